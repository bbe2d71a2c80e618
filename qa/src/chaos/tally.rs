//! Statistics of the faults of a role: counts by kind, recovery times, the bound that zero failures give.

use std::collections::BTreeMap;

use contract::Role;
use serde::Serialize;

use super::mission::{Delivered, Flown};

/// Statistics of the faults injected into one role.
#[derive(Clone, Debug, Serialize)]
pub struct Tally {
    /// Role that was the victim.
    pub role: Role,
    /// Missions flown with this victim.
    pub missions: u64,
    /// Faults that were injected, over all missions.
    pub faults: u64,
    /// Faults by kind; each crash point is a kind.
    pub kinds: BTreeMap<&'static str, u64>,
    /// Missions that broke a promise.
    pub failures: u64,
    /// Upper bound (95 %) of the share of faults that break a promise, 3 / faults; `None` after a failure or without
    /// a fault.
    pub bound: Option<f64>,
    /// Time from a fault to the next committed decision; faults after the last decision do not count.
    pub recovery: Recovery,
    #[serde(skip)]
    recoveries_ns: Vec<u64>,
}

/// Percentiles of recovery times by nearest rank, milliseconds.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Recovery {
    /// Faults that a decision followed.
    pub count: usize,
    /// Time within which half of the processes recovered, milliseconds.
    pub p50_ms: f64,
    /// Time within which 99 % of the processes recovered, milliseconds.
    pub p99_ms: f64,
    /// Time within which the slowest process recovered, milliseconds.
    pub max_ms: f64,
}

impl Tally {
    /// A tally without a mission.
    #[must_use]
    pub fn new(role: Role) -> Self {
        Self {
            role,
            missions: 0,
            faults: 0,
            kinds: BTreeMap::new(),
            failures: 0,
            bound: None,
            recovery: Recovery::default(),
            recoveries_ns: Vec::new(),
        }
    }

    /// Counts a mission's faults and recoveries in.
    pub fn add(&mut self, flown: &Flown) {
        self.missions += 1;
        self.failures += u64::from(flown.broken.is_some());
        for Delivered { fault, recovery_ns } in &flown.delivered {
            self.faults += 1;
            *self.kinds.entry(fault.name()).or_default() += 1;
            self.recoveries_ns.extend(recovery_ns);
        }
        self.recoveries_ns.sort_unstable();
        self.recovery = Recovery::of(&self.recoveries_ns);
        self.bound = (self.failures == 0 && self.faults > 0).then(|| 3.0 / self.faults as f64);
    }
}

impl Recovery {
    /// The figures of recovery times in ascending order, nanoseconds.
    fn of(sorted_ns: &[u64]) -> Self {
        let Some(&max) = sorted_ns.last() else { return Self::default() };
        let ms = |ns: u64| ns as f64 / 1e6;
        let rank = |percent: usize| sorted_ns[(sorted_ns.len() * percent).div_ceil(100).max(1) - 1];
        Self { count: sorted_ns.len(), p50_ms: ms(rank(50)), p99_ms: ms(rank(99)), max_ms: ms(max) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_of_the_nearest_rank() {
        let times: Vec<u64> = (1..=200).map(|ms| ms * 1_000_000).collect();
        let Recovery { count, p50_ms, p99_ms, max_ms } = Recovery::of(&times);
        assert_eq!((count, p50_ms, p99_ms, max_ms), (200, 100.0, 198.0, 200.0));
        assert_eq!(Recovery::of(&[7_000_000]).p99_ms, 7.0);
    }
}
