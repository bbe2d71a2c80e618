//! Who is there: who is told of the run again, whether the mission can go on, and when all know its end.

use contract::protocol::peer_table::SILENCE_NS;
use contract::{Decision, Heartbeat, MonotonicNs, PeerTable, RobotId, RobotSet, Role};

use super::{Arbiter, Effect, Phase};

/// How long the end is served to a role that nobody plays, nanoseconds, once all others know it.
const LATE_COMER_NS: u64 = 250_000_000;

/// How long peers may go on beating without knowing the run before it is published again, nanoseconds: the brief
/// is published once, and whoever missed it would miss it for ever.
pub const ANNOUNCE_NS: u64 = SILENCE_NS;

impl Arbiter {
    /// Whether the mission can go on: somebody senses who has its ground, and somebody plans for the robot that is due. One
    /// that is over, or under way with a fallback, needs nobody.
    #[must_use]
    pub fn is_manned(&self, peer_table: &PeerTable, now: MonotonicNs) -> bool {
        let senses = peer_table.has_of_run(Role::Perception, self.state.run, now);
        let due = RobotSet::NONE.with(self.due());
        let plans = peer_table.without_planner(due, now).is_empty();
        self.state.status.is_over() || self.falls_back() || senses && plans
    }

    /// Whether the guard's fallback acts where no planner does in time: once a mission with a deadline is under way.
    #[must_use]
    pub fn falls_back(&self) -> bool {
        // What is repeated from its journal may begin with what the fallback did.
        let has_begun = self.state.decision > Decision(0) || !self.deadlines;
        self.mission.brief.guard.deadline_ns > 0 && has_begun
    }

    /// The robot whose planner is to command next, if nothing is under way and nobody acts in its place.
    #[must_use]
    pub fn awaited(&self) -> Option<RobotId> {
        let rests = matches!(self.phase, Phase::Resting) && !self.state.status.is_over();
        if rests && !self.falls_back() { Some(self.due()) } else { None }
    }

    /// The brief again, if peers that do not know of the run go on without it.
    pub(super) fn announce(&mut self, beat: &Heartbeat, now: MonotonicNs) -> Option<Effect> {
        if beat.run == self.state.run || beat.role == Role::HopperSim {
            return None;
        }
        let since = *self.unknown_since.get_or_insert(now);
        let waited_ns = now.since_ns(since);
        if waited_ns > 2 * ANNOUNCE_NS {
            // Those of then know it by now, or are gone.
            self.unknown_since = Some(now);
            return None;
        }
        if waited_ns < ANNOUNCE_NS {
            return None;
        }
        self.unknown_since = None;
        Some(Effect::Announce)
    }

    /// Whether the final state is out and its peers are waited for.
    pub(super) fn is_lingering(&self) -> bool {
        self.state.status.is_over() && self.sent.is_some() && !self.finished
    }

    /// Finishes once everyone who lives has seen the end and nobody is missing, or the linger is up.
    pub(super) fn conclude(&mut self, now: MonotonicNs) -> Option<Effect> {
        if !self.is_lingering() {
            return None;
        }
        let (run, status) = (self.state.run, self.state.status);
        let is_peer = |role: &Role| *role != Role::HopperSim;
        let here = |role: Role| self.peer_table.has(role, now);
        let served_ns = now.since_ns(self.state.published);
        // Perception and a planner of each robot flew the mission; whoever else may come is given a moment.
        let planned = self.peer_table.without_planner(RobotSet::first(self.robots()), now).is_empty();
        let everyone_is_here =
            here(Role::Perception) && planned && (here(Role::Monitor) || served_ns >= LATE_COMER_NS);
        let everyone_knows = self
            .peer_table
            .live(now)
            .filter(|peer| is_peer(&peer.beat.role))
            .all(|peer| peer.beat.run == run && peer.beat.status == status);
        let waited_enough = served_ns >= self.linger_ns;
        self.finished = waited_enough || (everyone_is_here && everyone_knows);
        self.finished.then_some(Effect::Finished(status))
    }
}
