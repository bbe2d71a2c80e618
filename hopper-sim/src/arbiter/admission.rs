//! Which commands are executed, and why others are not.

use contract::{Action, Announcement, Command, Leader, MonotonicNs, Refusal, RobotId, Vetoed};

use super::{Arbiter, Phase};

impl Arbiter {
    /// Keeps the points of a route.
    pub(super) fn offer(&mut self, announcement: Announcement) -> Result<(), Refusal> {
        if announcement.run != self.state.run {
            return Err(Refusal::WrongRun { need: self.state.run, got: announcement.run });
        }
        self.robots.offer(announcement)
    }

    /// Who leads once `command` is executed, if the command stands up to every check.
    pub(super) fn admit(&self, command: &Command, now: MonotonicNs) -> Result<Leader, Refusal> {
        let leader = self.judge(command, now)?;
        self.refusal_of(command.action).map_or(Ok(leader), Err)
    }

    /// Why the robot that is due shall not execute `action`, whoever commands it, if there is a reason.
    pub(crate) fn refusal_of(&self, action: Action) -> Option<Refusal> {
        self.robots.refusal(&self.mission.terrain, action)
    }

    /// Takes note of what an earlier life vetoed at the decision that is due.
    ///
    /// # Errors
    /// The first action that is not vetoed.
    pub(crate) fn recall_vetoes(&mut self, vetoed: Vetoed) -> Result<(), Action> {
        let is_vetoed =
            |action: &Action| self.refusal_of(*action).is_some_and(|refusal| refusal.vetoed().is_some());
        match Action::ALL.into_iter().filter(|action| vetoed.has(*action)).find(|action| !is_vetoed(action)) {
            Some(action) => Err(action),
            None => {
                self.state.vetoed = vetoed;
                Ok(())
            }
        }
    }

    /// Who leads once `command` is executed; or why it is not.
    fn judge(&self, command: &Command, now: MonotonicNs) -> Result<Leader, Refusal> {
        let Command { run, robot, decision, incarnation, .. } = *command;
        let need = self.state.decision;
        if run != self.state.run {
            return Err(Refusal::WrongRun { need: self.state.run, got: run });
        }
        if robot.0 >= self.robots() {
            return Err(Refusal::WrongRobot { robots: self.robots(), got: robot.0.into() });
        }
        if decision < need {
            return Err(Refusal::RepeatedDecision { need, got: decision });
        }
        if decision > need {
            return Err(Refusal::FutureDecision { need, got: decision });
        }
        if command.digest != self.state.digest {
            let (need, got) = (self.state.digest, command.digest);
            return Err(Refusal::OtherPast { decision, need, got });
        }
        if self.state.status.is_over() {
            return Err(Refusal::MissionOver);
        }
        if robot != self.due() {
            return Err(Refusal::NotDue { need: self.due(), got: robot });
        }
        let leader = self.succession(command)?;
        if !matches!(self.phase, Phase::Resting) {
            return Err(Refusal::Busy { decision: need });
        }
        match self.standing_bid(robot, now) {
            Some(bid) if bid.incarnation != incarnation => Err(Refusal::Yielding { decision: need }),
            _ => Ok(leader),
        }
    }

    /// Who leads `robot`, counting a command that is being executed.
    pub(super) fn leader(&self, robot: RobotId) -> Leader {
        self.robots.leader(robot)
    }

    /// Compare-and-swap of the term: its holder goes on, or the next one begins, whoever asks first.
    /// A term counts as begun from the acceptance of its first command, before that is committed.
    fn succession(&self, command: &Command) -> Result<Leader, Refusal> {
        let held = self.leader(command.robot);
        let (need, got) = (held.term, command.term);
        let Command { incarnation, pid, planner, .. } = *command;
        if got == need.next() {
            Ok(Leader { term: got, incarnation, pid, planner })
        } else if got > need {
            Err(Refusal::FutureTerm { need, got })
        } else if got < need {
            Err(Refusal::StaleTerm { need, got })
        } else if held != Leader::default() && (incarnation, planner) == (held.incarnation, held.planner) {
            Ok(held)
        } else {
            Err(Refusal::NotLeader { term: need })
        }
    }
}
