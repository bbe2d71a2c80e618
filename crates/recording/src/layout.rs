//! Parses the records of an MCAP file (<https://mcap.dev/spec>) as untrusted input.
//!
//! The `mcap` crate is used for writing only: its reader panics on some damaged records.

use std::borrow::Cow;
use std::collections::BTreeMap;

use crate::compression::decompressed;

/// First and last bytes of every MCAP file.
pub(crate) const MAGIC: &[u8] = mcap::MAGIC;

/// Opcodes of the records that are parsed.
pub(crate) mod kind {
    pub const HEADER: u8 = 0x01;
    pub const FOOTER: u8 = 0x02;
    pub const SCHEMA: u8 = 0x03;
    pub const CHANNEL: u8 = 0x04;
    pub const MESSAGE: u8 = 0x05;
    pub const CHUNK: u8 = 0x06;
    pub const MESSAGE_INDEX: u8 = 0x07;
    pub const ATTACHMENT: u8 = 0x09;
    pub const METADATA: u8 = 0x0c;
    pub const DATA_END: u8 = 0x0f;
    /// Largest opcode of the specification. Larger ones are of later versions and, from 0x80 on, of other programs.
    pub const KNOWN_MAX: u8 = DATA_END;
}

/// A record with its position.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Framed<'a> {
    pub kind: u8,
    pub body: &'a [u8],
    /// Offset of the next record, bytes.
    pub end: usize,
}

/// The record that begins at byte `at`, or what is wrong with it.
pub(crate) fn framed(bytes: &[u8], at: usize) -> Result<Framed<'_>, String> {
    let cut = || format!("cut in the middle of the record at byte {at}");
    let mut cursor = Cursor(bytes.get(at..).unwrap_or_default());
    let kind = cursor.take(1).ok_or_else(cut)?[0];
    let length = cursor.u64().ok_or_else(cut)?;
    let body = usize::try_from(length).ok().and_then(|length| cursor.take(length)).ok_or_else(cut)?;
    Ok(Framed { kind, body, end: at + 9 + body.len() })
}

/// The records of a chunk after checking its length and checksum; those of a compressed chunk take at most `budget`
/// bytes.
pub(crate) fn chunk(body: &[u8], budget: u64) -> Result<Cow<'_, [u8]>, String> {
    let mut cursor = Cursor(body);
    let header = cursor.take(16).and_then(|_| Some((cursor.u64()?, cursor.u32()?)));
    let (size, need) = header.ok_or("a chunk without a header")?;
    let compression = cursor.text().ok_or("a chunk without a header")?;
    let length = cursor.u64().ok_or("a chunk without a header")?;
    let stored = usize::try_from(length).ok().and_then(|length| cursor.take(length));
    let stored = stored.ok_or("a chunk whose length differs from its header")?;
    let records = match compression.as_str() {
        "" => Cow::Borrowed(stored),
        other => Cow::Owned(decompressed(other, stored, size, budget)?),
    };
    if records.len() as u64 != size {
        return Err("a chunk whose length differs from its header".into());
    }
    let got = crc32fast::hash(&records);
    if need != 0 && need != got {
        return Err(format!("a chunk with checksum {got:08x}, need {need:08x}"));
    }
    Ok(records)
}

/// Whether this has the form of a chunk; its checksum is not looked at.
pub(crate) fn is_chunk(body: &[u8]) -> bool {
    let mut cursor = Cursor(body);
    let header = cursor.take(28).and_then(|_| Some((cursor.text()?, cursor.u64()?)));
    header.is_some_and(|(compression, length)| {
        ["", "zstd", "lz4"].contains(&compression.as_str()) && length == cursor.0.len() as u64
    })
}

/// Whether this is a well-formed index of one channel's messages in the chunk before.
pub(crate) fn is_message_index(body: &[u8]) -> bool {
    let mut cursor = Cursor(body);
    let length = cursor.take(2).and_then(|_| cursor.u32());
    length.is_some_and(|length| length as usize == cursor.0.len() && length % 16 == 0)
}

/// Id, name, encoding and data of a schema.
pub(crate) fn schema(body: &[u8]) -> Option<(u16, String, String, &[u8])> {
    let mut cursor = Cursor(body);
    let (id, name, encoding) = (cursor.u16()?, cursor.text()?, cursor.text()?);
    let length = cursor.u32()?;
    Some((id, name, encoding, cursor.take(length as usize)?))
}

