//! When an action that is committed has landed, and what is published then.

use contract::mission::pace::Launch;
use contract::{Control, MonotonicNs, Outcome, Record, Refusal, State};

use super::{Arbiter, Effect, Phase};
use crate::ROBOT;

impl Arbiter {
    /// Simulated time that the action just committed takes, seconds; in a team, until the next robot's turn.
    fn lasts_s(&self, outcome: &Outcome) -> f64 {
        self.robots.elapsed_s(outcome)
    }

    /// The state that `record`, committed at `committed`, leads to when it lands.
    pub(super) fn state_after(&self, record: &Record, committed: MonotonicNs) -> State {
        let lasts_s = self.lasts_s(&record.outcome);
        let launch = Launch { last_landed: self.state.landed, committed, lasts_s };
        let landed = self.throttle.landing(&launch);
        let mut next = record.state_after(self.state.run, landed, MonotonicNs(0));
        next.last_timing.committed = committed;
        next
    }

    /// Takes up the next state and publishes it, if its landing has come.
    pub(super) fn land(&mut self, now: MonotonicNs, effects: &mut Vec<Effect>) {
        let Phase::Flying(next) = &self.phase else { return };
        if now < next.landed || self.throttle.holds() {
            return;
        }
        let decision = next.decision;
        if next.visits != self.state.visits {
            self.leg_began = decision;
        }
        self.state = *next;
        self.phase = Phase::Resting;
        self.throttle.landed();
        if self.team.is_some() {
            self.team = Some(self.robots.team(&self.state));
            let due = self.due();
            for bid in self.bids.iter_mut().filter(|bid| bid.robot != due && bid.decision == decision) {
                // It is not that robot's turn: the one to come is kept.
                bid.decision = decision.next();
            }
        }
        self.sent = None;
        effects.push(self.publish(now));
    }

    /// Carries out an order: a hop in the air lands when the pace now in force has it, and a pause counts
    /// as flight, in no decision's time.
    pub(super) fn obey(&mut self, control: &Control, now: MonotonicNs) -> Result<(), Refusal> {
        let Control { run, robot, order } = *control;
        if run != self.state.run {
            return Err(Refusal::WrongRun { need: self.state.run, got: run });
        }
        if robot != ROBOT {
            return Err(Refusal::WrongRobot { robots: 1, got: robot.0.into() });
        }
        self.throttle.obey(order, now)?;
        if let Phase::Flying(next) = &self.phase {
            let mut next = *next;
            let (last_landed, committed) = (self.state.landed, next.last_timing.committed);
            let lasts_s = next.last.map_or(0.0, |outcome| self.lasts_s(&outcome));
            next.landed = self.throttle.landing_anew(&Launch { last_landed, committed, lasts_s }, now);
            self.phase = Phase::Flying(next);
        }
        Ok(())
    }

    /// The mission begins, or is taken up again where an earlier life ended: its landing is now.
    pub(super) fn take_up(&mut self, now: MonotonicNs) -> Effect {
        self.state.landed = now;
        self.publish(now)
    }

    /// Publishes the current state: stamped the first time, unchanged ever after.
    pub(super) fn publish(&mut self, now: MonotonicNs) -> Effect {
        if self.sent.is_none() {
            self.state.published = now;
        }
        self.sent = Some(now);
        Effect::Publish(self.state)
    }
}
