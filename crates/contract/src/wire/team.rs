//! Header and cell of `hop/team`.

use bytemuck::Zeroable;

use super::LeaderV1;
use super::codec::{
    ANY, CELL, COUNTED, Codec, DISTANCE, Ends, FLAG, Float, LENGTH, PROBABILITY, ROBOT, RUN, Tag, Whole,
    at_most, by_hand, float, joint, part, tag, unknown_tag, whole,
};
use super::declaration::wire;
use crate::limits::{LENGTH_MAX_M, ROBOTS_MAX, ROUTE_POINTS_MAX};
use crate::message::{Capacity, Message, PublishSubscribe};
use crate::protocol::team::{Member, Placement, Robot, Sensor, Standing, Team, Travel, Vehicle};
use crate::{
    Decision, Digest, Direction, Leader, Refusal, RobotId, Role, RouteId, Scout, Waypoint, slice_payload,
};

/// A speed, m/s: from 0.1 mm a Sol to what is faster than any vehicle.
const SPEED: Float = float(1.0e-9, 1.0e3);

/// How far a camera sees, metres.
const RADIUS: Float = float(f64::MIN_POSITIVE, Sensor::RADIUS_MAX_M);

/// How far a sensor of square view sees, cells.
const SQUARE: Whole = whole(1, Sensor::RANGE_MAX_CELLS as u64);

/// Where a robot faces.
const HEADING: Tag<Direction> =
    tag(|heading| heading as u32, |code| Direction::ALL.get(code as usize).copied());

/// The length of all flights of a stage, metres: there and back over the longest distance.
const FLOWN: Float = float(0.0, 2.0 * LENGTH_MAX_M);

/// A decision as its number plus 1.
struct PlusOne;

/// A decision as its number plus 1, so that 0 stands for none.
const PLUS_ONE: PlusOne = PlusOne;

impl Codec<u64> for PlusOne {
    type Value = Option<Decision>;

    fn to_wire(&self, decision: &Option<Decision>) -> u64 {
        decision.map_or(0, |decision| decision.0 + 1)
    }

    fn from_wire(&self, field: &str, wire: u64) -> Result<Option<Decision>, Refusal> {
        Ok(COUNTED.from_wire(field, wire)?.checked_sub(1).map(Decision))
    }

    fn range(&self) -> String {
        format!("{}: the decision plus 1, 0 for none", Codec::<u64>::range(&COUNTED))
    }

    fn ends(&self) -> Ends<u64> {
        COUNTED.ends()
    }
}

wire! {
    /// Which moment it is of, and whose turn it is; the payload is the robots.
    pub struct TeamHeaderV1 = "hop.TeamHeader.v1", 64 bytes, refused as "team" {
        /// Run it belongs to.
        run: [u64; 2] = RUN,
        /// Decision that is due.
        decision: u64 = COUNTED,
        /// Digest of the state that it was published with.
        digest: [u8; 32] = ANY,
        /// Robot that acts next.
        due: u32 = by_hand("below the number of robots"),
        /// Number of the robot that took the last decision, plus 1; 0 at decision 0.
        actor: u32 = by_hand("at most the number of robots"),
    }
    of Team { run, decision: Decision(decision), digest: Digest(digest), due, actor, members }
    to_wire {
        let due = &ROBOT.to_wire(due);
        let actor = &actor.map_or(0, |actor| u32::from(actor.0) + 1);
    }
    from_wire(wire) {
        let robots = members.len();
        if !(1..=ROBOTS_MAX).contains(&robots) {
            return Err(Refusal::malformed("team.members", &format!("1 to {ROBOTS_MAX}"), robots));
        }
        let known = |robot: u32| {
            if (robot as usize) < robots {
                Ok(RobotId(robot as u16))
            } else {
                Err(Refusal::WrongRobot { robots: robots as u16, got: robot })
            }
        };
        let due = known(due)?;
        let actor = actor.checked_sub(1).map(known).transpose()?;
        let members = members.iter().map(Member::try_from).collect::<Result<_, _>>()?;
    }
    /// The team of a copied message.
    ///
    /// # Errors
    /// If there is no robot or there are too many, one is malformed, or the header names one that is not there.
    pub fn team_from_wire(members: &[MemberV5]);
}

