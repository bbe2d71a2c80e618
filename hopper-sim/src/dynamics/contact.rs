//! Contact dynamics: the body flies, hits, bounces and rolls over the true ground until it rests (`docs/dynamics.md`).

use std::sync::Arc;

use ::contact::{Aim, End, Field, Known, Noise, Place, Soil, Surface};
use contract::{
    Branch, Cell, Detail, Direction, Flight, Grid, MotionModel as Model, Outcome, PathPoint, Waypoint,
};
use motion::{Domain, Draw};
use nalgebra::Vector3;
use scenario::{ContactParameters, ContactRules};
use terrain::Terrain;

use super::{Hop, Landing, MotionModel};
use crate::Mission;

/// Longest time that outcome and path may tell, seconds.
const SECONDS_MAX: f64 = 1.0e6;

/// A sphere on the true ground.
#[derive(Debug)]
pub struct Contact {
    surface: Surface<TrueGround>,
    parameters: ContactParameters,
}

/// The terrain as the body feels it.
#[derive(Debug)]
struct TrueGround {
    terrain: Arc<Terrain>,
    soils: [Soil; 2],
}

impl Field for TrueGround {
    fn size(&self) -> [usize; 2] {
        let Grid { width, height, .. } = self.terrain.grid;
        [width as usize, height as usize]
    }

    fn cell_m(&self) -> f64 {
        self.terrain.grid.cell_size_m
    }

    fn height_m(&self, column: usize, row: usize) -> f64 {
        self.terrain.cells[row * self.terrain.grid.width as usize + column].height_m
    }

    fn soil(&self, column: usize, row: usize) -> &Soil {
        let ground = &self.terrain.cells[row * self.terrain.grid.width as usize + column];
        &self.soils[ground.soil as usize]
    }
}

impl Contact {
    /// The model of a mission with these rules.
    pub fn new(mission: &Mission, rules: &ContactRules) -> Self {
        let parameters = rules.parameters();
        let ground = TrueGround { terrain: Arc::clone(&mission.terrain), soils: parameters.soils };
        Self { surface: Surface::new(ground), parameters }
    }

    /// Where the body rests before a hop.
    fn departure(&self, hop: &Hop<'_>) -> Vector3<f64> {
        let middle = Waypoint::middle_of(&hop.mission.brief.grid, hop.from);
        let [east, north] = hop.rest_m.map_or([middle.x_m, middle.y_m], |[east, north, _]| [east, north]);
        Vector3::new(east, north, self.surface.height_m(east, north))
    }
}

impl MotionModel for Contact {
    /// Random numbers are keyed by (seed, domain, robot, decision), as those of the law.
    fn hop(&self, hop: &Hop<'_>) -> Landing {
        let Hop { mission, robot, body, decision, from, direction, .. } = *hop;
        let (grid, gravity_mps2) = (&mission.brief.grid, body.motion.gravity_mps2);
        let ContactParameters { body: sphere, errors, nominal, .. } = &self.parameters;
        let design = motion::launch_over(&body.motion, grid.hop_distance_m());
        let start = self.departure(hop);
        let target = Waypoint::middle_of(grid, grid.hop(from, direction));
        let aim = Aim {
            target_m: [target.x_m - start.x, target.y_m - start.y],
            elevation_rad: body.motion.launch_angle_rad,
            speed_max_mps: self.parameters.speed_max_mps(design.speed_mps),
        };
        let ground = mission.terrain.ground(from).expect("a mission underway stands on its terrain");
        let known = Known { gradient: ground.gradient, soil: nominal[ground.soil as usize] };
        let trimmed_mps = aim.trimmed_mps(sphere, gravity_mps2, &known);
        let (key, stream) = Draw::key(mission.seed, Domain::Contact, robot, decision);
        let noise = &mut Noise::new(key, stream);
        let place =
            Place { surface: &self.surface, body: sphere, gravity_mps2, hop_m: grid.hop_distance_m() };
        let launch = aim.launch(trimmed_mps, errors, noise);
        match place.foothold(start, launch) {
            Some(launched) => {
                told(grid, from, direction, start, &place.hop(start, launched, noise), gravity_mps2)
            }
            None => stayed(from, start),
        }
    }

    /// It ends on the last free cell of its way, in the middle of that.
    fn displaced(&self, hop: &Hop<'_>, landing: Landing, is_taken: &dyn Fn(Cell) -> bool) -> Landing {
        let (grid, from) = (&hop.mission.brief.grid, hop.from);
        let Some(mut detail) = landing.detail else { return landing };
        let cells = detail.path.iter().rev().map(|point| lattice_cell(grid, from, point.at_m));
        let to = cells.into_iter().find(|cell| !is_taken(*cell)).unwrap_or(from);
        let Waypoint { x_m, y_m } = Waypoint::middle_of(grid, to);
        detail.rest_m = [x_m, y_m, self.surface.height_m(x_m, y_m)];
        detail.figures[DISPLACED] = 1.0;
        let branch = branch_of(grid, from, hop.direction, to);
        Landing { outcome: Outcome { branch, to, ..landing.outcome }, detail: Some(detail) }
    }
}

