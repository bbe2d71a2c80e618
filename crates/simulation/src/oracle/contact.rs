//! A hop as physics has it: how the body flies, hits and rolls is asked of the engine `contact`; where it starts, what launch control
//! knows, which numbers are drawn and what is told of it is worked out here.

use contact::{Aim, End, Field, Hop, Known, Noise, Place, Soil, Surface};
use contract::{
    Branch, Cell, Decision, Detail, Direction, Flight, Grid, Ground, Hopper, MotionModel, Outcome, PathPoint,
    RobotId,
};
use hopper_sim::Mission;
use motion::{Domain, Draw};
use scenario::ContactRules;

/// The ground that the mission has.
struct Bumps<'a> {
    mission: &'a Mission,
    /// Hard ground and sand.
    soils: [Soil; 2],
}

impl Bumps<'_> {
    fn ground(&self, column: usize, row: usize) -> &Ground {
        let cell = Cell::new(column as i32, row as i32);
        self.mission.terrain.ground(cell).expect("it is asked for cells of the map")
    }
}

impl Field for Bumps<'_> {
    fn size(&self) -> [usize; 2] {
        let Grid { width, height, .. } = self.mission.brief.grid;
        [width as usize, height as usize]
    }

    fn cell_m(&self) -> f64 {
        self.mission.brief.grid.cell_size_m
    }

    fn height_m(&self, column: usize, row: usize) -> f64 {
        self.ground(column, row).height_m
    }

    fn soil(&self, column: usize, row: usize) -> &Soil {
        of_soil(&self.soils, self.ground(column, row).soil)
    }
}

fn of_soil(soils: &[Soil; 2], soil: contract::Soil) -> &Soil {
    if soil == contract::Soil::Sand { &soils[1] } else { &soils[0] }
}

/// A hopper that is about to hop.
pub(super) struct Hopping<'a> {
    pub mission: &'a Mission,
    pub rules: &'a ContactRules,
    pub robot: RobotId,
    pub hopper: &'a Hopper,
    pub decision: Decision,
    pub from: Cell,
    /// What was told of its last action.
    pub told: Option<&'a Detail>,
    pub direction: Direction,
}

