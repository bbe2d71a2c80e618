//! How long a mission took on a clock that may have begun anew.

use contract::{MonotonicNs, Timing};

/// Time from the first landing to the last commit. CLOCK_MONOTONIC begins anew with a reboot: a decision that lands before the
/// last commit belongs to another boot, and what lies between two boots counts as no time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct FlownTime {
    /// Time flown in boots before the present one, nanoseconds.
    before_ns: u64,
    /// First landing and last commit of the present boot; `None` before the first decision.
    present: Option<(MonotonicNs, MonotonicNs)>,
}

impl FlownTime {
    /// The time flown in decisions with these `timings`, in order.
    pub fn of<'t>(timings: impl IntoIterator<Item = &'t Timing>) -> Self {
        let mut flown = Self::default();
        timings.into_iter().for_each(|timing| flown.add(timing));
        flown
    }

    /// Adds the next decision.
    pub fn add(&mut self, timing: &Timing) {
        let landed = match self.present {
            Some((landed, committed)) if timing.landed >= committed => landed,
            Some((landed, committed)) => {
                self.before_ns += committed.since_ns(landed);
                timing.landed
            }
            None => timing.landed,
        };
        self.present = Some((landed, timing.committed));
    }

    /// Nanoseconds so far.
    pub fn ns(&self) -> u64 {
        self.before_ns + self.present.map_or(0, |(landed, committed)| committed.since_ns(landed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn timing(landed_s: u64, committed_s: u64) -> Timing {
        let [landed, committed] = [landed_s, committed_s].map(|s| MonotonicNs(s * 1_000_000_000));
        Timing { landed, committed, ..Timing::default() }
    }

    #[test]
    fn a_reboot_takes_no_time_and_loses_none() {
        assert_eq!(FlownTime::default().ns(), 0);
        let before = [timing(500, 501), timing(501, 505)];
        assert_eq!(FlownTime::of(&before).ns(), 5_000_000_000);
        let after = [timing(3, 4), timing(6, 10), timing(10, 11)];
        assert_eq!(FlownTime::of(before.iter().chain(&after)).ns(), 13_000_000_000);
    }
}
