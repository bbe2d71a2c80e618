//! Header and cell of `hop/team`.

use bytemuck::Zeroable;

use super::LeaderV1;
use super::declaration::wire;
use crate::codec::{
    ANY, CELL, COUNTED, Codec, Ends, FLAG, Float, HEADING, LENGTH, ROBOT, RUN, at_most, by_hand, float,
    joint, part, tag,
};
use crate::limits::{LENGTH_MAX_M, ROBOTS_MAX, ROUTE_POINTS_MAX};
use crate::message::{Capacity, Message, PublishSubscribe};
use crate::{
    Decision, Digest, Leader, Member, Placement, Refusal, RobotId, Role, RouteId, Sampling, Standing, Team,
    Travel, Waypoint, slice_payload,
};

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
    pub fn team_from_wire(members: &[MemberV6]);
}

wire! {
    /// How a robot is at a decision; its number is its place in the message, and what it is stands in the brief.
    pub struct MemberV6 = "hop.Member.v6", 168 bytes, refused as "member" {
        /// Who commands it.
        leader: LeaderV1 = part::<Leader>(),
        /// Ready to act, nanoseconds of simulated time.
        ready_at_ns: u64 = ANY,
        /// Its last decision.
        last: u64 = PLUS_ONE,
        /// Now (x, y), cells.
        cell: [i32; 2] = CELL,
        /// Where it faces.
        heading: u32 = HEADING,
        /// Whether it takes turns.
        standing: u32 = tag(Standing::code, Standing::from_code),
        /// 1 if it waits for another robot to act.
        waits: u32 = FLAG,
        /// 1 if it goes from point to point; if not, what follows is zero.
        travels: u32 = joint(FLAG, "says whether what follows is read"),
        /// Where it is, metres.
        at_m: [f64; 2] = joint(LENGTH, "read with `travels`"),
        /// Fingerprint of its route; 0 for none.
        route: u64 = by_hand("any; read with `travels`"),
        /// The decision by which it announced its route.
        announced: u64 = joint(PLUS_ONE, "read with `travels`"),
        /// Its last drive or flight.
        moved: u64 = joint(PLUS_ONE, "read with `travels`"),
        /// Length of its flights in this stage, metres.
        flown_m: f64 = joint(FLOWN, "read with `travels`"),
        /// Points of its route that it has reached after the first.
        reached: u32 = by_hand("at most `legs`; read with `travels`"),
        /// Points of its route after the first.
        legs: u32 = joint(at_most(ROUTE_POINTS_MAX as u64 - 1), "read with `travels`"),
        /// The last drive that the end of a stage cut short.
        halted: u64 = joint(PLUS_ONE, "none without `halts`; read with `travels`"),
        /// Drives that the end of a stage cut short.
        halts: u32 = joint(at_most(Sampling::STAGES_MAX as u64 - 1), "read with `travels`"),
        reserved: u32,
    }
    of Member { at: Placement { cell, heading }, ready_at_ns, standing, waits, leader, last, travel }
    to_wire {
        let mut sum = MemberV6::zeroed();
        if let Some(travel) = travel {
            travel_to_wire(travel, &mut sum);
        }
        let MemberV6 { travels, at_m, route, announced, moved, flown_m, reached, legs, halts, halted, .. } = &sum;
    }
    from_wire(wire) {
        let travels = FLAG.from_wire("member.travels", travels)?;
        let travel = if travels { Some(travel_from_wire(wire)?) } else { None };
    }
}

fn travel_to_wire(travel: &Travel, wire: &mut MemberV6) {
    wire.travels = 1;
    wire.at_m = [travel.at.x_m, travel.at.y_m];
    wire.route = travel.route.map_or(0, |route| route.0);
    wire.announced = PLUS_ONE.to_wire(&travel.announced);
    wire.moved = PLUS_ONE.to_wire(&travel.moved);
    (wire.reached, wire.legs) = (travel.reached, travel.legs);
    (wire.halts, wire.halted) = (travel.halts, PLUS_ONE.to_wire(&travel.halted));
    wire.flown_m = travel.flown_m;
}

fn travel_from_wire(wire: &MemberV6) -> Result<Travel, Refusal> {
    let MemberV6 { reached, legs, halts, .. } = *wire;
    if legs as usize >= ROUTE_POINTS_MAX || reached > legs {
        let need = format!("reached up to legs, and those below {ROUTE_POINTS_MAX}");
        return Err(Refusal::malformed("member.legs", &need, format!("{reached} of {legs}")));
    }
    let halted = PLUS_ONE.from_wire("member.halted", wire.halted)?;
    if (halts > 0) != halted.is_some() || halts >= Sampling::STAGES_MAX {
        let need = format!("below {}, and 0 if none has halted it", Sampling::STAGES_MAX);
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

slice_payload!(Team => TeamHeaderV1, MemberV6, members, team_from_wire);

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
    use crate::{Cell, Direction, Incarnation, RunId, Term};
    use std::sync::Arc;

    fn team(robots: u16) -> Team {
        let member = |number: u16| Member {
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

    /// Two robots that go from point to point, and two that do not.
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
        let members = Arc::make_mut(&mut team.members);
        (members[0].travel, members[1].travel) = (Some(travel), Some(Travel::from_start(at(0.3))));
        members[3].waits = true;
        team
    }

    fn there_and_back(
        team: &Team,
        twist: impl Fn(&mut TeamHeaderV1, &mut Vec<MemberV6>),
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
        let scouted = scouted();
        assert_eq!(there_and_back(&scouted, |_, _| {}).unwrap(), scouted);
        let first = Team { actor: None, ..team(3) };
        assert_eq!(there_and_back(&first, |_, _| {}).unwrap(), first);
    }

    #[test]
    fn teams_that_cannot_be_are_refused_by_name() {
        type Twist = fn(&mut TeamHeaderV1, &mut Vec<MemberV6>);
        let cases: [(&str, Twist); 7] = [
            ("team.members", |_, members| members.clear()),
            ("team.members", |_, members| members.extend(vec![members[0]; 16])),
            ("robot below 3, got 3", |header, _| header.due = 3),
            ("robot below 3, got 6", |header, _| header.actor = 7),
            ("member.standing", |_, members| members[1].standing = 0),
            ("member.heading", |_, members| members[1].heading = 4),
            ("member.travels", |_, members| members[1].travels = 2),
        ];
        for (need, twist) in cases {
            let refusal = there_and_back(&team(3), twist).unwrap_err().to_string();
            assert!(refusal.contains(need), "{need}: {refusal}");
        }
        let cases: [(&str, Twist); 7] = [
            ("member.halts", |_, members| members[0].halts = 0),
            ("member.halts", |_, members| members[0].halts = 64),
            ("member.halts", |_, members| members[1].halts = 1),
            ("member.at_m", |_, members| members[0].at_m[1] = f64::NAN),
            ("member.legs", |_, members| members[0].legs = 256),
            ("member.legs", |_, members| members[1].reached = 1),
            ("member.waits", |_, members| members[1].waits = 2),
        ];
        for (need, twist) in cases {
            let refusal = there_and_back(&scouted(), twist).unwrap_err().to_string();
            assert!(refusal.contains(need), "{need}: {refusal}");
        }
    }
}
