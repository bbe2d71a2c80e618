//! Sections `[[robots]]` and `[[faults]]`: the robots of a mission, which a single hopper's has not.

use contract::limits::{LENGTH_MAX_M, ROBOTS_MAX};
use contract::{
    Body, Camera, Cell, Cover, Direction, Driver, ErringCamera, Goal, Grid, Helicopter, LookAhead, Name,
    Placement, Reach, Robot, RobotId, Rover, Sensor, Square, Track, Waypoint,
};
use helicopter::BUDGET_M;
#[cfg(test)]
use schemars::JsonSchema;
use scout_world::Trip;
use serde::{Deserialize, Serialize};
use terrain::Terrain;

use crate::mixed::Design;
use crate::{Scatter, Scenario, ScenarioError, exact};

/// A robot that fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Fault {
    /// Number of the robot, from 0.
    #[cfg_attr(test, schemars(with = "u16"))]
    pub robot: RobotId,
    /// Number of its action, from 1, that it no longer carries out. From then on it stands still.
    pub action: u64,
}

/// A robot of a team, as written in a scenario.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RobotRules {
    /// Its body: `rover`, which drives to neighbouring cells or, where it is scouted for, from point to point; `helicopter`;
    /// `hopper`, the first robot of a mission of kind `reach` or `patrol`, to which `[robot]` applies.
    #[serde(default)]
    pub vehicle: VehicleKind,
    /// Cell (x, y) that it starts from, where ground is to be covered and in mixed missions. All others start where the world
    /// or `brief.start` says.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "exact::optional")]
    pub start: Option<[i32; 2]>,
    /// Cell (x, y) that it shall reach, in mixed missions: of each hopper, and of a rover that drives over uncertain ground. A
    /// rover without one covers ground.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "exact::optional")]
    pub goal: Option<[i32; 2]>,
    /// Whether a mixed mission needs its task to be done; by default that of every robot but helicopters, which have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub required: Option<bool>,
    /// Where it faces at the start: `north`, `east`, `south` or `west`.
    #[serde(default = "north")]
    #[cfg_attr(test, schemars(with = "String", extend("enum" = ["north", "east", "south", "west"])))]
    pub heading: Direction,
    /// Speed of a rover that covers ground, on level ground, m/s; at most a cell a second. A helicopter's speed over ground. Of a
    /// rover that is scouted for, the ground has the speed; a hopper has none.
    #[serde(default = "one_metre")]
    pub speed_mps: f64,
    /// How far a rover that covers ground sees, cells to each side: 1 for the eight cells around it. Other robots have none.
    #[serde(default = "one_cell")]
    pub sensor_range_cells: u32,
    /// Length of all flights of a helicopter in a stage, metres; 300 by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub budget_m: Option<f64>,
    /// Radius of the ground that a helicopter sees, metres; 25 by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub view_radius_m: Option<f64>,
    /// Probability that a helicopter reads the speed of a cell right, 0 to 1, the other three speeds being equally likely; 1
    /// by default. The same for all helicopters that err. Only on uncertain ground.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<f64>,
    /// Planner that `hopper run` starts for it, unless told otherwise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub planner: Option<String>,
    /// Launch angle of a hopper in a mixed mission, degrees; by default that of `[robot]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub launch_angle_deg: Option<f64>,
    /// Scatter from hard ground of a hopper in a mixed mission; by default that of `[robot]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hard: Option<Scatter>,
    /// Scatter from sand of a hopper in a mixed mission; by default that of `[robot]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sand: Option<Scatter>,
    /// How far a hopper in a mixed mission sees; by default as far as `[robot.sensor]` says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensor: Option<OwnSensor>,
}

/// How far one hopper of several sees. What is left out is that of `[robot.sensor]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct OwnSensor {
    /// Metres of radius per metre of height.
    pub gain: Option<f64>,
    /// Height above the datum that is added, metres.
    pub offset_m: Option<f64>,
    /// Smallest radius, metres; not below one hop.
    pub radius_min_m: Option<f64>,
    /// Largest radius, metres.
    pub radius_max_m: Option<f64>,
}