/// Place of the figure `displaced`.
const DISPLACED: usize = 5;

/// A hop that did not leave the ground.
fn stayed(from: Cell, start: Vector3<f64>) -> Landing {
    let outcome = Outcome { branch: Branch::Stayed, from, to: from, flight: Flight::default() };
    let figures = [code(End::NoLaunch), 0.0, 0.0, 0.0, 0.0, 0.0];
    let detail = Detail { model: Model::Contact, rest_m: start.into(), figures, path: Vec::new() };
    Landing { outcome, detail: Some(detail) }
}

/// What a hop has come to, in the words of the protocol.
fn told(
    grid: &Grid,
    from: Cell,
    direction: Direction,
    start: Vector3<f64>,
    hop: &::contact::Hop,
    gravity_mps2: f64,
) -> Landing {
    let (launched, rest) = (hop.launched, hop.position);
    let to = match hop.end {
        End::LeftMap => beyond(grid, lattice_cell(grid, from, rest.into()), rest),
        _ => lattice_cell(grid, from, rest.into()),
    };
    let branch = match hop.end {
        End::RolledAway | End::BouncedOn => Branch::RolledAway,
        End::LeftMap => Branch::Elsewhere,
        End::Rest | End::Caught | End::NoLaunch => branch_of(grid, from, direction, to),
    };
    let speed_mps = libm::sqrt(launched.norm_squared());
    let level_mps = libm::hypot(launched.x, launched.y);
    let flight = Flight {
        launch_speed_mps: speed_mps,
        launch_angle_rad: libm::atan2(launched.z, level_mps).max(0.0),
        range_m: libm::hypot(rest.x - start.x, rest.y - start.y),
        rise_m: rest.z - start.z,
        apex_height_m: launched.z.max(0.0) * launched.z.max(0.0) / (2.0 * gravity_mps2),
        flight_time_s: hop.seconds.min(SECONDS_MAX),
        flights: 1,
    };
    let first = PathPoint { seconds: 0.0, at_m: start.into(), leaves_mps: launched.into() };
    let impacts = hop.impacts.iter().map(|impact| PathPoint {
        seconds: impact.seconds.min(SECONDS_MAX),
        at_m: impact.position.into(),
        leaves_mps: impact.after.into(),
    });
    let energy = 0.5 * launched.norm_squared();
    let detail = Detail {
        model: Model::Contact,
        rest_m: rest.into(),
        figures: [code(hop.end), f64::from(hop.impact_count), hop.rolled_m, hop.seconds, energy, 0.0],
        path: [first].into_iter().chain(impacts).collect(),
    };
    Landing { outcome: Outcome { branch, from, to, flight }, detail: Some(detail) }
}

/// The branch of a hop that ends on `to`.
fn branch_of(grid: &Grid, from: Cell, direction: Direction, to: Cell) -> Branch {
    let branches = [Branch::Intended, Branch::Stayed, Branch::Left, Branch::Right];
    let ends = |branch: &Branch| motion::landing(grid, from, direction, *branch) == to;
    branches.into_iter().find(ends).unwrap_or(Branch::Elsewhere)
}

/// The nearest cell of the lattice of whole hops around `from` that is on the map.
fn lattice_cell(grid: &Grid, from: Cell, [east, north, _]: [f64; 3]) -> Cell {
    let (middle, hop_m) = (Waypoint::middle_of(grid, from), grid.hop_distance_m());
    let along = |metres: f64, middle: f64, from: i32, cells: u32| {
        let hop = grid.hop_cells as i32;
        let (least, most) = (-(from / hop), (cells as i32 - 1 - from) / hop);
        let hops = libm::floor((metres - middle) / hop_m + 0.5).clamp(f64::from(least), f64::from(most));
        from + hop * hops as i32
    };
    Cell { x: along(east, middle.x_m, from.x, grid.width), y: along(north, middle.y_m, from.y, grid.height) }
}

/// The cell outside of the map next to `cell`, on the side where a body left it.
fn beyond(grid: &Grid, cell: Cell, at: Vector3<f64>) -> Cell {
    let extent = |cells: u32| f64::from(cells) * grid.cell_size_m;
    let sides = [
        (at.x, Direction::West),
        (extent(grid.width) - at.x, Direction::East),
        (at.y, Direction::South),
        (extent(grid.height) - at.y, Direction::North),
    ];
    let nearest = sides.into_iter().min_by(|one, other| one.0.total_cmp(&other.0));
    let (_, side) = nearest.expect("a map has four sides");
    let mut cell = cell;
    while grid.contains(cell) {
        cell = grid.hop(cell, side);
    }
    cell
}

/// How a hop ended, as a figure.
fn code(end: End) -> f64 {
    match end {
        End::Rest => 1.0,
        End::Caught => 2.0,
        End::NoLaunch => 3.0,
        End::LeftMap => 4.0,
        End::RolledAway => 5.0,
        End::BouncedOn => 6.0,
    }
}
