//! Uncertain ground as it should be: what a drive over it takes, what is known of its speeds, how likely a leg is a trap.

use std::ops::ControlFlow;

use contract::{Cell, DriveSpeed, SpeedPrior, Waypoint};
use helicopter::Swath;
use hopper_sim::Mission;
use rover::{Allowance, Drive, Lattice, Point, Segment, Speed, Surface, Truth, drive, traverse};

use crate::expected::Shown;

/// How far a route may begin from its robot, a flight exceed its budget, and the goal be beyond its radius, metres.
pub(super) const TOLERANCE_M: f64 = 1e-6;

/// The ground between points, which no action changes.
#[derive(Debug)]
pub(super) struct Uncertain {
    surface: Surface,
    truth: Truth,
    prior: Vec<SpeedPrior>,
    /// What a camera that errs reads of each cell.
    readings: Vec<Option<DriveSpeed>>,
    /// How often a camera that errs is right.
    accuracy: f64,
}

impl Uncertain {
    /// The ground of a mission.
    pub fn of(mission: &Mission) -> Self {
        let (robots, grid) = (&mission.brief.robots, mission.brief.grid);
        let lattice = Lattice::new(grid.width as usize, grid.height as usize).expect("a grid is a lattice");
        let cells = &mission.terrain.cells;
        let speed = |speed: Option<DriveSpeed>| speed.map_or(Speed::Zero, |speed| Speed::ALL[speed as usize]);
        let heights_m: Vec<f64> = cells.iter().map(|ground| ground.height_m).collect();
        Self {
            surface: Surface::from_heights(lattice, &heights_m).expect("heights of all cells"),
            truth: Truth { speeds: cells.iter().map(|ground| speed(ground.speed)).collect() },
            prior: mission.terrain.prior.clone(),
            readings: cells.iter().map(|ground| ground.reading).collect(),
            accuracy: robots.iter().find_map(|robot| robot.sensor.accuracy()).unwrap_or(1.0),
        }
    }

    /// The largest probability of a cell between two points that it is a trap: what has been seen is certain,
    /// and what was read by a camera that errs weighs the prior by how likely it is.
    pub fn hazard(&self, shown: &[Shown], from: Waypoint, to: Waypoint) -> f64 {
        let mut hazard = 0.0;
        let leg = Segment { from: point(from), to: point(to) };
        let _ = traverse(self.surface.lattice(), leg, |cell, _| {
            let is_trap = self.truth.speeds[cell] == Speed::Zero;
            let prior = self.prior[cell].probabilities();
            let stuck = match (shown[cell], self.readings[cell]) {
                (Shown::Truth, _) => f64::from(u8::from(is_trap)),
                (Shown::Reading, Some(reading)) => {
                    let misread = (1.0 - self.accuracy) / 3.0;
                    let weight = |speed: usize| {
                        prior[speed] * if speed == reading as usize { self.accuracy } else { misread }
                    };
                    let sum = weight(0) + weight(1) + weight(2) + weight(3);
                    if sum > 0.0 { weight(0) / sum } else { prior[0] }
                }
                _ => prior[0],
            };
            hazard = f64::max(hazard, stuck);
            ControlFlow::<()>::Continue(())
        });
        hazard
    }

    /// Whether a cell was read wrong, and nobody who sees the truth has been there since.
    pub fn has_misreadings(&self, shown: &[Shown]) -> bool {
        let mut cells = shown.iter().zip(&self.readings).zip(&self.truth.speeds);
        cells.any(|((shown, reading), truth)| {
            *shown == Shown::Reading && reading.is_some_and(|reading| Speed::ALL[reading as usize] != *truth)
        })
    }

    /// What a drive through `points` takes.
    pub fn drive(&self, points: &[Point], allowance: Allowance) -> Drive {
        drive(&self.surface, &self.truth, points, allowance)
    }

    /// Indices of the cells that a camera shows on the leg between two points.
    pub fn swath(&self, from: Waypoint, to: Waypoint, radius_m: f64) -> Vec<usize> {
        let lattice = self.surface.lattice();
        let leg = Segment { from: point(from), to: point(to) };
        Swath::new(lattice, leg, radius_m).cells(lattice).collect()
    }

    /// Whether a point is on the map.
    pub fn contains(&self, at: Waypoint) -> bool {
        self.surface.lattice().contains(point(at))
    }

    /// The cell of a point.
    pub fn cell(&self, at: Waypoint) -> Cell {
        let (cell, width) = (self.surface.lattice().cell(point(at)), self.surface.lattice().width());
        Cell::new((cell % width) as i32, (cell / width) as i32)
    }
}

/// A point of a route in the terms of the engines.
pub(super) fn point(at: Waypoint) -> Point {
    Point::new(at.x_m, at.y_m)
}