/// Id, schema id, topic, message encoding and metadata of a channel.
type Channel = (u16, u16, String, String, BTreeMap<String, String>);

pub(crate) fn channel(body: &[u8]) -> Option<Channel> {
    let mut cursor = Cursor(body);
    Some((cursor.u16()?, cursor.u16()?, cursor.text()?, cursor.text()?, cursor.map()?))
}

/// Channel id, sequence number, log time, publish time (both nanoseconds) and data of a message.
pub(crate) fn message(body: &[u8]) -> Option<(u16, u32, u64, u64, &[u8])> {
    let mut cursor = Cursor(body);
    Some((cursor.u16()?, cursor.u32()?, cursor.u64()?, cursor.u64()?, cursor.0))
}

/// Name and entries of a metadata record.
pub(crate) fn metadata(body: &[u8]) -> Option<(String, BTreeMap<String, String>)> {
    let mut cursor = Cursor(body);
    Some((cursor.text()?, cursor.map()?))
}

/// The profile in a header record.
pub(crate) fn profile(body: &[u8]) -> Option<String> {
    Cursor(body).text()
}

/// The CRC-32 of the data section in a data end record; 0 if none was computed.
pub(crate) fn data_end(body: &[u8]) -> Option<u32> {
    Cursor(body).u32()
}

/// The records between data and footer, if the file ends with a footer and they have the right checksum, or none.
pub(crate) fn summary(bytes: &[u8]) -> Option<&[u8]> {
    const FOOTER_BYTES: usize = 9 + 20;
    let footer_at = bytes.strip_suffix(MAGIC)?.len().checked_sub(FOOTER_BYTES)?;
    let footer = framed(bytes, footer_at).ok()?;
    let mut cursor = Cursor(footer.body);
    let (start, _, need) = (cursor.u64()?, cursor.u64()?, cursor.u32()?);
    if footer.kind != kind::FOOTER || start == 0 {
        return None;
    }
    let start = usize::try_from(start).ok()?;
    let summary = bytes.get(start..footer_at)?;
    // The checksum covers the footer up to itself.
    let got = crc32fast::hash(&bytes[start..footer_at + FOOTER_BYTES - 4]);
    if need == 0 || need == got { Some(summary) } else { None }
}

/// What bytes are that do not begin like an MCAP file, for an error.
pub(crate) fn other_format(bytes: &[u8]) -> String {
    let packed: [(&[u8], &str); 6] = [
        (b"\x1f\x8b", "gzip"),
        (b"\x28\xb5\x2f\xfd", "zstd"),
        (b"\x04\x22\x4d\x18", "lz4"),
        (b"BZh", "bzip2"),
        (b"\xfd7zXZ\0", "xz"),
        (b"PK\x03\x04", "zip"),
    ];
    if bytes.is_empty() {
        return "an empty file".into();
    }
    if let Some((_, name)) = packed.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        return format!("a file compressed by {name}: decompress it first");
    }
    if bytes.starts_with(b"#ROSBAG") {
        return "a bag of ROS 1: convert it to MCAP first".into();
    }
    format!("{:02x?} of {} bytes", &bytes[..bytes.len().min(MAGIC.len())], bytes.len())
}

/// The bytes not yet parsed.
struct Cursor<'a>(&'a [u8]);

impl<'a> Cursor<'a> {
    fn take(&mut self, length: usize) -> Option<&'a [u8]> {
        let (taken, left) = self.0.split_at_checked(length)?;
        self.0 = left;
        Some(taken)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.take(N)?.try_into().ok()
    }

    fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    fn text(&mut self) -> Option<String> {
        let length = self.u32()?;
        let bytes = self.take(length as usize)?;
        std::str::from_utf8(bytes).ok().map(str::to_owned)
    }
    fn map(&mut self) -> Option<BTreeMap<String, String>> {
        let length = self.u32()?;
        let mut entries = Cursor(self.take(length as usize)?);
        let mut map = BTreeMap::new();
        while !entries.0.is_empty() {
            map.insert(entries.text()?, entries.text()?);
        }
        Some(map)
    }
}