wire! {
    /// A robot; its number is its place in the message. Points are (x, y) in metres.
    pub struct MemberV5 = "hop.Member.v5", 264 bytes, refused as "member" {
        /// Who commands it.
        leader: LeaderV1 = part::<Leader>(),
        /// Ready to act, nanoseconds of simulated time.
        ready_at_ns: u64 = ANY,
        /// Its last decision.
        last: u64 = PLUS_ONE,
        /// Speed of a rover or a helicopter, m/s.
        speed_mps: f64 = joint(SPEED, "read with `vehicle` 1 and 3"),
        /// 1 rover, 2 driver, 3 helicopter, 4 hopper, 5 hopper with a goal of its own.
        vehicle: u32 = joint(whole(1, 5), "says which other fields are read"),
        /// 1 square, 2 track, 3 camera, 4 disc, 5 camera that errs.
        sensor: u32 = joint(whole(1, 5), "says which other fields are read"),
        /// How far a square reaches, cells.
        range_cells: u32 = joint(SQUARE, "read with `sensor` 1"),
        /// Whether it takes turns.
        standing: u32 = tag(Standing::code, Standing::from_code),
        /// Start (x, y), cells.
        start: [i32; 2] = CELL,
        /// Now (x, y), cells.
        cell: [i32; 2] = CELL,
        /// Goal (x, y) of a hopper that has its own, cells.
        goal: [i32; 2] = joint(CELL, "read with `vehicle` 5"),
        /// Where it faced at the start.
        start_heading: u32 = HEADING => "member.start",
        /// Where it faces now.
        heading: u32 = HEADING => "member.cell",
        /// Start of a driver or a helicopter.
        start_m: [f64; 2] = joint(LENGTH, "read with `vehicle` 2 and 3"),
        /// Goal of a driver.
        goal_m: [f64; 2] = joint(LENGTH, "read with `vehicle` 2"),
        /// How near to the goal is near enough for a driver, metres.
        goal_radius_m: f64 = joint(DISTANCE, "read with `vehicle` 2"),
        /// How far a helicopter flies in all, metres.
        budget_m: f64 = joint(DISTANCE, "read with `vehicle` 3"),
        /// How far a camera sees, metres.
        radius_m: f64 = joint(RADIUS, "read with `sensor` 3 and 5"),
        /// Probability that a camera that errs reads the true speed.
        accuracy: f64 = joint(PROBABILITY, "read with `sensor` 5"),
        /// Where a driver or a helicopter is.
        at_m: [f64; 2] = joint(LENGTH, "read with `vehicle` 2 and 3"),
        /// Fingerprint of the route of a driver or a helicopter; 0 for none.
        route: u64 = by_hand("any; read with `vehicle` 2 and 3"),
        /// The decision by which a driver or a helicopter announced its route.
        announced: u64 = joint(PLUS_ONE, "read with `vehicle` 2 and 3"),
        /// The last drive of a driver or flight of a helicopter.
        moved: u64 = joint(PLUS_ONE, "read with `vehicle` 2 and 3"),
        /// Length of the flights of a helicopter in this stage, metres.
        flown_m: f64 = joint(FLOWN, "read with `vehicle` 2 and 3"),
        /// Points of its route that a driver or a helicopter has reached after the first.
        reached: u32 = by_hand("at most `legs`; read with `vehicle` 2 and 3"),
        /// Points of the route of a driver or a helicopter after the first.
        legs: u32 = joint(at_most(ROUTE_POINTS_MAX as u64 - 1), "read with `vehicle` 2 and 3"),
        /// 1 if it waits for another robot to act.
        waits: u32 = FLAG,
        /// Drives that the end of a stage cut short.
        halts: u32 = joint(at_most(Scout::STAGES_MAX as u64 - 1), "read with `vehicle` 2 and 3"),
        /// The last drive that the end of a stage cut short.
        halted: u64 = joint(PLUS_ONE, "none without `halts`; read with `vehicle` 2 and 3"),
    }
    of Member {
        robot: Robot { vehicle, sensor, start: Placement { cell: start, heading: start_heading } },
        at: Placement { cell, heading },
        ready_at_ns,
        standing,
        waits,
        leader,
        last,
        travel,
    }
    to_wire {
        let mut sum = MemberV5::zeroed();
        vehicle_to_wire(vehicle, &mut sum);
        sensor_to_wire(sensor, &mut sum);
        if let Some(travel) = travel {
            travel_to_wire(travel, &mut sum);
        }
        let MemberV5 {
            vehicle, goal, start_m, goal_m, goal_radius_m, speed_mps, budget_m, sensor, range_cells, radius_m,
            accuracy, at_m, route, announced, moved, flown_m, reached, legs, halts, halted, ..
        } = &sum;
    }
    from_wire(wire) {
        let vehicle = vehicle_from_wire(wire)?;
        let sensor = sensor_from_wire(wire)?;
        let travel = vehicle.start().map(|_| travel_from_wire(wire)).transpose()?;
    }
}

