//! The algorithm of a planner process for which nobody names one: the usual one of its robots in the mission that it finds.

use contract::{Brief, Decision, Name, RobotId, RobotSet, Role, RunId, Status};
use process::{Exit, Failure, Membership, Ports, Process, Reader as _, Terms, Turn, accept};

use crate::built_in;
use crate::names::MDP;

/// Waits until a mission is known.
pub struct UsualAlgorithm<P: Ports> {
    membership: Membership<P>,
    briefs: P::Reader<Brief>,
    robots: RobotSet,
    brief: Option<Brief>,
}

impl<P: Ports> UsualAlgorithm<P> {
    /// Joins the instance on behalf of robots, of which the first decides.
    ///
    /// # Errors
    /// If a port cannot be had.
    pub fn join(ports: &mut P, robots: RobotSet, terms: Terms) -> Result<Self, P::Error> {
        Ok(Self {
            membership: Membership::join(ports, Role::Planner, Name::NONE, terms)?,
            briefs: ports.reader(RobotId(0), false)?,
            robots,
            brief: None,
        })
    }

    /// The name of the algorithm, once the brief is known. For a robot that the mission does not have, or that no algorithm suits,
    /// it is that of a hopper, which says so.
    #[must_use]
    pub fn name(&self) -> Option<&'static str> {
        let brief = self.brief.as_ref()?;
        let robot = brief.robots.at(self.robots.iter().next()?);
        Some(robot.and_then(|robot| built_in::usual(brief, robot)).unwrap_or(MDP))
    }
}

impl<P: Ports> Process<P> for UsualAlgorithm<P> {
    /// Leaves with [`Exit::Done`] once [`UsualAlgorithm::name`] is known.
    async fn turn(&mut self, ports: &mut P) -> Result<Turn, Failure> {
        for _ in 0..self.membership.depth() {
            if self.membership.hear(ports.now()).is_none() {
                break;
            }
        }
        self.brief = accept(self.briefs.newest()).or(self.brief.take());
        if self.name().is_some() {
            return Ok(Turn::Leave(Exit::Done));
        }
        let seen = (RunId(0), Decision(0), Status::Underway);
        self.membership.close_turn(ports, seen, Some("hopper-sim: a mission to plan for"))
    }
}
