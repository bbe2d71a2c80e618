//! Sections `[[robots]]` and `[[faults]]`: the robots of a mission, each a body with fields of its own.
//!
//! What a mission is follows from its robots: see [`Scenario::account`].

mod design;
mod read;
mod site;

use contract::limits::ROBOTS_MAX;
use contract::{Account, Cell, CoverMode, Direction, Grid, Name, Robot, RobotId};
#[cfg(test)]
use schemars::JsonSchema;
use scout_world::Trip;
use serde::{Deserialize, Serialize};
use terrain::{Relief, Terrain};
use toml::de::{Error, ValueDeserializer};

use crate::error::refuse;
use crate::{Scenario, ScenarioError};

pub(crate) use design::Design;
pub(crate) use read::read;
use site::Site;

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

/// What a robot written in a scenario comes to: the fields of each body implement it.
trait Rules {
    /// The robot on its ground, checked. Fields that say what holds anyway are left out from then on.
    fn on(&mut self, site: &Site<'_>) -> Result<Robot, ScenarioError>;

    /// What states of the mission tell if all others look ahead.
    fn account(&self) -> Account {
        Account::ActionsWithoutWaits
    }

    /// Whether it hops, so that the ground needs cells of which a hop spans a whole number.
    fn hops(&self) -> bool {
        false
    }

    /// Whether it looks ahead for the others, and may begin where the first of them does.
    fn looks_ahead(&self) -> bool {
        false
    }

    /// Whether it starts where the brief says. `has_trip` is whether the ground gives drivers start and goal.
    fn takes_start(&self, has_trip: bool) -> bool {
        let _ = has_trip;
        false
    }

    /// Whether its goal is that of the brief.
    fn takes_goal(&self, has_trip: bool) -> bool {
        let _ = has_trip;
        false
    }
}

/// Declares the bodies, one line each: its module, its variant with its fields, and what it is. The name in scenarios is that of the
/// module, and every body has a field `planner`.
macro_rules! bodies {
    ($($module:ident => $body:ident($rules:ident), $what:literal;)+) => {
        $(mod $module;)+
        $(pub use self::$module::*;)+

        /// A robot of a team, as written in a scenario: its body, and the fields that this body has.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[cfg_attr(test, derive(JsonSchema))]
        #[serde(tag = "body", rename_all = "snake_case")]
        pub enum RobotRules {
            $(#[doc = $what] $body($rules),)+
        }

        /// The body of a robot, as written in a scenario.
        #[derive(Clone, Copy, Deserialize)]
        #[serde(rename_all = "snake_case")]
        enum Body {
            $($body,)+
        }

        impl Body {
            /// A robot of this body with these fields, and the body's name.
            fn read(self, fields: ValueDeserializer<'_>) -> (Result<RobotRules, Error>, &'static str) {
                match self {
                    $(Body::$body => {
                        ($rules::deserialize(fields).map(RobotRules::$body), stringify!($module))
                    })+
                }
            }
        }

        impl RobotRules {
            /// Every body, as written in a scenario.
            pub const BODIES: &[&'static str] = &[$(stringify!($module)),+];

            /// Its body, as written in a scenario.
            #[must_use]
            pub fn body(&self) -> &'static str {
                match self {
                    $(RobotRules::$body(_) => stringify!($module),)+
                }
            }

            /// The planner that `hopper run` starts for it, unless told otherwise.
            #[must_use]
            pub fn planner(&self) -> Option<&str> {
                match self {
                    $(RobotRules::$body($rules { planner, .. }) => planner.as_deref(),)+
                }
            }

            /// Forgets its planner, which changes no outcome by itself.
            pub(crate) fn forget_planner(&mut self) {
                match self {
                    $(RobotRules::$body($rules { planner, .. }) => *planner = None,)+
                }
            }

            fn rules(&self) -> &dyn Rules {
                match self {
                    $(RobotRules::$body(rules) => rules,)+
                }
            }

            fn rules_mut(&mut self) -> &mut dyn Rules {
                match self {
                    $(RobotRules::$body(rules) => rules,)+
                }
            }
        }
    };
}

bodies! {
    hopper => Hopper(HopperRules), "Hops from cell to cell.";
    rover => Rover(RoverRules), "Drives to one of four neighbouring cells at a time, and covers ground.";
    driver => Driver(DriverRules), "Drives from point to point over ground of uncertain speed.";
    helicopter => Helicopter(HelicopterRules), "Flies from point to point, and looks ahead for the others.";
}

impl RobotRules {
    /// Whether it is a hopper that sees as far as it says itself.
    pub(crate) fn has_own_radius(&self) -> bool {
        let RobotRules::Hopper(HopperRules { sensor: Some(own), .. }) = self else { return false };
        *own != OwnSensor::default()
    }

    /// The launch angle of a hopper that has its own, degrees.
    pub(crate) fn own_launch_angle_deg(&self) -> Option<f64> {
        let RobotRules::Hopper(HopperRules { launch_angle_deg, .. }) = self else { return None };
        *launch_angle_deg
    }
}

impl Scenario {
    /// What states of the mission tell, and what its limit counts: a hopper's steps, if it is first and all others are helicopters; all
    /// actions, if there is one driver and all others are helicopters; otherwise the actions by which no robot waits for others.
    #[must_use]
    pub fn account(&self) -> Account {
        let mut others = self.robots.iter().enumerate().filter(|(_, robot)| !robot.rules().looks_ahead());
        match (others.next(), others.next()) {
            (None, _) if self.robots.is_empty() => Account::Hopper,
            (Some((number, robot)), None) => match robot.rules().account() {
                Account::Hopper if number > 0 => Account::ActionsWithoutWaits,
                account => account,
            },
            _ => Account::ActionsWithoutWaits,
        }
    }

    /// Whether a robot hops, so that the ground needs cells of which a hop spans a whole number.
    pub(crate) fn has_hoppers(&self) -> bool {
        self.robots.is_empty() || self.robots.iter().any(|robot| robot.rules().hops())
    }

    /// The robots on their terrain, checked: a hopper alone, or those of `[[robots]]`. `trip` has start and goal of a driver that has
    /// none of its own, where the ground gives them.
    pub(crate) fn robots_on(
        &mut self,
        terrain: &Terrain,
        relief: &Relief,
        trip: Option<Trip>,
    ) -> Result<Vec<Robot>, ScenarioError> {
        self.check_ends(trip.is_some())?;
        let mut site = Site {
            terrain,
            relief,
            trip,
            first: None,
            account: self.account(),
            is_short: self.robots.is_empty(),
            start: self.brief.start,
            goal: self.brief.goal,
            goals: self.brief.goals.clone(),
            hops_max: self.brief.hops_max,
            common: self.design(),
        };
        let robots = match self.robots.is_empty() {
            true => vec![HopperRules::default().on(&site)?],
            false => self.listed_on(&mut site)?,
        };
        check_distinct(&robots, &terrain.grid)?;
        check_goals_are_open(&robots, &terrain.grid)?;
        check_cover(&robots)?;
        check_accuracies(&robots)?;
        if !robots.iter().any(|robot| robot.required) {
            return refuse("robots.required", "at least one robot that the mission needs", "none".into());
        }
        self.check_faults()?;
        Ok(robots)
    }

    /// The robots of `[[robots]]`: first those on the ground, then those that look ahead, which may begin with them.
    fn listed_on(&mut self, site: &mut Site<'_>) -> Result<Vec<Robot>, ScenarioError> {
        let count = self.robots.len();
        if count > ROBOTS_MAX {
            return refuse("robots", "1 to 16 of them", count.to_string());
        }
        let mut robots: Vec<Option<Robot>> = vec![None; count];
        for look_ahead in [false, true] {
            for (number, rules) in self.robots.iter_mut().enumerate() {
                let rules = rules.rules_mut();
                if rules.looks_ahead() == look_ahead {
                    robots[number] = Some(rules.on(site).map_err(|error| error.of_robot(number))?);
                }
            }
            site.first = robots.iter().flatten().next().copied();
            if site.first.is_none() {
                let need = "at least one robot that hops or drives: helicopters look ahead for others";
                return refuse("robots.body", need, "helicopters alone".into());
            }
        }
        Ok(robots.into_iter().flatten().collect())
    }

    /// Refuses `brief.start`, `brief.goal` and `brief.goals` where no robot takes them, and goals that are written twice.
    fn check_ends(&self, has_trip: bool) -> Result<(), ScenarioError> {
        let brief = &self.brief;
        if brief.goal.is_some() && !brief.goals.is_empty() {
            return refuse("brief.goals", "brief.goal, or brief.goals with all goals in turn", "both".into());
        }
        if brief.goals.is_empty() && brief.hops_max != Visits::HOPS_MAX {
            return refuse("brief.hops_max", "brief.goals, the goals in turn", brief.hops_max.to_string());
        }
        let takes_start = |robot: &RobotRules| robot.rules().takes_start(has_trip);
        let takes_goal = |robot: &RobotRules| robot.rules().takes_goal(has_trip);
        let is_short = self.robots.is_empty();
        let given = |cell: Option<[i32; 2]>| cell.map(|[x, y]| format!("({x}, {y})"));
        if let Some(got) = given(brief.start)
            && !is_short
            && !self.robots.iter().any(takes_start)
        {
            return refuse("brief.start", "none, since no robot takes its start from there", got);
        }
        let goals = (!brief.goals.is_empty()).then(|| format!("{:?}", brief.goals));
        if let Some(got) = given(brief.goal).or(goals)
            && !is_short
            && !self.robots.iter().any(takes_goal)
        {
            let field = if brief.goal.is_some() { "brief.goal" } else { "brief.goals" };
            return refuse(field, "none, since no robot takes its goal from there", got);
        }
        Ok(())
    }

    fn check_faults(&self) -> Result<(), ScenarioError> {
        let Self { robots, faults, .. } = self;
        if !faults.is_empty() && robots.len() <= 1 && self.account() == Account::Hopper {
            return refuse("faults", "several robots, of which some may fail", "a hopper alone".into());
        }
        for (number, fault) in faults.iter().enumerate() {
            let known = usize::from(fault.robot.0) < robots.len();
            let again = faults[..number].iter().any(|other| other.robot == fault.robot);
            if !known || again || fault.action == 0 {
                let got = format!("robot {}, action {}", fault.robot, fault.action);
                return refuse("faults", "a robot of the mission, each once, and an action from 1", got);
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
            let name = rules.planner().map(str::parse).transpose();
            name.map_err(|error| ScenarioError::Planner { robot, error })
        };
        self.robots.iter().enumerate().map(name).collect()
    }
}

/// Refuses a cell on which two robots on the ground begin, or which is the goal of two.
fn check_distinct(robots: &[Robot], grid: &Grid) -> Result<(), ScenarioError> {
    let start = |robot: &Robot| robot.body.is_on_ground().then_some(robot.start.cell);
    let goal = |robot: &Robot| robot.goal.cell(grid, 0);
    let cells: [(&'static str, Vec<Option<Cell>>); 2] = [
        ("robots.start", robots.iter().map(start).collect()),
        ("robots.goal", robots.iter().map(goal).collect()),
    ];
    for (field, cells) in cells {
        for (number, cell) in cells.iter().enumerate() {
            let Some(cell) = cell else { continue };
            if let Some(other) = cells[..number].iter().position(|other| *other == Some(*cell)) {
                let got = format!("{cell} of robot {number} and robot {other}");
                return refuse(field, "a cell of its own for each robot on the ground", got);
            }
        }
    }
    Ok(())
}

/// Refuses a rover that begins on the goal of a hopper and may never leave it: one that covers ground, or one whose own goal is so
/// near that it is done there.
fn check_goals_are_open(robots: &[Robot], grid: &Grid) -> Result<(), ScenarioError> {
    for (number, robot) in robots.iter().enumerate() {
        let is_goal = |other: &Robot| other.body.hops() && other.goal.cell(grid, 0) == Some(robot.start.cell);
        let is_done = robot.body.drives() && robot.goal.is_reached_at_start(grid, robot.start_at, true);
        let stays = is_done || robot.goal.cover().is_some();
        if stays && let Some(hopper) = robots.iter().position(is_goal) {
            let need =
                "another cell than the goal of a hopper, for a rover that covers ground or is at its goal";
            let got = format!("{} of robot {number}, the goal of robot {hopper}", robot.start.cell);
            return refuse("robots.start", need, got);
        }
    }
    Ok(())
}

/// Refuses rovers that cover different shares, or in different modes, and regions of their own among robots of other bodies.
fn check_cover(robots: &[Robot]) -> Result<(), ScenarioError> {
    let covers = robots.iter().enumerate();
    let mut covers = covers.filter_map(|(number, robot)| Some((number, robot.goal.cover()?)));
    let Some((first, cover)) = covers.next() else { return Ok(()) };
    if let Some((other, another)) = covers.find(|(_, another)| *another != cover) {
        let [one, another] = [cover, another].map(rover::in_words);
        let got = format!("{one} of robot {first} and {another} of robot {other}");
        return refuse("robots.goal", "the same for all rovers", got);
    }
    let is_rover = |robot: &Robot| robot.goal.cover().is_some();
    match robots.iter().position(|robot| !is_rover(robot)) {
        Some(other) if cover.mode == CoverMode::Voronoi => refuse(
            "robots.goal.mode",
            "overlap, unless all robots are rovers: a region would stay uncovered for good where its rover, or the way to it, is lost",
            format!("voronoi of robot {first} beside robot {other}"),
        ),
        Some(_) | None => Ok(()),
    }
}

/// Refuses cameras that err differently: the readings of the ground are drawn once.
fn check_accuracies(robots: &[Robot]) -> Result<(), ScenarioError> {
    let mut accuracies = robots.iter().filter_map(|robot| robot.sensor.accuracy());
    if let Some(first) = accuracies.next()
        && let Some(other) = accuracies.find(|other| *other != first)
    {
        return refuse(
            "robots.accuracy",
            "the same for all helicopters that err",
            format!("{first} and {other}"),
        );
    }
    Ok(())
}

fn north() -> Direction {
    Direction::North
}

fn is_north(heading: &Direction) -> bool {
    *heading == Direction::North
}

fn yes() -> bool {
    true
}

fn is_yes(flag: &bool) -> bool {
    *flag
}

fn one_metre() -> f64 {
    1.0
}

fn is_one_metre(value: &f64) -> bool {
    *value == one_metre()
}
