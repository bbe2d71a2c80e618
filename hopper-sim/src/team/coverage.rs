//! How much of the ground rovers have covered, and what is left for each.

use contract::{Brief, Cell, Cover, Goal, RobotId, Standing};
use coverage_world::Progress;
use terrain::Terrain;

use super::roster::{Entry, Roster};

/// What rovers have covered so far.
#[derive(Clone, Debug)]
pub struct Coverage {
    progress: Progress,
    /// Those that cover ground, in the order of their numbers, by which `progress` knows them.
    rovers: Vec<RobotId>,
    /// Where hoppers go, whom no rover shall be in the way: closed to rovers, and no ground to cover.
    goals: Vec<Cell>,
}

impl Coverage {
    /// Before the first action: the starts are visited, and who has nothing else to cover is done.
    ///
    /// # Panics
    /// If a robot starts off the grid; scenarios are checked.
    #[must_use]
    pub fn new(roster: &mut Roster, brief: &Brief, terrain: &Terrain) -> Self {
        let (rovers, starts): (Vec<RobotId>, Vec<Cell>) = roster
            .entries()
            .filter(|(_, entry)| covers(entry))
            .map(|(robot, entry)| (robot, entry.at.cell))
            .unzip();
        let Cover { percent, mode } = brief.cover().unwrap_or_default();
        let hoppers = roster.entries().filter(|(_, entry)| entry.robot.body.hops());
        let goals: Vec<Cell> =
            hoppers.filter_map(|(_, entry)| entry.robot.goal.cell(&brief.grid, 0)).collect();
        let is_open = |cell| is_free(terrain, cell) && !goals.contains(&cell);
        let mut progress = Progress::new(brief.grid, is_open, &starts, mode, percent);
        for (robot, start) in starts.iter().enumerate() {
            progress.visit(robot, *start);
        }
        let team = Self { progress, rovers, goals };
        team.end_those_done(roster);
        team
    }

    /// Distinct cells that at least one rover stood on.
    #[must_use]
    pub fn visited_cells(&self) -> u64 {
        self.progress.visited_cells() as u64
    }

    /// Whether all ground is covered that was asked for.
    #[must_use]
    pub fn is_covered(&self) -> bool {
        self.progress.is_covered()
    }

    /// Whether a rover is left that can cover what is not covered yet.
    #[must_use]
    pub fn is_at_work(&self, roster: &Roster) -> bool {
        self.rovers.iter().any(|robot| roster.entry(*robot).standing == Standing::Active)
    }

    /// Whether rovers shall keep off `cell`, since a hopper goes there.
    #[must_use]
    pub fn keeps(&self, cell: Cell) -> bool {
        self.goals.contains(&cell)
    }

    /// Takes note that `robot` has stepped to where it is.
    pub fn visit(&mut self, roster: &mut Roster, robot: RobotId) {
        if let Ok(number) = self.rovers.binary_search(&robot) {
            self.progress.visit(number, roster.entry(robot).at.cell);
        }
        self.end_those_done(roster);
    }

    /// A robot closes its cell for good: what can no longer be reached does not count any more.
    pub fn close_ways(&mut self, roster: &mut Roster, terrain: &Terrain) {
        let stopped = roster.entries().filter(|(_, entry)| closes_way(entry)).map(|(_, entry)| entry.at.cell);
        let closed: Vec<Cell> = stopped.chain(self.goals.iter().copied()).collect();
        let is_open = |cell| is_free(terrain, cell) && !closed.contains(&cell);
        let active = self.rovers.iter().map(|robot| roster.entry(*robot));
        let active = active.filter(|entry| entry.standing == Standing::Active).map(|entry| entry.at.cell);
        self.progress.strand(active, is_open);
        self.end_those_done(roster);
    }

    /// Whoever has nothing left to cover acts no more.
    fn end_those_done(&self, roster: &mut Roster) {
        for (number, robot) in self.rovers.iter().enumerate() {
            let is_active = roster.entry(*robot).standing == Standing::Active;
            if is_active && self.progress.is_done(number) {
                roster.end(*robot, Standing::Done);
            }
        }
    }
}

/// Whether a robot closes its cell to rovers for good. Whoever is done covering has covered its own cell, which counts as before.
pub fn closes_way(entry: &Entry) -> bool {
    match entry.standing {
        Standing::Active => false,
        Standing::Stranded => entry.robot.body.is_on_ground(),
        Standing::Done | Standing::GaveUp => entry.robot.body.is_on_ground() && !covers(entry),
    }
}

fn covers(entry: &Entry) -> bool {
    matches!(entry.robot.goal, Goal::Cover(_))
}

/// Whether a ground robot can stand on `cell`.
pub fn is_free(terrain: &Terrain, cell: Cell) -> bool {
    terrain.ground(cell).is_some_and(|ground| ground.is_drivable())
}
