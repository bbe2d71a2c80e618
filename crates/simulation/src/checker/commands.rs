//! Who commands, and what becomes of it.

use contract::protocol::peer_table::SILENCE_NS;
use std::rc::Rc;

use contract::{
    Action, Announcement, Command, Decision, MonotonicNs, Policy, Record, RefusalCounts, Robot, RobotId,
    State, Term,
};
use planner::pilot::DEATH_SILENCE_NS;

use super::Checker;
use crate::checker::Known;
use crate::life::Life;
use crate::reservation::{ANSWERS, EXECUTED, Reservations, Standing, YIELDING};
use crate::setup::Seat;

impl Checker {
    /// hopper-sim receives a command, and judges it before anything else happens.
    pub(crate) fn judged(&mut self, command: &Command, now: MonotonicNs) {
        let due = self.pacing.published.unwrap_or(self.pacing.began);
        if self.acquaintance.is_recognised(self.sim, command.incarnation) {
            return;
        }
        let is_known = self.acquaintance.last_heard(self.sim, command.incarnation).is_some();
        let in_the_air = self.records.len() as u64 > due.0;
        let Some(before) = self.state_at(due) else { return };
        let robot = self.records.get(due.0 as usize).map_or_else(|| self.due(), |record| record.robot);
        let at = Standing {
            due,
            digest: before.digest,
            robot,
            in_the_air,
            is_over: before.status.is_over(),
            leader: self.leader_of(command.robot),
            published: self.pacing.told,
        };
        let is_possible = !in_the_air && !at.is_over && self.is_possible(&before, command);
        let (brief, reservations) = (&self.mission.brief, &mut self.reservations);
        reservations.judge(brief, command, (is_known, is_possible), &at, now);
    }

    /// Whether the robot that is due could do that: nothing speaks against it, and the route that is announced is known.
    fn is_possible(&self, before: &State, command: &Command) -> bool {
        let (robot, action) = (command.robot, command.action);
        if self.to_veto().has(action) {
            return false;
        }
        if let Action::Announce(id) = action
            && !self.offers.has(robot, id)
            && self.model.routes().route(id).is_none()
        {
            return false;
        }
        self.model.execute(before, action).is_some()
    }

    /// hopper-sim receives the points of a route.
    pub(crate) fn offered(&mut self, announcement: &Announcement) {
        let Announcement { run, robot, route } = announcement;
        if *run == self.mission.brief.run && robot.0 < self.mission.brief.robots.count() {
            self.offers.received(*robot, route.id());
        }
    }

    /// A turn of hopper-sim ends, which has refused so many commands in its life, by reason, and executed so many.
    pub(crate) fn answered(&mut self, refused: &RefusalCounts, executed: u64) {
        if self.reservations.unsure {
            return;
        }
        let (need, got) = (self.reservations.of(YIELDING), refused.of(YIELDING));
        self.require(need == got, "a decision is kept for a late takeover, and no other", || {
            format!("{got} commands were refused in favour of a takeover, {need} had to be")
        });
        let wrong = ANSWERS.into_iter().find(|reason| refused.of(reason) != self.reservations.of(reason));
        let wrong = wrong.map(|reason| (reason, refused.of(reason), self.reservations.of(reason)));
        self.require(wrong.is_none(), "every command is answered as it has to be", || {
            format!("answer, times it was given, times it is needed: {wrong:?}")
        });
        let need = self.reservations.of(EXECUTED);
        self.require(need == executed, "every command that nothing speaks against is executed", || {
            format!("{executed} commands were executed in this life, {need} had to be")
        });
    }

    /// Whether the algorithm of a seat can plan for all its robots.
    pub(crate) fn suits(&self, seat: Seat) -> bool {
        let brief = &self.mission.brief;
        let suits = |robot: &Robot| planner::suited(brief, robot).contains(&seat.planner.as_str());
        seat.robots.of(brief.robots.count()).iter().all(|robot| brief.robots.at(robot).is_some_and(suits))
    }

    /// A planner is told to take over the robots that it serves.
    pub(crate) fn told_to_take_over(&mut self, life: &Life) {
        let is_led = |robot: &RobotId| self.leader_of(*robot).incarnation == life.incarnation;
        let robots = life.robots.of(self.mission.brief.robots.count());
        let others: Vec<RobotId> = robots.iter().filter(|robot| !is_led(robot)).collect();
        self.claims.begin(life.incarnation, &others);
    }

    /// A turn of the robot of `record`, which was committed, was not that of planners which were told to take over.
    pub(crate) fn passed_over(&mut self, record: &Record, lives: &[Rc<Life>]) {
        let (run, robot) = (self.mission.brief.run, record.robot);
        if self.mapped != Some((run, record.decision)) {
            // Nobody can plan without the map of the landing.
            return;
        }
        for life in lives {
            let who = life.incarnation;
            let is_owed = who != record.leader.incarnation && self.claims.is_owed(who, robot);
            if is_owed && life.sits_idle(run, record.decision) && self.claims.pass(who, robot) {
                self.violate("who is to take over asks for the turn of each of its robots", || {
                    format!("{who} was idle again at decision {} of robot {robot}", record.decision)
                });
            }
        }
    }

    /// Whether it is no wonder that nothing is executed at `now`: landings wait, an action is under way, or a turn is kept for
    /// another planner.
    pub(crate) fn is_quiet(&self, now: MonotonicNs) -> bool {
        let due = (Decision(self.records.len() as u64), self.due());
        let kept = self.reservations.kept_until(&self.mission.brief, due, self.pacing.told);
        self.pacing.tempo.is_quiet(now) || kept.is_some_and(|kept| now < kept)
    }

    /// hopper-sim could not write down what it had accepted.
    pub(crate) fn append_failed(&mut self) {
        self.reservations.unsure = true;
    }

    /// What decisions were kept for in this life of hopper-sim.
    pub(crate) fn reservations(&self) -> &Reservations {
        &self.reservations
    }

    /// hopper-sim receives a policy.
    pub(crate) fn advised(&mut self, policy: &Policy) {
        // One that does not fit is not kept.
        let due = self.pacing.published.unwrap_or(self.pacing.began);
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
        self.claims.settle(incarnation, robot);
        self.sent.insert((run, robot, incarnation, decision, digest, term, action.code(), action.route()));
        if leader.incarnation == incarnation && term == leader.term {
            return None;
        }
        let heard = self.acquaintance.last_heard(incarnation, leader.incarnation).map_or(0, |at| at.0);
        // Silence counts only while somebody listens, and from when it knows who leads.
        let silent_since = heard.max(since.0).max(life.listening_since.get().0);
        let limit_ns = if is_gone { DEATH_SILENCE_NS } else { SILENCE_NS };
        // What it asks for may be what it got, and has not heard of yet.
        let led = run == self.mission.brief.run
            && self.succession.has_commanded(robot, incarnation)
            && self.succession.of(robot, term) != Some(incarnation);
        let told = life.takeover && !led || self.acquaintance.handed_over.contains(&incarnation);
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
