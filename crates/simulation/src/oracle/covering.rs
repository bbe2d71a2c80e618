//! How much of their ground the robots that cover it have covered, as it should be.

use contract::{Cell, Cover, CoverMode};
use hopper_sim::Mission;

/// What rovers have visited, and what they still have to.
#[derive(Clone, Debug)]
pub(super) struct Covering {
    cover: Cover,
    /// Where the rovers start, in the order of their numbers.
    starts: Vec<Cell>,
    /// Cells that each rover was the first to enter.
    first_visits: Vec<usize>,
    visited: Vec<bool>,
    /// Of the ground that all rovers share: the cells that count.
    shared: Vec<bool>,
    /// Cells that no rover shall enter, though it could.
    kept: Vec<Cell>,
}

impl Covering {
    /// Before the first action of rovers that start at `starts` and keep off the cells `kept`; `None` in a mission that has nothing to
    /// cover.
    pub fn begin(mission: &Mission, starts: Vec<Cell>, kept: Vec<Cell>) -> Option<Self> {
        let cover = mission.brief.robots.iter().find_map(|robot| robot.goal.cover());
        let mut covered = Self {
            cover: cover?,
            first_visits: vec![0; starts.len()],
            visited: vec![false; mission.brief.grid.cells()],
            shared: flood(mission, &starts, |cell| !kept.contains(&cell)),
            starts,
            kept,
        };
        for rover in 0..covered.starts.len() {
            covered.visit(mission, rover, covered.starts[rover]);
        }
        Some(covered)
    }

    /// Cells visited by anybody.
    pub fn visits(&self) -> u64 {
        self.visited.iter().filter(|visited| **visited).count() as u64
    }

    /// A rover has entered a cell.
    pub fn visit(&mut self, mission: &Mission, rover: usize, cell: Cell) {
        let visited = &mut self.visited[index(mission, cell)];
        self.first_visits[rover] += usize::from(!*visited);
        *visited = true;
    }

    /// A robot stays where it is for good: what those that are still `active` can reach counts, and what has been visited. If
    /// none is, nobody takes over.
    pub fn close(&mut self, mission: &Mission, active: &[Cell], closed: &[Cell]) {
        if active.is_empty() {
            return;
        }
        let reached = flood(mission, active, |cell| !closed.contains(&cell) && !self.kept.contains(&cell));
        self.shared =
            reached.iter().zip(&self.visited).map(|(reached, visited)| *reached || *visited).collect();
    }

    /// Whether every rover has nothing left to cover.
    pub fn is_all_covered(&self, mission: &Mission) -> bool {
        (0..self.starts.len()).all(|rover| self.has_covered(mission, rover))
    }

    /// Whether a rover has nothing left to cover: of the shared ground, or of its own region.
    pub fn has_covered(&self, mission: &Mission, rover: usize) -> bool {
        let (counts, visited) = match self.cover.mode {
            CoverMode::Overlap => (self.shared.clone(), self.visits() as usize),
            CoverMode::Voronoi => {
                let own = |cell: Cell| {
                    let away = |start: &Cell| (start.x - cell.x).pow(2) + (start.y - cell.y).pow(2);
                    let starts = self.starts.iter().enumerate();
                    let nearest = starts.min_by_key(|(other, start)| (away(start), *other));
                    nearest.is_some_and(|(nearest, _)| nearest == rover)
                };
                (flood(mission, &[self.starts[rover]], own), self.first_visits[rover])
            }
        };
        let cells = counts.into_iter().filter(|counts| *counts).count();
        100 * visited >= self.cover.percent as usize * cells
    }
}

/// Cells that can be reached by steps from any of `from`, over cells that are free and `open`.
fn flood(mission: &Mission, from: &[Cell], open: impl Fn(Cell) -> bool) -> Vec<bool> {
    let mut reached = vec![false; mission.brief.grid.cells()];
    let mut left: Vec<Cell> = from.to_vec();
    while let Some(cell) = left.pop() {
        if !is_free(mission, cell) || !open(cell) || reached[index(mission, cell)] {
            continue;
        }
        reached[index(mission, cell)] = true;
        left.extend([(0, 1), (1, 0), (0, -1), (-1, 0)].map(|(dx, dy)| Cell::new(cell.x + dx, cell.y + dy)));
    }
    reached
}

/// The index of a cell on the map.
pub(super) fn index(mission: &Mission, cell: Cell) -> usize {
    (cell.y * mission.brief.grid.width as i32 + cell.x) as usize
}

/// Whether a rover that covers ground can stand there: on the map, and neither an obstacle nor a trap.
pub(super) fn is_free(mission: &Mission, cell: Cell) -> bool {
    let grid = mission.brief.grid;
    let inside = (0..grid.width as i32).contains(&cell.x) && (0..grid.height as i32).contains(&cell.y);
    inside && {
        let ground = mission.terrain.cells[index(mission, cell)];
        ground.passable && ground.speed != Some(contract::DriveSpeed::Zero)
    }
}
