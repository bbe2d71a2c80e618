//! One robot as it should be after some decisions.

use contract::{
    Branch, Cell, Decision, Detail, Direction, Flight, Leader, Outcome, Robot, RouteId, Standing, Travel,
    Waypoint,
};
use hopper_sim::Mission;

/// A robot after some decisions.
#[derive(Clone, Debug)]
pub(super) struct Actor {
    pub robot: Robot,
    /// Where it is; of a robot that goes from cell to cell the point where it began.
    pub at: Waypoint,
    pub cell: Cell,
    pub heading: Direction,
    /// When it is ready for its next action, nanoseconds of simulated time.
    pub clock_ns: u64,
    /// Whether it waits until another robot has acted.
    pub waits: bool,
    pub actions: u64,
    /// Actions by which it waited for others, which the limit does not count.
    pub waited: u64,
    pub standing: Standing,
    pub leader: Leader,
    /// The last decision that was its turn.
    pub last: Option<Decision>,
    /// The action at which it fails, counted from 1.
    pub fails_at: Option<u64>,
    /// What it has announced last, and when.
    pub route: Option<(RouteId, Vec<Waypoint>, Decision)>,
    /// Legs of that route that are behind it.
    pub reached: usize,
    /// The decision by which it has moved last.
    pub moved: Option<Decision>,
    /// How far it has flown in this stage, metres.
    pub flown_m: f64,
    /// The points through which it has driven in this stage, from where that began.
    pub driven: Vec<Waypoint>,
    /// Stages that it has ended, and the decision by which it ended the last.
    pub halts: u32,
    pub halted: Option<Decision>,
    /// What the motion model told of its last action, if it tells more than the outcome.
    pub told: Option<Detail>,
}

impl Actor {
    /// The robot of this number before its first action.
    pub fn begin(mission: &Mission, number: usize) -> Self {
        let robot = mission.brief.robots[number];
        let fault = mission.faults.iter().find(|fault| usize::from(fault.robot.0) == number);
        Self {
            robot,
            at: robot.start_at,
            cell: robot.start.cell,
            heading: robot.start.heading,
            clock_ns: 0,
            waits: false,
            actions: 0,
            waited: 0,
            standing: Standing::Active,
            leader: Leader::default(),
            last: None,
            fails_at: fault.map(|fault| fault.action),
            route: None,
            reached: 0,
            moved: None,
            flown_m: 0.0,
            driven: vec![robot.start_at],
            halts: 0,
            halted: None,
            told: None,
        }
    }

    /// Whether it can still act.
    pub fn is_active(&self) -> bool {
        self.standing == Standing::Active
    }

    /// Whether its next action is the one at which it fails.
    pub fn fails(&self) -> bool {
        self.fails_at == Some(self.actions + 1)
    }

    /// Its actions, those left out by which it waited.
    pub fn spent(&self) -> u64 {
        self.actions - self.waited
    }

    /// The point that it goes to next.
    pub fn next(&self) -> Option<Waypoint> {
        self.route.as_ref().and_then(|(_, points, _)| points.get(self.reached + 1)).copied()
    }

    /// How far it is on its way.
    pub fn travel(&self) -> Travel {
        Travel {
            at: self.at,
            route: self.route.as_ref().map(|(id, ..)| *id),
            announced: self.route.as_ref().map(|(.., decision)| *decision),
            reached: self.reached as u32,
            legs: self.route.as_ref().map_or(0, |(_, points, _)| points.len() as u32 - 1),
            moved: self.moved,
            halts: self.halts,
            halted: self.halted,
            flown_m: self.flown_m,
        }
    }
}

/// What an action comes to, and where it leaves a robot that goes from point to point.
pub(super) struct Arrival {
    pub outcome: Outcome,
    pub at: Waypoint,
    /// What the motion model tells beyond the outcome.
    pub detail: Option<Detail>,
}

impl Arrival {
    /// The robot stays where it is.
    pub fn stays(actor: &Actor, branch: Branch, flight: Flight) -> Self {
        let outcome = Outcome { branch, from: actor.cell, to: actor.cell, flight };
        Self { outcome, at: actor.at, detail: actor.told.as_ref().map(Detail::at_rest) }
    }
}
