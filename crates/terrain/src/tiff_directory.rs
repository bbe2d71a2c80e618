//! Reads the directories of a TIFF file: tags with their values (TIFF 6.0, section 2; BigTIFF).
//!
//! No tag can make it allocate more memory than the file fills.

use std::collections::BTreeMap;
use std::io::{ErrorKind, Read, Seek, SeekFrom};

use crate::TerrainError;

/// Longest value that is read, bytes: the offsets of two million strips.
const VALUE_BYTES_MAX: u64 = 1 << 24;

/// Most tags of a directory; real ones have some twenty.
const TAGS_MAX: u64 = 4096;

pub(crate) struct Directory {
    /// Byte order and width of offsets.
    pub order: Order,
    entries: BTreeMap<u16, Entry>,
    /// Offset of the next directory in the file; 0 for none.
    next: u64,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Order {
    pub big_endian: bool,
    big_tiff: bool,
}

#[derive(Clone, Copy)]
struct Entry {
    kind: u16,
    count: u64,
    /// The value itself, or its offset in the file.
    field: [u8; 8],
}

impl Directory {
    /// Reads the first directory of the file.
    pub fn read(reader: &mut (impl Read + Seek)) -> Result<Self, TerrainError> {
        let mut start = [0; 8];
        fill(reader, &mut start, "the header of a TIFF")?;
        let mut order = Order { big_endian: start[0] == b'M', big_tiff: false };
        order.big_tiff = order.unsigned(&start[2..4]) == 43;
        let offset = if order.big_tiff {
            let mut offset = [0; 8];
            fill(reader, &mut offset, "the header of a BigTIFF")?;
            order.unsigned(&offset)
        } else {
            order.unsigned(&start[4..8])
        };
        Self::at(reader, order, offset)
    }

    /// The directory that follows this one in the file, if there is one.
    pub fn following(&self, reader: &mut (impl Read + Seek)) -> Result<Option<Self>, TerrainError> {
        if self.next == 0 { Ok(None) } else { Self::at(reader, self.order, self.next).map(Some) }
    }

    fn at(reader: &mut (impl Read + Seek), order: Order, offset: u64) -> Result<Self, TerrainError> {
        reader.seek(SeekFrom::Start(offset))?;
        let mut count = [0; 8];
        let count = &mut count[..if order.big_tiff { 8 } else { 2 }];
        fill(reader, count, "the directory of a TIFF")?;
        let count = order.unsigned(count);
        if count > TAGS_MAX {
            return Err(TerrainError::Malformed {
                what: "number of TIFF tags",
                need: format!("at most {TAGS_MAX}"),
                got: count.to_string(),
            });
        }
        let mut entries = BTreeMap::new();
        for _ in 0..count {
            let (tag, entry) = Entry::read(reader, order)?;
            entries.insert(tag, entry);
        }
        let mut next = [0; 8];
        let next = &mut next[..if order.big_tiff { 8 } else { 4 }];
        // A file may end with its last entry.
        let next = match reader.read_exact(next) {
            Ok(()) => order.unsigned(next),
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => 0,
            Err(error) => return Err(error.into()),
        };
        Ok(Self { order, entries, next })
    }

    pub fn has(&self, tag: u16) -> bool {
        self.entries.contains_key(&tag)
    }

    /// The unsigned integers of `tag`.
    pub fn unsigned(
        &self,
        reader: &mut (impl Read + Seek),
        tag: u16,
        what: &'static str,
    ) -> Result<Option<Vec<u64>>, TerrainError> {
        let Some((entry, bytes)) = self.bytes(reader, tag, what)? else { return Ok(None) };
        match entry.kind {
            1 | 3 | 4 | 16 => {
                Ok(Some(bytes.chunks_exact(entry.size()).map(|value| self.order.unsigned(value)).collect()))
            }
            kind => Err(wrong_kind(what, "unsigned integers", kind)),
        }
    }

    /// The single unsigned integer of `tag`.
    pub fn single(
        &self,
        reader: &mut (impl Read + Seek),
        tag: u16,
        what: &'static str,
    ) -> Result<Option<u64>, TerrainError> {
        match self.unsigned(reader, tag, what)?.as_deref() {
            None => Ok(None),
            Some([value, ..]) => Ok(Some(*value)),
            Some([]) => Err(TerrainError::Malformed { what, need: "a value".into(), got: "none".into() }),
        }
    }

