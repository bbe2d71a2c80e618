//! How hopper-sim has to answer each command, by the rules that docs and glossary state. A takeover that came just too late has
//! the next decision of its robot kept for it, once in a row, for a second or twice the decision budget after the state is
//! published; each robot's turn is kept by itself.

use std::collections::BTreeMap;

use contract::{Brief, Command, Decision, Digest, Incarnation, Leader, MonotonicNs, RobotId};

/// Shortest time for which a decision is kept, nanoseconds.
const KEPT_NS: u64 = 1_000_000_000;

/// The answers that are compared: those that depend on nothing but who asks, when, and for whose turn.
pub(crate) const ANSWERS: [&str; 11] = [
    "repeated_decision",
    "future_decision",
    "other_past",
    "mission_over",
    "not_due",
    "future_term",
    "stale_term",
    "not_leader",
    "busy",
    "unknown_life",
    YIELDING,
];

/// The decision is kept for another planner.
pub(crate) const YIELDING: &str = "yielding";

/// The command is executed.
pub(crate) const EXECUTED: &str = "executed";

/// How hopper-sim stands when a command comes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Standing {
    pub due: Decision,
    /// The digest of its state.
    pub digest: Digest,
    /// Whose turn that decision is.
    pub robot: RobotId,
    /// Whether the action of that decision is committed and has not landed.
    pub in_the_air: bool,
    pub is_over: bool,
    /// Who leads the robot of the command, the action in the air included.
    pub leader: Leader,
    /// When the state of the decision that is due was first published.
    pub published: MonotonicNs,
}

#[derive(Clone, Copy, Debug)]
struct Bid {
    who: Incarnation,
    decision: Decision,
    since: MonotonicNs,
}

/// The answers of one life of hopper-sim, and the turns that it keeps.
#[derive(Clone, Debug, Default)]
pub(crate) struct Reservations {
    /// The last bid for each robot.
    bids: BTreeMap<RobotId, Bid>,
    /// How often each answer had to be given.
    answers: BTreeMap<&'static str, u64>,
    /// Takeovers for which a decision was kept, and those that had let one pass before.
    pub kept: u64,
    pub slow: u64,
    /// Times that turns of two robots were kept at once.
    pub two_kept: u64,
    /// Whether this life had trouble with its journal: what it had accepted then is not known here.
    pub unsure: bool,
}

impl Reservations {
    /// How often an answer had to be given in this life.
    pub fn of(&self, answer: &str) -> u64 {
        self.answers.get(answer).copied().unwrap_or_default()
    }

    /// hopper-sim judges a command; `is_known` is whether it has heard a heartbeat of the sender, and `is_possible` whether the
    /// robot that is due could do that.
    pub fn judge(
        &mut self,
        brief: &Brief,
        command: &Command,
        (is_known, is_possible): (bool, bool),
        at: &Standing,
        now: MonotonicNs,
    ) {
        let refusal = self.refusal(brief, command, at, now);
        let answer = match refusal {
            Some(reason) => reason,
            None if !is_possible => return,
            None if !is_known => "unknown_life",
            None => EXECUTED,
        };
        *self.answers.entry(answer).or_default() += 1;
        if is_known && ["busy", "repeated_decision"].contains(&answer) {
            self.bid(brief, command, at, now);
        }
    }

    fn refusal(
        &self,
        brief: &Brief,
        command: &Command,
        at: &Standing,
        now: MonotonicNs,
    ) -> Option<&'static str> {
        let Command { robot, decision, term, incarnation, planner, .. } = *command;
        let held = at.leader.term;
        let leads = held.0 > 0 && (incarnation, planner) == (at.leader.incarnation, at.leader.planner);
        let reasons = [
            (command.run != brief.run, "wrong_run"),
            (robot.0 >= brief.robots.count(), "wrong_robot"),
            (decision < at.due, "repeated_decision"),
            (decision > at.due, "future_decision"),
            (command.digest != at.digest, "other_past"),
            (at.is_over, "mission_over"),
            (robot != at.robot, "not_due"),
            (term.0 > held.0 + 1, "future_term"),
            (term < held, "stale_term"),
            (term == held && !leads, "not_leader"),
            (at.in_the_air, "busy"),
            (self.standing(brief, robot, at, now).is_some_and(|bid| bid.who != incarnation), YIELDING),
        ];
        reasons.into_iter().find(|(applies, _)| *applies).map(|(_, reason)| reason)
    }

    /// Takes note of a takeover that is too late for one decision of its robot: the next is kept for it.
    fn bid(&mut self, brief: &Brief, command: &Command, at: &Standing, now: MonotonicNs) {
        let Command { robot, incarnation, term, .. } = *command;
        if term.0 != at.leader.term.0 + 1 || self.standing(brief, robot, at, now).is_some() {
            return;
        }
        if self.bids.get(&robot).is_some_and(|bid| bid.who == incarnation) {
            self.slow += 1;
            return;
        }
        self.kept += 1;
        let is_its_turn = robot == at.robot && !at.in_the_air;
        let decision = if is_its_turn { at.due } else { at.due.next() };
        self.bids.insert(robot, Bid { who: incarnation, decision, since: now });
        let standing = self.bids.keys().filter(|robot| self.standing(brief, **robot, at, now).is_some());
        self.two_kept += u64::from(standing.count() > 1);
    }

    /// The bid for which the turn of a robot is still kept.
    fn standing(&self, brief: &Brief, robot: RobotId, at: &Standing, now: MonotonicNs) -> Option<&Bid> {
        let kept_ns = KEPT_NS.max(2 * brief.limits.decision_budget_ns);
        let bid = self.bids.get(&robot)?;
        let since = bid.since.max(at.published);
        let is_open = bid.decision == at.due && now.0.saturating_sub(since.0) < kept_ns;
        (is_open || bid.decision > at.due).then_some(bid)
    }

    /// When the turn that is due is kept no longer, if it is kept.
    pub fn kept_until(
        &self,
        brief: &Brief,
        (due, robot): (Decision, RobotId),
        published: MonotonicNs,
    ) -> Option<MonotonicNs> {
        let kept_ns = KEPT_NS.max(2 * brief.limits.decision_budget_ns);
        let bid = self.bids.get(&robot).filter(|bid| bid.decision == due)?;
        Some(MonotonicNs(bid.since.max(published).0 + kept_ns))
    }

    /// The state of `decision` is published, which is the turn of `robot`: who waits for that of another waits on.
    pub fn landed(&mut self, decision: Decision, robot: RobotId) {
        for (of, bid) in &mut self.bids {
            if *of != robot && bid.decision == decision {
                bid.decision = decision.next();
            }
        }
    }
}
