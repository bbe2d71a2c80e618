//! A rover or a hopper with helicopters as they should be: whose turn it is, which routes are known, what an action comes to, what the
//! guard lets pass, and what is seen, by code that shares nothing with the product's. What a drive takes, and which cells a
//! camera shows along a leg, is asked of the engines `rover` and `helicopter`, as a hop's outcome is of the hopper's.

use std::collections::BTreeMap;

use contract::{
    Action, Announcement, Body, Branch, Cell, Decision, Digest, Direction, DriveSpeed, Flight, Helicopter,
    Leader, Outcome, Placement, Record, Robot, RobotId, RouteId, RunId, SpeedPrior, Standing, Team, Travel,
    Waypoint,
};
use helicopter::Swath;
use hopper_sim::Mission;
use rover::{Allowance, Drive, DriveEnd, Lattice, Point, SOL_HOURS, Segment, Speed, Surface, Truth, drive};
use xxhash_rust::xxh3::xxh3_64;

use crate::expected::Shown;

mod guard;

const SECOND_NS: u64 = 1_000_000_000;

/// The longest that a rover drives in a stage which is not the last, in Sol.
const STAGE_SOL: f64 = 1.0;

/// How far a route may begin from its robot, a flight exceed its budget, and the goal be beyond its radius, metres.
pub(crate) const TOLERANCE_M: f64 = 1e-6;

/// The points of routes that planners have published: for which run and robot.
pub(crate) type Announced = BTreeMap<(RunId, RobotId, RouteId), Vec<Waypoint>>;

/// The fingerprint that a route of these points has.
pub(crate) fn fingerprint(points: &[Waypoint]) -> RouteId {
    let bytes: Vec<u8> = points
        .iter()
        .flat_map(|point| [point.x_m, point.y_m])
        .flat_map(|metres| metres.to_bits().to_le_bytes())
        .collect();
    RouteId(xxh3_64(&bytes).max(1))
}

#[derive(Clone, Debug)]
pub(crate) struct Scout {
    pub robot: Robot,
    pub at: Waypoint,
    pub cell: Cell,
    heading: Direction,
    clock_ns: u64,
    pub waits: bool,
    pub actions: u64,
    /// Actions by which it waited for others, which the limit does not count.
    pub waited: u64,
    pub standing: Standing,
    leader: Leader,
    last: Option<Decision>,
    pub fails_at: Option<u64>,
    /// What it has announced last, and when.
    route: Option<(RouteId, Vec<Waypoint>, Decision)>,
    reached: usize,
    moved: Option<Decision>,
    flown_m: f64,
    /// The points through which it has driven in this stage, from where that began.
    driven: Vec<Waypoint>,
    halts: u32,
    halted: Option<Decision>,
}

impl Scout {
    /// The point that it goes to next.
    pub fn next(&self) -> Option<Waypoint> {
        self.route.as_ref().and_then(|(_, points, _)| points.get(self.reached + 1)).copied()
    }

