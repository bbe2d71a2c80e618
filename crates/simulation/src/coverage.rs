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
