//! A rover of `[[robots]]`, which covers ground.

use std::fmt;

use contract::{Body, Cover, CoverMode, Direction, Goal, Placement, Robot, Rover, Sensor, Square, Waypoint};
#[cfg(test)]
use schemars::JsonSchema;
use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use super::site::{Given, Site};
use super::{Rules, is_north, is_one_metre, is_yes, north, one_metre, yes};
use crate::error::refuse;
use crate::{ScenarioError, exact};

/// A rover: it drives to one of four neighbouring cells at a time, and covers ground together with all other rovers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RoverRules {
    /// Cell (x, y) that it starts from.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "exact::optional")]
    pub start: Option<[i32; 2]>,
    /// Where it faces at the start: `north`, `east`, `south` or `west`.
    #[serde(default = "north", skip_serializing_if = "is_north")]
    #[cfg_attr(test, schemars(with = "String", extend("enum" = ["north", "east", "south", "west"])))]
    pub heading: Direction,
    /// Speed on level ground, m/s; at most a cell a second.
    #[serde(default = "one_metre", skip_serializing_if = "is_one_metre")]
    pub speed_mps: f64,
    /// How far it sees, cells to each side, 1 to 64: 1 for the eight cells around it.
    #[serde(default = "one_cell", skip_serializing_if = "is_one_cell")]
    pub sensor_range_cells: u32,
    /// Whether the mission needs it to cover its ground.
    #[serde(default = "yes", skip_serializing_if = "is_yes")]
    pub required: bool,
    /// Planner that `hopper run` starts for it, unless told otherwise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub planner: Option<String>,
    /// How much ground rovers cover, and who covers which; the same for all rovers of a mission.
    #[serde(
        default,
        skip_serializing_if = "CoverGoal::is_default",
        deserialize_with = "CoverGoal::of_table"
    )]
    pub goal: CoverGoal,
}

/// How much ground rovers cover, and who covers which.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct CoverGoal {
    /// Share of the reachable cells to cover, 1 to 100 %.
    #[serde(skip_serializing_if = "is_all")]
    pub cover: u32,
    /// How rovers share the ground: `overlap`, all cover all of it, or `voronoi`, each the cells nearest to its start.
    #[serde(skip_serializing_if = "is_overlap")]
    #[cfg_attr(test, schemars(with = "String", extend("enum" = ["overlap", "voronoi"])))]
    pub mode: CoverMode,
}

impl Default for CoverGoal {
    fn default() -> Self {
        let Cover { percent, mode } = Cover::default();
        Self { cover: percent, mode }
    }
}

impl CoverGoal {
    /// Reads it from a table alone: a list would be a cell, which is the goal of a driver.
    fn of_table<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Table;
        impl<'de> Visitor<'de> for Table {
            type Value = CoverGoal;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("{ cover = 100, mode = \"overlap\" }: it is a driver that drives to a cell")
            }

            fn visit_map<A: MapAccess<'de>>(self, fields: A) -> Result<CoverGoal, A::Error> {
                CoverGoal::deserialize(MapAccessDeserializer::new(fields))
            }
        }
        deserializer.deserialize_map(Table)
    }

    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

impl Rules for RoverRules {
    fn on(&mut self, site: &Site<'_>) -> Result<Robot, ScenarioError> {
        let grid = &site.terrain.grid;
        let Some(start) = self.start else {
            return refuse("robots.start", "a cell (x, y)", "nothing".into());
        };
        let Given { field, cell } = Given::of("robots.start", start);
        match site.terrain.ground(cell) {
            None => return refuse(field, "a cell on the map", cell.to_string()),
            Some(ground) if !ground.is_drivable() => {
                return refuse(field, "ground without obstacle", cell.to_string());
            }
            Some(_) => {}
        }
        if !(1.0e-9..=grid.cell_size_m).contains(&self.speed_mps) {
            let need = "above 0 and at most one cell a second, since an action lasts a second at least";
            return refuse("robots.speed_mps", need, self.speed_mps.to_string());
        }
        if !(1..=Square::RANGE_MAX_CELLS).contains(&self.sensor_range_cells) {
            return refuse("robots.sensor_range_cells", "1 to 64", self.sensor_range_cells.to_string());
        }
        let CoverGoal { cover: percent, mode } = self.goal;
        if !(1..=100).contains(&percent) {
            return refuse("robots.goal.cover", "1 to 100 %", percent.to_string());
        }
        Ok(Robot {
            body: Body::Rover(Rover { speed_mps: self.speed_mps }),
            sensor: Sensor::Square(Square { range_cells: self.sensor_range_cells }),
            start: Placement { cell, heading: self.heading },
            start_at: Waypoint::middle_of(grid, cell),
            goal: Goal::Cover(Cover { percent, mode }),
            required: self.required,
        })
    }
}

/// A goal as it is written.
pub(super) fn in_words(cover: Cover) -> String {
    let mode = match cover.mode {
        CoverMode::Overlap => "overlap",
        CoverMode::Voronoi => "voronoi",
    };
    format!("{{ cover = {}, mode = \"{mode}\" }}", cover.percent)
}

fn one_cell() -> u32 {
    1
}

fn is_one_cell(cells: &u32) -> bool {
    *cells == one_cell()
}

fn is_all(percent: &u32) -> bool {
    *percent == CoverGoal::default().cover
}

fn is_overlap(mode: &CoverMode) -> bool {
    *mode == CoverMode::Overlap
}
