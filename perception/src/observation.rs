//! What is known of seen cells, among them their gradients.

use contract::{Brief, Cell, Decision, GradientSource, Ground, ObservedMap, Pose, RobotId};
use terrain::Terrain;

use crate::sensing::disc;

/// The observed map under construction.
#[derive(Clone, Debug)]
pub struct Observation {
    map: ObservedMap,
    gradient: GradientSource,
}

impl Observation {
    /// A map on which nothing has been seen.
    #[must_use]
    pub fn unseen(brief: &Brief, robot: RobotId) -> Self {
        Self { map: ObservedMap::unseen(brief.run, robot, brief.grid), gradient: brief.sensor.gradient }
    }

    /// The map so far.
    #[must_use]
    pub fn map(&self) -> &ObservedMap {
        &self.map
    }

    pub(crate) fn map_mut(&mut self) -> &mut ObservedMap {
        &mut self.map
    }

    /// Folds in what the sensor sees from `pose` at `decision`. Of `terrain` only the cells of the
    /// sensing disc are read, and of its treasures only those there.
    ///
    /// # Panics
    /// If the terrain is not on the brief's grid.
    pub fn fold(&mut self, brief: &Brief, terrain: &Terrain, pose: Pose, decision: Decision) {
        let grid = self.map.grid;
        assert!(terrain.grid == grid, "terrain and brief disagree on the grid");
        let mut revealed = Vec::new();
        for cell in disc(grid, &brief.sensor, pose) {
            let index = grid.index(cell).expect("the disc is clipped to the grid");
            if self.map.cells[index].is_none() {
                self.map.cells[index] = Some(terrain.cells[index]);
                revealed.push(cell);
            }
        }
        if self.gradient == GradientSource::SeenDifferences {
            for &cell in &revealed {
                for (dx, dy) in [(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)] {
                    self.measure_gradient(Cell::new(cell.x + dx, cell.y + dy));
                }
            }
        }
        self.note_treasures(terrain, &revealed, pose.cell);
        self.map.through = Some(decision);
    }

    /// A treasure is known from the moment its cell is revealed until the hopper lands on it.
    fn note_treasures(&mut self, terrain: &Terrain, revealed: &[Cell], landed: Cell) {
        if terrain.treasures.is_empty() {
            return;
        }
        let treasures = &mut self.map.treasures;
        treasures.extend(revealed.iter().filter(|cell| terrain.treasures.contains(cell)));
        treasures.retain(|cell| *cell != landed);
        let grid = self.map.grid;
        treasures.sort_by_key(|cell| grid.index(*cell));
    }

    /// Gradient at a seen `cell` from the heights of seen neighbours: central difference where both
    /// are seen, one-sided where one is, zero where none is.
    fn measure_gradient(&mut self, cell: Cell) {
        let Some(here) = self.map.ground(cell).map(|ground| ground.height_m) else { return };
        let height = |dx: i32, dy: i32| {
            self.map.ground(Cell::new(cell.x + dx, cell.y + dy)).map(|ground: &Ground| ground.height_m)
        };
        let spacing_m = self.map.grid.cell_size_m;
        let slope = |ahead: Option<f64>, behind: Option<f64>| match (ahead, behind) {
            (Some(ahead), Some(behind)) => (ahead - behind) / (2.0 * spacing_m),
            (Some(ahead), None) => (ahead - here) / spacing_m,
            (None, Some(behind)) => (here - behind) / spacing_m,
            (None, None) => 0.0,
        };
        let gradient = [slope(height(1, 0), height(-1, 0)), slope(height(0, 1), height(0, -1))];
        let index = self.map.grid.index(cell).expect("a seen cell lies on the grid");
        if let Some(ground) = &mut self.map.cells[index] {
            ground.gradient = gradient;
        }
    }
}
