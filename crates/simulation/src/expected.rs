//! The map and the digest as they should be, computed by code that shares nothing with the product's: what gradients follow from
//! what is seen, the fingerprint of a map, and the digest chain.

use std::num::NonZeroU8;

use contract::{
    Account, Brief, Cell, Detail, DetailId, Digest, DriveSpeed, GradientSource, Ground, Pose, Profile,
    Record, Robot, Soil,
};
use sha2::{Digest as _, Sha256};
use terrain::Terrain;
use xxhash_rust::xxh3::xxh3_64;

use crate::sensor::{self, cells_of, distance_m, is_inside};

/// What robots on their way have shown of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shown {
    Nothing,
    /// By a camera that errs.
    Reading,
    Truth,
}

/// What has been seen from the poses so far.
#[derive(Clone, Debug)]
pub(crate) struct Expected {
    seen: Vec<bool>,
    /// Whether a seen cell is known only from a reading of a camera that errs.
    doubtful: Vec<bool>,
    /// Cells with treasures that were seen and not landed on, in index order.
    treasures: Vec<Cell>,
    /// What is known of each cell, in index order.
    cells: Vec<Option<Ground>>,
    /// The highest that sensors have reported of each cell, in index order.
    reported: Vec<Option<NonZeroU8>>,
    /// How often rovers have entered each cell, in index order.
    visits: Vec<u16>,
    /// Cells that each pose so far revealed or held in view.
    pub disc_cells: Vec<usize>,
}

impl Expected {
    pub fn unseen(brief: &Brief) -> Self {
        let count = brief.grid.cells();
        Self {
            seen: vec![false; count],
            doubtful: vec![false; count],
            treasures: Vec::new(),
            cells: vec![None; count],
            reported: vec![None; count],
            visits: vec![0; count],
            disc_cells: Vec::new(),
        }
    }

    pub fn cells(&self) -> &[Option<Ground>] {
        &self.cells
    }

    pub fn treasures(&self) -> &[Cell] {
        &self.treasures
    }

    pub fn is_seen(&self, index: usize) -> bool {
        self.seen[index]
    }

    /// A rover that covers ground has entered a cell.
    pub fn visit(&mut self, brief: &Brief, at: Cell) {
        self.visits[index_of(brief, at)] += 1;
    }

    /// A hopper has landed on a cell: a treasure there is collected.
    pub fn collect(&mut self, at: Cell) {
        self.treasures.retain(|cell| *cell != at);
    }

    /// A robot is at `pose`: what its sensor reports of the cells in view is part of what is revealed next.
    pub fn report(&mut self, brief: &Brief, robot: &Robot, pose: Pose) {
        let sensor = sensor::of(&robot.sensor);
        if sensor.reports(0.0).is_none() {
            return;
        }
        for index in sensor.around(brief, pose) {
            let cell =
                Cell::new(index as i32 % brief.grid.width as i32, index as i32 / brief.grid.width as i32);
            let report = sensor.reports(distance_m(brief, pose.cell, cell));
            self.reported[index] = self.reported[index].max(report);
        }
    }

    /// This is what robots have shown on their way, in index order.
    pub fn reveal(&mut self, brief: &Brief, terrain: &Terrain, shown: &[Shown]) {
        for (index, cell) in cells_of(brief).enumerate() {
            let is_shown = shown[index] != Shown::Nothing;
            if is_shown && !self.seen[index] && terrain.treasures.contains(&cell) {
                self.treasures.push(cell);
            }
            self.seen[index] |= is_shown;
            self.doubtful[index] = shown[index] == Shown::Reading;
        }
        self.treasures.sort_by_key(|cell| (cell.y, cell.x));
        self.cells = cells_of(brief).map(|cell| self.ground(brief, terrain, cell)).collect();
    }

    /// The hopper that the mission is about is at `pose`: how much it sees from there is noted, and a treasure collected.
    pub fn land(&mut self, brief: &Brief, pose: Pose) {
        self.disc_cells.push(sensor::of(&brief.robots[0].sensor).around(brief, pose).len());
        self.collect(pose.cell);
    }

    /// What is known of a cell.
    fn ground(&self, brief: &Brief, terrain: &Terrain, cell: Cell) -> Option<Ground> {
        let known = |x: i32, y: i32| {
            let at = Cell::new(cell.x + x, cell.y + y);
            let index = is_inside(brief, at).then(|| index_of(brief, at))?;
            let truth = terrain.cells[index];
            // Where robots of all kinds are, passable ground is that of the hoppers.
            let passable = match brief.account {
                Account::ActionsWithoutWaits => truth.passable,
                Account::Hopper | Account::Actions => truth.reading != Some(DriveSpeed::Zero),
            };
            let truth = Ground { reported: self.reported[index], ..truth };
            let of_reading = Ground { speed: None, passable, ..truth };
            let told = if self.doubtful[index] { of_reading } else { Ground { reading: None, ..truth } };
            self.seen[index].then_some(told)
        };
        let here = known(0, 0)?;
        if gradient_of(brief) == GradientSource::Measured {
            return Some(here);
        }
        let slope = |x: i32, y: i32| {
            let (ahead, behind) = (known(x, y), known(-x, -y));
            let spacing = f64::from(u8::from(ahead.is_some()) + u8::from(behind.is_some()));
            let rise_m = ahead.unwrap_or(here).height_m - behind.unwrap_or(here).height_m;
            if spacing > 0.0 { rise_m / (spacing * brief.grid.cell_size_m) } else { 0.0 }
        };
        Some(Ground { gradient: [slope(1, 0), slope(0, 1)], ..here })
    }

