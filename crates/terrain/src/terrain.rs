//! The true ground that hops are executed on.

use std::collections::VecDeque;

use contract::{Cell, Direction, Grid, Ground, Range, Soil, SpeedPrior};

use crate::{Relief, Sand};

/// The ground of every cell. Heights are relative to the mission's datum, whose elevation is in
/// [`contract::Brief::datum_m`].
#[derive(Clone, Debug, PartialEq)]
pub struct Terrain {
    /// Lattice of the cells.
    pub grid: Grid,
    /// Cells in index order: row-major, southernmost row first.
    pub cells: Vec<Ground>,
    /// Cells with treasures, in index order.
    pub treasures: Vec<Cell>,
    /// What is known of the speeds of a driving rover beforehand, in index order; empty where they are not uncertain.
    pub prior: Vec<SpeedPrior>,
}

impl Terrain {
    /// `relief` with heights relative to `datum_m` and with `sand`, without treasures. Cells steeper than
    /// `slope_limit_rad` and unknown cells are impassable; unknown cells are hard and flat at the height of the
    /// lowest known cell, so that they widen no range of heights.
    #[must_use]
    pub fn new(relief: &Relief, datum_m: f64, slope_limit_rad: f64, sand: &Sand) -> Self {
        let lowest = relief.known().map(|(height, _)| *height).reduce(f64::min).unwrap_or(datum_m);
        let nothing = Ground { height_m: lowest - datum_m, passable: false, ..Ground::FLAT };
        let ground = |(cell, known): (Cell, &Option<(f64, [f64; 2])>)| {
            let Some((height, gradient)) = *known else { return nothing };
            let height_m = height - datum_m;
            let soil = if sand.covers(&relief.grid, cell, height_m) { Soil::Sand } else { Soil::Hard };
            let ground = Ground { height_m, gradient, soil, ..Ground::FLAT };
            Ground { passable: libm::atan(ground.steepness()) <= slope_limit_rad, ..ground }
        };
        Self {
            grid: relief.grid,
            cells: relief.grid.iter().zip(&relief.cells).map(ground).collect(),
            treasures: Vec::new(),
            prior: Vec::new(),
        }
    }

    /// The ground of `cell`; `None` outside of the map.
    #[must_use]
    pub fn ground(&self, cell: Cell) -> Option<&Ground> {
        self.grid.index(cell).map(|index| &self.cells[index])
    }

    /// Range of heights over passable ground, metres: the prior of I that an orbital survey would give.
    ///
    /// Impassable ground is left out: a single cliff or a gap in the data would squeeze all ground a hopper
    /// can stand on into a small part of the range. Both ends are 0 if nothing is passable.
    #[must_use]
    pub fn height_range(&self) -> Range {
        self.range_of(|ground| ground.height_m)
    }

    /// Range of S = −|∇h| − T over passable ground, with T = `sand_term` on sand and 0 elsewhere
    /// (P23 eq. 4).
    #[must_use]
    pub fn safety_range(&self, sand_term: f64) -> Range {
        self.range_of(|ground| {
            let term = if ground.soil == Soil::Sand { sand_term } else { 0.0 };
            -ground.steepness() - term
        })
    }

    /// Fewest hops over passable ground from `from` to `to`; `None` if no chain of hops connects them.
    #[must_use]
    pub fn hops_between(&self, from: Cell, to: Cell) -> Option<u32> {
        let passable = |cell: Cell| self.grid.index(cell).filter(|&index| self.cells[index].passable);
        let target = passable(to)?;
        let mut hops: Vec<Option<u32>> = vec![None; self.cells.len()];
        hops[passable(from)?] = Some(0);
        let mut queue = VecDeque::from([from]);
        while let Some(cell) = queue.pop_front() {
            let so_far = hops[self.grid.index(cell)?]?;
            for direction in Direction::ALL {
                let next = self.grid.hop(cell, direction);
                if let Some(index) = passable(next).filter(|&index| hops[index].is_none()) {
                    hops[index] = Some(so_far + 1);
                    queue.push_back(next);
                }
            }
        }
        hops[target]
    }

