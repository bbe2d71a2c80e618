//! Who commands, and what becomes of it.

use contract::protocol::peer_table::SILENCE_NS;
use contract::{Command, Decision, MonotonicNs, Policy, Term};
use planner::pilot::DEATH_SILENCE_NS;

use super::Checker;
use crate::checker::Known;
use crate::life::Life;
use crate::reservation::Reservations;
use crate::reservation::Standing;

impl Checker {
    /// hopper-sim receives a command, and judges it before anything else happens.
    pub(crate) fn judged(&mut self, command: &Command, now: MonotonicNs) {
        let Some(due) = self.pacing.published.or(Some(Decision(self.records.len() as u64))) else { return };
        if self.recognised.contains(&(self.sim, command.incarnation)) {
            return;
        }
        let is_known = self.heard.contains_key(&(self.sim, command.incarnation));
        let in_the_air = self.records.len() as u64 > due.0;
        let Some(before) = self.state_at(due) else { return };
        let at = Standing {
            due,
            digest: before.digest,
            in_the_air,
            is_over: before.status.is_over(),
            leader: self.leader(),
            published: self.pacing.told,
        };
        self.reservations.judge(&self.mission.brief, command, is_known, &at, now);
    }

    /// A turn of hopper-sim ends, after `yielded` refusals in favour of a takeover in its life.
    pub(crate) fn yielded(&mut self, yielded: u64) {
        let need = self.reservations;
        self.require(
            need.unsure || need.yielded == yielded,
            "a decision is kept for a late takeover, and no other",
            || format!("{yielded} commands were refused in favour of a takeover, {} had to be", need.yielded),
        );
    }

    /// hopper-sim could not write down what it had accepted.
    pub(crate) fn append_failed(&mut self) {
        self.reservations.unsure = true;
    }

    /// What decisions were kept for in this life of hopper-sim.
    pub(crate) fn reservations(&self) -> Reservations {
        self.reservations
    }

    /// hopper-sim receives a policy.
    pub(crate) fn advised(&mut self, policy: &Policy) {
        // One that does not fit is not kept.
        let due = self.pacing.published.unwrap_or(Decision(self.records.len() as u64));
        if policy.run == self.mission.brief.run && policy.decision <= due.next() {
            self.policy = Some((policy.run, policy.planner, policy.decision));
        }
    }

    /// A planner sends a command, knowing who leads. Says what it takes over for, if it does.
    pub(crate) fn sent(
        &mut self,
        command: &Command,
        life: &Life,
        known: Known,
        now: MonotonicNs,
    ) -> Option<&'static str> {
        let Command { run, robot, incarnation, decision, digest, term, action, .. } = *command;
        let Known { leader, since, is_gone } = known;
        self.announced_before(command);
        self.decides(command);
        self.sent.insert((run, robot, incarnation, decision, digest, term, action.code(), action.route()));
        if leader.incarnation == incarnation && term == leader.term {
            return None;
        }
        let heard = self.heard.get(&(incarnation, leader.incarnation)).map_or(0, |&(_, at)| at.0);
        // Silence counts only while somebody listens, and from when it knows who leads.
        let silent_since = heard.max(since.0).max(life.listening_since.get().0);
        let limit_ns = if is_gone { DEATH_SILENCE_NS } else { SILENCE_NS };
        // What it asks for may be what it got, and has not heard of yet.
        let led = run == self.mission.brief.run
            && self.commanders.contains(&(robot, incarnation))
            && self.terms.get(&(robot, term)) != Some(&incarnation);
        let told = life.takeover && !led || self.handed_over.contains(&incarnation);
        let cause = if leader.term == Term(0) {
            Some("vacancy")
        } else if told {
            Some("order")
        } else if life.succeeds_pid == Some(leader.pid) {
            Some("succession")
        } else if now.0.saturating_sub(silent_since) > limit_ns {
            Some("silence")
        } else {
            None
        };
        self.require(
            cause.is_some() && term == leader.term.next(),
            "nobody takes over without a cause",
            || format!("{incarnation} asks for term {term} after {}, whose leader beats", leader.term),
        );
        cause
    }
}
