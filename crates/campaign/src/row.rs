//! The result of one mission of a grid.

use contract::limits::{DECISIONS_MAX, STEPS_MAX, TREASURES_MAX};
use contract::{Digest, Profile, Status};
use serde::{Deserialize, Serialize};

use crate::{Plan, Trial, TrialRow};

/// Longest line of `trials.jsonl`, bytes.
pub const LINE_BYTES_MAX: usize = 1 << 14;

/// Columns of `trials.csv`.
const HEADINGS: [&str; 18] = [
    "trial",
    "cell",
    "repetition",
    "seed",
    "config",
    "version",
    "scenario",
    "profile",
    "planner",
    "safety",
    "information",
    "distance",
    "outcome",
    "steps",
    "hops",
    "treasures",
    "coverage",
    "digest",
];

/// One row. All of it is reproducible; computing times are kept in another file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Number in the whole campaign, from 0.
    pub trial: u64,
    /// Number of its cell, from 0.
    pub cell: u64,
    /// Repetition within its cell, from 0.
    pub repetition: u64,
    /// Seed of its random draws, as `hopper run --seed` takes it.
    pub seed: u64,
    /// SHA-256 over resolved scenario and planner, hexadecimal.
    pub config: String,
    /// Version of the program that flew it.
    pub version: String,
    /// Scenario as the campaign names it.
    pub scenario: String,
    /// Profile: which reading of the model is flown.
    pub profile: Profile,
    /// Name of the algorithm.
    pub planner: String,
    /// Weight w1, of safety S.
    pub safety: f64,
    /// Weight w2, of information I.
    pub information: f64,
    /// Weight w3, of the distance penalty D.
    pub distance: f64,
    /// Final status of the mission.
    pub outcome: Status,
    /// Steps, in the count of the mission's limits.
    pub steps: u64,
    /// Number of hops commanded.
    pub hops: u64,
    /// Number of treasures collected.
    pub treasures: u32,
    /// Share of the map seen, 0 to 1.
    pub coverage: f64,
    /// Digest of everything the mission executed.
    pub digest: Digest,
}

/// What only flying a trial can tell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrialResult {
    /// Final status of the mission.
    pub outcome: Status,
    /// Steps, in the count of the mission's limits.
    pub steps: u64,
    /// Number of hops commanded.
    pub hops: u64,
    /// Number of treasures collected.
    pub treasures: u32,
    /// Share of the map seen, 0 to 1.
    pub coverage: f64,
    /// Digest of everything the mission executed.
    pub digest: Digest,
}

impl Row {
    /// The row of `trial` with `result`.
    #[must_use]
    pub fn new(plan: &Plan, trial: &Trial<'_>, result: TrialResult) -> Self {
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
            outcome: result.outcome,
            steps: result.steps,
            hops: result.hops,
            treasures: result.treasures,
            coverage: result.coverage,
            digest: result.digest,
        }
    }

    /// The fields that the plan does not determine.
    #[must_use]
    pub fn result(&self) -> TrialResult {
        let Self { outcome, steps, hops, treasures, coverage, digest, .. } = *self;
        TrialResult { outcome, steps, hops, treasures, coverage, digest }
    }
}

impl TrialRow for Row {
    fn trial(&self) -> u64 {
        self.trial
    }

    fn headings() -> Vec<String> {
        HEADINGS.map(String::from).to_vec()
    }

    fn check(&self) -> Result<(), String> {
        let most = |field, most: u64, got: u64| {
            if got <= most { Ok(()) } else { Err(format!("{field}: need at most {most}, got {got}")) }
        };
        most("steps", STEPS_MAX, self.steps)?;
        most("hops", DECISIONS_MAX, self.hops)?;
        most("treasures", TREASURES_MAX as u64, self.treasures.into())?;
        if (0.0..=1.0).contains(&self.coverage) {
            Ok(())
        } else {
            Err(format!("coverage: need 0 to 1, got {}", self.coverage))
        }
    }
}
