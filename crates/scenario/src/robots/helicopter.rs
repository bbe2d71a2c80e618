//! A helicopter of `[[robots]]`, which looks ahead for the others.

use contract::limits::LENGTH_MAX_M;
use contract::{
    Body, Camera, Direction, ErringCamera, Goal, Helicopter, LookAhead, Placement, Robot, Sensor, Waypoint,
};
use helicopter::BUDGET_M;
#[cfg(test)]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::site::{Given, Site};
use super::{Rules, is_one_metre, one_metre};
use crate::error::refuse;
use crate::{ScenarioError, exact};

/// A helicopter: it flies from point to point, and looks ahead for the others. It has no goal, and no mission requires it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct HelicopterRules {
    /// Cell (x, y) above which it starts; by default where the first robot starts that is no helicopter.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "exact::optional")]
    pub start: Option<[i32; 2]>,
    /// Speed over ground, m/s.
    #[serde(default = "one_metre", skip_serializing_if = "is_one_metre")]
    pub speed_mps: f64,
    /// Length of all its flights in a stage, metres.
    #[serde(default = "budget_m", skip_serializing_if = "is_budget")]
    pub budget_m: f64,
    /// Radius of the ground that it sees, metres.
    #[serde(default = "view_radius_m", skip_serializing_if = "is_view_radius")]
    pub view_radius_m: f64,
    /// Probability that it reads the speed of a cell right, 0 to 1, the other three speeds being equally likely. The same for
    /// all helicopters that err. Below 1 only on uncertain ground.
    #[serde(default = "certain", skip_serializing_if = "is_certain")]
    pub accuracy: f64,
    /// Planner that `hopper run` starts for it, unless told otherwise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub planner: Option<String>,
}

impl Rules for HelicopterRules {
    /// Without a start of its own it begins where the first robot does.
    fn on(&mut self, site: &Site<'_>) -> Result<Robot, ScenarioError> {
        let grid = &site.terrain.grid;
        let (cell, start_at) = match (self.start, site.first) {
            (None, None) => return refuse("robots.start", "a cell (x, y)", "nothing".into()),
            (None, Some(first)) => (first.start.cell, first.start_at),
            (Some(start), _) => {
                let Given { field, cell } = Given::of("robots.start", start);
                if !grid.contains(cell) {
                    return refuse(field, "a cell on the map", cell.to_string());
                }
                (cell, Waypoint::middle_of(grid, cell))
            }
        };
        let Self { speed_mps, budget_m, view_radius_m: radius_m, accuracy, .. } = *self;
        if !(0.0..=LENGTH_MAX_M).contains(&budget_m) {
            return refuse("robots.budget_m", "0 to 1e6 m", budget_m.to_string());
        }
        if !(1.0e-3..=Camera::RADIUS_MAX_M).contains(&radius_m) {
            return refuse("robots.view_radius_m", "0.001 to 1000 m", radius_m.to_string());
        }
        if !(1.0e-3..=1.0e3).contains(&speed_mps) {
            return refuse("robots.speed_mps", "0.001 to 1000 m/s", speed_mps.to_string());
        }
        if !(0.0..=1.0).contains(&accuracy) {
            return refuse("robots.accuracy", "a probability, 0 to 1", accuracy.to_string());
        }
        if accuracy < 1.0 && site.terrain.prior.is_empty() {
            let need = "1 on ground without speeds: a camera errs in the speeds of uncertain ground";
            return refuse("robots.accuracy", need, accuracy.to_string());
        }
        Ok(Robot {
            body: Body::Helicopter(Helicopter { speed_mps, budget_m }),
            sensor: if accuracy < 1.0 {
                Sensor::ErringCamera(ErringCamera { radius_m, accuracy })
            } else {
                Sensor::Camera(Camera { radius_m })
            },
            start: Placement { cell, heading: Direction::North },
            start_at,
            goal: Goal::LookAhead(LookAhead {}),
            required: false,
        })
    }

    fn looks_ahead(&self) -> bool {
        true
    }
}

fn budget_m() -> f64 {
    BUDGET_M
}

fn is_budget(metres: &f64) -> bool {
    *metres == BUDGET_M
}

fn view_radius_m() -> f64 {
    helicopter::Camera::default().radius_m()
}

fn is_view_radius(metres: &f64) -> bool {
    *metres == view_radius_m()
}

fn certain() -> f64 {
    1.0
}

fn is_certain(accuracy: &f64) -> bool {
    *accuracy == certain()
}