    fn range_of(&self, value: impl Fn(&Ground) -> f64) -> Range {
        self.cells
            .iter()
            .filter(|ground| ground.passable)
            .map(value)
            .map(|value| Range { min: value, max: value })
            .reduce(|range, one| Range { min: range.min.min(one.min), max: range.max.max(one.max) })
            .unwrap_or(Range { min: 0.0, max: 0.0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn relief(rows: &[&str]) -> Relief {
        let (width, height) = (rows[0].len() as u32, rows.len() as u32);
        let cells = rows.iter().rev().flat_map(|row| row.chars()).map(|c| match c {
            '.' => Some((10.0, [0.0, 0.1])),
            '^' => Some((12.0, [0.6, 0.0])),
            '_' => Some((9.0, [0.0, 0.0])),
            _ => None,
        });
        Relief { grid: Grid::new(width, height, 1.0, 1).unwrap(), cells: cells.collect() }
    }

    fn terrain(rows: &[&str]) -> Terrain {
        Terrain::new(&relief(rows), 10.0, std::f64::consts::FRAC_PI_6, &Sand::default())
    }

    #[test]
    fn nodata_and_slopes_over_the_limit_are_impassable() {
        let terrain = terrain(&["._^ "]);
        let passable: Vec<bool> = terrain.cells.iter().map(|ground| ground.passable).collect();
        assert_eq!(passable, [true, true, false, false]);
        assert_eq!(terrain.cells[0].height_m, 0.0, "heights are relative to the datum");
        assert_eq!(terrain.cells[3].height_m, -1.0, "nodata lies level with the lowest known cell");
    }

    #[test]
    fn a_slope_of_exactly_the_limit_is_passable() {
        let limit = 0.25;
        let mut relief = relief(&["."]);
        for (slope, passable) in [(libm::tan(limit) - 1e-12, true), (libm::tan(limit) + 1e-9, false)] {
            relief.cells[0] = Some((0.0, [slope, 0.0]));
            assert_eq!(Terrain::new(&relief, 0.0, limit, &Sand::default()).cells[0].passable, passable);
        }
    }

    #[test]
    fn ranges_are_those_of_passable_ground() {
        let terrain = terrain(&["._^ "]);
        assert_eq!(terrain.height_range(), Range { min: -1.0, max: 0.0 });
        assert_eq!(terrain.safety_range(-5.0), Range { min: -0.1, max: -0.0 });
        assert_eq!(self::terrain(&["^ "]).height_range(), Range { min: 0.0, max: 0.0 });
    }

    #[test]
    fn the_sand_term_counts_on_sand_only() {
        let sand = Sand { below_height_m: Some(-0.5), ..Sand::default() };
        let terrain = Terrain::new(&relief(&["._"]), 10.0, 0.5, &sand);
        assert_eq!(terrain.cells[1].soil, Soil::Sand);
        assert_eq!(terrain.safety_range(-5.0), Range { min: -0.1, max: 5.0 });
    }

    #[test]
    fn hops_go_around_impassable_ground_and_end_where_it_closes() {
        let open = terrain(&["...", ".^.", ".^."]);
        assert_eq!(open.hops_between(Cell::new(0, 0), Cell::new(2, 0)), Some(6));
        let closed = terrain(&[".^.", ". .", ".^."]);
        assert_eq!(closed.hops_between(Cell::new(0, 0), Cell::new(2, 0)), None);
        let mut long = terrain(&["....."]);
        long.grid.hop_cells = 2;
        assert_eq!(long.hops_between(Cell::new(0, 0), Cell::new(4, 0)), Some(2), "hops of two cells");
        assert_eq!(long.hops_between(Cell::new(0, 0), Cell::new(3, 0)), None, "off the lattice");
    }
}
