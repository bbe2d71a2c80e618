//! A journal's files are removed, replaced, cut or linked while it is in use, or belong to somebody else.

use std::fs;
use std::os::unix::fs::{chown, symlink};
use std::path::Path;

use contract::Decision;
use hopper_sim::journal::{Displacement, FILE_NAME};
use hopper_sim::private_file::FileError;
use hopper_sim::{Journal, JournalError};
use tempfile::tempdir;

use crate::fixture::{header, mission, undisturbed};
use crate::journal::Written;

/// P-LOCK-FILE: The lock is on the file of the records: removing the directory's lock file lets no
/// second writer in, and a refused process creates no file.
#[test]
fn removing_the_lock_file_lets_no_second_writer_in() {
    let written = Written::of(undisturbed()[..3].to_vec());
    let held = Journal::open(written.path(), false).unwrap();
    let lock = written.path().join("lock");
    fs::remove_file(&lock).unwrap();
    let error = Journal::open(written.path(), false).unwrap_err();
    assert!(matches!(&error, JournalError::Locked { pid: Some(pid), .. } if *pid == std::process::id()));
    assert!(!lock.exists(), "who is refused makes no file");
    drop(held);
    Journal::open(written.path(), false).unwrap();
}

#[test]
fn a_journal_is_locked_from_its_creation_on() {
    let dir = tempdir().unwrap();
    let _held = Journal::create(dir.path(), &header(&mission()), false).unwrap();
    fs::remove_file(dir.path().join("lock")).unwrap();
    let error = Journal::open(dir.path(), false).unwrap_err();
    assert!(matches!(error, JournalError::Locked { .. }), "{error}");
}

type Displace = fn(&Path, &Path);
type Expect = fn(&Displacement) -> bool;

/// P-DISPLACED: Before each append the journal is looked up at its path. If it was deleted, moved,
/// replaced, cut or written to by another process, nothing is appended until the same file is back,
/// and the error says what happened to it.
#[test]
fn nothing_is_appended_to_a_journal_that_is_no_longer_at_its_path() {
    let all = undisturbed();
    let displace: [(Displace, Expect); 5] = [
        (|path, aside| fs::rename(path, aside).unwrap(), |got| *got == Displacement::Gone),
        (
            |path, aside| {
                fs::rename(path, aside).unwrap();
                fs::copy(aside, path).unwrap();
            },
            |got| *got == Displacement::Replaced,
        ),
        (
            |path, aside| {
                fs::rename(path, aside).unwrap();
                symlink(aside, path).unwrap();
            },
            |got| *got == Displacement::Replaced,
        ),
        (
            |path, aside| {
                fs::copy(path, aside).unwrap();
                fs::OpenOptions::new().write(true).open(path).unwrap().set_len(100).unwrap();
            },
            |got| matches!(got, Displacement::Resized { got: 100, .. }),
        ),
        (
            |path, aside| {
                fs::copy(path, aside).unwrap();
                let bytes = fs::read(path).unwrap();
                fs::write(path, [&bytes[..], b"a record of somebody else"].concat()).unwrap();
            },
            |got| matches!(got, Displacement::Resized { need, got } if got > need),
        ),
    ];
    for (case, (displace, is_told)) in displace.into_iter().enumerate() {
        let written = Written::of(all[..3].to_vec());
        let mut journal = Journal::open(written.path(), false).unwrap();
        let (path, aside) = (written.path().join(FILE_NAME), written.path().join("aside"));
        journal.append(&all[3], None).unwrap();
        let intact = fs::read(&path).unwrap();
        displace(&path, &aside);
        let displaced = fs::read(&path).ok();
        for _ in 0..2 {
            let error = journal.append(&all[4], None).unwrap_err();
            let JournalError::Displaced { displacement, .. } = &error else { panic!("{error}") };
            assert!(is_told(displacement), "case {case}: {error}");
            assert!(error.to_string().starts_with(path.to_str().unwrap()), "{error}");
            assert!(matches!(journal.check(), Err(JournalError::Displaced { .. })));
            assert_eq!(fs::read(&path).ok(), displaced, "case {case}");
        }
        // The very file, as it was, is gone on with.
        if case < 3 {
            let _ = fs::remove_file(&path);
            fs::rename(&aside, &path).unwrap();
        } else {
            fs::write(&path, &intact).unwrap();
        }
        journal.append(&all[4], None).unwrap();
        drop(journal);
        assert_eq!(Journal::open(written.path(), false).unwrap().len(), 5, "case {case}");
    }
}

