//! The four maps of the paper's simulations.

use std::fmt;
use std::str::FromStr;

use contract::{Cell, Direction, Grid, Ground, Soil, SoilMotion};
use motion::GroundProfile;
use serde::Serialize;
use terrain::Gaussian;

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

/// Outlines of the rocks on the fourth map. The paper shows their outlines in a figure only; these are chosen so that
/// the path climbs the low rock at (9, 11), which the paper reports.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rocks {
    /// The tall rock, 1.0 m: its south-western and north-eastern cells.
    pub tall: [Cell; 2],
    /// The low rock, 0.25 m: its south-western and north-eastern cells.
    pub low: [Cell; 2],
}

impl Rocks {
    /// Height of the tall rock, metres.
    pub const TALL_M: f64 = 1.0;
    /// Height of the low rock, metres.
    pub const LOW_M: f64 = 0.25;
    /// The outlines that the experiment uses.
    pub const CHOSEN: Rocks =
        Rocks { tall: [Cell::new(3, 3), Cell::new(6, 6)], low: [Cell::new(10, 10), Cell::new(12, 12)] };

    fn height_m(&self, cell: Cell) -> f64 {
        let covers =
            |[low, high]: [Cell; 2]| (low.x..=high.x).contains(&cell.x) && (low.y..=high.y).contains(&cell.y);
        if covers(self.tall) {
            Self::TALL_M
        } else if covers(self.low) {
            Self::LOW_M
        } else {
            0.0
        }
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
    /// The map of `experiment` under `reading`.
    #[must_use]
    pub fn new(experiment: Experiment, reading: &Reading) -> Self {
        match experiment {
            Experiment::Rocks => Self::with_rocks(Rocks::CHOSEN),
            _ => Self::with_hills(experiment, reading),
        }
    }

    /// The fourth map with other rocks.
    #[must_use]
    pub fn with_rocks(rocks: Rocks) -> Self {
        let grid = grid(14);
        let ground = |cell| Ground { height_m: rocks.height_m(cell), ..Ground::FLAT };
        Self {
            experiment: Experiment::Rocks,
            grid,
            ground: grid.iter().map(ground).collect(),
            start: Cell::new(0, 0),
            goal: Cell::new(13, 13),
            hard: hop(HARD, 1.0, 1, 1),
            sand: hop(SAND, 0.5, 1, 1),
            stepped: true,
        }
    }

    fn with_hills(experiment: Experiment, reading: &Reading) -> Self {
        let grid = grid(20);
        let amplitude_m = reading.hill_height.amplitude_m();
        let hills = hills(amplitude_m, reading.hollows);
        let is_sand = |cell: Cell, height_m: f64| match experiment {
            Experiment::Heterogeneous => (5..=11).contains(&cell.x) && (3..=11).contains(&cell.y),
            Experiment::Sandy => height_m < reading.sand_level * amplitude_m,
            Experiment::Hard | Experiment::Rocks => false,
        };
        let ground = |cell: Cell| {
            let at_m = [f64::from(cell.x), f64::from(cell.y)];
            let height_m: f64 = hills.iter().map(|hill| hill.height_m(at_m)).sum();
            let gradient = hills
                .iter()
                .map(|hill| hill.gradient(at_m))
                .fold([0.0; 2], |sum, part| [sum[0] + part[0], sum[1] + part[1]]);
            let soil = if is_sand(cell, height_m) { Soil::Sand } else { Soil::Hard };
            Ground { height_m, gradient, soil, passable: true, ..Ground::FLAT }
        };
        let (hard, sand) = match experiment {
            Experiment::Sandy => (reading.long_hops.hop(), hop(SAND, 1.0, 1, 1)),
            _ => (hop(HARD, 1.0, 1, 1), hop(SoilMotion { flights: 2, ..SAND }, 0.5, 1, 1)),
        };
        Self {
            experiment,
            grid,
            ground: grid.iter().map(ground).collect(),
            start: Cell::new(0, 0),
            goal: Cell::new(18, 18),
            hard,
            sand,
            stepped: false,
        }
    }

    /// The cells of Table 2's hills that lie on the map.
    pub(crate) fn hill_tops(reading: &Reading) -> Vec<Cell> {
        let raised = (1..).zip(CENTRES).filter(|(n, _)| !reading.hollows.contains(n));
        let cells = raised.map(|(_, [x, y])| Cell::new(x as i32, y as i32));
        cells.filter(|cell| grid(20).contains(*cell)).collect()
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

/// The paper's scatter on hard ground.
const HARD: SoilMotion = SoilMotion { intended: 0.7, stuck: 0.0, sideways: 0.15, flights: 1 };
/// The paper's scatter on sand.
const SAND: SoilMotion = SoilMotion { intended: 0.5, stuck: 0.2, sideways: 0.15, flights: 1 };

fn hop(motion: SoilMotion, flight_m: f64, cells: u32, slip_cells: u32) -> SoilHop {
    SoilHop { motion, flight_m, cells, slip_cells }
}

impl crate::LongHops {
    fn hop(self) -> SoilHop {
        match self {
            crate::LongHops::TwoCells => hop(HARD, 2.0, 2, 2),
            crate::LongHops::TwoCellsSlippingOne => hop(HARD, 2.0, 2, 1),
            crate::LongHops::OneCell => hop(HARD, 2.0, 1, 1),
        }
    }
}

fn grid(side: u32) -> Grid {
    Grid::new(side, side, 1.0, 1).expect("a grid within bounds")
}

/// Centres of the hills and hollows, metres (Table 2).
const CENTRES: [[f64; 2]; 8] =
    [[1.0, 6.0], [5.0, 0.0], [5.0, 20.0], [7.0, 14.0], [8.0, 8.0], [10.0, 18.0], [12.0, 1.0], [15.0, 10.0]];

fn hills(amplitude_m: f64, hollows: [u8; 3]) -> Vec<Gaussian> {
    let hill = |(n, &centre_m): (usize, &[f64; 2])| {
        let sign = if hollows.contains(&(n as u8 + 1)) { -1.0 } else { 1.0 };
        Gaussian { centre_m, sigma_m: 2.0, amplitude_m: sign * amplitude_m }
    };
    CENTRES.iter().enumerate().map(hill).collect()
}
