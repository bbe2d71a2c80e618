//! A cell of `hop/brief`: a robot.

use super::declaration::wire;
use crate::codec::{CELL, FLAG, HEADING, LENGTH, by_hand};
use crate::{Body, Goal, Placement, Robot, Sensor, Waypoint};

wire! {
    /// A robot: what it is, what it sees, where it begins, and what it shall do. Bodies, sensors and goals have a code and a
    /// block of numbers each, which the tables below list; the rest of a block is 0.
    pub struct RobotV1 = "hop.Robot.v1", 560 bytes, refused as "robot" {
        /// Kind of body.
        body: u32 = by_hand("a code of a body"),
        /// Kind of sensor.
        sensor: u32 = by_hand("a code of a sensor"),
        /// Kind of goal.
        goal: u32 = by_hand("a code of a goal"),
        /// 1 if the mission needs its goal to be reached.
        required: u32 = FLAG,
        /// Start (x, y), cells.
        start: [i32; 2] = CELL,
        /// Where it faces at the start.
        heading: u32 = HEADING,
        reserved: u32,
        /// Start (x, y) exactly, metres.
        start_m: [f64; 2] = LENGTH,
        /// Parameters of the body.
        body_values: [f64; Body::BLOCK] = by_hand("as `body` says"),
        /// Parameters of the sensor.
        sensor_values: [f64; Sensor::BLOCK] = by_hand("as `sensor` says"),
        /// Parameters of the goal.
        goal_values: [f64; Goal::BLOCK] = by_hand("as `goal` says"),
    }
    of Robot {
        body,
        sensor,
        start: Placement { cell: start, heading },
        start_at: Waypoint { x_m, y_m },
        goal,
        required,
    }
    to_wire {
        let start_m = &[*x_m, *y_m];
        let (body, body_values) = &body.to_block();
        let (sensor, sensor_values) = &sensor.to_block();
        let (goal, goal_values) = &goal.to_block();
    }
    from_wire(wire) {
        let [x_m, y_m] = start_m;
        let body = Body::from_block(body, &body_values)?;
        let sensor = Sensor::from_block(sensor, &sensor_values)?;
        let goal = Goal::from_block(goal, &goal_values)?;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mission::kind::KindInBlock;
    use crate::{
        Camera, Cell, Cover, CoverMode, Driver, ErringCamera, GradientSource, Grid, Helicopter, LookAhead,
        MotionParameters, Reach, Rover, SensorParameters, SoilMotion, Square, Track, Visit,
    };

    /// P-WIRE-KINDS: A parameter of a body, a sensor or a goal survives its block at both ends of its range, and is refused by name
    /// beyond; so is a code that stands for nothing, and a number behind the last parameter.
    #[test]
    fn kinds_survive_their_blocks_and_are_refused_by_name() {
        let soil = SoilMotion { intended: 0.8, stuck: 0.1, sideways: 0.05, flights: 1 };
        let motion = MotionParameters {
            hard: soil,
            sand: SoilMotion { flights: 2, ..soil },
            slope_limit_rad: 0.5,
            launch_angle_rad: 0.8,
            gravity_mps2: 3.72,
            vertical: false,
            table: 0,
        };
        let gradient = GradientSource::SeenDifferences;
        let sensor =
            SensorParameters { gain: 2.0, offset_m: 1.0, radius_min_m: 1.0, radius_max_m: 9.0, gradient };
        let grid = Grid::new(9, 9, 0.5, 1).unwrap();
        let robot = Robot::hopper(&grid, motion, sensor, [Cell::new(1, 2), Cell::new(8, 8)]);
        let wire = RobotV1::from(&robot);
        let start_at = Waypoint { x_m: 0.3, y_m: 4.5 };
        let visit = Visit::new(&[Cell::new(1, 2), Cell::new(8, 8), Cell::new(0, 0)], 77).unwrap();
        let others = [
            (Body::Rover(Rover { speed_mps: 0.5 }), Sensor::Square(Square { range_cells: 2 })),
            (Body::Driver(Driver {}), Sensor::Track(Track {})),
            (
                Body::Helicopter(Helicopter { speed_mps: 5.0, budget_m: 300.0 }),
                Sensor::ErringCamera(ErringCamera { radius_m: 25.0, accuracy: 0.97 }),
            ),
            (Body::Driver(Driver {}), Sensor::Camera(Camera { radius_m: 25.0 })),
        ];
        let goals = [
            Goal::Visit(visit),
            Goal::Cover(Cover { percent: 60, mode: CoverMode::Voronoi }),
            Goal::LookAhead(LookAhead {}),
            Goal::Reach(Reach { at: start_at, radius_m: 3.0 }),
        ];
        let others = others.into_iter().zip(goals);
        let others = others.map(|((body, sensor), goal)| Robot { body, sensor, goal, start_at, ..robot });
        for robot in others.chain([robot]) {
            assert_eq!(Robot::try_from(&RobotV1::from(&robot)).unwrap(), robot);
        }
        type Twist = fn(&mut RobotV1);
        let cases: [(&str, Twist); 12] = [
            ("field robot.body needs", |wire| wire.body = 0),
            ("field robot.sensor needs", |wire| wire.sensor = u32::MAX),
            ("field robot.goal needs", |wire| wire.goal = u32::MAX),
            ("field robot.required", |wire| wire.required = 2),
            ("field robot.body.motion.hard.sideways", |wire| wire.body_values[2] = 0.6),
            ("field robot.body.motion.hard.sum", |wire| wire.body_values[0] = 0.5),
            ("field robot.body.motion.sand.flights", |wire| wire.body_values[7] = 1.5),
            ("field robot.body needs 0 after", |wire| wire.body_values[15] = f64::NAN),
            ("field robot.sensor.radius_max_m", |wire| wire.sensor_values[3] = 0.5),
            ("field robot.sensor.gradient", |wire| wire.sensor_values[4] = 2.0),
            ("field robot.goal.at", |wire| wire.goal_values[0] = f64::NAN),
            ("field robot.goal.radius_m", |wire| wire.goal_values[2] = -1.0),
        ];
        for (need, twist) in cases {
            let mut wire = wire;
            twist(&mut wire);
            let refusal = Robot::try_from(&wire).unwrap_err().to_string();
            assert!(refusal.starts_with(need), "{need}: {refusal}");
        }
    }

    /// P-WIRE-KINDS.
    #[test]
    fn every_parameter_says_why_it_is_there() {
        for KindInBlock { name, what, parameters, .. } in
            [Body::described(), Sensor::described(), Goal::described()].concat()
        {
            assert!(what.ends_with('.'), "{name}");
            for parameter in parameters {
                assert!(parameter.reason.ends_with('.'), "{name}.{}", parameter.name);
            }
        }
    }
}
