//! Decisions that are kept for a planner that takes over.

use contract::protocol::peer_table::SILENCE_NS;
use contract::{Command, Decision, Incarnation, MonotonicNs, Refusal, RobotId};

use super::{Arbiter, Phase};

/// How long a decision is at least kept for a planner that takes over, nanoseconds; twice the
/// decision budget if that is longer.
pub const BID_GRACE_NS: u64 = SILENCE_NS;

/// A takeover that came too late for one decision, and for which the robot's next is kept: without it, a slow
/// planner would lose every race against a quick incumbent.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bid {
    pub(super) incarnation: Incarnation,
    pub(super) robot: RobotId,
    /// The decision that is kept.
    pub(super) decision: Decision,
    /// When the bid was made.
    since: MonotonicNs,
}

impl Arbiter {
    /// A refused command asks for the next term if it was only too late.
    pub(super) fn bid_of(&self, command: &Command, refusal: &Refusal, now: MonotonicNs) -> Option<Bid> {
        let late = matches!(refusal, Refusal::Busy { .. } | Refusal::RepeatedDecision { .. });
        let robot = command.robot;
        if robot.0 >= self.robots() {
            return None;
        }
        let takes_over = command.term == self.leader(robot).term.next();
        // Whoever let one decision pass that was kept for it is too slow to be waited for.
        let slow = self.bid_for(robot).is_some_and(|bid| bid.incarnation == command.incarnation);
        let due = self.state.decision;
        let is_next = matches!(self.phase, Phase::Resting) && robot == self.due();
        let decision = if is_next { due } else { due.next() };
        let bid = Bid { incarnation: command.incarnation, robot, decision, since: now };
        (late && takes_over && !slow).then_some(bid)
    }

    /// Remembers a new bid for a robot, unless one for it stands.
    pub(super) fn keep_bid(&mut self, bid: Option<Bid>, now: MonotonicNs) {
        let Some(bid) = bid.filter(|bid| self.standing_bid(bid.robot, now).is_none()) else { return };
        self.bids.retain(|known| known.robot != bid.robot);
        self.bids.push(bid);
    }

    /// The last bid for `robot`.
    fn bid_for(&self, robot: RobotId) -> Option<Bid> {
        self.bids.iter().find(|bid| bid.robot == robot).copied()
    }

    /// The bid for which the present decision of `robot`, or the one being executed, is still kept at `now`.
    pub(super) fn standing_bid(&self, robot: RobotId, now: MonotonicNs) -> Option<Bid> {
        let bid = self.bid_for(robot)?;
        let grace_ns = BID_GRACE_NS.max(self.mission.brief.limits.decision_budget_ns.saturating_mul(2));
        let kept_since = bid.since.max(self.state.published);
        let open = bid.decision == self.state.decision && now.since_ns(kept_since) < grace_ns;
        (open || bid.decision > self.state.decision).then_some(bid)
    }
}
