//! How often each thing that is worth simulating has come up.

use std::collections::BTreeMap;

use serde::Serialize;

/// Counters by group and name.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Coverage(pub BTreeMap<&'static str, BTreeMap<&'static str, u64>>);

impl Coverage {
    /// Counts one more.
    pub fn count(&mut self, group: &'static str, name: &'static str) {
        *self.0.entry(group).or_default().entry(name).or_default() += 1;
    }

    /// How often it came up.
    #[must_use]
    pub fn of(&self, group: &str, name: &str) -> u64 {
        self.0.get(group).and_then(|names| names.get(name)).copied().unwrap_or(0)
    }

    /// Adds the counts of another simulation.
    pub fn add(&mut self, other: &Coverage) {
        for (group, names) in &other.0 {
            for (name, count) in names {
                *self.0.entry(group).or_default().entry(name).or_default() += count;
            }
        }
    }
}

/// A rare event that must come up: group, name, and within how many seeds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sometimes {
    /// Group of the counter.
    pub group: &'static str,
    /// Name of the counter.
    pub name: &'static str,
    /// Seeds within which it comes up at least once, with room to spare.
    pub seeds: u64,
}

const fn sometimes(group: &'static str, name: &'static str, seeds: u64) -> Sometimes {
    Sometimes { group, name, seeds }
}

/// Rare events without which promises are kept by luck.
pub const SOMETIMES: &[Sometimes] = &[
    sometimes("map", "discs_differ", 100),
    sometimes("map", "patch_between_pages", 500),
    sometimes("map", "pass_undisturbed", 500),
    sometimes("map", "pass_disturbed", 500),
    sometimes("map", "asked_again", 2_000),
    sometimes("journal", "replaced_before", 500),
    sometimes("journal", "replaced_after", 500),
    sometimes("reservation", "kept", 500),
    sometimes("reservation", "slow_bidder", 20_000),
    sometimes("stayed", "planner", 500),
    sometimes("stayed", "perception", 500),
    sometimes("stayed", "monitor", 500),
    sometimes("fallback", "policy", 2_000),
];

impl Coverage {
    /// The rare events that should have come up in so many seeds, and did not.
    pub fn never(&self, seeds: u64) -> impl Iterator<Item = &'static Sometimes> + '_ {
        SOMETIMES.iter().filter(move |event| event.seeds <= seeds && self.of(event.group, event.name) == 0)
    }
}