fn vehicle_to_wire(vehicle: &Vehicle, wire: &mut MemberV5) {
    match *vehicle {
        Vehicle::Rover { speed_mps } => (wire.vehicle, wire.speed_mps) = (1, speed_mps),
        Vehicle::Driver { start, goal, goal_radius_m } => {
            (wire.vehicle, wire.start_m) = (2, [start.x_m, start.y_m]);
            (wire.goal_m, wire.goal_radius_m) = ([goal.x_m, goal.y_m], goal_radius_m);
        }
        Vehicle::Helicopter { start, speed_mps, budget_m } => {
            (wire.vehicle, wire.start_m) = (3, [start.x_m, start.y_m]);
            (wire.speed_mps, wire.budget_m) = (speed_mps, budget_m);
        }
        Vehicle::Hopper => wire.vehicle = 4,
        Vehicle::HopperTo { goal } => (wire.vehicle, wire.goal) = (5, CELL.to_wire(&goal)),
    }
}

fn vehicle_from_wire(wire: &MemberV5) -> Result<Vehicle, Refusal> {
    let start = || point("member.start_m", wire.start_m);
    let speed_mps = || SPEED.from_wire("member.speed_mps", wire.speed_mps);
    Ok(match wire.vehicle {
        1 => Vehicle::Rover { speed_mps: speed_mps()? },
        2 => Vehicle::Driver {
            start: start()?,
            goal: point("member.goal_m", wire.goal_m)?,
            goal_radius_m: DISTANCE.from_wire("member.goal_radius_m", wire.goal_radius_m)?,
        },
        3 => Vehicle::Helicopter {
            start: start()?,
            speed_mps: speed_mps()?,
            budget_m: DISTANCE.from_wire("member.budget_m", wire.budget_m)?,
        },
        4 => Vehicle::Hopper,
        5 => Vehicle::HopperTo { goal: CELL.from_wire("member.goal", wire.goal)? },
        other => return Err(unknown_tag("member.vehicle", other)),
    })
}

fn sensor_to_wire(sensor: &Sensor, wire: &mut MemberV5) {
    match *sensor {
        Sensor::Square { range_cells } => (wire.sensor, wire.range_cells) = (1, range_cells),
        Sensor::Track => wire.sensor = 2,
        Sensor::Camera { radius_m } => (wire.sensor, wire.radius_m) = (3, radius_m),
        Sensor::Disc => wire.sensor = 4,
        Sensor::ErringCamera { radius_m, accuracy } => {
            (wire.sensor, wire.radius_m, wire.accuracy) = (5, radius_m, accuracy);
        }
    }
}

fn sensor_from_wire(wire: &MemberV5) -> Result<Sensor, Refusal> {
    let radius_m = || RADIUS.from_wire("member.radius_m", wire.radius_m);
    Ok(match wire.sensor {
        1 => Sensor::Square { range_cells: SQUARE.from_wire("member.range_cells", wire.range_cells)? },
        2 => Sensor::Track,
        3 => Sensor::Camera { radius_m: radius_m()? },
        4 => Sensor::Disc,
        5 => Sensor::ErringCamera {
            accuracy: PROBABILITY.from_wire("member.accuracy", wire.accuracy)?,
            radius_m: radius_m()?,
        },
        other => return Err(unknown_tag("member.sensor", other)),
    })
}

