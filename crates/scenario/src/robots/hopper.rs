//! A hopper of `[[robots]]`.

use contract::limits::{DECISIONS_MAX, LENGTH_MAX_M};
use contract::{Account, Cell, Direction, Goal, Placement, Robot, SensorParameters, SoilMotion, Visit};
#[cfg(test)]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::design::Design;
use super::site::{Given, Site};
use super::{Rules, is_north, is_yes, north, yes};
use crate::bounds::in_range;
use crate::error::refuse;
use crate::robot::{check_launch_angle, check_radius_min};
use crate::{Scatter, ScenarioError, exact};

/// A hopper: it hops to a goal, or from goal to goal in turn. Motion and sensor that it leaves out are those of `[robot]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct HopperRules {
    /// Cell (x, y) that it starts from; by default `brief.start`.
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "exact::optional")]
    pub start: Option<[i32; 2]>,
    /// Where it faces at the start: `north`, `east`, `south` or `west`.
    #[serde(skip_serializing_if = "is_north")]
    #[cfg_attr(test, schemars(with = "String", extend("enum" = ["north", "east", "south", "west"])))]
    pub heading: Direction,
    /// Whether the mission needs it to reach its goal.
    #[serde(skip_serializing_if = "is_yes")]
    pub required: bool,
    /// Planner that `hopper run` starts for it, unless told otherwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub planner: Option<String>,
    /// Launch angle above the horizontal, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub launch_angle_deg: Option<f64>,
    /// Cell (x, y) that it shall reach, or goals that it shall visit in turn; by default `brief.goal` or `brief.goals`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub goal: Option<HopperGoal>,
    /// Scatter of hops from hard ground.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hard: Option<Scatter>,
    /// Scatter of hops from sand.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sand: Option<Scatter>,
    /// How far it sees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensor: Option<OwnSensor>,
}

/// What a hopper shall do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(untagged, expecting = "need a cell [x, y], or { visit = [[x, y], ..], hops_max = N }")]
pub enum HopperGoal {
    /// Reach a cell (x, y).
    Reach(#[serde(deserialize_with = "exact::array")] [i32; 2]),
    /// Visit goals in turn.
    Visit(Visits),
}

/// Goals in turn, from the last to the first again, until the hops are flown; `limits.steps_max` does not apply.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Visits {
    /// Goals, 2 to 16 cells (x, y), each different from the one before it, and the first from the last.
    #[serde(deserialize_with = "exact::list")]
    pub visit: Vec<[i32; 2]>,
    /// Hops after which it is done; by default as many as a mission can count.
    #[serde(default = "Visits::most_hops", skip_serializing_if = "Visits::is_most_hops")]
    pub hops_max: u64,
}

impl Visits {
    /// Default of `hops_max`: as many hops as a mission can count.
    pub const HOPS_MAX: u64 = DECISIONS_MAX;

    pub(crate) fn most_hops() -> u64 {
        Self::HOPS_MAX
    }

    pub(crate) fn is_most_hops(hops_max: &u64) -> bool {
        *hops_max == Self::HOPS_MAX
    }
}

/// How far one hopper of several sees. What is left out is that of `[robot.sensor]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct OwnSensor {
    /// Metres of radius per metre of height.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gain: Option<f64>,
    /// Height above the datum that is added, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub offset_m: Option<f64>,
    /// Smallest radius, metres; not below one hop.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius_min_m: Option<f64>,
    /// Largest radius, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius_max_m: Option<f64>,
}

impl Default for HopperRules {
    /// The hopper of a scenario without `[[robots]]`.
    fn default() -> Self {
        Self {
            start: None,
            heading: north(),
            required: yes(),
            planner: None,
            launch_angle_deg: None,
            goal: None,
            hard: None,
            sand: None,
            sensor: None,
        }
    }
}

impl Rules for HopperRules {
    /// Fields that say what `[robot]` says are left out from then on.
    fn on(&mut self, site: &Site<'_>) -> Result<Robot, ScenarioError> {
        let grid = &site.terrain.grid;
        let start = site.start(self.start)?;
        let (goals, hops_max) = self.goals(site)?;
        let visit = match hops_max {
            Some(hops_max) => Some(visit(&goals, hops_max, site)?),
            None => None,
        };
        site.check_landing(start)?;
        goals.iter().try_for_each(|goal| site.check_landing(*goal))?;
        let Given { field, cell: goal } = goals[0];
        if site.account != Account::Hopper && start.cell == goal {
            return refuse(field, "another cell than the start", goal.to_string());
        }
        if let Some(off) = goals.iter().find(|goal| !grid.on_same_lattice(start.cell, goal.cell)) {
            let (hop_cells, start, goal) = (grid.hop_cells, start.cell, off.cell.to_string());
            return Err(ScenarioError::OffLattice { field, hop_cells, start, goal });
        }
        let Design { motion, sensor } = self.design(&site.common, grid.hop_distance_m())?;
        let hopper = Robot::hopper(grid, motion, sensor, [start.cell, goal]);
        Ok(Robot {
            start: Placement { cell: start.cell, heading: self.heading },
            goal: visit.map_or(hopper.goal, Goal::Visit),
            required: self.required,
            ..hopper
        })
    }

    fn account(&self) -> Account {
        Account::Hopper
    }

    fn hops(&self) -> bool {
        true
    }

    fn takes_start(&self, _: bool) -> bool {
        self.start.is_none()
    }