    fn travel(&self) -> Travel {
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

/// The robots of a mission after some decisions.
#[derive(Clone, Debug)]
pub(crate) struct Scouts {
    run: RunId,
    pub actions_max: u64,
    stages: u32,
    hazard_max: f64,
    surface: Surface,
    truth: Truth,
    prior: Vec<SpeedPrior>,
    pub scouts: Vec<Scout>,
    /// What some robot has shown of each cell, in index order.
    pub shown: Vec<Shown>,
    /// What a camera that errs reads of each cell.
    readings: Vec<Option<DriveSpeed>>,
    /// How often a camera that errs is right.
    accuracy: f64,
    /// Published by planners in any run, executed or not.
    announced: Announced,
    /// The routes that decisions have announced, in their order.
    routes: Vec<(RouteId, Vec<Waypoint>)>,
    actor: Option<usize>,
    /// When the last action began and whoever acts next is ready, nanoseconds of simulated time.
    acted_at_ns: u64,
}

/// What an action comes to, and where it leaves the robot.
pub(crate) struct Arrival {
    pub outcome: Outcome,
    at: Waypoint,
}

impl Scouts {
    /// Before the first decision.
    pub fn begin(mission: &Mission) -> Self {
        let robots = &mission.brief.robots;
        let grid = mission.brief.grid;
        let lattice = Lattice::new(grid.width as usize, grid.height as usize).expect("a grid is a lattice");
        let speeds = mission.terrain.cells.iter();
        let speeds =
            speeds.map(|ground| ground.speed.map_or(Speed::Zero, |speed| Speed::ALL[speed as usize]));
        let heights_m: Vec<f64> = mission.terrain.cells.iter().map(|ground| ground.height_m).collect();
        let scout = |(number, robot): (usize, &Robot)| {
            let fault = mission.faults.iter().find(|fault| usize::from(fault.robot.0) == number);
            Scout {
                robot: *robot,
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
            }
        };
        Self {
            run: mission.brief.run,
            actions_max: mission.brief.limits.steps_max,
            stages: mission.brief.sampling.map_or(1, |sampling| sampling.stages),
            hazard_max: mission.brief.guard.hazard_max,
            surface: Surface::from_heights(lattice, &heights_m).expect("heights of all cells"),
            truth: Truth { speeds: speeds.collect() },
            prior: mission.terrain.prior.clone(),
            scouts: robots.iter().enumerate().map(scout).collect(),
            shown: vec![Shown::Nothing; grid.cells()],
            readings: mission.terrain.cells.iter().map(|ground| ground.reading).collect(),
            accuracy: robots.iter().find_map(|robot| robot.sensor.accuracy()).unwrap_or(1.0),
            announced: Announced::new(),
            routes: Vec::new(),
            actor: None,
            acted_at_ns: 0,
        }
    }

    /// Whether that robot is a hopper.
    pub fn is_hopper(&self, robot: RobotId) -> bool {
        let scout = self.scouts.get(usize::from(robot.0));
        scout.is_some_and(|scout| scout.robot.body.hops())
    }

    /// Who acts next; once nobody does, who acted last.
    pub fn due(&self) -> RobotId {
        RobotId(self.next().or(self.actor).unwrap_or_default() as u16)
    }

    pub fn next(&self) -> Option<usize> {
        let can_act = |number: &usize| {
            let scout = &self.scouts[*number];
            scout.standing == Standing::Active && !scout.waits
        };
        (0..self.scouts.len()).filter(can_act).min_by_key(|&number| (self.scouts[number].clock_ns, number))
    }

    /// Whether nobody acts next because all that still could wait for each other.
    pub fn is_all_waiting(&self) -> bool {
        self.next().is_none() && self.scouts.iter().any(|scout| scout.waits)
    }

    pub fn leader(&self, robot: RobotId) -> Leader {
        self.scouts.get(usize::from(robot.0)).map_or(Leader::default(), |scout| scout.leader)
    }

    /// What some robot has shown of each cell.
    pub fn shown(&self) -> &[Shown] {
        &self.shown
    }

    /// Stages that are over.
    pub fn halts(&self) -> u32 {
        self.scouts.iter().map(|scout| scout.halts).max().unwrap_or_default()
    }

    /// Whether `robot` has moved since the last stage ended.
    pub fn has_moved_in_stage(&self, robot: RobotId) -> bool {
        let ended = self.scouts.iter().filter_map(|scout| scout.halted).max();
        self.scouts.get(usize::from(robot.0)).is_some_and(|scout| scout.moved > ended)
    }

    /// Whether a cell was read wrong, and no rover has been there since.
    pub fn has_misreadings(&self) -> bool {
        let mut cells = self.shown.iter().zip(&self.readings).zip(&self.truth.speeds);
        cells.any(|((shown, reading), truth)| {
            *shown == Shown::Reading && reading.is_some_and(|reading| Speed::ALL[reading as usize] != *truth)
        })
    }

    /// The routes that decisions have announced, in their order.
    pub fn routes(&self) -> &[(RouteId, Vec<Waypoint>)] {
        &self.routes
    }

    /// The points of a route that some decision has announced.
    pub fn route(&self, id: RouteId) -> Option<&[Waypoint]> {
        self.routes.iter().find(|(known, _)| *known == id).map(|(_, points)| points.as_slice())
    }

    /// Whether some planner has published that route in the run.
    pub fn is_announced(&self, run: RunId, id: RouteId) -> bool {
        self.announced.keys().any(|(of, _, known)| (*of, *known) == (run, id))
    }

    /// A planner publishes the points of a route.
    pub fn announce(&mut self, announcement: &Announcement) {
        let Announcement { run, robot, route } = announcement;
        let points = route.waypoints().to_vec();
        self.announced.insert((*run, *robot, fingerprint(&points)), points);
    }

    /// Keeps what planners have published, though decisions are taken back or another mission begins.
    pub fn keep_announced(&mut self, before: &Self) {
        self.announced.extend(before.announced.clone());
    }

    /// Simulated time from the beginning of the last action to that of the next, nanoseconds.
    pub fn lasts_ns(&self) -> u64 {
        let next = self.next().or(self.actor).map(|number| self.scouts[number].clock_ns);
        next.map_or(0, |next_ns| next_ns.saturating_sub(self.acted_at_ns))
    }

    pub fn arrival(&self, number: usize, action: Action) -> Arrival {
        let scout = &self.scouts[number];
        let from = scout.cell;
        let arrival = |branch, at: Waypoint, to: Cell, (range_m, flight_time_s)| {
            let flight = Flight { range_m, flight_time_s, flights: 1, ..Flight::default() };
            Arrival { outcome: Outcome { branch, from, to, flight }, at }
        };
        if scout.fails_at == Some(scout.actions + 1) {
            return arrival(Branch::Stranded, scout.at, from, (0.0, 1.0));
        }
        match (action, scout.next(), scout.robot.body) {
            (Action::Drive, Some(to), _) => {
                let drive = self.leg(number, to);
                let took = (drive.length_m, drive.duration_sol * SOL_HOURS * 3600.0);
                let at = Waypoint { x_m: drive.at.x_m, y_m: drive.at.y_m };
                match drive.end {
                    DriveEnd::Stuck { .. } => arrival(Branch::Stranded, at, self.cell(at), took),
                    DriveEnd::OutOfTime => arrival(Branch::Halted, at, self.cell(at), took),
                    DriveEnd::Arrived => arrival(Branch::Intended, to, self.cell(to), took),
                }
            }
            (Action::Fly, Some(to), Body::Helicopter(Helicopter { speed_mps, .. })) => {
                let range_m = point(scout.at).distance_m(point(to));
                arrival(Branch::Intended, to, self.cell(to), (range_m, range_m / speed_mps))
            }
            (Action::Wait | Action::Done, ..) => arrival(Branch::Held, scout.at, from, (0.0, 0.0)),
            _ => arrival(Branch::Held, scout.at, from, (0.0, 1.0)),
        }
    }

    /// The drive of a rover to its next point: in all stages but the last, as far as it comes within a Sol from where the stage
    /// began.
    fn leg(&self, number: usize, to: Waypoint) -> Drive {
        let scout = &self.scouts[number];
        let driven: Vec<Point> = scout.driven.iter().copied().map(point).collect();
        let before = drive(&self.surface, &self.truth, &driven, Allowance::UNLIMITED);
        let is_last = scout.halts + 1 >= self.stages;
        let limit_sol = if is_last { f64::INFINITY } else { STAGE_SOL };
        let allowance = Allowance { used_sol: before.duration_sol, limit_sol };
        drive(&self.surface, &self.truth, &[point(scout.at), point(to)], allowance)
    }

    pub fn cell(&self, at: Waypoint) -> Cell {
        let (cell, width) = (self.surface.lattice().cell(point(at)), self.surface.lattice().width());
        Cell::new((cell % width) as i32, (cell / width) as i32)
    }

    /// Takes note of who has commanded the robot of `record`, and of the route that it announces.
    pub fn note(&mut self, record: &Record) {
        let number = usize::from(record.robot.0);
        if let Action::Announce(id) = record.action
            && let Some(points) = self.points(number, id).map(<[Waypoint]>::to_vec)
        {
            self.routes.push((id, points));
        }
        (self.scouts[number].leader, self.scouts[number].last) = (record.leader, Some(record.decision));
    }

    /// The action of a robot that goes from cell to cell has come to `outcome`, which was compared.
    pub fn in_cells(&mut self, number: usize, action: Action, outcome: &Outcome) {
        self.actor = Some(number);
        let scout = &mut self.scouts[number];
        (self.acted_at_ns, scout.cell) = (scout.clock_ns, outcome.to);
        scout.actions += 1;
        if outcome.branch == Branch::Stranded {
            scout.standing = Standing::Stranded;
        } else if action == Action::Wait {
            (scout.waits, scout.waited) = (true, scout.waited + 1);
            return;
        } else if let Action::Step(heading) = action {
            scout.heading = heading;
        }
        let seconds = outcome.flight.flight_time_s * f64::from(outcome.flight.flights);
        self.busy(number, seconds);
    }

    /// A robot is busy for so long; whoever waits for somebody to act waits no longer than that.
    fn busy(&mut self, number: usize, seconds: f64) {
        self.scouts[number].clock_ns += ((seconds * 1e9).round() as u64).max(SECOND_NS);
        let ended_ns = self.scouts[number].clock_ns;
        for waiting in self.scouts.iter_mut().filter(|scout| scout.waits) {
            (waiting.waits, waiting.clock_ns) = (false, waiting.clock_ns.max(ended_ns));
        }
    }

    pub fn act(&mut self, number: usize, decision: Decision, action: Action) {
        let Arrival { outcome, at } = self.arrival(number, action);
        let has_failed = outcome.branch == Branch::Stranded && outcome.flight.range_m == 0.0;
        if !has_failed {
            self.look(number, action);
        }
        let points = match action {
            Action::Announce(id) => self.points(number, id).map(|points| (id, points.to_vec(), decision)),
            _ => None,
        };
        self.actor = Some(number);
        let scout = &mut self.scouts[number];
        self.acted_at_ns = scout.clock_ns;
        scout.actions += 1;
        if outcome.branch == Branch::Stranded {
            scout.standing = Standing::Stranded;
        } else if outcome.branch == Branch::Halted {
            scout.driven = vec![at];
            (scout.moved, scout.halted, scout.halts) = (Some(decision), Some(decision), scout.halts + 1);
        } else {
            match action {
                Action::Wait => {
                    (scout.waits, scout.waited) = (true, scout.waited + 1);
                    return;
                }
                Action::Done => {
                    scout.standing = gave_up(&scout.robot);
                    return;
                }
                Action::Announce(_) => (scout.route, scout.reached) = (points, 0),
                Action::Drive | Action::Fly => {
                    (scout.reached, scout.moved) = (scout.reached + 1, Some(decision));
                    scout.driven.push(at);
                    if action == Action::Fly {
                        scout.flown_m += outcome.flight.range_m;
                    }
                }
                _ => {}
            }
        }
        (scout.at, scout.cell) = (at, outcome.to);
        self.busy(number, outcome.flight.flight_time_s);
        if outcome.branch == Branch::Halted {
            self.gather(number);
        }
    }

    /// A stage has ended: all helicopters that still act are with the rover, fresh, and act no earlier than it.
    fn gather(&mut self, rover: usize) {
        let Scout { at, cell, clock_ns, .. } = self.scouts[rover];
        for scout in &mut self.scouts {
            let flies = matches!(scout.robot.body, Body::Helicopter(_));
            if flies && scout.standing == Standing::Active {
                (scout.at, scout.cell, scout.clock_ns) = (at, cell, scout.clock_ns.max(clock_ns));
                (scout.route, scout.reached, scout.flown_m) = (None, 0, 0.0);
            }
        }
    }

    /// What a robot sees on the way to its next point.
    fn look(&mut self, number: usize, action: Action) {
        let Scout { robot, at, .. } = self.scouts[number];
        let Some(to) = self.scouts[number].next() else { return };
        let cells: Vec<usize> = match (action, robot.sensor.view_m()) {
            (Action::Drive, _) => self.leg(number, to).sensed,
            (Action::Fly, Some(radius_m)) => {
                let leg = Segment { from: point(at), to: point(to) };
                let lattice = self.surface.lattice();
                Swath::new(lattice, leg, radius_m).cells(lattice).collect()
            }
            _ => return,
        };
        for cell in cells {
            if robot.sensor.accuracy().is_none() {
                self.shown[cell] = Shown::Truth;
            } else if self.shown[cell] == Shown::Nothing {
                self.shown[cell] = Shown::Reading;
            }
        }
    }

    /// The message about all robots as of the state of `decision` with `digest`.
    pub fn team(&self, run: RunId, decision: Decision, digest: Digest) -> Team {
        let member = |scout: &Scout| contract::Member {
            at: Placement { cell: scout.cell, heading: scout.heading },
            ready_at_ns: scout.clock_ns,
            standing: scout.standing,
            waits: scout.waits,
            leader: scout.leader,
            last: scout.last,
            travel: scout.robot.body.along_route().map(|_| scout.travel()),
        };
        let members = self.scouts.iter().map(member).collect();
        let actor = self.actor.map(|actor| RobotId(actor as u16));
        Team { run, decision, digest, due: self.due(), actor, members }
    }

    /// Where the robot that is due stands, and how far it may still fly; `None` if that is the rover.
    pub fn due_at(&self) -> (Waypoint, Option<f64>) {
        let scout = &self.scouts[usize::from(self.due().0)];
        let left_m = match scout.robot.body {
            Body::Helicopter(Helicopter { budget_m, .. }) => Some(budget_m - scout.flown_m),
            Body::Hopper(_) | Body::Rover(_) | Body::Driver(_) => None,
        };
        (scout.at, left_m)
    }
}

/// How a robot stands that acts no more by its own choice: a helicopter's task is never done.
pub(crate) fn gave_up(robot: &Robot) -> Standing {
    if robot.body.is_on_ground() { Standing::GaveUp } else { Standing::Done }
}

pub(crate) fn point(at: Waypoint) -> Point {
    Point::new(at.x_m, at.y_m)
}
