//! What a journal under `--sync` keeps when the power fails: on a disk that loses whatever was not synced.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io::{self, ErrorKind};
use std::path::PathBuf;
use std::rc::Rc;

use hopper_sim::journal::{FILE_NAME, Folder, Lock};
use hopper_sim::{Journal, JournalError, JournalReader, Storage};

use crate::fixture::{header, mission, undisturbed};

/// What is there, and what a loss of power leaves of it.
#[derive(Clone, Debug, Default)]
struct Kept<T> {
    now: T,
    durable: T,
}

impl<T: Clone> Kept<T> {
    fn sync(&mut self) {
        self.durable = self.now.clone();
    }

    fn lose_power(&mut self) {
        self.now = self.durable.clone();
    }
}

/// A file that keeps only what was synced.
#[derive(Clone, Debug, Default)]
struct LossyFile(Rc<RefCell<Kept<Vec<u8>>>>);

impl Storage for LossyFile {
    fn bytes(&self) -> io::Result<u64> {
        Ok(self.0.borrow().now.len() as u64)
    }

    fn read_exact_at(&self, buffer: &mut [u8], offset: u64) -> io::Result<()> {
        let kept = self.0.borrow();
        let held = kept.now.get(offset as usize..).and_then(|bytes| bytes.get(..buffer.len()));
        buffer.copy_from_slice(held.ok_or(ErrorKind::UnexpectedEof)?);
        Ok(())
    }

    fn write_all_at(&self, bytes: &[u8], offset: u64) -> io::Result<()> {
        let mut kept = self.0.borrow_mut();
        let end = offset as usize + bytes.len();
        let length = kept.now.len().max(end);
        kept.now.resize(length, 0);
        kept.now[offset as usize..end].copy_from_slice(bytes);
        Ok(())
    }

    fn cut(&self, bytes: u64) -> io::Result<()> {
        self.0.borrow_mut().now.truncate(bytes as usize);
        Ok(())
    }

    fn sync(&self) -> io::Result<()> {
        self.0.borrow_mut().sync();
        Ok(())
    }
}

/// A folder that keeps only the names that were synced.
#[derive(Clone, Debug, Default)]
struct LossyFolder(Rc<RefCell<Kept<BTreeMap<String, LossyFile>>>>);

impl LossyFolder {
    fn lose_power(&self) {
        let mut kept = self.0.borrow_mut();
        kept.lose_power();
        kept.now.values().for_each(|file| file.0.borrow_mut().lose_power());
    }

    fn file(&self, name: &str) -> Option<LossyFile> {
        self.0.borrow().now.get(name).cloned()
    }
}

impl Folder for LossyFolder {
    type File = LossyFile;

    fn path(&self, name: &str) -> PathBuf {
        name.into()
    }

    fn holds(&self, name: &str) -> bool {
        self.file(name).is_some()
    }

    fn open(&self, name: &str, create: bool) -> Result<(LossyFile, Option<Lock>), JournalError> {
        assert!(create, "a journal is made");
        Ok((self.0.borrow_mut().now.entry(name.into()).or_default().clone(), None))
    }

    fn rename(&self, from: &str, to: &str) -> io::Result<()> {
        let mut kept = self.0.borrow_mut();
        let file = kept.now.remove(from).ok_or(ErrorKind::NotFound)?;
        kept.now.insert(to.into(), file);
        Ok(())
    }

    fn sync(&self) -> io::Result<()> {
        self.0.borrow_mut().sync();
        Ok(())
    }
}

/// Records that a reader finds in `file`.
fn records_in(file: LossyFile) -> u64 {
    let reader = JournalReader::on(file, FILE_NAME.into()).unwrap();
    assert_eq!(reader.header(), &header(&mission()));
    reader.records().map(Result::unwrap).count() as u64
}

/// P-SYNC: With `--sync`, a loss of power loses no record that a journal holds: its name, its
/// header, each record, and what an earlier process wrote without syncing are on the disk before
/// they count.
#[test]
fn a_new_journal_survives_a_loss_of_power_with_header_and_name() {
    let folder = LossyFolder::default();
    let mut journal = Journal::create_in(&folder, &header(&mission()), true).unwrap();
    folder.lose_power();
    assert_eq!(records_in(folder.file(FILE_NAME).expect("its name is kept")), 0);
    for (count, record) in (1..).zip(&undisturbed()[..3]) {
        journal.append(record, None).unwrap();
        folder.lose_power();
        assert_eq!(records_in(folder.file(FILE_NAME).unwrap()), count);
    }
    // Without the flag nothing was promised.
    let folder = LossyFolder::default();
    Journal::create_in(&folder, &header(&mission()), false).unwrap();
    folder.lose_power();
    assert!(!folder.holds(FILE_NAME));
}

/// At no moment does the name stand for half a header: the header is on the disk before the file has its name.
#[test]
fn a_journal_has_its_name_only_once_its_header_is_on_the_disk() {
    /// Loses the power once a file was renamed.
    struct Fails(LossyFolder);
    impl Folder for Fails {
        type File = LossyFile;
        fn path(&self, name: &str) -> PathBuf {
            self.0.path(name)
        }
        fn holds(&self, name: &str) -> bool {
            self.0.holds(name)
        }
        fn open(&self, name: &str, create: bool) -> Result<(LossyFile, Option<Lock>), JournalError> {
            self.0.open(name, create)
        }
        fn rename(&self, from: &str, to: &str) -> io::Result<()> {
            self.0.rename(from, to)?;
            // The disk may well have written the name by then.
            self.0.sync()?;
            self.0.lose_power();
            Err(ErrorKind::BrokenPipe.into())
        }
        fn sync(&self) -> io::Result<()> {
            self.0.sync()
        }
    }
    let folder = Fails(LossyFolder::default());
    Journal::create_in(&folder, &header(&mission()), true).unwrap_err();
    assert_eq!(records_in(folder.0.file(FILE_NAME).unwrap()), 0);
}

