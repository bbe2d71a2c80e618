//! Journals: bytes to the records before the first that is not whole, or one error.

use std::path::PathBuf;

use hopper_sim::{Journal, JournalHeader, JournalReader, Verification};

use crate::disk::Disk;
use crate::{fixtures, told};

/// Reads, verifies, then goes on with it: all three tell of the same records.
pub fn read(bytes: &[u8]) {
    let path = || PathBuf::from("hostile");
    let disk = Disk::of(bytes);
    let history = match JournalReader::on(&disk, path()) {
        Ok(history) => history,
        Err(error) => return told(&error),
    };
    let mut records = history.records();
    let mut read = Vec::new();
    let whole = loop {
        match records.next() {
            None => break true,
            Some(Ok(record)) => read.push(record),
            Some(Err(error)) => {
                told(&error);
                break false;
            }
        }
    };
    let torn_bytes = records.torn_bytes();
    match Verification::of(&history) {
        Ok(verification) => {
            assert!(whole && verification.torn_bytes == torn_bytes);
            assert_eq!(verification.decisions + verification.duplicates, read.len() as u64);
            told(&verification);
        }
        Err(error) => {
            assert!(!whole, "{error}");
            told(&error);
        }
    }
    let world = fixtures::world();
    let expected = JournalHeader::new(world, fixtures::mission().seed);
    match Journal::resume_on(&disk, &expected, &world.terrain, true) {
        Err(error) => {
            assert_eq!(disk.into_bytes(), bytes, "what cannot be gone on with is left as it is");
            told(&error);
        }
        Ok(journal) => {
            assert!(whole, "a journal with a broken frame is not gone on with");
            assert_eq!((journal.len(), journal.torn_bytes()), (read.len() as u64, torn_bytes));
            let again: Vec<_> = journal.records().map(|record| record.expect("it was read before")).collect();
            assert_eq!(again, read);
            let kept = bytes.len() - torn_bytes as usize;
            assert_eq!(disk.into_bytes(), bytes[..kept], "the torn tail is cut, and nothing else");
        }
    }
}

/// A journal of the fixtures' mission.
#[must_use]
pub fn seeds() -> Vec<Vec<u8>> {
    let disk = Disk::default();
    let header = JournalHeader::new(fixtures::world(), fixtures::mission().seed).with_run(fixtures::RUN);
    let mut journal = Journal::create_on(&disk, &header, false).expect("a disk in memory takes it");
    for record in fixtures::flown().0 {
        journal.append(&record, None).expect("the records of a mission follow one another");
    }
    vec![disk.into_bytes()]
}
