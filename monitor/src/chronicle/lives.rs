//! Who came and went while a mission was watched.

use std::collections::{BTreeMap, VecDeque};

use contract::roster::SILENCE_NS;
use contract::{Decision, Heartbeat, Incarnation, MonotonicNs, Role};

/// Marks that are kept.
pub const MARKS_KEPT: usize = 1024;

/// Lives that are kept in mind; of those silent, the ones heard last.
const LIVES_KEPT: usize = 64;

/// What became of a process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// It was heard for the first time.
    Joined,
    /// It has not been heard for [`SILENCE_NS`].
    Silent,
    /// It was heard again.
    Back,
}

impl Change {
    /// The change in one word.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Change::Joined => "joined",
            Change::Silent => "silent",
            Change::Back => "back",
        }
    }
}

/// A change, and when.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mark {
    /// The decision that was due.
    pub decision: Decision,
    /// What happened.
    pub change: Change,
    /// To whom.
    pub beat: Heartbeat,
}

/// A process, and when it was last heard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Peer {
    /// Its last beat.
    pub beat: Heartbeat,
    /// When its counter last advanced.
    pub heard: MonotonicNs,
    /// Whether it counts as silent.
    pub silent: bool,
}

/// Every process heard of, with what became of it.
#[derive(Clone, Debug, Default)]
pub struct Lives {
    peers: BTreeMap<Incarnation, Peer>,
    marks: VecDeque<Mark>,
    /// Marks that are no longer kept.
    gone: u64,
}

impl Lives {
    /// Takes note of a beat at `now`; one whose counter stands still or leaps proves nothing.
    pub fn hear(&mut self, beat: &Heartbeat, decision: Decision, now: MonotonicNs) {
        let known = self.peers.get(&beat.incarnation).copied();
        if known.is_some_and(|known| !beat.follows(&known.beat, now.since_ns(known.heard))) {
            return;
        }
        match known {
            None => self.mark(Mark { decision, change: Change::Joined, beat: *beat }),
            Some(known) if known.silent => self.mark(Mark { decision, change: Change::Back, beat: *beat }),
            Some(_) => {}
        }
        self.peers.insert(beat.incarnation, Peer { beat: *beat, heard: now, silent: false });
        if self.peers.len() > LIVES_KEPT {
            let oldest = self.peers.iter().min_by_key(|(_, peer)| peer.heard).map(|(life, _)| *life);
            oldest.map(|oldest| self.peers.remove(&oldest));
        }
    }

    /// Takes note of who has fallen silent; once the mission is over everybody may.
    pub fn listen(&mut self, decision: Decision, over: bool, now: MonotonicNs) {
        let silent = |peer: &&mut Peer| !peer.silent && now.since_ns(peer.heard) > SILENCE_NS;
        let mut fallen = Vec::new();
        for peer in self.peers.values_mut().filter(silent) {
            peer.silent = true;
            fallen.push(peer.beat);
        }
        if !over {
            fallen.into_iter().for_each(|beat| self.mark(Mark { decision, change: Change::Silent, beat }));
        }
    }

    /// Everybody heard of, by role and then in the order of their coming as far as processes tell.
    #[must_use]
    pub fn peers(&self) -> Vec<Peer> {
        let mut peers: Vec<Peer> = self.peers.values().copied().collect();
        peers.sort_by_key(|peer| (peer.beat.role, peer.silent, peer.beat.pid));
        peers
    }

    /// Whether the life belongs to a planner that is heard.
    #[must_use]
    pub fn is_live_planner(&self, life: Incarnation) -> bool {
        self.peers.get(&life).is_some_and(|peer| peer.beat.role == Role::Planner && !peer.silent)
    }

    /// The marks in order.
    pub fn marks(&self) -> impl DoubleEndedIterator<Item = &Mark> {
        self.marks.iter()
    }

    pub(super) fn marks_from(&self, number: u64) -> impl Iterator<Item = &Mark> {
        self.marks.iter().skip(number.saturating_sub(self.gone) as usize)
    }

    pub(super) fn marks_count(&self) -> u64 {
        self.gone + self.marks.len() as u64
    }

    pub(super) fn forget_marks(&mut self) {
        self.gone += self.marks.len() as u64;
        self.marks.clear();
    }

    fn mark(&mut self, mark: Mark) {
        if self.marks.len() == MARKS_KEPT {
            self.marks.pop_front();
            self.gone += 1;
        }
        self.marks.push_back(mark);
    }
}

#[cfg(test)]
mod tests {
    use contract::{Name, RunId, Status};

    use super::*;

    /// P-ROGUE-BEAT on the page: a life in whose name somebody else beats is not silent for that.
    #[test]
    fn a_forged_leap_of_the_counter_silences_no_life() {
        let beat = |counter| Heartbeat {
            role: Role::Planner,
            incarnation: Incarnation(7),
            pid: 1,
            version: Name::NONE,
            planner: Name::NONE,
            counter,
            run: RunId(0),
            decision: Decision(0),
            status: Status::Underway,
        };
        let mut lives = Lives::default();
        lives.hear(&beat(1), Decision(0), MonotonicNs(0));
        lives.hear(&beat(u64::MAX), Decision(0), MonotonicNs(1));
        lives.hear(&beat(2), Decision(0), MonotonicNs(SILENCE_NS));
        lives.listen(Decision(0), false, MonotonicNs(2 * SILENCE_NS));
        assert!(lives.is_live_planner(Incarnation(7)));
        assert_eq!(lives.marks().count(), 1, "it joined, and nothing else");
        // The same beat again is no sign of life.
        lives.hear(&beat(2), Decision(1), MonotonicNs(2 * SILENCE_NS));
        lives.listen(Decision(1), false, MonotonicNs(2 * SILENCE_NS + 1));
        assert!(!lives.is_live_planner(Incarnation(7)));
    }
}
