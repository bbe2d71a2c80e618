//! `[[robots]]` of missions of kind `mixed`: robots of any kind, each with a start and a task of its own.

use contract::limits::{DESIGNS_MAX, LENGTH_MAX_M, ROBOTS_MAX};
use contract::{
    Cell, Cover, CoverMode, Goal, Grid, MotionParameters, Placement, Robot, SensorParameters, Waypoint,
};
use terrain::Terrain;

use crate::bounds::in_range;
use crate::mobility::trip;
use crate::robot::check_launch_angle;
use crate::robots::refuse;
use crate::{RobotRules, Scenario, ScenarioError, VehicleKind};

/// How a hopper hops and sees.
#[derive(Clone, Copy)]
pub(crate) struct Design {
    pub motion: MotionParameters,
    pub sensor: SensorParameters,
}

impl Scenario {
    /// The robots of a mixed mission on their terrain, checked.
    pub(crate) fn mixed_on(&mut self, terrain: &Terrain, cover: Cover) -> Result<Vec<Robot>, ScenarioError> {
        if !(1..=ROBOTS_MAX).contains(&self.robots.len()) {
            let need = "1 to 16 of them, each with a start";
            return refuse("robots", need, self.robots.len().to_string());
        }
        let common = self.design();
        let robots = self.robots.iter_mut().enumerate();
        let robots = robots.map(|(number, rules)| rules.mixed(number, terrain, cover, common));
        let robots: Vec<Robot> = robots.collect::<Result<_, _>>()?;
        let is_grounded = |number: usize| robots[number].body.is_on_ground();
        let starts = (0..robots.len()).filter(|number| is_grounded(*number));
        check_distinct("robots.start", starts.map(|number| (number, self.robots[number].start)))?;
        check_distinct("robots.goal", (0..robots.len()).map(|number| (number, self.robots[number].goal)))?;
        check_goals_are_open(&robots, &terrain.grid)?;
        if self.mission.mode == Some(CoverMode::Voronoi) {
            let need =
                "overlap: a region would stay uncovered for good where its rover, or the way to it, is lost";
            return refuse("mission.mode", need, "voronoi".into());
        }
        self.check_faults()?;
        self.check_accuracies(&robots)?;
        if !robots.iter().any(|robot| robot.required) {
            return refuse("robots.required", "at least one robot that the mission needs", "none".into());
        }
        let mut designs = vec![(&common.motion, &common.sensor)];
        for design in robots.iter().filter_map(Robot::as_hopper) {
            if !designs.contains(&design) {
                designs.push(design);
            }
        }
        if designs.len() > 1 + DESIGNS_MAX {
            return refuse("robots", "hoppers of at most 4 designs beside that of [robot]", "more".into());
        }
        Ok(robots)
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

    /// How this hopper hops and sees, checked: as `common`, but for what is given. No radius may be below `hop_m`, the length of a
    /// hop.
    fn design(&mut self, number: usize, common: Design, hop_m: f64) -> Result<Design, ScenarioError> {
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
        Ok(Design { motion, sensor })
    }

    /// The robot of these rules in a mixed mission, with the defaults of a helicopter filled in.
    fn mixed(
        &mut self,
        number: usize,
        terrain: &Terrain,
        cover: Cover,
        common: Design,
    ) -> Result<Robot, ScenarioError> {
        let grid = &terrain.grid;
        let cell = place("robots.start", number, self.start, terrain)?;
        if self.vehicle != VehicleKind::Hopper
            && let Some(given) = self.given_design()
        {
            let got = format!("{given} of robot {number}, a {}", self.vehicle.name());
            return refuse("robots", "vehicle = \"hopper\" for launch_angle_deg, hard, sand and sensor", got);
        }
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
                if cell == goal || !grid.on_same_lattice(cell, goal) {
                    let need = "another cell than its start, whole hops away";
                    return refuse("robots.goal", need, format!("{goal} for robot {number} at {cell}"));
                }
                let Design { motion, sensor } = self.design(number, common, grid.hop_distance_m())?;
                Ok(Robot {
                    start: Placement { cell, heading: self.heading },
                    required: self.is_required(),
                    ..Robot::hopper(grid, motion, sensor, [cell, goal])
                })
            }
            (VehicleKind::Rover, Some(_)) => {
                self.check_driving(number)?;
                if terrain.prior.is_empty() {
                    let need = "none on ground without speeds: add truth.mobility, or leave it out for a rover that covers ground";
                    return refuse("robots.goal", need, format!("one for rover {number}"));
                }
                let trip =
                    trip(terrain, [self.start, self.goal], ["robots.start", "robots.goal"], Some(number))?;
                Ok(self.driving(&trip, grid))
            }
            (VehicleKind::Rover, None) => {
                self.check_covering(number, terrain)?;
                Ok(self.covering(grid, cover))
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
            (VehicleKind::Helicopter, None) => self.flying(number, Waypoint::middle_of(grid, cell), cell),
        }
    }
}

/// Refuses a rover that begins on the goal of a hopper and may never leave it: one that covers ground, or one whose own goal is so
/// near that it is done there.
fn check_goals_are_open(robots: &[Robot], grid: &Grid) -> Result<(), ScenarioError> {
    for (number, robot) in robots.iter().enumerate() {
        let is_goal = |other: &Robot| other.body.hops() && other.goal.cell(grid, 0) == Some(robot.start.cell);
        let stays = match robot.goal {
            Goal::Cover(_) => true,
            Goal::Reach(goal) => robot.body.drives() && robot.start_at.distance_m(goal.at) <= goal.radius_m,
            Goal::Visit(_) | Goal::LookAhead(_) => false,
        };
        if stays && let Some(hopper) = robots.iter().position(is_goal) {
            let need =
                "another cell than the goal of a hopper, for a rover that covers ground or is at its goal";
            let got = format!("{} of robot {number}, the goal of robot {hopper}", robot.start.cell);
            return refuse("robots.start", need, got);
        }
    }
    Ok(())
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
