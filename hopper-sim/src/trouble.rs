//! Something that goes wrong again and again: reported once, and endured for a while.

use contract::MonotonicNs;
use contract::protocol::peer_table::SILENCE_NS;

/// A trouble that lasts. Failures further apart than [`SILENCE_NS`] are not one trouble.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Trouble {
    /// The first failure in words.
    why: String,
    since: MonotonicNs,
    last: MonotonicNs,
}

impl Trouble {
    /// Notes a failure at `now`; true if it is news, and worth a line in the log.
    pub(crate) fn note(trouble: &mut Option<Self>, error: &impl std::fmt::Display, now: MonotonicNs) -> bool {
        match trouble {
            Some(known) if now.since_ns(known.last) <= SILENCE_NS => {
                known.last = now;
                false
            }
            _ => {
                *trouble = Some(Self { why: error.to_string(), since: now, last: now });
                true
            }
        }
    }

    /// How long it has lasted up to its last failure, nanoseconds.
    pub(crate) fn lasted_ns(&self) -> u64 {
        self.last.since_ns(self.since)
    }

    /// The first failure in words.
    pub(crate) fn why(&self) -> &str {
        &self.why
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trouble_is_news_once_and_lasts_as_long_as_it_fails_without_a_break() {
        let mut trouble = None;
        assert!(Trouble::note(&mut trouble, &"gone", MonotonicNs(5)));
        for n in 1..=30 {
            assert!(!Trouble::note(&mut trouble, &"gone still", MonotonicNs(5 + n * SILENCE_NS)));
        }
        let lasting = trouble.as_ref().unwrap();
        assert_eq!((lasting.why(), lasting.lasted_ns()), ("gone", 30 * SILENCE_NS));
        // Nobody has minded for a while: it begins anew.
        assert!(Trouble::note(&mut trouble, &"gone again", MonotonicNs(6 + 31 * SILENCE_NS + 6)));
        assert_eq!(trouble.unwrap().lasted_ns(), 0);
    }
}