    /// The fingerprint that a map of these cells and treasures has.
    pub fn fingerprint(&self) -> u64 {
        let mut sum = 0_u64;
        for (index, ground) in self.cells.iter().enumerate() {
            let Some(ground) = ground else { continue };
            let mut bytes = (index as u32).to_le_bytes().to_vec();
            for value in [ground.height_m, ground.gradient[0], ground.gradient[1]] {
                bytes.extend(value.to_bits().to_le_bytes());
            }
            let speed = ground.speed.map_or(0, |speed| 1 + speed as u8);
            let reading = ground.reading.map_or(0, |reading| 1 + reading as u8);
            let sand = u8::from(ground.soil == Soil::Sand);
            bytes.extend([sand + 2 * speed + 16 * reading, u8::from(ground.passable)]);
            if self.visits[index] > 0 || ground.reported.is_some() {
                bytes.extend(self.visits[index].to_le_bytes());
            }
            bytes.extend(ground.reported.map(NonZeroU8::get));
            sum = sum.wrapping_add(xxh3_64(&bytes));
        }
        for cell in &self.treasures {
            sum = sum.wrapping_add(xxh3_64(&[cell.x.to_le_bytes(), cell.y.to_le_bytes()].concat()));
        }
        sum
    }
}

/// Where gradients come from: the same for all hoppers of a mission, and measured where nobody hops.
fn gradient_of(brief: &Brief) -> GradientSource {
    let mut sensors = brief.robots.iter().map(|robot| sensor::of(&robot.sensor));
    sensors.find_map(|sensor| sensor.gradient()).unwrap_or(GradientSource::Measured)
}

fn index_of(brief: &Brief, cell: Cell) -> usize {
    (cell.y * brief.grid.width as i32 + cell.x) as usize
}

/// The digest before the first decision.
pub(crate) fn first_digest(brief: &Brief, seed: u64) -> Digest {
    let profile: u32 = match brief.profile {
        Profile::Paper2023 => 1,
        Profile::Hopper => 2,
        Profile::Paper2022 => 3,
    };
    let mut bytes = b"hopper chain v2".to_vec();
    bytes.extend(brief.scenario_hash);
    bytes.extend(seed.to_le_bytes());
    bytes.extend(profile.to_le_bytes());
    bytes.extend(0_u16.to_le_bytes());
    Digest(Sha256::digest(bytes).into())
}

/// The name of what a motion model tells: the hash of all its numbers.
pub(crate) fn detail_id(detail: &Detail) -> DetailId {
    let mut bytes = detail.model.code().to_le_bytes().to_vec();
    let mut add = |values: &[f64]| {
        values.iter().for_each(|value| bytes.extend(value.to_bits().to_le_bytes()));
    };
    add(&detail.rest_m);
    add(&detail.figures);
    for point in &detail.path {
        add(&[point.seconds]);
        add(&point.at_m);
        add(&point.leaves_mps);
    }
    DetailId(Sha256::digest(bytes).into())
}

/// The digest after `record`, from the one before it: everything that was executed, and nothing else.
pub(crate) fn next_digest(before: Digest, record: &Record) -> Digest {
    let (outcome, flight) = (&record.outcome, &record.outcome.flight);
    let mut bytes = before.0.to_vec();
    bytes.extend(record.decision.0.to_le_bytes());
    bytes.extend(record.action.code().to_le_bytes());
    bytes.extend(outcome.branch.code().to_le_bytes());
    for coordinate in
        [outcome.from.x, outcome.from.y, outcome.to.x, outcome.to.y, record.pose.cell.x, record.pose.cell.y]
    {
        bytes.extend(coordinate.to_le_bytes());
    }
    for value in [
        flight.launch_speed_mps,
        flight.launch_angle_rad,
        flight.range_m,
        flight.rise_m,
        flight.apex_height_m,
        flight.flight_time_s,
        record.pose.height_m,
    ] {
        bytes.extend(value.to_bits().to_le_bytes());
    }
    bytes.extend(flight.flights.to_le_bytes());
    bytes.extend(record.steps.to_le_bytes());
    bytes.extend(record.status.code().to_le_bytes());
    bytes.extend(record.collected.0.to_le_bytes());
    if let contract::Action::Announce(route) = record.action {
        bytes.extend(route.0.to_le_bytes());
    }
    if record.detail != DetailId::NONE {
        bytes.extend(record.detail.0);
    }
    if record.robot.0 > 0 {
        bytes.extend(record.robot.0.to_le_bytes());
    }
    Digest(Sha256::digest(bytes).into())
}
