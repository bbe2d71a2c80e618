//! The algorithm of a planner process for which nobody names one: the usual one of its robots in the mission that it finds.

use contract::{Brief, Decision, Name, RobotId, RobotSet, Role, RunId, Status, Team};
use process::{Exit, Failure, Membership, Ports, Process, Reader as _, Terms, Turn, accept};

use crate::names::{self, MDP};

/// Waits until a mission is known. From the brief on it stands for its robots, since there is an algorithm for each: hopper-sim tells
/// what they are once every robot that is due has a planner.
pub struct UsualAlgorithm<P: Ports> {
    membership: Membership<P>,
    briefs: P::Reader<Brief>,
    teams: P::Reader<Team>,
    robots: RobotSet,
    brief: Option<Brief>,
    team: Option<Team>,
}

impl<P: Ports> UsualAlgorithm<P> {
    /// Joins the instance on behalf of robots, of which the first decides.
    ///
    /// # Errors
    /// If a port cannot be had.
    pub fn join(ports: &mut P, robots: RobotSet, terms: Terms) -> Result<Self, P::Error> {
        let of_all = RobotId(0);
        Ok(Self {
            membership: Membership::join(ports, Role::Planner, Name::NONE, terms)?,
            briefs: ports.reader(of_all, false)?,
            teams: ports.reader(of_all, false)?,
            robots,
            brief: None,
            team: None,
        })
    }

    /// The name of the algorithm, once brief and, where there are several robots, team are known. For a robot that the mission does
    /// not have it is that of a hopper, which says so.
    #[must_use]
    pub fn name(&self) -> Option<&'static str> {
        let brief = self.brief.as_ref()?;
        let robot = self.robots.iter().next()?;
        if !brief.has_team() || robot.0 >= brief.robots {
            return Some(MDP);
        }
        let team = self.team.as_ref().filter(|team| team.run == brief.run)?;
        Some(names::usual(brief, team.member(robot).map(|member| member.robot.vehicle)))
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
        self.team = accept(self.teams.newest()).or(self.team.take());
        if self.name().is_some() {
            return Ok(Turn::Leave(Exit::Done));
        }
        if self.brief.is_some() {
            self.membership.tell_robots(self.robots);
        }
        let seen = (RunId(0), Decision(0), Status::Underway);
        self.membership.close_turn(ports, seen, Some("hopper-sim: a mission to plan for"))
    }
}
