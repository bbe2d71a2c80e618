//! A driver of `[[robots]]`: a rover that drives to a goal over ground of uncertain speed.

use contract::{Account, Body, Direction, Driver, Goal, Placement, Reach, Robot, Sensor, Track, Waypoint};
use rover::Point;
#[cfg(test)]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::site::{Given, Site};
use super::{Rules, is_yes, yes};
use crate::error::refuse;
use crate::mobility::{GOAL_RADIUS_M, middle_of_drivable};
use crate::{ScenarioError, exact};

/// A driver: a rover that drives from point to point over ground of uncertain speed. The ground gives its speed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct DriverRules {
    /// Cell (x, y) in whose middle it starts; by default where the trip of `truth.terrain.passages` begins, elsewhere `brief.start`.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "exact::optional")]
    pub start: Option<[i32; 2]>,
    /// Cell (x, y) to whose middle it drives; by default where the trip of `truth.terrain.passages` ends, elsewhere `brief.goal`.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "exact::optional")]
    pub goal: Option<[i32; 2]>,
    /// Whether the mission needs it to reach its goal.
    #[serde(default = "yes", skip_serializing_if = "is_yes")]
    pub required: bool,
    /// Planner that `hopper run` starts for it, unless told otherwise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub planner: Option<String>,
}

impl Rules for DriverRules {
    fn on(&mut self, site: &Site<'_>) -> Result<Robot, ScenarioError> {
        let terrain = site.terrain;
        if terrain.prior.is_empty() {
            let need = "truth.mobility or truth.terrain.passages for a driver";
            return refuse("robots.body", need, "neither".into());
        }
        let end = |Given { field, cell }| middle_of_drivable(field, cell, terrain);
        let start = match (self.start, site.trip) {
            (None, Some(trip)) => trip.start,
            (own, _) => end(site.start(own)?)?,
        };
        let (goal, radius_m) = match (self.goal, site.trip) {
            (None, Some(trip)) => (trip.goal.at, trip.goal.radius_m),
            (own, _) => (end(site.goal(own)?)?, GOAL_RADIUS_M),
        };
        let start_at = waypoint(start);
        Ok(Robot {
            body: Body::Driver(Driver {}),
            sensor: Sensor::Track(Track {}),
            start: Placement { cell: start_at.cell_of(&terrain.grid), heading: Direction::North },
            start_at,
            goal: Goal::Reach(Reach { at: waypoint(goal), radius_m }),
            required: self.required,
        })
    }

    fn account(&self) -> Account {
        Account::Actions
    }

    fn takes_start(&self, has_trip: bool) -> bool {
        self.start.is_none() && !has_trip
    }

    fn takes_goal(&self, has_trip: bool) -> bool {
        self.goal.is_none() && !has_trip
    }
}

fn waypoint(point: Point) -> Waypoint {
    Waypoint { x_m: point.x_m, y_m: point.y_m }
}
