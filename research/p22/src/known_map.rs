//! The four maps of the paper's simulations.

use std::fmt;
use std::str::FromStr;

use contract::{Cell, Direction, Grid, Ground, Leg, Soil, SoilMotion};
use motion::GroundProfile;
use scenario::{Gaussians, ResolvedScenario, Scenario, TerrainSource};
use serde::Serialize;

use crate::{KnownError, Reading};

/// One of the paper's simulations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Experiment {
    /// Hills and hollows of hard ground (figs. 4, 5).
    Hard,
    /// Hills and hollows with a field of sand (figs. 6, 7, 10).
    Heterogeneous,
    /// Hills and hollows, most of them sand (figs. 8, 9).
    Sandy,
    /// A plain with a tall rock and a low one (fig. 11).
    Rocks,
}

impl Experiment {
    /// Every experiment, in the paper's order.
    pub const ALL: [Experiment; 4] =
        [Experiment::Hard, Experiment::Heterogeneous, Experiment::Sandy, Experiment::Rocks];
}

impl fmt::Display for Experiment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Experiment::Hard => "hard",
            Experiment::Heterogeneous => "heterogeneous",
            Experiment::Sandy => "sandy",
            Experiment::Rocks => "rocks",
        })
    }
}

impl FromStr for Experiment {
    type Err = KnownError;

    fn from_str(text: &str) -> Result<Self, KnownError> {
        let found = Experiment::ALL.into_iter().find(|experiment| experiment.to_string() == text);
        found.ok_or_else(|| KnownError::Experiment { got: text.to_owned() })
    }
}

/// Scatter and length of hops from one soil.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoilHop {
    /// Scatter on flat ground.
    pub motion: SoilMotion,
    /// Length of a flight at 45° on flat ground, metres.
    pub flight_m: f64,
    /// Cells from start to intended landing.
    pub cells: u32,
    /// Cells that a slip leads aside of the start.
    pub slip_cells: u32,
}

/// One of the paper's maps, known completely to the planner.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownMap {
    /// Simulation of the paper it belongs to.
    pub experiment: Experiment,
    /// Lattice of 1 m cells.
    pub grid: Grid,
    /// True ground of every cell in index order.
    pub ground: Vec<Ground>,
    /// Start of every path.
    pub start: Cell,
    /// Goal of every path.
    pub goal: Cell,
    /// Hops from hard ground.
    pub hard: SoilHop,
    /// Hops from sand.
    pub sand: SoilHop,
    /// Whether the borders between cells are steps (rocks) or slopes (hills).
    pub stepped: bool,
}

impl KnownMap {
    /// The map of `experiment` under `reading`: that of the built-in scenario, with the reading's hills and sand.
    ///
    /// # Panics
    /// Never: the built-in scenarios resolve under every reading.
    #[must_use]
    pub fn new(experiment: Experiment, reading: &Reading) -> Self {
        let mut scenario = scenario_of(experiment);
        if let TerrainSource::Gaussians(hills) = &mut scenario.truth.terrain {
            let centres_m = centres_m(hills);
            let of = |lowered: bool| {
                let numbered = (1..).zip(&centres_m);
                let chosen = numbered.filter(|(n, _)| reading.hollows.contains(n) == lowered);
                chosen.map(|(_, centre_m)| *centre_m).collect()
            };
            hills.amplitude_m = reading.hill_height.amplitude_m();
            (hills.raised_m, hills.lowered_m) = (of(false), of(true));
            if let Some(level_m) = &mut scenario.truth.sand.below_height_m {
                *level_m = reading.sand_level * hills.amplitude_m;
            }
        }
        let ResolvedScenario { terrain, brief, .. } =
            scenario.resolve().expect("a built-in scenario resolves");
        let Leg { start, goal, motion, .. } = brief.leg(0);
        let is_sandy = experiment == Experiment::Sandy;
        let half_m = if motion.sand.flights > 1 { 0.5 } else { 1.0 };
        Self {
            experiment,
            grid: terrain.grid,
            ground: terrain.cells.clone(),
            start,
            goal,
            hard: if is_sandy { reading.long_hops.hop(motion.hard) } else { hop(motion.hard, 1.0, 1, 1) },
            sand: hop(motion.sand, half_m, 1, 1),
            stepped: experiment == Experiment::Rocks,
        }
    }

