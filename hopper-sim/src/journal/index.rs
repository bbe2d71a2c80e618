//! Where records lie in the file: every one of a short journal, every so many of a long one.

/// Most offsets kept: 128 kB, however long the journal.
const MARKS_MAX: usize = 1 << 14;

/// Offsets of frames. Once there are [`MARKS_MAX`], every second one is dropped.
#[derive(Clone, Debug)]
pub(super) struct Index {
    /// Byte at which the frame of every `stride`-th record begins.
    marks: Vec<u64>,
    stride: u64,
    len: u64,
}

impl Default for Index {
    fn default() -> Self {
        Self { marks: Vec::new(), stride: 1, len: 0 }
    }
}

impl Index {
    /// The next record begins at byte `offset`.
    pub fn push(&mut self, offset: u64) {
        if self.len.is_multiple_of(self.stride) {
            if self.marks.len() == MARKS_MAX {
                let mut number = 0;
                self.marks.retain(|_| {
                    number += 1;
                    number % 2 == 1
                });
                self.stride *= 2;
            }
            if self.len.is_multiple_of(self.stride) {
                self.marks.push(offset);
            }
        }
        self.len += 1;
    }

    /// Records so far.
    pub fn len(&self) -> u64 {
        self.len
    }

    /// The record at or before `record` whose offset is known, with that offset; `None` if there is none
    /// such.
    pub fn before(&self, record: u64) -> Option<(u64, u64)> {
        if record >= self.len {
            return None;
        }
        let mark = record / self.stride;
        let offset = self.marks.get(usize::try_from(mark).ok()?)?;
        Some((mark * self.stride, *offset))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// P-JOURNAL-INDEX: The memory that a journal takes does not grow with its length.
    #[test]
    fn every_record_is_found_from_a_mark_not_far_before_it_in_bounded_memory() {
        let mut index = Index::default();
        assert_eq!(index.before(0), None);
        for record in 0..200_000_u64 {
            index.push(10 * record);
            assert!(index.marks.len() <= MARKS_MAX);
        }
        assert_eq!(index.len(), 200_000);
        for record in (0..200_000).step_by(77).chain([199_999]) {
            let (found, offset) = index.before(record).unwrap();
            assert!(found <= record && record - found < 32, "{record} from {found}");
            assert_eq!(offset, 10 * found);
        }
        assert_eq!(index.before(200_000), None);
    }

    #[test]
    fn a_short_journal_has_the_offset_of_every_record() {
        let mut index = Index::default();
        (0..1_000).for_each(|record| index.push(3 * record));
        assert!((0..1_000).all(|record| index.before(record) == Some((record, 3 * record))));
    }
}
