//! Header and cell of `hop/team`.

use bytemuck::{Pod, Zeroable};

use super::{
    LeaderV1, Wire, cell_from_wire, cell_to_wire, counted, flag, float, length, robot_from_wire,
    run_from_wire, run_to_wire, tag,
};
use crate::limits::{LENGTH_MAX_M, ROBOTS_MAX, ROUTE_POINTS_MAX};
use crate::message::{Capacity, Message, PublishSubscribe};
use crate::protocol::team::{Member, Placement, Robot, Sensor, Standing, Team, Travel, Vehicle};
use crate::{Decision, Digest, Direction, Refusal, RobotId, Role, RouteId, Scout, Waypoint, slice_payload};

/// Fastest vehicle that is believed, m/s.
const SPEED_MAX_MPS: f64 = 1.0e3;

/// Slowest vehicle that is believed, m/s: 0.1 mm a Sol.
const SPEED_MIN_MPS: f64 = 1.0e-9;

#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct TeamHeaderV1 {
    pub run: [u64; 2],
    pub decision: u64,
    pub digest: [u8; 32],
    pub due: u32,
    /// Number of the robot that took the last decision, plus 1; 0 at decision 0.
    pub actor: u32,
}

/// A robot; its number is its place in the message. Points are (x, y) in metres.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct MemberV5 {
    pub leader: LeaderV1,
    /// Ready to act, nanoseconds of simulated time.
    pub ready_at_ns: u64,
    /// Its last decision plus 1; 0 before its first.
    pub last: u64,
    /// Speed of a rover (1) or a helicopter, m/s; not read of other vehicles.
    pub speed_mps: f64,
    /// 1 rover, 2 driver, 3 helicopter, 4 hopper, 5 hopper with a goal of its own. What follows up to `waits` is read of 2 and 3 only.
    pub vehicle: u32,
    /// 1 square, 2 track, 3 camera, 4 disc, 5 camera that errs.
    pub sensor: u32,
    /// How far a square sensor sees, cells; not read of other sensors.
    pub range_cells: u32,
    /// [`Standing::code`].
    pub standing: u32,
    /// Start (x, y), cells.
    pub start: [i32; 2],
    /// Now (x, y), cells.
    pub cell: [i32; 2],
    /// Goal (x, y) of a hopper that has its own, cells.
    pub goal: [i32; 2],
    /// Heading at the start: 0 north, 1 east, 2 south, 3 west.
    pub start_heading: u32,
    /// Heading now: 0 north, 1 east, 2 south, 3 west.
    pub heading: u32,
    /// Start (x, y) of a driver or a helicopter; not read of other vehicles.
    pub start_m: [f64; 2],
    /// Goal (x, y) of a driver; not read of other vehicles.
    pub goal_m: [f64; 2],
    /// How near to its goal a driver is done, metres; not read of other vehicles.
    pub goal_radius_m: f64,
    /// How far a helicopter may fly, metres; not read of other vehicles.
    pub budget_m: f64,
    /// How far a camera sees, metres; not read of other sensors.
    pub radius_m: f64,
    /// Share of readings that are right, of a camera that errs; not read of other sensors.
    pub accuracy: f64,
    /// Where it is.
    pub at_m: [f64; 2],
    /// Fingerprint of its route; 0 for none.
    pub route: u64,
    /// The decision by which it announced its route plus 1; 0 for none.
    pub announced: u64,
    /// Its last drive or flight plus 1; 0 before its first.
    pub moved: u64,
    pub flown_m: f64,
    pub reached: u32,
    pub legs: u32,
    /// 1 if it waits.
    pub waits: u32,
    /// Drives that the end of a stage cut short.
    pub halts: u32,
    /// The last decision whose drive the end of a stage cut short, plus 1; 0 for none.
    pub halted: u64,
}

const _: () = assert!(size_of::<TeamHeaderV1>() == 64);
const _: () = assert!(size_of::<MemberV5>() == 264);

impl Wire for TeamHeaderV1 {
    const NAME: &'static str = "hop.TeamHeader.v1";
}

impl Wire for MemberV5 {
    const NAME: &'static str = "hop.Member.v5";
}

impl From<&Team> for TeamHeaderV1 {
    fn from(team: &Team) -> Self {
        Self {
            run: run_to_wire(team.run),
            decision: team.decision.0,
            digest: team.digest.0,
            due: team.due.0.into(),
            actor: team.actor.map_or(0, |actor| u32::from(actor.0) + 1),
        }
    }
}

