//! Cells merged into tiles and rectangles, so that large maps make short SVG paths.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use contract::{Grid, Ground, Range, Soil};

use super::scale::range;

/// Most tiles along a side; a larger grid is drawn in blocks of cells.
const TILES_MAX: u32 = 256;

/// Look of a block of cells (on small maps one cell).
#[derive(Clone, Copy, Debug, Default)]
pub struct Tile {
    /// Mean of the known heights, metres; `None` if none is known.
    pub height_m: Option<f64>,
    /// Whether most of its cells were seen.
    pub seen: bool,
    /// Whether most of its cells are sand.
    pub sand: bool,
    /// Whether any of its cells is impassable.
    pub blocked: bool,
    /// Mean of what else the ground shows; `None` if it shows heights.
    pub value: Option<f64>,
}

/// Tiles row by row, southernmost first.
#[derive(Clone, Debug)]
pub struct TileMap {
    /// Cells along the side of a tile.
    pub block: u32,
    columns: usize,
    rows: usize,
    tiles: Vec<Tile>,
}

impl TileMap {
    /// The tiles of `grid`: `is_seen`, `ground` and `value` are asked for every index. `ground` is `None` where nothing is
    /// known, `value` where heights are shown.
    pub fn new<'a>(
        grid: &Grid,
        is_seen: impl Fn(usize) -> bool,
        ground: impl Fn(usize) -> Option<&'a Ground>,
        value: impl Fn(usize) -> Option<f64>,
    ) -> Self {
        let block = grid.width.max(grid.height).div_ceil(TILES_MAX);
        let (columns, rows) = (grid.width.div_ceil(block) as usize, grid.height.div_ceil(block) as usize);
        let mut sums = vec![Sum::default(); columns * rows];
        for (index, cell) in grid.iter().enumerate() {
            let sum =
                &mut sums[(cell.y as usize / block as usize) * columns + cell.x as usize / block as usize];
            sum.cells += 1;
            sum.seen += u32::from(is_seen(index));
            if let Some(value) = value(index) {
                sum.values += 1;
                sum.value += value;
            }
            let Some(ground) = ground(index) else { continue };
            sum.sand += u32::from(ground.soil == Soil::Sand);
            sum.blocked += u32::from(!ground.passable);
            if ground.height_m.is_finite() {
                sum.heights += 1;
                sum.height_m += ground.height_m;
            }
        }
        Self { block, columns, rows, tiles: sums.iter().map(Sum::tile).collect() }
    }

    /// Every tile, row by row, southernmost first.
    pub fn tiles(&self) -> &[Tile] {
        &self.tiles
    }

    /// Whether both show the same ground, however much of it was seen.
    pub fn has_ground_of(&self, other: &Self) -> bool {
        let ground = |tile: &Tile| (tile.height_m, tile.sand, tile.blocked, tile.value);
        (self.block, self.columns, self.rows) == (other.block, other.columns, other.rows)
            && self.tiles.iter().map(ground).eq(other.tiles.iter().map(ground))
    }

    /// Range of the known heights; never of zero width.
    pub fn heights(&self) -> Range {
        match range(self.tiles.iter().filter_map(|tile| tile.height_m)) {
            Some(Range { min, max }) if max - min > 1e-9 => Range { min, max },
            Some(Range { min, max }) => Range { min: min - 0.5, max: max + 0.5 },
            None => Range { min: -0.5, max: 0.5 },
        }
    }

    fn is(&self, column: usize, row: usize, wanted: &impl Fn(&Tile) -> bool) -> bool {
        wanted(&self.tiles[row * self.columns + column])
    }

    /// Path that fills the tiles `wanted`: runs along a row, merged with equal runs of the next rows.
    pub fn fill(&self, wanted: impl Fn(&Tile) -> bool) -> String {
        let mut path = String::new();
        let mut open: BTreeMap<(usize, usize), usize> = BTreeMap::new();
        let mut pen = (0, 0);
        for row in 0..=self.rows {
            let runs = match row < self.rows {
                true => runs(self.columns, |column| self.is(column, row, &wanted)),
                false => Vec::new(),
            };
            open.retain(|&(from, to), &mut since| {
                let goes_on = runs.binary_search(&(from, to)).is_ok();
                if !goes_on {
                    let (width, height) = (to - from, row - since);
                    let (dx, dy) = (from as i64 - pen.0, since as i64 - pen.1);
                    let _ = write!(path, "m{dx} {dy}h{width}v{height}h-{width}z");
                    pen = (from as i64, since as i64);
                }
                goes_on
            });
            for run in runs {
                open.entry(run).or_insert(row);
            }
        }
        path
    }

    /// Path along the borders between tiles `wanted` and others.
    pub fn outline(&self, wanted: impl Fn(&Tile) -> bool) -> String {
        let mut path = String::new();
        for row in 1..self.rows {
            let differs = |column| self.is(column, row - 1, &wanted) != self.is(column, row, &wanted);
            for (from, to) in runs(self.columns, differs) {
                let _ = write!(path, "M{from} {row}h{}", to - from);
            }
        }
        for column in 1..self.columns {
            let differs = |row| self.is(column - 1, row, &wanted) != self.is(column, row, &wanted);
            for (from, to) in runs(self.rows, differs) {
                let _ = write!(path, "M{column} {from}v{}", to - from);
            }
        }
        path
    }
}

