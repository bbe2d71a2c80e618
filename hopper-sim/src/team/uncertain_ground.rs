//! Ground of uncertain speed: what drives on it come to, and what anybody can know of it.

use std::ops::ControlFlow;

use contract::{Brief, Cell, DriveSpeed, Grid, Robot, RobotId, SpeedPrior, Waypoint};
use helicopter::{Sensor, Sighting};
use rover::{Drive, Point, Segment, Speed, SpeedDistribution, traverse};
use scout_world::{StageClock, TrueGround};
use terrain::Terrain;

use super::roster::Roster;

/// The true speeds, the time that is left in the stage of each rover, and what is known of the ground.
#[derive(Clone, Debug)]
pub struct UncertainGround {
    /// Of each robot, in the order of their numbers; only those of rovers run.
    clocks: Vec<StageClock>,
    grid: Grid,
    ground: TrueGround,
    prior: Vec<SpeedPrior>,
    /// In index order.
    sights: Vec<Sight>,
    /// The camera of those helicopters that err.
    camera: Option<Sensor>,
    /// What it reads of each cell, in index order; nothing where none errs.
    readings: Vec<Option<DriveSpeed>>,
}

/// What sensors have shown of a cell's speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sight {
    /// Nothing.
    Unseen,
    /// What a camera that errs reads.
    Read,
    /// The true one.
    Seen,
}

impl UncertainGround {
    /// Before the first action: the rover sees where it stands.
    ///
    /// # Panics
    /// If the terrain has no speeds; scenarios are checked.
    #[must_use]
    pub fn new(roster: &Roster, brief: &Brief, terrain: &Terrain) -> Self {
        assert_eq!(terrain.prior.len(), terrain.cells.len(), "uncertain ground has a prior for each cell");
        let ground =
            TrueGround::new(brief.grid, &terrain.cells).expect("a grid is within the limits of a lattice");
        let mut accuracies = roster.entries().filter_map(|(_, entry)| entry.robot.sensor.accuracy());
        let stages = brief.sampling.map_or(1, |sampling| sampling.stages);
        let mut ground = Self {
            clocks: vec![StageClock::new(stages); usize::from(roster.count())],
            grid: brief.grid,
            ground,
            prior: terrain.prior.clone(),
            sights: vec![Sight::Unseen; brief.grid.cells()],
            camera: accuracies.next().and_then(|accuracy| Sensor::with_accuracy(accuracy).ok()),
            readings: terrain.cells.iter().map(|ground| ground.reading).collect(),
        };
        for (_, entry) in roster.entries() {
            if entry.robot.body.drives() {
                ground.see_between(&entry.robot, entry.robot.start_at, entry.robot.start_at);
            }
        }
        ground
    }

    /// The largest probability of getting stuck in a cell between two points, as far as it is known.
    #[must_use]
    pub fn hazard(&self, from: Waypoint, to: Waypoint) -> f64 {
        let mut hazard = 0.0_f64;
        let segment = Segment { from: point(from), to: point(to) };
        let _ = traverse(self.ground.lattice(), segment, |cell, _| {
            hazard = hazard.max(self.stuck(cell));
            ControlFlow::<()>::Continue(())
        });
        hazard
    }

    /// The probability of getting stuck in a cell, as far as it is known.
    fn stuck(&self, cell: usize) -> f64 {
        let sighting = match self.sights[cell] {
            Sight::Seen => Sighting { speed: Some(self.ground.speed(cell)), reading: None },
            Sight::Read => Sighting { speed: None, reading: self.readings[cell].map(scout_world::speed) },
            Sight::Unseen => Sighting::default(),
        };
        let prior = SpeedDistribution::as_given(self.prior[cell].probabilities());
        prior.map_or(1.0, |prior| sighting.belief(prior, self.camera.as_ref()).probability(Speed::Zero))
    }

    /// Whether a point lies on the map.
    #[must_use]
    pub fn contains(&self, at: Waypoint) -> bool {
        self.ground.lattice().contains(point(at))
    }

    /// The cell of a point.
    #[must_use]
    pub fn cell(&self, at: Waypoint) -> Cell {
        self.grid.cell(self.ground.lattice().cell(point(at)))
    }

    /// What a drive of `robot` between two points comes to, within the time that is left of its stage.
    #[must_use]
    pub fn drive(&self, robot: RobotId, from: Waypoint, to: Waypoint) -> Drive {
        self.ground.drive(from, to, self.clocks[usize::from(robot.0)].allowance())
    }

    /// Takes note that `robot` has driven.
    pub fn drove(&mut self, robot: RobotId, drive: &Drive) {
        self.clocks[usize::from(robot.0)].drove(drive);
    }

    /// The next stage of `robot` begins.
    pub fn begin_stage(&mut self, robot: RobotId) {
        self.clocks[usize::from(robot.0)].begin_next();
    }

    /// Takes note of what `robot` has seen on its way between two points.
    pub fn see_between(&mut self, robot: &Robot, from: Waypoint, to: Waypoint) {
        let cells = self.ground.seen(robot.sensor, from, to);
        self.see(robot, cells);
    }

    /// Takes note of what a robot sees of these cells.
    pub fn see(&mut self, robot: &Robot, cells: impl IntoIterator<Item = usize>) {
        let errs = robot.sensor.accuracy().is_some();
        for cell in cells {
            self.sights[cell] = match (errs, self.sights[cell]) {
                (true, Sight::Unseen | Sight::Read) => Sight::Read,
                (false, _) | (true, Sight::Seen) => Sight::Seen,
            };
        }
    }
}

fn point(at: Waypoint) -> Point {
    Point::new(at.x_m, at.y_m)
}
