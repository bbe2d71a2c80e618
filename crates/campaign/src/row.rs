//! What became of one trial: a row of `trials.jsonl` and `trials.csv`.

use contract::{Digest, Profile, Status};
use serde::{Deserialize, Serialize};

use crate::{Plan, Trial};

/// One row. All of it is reproducible; times are kept apart.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Number in the whole campaign, from 0.
    pub trial: u64,
    /// Number of its cell.
    pub cell: u64,
    /// Repetition within its cell.
    pub repetition: u64,
    /// Seed of its draws, as `hopper run --seed` takes it.
    pub seed: u64,
    /// Hash of world and planner.
    pub config: String,
    /// Version of the program that flew it.
    pub version: String,
    /// Scenario as the campaign names it.
    pub scenario: String,
    /// Reading of the model.
    pub profile: Profile,
    /// Algorithm.
    pub planner: String,
    /// Weight w1.
    pub safety: f64,
    /// Weight w2.
    pub information: f64,
    /// Weight w3.
    pub distance: f64,
    /// How it ended.
    pub outcome: Status,
    /// Steps, in the paper's count.
    pub steps: u64,
    /// Hops commanded.
    pub hops: u64,
    /// Treasures collected.
    pub treasures: u32,
    /// Share of the map seen, 0 to 1.
    pub coverage: f64,
    /// Digest of the mission.
    pub digest: Digest,
}

/// How a trial ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ending {
    /// How.
    pub outcome: Status,
    /// Steps, in the paper's count.
    pub steps: u64,
    /// Hops commanded.
    pub hops: u64,
    /// Treasures collected.
    pub treasures: u32,
    /// Share of the map seen, 0 to 1.
    pub coverage: f64,
    /// Digest of the mission.
    pub digest: Digest,
}

impl Row {
    /// The row of `trial`, which ended so.
    #[must_use]
    pub fn new(plan: &Plan, trial: &Trial<'_>, ending: Ending) -> Self {
        let cell = trial.cell;
        Self {
            trial: trial.number,
            cell: cell.number,
            repetition: trial.repetition,
            seed: trial.seed,
            config: cell.config.clone(),
            version: plan.version.clone(),
            scenario: cell.scenario.clone(),
            profile: cell.profile,
            planner: cell.planner.clone(),
            safety: cell.weights.safety,
            information: cell.weights.information,
            distance: cell.weights.distance,
            outcome: ending.outcome,
            steps: ending.steps,
            hops: ending.hops,
            treasures: ending.treasures,
            coverage: ending.coverage,
            digest: ending.digest,
        }
    }
}
