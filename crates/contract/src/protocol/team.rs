//! The robots of a mission that is not a single hopper's, at one decision: where each of them stands, and who commands it.
//! [`crate::Brief::robots`] says what they are.
//!
//! A decision of such a mission is the turn of one robot. [`crate::State`] tells of the robot that acted last; a [`Team`],
//! published with it, of all of them. In a hopper's mission pose, steps, visits and treasures of a state are the hopper's,
//! whoever acted.

use std::fmt;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::{
    Decision, Digest, Incarnation, Leader, Placement, Robot, RobotId, RobotSet, Route, RouteId, RunId, State,
    Waypoint,
};

/// Whether a robot takes turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Standing {
    /// It acts when its turn comes.
    Active,
    /// Its part of the mission is done.
    Done,
    /// It has failed: it stays where it is and still occupies its cell.
    Stranded,
    /// It acts no more although its goal is not reached: it found no way, or has used up its actions. A helicopter, whose goal
    /// is never reached, is [`Done`](Self::Done) then.
    GaveUp,
}

impl Standing {
    /// Every standing, in the order of their wire codes.
    pub const ALL: [Standing; 4] = [Standing::Active, Standing::Done, Standing::Stranded, Standing::GaveUp];

    /// The code on the wire.
    #[must_use]
    pub fn code(self) -> u32 {
        self as u32 + 1
    }

    /// The standing of a wire code, if there is one.
    #[must_use]
    pub fn from_code(code: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|standing| standing.code() == code)
    }
}

impl fmt::Display for Standing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Standing::Active => "active",
            Standing::Done => "done",
            Standing::Stranded => "stranded",
            Standing::GaveUp => "gave up",
        })
    }
}

/// A robot at one decision.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Member {
    /// Cell and heading after its last action.
    pub at: Placement,
    /// From when on it is ready to act, nanoseconds of simulated time since the mission began.
    pub ready_at_ns: u64,
    /// Whether it takes turns.
    pub standing: Standing,
    /// Whether it waits for another robot to act.
    #[serde(default)]
    pub waits: bool,
    /// Who commands it. Terms are counted for each robot.
    pub leader: Leader,
    /// Its last decision; `None` before its first.
    pub last: Option<Decision>,
    /// How far it is on its way, if it goes from point to point.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub travel: Option<Travel>,
}

impl Member {
    /// A robot before its first action, which nobody commands. It has no travel yet, even if it goes from point to point.
    #[must_use]
    pub fn at_start(robot: &Robot) -> Self {
        Self {
            at: robot.start,
            ready_at_ns: 0,
            standing: Standing::Active,
            waits: false,
            leader: Leader::default(),
            last: None,
            travel: None,
        }
    }
}

/// How far a robot is on its way that goes from point to point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Travel {
    /// Where it is, exactly.
    pub at: Waypoint,
    /// The route that it announced last.
    pub route: Option<RouteId>,
    /// The decision by which it announced that.
    pub announced: Option<Decision>,
    /// Points of that route that it has reached after the first.
    pub reached: u32,
    /// Points of that route after the first.
    pub legs: u32,
    /// Its last drive or flight.
    pub moved: Option<Decision>,
    /// Drives that ended because the time of their stage was used up: it is in stage `halts` + 1.
    pub halts: u32,
    /// The last decision whose drive the end of a stage cut short; its present stage began with it.
    pub halted: Option<Decision>,
    /// Length of its flights in this stage, metres.
    pub flown_m: f64,
}

impl Travel {
    /// Before its first action.
    #[must_use]
    pub fn from_start(at: Waypoint) -> Self {
        Self {
            at,
            route: None,
            announced: None,
            reached: 0,
            legs: 0,
            moved: None,
            halts: 0,
            halted: None,
            flown_m: 0.0,
        }
    }

    /// Where it is, and the points of `route`, which it follows, that it has not reached.
    pub fn rest<'a>(&self, route: &'a Route) -> impl Iterator<Item = Waypoint> + 'a {
        let ahead = route.waypoints().get(self.reached as usize + 1..).unwrap_or_default();
        std::iter::once(self.at).chain(ahead.iter().copied())
    }

    /// Whether it has not driven in its present stage.
    #[must_use]
    pub fn is_stage_fresh(&self) -> bool {
        self.moved == self.halted
    }

    /// Whether its route has another point to go to.
    #[must_use]
    pub fn is_under_way(&self) -> bool {
        self.reached < self.legs
    }
}

/// All robots at one decision: published with the state of that decision.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Team {
    /// Run it belongs to; whoever follows another run refuses it.
    pub run: RunId,
    /// The decision that is due.
    pub decision: Decision,
    /// Digest of the state that it was published with.
    pub digest: Digest,
    /// The robot that acts next; once the mission is over, the one that acted last.
    pub due: RobotId,
    /// The robot that took the last decision; `None` at decision 0.
    pub actor: Option<RobotId>,
    /// In the order of the robots' numbers, 1 to [`crate::limits::ROBOTS_MAX`]. Shared: a team is published at every decision, and
    /// copied for each reader.
    pub members: Arc<[Member]>,
}

impl Team {
    /// Whether it tells of the same moment as `state`.
    #[must_use]
    #[inline]
    pub fn is_of(&self, state: &State) -> bool {
        (&self.decision, &self.run, &self.digest) == (&state.decision, &state.run, &state.digest)
    }

    /// The robot of that number, if the mission has it.
    #[must_use]
    pub fn member(&self, robot: RobotId) -> Option<&Member> {
        self.members.get(usize::from(robot.0))
    }

    /// What of it follows from the past that its digest names: all but who commands the robots. As
    /// [`State::of_its_past`].
    #[must_use]
    pub fn of_its_past(&self) -> Self {
        let member = |member: &Member| {
            let Member { at, ready_at_ns, standing, waits, leader: _, last, travel } = *member;
            Member { at, ready_at_ns, standing, waits, leader: Leader::default(), last, travel }
        };
        let Self { run, decision, digest, due, actor, ref members } = *self;
        Self { run, decision, digest, due, actor, members: members.iter().map(member).collect() }
    }

    fn numbered(&self) -> impl Iterator<Item = (RobotId, &Member)> {
        (0..).map(RobotId).zip(self.members.iter())
    }

    /// The robots that still act.
    #[must_use]
    pub fn acting(&self) -> RobotSet {
        let acting = self.numbered().filter(|(_, member)| member.standing == Standing::Active);
        acting.fold(RobotSet::NONE, |set, (robot, _)| set.with(robot))
    }

    /// The last route that each robot announced, with the decision and the robot.
    pub fn announced(&self) -> impl Iterator<Item = ((Decision, RobotId), RouteId)> + '_ {
        self.numbered().filter_map(|(robot, member)| {
            let travel = member.travel.as_ref()?;
            Some(((travel.announced?, robot), travel.route?))
        })
    }

    /// The robots that a life commands.
    pub fn led_by(&self, life: Incarnation) -> impl Iterator<Item = RobotId> + '_ {
        self.numbered().filter(move |(_, member)| member.leader.incarnation == life).map(|(robot, _)| robot)
    }
}