impl From<&Member> for MemberV5 {
    fn from(member: &Member) -> Self {
        let Robot { vehicle, sensor, start } = member.robot;
        let mut wire = Self {
            leader: (&member.leader).into(),
            ready_at_ns: member.ready_at_ns,
            last: plus_one(member.last),
            standing: member.standing.code(),
            waits: member.waits.into(),
            start: cell_to_wire(start.cell),
            cell: cell_to_wire(member.at.cell),
            start_heading: start.heading as u32,
            heading: member.at.heading as u32,
            ..Self::zeroed()
        };
        match vehicle {
            Vehicle::Rover { speed_mps } => (wire.vehicle, wire.speed_mps) = (1, speed_mps),
            Vehicle::Driver { start, goal, goal_radius_m } => {
                (wire.vehicle, wire.start_m) = (2, point_to_wire(start));
                (wire.goal_m, wire.goal_radius_m) = (point_to_wire(goal), goal_radius_m);
            }
            Vehicle::Helicopter { start, speed_mps, budget_m } => {
                (wire.vehicle, wire.start_m) = (3, point_to_wire(start));
                (wire.speed_mps, wire.budget_m) = (speed_mps, budget_m);
            }
            Vehicle::Hopper => wire.vehicle = 4,
            Vehicle::HopperTo { goal } => (wire.vehicle, wire.goal) = (5, cell_to_wire(goal)),
        }
        match sensor {
            Sensor::Square { range_cells } => (wire.sensor, wire.range_cells) = (1, range_cells),
            Sensor::Track => wire.sensor = 2,
            Sensor::Camera { radius_m } => (wire.sensor, wire.radius_m) = (3, radius_m),
            Sensor::Disc => wire.sensor = 4,
            Sensor::ErringCamera { radius_m, accuracy } => {
                (wire.sensor, wire.radius_m, wire.accuracy) = (5, radius_m, accuracy);
            }
        }
        if let Some(travel) = &member.travel {
            wire.at_m = point_to_wire(travel.at);
            wire.route = travel.route.map_or(0, |route| route.0);
            (wire.announced, wire.moved) = (plus_one(travel.announced), plus_one(travel.moved));
            (wire.reached, wire.legs) = (travel.reached, travel.legs);
            (wire.halts, wire.halted) = (travel.halts, plus_one(travel.halted));
            wire.flown_m = travel.flown_m;
        }
        wire
    }
}

impl TryFrom<&MemberV5> for Member {
    type Error = Refusal;

    fn try_from(wire: &MemberV5) -> Result<Self, Refusal> {
        let vehicle = vehicle_from_wire(wire)?;
        let placement = |field: &str, cell, heading| -> Result<Placement, Refusal> {
            let heading = tag(field, heading, |code| Direction::ALL.get(code as usize).copied())?;
            Ok(Placement { cell: cell_from_wire(field, cell)?, heading })
        };
        Ok(Self {
            robot: Robot {
                vehicle,
                sensor: sensor_from_wire(wire)?,
                start: placement("member.start", wire.start, wire.start_heading)?,
            },
            at: placement("member.cell", wire.cell, wire.heading)?,
            ready_at_ns: wire.ready_at_ns,
            standing: tag("member.standing", wire.standing, Standing::from_code)?,
            waits: flag("member.waits", wire.waits)?,
            leader: (&wire.leader).try_into()?,
            last: decision("member.last", wire.last)?,
            travel: vehicle.start().map(|_| travel_from_wire(wire)).transpose()?,
        })
    }
}

fn vehicle_from_wire(wire: &MemberV5) -> Result<Vehicle, Refusal> {
    let speed = || float("member.speed_mps", wire.speed_mps, SPEED_MIN_MPS, SPEED_MAX_MPS);
    Ok(match wire.vehicle {
        1 => Vehicle::Rover { speed_mps: speed()? },
        2 => Vehicle::Driver {
            start: point("member.start_m", wire.start_m)?,
            goal: point("member.goal_m", wire.goal_m)?,
            goal_radius_m: float("member.goal_radius_m", wire.goal_radius_m, 0.0, LENGTH_MAX_M)?,
        },
        3 => Vehicle::Helicopter {
            start: point("member.start_m", wire.start_m)?,
            speed_mps: speed()?,
            budget_m: float("member.budget_m", wire.budget_m, 0.0, LENGTH_MAX_M)?,
        },
        4 => Vehicle::Hopper,
        5 => Vehicle::HopperTo { goal: cell_from_wire("member.goal", wire.goal)? },
        other => return Err(Refusal::malformed("member.vehicle", "a known tag", other)),
    })
}

