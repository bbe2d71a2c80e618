//! `[[robots]]` of missions of kind `mixed`: robots of any kind, each with a start and a task of its own.

use contract::limits::LENGTH_MAX_M;
use contract::limits::ROBOTS_MAX;
use contract::{
    Cell, CoverMode, Design, Designs, Placement, Robot, RobotId, RobotSet, Sensor, SensorParameters, Vehicle,
    Waypoint,
};
use terrain::Terrain;

use crate::bounds::in_range;
use crate::fleet::refuse;
use crate::mobility::trip;
use crate::robot::check_launch_angle;
use crate::{Fleet, RobotRules, Scenario, ScenarioError, VehicleKind};

impl Scenario {
    /// The robots of a mixed mission on their terrain, checked.
    pub(crate) fn mixed_on(&mut self, terrain: &Terrain) -> Result<Fleet, ScenarioError> {
        if !(1..=ROBOTS_MAX).contains(&self.robots.len()) {
            let need = "1 to 16 of them, each with a start";
            return refuse("robots", need, self.robots.len().to_string());
        }
        let robots = self.robots.iter_mut().enumerate();
        let robots: Vec<Robot> =
            robots.map(|(number, rules)| rules.mixed(number, terrain)).collect::<Result<_, _>>()?;
        let is_grounded = |number: usize| robots[number].vehicle.is_on_ground();
        let starts = (0..robots.len()).filter(|number| is_grounded(*number));
        check_distinct("robots.start", starts.map(|number| (number, self.robots[number].start)))?;
        check_distinct("robots.goal", (0..robots.len()).map(|number| (number, self.robots[number].goal)))?;
        self.check_goals_are_open(&robots)?;
        if self.mission.mode == Some(CoverMode::Voronoi) {
            let need =
                "overlap: a region would stay uncovered for good where its rover, or the way to it, is lost";
            return refuse("mission.mode", need, "voronoi".into());
        }
        self.check_faults()?;
        self.check_accuracies(&robots)?;
        if self.required() == RobotSet(0) {
            return refuse("robots.required", "at least one robot that the mission needs", "none".into());
        }
        Ok(Fleet { robots, faults: self.faults.clone() })
    }

    /// Refuses a rover that begins on the goal of a hopper and may never leave it: one that covers ground, or one whose own goal is
    /// so near that it is done there.
    fn check_goals_are_open(&self, robots: &[Robot]) -> Result<(), ScenarioError> {
        for (number, robot) in robots.iter().enumerate() {
            let is_goal = |other: &Robot| other.vehicle == Vehicle::HopperTo { goal: robot.start.cell };
            let stays = match robot.vehicle {
                Vehicle::Rover { .. } => true,
                Vehicle::Driver { start, goal, goal_radius_m } => start.distance_m(goal) <= goal_radius_m,
                _ => false,
            };
            if stays && let Some(hopper) = robots.iter().position(is_goal) {
                let need = "another cell than the goal of a hopper, for a rover that covers ground or is at its goal";
                let got = format!("{} of robot {number}, the goal of robot {hopper}", robot.start.cell);
                return refuse("robots.start", need, got);
            }
        }
        Ok(())
    }

    /// The robots whose tasks a mixed mission needs to be done.
    pub(crate) fn required(&self) -> RobotSet {
        let needs = |rules: &RobotRules| rules.required.unwrap_or(rules.vehicle != VehicleKind::Helicopter);
        let robots = (0..).map(RobotId).zip(&self.robots).filter(|(_, rules)| needs(rules));
        robots.map(|(robot, _)| robot).fold(RobotSet(0), RobotSet::with)
    }

    /// The designs of hoppers that hop or see otherwise than `common`, checked, with what is left out filled in. No radius may be
    /// below `hop_m`, the length of a hop.
    pub(crate) fn designs(&mut self, common: Design, hop_m: f64) -> Result<Designs, ScenarioError> {
        let given = self.robots.iter_mut().enumerate();
        let given: Vec<_> =
            given.map(|(number, rules)| rules.design(number, common, hop_m)).collect::<Result<_, _>>()?;
        Designs::new(given).ok_or_else(|| ScenarioError::Value {
            field: "robots",
            need: "hoppers of at most 4 designs beside that of [robot]",
            got: "more".into(),
        })
    }