fn travel_to_wire(travel: &Travel, wire: &mut MemberV5) {
    wire.at_m = [travel.at.x_m, travel.at.y_m];
    wire.route = travel.route.map_or(0, |route| route.0);
    wire.announced = PLUS_ONE.to_wire(&travel.announced);
    wire.moved = PLUS_ONE.to_wire(&travel.moved);
    (wire.reached, wire.legs) = (travel.reached, travel.legs);
    (wire.halts, wire.halted) = (travel.halts, PLUS_ONE.to_wire(&travel.halted));
    wire.flown_m = travel.flown_m;
}

fn travel_from_wire(wire: &MemberV5) -> Result<Travel, Refusal> {
    let MemberV5 { reached, legs, halts, .. } = *wire;
    if legs as usize >= ROUTE_POINTS_MAX || reached > legs {
        let need = format!("reached up to legs, and those below {ROUTE_POINTS_MAX}");
        return Err(Refusal::malformed("member.legs", &need, format!("{reached} of {legs}")));
    }
    let halted = PLUS_ONE.from_wire("member.halted", wire.halted)?;
    if (halts > 0) != halted.is_some() || halts >= Scout::STAGES_MAX {
        let need = format!("below {}, and 0 if none has halted it", Scout::STAGES_MAX);
        return Err(Refusal::malformed("member.halts", &need, halts));
    }
    Ok(Travel {
        at: point("member.at_m", wire.at_m)?,
        route: (wire.route != 0).then_some(RouteId(wire.route)),
        announced: PLUS_ONE.from_wire("member.announced", wire.announced)?,
        reached,
        legs,
        moved: PLUS_ONE.from_wire("member.moved", wire.moved)?,
        halts,
        halted,
        flown_m: FLOWN.from_wire("member.flown_m", wire.flown_m)?,
    })
}

fn point(field: &str, wire: [f64; 2]) -> Result<Waypoint, Refusal> {
    let [x_m, y_m] = LENGTH.from_wire(field, wire)?;
    Ok(Waypoint { x_m, y_m })
}

slice_payload!(Team => TeamHeaderV1, MemberV5, members, team_from_wire);

/// Written only in missions that are not a single hopper's, each time just before the state.
impl Message for Team {
    const SERVICE: PublishSubscribe = PublishSubscribe {
        max_subscribers: 24,
        buffer: 64,
        capacity: Capacity::Cells(ROBOTS_MAX),
        ..PublishSubscribe::new("hop/team", &[Role::HopperSim])
    };
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::Payload;
    use crate::{Cell, Incarnation, Leader, RunId, Term};
    use std::sync::Arc;

    fn team(robots: u16) -> Team {
        let member = |number: u16| Member {
            robot: Robot {
                vehicle: Vehicle::Rover { speed_mps: 0.5 },
                sensor: Sensor::Square { range_cells: 2 },
                start: Placement { cell: Cell::new(number.into(), 1), heading: Direction::West },
            },
            at: Placement { cell: Cell::new(number.into(), 9), heading: Direction::South },
            ready_at_ns: 5_000_000_000,
            standing: Standing::Stranded,
            waits: false,
            leader: Leader { term: Term(3), incarnation: Incarnation(7), pid: 1, ..Leader::default() },
            last: number.checked_sub(1).map(|last| Decision(last.into())),
            travel: None,
        };
        Team {
            run: RunId(1 << 70 | 9),
            decision: Decision(12),
            digest: Digest([4; 32]),
            due: RobotId(robots - 1),
            actor: Some(RobotId(0)),
            members: (0..robots).map(member).collect(),
        }
    }

