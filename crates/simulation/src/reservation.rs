//! For whom hopper-sim keeps a decision, by the rule that docs and glossary state: a takeover that came just too late has the
//! next decision kept for it, once in a row, for a second or twice the decision budget after the state is published.

use contract::{Brief, Command, Decision, Digest, Incarnation, Leader, MonotonicNs};

/// Shortest time for which a decision is kept, nanoseconds.
const KEPT_NS: u64 = 1_000_000_000;

/// How hopper-sim stands when a command comes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Standing {
    pub due: Decision,
    /// The digest of its state.
    pub digest: Digest,
    /// Whether the hop of that decision is committed and in the air.
    pub in_the_air: bool,
    pub is_over: bool,
    /// Who leads, the hop in the air included.
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

/// The reservation of one life of hopper-sim.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Reservations {
    bid: Option<Bid>,
    /// Commands that had to be refused because the decision was kept for another.
    pub yielded: u64,
    /// Takeovers for which a decision was kept, and those that had let one pass before.
    pub kept: u64,
    pub slow: u64,
    /// Whether this life had trouble with its journal: what it had accepted then is not known here.
    pub unsure: bool,
}

impl Reservations {
    /// hopper-sim judges a command; `is_known` is whether it has heard a heartbeat of the sender.
    pub fn judge(
        &mut self,
        brief: &Brief,
        command: &Command,
        is_known: bool,
        at: &Standing,
        now: MonotonicNs,
    ) {
        if command.run != brief.run || command.robot.0 != 0 {
            return;
        }
        let kept_ns = KEPT_NS.max(2 * brief.limits.decision_budget_ns);
        let is_open = |bid: &Bid| {
            bid.decision > at.due
                || bid.decision == at.due && now.0.saturating_sub(bid.since.0.max(at.published.0)) < kept_ns
        };
        let standing = self.bid.filter(is_open);
        let takes_over = command.term.0 == at.leader.term.0 + 1;
        let leads = at.leader.term.0 > 0
            && command.term == at.leader.term
            && (command.incarnation, command.planner) == (at.leader.incarnation, at.leader.planner);
        let is_due = command.decision == at.due && command.digest == at.digest && !at.is_over;
        if is_due && !at.in_the_air && (takes_over || leads) {
            self.yielded += u64::from(standing.is_some_and(|bid| bid.who != command.incarnation));
        }
        let is_late = command.decision < at.due || is_due && at.in_the_air;
        if is_late && takes_over && is_known && standing.is_none() {
            if self.bid.is_some_and(|bid| bid.who == command.incarnation) {
                self.slow += 1;
                return;
            }
            self.kept += 1;
            let decision = if at.in_the_air { at.due.next() } else { at.due };
            self.bid = Some(Bid { who: command.incarnation, decision, since: now });
        }
    }
}
