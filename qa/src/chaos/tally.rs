//! What the faults of a role came to: counts by kind, recovery times, the bound that zero failures give.

use std::collections::BTreeMap;

use contract::Role;
use serde::Serialize;

use super::mission::{Delivered, Flown};

/// One role's faults.
#[derive(Clone, Debug, Serialize)]
pub struct Tally {
    /// The role.
    pub role: Role,
    /// Missions in which it was the victim.
    pub missions: u64,
    /// Faults that befell it.
    pub faults: u64,
    /// The same by kind; a crash point is a kind.
    pub kinds: BTreeMap<&'static str, u64>,
    /// Missions that broke a promise.
    pub failures: u64,
    /// At 95 %, fewer of its faults than this break a promise; `None` if one did, or none was delivered.
    pub bound: Option<f64>,
    /// From a fault to the next decision that was committed; faults after the last decision have none.
    pub recovery: Recovery,
    #[serde(skip)]
    recoveries_ns: Vec<u64>,
}

/// Recovery times, milliseconds.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Recovery {
    /// Faults with a decision after them.
    pub count: usize,
    /// Median.
    pub p50_ms: f64,
    /// 99th percentile.
    pub p99_ms: f64,
    /// Longest.
    pub max_ms: f64,
}

impl Tally {
    /// No fault yet.
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

    /// Takes note of a mission.
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
    /// Of times in ascending order; percentiles by nearest rank.
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
