//! A whole mission: the rovers act in the order of their numbers, each on what those before it have done.

use contract::Direction;
use coverage::{Placement, Planner, Rover, Situation, TeamMap};

use crate::error::SetupError;
use crate::progress::{Progress, cells_of};
use crate::reachable::neighbour;
use crate::{Setup, World};

/// A mission between two actions.
#[derive(Clone, Debug)]
pub struct Mission<'a> {
    world: &'a World,
    setup: &'a Setup,
    map: TeamMap,
    rovers: Vec<Rover>,
    planner: Planner,
    progress: Progress,
    steps: u64,
    covered_at: Vec<u64>,
}

/// How a mission went.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// Whether the share asked for was covered; in [`coverage::CoverMode::Voronoi`], in every rover's region.
    pub covered: bool,
    /// Actions of the rover that acted most often: the path length of P19, in steps.
    pub steps: u64,
    /// Cells that the rovers can reach. Once rovers are stranded: that the others can reach, or that were visited.
    pub reachable: usize,
    /// Steps after which the first, second, … cell was visited for the first time; 0 for the starts.
    pub covered_at: Vec<u64>,
}

impl Outcome {
    /// Steps until `percent` of the reachable cells were visited, if they were. Meaningful in
    /// [`coverage::CoverMode::Overlap`] only: otherwise each region counts by itself.
    #[must_use]
    pub fn steps_to(&self, percent: u32) -> Option<u64> {
        let need = cells_of(percent, self.reachable);
        if need == 0 { Some(0) } else { self.covered_at.get(need - 1).copied() }
    }
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
            progress: Progress::new(
                *world.grid(),
                |cell| world.is_free(cell),
                &rovers.iter().map(|rover| rover.start.cell).collect::<Vec<_>>(),
                setup.mode,
                setup.percent,
            ),
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
            if !self.rovers[robot].stranded && !self.progress.is_done(robot) {
                self.act(robot);
            }
        }
    }

    /// Whether no rover has anything left to do, or the step limit is reached.
    #[must_use]
    pub fn is_over(&self) -> bool {
        let idle = |(robot, rover): (usize, &Rover)| rover.stranded || self.progress.is_done(robot);
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
            covered: self.progress.is_covered(),
            steps: self.steps,
            reachable: self.progress.reachable_cells(),
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
        self.arrive(robot, Placement { cell, heading: direction });
    }

    fn arrive(&mut self, robot: usize, pose: Placement) {
        self.rovers[robot].pose = pose;
        if self.progress.visit(robot, pose.cell) {
            self.covered_at.push(self.steps);
        }
        self.map.visit(pose.cell);
        self.setup.sensing.sense(self.world, pose.cell, &mut self.map);
    }

    /// Rover `robot` stays where it is for good.
    fn strand(&mut self, robot: usize) {
        self.rovers[robot].stranded = true;
        let (world, rovers) = (self.world, &self.rovers);
        let active = rovers.iter().filter(|rover| !rover.stranded).map(|rover| rover.pose.cell);
        let is_blocked = |cell| rovers.iter().any(|rover| rover.stranded && rover.pose.cell == cell);
        self.progress.strand(active, |cell| world.is_free(cell) && !is_blocked(cell));
    }
}