/// Maximal intervals [from, to) below `end` in which `holds`.
fn runs(end: usize, holds: impl Fn(usize) -> bool) -> Vec<(usize, usize)> {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for at in (0..end).filter(|&at| holds(at)) {
        match runs.last_mut() {
            Some((_, to)) if *to == at => *to = at + 1,
            _ => runs.push((at, at + 1)),
        }
    }
    runs
}

#[derive(Clone, Copy, Default)]
struct Sum {
    cells: u32,
    seen: u32,
    sand: u32,
    blocked: u32,
    heights: u32,
    height_m: f64,
    values: u32,
    value: f64,
}

impl Sum {
    fn tile(&self) -> Tile {
        Tile {
            height_m: (self.heights > 0).then(|| self.height_m / f64::from(self.heights)),
            seen: 2 * self.seen > self.cells,
            sand: 2 * self.sand > self.cells,
            blocked: self.blocked > 0,
            value: (self.values > 0).then(|| self.value / f64::from(self.values)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows as they look, northernmost first; '#' is seen.
    fn tiles(rows: &[&str]) -> TileMap {
        let tile = |c| Tile { seen: c == '#', ..Tile::default() };
        let tiles = rows.iter().rev().flat_map(|row| row.chars().map(tile)).collect();
        TileMap { block: 1, columns: rows[0].len(), rows: rows.len(), tiles }
    }

    #[test]
    fn equal_runs_of_neighbouring_rows_become_one_rectangle() {
        let tiles = tiles(&[".##.", "####", "####"]);
        assert_eq!(tiles.fill(|tile| tile.seen), "m0 0h4v2h-4zm1 2h2v1h-2z");
        assert_eq!(tiles.fill(|_| true), "m0 0h4v3h-4z");
        assert_eq!(tiles.fill(|_| false), "");
    }

    #[test]
    fn rectangles_cover_each_wanted_tile_once() {
        let tiles = tiles(&["#.##..#", ".###.#.", "####..#", "#..#..#"]);
        let mut area = 0;
        for rectangle in tiles.fill(|tile| tile.seen).split_terminator('z') {
            let (_, sides) = rectangle.split_once('h').unwrap();
            let (width, rest) = sides.split_once('v').unwrap();
            area +=
                width.parse::<usize>().unwrap() * rest.split_once('h').unwrap().0.parse::<usize>().unwrap();
        }
        assert_eq!(area, tiles.tiles.iter().filter(|tile| tile.seen).count());
    }

    #[test]
    fn the_outline_runs_between_the_tiles() {
        let tiles = tiles(&["..", "#."]);
        assert_eq!(tiles.outline(|tile| tile.seen), "M0 1h1M1 0v1");
    }
}