/// P-SYNC. Here the header is written into an existing file.
#[test]
fn a_header_written_into_a_file_survives_a_loss_of_power() {
    let file = LossyFile::default();
    Journal::create_on(file.clone(), &header(&mission()), true).unwrap();
    file.0.borrow_mut().lose_power();
    assert_eq!(records_in(file), 0);
}

/// P-SYNC. The next process publishes what an earlier one wrote without syncing, so it must sync it
/// first.
#[test]
fn what_an_earlier_life_wrote_survives_a_loss_of_power_once_it_is_reopened() {
    for torn in [&b""[..], b"torn"] {
        let file = LossyFile::default();
        let mut journal = Journal::create_on(file.clone(), &header(&mission()), false).unwrap();
        for record in &undisturbed()[..5] {
            journal.append(record, None).unwrap();
        }
        drop(journal);
        file.0.borrow_mut().now.extend(torn);
        let journal =
            Journal::resume_on(file.clone(), &header(&mission()), &mission().terrain, true).unwrap();
        assert_eq!((journal.len(), journal.torn_bytes()), (5, torn.len() as u64));
        let whole = file.bytes().unwrap();
        file.0.borrow_mut().lose_power();
        assert_eq!((file.bytes().unwrap(), records_in(file)), (whole, 5));
    }
}

/// P-SYNC. The power may fail between the cut of a torn tail and the next append, so that the tail
/// is back. However much of the tail was written, and whatever is appended over it, no record is
/// lost or changed.
#[test]
fn a_torn_tail_that_is_there_again_after_a_loss_of_power_is_cut_again() {
    let records = undisturbed();
    let bytes = |count: usize| {
        let file = LossyFile::default();
        let mut journal = Journal::create_on(file.clone(), &header(&mission()), true).unwrap();
        records[..count].iter().for_each(|record| journal.append(record, None).unwrap());
        let kept = file.0.borrow();
        kept.now.clone()
    };
    let (whole, longer) = (bytes(5), bytes(6));
    for torn in whole.len() + 1..longer.len() {
        for syncs in [true, false] {
            let file = LossyFile::default();
            file.0.borrow_mut().now = longer[..torn].to_vec();
            file.0.borrow_mut().sync();
            // It is cut twice: of the first cut nothing reached the disk.
            for _ in 0..2 {
                let journal =
                    Journal::resume_on(file.clone(), &header(&mission()), &mission().terrain, syncs).unwrap();
                assert_eq!((journal.len(), file.bytes().unwrap()), (5, whole.len() as u64));
                assert_eq!(journal.torn_bytes(), (torn - whole.len()) as u64);
                file.0.borrow_mut().now = longer[..torn].to_vec();
            }
            let mut journal =
                Journal::resume_on(file.clone(), &header(&mission()), &mission().terrain, syncs).unwrap();
            journal.append(&records[5], None).unwrap();
            drop(journal);
            if syncs {
                file.0.borrow_mut().lose_power();
            }
            assert_eq!(file.0.borrow().now, longer, "{torn} bytes");
            assert_eq!(records_in(file), 6);
        }
    }
}

/// P-SYNC. What a failed append left is cut before the next, though the first attempt to cut it
/// failed too.
#[test]
fn what_a_failed_append_left_is_cut_before_the_next_though_it_could_not_be_cut_at_once() {
    /// A file of which nothing can be cut off for a while, and into which only so much can be written.
    #[derive(Clone, Debug, Default)]
    struct Full {
        file: LossyFile,
        room: Rc<RefCell<Option<usize>>>,
    }

    impl Storage for Full {
        fn bytes(&self) -> io::Result<u64> {
            self.file.bytes()
        }

        fn read_exact_at(&self, buffer: &mut [u8], offset: u64) -> io::Result<()> {
            self.file.read_exact_at(buffer, offset)
        }

        fn write_all_at(&self, bytes: &[u8], offset: u64) -> io::Result<()> {
            match *self.room.borrow() {
                Some(room) if room < bytes.len() => {
                    self.file.write_all_at(&bytes[..room], offset)?;
                    Err(ErrorKind::StorageFull.into())
                }
                _ => self.file.write_all_at(bytes, offset),
            }
        }

        fn cut(&self, bytes: u64) -> io::Result<()> {
            match *self.room.borrow() {
                Some(_) => Err(ErrorKind::StorageFull.into()),
                None => self.file.cut(bytes),
            }
        }

        fn sync(&self) -> io::Result<()> {
            self.file.sync()
        }
    }

    let records = undisturbed();
    for (room, fails) in [(0, 1), (7, 1), (60, 2), (60, 5)] {
        let full = Full::default();
        let mut journal = Journal::create_on(full.clone(), &header(&mission()), true).unwrap();
        records[..3].iter().for_each(|record| journal.append(record, None).unwrap());
        *full.room.borrow_mut() = Some(room);
        for _ in 0..fails {
            journal.append(&records[3], None).unwrap_err();
        }
        *full.room.borrow_mut() = None;
        journal.append(&records[3], None).unwrap();
        full.file.0.borrow_mut().lose_power();
        assert_eq!(records_in(full.file.clone()), 4, "room for {room} bytes");
        drop(journal);
        let journal = Journal::resume_on(full, &header(&mission()), &mission().terrain, true).unwrap();
        assert_eq!((journal.len(), journal.torn_bytes()), (4, 0));
    }
}