/// The kind of a robot's body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum VehicleKind {
    /// Drives to one of four neighbouring cells at a time.
    #[default]
    Rover,
    /// Flies from point to point and looks ahead for a rover or a hopper.
    Helicopter,
    /// Hops.
    Hopper,
}

impl VehicleKind {
    /// As written in a scenario.
    pub(crate) fn name(self) -> &'static str {
        match self {
            VehicleKind::Rover => "rover",
            VehicleKind::Helicopter => "helicopter",
            VehicleKind::Hopper => "hopper",
        }
    }
}

impl Scenario {
    /// The robots on their terrain, checked: a hopper alone, or those of `[[robots]]`.
    pub(crate) fn robots_on(
        &mut self,
        terrain: &Terrain,
        trip: Option<&Trip>,
    ) -> Result<Vec<Robot>, ScenarioError> {
        if !self.mission.is_of_hopper() {
            self.check_no_ends()?;
            self.mission.resolve_visits(Cell::default())?;
        }
        let cover = self.mission.resolve_cover(self.covers())?;
        if self.mission.is_mixed() {
            return self.mixed_on(terrain, cover);
        }
        self.check_unmixed()?;
        if trip.is_some() != self.mission.is_scout() {
            return Err(ScenarioError::Value {
                field: "mission.kind",
                need: "scout or mixed with truth.terrain.passages or truth.mobility, and no other with either",
                got: if trip.is_some() {
                    "uncertain ground in another mission"
                } else {
                    "scout on other ground"
                }
                .into(),
            });
        }
        if let Some(trip) = trip {
            return self.scouts_on(trip, &terrain.grid);
        }
        let (robots, faults) = (&self.robots, &self.faults);
        if !self.mission.is_cover() {
            return match (robots.is_empty(), faults.is_empty()) {
                (true, true) => Ok(vec![self.hopper_on(&terrain.grid)?]),
                (false, _) => self.accompanied_on(terrain),
                (true, false) => refuse("faults", "robots that may fail", "none".into()),
            };
        }
        if !(1..=ROBOTS_MAX).contains(&robots.len()) {
            return refuse("robots", "1 to 16 of them, each with a start", robots.len().to_string());
        }
        for (number, rules) in robots.iter().enumerate() {
            rules.check(number, terrain, &robots[..number])?;
        }
        self.check_faults()?;
        Ok(robots.iter().map(|rules| rules.covering(&terrain.grid, cover)).collect())
    }

    /// Whether a rover covers ground.
    fn covers(&self) -> bool {
        let has_no_goal = |rules: &RobotRules| rules.vehicle == VehicleKind::Rover && rules.goal.is_none();
        self.mission.is_cover() || self.mission.is_mixed() && self.robots.iter().any(has_no_goal)
    }

    /// The hopper that the mission is of.
    fn hopper_on(&mut self, grid: &Grid) -> Result<Robot, ScenarioError> {
        let [start, goal] = self.ends()?;
        let Design { motion, sensor } = self.design();
        let hopper = Robot::hopper(grid, motion, sensor, [start, goal]);
        let visits = self.mission.resolve_visits(goal)?;
        Ok(Robot { goal: visits.map_or(hopper.goal, Goal::Visit), ..hopper })
    }

    /// A hopper with its helicopters, checked.
    fn accompanied_on(&mut self, terrain: &Terrain) -> Result<Vec<Robot>, ScenarioError> {
        let hoppers = self.robots.iter().filter(|rules| rules.vehicle == VehicleKind::Hopper).count();
        let is_first = self.robots.first().is_some_and(|rules| rules.vehicle == VehicleKind::Hopper);
        if !(2..=ROBOTS_MAX).contains(&self.robots.len()) || hoppers != 1 || !is_first {
            let need = "a hopper and 1 to 15 helicopters, the hopper first; or mission.kind = \"cover\" or \"scout\"";
            let (others, first) =
                (self.robots.len() - hoppers, if is_first { ", one of them first" } else { "" });
            return refuse("robots", need, format!("{hoppers} hoppers{first}, and {others} others"));
        }
        self.check_faults()?;
        let hopper = self.hopper_on(&terrain.grid)?;
        let (cell, start_at) = (hopper.start.cell, hopper.start_at);
        if !terrain.grid.contains(cell) {
            return refuse("brief.start", "a cell on the map", cell.to_string());
        }
        let robot = |(number, rules): (usize, &mut RobotRules)| match rules.vehicle {
            VehicleKind::Hopper => rules.hopping(number, hopper),
            VehicleKind::Helicopter if rules.accuracy.is_some() => {
                let need = "nothing beside a hopper: a camera errs in the speeds of uncertain ground";
                refuse("robots.accuracy", need, format!("one for robot {number}"))
            }
            VehicleKind::Helicopter => {
                rules.check_without_start(number)?;
                rules.flying(number, start_at, cell)
            }
            VehicleKind::Rover => {
                refuse("robots.vehicle", "helicopter, beside a hopper", format!("rover for robot {number}"))
            }
        };
        self.robots.iter_mut().enumerate().map(robot).collect()
    }

