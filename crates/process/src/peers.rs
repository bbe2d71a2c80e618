//! Which peers are of this build.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use contract::protocol::peer_table::SILENCE_NS;
use contract::{Heartbeat, Incarnation, MonotonicNs, Name, Refusal};

/// Lives whose build a process remembers. While there are so many, newcomers are not known until others fall silent.
const LIVES_MAX: usize = 1024;

/// Tells peers of this build from those of another by the first heartbeat of each life. A process of another build is
/// usually refused when it joins; a build too old to check is recognised here.
#[derive(Clone, Debug)]
pub struct Builds {
    own: Name,
    /// The version in the first heartbeat of each life, and when the last one came.
    known: BTreeMap<Incarnation, (Name, MonotonicNs)>,
}

impl Builds {
    /// Peers of a process whose own version is `own`.
    #[must_use]
    pub fn new(own: Name) -> Self {
        Self { own, known: BTreeMap::new() }
    }

    /// Whether a heartbeat that is heard at `now` is of this build. The first of another is logged with both versions.
    pub fn admit(&mut self, beat: &Heartbeat, now: MonotonicNs) -> bool {
        let own = self.own;
        if beat.version != own && !self.known.contains_key(&beat.incarnation) {
            tracing::error!(
                "{} (process {}) is version {}, this process is version {own}: its messages are ignored; run all \
                 processes of an instance from one build",
                beat.role,
                beat.pid,
                beat.version,
            );
        }
        if self.known.len() >= LIVES_MAX && !self.known.contains_key(&beat.incarnation) {
            self.known.retain(|_, (_, heard)| now.since_ns(*heard) <= 10 * SILENCE_NS);
        }
        let is_full = self.known.len() >= LIVES_MAX;
        match self.known.entry(beat.incarnation) {
            Entry::Occupied(mut known) => known.get_mut().1 = now,
            Entry::Vacant(_) if is_full => {}
            Entry::Vacant(place) => {
                place.insert((beat.version, now));
            }
        }
        beat.version == own && self.refuse(beat.incarnation).is_none()
    }

    /// Why a message of that life is refused, if it is of another build.
    #[must_use]
    pub fn refuse(&self, incarnation: Incarnation) -> Option<Refusal> {
        let (got, _) = self.known.get(&incarnation).filter(|(got, _)| *got != self.own)?;
        Some(Refusal::malformed("version", self.own.as_str(), got))
    }

    /// Whether a heartbeat of that life has been heard, so that its build is known.
    #[must_use]
    pub fn knows(&self, incarnation: Incarnation) -> bool {
        self.known.contains_key(&incarnation)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use contract::{Decision, RobotSet, Role, RunId, Status};

    fn beat(life: u64, version: &str) -> Heartbeat {
        Heartbeat {
            role: Role::Planner,
            incarnation: Incarnation(life),
            pid: 1,
            version: version.parse().expect("a name"),
            planner: Name::NONE,
            counter: 1,
            run: RunId(0),
            decision: Decision(0),
            status: Status::Underway,
            robots: RobotSet::default(),
        }
    }

    /// P-UNKNOWN-BUILD: No command is executed from a process whose heartbeat has not been
    /// received, since its build is unknown. Memory is bounded, and a flood of such processes shuts
    /// nobody out for good.
    #[test]
    fn a_flood_of_lives_takes_bounded_memory_and_shuts_nobody_out_for_good() {
        let mut builds = Builds::new("1".parse().expect("a name"));
        assert!(builds.admit(&beat(1, "1"), MonotonicNs(0)) && !builds.admit(&beat(2, "0"), MonotonicNs(0)));
        assert!(builds.knows(Incarnation(1)) && builds.refuse(Incarnation(1)).is_none());
        assert!(builds.knows(Incarnation(2)) && builds.refuse(Incarnation(2)).is_some());
        for life in 10..5_000 {
            builds.admit(&beat(life, "1"), MonotonicNs(1));
        }
        assert_eq!(builds.known.len(), LIVES_MAX);
        assert!(builds.knows(Incarnation(1)) && !builds.knows(Incarnation(4_999)));
        let later = MonotonicNs(10 * SILENCE_NS + 2);
        builds.admit(&beat(1, "1"), later);
        assert!(builds.admit(&beat(9_000, "1"), later) && builds.knows(Incarnation(9_000)));
        assert!(builds.knows(Incarnation(1)) && builds.known.len() < LIVES_MAX);
    }
}
