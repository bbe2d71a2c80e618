//! What the robots of a mission are placed on.

use contract::{Account, Cell, Robot};
use scout_world::Trip;
use terrain::{Relief, Terrain};

use super::design::Design;
use crate::ScenarioError;
use crate::error::refuse;

/// What the robots of a mission are placed on, and what holds for those that leave out a field.
pub(super) struct Site<'a> {
    /// The ground.
    pub terrain: &'a Terrain,
    /// Its heights as read: none where there is no ground.
    pub relief: &'a Relief,
    /// Start and goal of a driver that has none of its own, where the ground gives them.
    pub trip: Option<Trip>,
    /// The first robot that does not look ahead for others, once all those are placed.
    pub first: Option<Robot>,
    /// What states of the mission tell.
    pub account: Account,
    /// Whether the mission is written as one hopper, without `[[robots]]`.
    pub is_short: bool,
    /// `brief.start`.
    pub start: Option<[i32; 2]>,
    /// `brief.goal`.
    pub goal: Option<[i32; 2]>,
    /// `brief.goals`; empty for no patrol.
    pub goals: Vec<[i32; 2]>,
    /// `brief.hops_max`.
    pub hops_max: u64,
    /// How hoppers hop and see by `[robot]`.
    pub common: Design,
}

/// A cell that a scenario gives, and the field in which it does.
#[derive(Clone, Copy)]
pub(super) struct Given {
    pub field: &'static str,
    pub cell: Cell,
}

impl Given {
    /// A cell as written.
    pub fn of(field: &'static str, [x, y]: [i32; 2]) -> Self {
        Self { field, cell: Cell::new(x, y) }
    }
}

impl Site<'_> {
    /// The start of a robot that may take that of the brief.
    pub fn start(&self, own: Option<[i32; 2]>) -> Result<Given, ScenarioError> {
        self.given(["robots.start", "brief.start"], own, self.start)
    }

    /// The goal of a robot that may take that of the brief.
    pub fn goal(&self, own: Option<[i32; 2]>) -> Result<Given, ScenarioError> {
        self.given(["robots.goal", "brief.goal"], own, self.goal)
    }

    fn given(
        &self,
        [own_field, field]: [&'static str; 2],
        own: Option<[i32; 2]>,
        common: Option<[i32; 2]>,
    ) -> Result<Given, ScenarioError> {
        match (own, common) {
            (Some(cell), _) => Ok(Given::of(own_field, cell)),
            (None, Some(cell)) => Ok(Given::of(field, cell)),
            (None, None) if self.is_short => refuse(field, "a cell (x, y)", "nothing".into()),
            (None, None) => refuse(own_field, "a cell (x, y), or one in [brief]", "nothing".into()),
        }
    }

    /// Refuses a cell that no hopper survives landing on.
    pub fn check_landing(&self, given: Given) -> Result<(), ScenarioError> {
        let (Given { field, cell }, grid) = (given, &self.terrain.grid);
        let Some(ground) = self.terrain.ground(cell) else {
            let last = grid.cell(grid.cells() - 1);
            return Err(ScenarioError::OffMap { field, last, got: cell.to_string() });
        };
        if ground.passable {
            return Ok(());
        }
        let why = match grid.index(cell).and_then(|index| self.relief.cells[index]) {
            Some(_) => format!("slopes {:.1} degrees", libm::atan(ground.steepness()).to_degrees()),
            None => "has no height (nodata)".into(),
        };
        let is_passable = |at: &Cell| self.terrain.ground(*at).is_some_and(|ground| ground.passable);
        let nearby = grid
            .iter()
            .filter(|at| grid.on_same_lattice(cell, *at) && is_passable(at))
            .min_by(|a, b| a.distance_cells(cell).total_cmp(&b.distance_cells(cell)))
            .map_or("none on this map".into(), |cell| cell.to_string());
        Err(ScenarioError::Impassable { field, got: cell.to_string(), why, nearby })
    }
}
