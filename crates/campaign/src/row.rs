//! What became of one trial: a row of `trials.jsonl` and `trials.csv`.
//!
//! A line of `trials.jsonl` closes with the CRC-32 of all that stands before it, as text, so that a row that
//! was damaged is told from one that was written.

use contract::limits::{DECISIONS_MAX, STEPS_MAX, TREASURES_MAX};
use contract::{Digest, Profile, Status};
use serde::{Deserialize, Serialize};

use crate::seal::{seal, unseal};
use crate::{Plan, Trial};

/// Longest line of `trials.jsonl`, bytes.
pub const LINE_BYTES_MAX: usize = 1 << 14;

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

    /// What of it no plan could foretell.
    #[must_use]
    pub fn ending(&self) -> Ending {
        let Self { outcome, steps, hops, treasures, coverage, digest, .. } = *self;
        Ending { outcome, steps, hops, treasures, coverage, digest }
    }

    /// The row as a line of `trials.jsonl`, ended.
    #[must_use]
    pub fn line(&self) -> String {
        let mut text = serde_json::to_string(self).expect("a row is numbers and text");
        assert_eq!(text.pop(), Some('}'), "a row is an object");
        seal(&text) + "\n"
    }

    /// The row of a `line` that was ended; the line's end is no part of it.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn of_line(line: &[u8]) -> Result<Self, String> {
        let text = std::str::from_utf8(line).map_err(|error| format!("need UTF-8, got {error}"))?;
        let row: Self = serde_json::from_str(&unseal(text)?).map_err(|error| error.to_string())?;
        row.check()?;
        Ok(row)
    }

    /// Numbers that no mission can come to.
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
