//! What a command comes to, and what is done where none comes in time.

use contract::{Account, Action, Brief, Command, Leader, MonotonicNs, Origin, Policy, Record, State, Timing};

use super::{Arbiter, Effect, Phase};
use crate::Execution;
use crate::ROBOT;
use crate::guard::Fallback;

impl Arbiter {
    /// The record that an admitted command leads to, outcome drawn.
    pub(super) fn execute(&mut self, command: &Command, leader: Leader, now: MonotonicNs) -> Record {
        let state = &self.state;
        let timing = Timing {
            landed: state.landed,
            state_published: state.published,
            sensed: command.sensed,
            map_published: command.map_published,
            planning_started: command.planning_started,
            planning_ended: command.planning_ended,
            accepted: now,
            committed: now,
        };
        let mut record = self.record(leader, command.action, Origin::Planner, timing);
        (record.observation, record.work, record.cut) = (command.observation, command.work, command.cut);
        record
    }

    /// The record of `action`, its outcome drawn; nothing in it that only a planner knows.
    fn record(&mut self, leader: Leader, action: Action, origin: Origin, timing: Timing) -> Record {
        let state = &self.state;
        let (robot, execution) = self.robots.execute(&self.mission, state, leader, action);
        let Execution { outcome, pose, detail, collected, steps, visits, status } = execution;
        let mut record = Record {
            robot,
            decision: state.decision,
            leader,
            action,
            origin,
            vetoed: state.vetoed,
            observation: 0,
            work: 0,
            cut: false,
            outcome,
            pose,
            detail,
            collected,
            steps,
            visits,
            status,
            timing,
            previous: state.digest,
            digest: state.digest,
        };
        record.digest = record.previous.chain(&record);
        record
    }

    /// Whether the fallback may follow a policy.
    pub(crate) fn follows_policies(&self) -> bool {
        self.robots.follows_policies()
    }

    /// What is done at the deadline.
    pub(crate) fn fallback(&self) -> Fallback {
        let policy = if self.follows_policies() { self.policy() } else { None };
        self.robots.fallback(&self.mission.terrain, self.state.visits, policy)
    }

    /// When the fallback acts, unless a command is accepted before; `None` if it does not.
    pub(super) fn deadline(&self) -> Option<MonotonicNs> {
        let deadline_ns = self.mission.brief.guard.deadline_ns;
        let waits = matches!(self.phase, Phase::Resting) && !self.state.status.is_over();
        (deadline_ns > 0 && self.deadlines && waits && self.sent.is_some())
            .then(|| self.state.published.plus_ns(deadline_ns))
    }

    /// Acts in the planner's stead. Who commands goes on commanding: the term stays.
    pub(super) fn fall_back(&mut self, Fallback { action, origin }: Fallback, now: MonotonicNs) -> Effect {
        let State { landed, published, .. } = self.state;
        let leader = self.leader(self.due());
        let timing =
            Timing { landed, state_published: published, accepted: now, committed: now, ..Timing::default() };
        let record = self.record(leader, action, origin, timing);
        self.commit(record)
    }

    pub(super) fn keep(&mut self, policy: Policy) {
        let Brief { run, guard, grid, .. } = self.mission.brief;
        let fits = policy.run == run && policy.robot == ROBOT && policy.cells.len() == grid.cells();
        // A policy leads to one goal, and each of several hoppers has its own.
        let fits = fits && self.mission.brief.account == Account::Hopper;
        if guard.deadline_ns > 0 && fits && policy.decision <= self.state.decision.next() {
            self.policy = Some(policy);
        }
    }

    /// The last policy of the algorithm in command, unless it leads to a goal that has been visited since.
    fn policy(&self) -> Option<&Policy> {
        let leads_here = |policy: &&Policy| policy.decision >= self.leg_began;
        let in_command = self.leader(ROBOT).planner;
        self.policy.as_ref().filter(|policy| policy.planner == in_command).filter(leads_here)
    }

    pub(super) fn commit(&mut self, record: Record) -> Effect {
        self.phase = Phase::Committing(record);
        Effect::Append(record)
    }
}
