//! Processes that joined, fell silent or came back during a mission.

use std::collections::{BTreeMap, VecDeque};

use contract::protocol::peer_table::SILENCE_NS;
use contract::{Decision, Heartbeat, Incarnation, MissingPeer, MonotonicNs, Role};

/// Number of events that are kept, the newest.
pub const EVENTS_KEPT: usize = 1024;

/// Number of processes that are kept, those heard last.
const PEERS_KEPT: usize = 64;

/// How the liveness of a process changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PeerChange {
    /// It was heard for the first time.
    Joined,
    /// It has not been heard for [`SILENCE_NS`].
    Silent,
    /// It was heard again.
    Back,
}

impl PeerChange {
    /// The change in one word.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            PeerChange::Joined => "joined",
            PeerChange::Silent => "silent",
            PeerChange::Back => "back",
        }
    }
}

/// A change of a process, and when.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PeerEvent {
    /// The decision that was due.
    pub decision: Decision,
    /// Kind of change.
    pub change: PeerChange,
    /// Last heartbeat of the process.
    pub beat: Heartbeat,
}

/// A process with the time of its last heartbeat.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Peer {
    /// Its last heartbeat.
    pub beat: Heartbeat,
    /// When its counter last advanced.
    pub heard: MonotonicNs,
    /// Whether it has been silent for longer than [`SILENCE_NS`].
    pub silent: bool,
}

/// Every process heard, and the changes of their liveness.
#[derive(Clone, Debug, Default)]
pub struct PeerHistory {
    peers: BTreeMap<Incarnation, Peer>,
    events: VecDeque<PeerEvent>,
    /// Number of events that are no longer kept.
    gone: u64,
}

impl PeerHistory {
    /// Adds a heartbeat received at `now`. A heartbeat whose counter stands still or jumps is ignored.
    pub fn heartbeat(&mut self, beat: &Heartbeat, decision: Decision, now: MonotonicNs) {
        let known = self.peers.get(&beat.incarnation).copied();
        if known.is_some_and(|known| !beat.follows(&known.beat, now.since_ns(known.heard))) {
            return;
        }
        match known {
            None => self.add_event(PeerEvent { decision, change: PeerChange::Joined, beat: *beat }),
            Some(known) if known.silent => {
                self.add_event(PeerEvent { decision, change: PeerChange::Back, beat: *beat })
            }
            Some(_) => {}
        }
        self.peers.insert(beat.incarnation, Peer { beat: *beat, heard: now, silent: false });
        if self.peers.len() > PEERS_KEPT {
            let oldest = self.peers.iter().min_by_key(|(_, peer)| peer.heard).map(|(life, _)| *life);
            oldest.map(|oldest| self.peers.remove(&oldest));
        }
    }

    /// Marks processes that have fallen silent; once the mission is over, without an event.
    pub fn mark_silent(&mut self, decision: Decision, over: bool, now: MonotonicNs) {
        let silent = |peer: &&mut Peer| !peer.silent && now.since_ns(peer.heard) > SILENCE_NS;
        let mut fallen = Vec::new();
        for peer in self.peers.values_mut().filter(silent) {
            peer.silent = true;
            fallen.push(peer.beat);
        }
        if !over {
            fallen
                .into_iter()
                .for_each(|beat| self.add_event(PeerEvent { decision, change: PeerChange::Silent, beat }));
        }
    }

    /// Every process, sorted by role, silence and process id.
    #[must_use]
    pub fn peers(&self) -> Vec<Peer> {
        let mut peers: Vec<Peer> = self.peers.values().copied().collect();
        peers.sort_by_key(|peer| (peer.beat.role, peer.silent, peer.beat.pid));
        peers
    }

    /// Whether `life` is a planner that is not silent.
    #[must_use]
    pub fn is_live_planner(&self, life: Incarnation) -> bool {
        self.peers.get(&life).is_some_and(|peer| peer.beat.role == Role::Planner && !peer.silent)
    }

    /// What the living lack to go on, as the living hopper-sim tells which robots act; `None` without one.
    #[must_use]
    pub fn missing(&self) -> Option<MissingPeer> {
        let alive = || self.peers.values().filter(|peer| !peer.silent).map(|peer| peer.beat);
        let acting = alive().find(|beat| beat.role == Role::HopperSim)?.robots;
        MissingPeer::among(acting, alive())
    }

    /// The events that are kept, in order.
    pub fn events(&self) -> impl DoubleEndedIterator<Item = &PeerEvent> {
        self.events.iter()
    }

    pub(super) fn events_from(&self, number: u64) -> impl Iterator<Item = &PeerEvent> {
        self.events.iter().skip(number.saturating_sub(self.gone) as usize)
    }

    pub(super) fn events_count(&self) -> u64 {
        self.gone + self.events.len() as u64
    }

    pub(super) fn forget_events(&mut self) {
        self.gone += self.events.len() as u64;
        self.events.clear();
    }

    fn add_event(&mut self, event: PeerEvent) {
        if self.events.len() == EVENTS_KEPT {
            self.events.pop_front();
            self.gone += 1;
        }
        self.events.push_back(event);
    }
}

#[cfg(test)]
mod tests {
    use contract::{Name, RobotSet, RunId, Status};

    use super::*;

    /// P-MANNED. On the page silent processes do not count, and hopper-sim says which robots act.
    #[test]
    fn a_silent_planner_leaves_its_robots_without_one() {
        let beat = |role, life, robots| Heartbeat {
            role,
            incarnation: Incarnation(life),
            pid: 1,
            version: Name::NONE,
            planner: Name::NONE,
            counter: 1,
            run: RunId(0),
            decision: Decision(0),
            status: Status::Underway,
            robots: RobotSet(robots),
        };
        let mut peers = PeerHistory::default();
        assert_eq!(peers.missing(), None, "without hopper-sim nobody knows");
        let later = MonotonicNs(SILENCE_NS + 1);
        peers.heartbeat(&beat(Role::Planner, 3, 0b10), Decision(0), MonotonicNs(0));
        for (role, life, robots) in
            [(Role::HopperSim, 1, 0b111), (Role::Perception, 2, 0), (Role::Planner, 4, 0b1)]
        {
            peers.heartbeat(&beat(role, life, robots), Decision(0), later);
        }
        assert_eq!(peers.missing(), Some(MissingPeer::Planner(RobotSet(0b100))));
        peers.mark_silent(Decision(0), false, later);
        assert_eq!(peers.missing(), Some(MissingPeer::Planner(RobotSet(0b110))));
    }

    /// P-ROGUE-BEAT. On the page a process in whose name somebody else sends heartbeats does not
    /// count as silent.
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
            robots: RobotSet::default(),
        };
        let mut peers = PeerHistory::default();
        peers.heartbeat(&beat(1), Decision(0), MonotonicNs(0));
        peers.heartbeat(&beat(u64::MAX), Decision(0), MonotonicNs(1));
        peers.heartbeat(&beat(2), Decision(0), MonotonicNs(SILENCE_NS));
        peers.mark_silent(Decision(0), false, MonotonicNs(2 * SILENCE_NS));
        assert!(peers.is_live_planner(Incarnation(7)));
        assert_eq!(peers.events().count(), 1, "it joined, and nothing else");
        // A repeated heartbeat is no sign of life.
        peers.heartbeat(&beat(2), Decision(1), MonotonicNs(2 * SILENCE_NS));
        peers.mark_silent(Decision(1), false, MonotonicNs(2 * SILENCE_NS + 1));
        assert!(!peers.is_live_planner(Incarnation(7)));
    }
}
