//! A whole mission: the rovers act in the order of their numbers, each on what those before it have done.

use contract::{Cell, Direction};
use coverage::{Mode, Planner, Pose, Rover, Situation, TeamMap, region};

use crate::error::SetupError;
use crate::reachable::{neighbour, reachable};
use crate::{Setup, World};

/// A mission between two actions.
#[derive(Clone, Debug)]
pub struct Mission<'a> {
    world: &'a World,
    setup: &'a Setup,
    map: TeamMap,
    rovers: Vec<Rover>,
    planner: Planner,
    /// What each rover has to cover; one entry for all of them in [`Mode::Overlap`].
    tasks: Vec<Task>,
    steps: u64,
    covered_at: Vec<u64>,
}

/// Ground to cover, and how much of it is.
#[derive(Clone, Debug)]
struct Task {
    /// Cells that count.
    cells: usize,
    /// Cells to visit until the task is done.
    need: usize,
    visited: usize,
}

/// How a mission went.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// Whether the share asked for was covered; in [`Mode::Voronoi`], in every rover's region.
    pub covered: bool,
    /// Actions of the rover that acted most often: the path length of P19, in steps.
    pub steps: u64,
    /// Cells that the rovers can reach. Once rovers are stranded: that the others can reach, or that were visited.
    pub reachable: usize,
    /// Steps after which the first, second, … cell was visited for the first time; 0 for the starts.
    pub covered_at: Vec<u64>,
}

impl Outcome {
    /// Steps until `percent` of the reachable cells were visited, if they were. Meaningful in [`Mode::Overlap`] only:
    /// otherwise each region counts by itself.
    #[must_use]
    pub fn steps_to(&self, percent: u32) -> Option<u64> {
        let need = cells_of(percent, self.reachable);
        if need == 0 { Some(0) } else { self.covered_at.get(need - 1).copied() }
    }
}

/// `percent` of `count` cells, rounded up.
fn cells_of(percent: u32, count: usize) -> usize {
    (percent as usize * count).div_ceil(100)
}

impl<'a> Mission<'a> {
    /// A mission before its first action: the starts are visited and sensed from.
    ///
    /// # Errors
    /// If the setup cannot be executed on this world.
    pub fn new(world: &'a World, setup: &'a Setup) -> Result<Self, SetupError> {
        setup.check(world)?;
        let rovers: Vec<Rover> = setup.starts.iter().map(|start| Rover::at(*start)).collect();
        let mut mission = Self {
            world,
            setup,
            map: TeamMap::new(*world.grid()),
            planner: Planner::new(setup.algorithm),
            tasks: tasks(world, setup, &rovers),
            rovers,
            steps: 0,
            covered_at: Vec::new(),
        };
        for robot in 0..mission.rovers.len() {
            mission.arrive(robot, setup.starts[robot]);
        }
        Ok(mission)
    }

    /// The mission to its end.
    ///
    /// # Errors
    /// As [`Mission::new`].
    pub fn run(world: &World, setup: &Setup) -> Result<Outcome, SetupError> {
        let mut mission = Mission::new(world, setup)?;
        while !mission.is_over() {
            mission.round();
        }
        Ok(mission.outcome())
    }

    /// One action of every rover that still has something to do, until the mission is over.
    pub fn round(&mut self) {
        self.steps += 1;
        for robot in 0..self.rovers.len() {
            if !self.rovers[robot].stranded && !self.task(robot).is_done() {
                self.act(robot);
            }
        }
    }

    /// Whether no rover has anything left to do, or the step limit is reached.
    #[must_use]
    pub fn is_over(&self) -> bool {
        let idle = |(robot, rover): (usize, &Rover)| rover.stranded || self.task(robot).is_done();
        self.steps >= self.setup.steps_max || self.rovers.iter().enumerate().all(idle)
    }

    /// What the rovers know together.
    #[must_use]
    pub fn map(&self) -> &TeamMap {
        &self.map
    }

    /// The rovers in the order of their numbers.
    #[must_use]
    pub fn rovers(&self) -> &[Rover] {
        &self.rovers
    }

