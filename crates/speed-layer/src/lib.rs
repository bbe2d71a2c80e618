//! Expected speed and spread of every cell of uncertain ground, for displays.
//!
//! They are those that planners count with: [`helicopter::Sighting::belief`] is the one place where an observation weighs the prior.
//! Most cells share a distribution, so it is kept once, with what becomes of it under each reading.

#![warn(clippy::disallowed_methods)]

use std::collections::BTreeMap;

use contract::{DriveSpeed, Ground, PriorCell, Robot, SpeedPrior};
use helicopter::{Sensor, Sighting};
use rover::{Speed, SpeedDistribution};

/// Largest expected speed, m/Sol.
pub const SPEED_MAX_M_PER_SOL: f64 = Speed::Fast.m_per_sol();

/// Largest spread, m/Sol: standing still as likely as the largest speed.
pub const SPREAD_MAX_M_PER_SOL: f64 = SPEED_MAX_M_PER_SOL / 2.0;

/// What is known of the speed of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct SpeedEstimate {
    /// E\[v\], 0 to 200 m/Sol.
    pub mean_m_per_sol: f64,
    /// Standard deviation of v, 0 to 100 m/Sol.
    pub sd_m_per_sol: f64,
}

impl SpeedEstimate {
    /// A speed that was seen.
    #[must_use]
    pub fn certain(speed: DriveSpeed) -> Self {
        Self::of(&SpeedDistribution::certain(Speed::ALL[speed as usize]))
    }

    /// Expected speed and standard deviation, as the layers of the map take them.
    #[must_use]
    pub fn mean_and_sd_m_per_sol(self) -> [f64; 2] {
        [self.mean_m_per_sol, self.sd_m_per_sol]
    }

    fn of(speeds: &SpeedDistribution) -> Self {
        Self { mean_m_per_sol: speeds.mean_m_per_sol(), sd_m_per_sol: speeds.sd_m_per_sol() }
    }
}

/// What one distribution of the prior comes to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedRow {
    /// Before anything was seen.
    pub unseen: SpeedEstimate,
    /// After each reading of a camera that errs, in the order of [`DriveSpeed::ALL`]; as before where none does.
    pub read: [SpeedEstimate; 4],
}

/// The expected speeds of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct SpeedLayer {
    rows: Vec<SpeedRow>,
    /// For each cell, in index order, its row.
    codes: Vec<u32>,
}

impl SpeedLayer {
    /// The layer of a prior; `robots` say whether a camera errs.
    #[must_use]
    pub fn new(prior: &[PriorCell], robots: &[Robot]) -> Self {
        Self::of_speeds(prior.iter().map(|cell| &cell.speeds), robots)
    }

    /// The layer of these probabilities, in index order.
    #[must_use]
    pub fn of_speeds<'a>(prior: impl Iterator<Item = &'a SpeedPrior>, robots: &[Robot]) -> Self {
        let mut accuracies = robots.iter().filter_map(|robot| robot.sensor.accuracy());
        let camera = accuracies.next().and_then(|accuracy| Sensor::with_accuracy(accuracy).ok());
        let mut known = BTreeMap::new();
        let mut layer = Self { rows: Vec::new(), codes: Vec::new() };
        let mut last: Option<(&SpeedPrior, u32)> = None;
        for speeds in prior {
            if let Some((_, code)) = last.filter(|(last, _)| *last == speeds) {
                layer.codes.push(code);
                continue;
            }
            let bits = speeds.probabilities().map(f64::to_bits);
            let code = *known.entry(bits).or_insert_with(|| {
                layer.rows.push(SpeedRow::of(speeds, camera.as_ref()));
                layer.rows.len() as u32 - 1
            });
            layer.codes.push(code);
            last = Some((speeds, code));
        }
        layer
    }

    /// The distinct distributions.
    #[must_use]
    pub fn rows(&self) -> &[SpeedRow] {
        &self.rows
    }

    /// For each cell, in index order, the number of its row.
    #[must_use]
    pub fn codes(&self) -> &[u32] {
        &self.codes
    }

    /// What is known of the cell at `index`, of which `speed` and `reading` were observed; `None` outside of the map.
    #[must_use]
    pub fn estimate(
        &self,
        index: usize,
        speed: Option<DriveSpeed>,
        reading: Option<DriveSpeed>,
    ) -> Option<SpeedEstimate> {
        let row = &self.rows[*self.codes.get(index)? as usize];
        Some(match (speed, reading) {
            (Some(speed), _) => SpeedEstimate::certain(speed),
            (None, Some(reading)) => row.read[reading as usize],
            (None, None) => row.unseen,
        })
    }

    /// What is believed of the speed in cell `index` of the observed map, of which `seen` is known.
    #[must_use]
    pub fn estimate_seen(&self, index: usize, seen: Option<&Ground>) -> Option<SpeedEstimate> {
        let (speed, reading) = seen.map_or((None, None), |ground| (ground.speed, ground.reading));
        self.estimate(index, speed, reading)
    }
}

impl SpeedRow {
    fn of(speeds: &SpeedPrior, camera: Option<&Sensor>) -> Self {
        // A prior of the contract is a distribution; zero probabilities everywhere would be an estimate of 0 m/Sol.
        let Ok(prior) = SpeedDistribution::as_given(speeds.probabilities()) else {
            return Self { unseen: SpeedEstimate::default(), read: [SpeedEstimate::default(); 4] };
        };
        let read = |reading| Sighting { speed: None, reading: Some(reading) }.belief(prior, camera);
        Self {
            unseen: SpeedEstimate::of(&prior),
            read: Speed::ALL.map(|reading| SpeedEstimate::of(&read(reading))),
        }
    }
}