    /// A driver, a helicopter, and two hoppers, one with a goal of its own.
    fn scouted() -> Team {
        let mut team = team(4);
        let at = |x_m| Waypoint { x_m, y_m: 0.1 };
        let travel = Travel {
            at: at(9.7),
            route: Some(RouteId(u64::MAX)),
            announced: Some(Decision(0)),
            reached: 2,
            legs: 255,
            moved: Some(Decision(7)),
            halts: 2,
            halted: Some(Decision(6)),
            flown_m: 299.5,
        };
        let robots = [
            (Vehicle::Driver { start: at(0.3), goal: at(99.0), goal_radius_m: 3.0 }, Sensor::Track),
            (
                Vehicle::Helicopter { start: at(0.3), speed_mps: 5.0, budget_m: 300.0 },
                Sensor::Camera { radius_m: 25.0 },
            ),
        ];
        let members = Arc::make_mut(&mut team.members);
        for (member, (vehicle, sensor)) in members.iter_mut().zip(robots) {
            (member.robot.vehicle, member.robot.sensor, member.travel) = (vehicle, sensor, Some(travel));
        }
        members[3].waits = true;
        members[1].travel = Some(Travel::from_start(at(0.3)));
        (members[3].robot.vehicle, members[3].robot.sensor) = (Vehicle::Hopper, Sensor::Disc);
        members[2].robot.vehicle = Vehicle::HopperTo { goal: Cell::new(8, 9) };
        team
    }

    fn there_and_back(
        team: &Team,
        twist: impl Fn(&mut TeamHeaderV1, &mut Vec<MemberV5>),
    ) -> Result<Team, Refusal> {
        let mut header = team.header();
        let mut members = (0..team.cells()).map(|index| team.cell(index)).collect();
        twist(&mut header, &mut members);
        team_from_wire(&header, &members)
    }

    #[test]
    fn a_team_survives_its_wire_form() {
        for robots in [1, 2, 16] {
            let team = team(robots);
            assert_eq!(there_and_back(&team, |_, _| {}).unwrap(), team);
        }
        let mut scouted = scouted();
        assert_eq!(there_and_back(&scouted, |_, _| {}).unwrap(), scouted);
        Arc::make_mut(&mut scouted.members)[1].robot.sensor =
            Sensor::ErringCamera { radius_m: 25.0, accuracy: 0.97 };
        assert_eq!(there_and_back(&scouted, |_, _| {}).unwrap(), scouted);
        let first = Team { actor: None, ..team(3) };
        assert_eq!(there_and_back(&first, |_, _| {}).unwrap(), first);
    }

    #[test]
    fn teams_that_cannot_be_are_refused_by_name() {
        type Twist = fn(&mut TeamHeaderV1, &mut Vec<MemberV5>);
        let cases: [(&str, Twist); 9] = [
            ("team.members", |_, members| members.clear()),
            ("team.members", |_, members| members.extend(vec![members[0]; 16])),
            ("robot below 3, got 3", |header, _| header.due = 3),
            ("robot below 3, got 6", |header, _| header.actor = 7),
            ("member.vehicle", |_, members| members[1].vehicle = 6),
            ("member.speed_mps", |_, members| members[1].speed_mps = f64::NAN),
            ("member.range_cells", |_, members| members[1].range_cells = 0),
            ("member.standing", |_, members| members[1].standing = 0),
            ("member.cell", |_, members| members[1].heading = 4),
        ];
        for (need, twist) in cases {
            let refusal = there_and_back(&team(3), twist).unwrap_err().to_string();
            assert!(refusal.contains(need), "{need}: {refusal}");
        }
        let cases: [(&str, Twist); 13] = [
            ("member.halts", |_, members| members[0].halts = 0),
            ("member.halts", |_, members| members[0].halts = 64),
            ("member.halts", |_, members| members[1].halts = 1),
            ("member.sensor", |_, members| members[0].sensor = 6),
            ("member.accuracy", |_, members| (members[1].sensor, members[1].accuracy) = (5, 1.5)),
            ("member.at_m", |_, members| members[0].at_m[1] = f64::NAN),
            ("member.goal_m", |_, members| members[0].goal_m[0] = 1e9),
            ("member.goal_radius_m", |_, members| members[0].goal_radius_m = -1.0),
            ("member.legs", |_, members| members[0].legs = 256),
            ("member.legs", |_, members| members[1].reached = 1),
            ("member.waits", |_, members| members[1].waits = 2),
            ("member.budget_m", |_, members| members[1].budget_m = f64::INFINITY),
            ("member.radius_m", |_, members| members[1].radius_m = 0.0),
        ];
        for (need, twist) in cases {
            let refusal = there_and_back(&scouted(), twist).unwrap_err().to_string();
            assert!(refusal.contains(need), "{need}: {refusal}");
        }
    }
}