    /// What rover `robot` knows when it decides.
    #[must_use]
    pub fn situation(&self, robot: usize) -> Situation<'_> {
        Situation { map: &self.map, rovers: &self.rovers, mode: self.setup.mode, robot }
    }

    /// How the mission has gone so far.
    #[must_use]
    pub fn outcome(&self) -> Outcome {
        Outcome {
            covered: self.tasks.iter().all(Task::is_done),
            steps: self.steps,
            reachable: self.tasks.iter().map(|task| task.cells).sum(),
            covered_at: self.covered_at.clone(),
        }
    }

    fn act(&mut self, robot: usize) {
        if self.setup.faults.iter().any(|fault| fault.robot == robot && fault.action == self.steps) {
            self.strand(robot);
            return;
        }
        let situation = Situation { map: &self.map, rovers: &self.rovers, mode: self.setup.mode, robot };
        if let Some(direction) = self.planner.decide(&situation) {
            self.drive(robot, direction);
        }
    }

    /// # Panics
    /// If there is no free cell to drive to, which the planner has seen.
    fn drive(&mut self, robot: usize, direction: Direction) {
        let cell = neighbour(self.rovers[robot].pose.cell, direction);
        assert!(self.world.is_free(cell), "rover {robot} needs free ground, got {cell}");
        let occupied = self.rovers.iter().any(|other| other.pose.cell == cell);
        assert!(!occupied, "rover {robot} needs a cell of its own, got {cell}");
        self.arrive(robot, Pose { cell, heading: direction });
    }

    fn arrive(&mut self, robot: usize, pose: Pose) {
        self.rovers[robot].pose = pose;
        if self.map.visits(pose.cell) == 0 {
            self.covered_at.push(self.steps);
            let number = self.task_number(robot);
            self.tasks[number].visited += 1;
        }
        self.map.visit(pose.cell);
        self.setup.sensing.sense(self.world, pose.cell, &mut self.map);
    }

    /// Rover `robot` stays where it is for good. What only it could reach no longer counts where others may take over.
    fn strand(&mut self, robot: usize) {
        self.rovers[robot].stranded = true;
        if self.setup.mode == Mode::Overlap {
            let active = self.rovers.iter().filter(|rover| !rover.stranded).map(|rover| rover.pose.cell);
            let blocked = |cell| self.rovers.iter().any(|rover| rover.stranded && rover.pose.cell == cell);
            let open = |cell| self.world.is_free(cell) && !blocked(cell);
            let mut cells = reachable(self.world.grid(), active, open);
            for (index, cell) in self.world.grid().iter().enumerate() {
                cells[index] |= self.map.visits(cell) > 0;
            }
            self.tasks = vec![Task::new(cells, self.setup.percent, self.covered_at.len())];
        }
    }

    fn task(&self, robot: usize) -> &Task {
        &self.tasks[self.task_number(robot)]
    }

    fn task_number(&self, robot: usize) -> usize {
        if self.setup.mode == Mode::Overlap { 0 } else { robot }
    }
}

/// What has to be covered: all that can be reached from any start, or, in a region, from its start without leaving it.
fn tasks(world: &World, setup: &Setup, rovers: &[Rover]) -> Vec<Task> {
    let task = |cells| Task::new(cells, setup.percent, 0);
    let starts = || rovers.iter().map(|rover| rover.start.cell);
    match setup.mode {
        Mode::Overlap => {
            vec![task(reachable(world.grid(), starts(), |cell| world.is_free(cell)))]
        }
        Mode::Voronoi => {
            let region = |robot: usize| {
                let open =
                    move |cell: Cell| world.is_free(cell) && region::nearest_start(starts(), cell) == robot;
                task(reachable(world.grid(), [rovers[robot].start.cell], open))
            };
            (0..rovers.len()).map(region).collect()
        }
    }
}

impl Task {
    fn new(cells: Vec<bool>, percent: u32, visited: usize) -> Self {
        let cells = cells.into_iter().filter(|counts| *counts).count();
        Self { cells, need: cells_of(percent, cells), visited }
    }

    fn is_done(&self) -> bool {
        self.visited >= self.need
    }
}