    fn takes_goal(&self, _: bool) -> bool {
        self.goal.is_none()
    }
}

impl HopperRules {
    /// Its goals, at least one, with the hops after which it is done if it visits them in turn.
    fn goals(&self, site: &Site<'_>) -> Result<(Vec<Given>, Option<u64>), ScenarioError> {
        let all = |field, cells: &[[i32; 2]]| cells.iter().map(|&cell| Given::of(field, cell)).collect();
        match &self.goal {
            Some(HopperGoal::Reach(cell)) => Ok((vec![site.goal(Some(*cell))?], None)),
            Some(HopperGoal::Visit(visits)) => Ok((all("robots.goal", &visits.visit), Some(visits.hops_max))),
            None if site.goals.is_empty() => Ok((vec![site.goal(None)?], None)),
            None => Ok((all("brief.goals", &site.goals), Some(site.hops_max))),
        }
    }

    /// How it hops and sees, checked: as `common`, but for what is given. No radius may be below `hop_m`, the length of a hop.
    fn design(&mut self, common: &Design, hop_m: f64) -> Result<Design, ScenarioError> {
        let Design { mut motion, mut sensor } = *common;
        if let Some(launch_angle_deg) = self.launch_angle_deg {
            check_launch_angle("robots.launch_angle_deg", launch_angle_deg)?;
            motion.launch_angle_rad = launch_angle_deg.to_radians();
        }
        for (field, scatter) in [("robots.hard", self.hard), ("robots.sand", self.sand)] {
            let Some(given) = scatter else { continue };
            given.check(field)?;
            for probability in [given.intended, given.stuck, given.sideways] {
                in_range(field, probability, 0.0..=1.0, "probabilities, 0 to 1")?;
            }
            if !(1..=2).contains(&given.flights) {
                return refuse(field, "1 or 2 flights", given.flights.to_string());
            }
        }
        motion.hard = self.hard.map_or(motion.hard, Into::into);
        motion.sand = self.sand.map_or(motion.sand, Into::into);
        if let Some(own) = &self.sensor {
            sensor.gain = own.gain.unwrap_or(sensor.gain);
            sensor.offset_m = own.offset_m.unwrap_or(sensor.offset_m);
            sensor.radius_min_m = own.radius_min_m.unwrap_or(sensor.radius_min_m);
            sensor.radius_max_m = own.radius_max_m.unwrap_or(sensor.radius_max_m);
            check_sensor(&sensor, hop_m)?;
        }
        self.forget_common(common);
        Ok(Design { motion, sensor })
    }

    /// Leaves out what says the same as `common`: a field at its default is none.
    fn forget_common(&mut self, common: &Design) {
        let Design { motion, sensor } = common;
        self.launch_angle_deg =
            self.launch_angle_deg.filter(|deg| deg.to_radians() != motion.launch_angle_rad);
        self.hard = self.hard.filter(|own| motion.hard != SoilMotion::from(*own));
        self.sand = self.sand.filter(|own| motion.sand != SoilMotion::from(*own));
        if let Some(own) = &mut self.sensor {
            own.gain = own.gain.filter(|gain| *gain != sensor.gain);
            own.offset_m = own.offset_m.filter(|offset_m| *offset_m != sensor.offset_m);
            own.radius_min_m = own.radius_min_m.filter(|radius_m| *radius_m != sensor.radius_min_m);
            own.radius_max_m = own.radius_max_m.filter(|radius_m| *radius_m != sensor.radius_max_m);
        }
        self.sensor = self.sensor.filter(|own| *own != OwnSensor::default());
    }
}

/// The visits of a hopper, which only the first robot may have, beside helicopters.
fn visit(goals: &[Given], hops_max: u64, site: &Site<'_>) -> Result<Visit, ScenarioError> {
    let field = goals.first().map_or("robots.goal", |goal| goal.field);
    let cells: Vec<Cell> = goals.iter().map(|goal| goal.cell).collect();
    if site.account != Account::Hopper {
        let need =
            "one cell: goals in turn are for a hopper alone, or for the first robot beside helicopters";
        return refuse(field, need, format!("{} cells", cells.len()));
    }
    if !(1..=DECISIONS_MAX).contains(&hops_max) {
        let field = if field == "brief.goals" { "brief.hops_max" } else { "robots.goal.hops_max" };
        return refuse(field, "1 to 4294967296 hops", hops_max.to_string());
    }
    match Visit::new(&cells, hops_max) {
        Some(visit) => Ok(visit),
        None => {
            let need = "2 to 16 cells, each different from the one before it, and the first from the last";
            let cells: Vec<String> = cells.iter().map(ToString::to_string).collect();
            refuse(field, need, format!("[{}]", cells.join(", ")))
        }
    }
}

/// Refuses a hopper's own sensor that no brief can hold.
fn check_sensor(sensor: &SensorParameters, hop_m: f64) -> Result<(), ScenarioError> {
    let SensorParameters { gain, offset_m, radius_min_m, radius_max_m, .. } = *sensor;
    check_radius_min("robots.sensor.radius_min_m", radius_min_m, hop_m)?;
    in_range("robots.sensor.gain", gain, 0.0..=1e6, "0 to 1e6")?;
    in_range("robots.sensor.offset_m", offset_m, -LENGTH_MAX_M..=LENGTH_MAX_M, "-1e6 to 1e6 m")?;
    in_range("robots.sensor.radius_max_m", radius_max_m, radius_min_m..=LENGTH_MAX_M, "radius_min_m to 1e6 m")
}