impl Hopping<'_> {
    fn middle_m(&self, cell: Cell) -> [f64; 2] {
        let edge_m = self.mission.brief.grid.cell_size_m;
        [(f64::from(cell.x) + 0.5) * edge_m, (f64::from(cell.y) + 0.5) * edge_m]
    }

    /// What it comes to, if no other robot is in the way.
    pub fn hop(&self) -> (Outcome, Detail) {
        let Self { mission, hopper, from, .. } = *self;
        let (grid, all) = (mission.brief.grid, self.rules.parameters());
        let (gravity_mps2, hop_m) =
            (hopper.motion.gravity_mps2, f64::from(grid.hop_cells) * grid.cell_size_m);
        let surface = Surface::new(Bumps { mission, soils: all.soils });
        let [x, y] = self.told.map_or(self.middle_m(from), |told| [told.rest_m[0], told.rest_m[1]]);
        let [aim_x, aim_y] = self.middle_m(grid.hop(from, self.direction));
        let elevation_rad = hopper.motion.launch_angle_rad;
        let design_mps = libm::sqrt(gravity_mps2 * hop_m / libm::sin(2.0 * elevation_rad));
        let speed_max_mps = all.speed_max_mps(design_mps);
        let aim = Aim { target_m: [aim_x - x, aim_y - y], elevation_rad, speed_max_mps };
        let ground = mission.terrain.ground(from).expect("it stands on the map");
        let known = Known { gradient: ground.gradient, soil: *of_soil(&all.nominal, ground.soil) };
        let trimmed_mps = aim.trimmed_mps(&all.body, gravity_mps2, &known);
        let (key, stream) = Draw::key(mission.seed, Domain::Contact, self.robot, self.decision);
        let mut noise = Noise::new(key, stream);
        let launch = aim.launch(trimmed_mps, &all.errors, &mut noise);
        let start = [x, y, surface.height_m(x, y)];
        let place = Place { surface: &surface, body: &all.body, gravity_mps2, hop_m };
        let hop = place.foothold(start.into(), launch).map(|held| place.hop(start.into(), held, &mut noise));
        match hop {
            Some(hop) => self.told(start, &hop, gravity_mps2),
            None => {
                let outcome = Outcome { branch: Branch::Stayed, from, to: from, flight: Flight::default() };
                let figures = [3.0, 0.0, 0.0, 0.0, 0.0, 0.0];
                (outcome, Detail { model: MotionModel::Contact, rest_m: start, figures, path: Vec::new() })
            }
        }
    }

    fn told(&self, start: [f64; 3], hop: &Hop, gravity_mps2: f64) -> (Outcome, Detail) {
        let (rest, up) = (hop.position, hop.launched);
        let (end, is_lost, has_left) = match hop.end {
            End::Rest => (1.0, false, false),
            End::Caught => (2.0, false, false),
            End::NoLaunch => (3.0, false, false),
            End::LeftMap => (4.0, false, true),
            End::RolledAway => (5.0, true, false),
            End::BouncedOn => (6.0, true, false),
        };
        let nearest = self.nearest([rest.x, rest.y]);
        let to = if has_left { self.off_the_map(nearest, [rest.x, rest.y]) } else { nearest };
        let branch = match (is_lost, has_left) {
            (true, _) => Branch::RolledAway,
            (_, true) => Branch::Elsewhere,
            _ => self.branch(to),
        };
        let points = hop.impacts.iter().map(|impact| PathPoint {
            seconds: impact.seconds.min(1.0e6),
            at_m: impact.position.into(),
            leaves_mps: impact.after.into(),
        });
        let launch = PathPoint { seconds: 0.0, at_m: start, leaves_mps: up.into() };
        let rising_mps = up.z.max(0.0);
        let flight = Flight {
            launch_speed_mps: libm::sqrt(up.norm_squared()),
            launch_angle_rad: libm::atan2(up.z, libm::hypot(up.x, up.y)).max(0.0),
            range_m: libm::hypot(rest.x - start[0], rest.y - start[1]),
            rise_m: rest.z - start[2],
            apex_height_m: rising_mps * rising_mps / (2.0 * gravity_mps2),
            flight_time_s: hop.seconds.min(1.0e6),
            flights: 1,
        };
        let energy = 0.5 * up.norm_squared();
        let figures = [end, f64::from(hop.impact_count), hop.rolled_m, hop.seconds, energy, 0.0];
        let path = std::iter::once(launch).chain(points).collect();
        let detail = Detail { model: MotionModel::Contact, rest_m: rest.into(), figures, path };
        (Outcome { branch, from: self.from, to, flight }, detail)
    }

    /// The branch of a hop that rests on a cell.
    pub fn branch(&self, to: Cell) -> Branch {
        let grid = &self.mission.brief.grid;
        let beside = |direction| grid.hop(self.from, direction) == to;
        if beside(self.direction) {
            Branch::Intended
        } else if to == self.from {
            Branch::Stayed
        } else if beside(self.direction.left()) {
            Branch::Left
        } else if beside(self.direction.right()) {
            Branch::Right
        } else {
            Branch::Elsewhere
        }
    }

    /// The cell that a hopper can stand on whose middle is nearest along both axes.
    pub fn nearest(&self, [x, y]: [f64; 2]) -> Cell {
        let Grid { width, height, hop_cells, cell_size_m } = self.mission.brief.grid;
        let along = |metres: f64, from: i32, cells: u32| {
            let hop = hop_cells as i32;
            let middle_m = (f64::from(from) + 0.5) * cell_size_m;
            let hops = libm::floor((metres - middle_m) / (f64::from(hop) * cell_size_m) + 0.5) as i32;
            let all: Vec<i32> = (0..cells as i32).filter(|cell| (cell - from) % hop == 0).collect();
            let (first, last) = (all[0], all[all.len() - 1]);
            (from + hop * hops).clamp(first, last)
        };
        Cell::new(along(x, self.from.x, width), along(y, self.from.y, height))
    }

    /// The first cell of the lattice off the map from `cell`, to the side that is nearest.
    fn off_the_map(&self, cell: Cell, [x, y]: [f64; 2]) -> Cell {
        let grid = self.mission.brief.grid;
        let [east_m, north_m] = [grid.width, grid.height].map(|cells| f64::from(cells) * grid.cell_size_m);
        let sides = [
            (x, Direction::West),
            (east_m - x, Direction::East),
            (y, Direction::South),
            (north_m - y, Direction::North),
        ];
        let mut side = sides[0];
        for other in sides {
            if other.0 < side.0 {
                side = other;
            }
        }
        let mut cell = cell;
        while grid.contains(cell) {
            cell = grid.hop(cell, side.1);
        }
        cell
    }

    /// A hop that would end on another robot: it rests in the middle of the last free cell of its way.
    pub fn displaced(&self, hop: (Outcome, Detail), is_taken: impl Fn(Cell) -> bool) -> (Outcome, Detail) {
        let (outcome, mut detail) = hop;
        let way = detail.path.iter().rev().map(|point| self.nearest([point.at_m[0], point.at_m[1]]));
        let to = way.into_iter().find(|cell| !is_taken(*cell)).unwrap_or(self.from);
        let [x, y] = self.middle_m(to);
        let soils = self.rules.parameters().soils;
        let surface = Surface::new(Bumps { mission: self.mission, soils });
        detail.rest_m = [x, y, surface.height_m(x, y)];
        detail.figures[5] = 1.0;
        (Outcome { branch: self.branch(to), to, ..outcome }, detail)
    }
}