    /// The cells of Table 2's hills that lie on the map.
    pub(crate) fn hill_tops(reading: &Reading) -> Vec<Cell> {
        let TerrainSource::Gaussians(hills) = scenario_of(Experiment::Hard).truth.terrain else {
            return Vec::new();
        };
        let on_map = |cell: &Cell| {
            (0..hills.width_cells as i32).contains(&cell.x)
                && (0..hills.height_cells as i32).contains(&cell.y)
        };
        let raised = (1..).zip(centres_m(&hills)).filter(|(n, _)| !reading.hollows.contains(n));
        raised.map(|(_, [x, y])| Cell::new(x as i32, y as i32)).filter(on_map).collect()
    }

    /// Height of the tallest cell, metres.
    pub(crate) fn highest_m(&self) -> f64 {
        self.ground.iter().map(|ground| ground.height_m).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Mean steepness |∇h| of the ground, metres per metre.
    #[must_use]
    pub fn mean_steepness(&self) -> f64 {
        self.ground.iter().map(Ground::steepness).sum::<f64>() / self.ground.len() as f64
    }

    /// Share of the map that is sand.
    #[must_use]
    pub fn sand_share(&self) -> f64 {
        self.ground.iter().filter(|ground| ground.soil == Soil::Sand).count() as f64
            / self.ground.len() as f64
    }

    /// Scatter and length of hops from `soil`.
    #[must_use]
    pub fn hop(&self, soil: Soil) -> &SoilHop {
        match soil {
            Soil::Hard => &self.hard,
            Soil::Sand => &self.sand,
        }
    }

    /// The ground of `cell`; `None` outside of the map.
    #[must_use]
    pub fn at(&self, cell: Cell) -> Option<&Ground> {
        self.grid.index(cell).map(|index| &self.ground[index])
    }

    /// The cell `cells` away from `from` towards `direction`; it may lie outside of the map.
    #[must_use]
    pub fn beyond(from: Cell, direction: Direction, cells: u32) -> Cell {
        let (dx, dy) = direction.step();
        Cell::new(from.x + dx * cells as i32, from.y + dy * cells as i32)
    }

    /// Height profile over `cells` cells from `from` towards `direction`, as far as the map reaches.
    ///
    /// # Panics
    /// If `from` lies outside of the map.
    #[must_use]
    pub fn profile(&self, from: Cell, direction: Direction, cells: u32) -> GroundProfile {
        let heights_m: Vec<f64> = (0..=cells)
            .map_while(|n| self.at(Self::beyond(from, direction, n)).map(|ground| ground.height_m))
            .collect();
        match self.stepped {
            true => GroundProfile::stepped(&heights_m, self.grid.cell_size_m),
            false => GroundProfile::sloping(&heights_m, self.grid.cell_size_m),
        }
    }
}

fn hop(motion: SoilMotion, flight_m: f64, cells: u32, slip_cells: u32) -> SoilHop {
    SoilHop { motion, flight_m, cells, slip_cells }
}

impl crate::LongHops {
    fn hop(self, hard: SoilMotion) -> SoilHop {
        match self {
            crate::LongHops::TwoCells => hop(hard, 2.0, 2, 2),
            crate::LongHops::TwoCellsSlippingOne => hop(hard, 2.0, 2, 1),
            crate::LongHops::OneCell => hop(hard, 2.0, 1, 1),
        }
    }
}

impl Experiment {
    /// The built-in scenario with its ground.
    #[must_use]
    pub fn scenario(self) -> &'static str {
        match self {
            Experiment::Hard => "known-hard",
            Experiment::Heterogeneous => "known-heterogeneous",
            Experiment::Sandy => "known-sandy",
            Experiment::Rocks => "rocks",
        }
    }
}

fn scenario_of(experiment: Experiment) -> Scenario {
    scenario::load(experiment.scenario()).expect("a built-in scenario")
}

/// Centres of the hills and hollows, metres, in the order of Table 2: the scenario lists its hollows last.
fn centres_m(hills: &Gaussians) -> Vec<[f64; 2]> {
    [&hills.raised_m[..], &hills.lowered_m].concat()
}