fn sensor_from_wire(wire: &MemberV5) -> Result<Sensor, Refusal> {
    let MemberV5 { range_cells, accuracy, .. } = *wire;
    let radius_m = || float("member.radius_m", wire.radius_m, f64::MIN_POSITIVE, Sensor::RADIUS_MAX_M);
    match wire.sensor {
        1 if (1..=Sensor::RANGE_MAX_CELLS).contains(&range_cells) => Ok(Sensor::Square { range_cells }),
        1 => {
            let need = format!("1 to {}", Sensor::RANGE_MAX_CELLS);
            Err(Refusal::malformed("member.range_cells", &need, range_cells))
        }
        2 => Ok(Sensor::Track),
        3 => Ok(Sensor::Camera { radius_m: radius_m()? }),
        4 => Ok(Sensor::Disc),
        5 => {
            let accuracy = float("member.accuracy", accuracy, 0.0, 1.0)?;
            Ok(Sensor::ErringCamera { radius_m: radius_m()?, accuracy })
        }
        other => Err(Refusal::malformed("member.sensor", "a known tag", other)),
    }
}

fn travel_from_wire(wire: &MemberV5) -> Result<Travel, Refusal> {
    let MemberV5 { reached, legs, halts, .. } = *wire;
    if legs as usize >= ROUTE_POINTS_MAX || reached > legs {
        let need = format!("reached up to legs, and those below {ROUTE_POINTS_MAX}");
        return Err(Refusal::malformed("member.legs", &need, format!("{reached} of {legs}")));
    }
    let halted = decision("member.halted", wire.halted)?;
    if (halts > 0) != halted.is_some() || halts >= Scout::STAGES_MAX {
        let need = format!("below {}, and 0 if none has halted it", Scout::STAGES_MAX);
        return Err(Refusal::malformed("member.halts", &need, halts));
    }
    Ok(Travel {
        at: point("member.at_m", wire.at_m)?,
        route: (wire.route != 0).then_some(RouteId(wire.route)),
        announced: decision("member.announced", wire.announced)?,
        reached,
        legs,
        moved: decision("member.moved", wire.moved)?,
        halts,
        halted,
        flown_m: float("member.flown_m", wire.flown_m, 0.0, 2.0 * LENGTH_MAX_M)?,
    })
}

fn point(field: &str, [x_m, y_m]: [f64; 2]) -> Result<Waypoint, Refusal> {
    Ok(Waypoint { x_m: length(field, x_m)?, y_m: length(field, y_m)? })
}

fn point_to_wire(point: Waypoint) -> [f64; 2] {
    [point.x_m, point.y_m]
}

/// A decision as its number plus 1, so that 0 stands for none.
fn plus_one(decision: Option<Decision>) -> u64 {
    decision.map_or(0, |decision| decision.0 + 1)
}

fn decision(field: &str, wire: u64) -> Result<Option<Decision>, Refusal> {
    Ok(counted(field, wire)?.checked_sub(1).map(Decision))
}

/// The team of a copied message.
///
/// # Errors
/// If there is no robot or there are too many, one is malformed, or the header names one that is not there.
pub fn team_from_wire(header: &TeamHeaderV1, members: &[MemberV5]) -> Result<Team, Refusal> {
    if !(1..=ROBOTS_MAX).contains(&members.len()) {
        return Err(Refusal::malformed("team.members", &format!("1 to {ROBOTS_MAX}"), members.len()));
    }
    let known = |robot: u32| -> Result<RobotId, Refusal> {
        let there = (robot as usize) < members.len();
        let unknown = Refusal::WrongRobot { robots: members.len() as u16, got: robot };
        if there { robot_from_wire(robot) } else { Err(unknown) }
    };
    Ok(Team {
        run: run_from_wire(header.run),
        decision: Decision(counted("team.decision", header.decision)?),
        digest: Digest(header.digest),
        due: known(header.due)?,
        actor: header.actor.checked_sub(1).map(known).transpose()?,
        members: members.iter().map(Member::try_from).collect::<Result<_, _>>()?,
    })
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