    /// A rover on `trip` with its helicopters, checked.
    fn scouts_on(&mut self, trip: &Trip, grid: &Grid) -> Result<Vec<Robot>, ScenarioError> {
        if !(1..=ROBOTS_MAX).contains(&self.robots.len()) {
            return refuse(
                "robots",
                "1 to 16 of them, one of which is a rover",
                self.robots.len().to_string(),
            );
        }
        let rovers = self.robots.iter().filter(|rules| rules.vehicle == VehicleKind::Rover).count();
        if rovers != 1 {
            return refuse("robots.vehicle", "one rover in a mission of kind scout", rovers.to_string());
        }
        self.check_faults()?;
        let robots = self.robots.iter_mut().enumerate();
        let robots: Vec<Robot> =
            robots.map(|(number, rules)| rules.scouting(number, trip, grid)).collect::<Result<_, _>>()?;
        self.check_accuracies(&robots)?;
        Ok(robots)
    }

    /// Checks that all cameras that err do so alike.
    pub(crate) fn check_accuracies(&self, robots: &[Robot]) -> Result<(), ScenarioError> {
        let mut accuracies = robots.iter().filter_map(|robot| robot.sensor.accuracy());
        if let Some(first) = accuracies.next()
            && let Some(other) = accuracies.find(|other| *other != first)
        {
            let need = "the same for all helicopters that err";
            return refuse("robots.accuracy", need, format!("{first} and {other}"));
        }
        Ok(())
    }

    pub(crate) fn check_faults(&self) -> Result<(), ScenarioError> {
        let Self { robots, faults, .. } = self;
        for (number, fault) in faults.iter().enumerate() {
            let known = usize::from(fault.robot.0) < robots.len();
            let again = faults[..number].iter().any(|other| other.robot == fault.robot);
            if !known || again || fault.action == 0 {
                let (field, need) = ("faults", "a robot of the mission, each once, and an action from 1");
                let got = format!("robot {}, action {}", fault.robot, fault.action);
                return Err(ScenarioError::Value { field, need, got });
            }
        }
        Ok(())
    }

    /// The planners that robots name, in the order of their numbers.
    ///
    /// # Errors
    /// [`ScenarioError::Planner`] if one cannot be a planner's name.
    pub fn planners(&self) -> Result<Vec<Option<Name>>, ScenarioError> {
        let name = |(robot, rules): (usize, &RobotRules)| {
            let name = rules.planner.as_deref().map(str::parse).transpose();
            name.map_err(|error| ScenarioError::Planner { robot, error })
        };
        self.robots.iter().enumerate().map(name).collect()
    }
}

impl RobotRules {
    fn check(&self, number: usize, terrain: &Terrain, before: &[Self]) -> Result<(), ScenarioError> {
        if self.vehicle != VehicleKind::Rover {
            let (field, need) = ("robots.vehicle", "rover, where ground is to be covered");
            return refuse(field, need, format!("{} for robot {number}", self.vehicle.name()));
        }
        self.check_covering(number, terrain)?;
        if let (Some([x, y]), Some(other)) =
            (self.start, before.iter().position(|other| other.start == self.start))
        {
            let need = "a cell of its own for each robot";
            return refuse("robots.start", need, format!("({x}, {y}) of robot {number} and robot {other}"));
        }
        Ok(())
    }