    /// The floating-point numbers of `tag`.
    pub fn doubles(
        &self,
        reader: &mut (impl Read + Seek),
        tag: u16,
        what: &'static str,
    ) -> Result<Option<Vec<f64>>, TerrainError> {
        let Some((entry, bytes)) = self.bytes(reader, tag, what)? else { return Ok(None) };
        match entry.kind {
            12 => Ok(Some(
                bytes.chunks_exact(8).map(|value| f64::from_bits(self.order.unsigned(value))).collect(),
            )),
            kind => Err(wrong_kind(what, "double-precision numbers", kind)),
        }
    }

    /// The text of `tag`, up to its first zero.
    pub fn text(
        &self,
        reader: &mut (impl Read + Seek),
        tag: u16,
        what: &'static str,
    ) -> Result<Option<String>, TerrainError> {
        let Some((entry, bytes)) = self.bytes(reader, tag, what)? else { return Ok(None) };
        match entry.kind {
            2 => {
                let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
                Ok(Some(String::from_utf8_lossy(&bytes[..end]).trim().to_string()))
            }
            kind => Err(wrong_kind(what, "text", kind)),
        }
    }

    fn bytes(
        &self,
        reader: &mut (impl Read + Seek),
        tag: u16,
        what: &'static str,
    ) -> Result<Option<(Entry, Vec<u8>)>, TerrainError> {
        let Some(&entry) = self.entries.get(&tag) else { return Ok(None) };
        let length = entry.count.saturating_mul(entry.size() as u64);
        if length > VALUE_BYTES_MAX {
            return Err(TerrainError::Malformed {
                what,
                need: format!("at most {VALUE_BYTES_MAX} bytes"),
                got: length.to_string(),
            });
        }
        let inline = if self.order.big_tiff { 8 } else { 4 };
        if length <= inline {
            return Ok(Some((entry, entry.field[..length as usize].to_vec())));
        }
        reader.seek(SeekFrom::Start(self.order.unsigned(&entry.field[..inline as usize])))?;
        let mut bytes = Vec::new();
        reader.take(length).read_to_end(&mut bytes)?;
        if (bytes.len() as u64) < length {
            return Err(TerrainError::Truncated { need: format!("{length} bytes of {what}") });
        }
        Ok(Some((entry, bytes)))
    }
}

impl Entry {
    fn read(reader: &mut impl Read, order: Order) -> Result<(u16, Self), TerrainError> {
        let mut bytes = [0; 20];
        let (width, bytes) = if order.big_tiff { (8, &mut bytes[..20]) } else { (4, &mut bytes[..12]) };
        fill(reader, bytes, "the directory of a TIFF")?;
        let kind = order.unsigned(&bytes[2..4]) as u16;
        if !matches!(kind, 1..=13 | 16..=18) {
            return Err(TerrainError::Malformed {
                what: "type of a TIFF tag",
                need: "1 to 13 or 16 to 18".into(),
                got: kind.to_string(),
            });
        }
        let mut field = [0; 8];
        field[..width].copy_from_slice(&bytes[4 + width..]);
        Ok((
            order.unsigned(&bytes[..2]) as u16,
            Self { kind, count: order.unsigned(&bytes[4..4 + width]), field },
        ))
    }

    /// Bytes of one value.
    fn size(&self) -> usize {
        match self.kind {
            3 | 8 => 2,
            4 | 9 | 11 | 13 => 4,
            5 | 10 | 12 | 16 | 17 | 18 => 8,
            _ => 1,
        }
    }
}

impl Order {
    /// The unsigned integer that `bytes` hold, at most eight of them.
    pub fn unsigned(self, bytes: &[u8]) -> u64 {
        let join = |value: u64, byte: &u8| value << 8 | u64::from(*byte);
        if self.big_endian { bytes.iter().fold(0, join) } else { bytes.iter().rev().fold(0, join) }
    }
}

fn fill(reader: &mut impl Read, bytes: &mut [u8], need: &str) -> Result<(), TerrainError> {
    reader.read_exact(bytes).map_err(|error| match error.kind() {
        ErrorKind::UnexpectedEof => TerrainError::Truncated { need: need.into() },
        _ => error.into(),
    })
}

fn wrong_kind(what: &'static str, need: &str, kind: u16) -> TerrainError {
    TerrainError::Malformed { what, need: need.into(), got: format!("TIFF type {kind}") }
}
