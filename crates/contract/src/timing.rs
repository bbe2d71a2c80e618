//! Where the time of a decision went.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Nanoseconds on the host's monotonic clock, or on the virtual clock of a simulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct MonotonicNs(pub u64);

impl MonotonicNs {
    /// Nanoseconds from `earlier` to here; 0 if `earlier` is later.
    #[must_use]
    pub fn since_ns(self, earlier: MonotonicNs) -> u64 {
        self.0.saturating_sub(earlier.0)
    }

    /// This instant plus `ns`, saturating.
    #[must_use]
    pub fn plus_ns(self, ns: u64) -> Self {
        Self(self.0.saturating_add(ns))
    }
}

/// The moments of one decision, from landing to commit. A zero means the moment was not measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Timing {
    /// The hopper came to rest.
    pub landed: MonotonicNs,
    /// hopper-sim published the state.
    pub state_published: MonotonicNs,
    /// perception had folded the pose into the map.
    pub sensed: MonotonicNs,
    /// perception published the map.
    pub map_published: MonotonicNs,
    /// The planner began to plan.
    pub planning_started: MonotonicNs,
    /// The planner had its action.
    pub planning_ended: MonotonicNs,
    /// hopper-sim accepted the command.
    pub accepted: MonotonicNs,
    /// The journal held the record.
    pub committed: MonotonicNs,
}

/// An interval between two moments of [`Timing`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// Landed → state published.
    State,
    /// State published → sensed.
    Sense,
    /// Sensed → map published.
    Map,
    /// Map published → planning started.
    Deliver,
    /// Planning started → planning ended.
    Plan,
    /// Planning ended → command accepted.
    Command,
    /// Command accepted → committed.
    Commit,
}

impl Stage {
    /// Every stage in the order of time.
    pub const ALL: [Stage; 7] =
        [Stage::State, Stage::Sense, Stage::Map, Stage::Deliver, Stage::Plan, Stage::Command, Stage::Commit];

    /// The stage's name in tables and JSON.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Stage::State => "state",
            Stage::Sense => "sense",
            Stage::Map => "map",
            Stage::Deliver => "deliver",
            Stage::Plan => "plan",
            Stage::Command => "command",
            Stage::Commit => "commit",
        }
    }
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

impl Timing {
    /// The moments in order.
    #[must_use]
    pub fn moments(&self) -> [MonotonicNs; 8] {
        [
            self.landed,
            self.state_published,
            self.sensed,
            self.map_published,
            self.planning_started,
            self.planning_ended,
            self.accepted,
            self.committed,
        ]
    }

    /// Timing from its moments in order.
    #[must_use]
    pub fn from_moments(moments: [MonotonicNs; 8]) -> Self {
        let [
            landed,
            state_published,
            sensed,
            map_published,
            planning_started,
            planning_ended,
            accepted,
            committed,
        ] = moments;
        Self {
            landed,
            state_published,
            sensed,
            map_published,
            planning_started,
            planning_ended,
            accepted,
            committed,
        }
    }

    /// Durations of the stages in nanoseconds, in the order of [`Stage::ALL`]. They sum to
    /// [`Timing::total_ns`] whatever the moments are: a moment that reads earlier than its
    /// predecessor (a process restarted in between) counts as simultaneous with it.
    #[must_use]
    pub fn stages_ns(&self) -> [u64; 7] {
        let mut latest = self.landed;
        let moments = self.moments();
        let end = self.committed.max(self.landed);
        std::array::from_fn(|stage| {
            let until = moments[stage + 1].max(latest).min(end);
            let ns = until.since_ns(latest);
            latest = until;
            ns
        })
    }

    /// Landed → command accepted in nanoseconds.
    #[must_use]
    pub fn answer_ns(&self) -> u64 {
        self.stages_ns()[..=Stage::Command as usize].iter().sum()
    }

    /// State published → planning started in nanoseconds: sensing, building the map, bringing it to the
    /// planner.
    #[must_use]
    pub fn feeding_ns(&self) -> u64 {
        self.stages_ns()[Stage::Sense as usize..=Stage::Deliver as usize].iter().sum()
    }

    /// Landed → committed in nanoseconds.
    #[must_use]
    pub fn total_ns(&self) -> u64 {
        self.committed.since_ns(self.landed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn timing(moments: [u64; 8]) -> Timing {
        Timing::from_moments(moments.map(MonotonicNs))
    }

    #[test]
    fn stages_telescope_to_the_total_even_out_of_order() {
        let tidy = timing([10, 11, 13, 16, 20, 25, 31, 38]);
        assert_eq!(tidy.stages_ns(), [1, 2, 3, 4, 5, 6, 7]);
        for moments in [
            [10, 30, 13, 16, 20, 25, 31, 38],
            [10, 0, 0, 0, 0, 0, 0, 38],
            [10, 11, 99, 16, 20, 25, 31, 38],
            [10, 11, 12, 13, 14, 15, 16, 5],
        ] {
            let timing = timing(moments);
            assert_eq!(timing.stages_ns().iter().sum::<u64>(), timing.total_ns(), "{moments:?}");
        }
    }
}