/// P-PAST-LOST. The records were changed in place, so path and length are unchanged.
#[test]
fn no_page_is_served_of_records_that_were_not_appended() {
    let written = Written::new();
    let journal = Journal::open(written.path(), false).unwrap();
    let (bytes, ends) = (written.bytes(), [3, 4, 5].map(|decision| written.ends[decision] as usize));
    let swapped = [&bytes[..ends[0]], &bytes[ends[1]..ends[2]], &bytes[ends[0]..ends[1]], &bytes[ends[2]..]];
    written.overwrite(&swapped.concat());
    journal.check().expect("path and length are the same");
    let error = journal.page(Decision(0)).unwrap_err();
    assert!(matches!(error, JournalError::OutOfOrder { need: Decision(3), got: Decision(4) }), "{error}");
    written.overwrite(&bytes);
    assert_eq!(journal.page(Decision(0)).unwrap().records, written.records);
}

/// P-NO-LINK: A symbolic link in place of a file to write is refused, and its target is left as it
/// was.
#[test]
fn no_symbolic_link_is_followed() {
    let target = tempdir().unwrap();
    let precious = target.path().join("precious");
    fs::write(&precious, "theirs").unwrap();
    for name in [FILE_NAME, "hops.journal.new", "lock"] {
        let dir = tempdir().unwrap();
        symlink(&precious, dir.path().join(name)).unwrap();
        let opened = match name {
            FILE_NAME => Journal::open(dir.path(), false),
            _ => Journal::create(dir.path(), &header(&mission()), false),
        };
        let error = opened.unwrap_err();
        assert!(matches!(&error, JournalError::File(FileError::SymbolicLink { .. })), "{name}: {error}");
        let path = dir.path().join(name);
        assert!(error.to_string().starts_with(path.to_str().unwrap()), "{error}");
        assert_eq!(fs::read_to_string(&precious).unwrap(), "theirs", "{name}");
    }
    let written = Written::new();
    let lock = written.path().join("lock");
    fs::remove_file(&lock).unwrap();
    symlink(&precious, &lock).unwrap();
    assert!(Journal::open(written.path(), false).is_err());
    assert_eq!(fs::read_to_string(&precious).unwrap(), "theirs");
}

/// P-FOREIGN-OWNER: A journal or an output directory of another user is refused, and the error
/// names its path and its owner.
#[test]
fn a_journal_of_another_user_is_refused_with_its_owner_named() {
    if !rustix::process::geteuid().is_root() {
        eprintln!("SKIPPED: files of another user: only root can make them");
        return;
    }
    let give = |path: &Path| chown(path, Some(65534), Some(65534)).unwrap();
    let written = Written::new();
    for name in ["", FILE_NAME, "lock"] {
        let path = if name.is_empty() { written.path().into() } else { written.path().join(name) };
        give(&path);
        let error = Journal::open(written.path(), false).unwrap_err();
        assert!(matches!(&error, JournalError::File(FileError::ForeignOwner { got: 65534, .. })), "{error}");
        let told = format!("{} belongs to user 65534, and this process is user 0", path.display());
        assert!(error.to_string().starts_with(&told), "{error}");
        chown(&path, Some(0), Some(0)).unwrap();
    }
    let folder = tempdir().unwrap();
    give(folder.path());
    let error = Journal::create(folder.path(), &header(&mission()), false).unwrap_err();
    assert!(matches!(&error, JournalError::File(FileError::ForeignOwner { .. })), "{error}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}
