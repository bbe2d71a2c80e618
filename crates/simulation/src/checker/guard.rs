//! What the guard vetoes, and what the fallback does at the deadline.

use contract::{Action, Leader, Origin, Record, State, Vetoed};

use super::Checker;
use crate::model::Follows;

impl Checker {
    /// hopper-sim has executed a command just now.
    pub(crate) fn executed(&mut self, record: &Record) {
        if let Action::Announce(_) = record.action {
            self.offers.announced(record.robot);
        }
        let leader = record.leader.incarnation;
        // The fallback leaves the command with whom it was.
        let refused = !record.origin.is_fallback() && self.acquaintance.foreign.contains(&leader);
        self.require(!refused, "a process of another build is not obeyed", || {
            format!("decision {} was commanded by {leader}, which is of another build", record.decision)
        });
        let follows = self.model.follows(record.robot);
        self.require(
            !(follows == Follows::Nothing && record.origin == Origin::Policy),
            "no policy is followed where robots have goals of their own",
            || format!("decision {} followed one", record.decision),
        );
        if record.origin == Origin::Policy && follows == Follows::Policy {
            // The decision after that which reached the last goal.
            let visits = self.records.last().map_or(0, |last| last.visits);
            let leg_began = self.records.iter().position(|record| record.visits == visits);
            let leg_began = if visits == 0 { 0 } else { leg_began.map_or(0, |index| index as u64 + 1) };
            let policy = self.policy;
            let run = self.mission.brief.run;
            let leads_here = policy.is_some_and(|(of, planner, decision)| {
                of == run && planner == record.leader.planner && decision.0 >= leg_began
            });
            self.require(leads_here, "the fallback follows a policy for the goal in force", || {
                format!("decision {} followed {policy:?}; its leg began at {leg_began}", record.decision)
            });
        }
    }

    /// Actions that the guard should veto, from what is seen so far.
    pub(super) fn to_veto(&self) -> Vetoed {
        self.model.vetoed(self.maps.expected.cells())
    }

    /// The guard did its duty at the decision of `record`, and no more.
    pub(super) fn guarded(&mut self, before: &State, record: &Record) {
        let (due, action) = (record.decision, record.action);
        let need = self.to_veto();
        self.require(!need.has(action), "nothing dangerous is executed", || {
            format!("decision {due} was {action} from {}", before.pose.cell)
        });
        self.require(
            record.vetoed.union(need) == need,
            "only what is seen to be dangerous is vetoed",
            || format!("decision {due}: {:?} were vetoed, {need:?} are dangerous", record.vetoed),
        );
    }

    /// The fallback acted when it should, and left the command where it was.
    pub(super) fn fell_back(&mut self, leader: Leader, record: &Record) {
        let deadline_ns = self.mission.brief.guard.deadline_ns;
        let timing = &record.timing;
        let waited_ns = timing.accepted.since_ns(timing.state_published);
        let due = deadline_ns > 0 && waited_ns >= deadline_ns && record.leader == leader;
        self.require(due, "nobody falls back before the deadline", || {
            format!("decision {} after {waited_ns} of {deadline_ns} ns", record.decision)
        });
        let need = self.model.fallback(self.maps.expected.cells(), self.to_veto());
        let Some(need) = need else { return };
        let got = (record.action, record.origin);
        self.require(got == need, "at the deadline a robot goes on along its way, or holds", || {
            format!("decision {} was {got:?}, needs {need:?}", record.decision)
        });
    }
}
