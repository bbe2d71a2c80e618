//! Who is alive, by heartbeats that advance.

use std::collections::BTreeMap;

use crate::limits::PEERS_MAX;
use crate::{Heartbeat, Incarnation, MonotonicNs, RobotSet, Role, RunId};

/// A heartbeat older than this no longer proves life: ten missed beats.
pub const SILENCE_NS: u64 = 1_000_000_000;

/// How often a process beats.
pub const BEAT_PERIOD_NS: u64 = 50_000_000;

/// How long whoever looks in listens before all that live count as heard, nanoseconds: several heartbeats.
pub const LISTENING_NS: u64 = 8 * BEAT_PERIOD_NS;

/// One process as last heard of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Peer {
    /// The newest; later ones of the same life replace it.
    pub beat: Heartbeat,
    /// When its counter last advanced.
    pub advanced: MonotonicNs,
}

/// Every process heard of; a beat whose counter stands still proves nothing.
#[derive(Clone, Debug, Default)]
pub struct PeerTable {
    peers: BTreeMap<Incarnation, Peer>,
}

impl PeerTable {
    /// Takes note of a beat heard at `now`, unless its counter stands still or leaps. Peers silent for ten times
    /// [`SILENCE_NS`] are forgotten; while [`PEERS_MAX`] are remembered, nobody else is heard, so that a flood of
    /// lives neither takes memory nor drives out who is known.
    pub fn observe(&mut self, beat: Heartbeat, now: MonotonicNs) {
        let known = self.peers.get(&beat.incarnation);
        let is_news = |peer: &Peer| beat.follows(&peer.beat, now.since_ns(peer.advanced));
        if known.is_some_and(|peer| !is_news(peer)) {
            // Nor is it forgotten by that: it would be taken for news.
            return;
        }
        let known = known.is_some();
        self.peers.retain(|_, peer| now.since_ns(peer.advanced) <= 10 * SILENCE_NS);
        if known || self.peers.len() < PEERS_MAX {
            self.peers.insert(beat.incarnation, Peer { beat, advanced: now });
        }
    }

    /// Everyone who lives at `now`.
    pub fn live(&self, now: MonotonicNs) -> impl Iterator<Item = &Peer> {
        self.peers.values().filter(move |peer| now.since_ns(peer.advanced) <= SILENCE_NS)
    }

    /// Whether somebody of `role` lives at `now`.
    #[must_use]
    pub fn has(&self, role: Role, now: MonotonicNs) -> bool {
        self.live(now).any(|peer| peer.beat.role == role)
    }

    /// Whether somebody of `role` lives at `now` who knows `run`.
    #[must_use]
    pub fn has_of_run(&self, role: Role, run: RunId, now: MonotonicNs) -> bool {
        self.live(now).any(|peer| peer.beat.role == role && peer.beat.run == run)
    }

    /// The robots among `robots` for which no planner plans that lives at `now`.
    #[must_use]
    pub fn without_planner(&self, robots: RobotSet, now: MonotonicNs) -> RobotSet {
        let planners = self.live(now).filter(|peer| peer.beat.role == Role::Planner);
        planners.fold(robots, |left, peer| left.without(peer.beat.robots))
    }

    /// What was last heard of a process, if anything.
    #[must_use]
    pub fn by_pid(&self, pid: u32) -> Option<&Peer> {
        self.peers.values().filter(|peer| peer.beat.pid == pid).max_by_key(|peer| peer.advanced)
    }

    /// What was last heard of one life, if anything.
    #[must_use]
    pub fn peer(&self, incarnation: Incarnation) -> Option<&Peer> {
        self.peers.get(&incarnation)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Decision, Name, Status};

    fn beat(counter: u64) -> Heartbeat {
        Heartbeat {
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
        }
    }

    #[test]
    fn a_flood_of_lives_drives_out_nobody_and_takes_no_more_room() {
        let mut peer_table = PeerTable::default();
        peer_table.observe(beat(1), MonotonicNs(0));
        for life in 100..1_000 {
            peer_table.observe(Heartbeat { incarnation: Incarnation(life), ..beat(1) }, MonotonicNs(life));
        }
        peer_table.observe(beat(2), MonotonicNs(1_000));
        assert_eq!(peer_table.live(MonotonicNs(1_000)).count(), PEERS_MAX);
        assert_eq!(peer_table.peer(Incarnation(7)).unwrap().beat.counter, 2);
        // Once the flood has run dry there is room again.
        peer_table
            .observe(Heartbeat { incarnation: Incarnation(1), ..beat(1) }, MonotonicNs(11 * SILENCE_NS));
        assert!(peer_table.peer(Incarnation(1)).is_some());
    }

    #[test]
    fn a_counter_that_stands_still_proves_no_life() {
        let mut peer_table = PeerTable::default();
        peer_table.observe(beat(1), MonotonicNs(0));
        peer_table.observe(beat(1), MonotonicNs(SILENCE_NS));
        assert!(peer_table.has(Role::Planner, MonotonicNs(SILENCE_NS)));
        assert!(!peer_table.has(Role::Planner, MonotonicNs(SILENCE_NS + 1)));
        peer_table.observe(beat(2), MonotonicNs(SILENCE_NS + 1));
        assert!(peer_table.has(Role::Planner, MonotonicNs(SILENCE_NS + 2)));
    }

    #[test]
    fn a_forged_leap_of_the_counter_silences_nobody() {
        let mut peer_table = PeerTable::default();
        peer_table.observe(beat(1), MonotonicNs(0));
        peer_table.observe(beat(u64::MAX), MonotonicNs(1));
        peer_table.observe(beat(2), MonotonicNs(SILENCE_NS));
        assert!(peer_table.has(Role::Planner, MonotonicNs(2 * SILENCE_NS)));
        // Who has been away for a minute finds many beats gone by.
        peer_table.observe(beat(2 + 60 * 20), MonotonicNs(61 * SILENCE_NS));
        assert!(peer_table.has(Role::Planner, MonotonicNs(61 * SILENCE_NS)));
    }
}
