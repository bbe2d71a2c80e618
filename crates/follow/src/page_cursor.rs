//! Which page to ask for next, and when: the one rule by which readers catch up with what is served in pages.
//!
//! Truth, past and snapshot are served by request and response, and both may be lost. A reader asks for the first item
//! that it lacks, asks again after a pause if no page comes, and takes a page only if it begins there. What the items
//! are, and how they are folded, is the reader's business.

use contract::MonotonicNs;
use contract::limits::ASK_AGAIN_NS;

/// The place of a reader among numbered items that are served in pages.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub(crate) struct PageCursor {
    next: u64,
    asked: Option<MonotonicNs>,
}

impl PageCursor {
    /// Number of the first item that is still wanted, from 0.
    #[must_use]
    pub fn next(&self) -> u64 {
        self.next
    }

    /// Takes a page of the items from `first` up to, but not including, `end`. Returns false, and changes nothing, if it
    /// is not the page that is wanted: the answer to a request that was given up. The following page may be asked for
    /// at once.
    pub fn accept(&mut self, first: u64, end: u64) -> bool {
        let continues = first == self.next;
        if continues {
            *self = Self { next: end, asked: None };
        }
        continues
    }

    /// Moves to `next` where the reader folds item by item, from pages or otherwise. An item that was not asked for yet
    /// may be asked for at once.
    pub fn advance_to(&mut self, next: u64) {
        if next != self.next {
            *self = Self { next, asked: None };
        }
    }

    /// As [`PageCursor::advance_to`], but the pause since the last request stays in force.
    pub fn move_to(&mut self, next: u64) {
        self.next = next;
    }

    /// Begins again at item 0, one pause after `now`.
    pub fn restart(&mut self, now: MonotonicNs) {
        *self = Self { next: 0, asked: Some(now) };
    }

    /// The item to ask for at `now`; `None` for [`ASK_AGAIN_NS`] after each request.
    pub fn ask(&mut self, now: MonotonicNs) -> Option<u64> {
        self.ask_after(now, ASK_AGAIN_NS)
    }

    /// As [`PageCursor::ask`], with a pause of `pause_ns` nanoseconds.
    pub fn ask_after(&mut self, now: MonotonicNs, pause_ns: u64) -> Option<u64> {
        if self.asked.is_some_and(|asked| now.since_ns(asked) < pause_ns) {
            return None;
        }
        self.asked = Some(now);
        Some(self.next)
    }
}

/// What is served one by one, each as item 0 of a list of its own.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OneByOne<T> {
    asked: Option<T>,
    cursor: PageCursor,
}

impl<T> Default for OneByOne<T> {
    fn default() -> Self {
        Self { asked: None, cursor: PageCursor::default() }
    }
}

impl<T: Copy + PartialEq> OneByOne<T> {
    /// Whether it is what was asked for last.
    pub fn is_for(&self, item: &T) -> bool {
        self.asked.as_ref() == Some(item)
    }

    /// The first item that is missing, if it is to be asked for at `now`: at once if another was asked for before, else after a pause.
    pub fn ask(&mut self, first: T, now: MonotonicNs) -> Option<T> {
        if !self.is_for(&first) {
            *self = Self { asked: Some(first), cursor: PageCursor::default() };
        }
        self.cursor.ask(now)?;
        Some(first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_is_repeated_after_a_pause_and_the_next_page_is_asked_for_at_once() {
        let mut cursor = PageCursor::default();
        assert_eq!(cursor.ask(MonotonicNs(5)), Some(0));
        assert_eq!(cursor.ask(MonotonicNs(4 + ASK_AGAIN_NS)), None);
        assert_eq!(cursor.ask(MonotonicNs(5 + ASK_AGAIN_NS)), Some(0));
        assert!(cursor.accept(0, 64));
        assert_eq!(cursor.ask(MonotonicNs(6 + ASK_AGAIN_NS)), Some(64));
    }

    #[test]
    fn a_page_that_does_not_continue_changes_nothing() {
        let mut cursor = PageCursor::default();
        cursor.move_to(64);
        assert_eq!(cursor.ask(MonotonicNs(5)), Some(64));
        let before = cursor;
        assert!(!cursor.accept(0, 64) && !cursor.accept(65, 66));
        assert_eq!(cursor, before);
    }

    #[test]
    fn advancing_ends_the_pause_while_moving_and_starting_again_keep_it() {
        let mut cursor = PageCursor::default();
        assert_eq!(cursor.ask(MonotonicNs(5)), Some(0));
        cursor.move_to(3);
        assert_eq!(cursor.ask(MonotonicNs(6)), None);
        assert_eq!(cursor.ask_after(MonotonicNs(6), 1), Some(3));
        cursor.advance_to(3);
        assert_eq!(cursor.ask(MonotonicNs(7)), None, "no news");
        cursor.advance_to(4);
        assert_eq!(cursor.ask(MonotonicNs(7)), Some(4));
        cursor.restart(MonotonicNs(7));
        assert_eq!(cursor.ask(MonotonicNs(8)), None);
        assert_eq!(cursor.ask(MonotonicNs(7 + ASK_AGAIN_NS)), Some(0));
    }
}