    /// Checks what a rover needs that covers ground.
    pub(crate) fn check_covering(&self, number: usize, terrain: &Terrain) -> Result<(), ScenarioError> {
        self.check_grounded(number)?;
        let Some([x, y]) = self.start else {
            return refuse("robots.start", "a cell (x, y)", format!("nothing for robot {number}"));
        };
        let got = format!("({x}, {y}) of robot {number}");
        match terrain.ground(Cell::new(x, y)) {
            None => return refuse("robots.start", "a cell on the map", got),
            Some(ground) if !ground.is_drivable() => {
                return refuse("robots.start", "ground without obstacle", got);
            }
            Some(_) => {}
        }
        let fastest_mps = terrain.grid.cell_size_m;
        if !(1.0e-9..=fastest_mps).contains(&self.speed_mps) {
            let need = "above 0 and at most one cell a second, since an action lasts a second at least";
            return refuse("robots.speed_mps", need, format!("{} for robot {number}", self.speed_mps));
        }
        if !(1..=Square::RANGE_MAX_CELLS).contains(&self.sensor_range_cells) {
            let got = format!("{} for robot {number}", self.sensor_range_cells);
            return refuse("robots.sensor_range_cells", "1 to 64", got);
        }
        Ok(())
    }
}

impl RobotRules {
    /// The rover of these rules, which were checked, in a mission that covers ground.
    pub(crate) fn covering(&self, grid: &Grid, cover: Cover) -> Robot {
        let [x, y] = self.start.unwrap_or_default();
        let cell = Cell::new(x, y);
        Robot {
            body: Body::Rover(Rover { speed_mps: self.speed_mps }),
            sensor: Sensor::Square(Square { range_cells: self.sensor_range_cells }),
            start: Placement { cell, heading: self.heading },
            start_at: Waypoint::middle_of(grid, cell),
            goal: Goal::Cover(cover),
            required: self.is_required(),
        }
    }

    /// The rover of these rules on its trip, which was checked.
    pub(crate) fn driving(&self, trip: &Trip, grid: &Grid) -> Robot {
        let point = |point: rover::Point| Waypoint { x_m: point.x_m, y_m: point.y_m };
        let start_at = point(trip.start);
        Robot {
            body: Body::Driver(Driver {}),
            sensor: Sensor::Track(Track {}),
            start: Placement { cell: start_at.cell_of(grid), heading: self.heading },
            start_at,
            goal: Goal::Reach(Reach { at: point(trip.goal.at), radius_m: trip.goal.radius_m }),
            required: self.is_required(),
        }
    }

    /// Whether the mission needs its task to be done.
    pub(crate) fn is_required(&self) -> bool {
        self.required.unwrap_or(self.vehicle != VehicleKind::Helicopter)
    }

    /// The robot of these rules on `trip`, with the defaults of a helicopter filled in.
    fn scouting(&mut self, number: usize, trip: &Trip, grid: &Grid) -> Result<Robot, ScenarioError> {
        self.check_without_start(number)?;
        match self.vehicle {
            VehicleKind::Helicopter => {
                let start_at = Waypoint { x_m: trip.start.x_m, y_m: trip.start.y_m };
                self.flying(number, start_at, start_at.cell_of(grid))
            }
            VehicleKind::Hopper => {
                refuse("robots.vehicle", "rover or helicopter", format!("hopper for robot {number}"))
            }
            VehicleKind::Rover => {
                self.check_driving(number)?;
                Ok(self.driving(trip, grid))
            }
        }
    }

    /// `hopper`, facing as these rules say.
    fn hopping(&self, number: usize, hopper: Robot) -> Result<Robot, ScenarioError> {
        self.check_hopping(number)?;
        self.check_without_start(number)?;
        Ok(Robot { start: Placement { heading: self.heading, ..hopper.start }, ..hopper })
    }