    /// Refuses what only robots of a mixed mission have.
    pub(crate) fn check_unmixed(&self) -> Result<(), ScenarioError> {
        for (number, rules) in self.robots.iter().enumerate() {
            let got = match (rules.goal, rules.required) {
                (Some([x, y]), _) => format!("goal ({x}, {y}) of robot {number}"),
                (None, Some(required)) => format!("required = {required} of robot {number}"),
                (None, None) => continue,
            };
            return refuse("robots.goal, required", "mission.kind = \"mixed\", for either", got);
        }
        let mut given = self.robots.iter().map(RobotRules::given_design).enumerate();
        match given.find_map(|(number, given)| Some((number, given?))) {
            None => Ok(()),
            Some((number, given)) => {
                let need = "mission.kind = \"mixed\" for launch_angle_deg, hard, sand and sensor, which are else those of [robot]";
                refuse("robots", need, format!("{given} of robot {number}"))
            }
        }
    }
}

impl RobotRules {
    /// Which field is given, if one is, of those by which hoppers differ.
    fn given_design(&self) -> Option<&'static str> {
        let given = [
            ("launch_angle_deg", self.launch_angle_deg.is_some()),
            ("hard", self.hard.is_some()),
            ("sand", self.sand.is_some()),
            ("sensor", self.sensor.is_some()),
        ];
        given.into_iter().find_map(|(field, is_given)| is_given.then_some(field))
    }

    /// How this hopper hops and sees, if it is another way than `common`.
    fn design(&mut self, number: usize, common: Design, hop_m: f64) -> Result<Option<Design>, ScenarioError> {
        let Some(given) = self.given_design() else { return Ok(None) };
        if self.vehicle != VehicleKind::Hopper {
            let got = format!("{given} of robot {number}, a {}", self.vehicle.name());
            return refuse("robots", "vehicle = \"hopper\" for launch_angle_deg, hard, sand and sensor", got);
        }
        let Design { mut motion, mut sensor } = common;
        if let Some(launch_angle_deg) = self.launch_angle_deg {
            check_launch_angle("robots.launch_angle_deg", launch_angle_deg)
                .map_err(|error| error.of_robot(number))?;
            motion.launch_angle_rad = launch_angle_deg.to_radians();
        }
        for (field, scatter) in [("robots.hard", self.hard), ("robots.sand", self.sand)] {
            let Some(given) = scatter else { continue };
            given.check(field).map_err(|error| error.of_robot(number))?;
            for probability in [given.intended, given.stuck, given.sideways] {
                in_range(field, probability, 0.0..=1.0, "probabilities, 0 to 1")
                    .map_err(|error| error.of_robot(number))?;
            }
        }
        motion.hard = self.hard.map_or(motion.hard, Into::into);
        motion.sand = self.sand.map_or(motion.sand, Into::into);
        if let Some(own) = &mut self.sensor {
            sensor.gain = *own.gain.get_or_insert(sensor.gain);
            sensor.offset_m = *own.offset_m.get_or_insert(sensor.offset_m);
            sensor.radius_min_m = *own.radius_min_m.get_or_insert(sensor.radius_min_m);
            sensor.radius_max_m = *own.radius_max_m.get_or_insert(sensor.radius_max_m);
            if sensor.radius_min_m.is_nan() || sensor.radius_min_m < hop_m * (1.0 - 1e-9) {
                let got = format!("{} m for robot {number} with hops of {hop_m} m", sensor.radius_min_m);
                let need = "at least one hop, so that the hopper sees where it may land";
                return refuse("robots.sensor.radius_min_m", need, got);
            }
            check_sensor(&sensor).map_err(|error| error.of_robot(number))?;
        }
        let design = Design { motion, sensor };
        Ok((design != common).then_some(design))
    }

    /// The robot of these rules in a mixed mission, with the defaults of a helicopter filled in.
    fn mixed(&mut self, number: usize, terrain: &Terrain) -> Result<Robot, ScenarioError> {
        let cell = place("robots.start", number, self.start, terrain)?;
        let start = Placement { cell, heading: self.heading };
        match (self.vehicle, self.goal) {
            (VehicleKind::Hopper, _) => {
                self.check_hopping(number)?;
                let goal = place("robots.goal", number, self.goal, terrain)?;
                for (field, cell) in [("robots.start", cell), ("robots.goal", goal)] {
                    if terrain.ground(cell).is_none_or(|ground| !ground.passable) {
                        let got = format!("{cell} of robot {number}");
                        return refuse(field, "ground on which a hopper survives landing", got);
                    }
                }
                if cell == goal || !terrain.grid.on_same_lattice(cell, goal) {
                    let need = "another cell than its start, whole hops away";
                    return refuse("robots.goal", need, format!("{goal} for robot {number} at {cell}"));
                }
                Ok(Robot { vehicle: Vehicle::HopperTo { goal }, sensor: Sensor::Disc, start })
            }
            (VehicleKind::Rover, Some(_)) => {
                self.check_driving(number)?;
                if terrain.prior.is_empty() {
                    let need = "none on ground without speeds: add truth.mobility, or leave it out for a rover that covers ground";
                    return refuse("robots.goal", need, format!("one for rover {number}"));
                }
                let trip =
                    trip(terrain, [self.start, self.goal], ["robots.start", "robots.goal"], Some(number))?;
                let point = |x_m, y_m| Waypoint { x_m, y_m };
                let vehicle = Vehicle::Driver {
                    start: point(trip.start.x_m, trip.start.y_m),
                    goal: point(trip.goal.at.x_m, trip.goal.at.y_m),
                    goal_radius_m: trip.goal.radius_m,
                };
                Ok(Robot { vehicle, sensor: Sensor::Track, start })
            }
            (VehicleKind::Rover, None) => {
                self.check_covering(number, terrain)?;
                Ok(self.covering())
            }
            (VehicleKind::Helicopter, Some([x, y])) => refuse(
                "robots.goal",
                "none for a helicopter, which looks ahead",
                format!("({x}, {y}) of robot {number}"),
            ),
            (VehicleKind::Helicopter, None) if self.required == Some(true) => refuse(
                "robots.required",
                "false for a helicopter, which has no task to do",
                format!("true for robot {number}"),
            ),
            (VehicleKind::Helicopter, None) if self.accuracy.is_some() && terrain.prior.is_empty() => {
                let need = "none on ground without speeds: a camera errs in the speeds of uncertain ground";
                refuse("robots.accuracy", need, format!("one for robot {number}"))
            }
            (VehicleKind::Helicopter, None) => {
                self.flying(number, Waypoint::middle_of(&terrain.grid, cell), cell)
            }
        }
    }
}

