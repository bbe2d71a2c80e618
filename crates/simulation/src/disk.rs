//! A disk that fails on demand: under the real journal, codec and all.

use std::cell::RefCell;
use std::io::{self, ErrorKind};
use std::path::Path;
use std::rc::Rc;

use hopper_sim::{Located, Storage};

use crate::fault::Place;

/// One file, which outlives the processes that write it.
#[derive(Clone, Debug, Default)]
pub struct Disk(Rc<RefCell<Platter>>);

#[derive(Debug, Default)]
struct Platter {
    bytes: Vec<u8>,
    /// What the disk holds for certain, whatever was written or cut since.
    durable: Vec<u8>,
    /// Bytes from the start in which the two are the same.
    same: usize,
    /// Bytes that may still be written, if the disk is full.
    room: Option<usize>,
    /// Whether a full disk cannot even be cut.
    stubborn: bool,
    /// How much of the next write is done when its process dies, in thousandths.
    tear: Option<u64>,
    /// Whether a process died writing: it does nothing more.
    torn: bool,
    /// What is said of the journal's path, if it is not the truth.
    place: Option<Place>,
    /// Bytes held when it was asked for that last.
    located_bytes: usize,
    /// Whether something was written meanwhile.
    misplaced_write: bool,
    /// The last write that went through, until it is taken.
    write: Option<Vec<u8>>,
}

impl Disk {
    /// Whether nothing was ever written.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.borrow().bytes.is_empty()
    }

    /// Whether it is full.
    #[must_use]
    pub fn is_full(&self) -> bool {
        self.0.borrow().room.is_some()
    }

    /// The journal's file is gone from its folder, as after `rm`; who has it open keeps it.
    pub fn erase(&self) {
        let mut platter = self.0.borrow_mut();
        platter.bytes.clear();
        platter.durable.clear();
        platter.same = 0;
    }

    /// Holds what `other` holds, durably: a backup is restored.
    pub(crate) fn restore(&self, other: &Disk) {
        let bytes = other.0.borrow().bytes.clone();
        let mut platter = self.0.borrow_mut();
        platter.same = bytes.len();
        platter.durable = bytes.clone();
        platter.bytes = bytes;
    }

    /// Fills up: `room` more bytes can be written; if `stubborn`, none can be cut off either.
    pub fn fill(&self, room: u64, stubborn: bool) {
        let mut platter = self.0.borrow_mut();
        (platter.room, platter.stubborn) = (Some(room as usize), stubborn);
    }

    /// There is room again.
    pub fn free(&self) {
        let mut platter = self.0.borrow_mut();
        (platter.room, platter.stubborn) = (None, false);
    }

    /// Says from now on that the journal lies at `place`; `None` for the truth.
    pub(crate) fn misplace(&self, place: Option<Place>) {
        self.0.borrow_mut().place = place;
    }

    /// Whether it says so.
    pub(crate) fn is_misplaced(&self) -> bool {
        self.0.borrow().place.is_some()
    }

    /// Whether something was written while the journal was misplaced, since this was asked last.
    pub(crate) fn take_misplaced_write(&self) -> bool {
        std::mem::take(&mut self.0.borrow_mut().misplaced_write)
    }

    /// The process that writes next dies in its midst, `thousandths` of the bytes written.
    pub fn tear_next_write(&self, thousandths: u64) {
        self.0.borrow_mut().tear = Some(thousandths);
    }

    /// The last write that went through whole, once.
    pub(crate) fn take_write(&self) -> Option<Vec<u8>> {
        self.0.borrow_mut().write.take()
    }

    /// Whether a process has died writing since this was asked last.
    pub fn take_torn(&self) -> bool {
        std::mem::take(&mut self.0.borrow_mut().torn)
    }

    /// The power goes: of what was not yet durable, `thousandths` survive. What was cut and not synced is there again, unless
    /// the number is odd: a file system may write its tables before or after.
    pub fn lose_power(&self, thousandths: u64) {
        let mut platter = self.0.borrow_mut();
        let loose = platter.bytes.len() - platter.same;
        let kept = platter.same + loose * thousandths as usize / 1000;
        platter.bytes.truncate(kept);
        if thousandths.is_multiple_of(2)
            && let Some(cut) = platter.durable.get(kept..).map(<[u8]>::to_vec)
        {
            platter.bytes.extend(cut);
        }
        platter.sync();
    }
}

impl Platter {
    fn sync(&mut self) {
        let Self { bytes, durable, same, .. } = self;
        durable.truncate(*same);
        durable.extend_from_slice(&bytes[*same..]);
        *same = bytes.len();
    }
}

impl Storage for Disk {
    fn bytes(&self) -> io::Result<u64> {
        Ok(self.0.borrow().bytes.len() as u64)
    }

    fn read_exact_at(&self, buffer: &mut [u8], offset: u64) -> io::Result<()> {
        let platter = self.0.borrow();
        let held = platter.bytes.get(offset as usize..).and_then(|bytes| bytes.get(..buffer.len()));
        buffer.copy_from_slice(held.ok_or(ErrorKind::UnexpectedEof)?);
        Ok(())
    }

    fn write_all_at(&self, bytes: &[u8], offset: u64) -> io::Result<()> {
        let mut platter = self.0.borrow_mut();
        if platter.torn {
            return Err(ErrorKind::BrokenPipe.into());
        }
        let offset = offset as usize;
        // A header begins a journal that had no place before. With a torn tail that is still to be cut, a length is no surprise.
        let has_odd_length = |place| matches!(place, Place::Longer | Place::Shorter);
        let is_expected = |place| offset == 0 || has_odd_length(place) && platter.located_bytes > offset;
        platter.misplaced_write |= platter.place.is_some_and(|place| !is_expected(place));
        let tear = platter.tear.take().map(|thousandths| bytes.len() * thousandths as usize / 1000);
        let written = bytes.len().min(platter.room.unwrap_or(usize::MAX)).min(tear.unwrap_or(usize::MAX));
        let end = offset + written;
        if platter.bytes.len() < end {
            platter.bytes.resize(end, 0);
        }
        platter.bytes[offset..end].copy_from_slice(&bytes[..written]);
        platter.same = platter.same.min(offset);
        if let Some(room) = &mut platter.room {
            *room -= written;
        }
        if tear.is_some() {
            platter.torn = true;
            return Err(ErrorKind::BrokenPipe.into());
        }
        if written < bytes.len() {
            return Err(ErrorKind::StorageFull.into());
        }
        platter.write = Some(bytes.to_vec());
        Ok(())
    }

    fn cut(&self, bytes: u64) -> io::Result<()> {
        let mut platter = self.0.borrow_mut();
        if platter.torn {
            return Err(ErrorKind::BrokenPipe.into());
        }
        if platter.stubborn {
            return Err(ErrorKind::StorageFull.into());
        }
        platter.bytes.truncate(bytes as usize);
        platter.same = platter.same.min(bytes as usize);
        Ok(())
    }

    fn locate(&self, _path: &Path) -> io::Result<Located> {
        let mut platter = self.0.borrow_mut();
        platter.located_bytes = platter.bytes.len();
        let bytes = platter.bytes.len() as u64;
        Ok(match platter.place {
            None => Located::Here { bytes },
            Some(Place::Nowhere) => Located::Nowhere,
            Some(Place::Elsewhere) => Located::Elsewhere,
            Some(Place::Longer) => Located::Here { bytes: bytes + 1 },
            Some(Place::Shorter) => Located::Here { bytes: bytes.saturating_sub(1) },
        })
    }

    fn sync(&self) -> io::Result<()> {
        self.0.borrow_mut().sync();
        Ok(())
    }
}