    /// The helicopter of these rules, at `start_at` above `cell`, with the defaults filled in.
    pub(crate) fn flying(
        &mut self,
        number: usize,
        start_at: Waypoint,
        cell: Cell,
    ) -> Result<Robot, ScenarioError> {
        self.check_without_range(number)?;
        let got = |value: f64| format!("{value} for robot {number}");
        let budget_m = *self.budget_m.get_or_insert(BUDGET_M);
        if !(0.0..=LENGTH_MAX_M).contains(&budget_m) {
            return refuse("robots.budget_m", "0 to 1e6 m", got(budget_m));
        }
        let radius_m = *self.view_radius_m.get_or_insert_with(|| helicopter::Camera::default().radius_m());
        if !(1.0e-3..=Camera::RADIUS_MAX_M).contains(&radius_m) {
            return refuse("robots.view_radius_m", "0.001 to 1000 m", got(radius_m));
        }
        if !(1.0e-3..=1.0e3).contains(&self.speed_mps) {
            return refuse("robots.speed_mps", "0.001 to 1000 m/s", got(self.speed_mps));
        }
        if let Some(accuracy) = self.accuracy.filter(|accuracy| !(0.0..=1.0).contains(accuracy)) {
            return refuse("robots.accuracy", "a probability, 0 to 1", got(accuracy));
        }
        Ok(Robot {
            body: Body::Helicopter(Helicopter { speed_mps: self.speed_mps, budget_m }),
            sensor: match self.accuracy.filter(|accuracy| *accuracy < 1.0) {
                None => Sensor::Camera(Camera { radius_m }),
                Some(accuracy) => Sensor::ErringCamera(ErringCamera { radius_m, accuracy }),
            },
            start: Placement { cell, heading: self.heading },
            start_at,
            goal: Goal::LookAhead(LookAhead {}),
            required: false,
        })
    }

    fn check_without_start(&self, number: usize) -> Result<(), ScenarioError> {
        let Some([x, y]) = self.start else { return Ok(()) };
        let (field, need) = ("robots.start", "none: the robots start where the world or brief.start says");
        refuse(field, need, format!("({x}, {y}) of robot {number}"))
    }

    /// Checks that no speed and no range of sight are given, which a hopper has from elsewhere.
    pub(crate) fn check_hopping(&self, number: usize) -> Result<(), ScenarioError> {
        self.check_grounded(number)?;
        self.check_without_range(number)?;
        if self.speed_mps == one_metre() {
            return Ok(());
        }
        refuse(
            "robots.speed_mps",
            "a rover or a helicopter",
            format!("{} for robot {number}, a hopper", self.speed_mps),
        )
    }

    /// Checks the speed of a rover with a goal, though the ground has the speed, and that no range of sight is given.
    pub(crate) fn check_driving(&self, number: usize) -> Result<(), ScenarioError> {
        self.check_grounded(number)?;
        self.check_without_range(number)?;
        if (1.0e-9..=1.0e3).contains(&self.speed_mps) {
            return Ok(());
        }
        refuse(
            "robots.speed_mps",
            "above 0 and at most 1000 m/s",
            format!("{} for robot {number}", self.speed_mps),
        )
    }

    /// Checks that no range of sight is given in cells, which only a rover that covers ground has.
    fn check_without_range(&self, number: usize) -> Result<(), ScenarioError> {
        if self.sensor_range_cells == one_cell() {
            return Ok(());
        }
        let got = format!("{} for robot {number}", self.sensor_range_cells);
        refuse(
            "robots.sensor_range_cells",
            "a rover that covers ground: others see as far as their sensor",
            got,
        )
    }

    /// Checks that nothing is given which only a helicopter has.
    pub(crate) fn check_grounded(&self, number: usize) -> Result<(), ScenarioError> {
        if self.budget_m.is_none() && self.view_radius_m.is_none() && self.accuracy.is_none() {
            return Ok(());
        }
        let (field, need) = ("robots.budget_m, view_radius_m, accuracy", "vehicle = \"helicopter\"");
        refuse(field, need, format!("{} for robot {number}", self.vehicle.name()))
    }
}

pub(crate) fn refuse<T>(field: &'static str, need: &'static str, got: String) -> Result<T, ScenarioError> {
    Err(ScenarioError::Value { field, need, got })
}

fn north() -> Direction {
    Direction::North
}

fn one_metre() -> f64 {
    1.0
}

fn one_cell() -> u32 {
    1
}