/// A cell of the map that is given.
fn place(
    field: &'static str,
    number: usize,
    given: Option<[i32; 2]>,
    terrain: &Terrain,
) -> Result<Cell, ScenarioError> {
    let Some([x, y]) = given else {
        return refuse(field, "a cell (x, y)", format!("nothing for robot {number}"));
    };
    let cell = Cell::new(x, y);
    if terrain.grid.contains(cell) {
        return Ok(cell);
    }
    refuse(field, "a cell on the map", format!("{cell} of robot {number}"))
}

/// Refuses a cell that two robots have.
fn check_distinct(
    field: &'static str,
    cells: impl Iterator<Item = (usize, Option<[i32; 2]>)>,
) -> Result<(), ScenarioError> {
    let mut known: Vec<(usize, [i32; 2])> = Vec::new();
    for (number, cell) in cells.filter_map(|(number, cell)| Some((number, cell?))) {
        if let Some((other, _)) = known.iter().find(|(_, of)| *of == cell) {
            let got = format!("({}, {}) of robot {number} and robot {other}", cell[0], cell[1]);
            return refuse(field, "a cell of its own for each robot on the ground", got);
        }
        known.push((number, cell));
    }
    Ok(())
}

/// Refuses a hopper's own sensor that no brief can hold, but for its least radius.
fn check_sensor(sensor: &SensorParameters) -> Result<(), ScenarioError> {
    let SensorParameters { gain, offset_m, radius_min_m, radius_max_m, .. } = *sensor;
    in_range("robots.sensor.gain", gain, 0.0..=1e6, "0 to 1e6")?;
    in_range("robots.sensor.offset_m", offset_m, -LENGTH_MAX_M..=LENGTH_MAX_M, "-1e6 to 1e6 m")?;
    in_range("robots.sensor.radius_max_m", radius_max_m, radius_min_m..=LENGTH_MAX_M, "radius_min_m to 1e6 m")
}
