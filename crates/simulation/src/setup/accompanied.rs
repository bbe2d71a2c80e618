//! The hopper of a small world with one or two helicopters that look ahead for it.

use contract::{Body, Brief, Camera, Goal, Helicopter, LookAhead, Robot, RobotId, RobotSet, Sensor};
use hopper_sim::Mission;
use scenario::Fault;

use super::{HOPPER_PLANNERS, Missions, Seat, Vertical, hopper_mission, team};
use crate::chance::Chance;

const HOPPER: RobotId = RobotId(0);

/// A planner process for the hopper, or for some of the helicopters; now and then for robots that it cannot plan for.
pub(super) fn seat(seed: u64, chance: &mut Chance) -> Seat {
    let count = Missions::Accompanied.robots(seed);
    let some = chance.between(1, (1 << count) - 1) as u16;
    if chance.one_in(16) {
        return Seat { planner: Missions::Accompanied.algorithm(chance), robots: RobotSet(some) };
    }
    let helicopters = RobotSet(some & !1);
    if helicopters.0 == 0 || chance.one_in(2) { of_hopper(chance) } else { of_helicopters(helicopters) }
}

fn of_hopper(chance: &mut Chance) -> Seat {
    let planner = chance.pick(&HOPPER_PLANNERS).parse().expect("the names of algorithms are names");
    Seat { planner, robots: RobotSet(0).with(HOPPER) }
}

fn of_helicopters(robots: RobotSet) -> Seat {
    let planner = planner::AHEAD_ALGORITHMS[0].parse().expect("the names of algorithms are names");
    Seat { planner, robots }
}

/// A planner process for the hopper, and one for each helicopter or for both.
pub(super) fn planners(seed: u64, chance: &mut Chance) -> Vec<Seat> {
    let helicopters = RobotSet(RobotSet::first(Missions::Accompanied.robots(seed)).0 & !1);
    let mut seats = vec![of_hopper(chance)];
    if chance.one_in(3) {
        seats.push(of_helicopters(helicopters));
    } else {
        seats.extend(helicopters.iter().map(|robot| of_helicopters(RobotSet(0).with(robot))));
    }
    seats
}

/// The `number`th mission of a seed.
pub(super) fn mission(seed: u64, number: u64) -> Mission {
    let mission = hopper_mission(seed, number, Vertical::NONE);
    let mut chance = Chance::new(seed ^ number.rotate_left(32), "accompanied");
    let robots = Missions::Accompanied.robots(seed);
    let hopper = mission.brief.robots[0];
    let helicopter = |_: u16| {
        let (speed_mps, budget_m) = (chance.pick(&[0.2, 0.5, 5.0]), chance.pick(&[0.0, 2.5, 6.0, 20.0]));
        Robot {
            body: Body::Helicopter(Helicopter { speed_mps, budget_m }),
            sensor: Sensor::Camera(Camera { radius_m: chance.pick(&[0.8, 1.5, 2.5]) }),
            goal: Goal::LookAhead(LookAhead {}),
            required: false,
            ..hopper
        }
    };
    let all: Vec<Robot> = std::iter::once(hopper).chain((1..robots).map(helicopter)).collect();
    let mut chance = Chance::new(seed ^ number.rotate_left(32), "accompanied faults");
    let fault = |robot: RobotId| chance.one_in(6).then(|| Fault { robot, action: chance.between(2, 12) });
    let faults = (0..robots).map(RobotId).filter_map(fault).collect();
    let brief = Brief { robots: team(&all), ..mission.brief };
    Mission { brief, faults, ..mission }
}
