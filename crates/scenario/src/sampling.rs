//! Section `[sampling]`: what planners of routes over uncertain ground are given.

use contract::limits::SAMPLES_MAX;
use contract::{Account, Sampling};
#[cfg(test)]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::ScenarioError;
use crate::error::refuse;

/// Samples of the planners of routes, and stages; only with a driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct SamplingRules {
    /// Samples that the RRT* planners of a driver draw, 1 to 1000000; the default is for 200 x 200 cells.
    #[serde(skip_serializing_if = "is_default_rover_samples")]
    pub rover_samples: u32,
    /// Samples that the RRT* planner of a helicopter draws, 1 to 1000000.
    #[serde(skip_serializing_if = "is_default_helicopter_samples")]
    pub helicopter_samples: u32,
    /// Flights of the helicopters before the goal, each with a drive after it that takes a Sol at most unless it is the last, 1 to
    /// 64. More than 1 only for one driver with helicopters alone.
    #[serde(skip_serializing_if = "is_one")]
    pub stages: u32,
}

impl Default for SamplingRules {
    fn default() -> Self {
        Self { rover_samples: 1200, helicopter_samples: 600, stages: 1 }
    }
}

impl SamplingRules {
    /// Whether everything is at its default, so that the section is left out of the canonical text.
    pub(crate) fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// What planners of routes are given; `None` where no robot drives to a goal. `seed` is theirs.
    pub(crate) fn resolve(
        &self,
        account: Account,
        drives: bool,
        flies: bool,
        seed: u64,
    ) -> Result<Option<Sampling>, ScenarioError> {
        let Self { rover_samples, helicopter_samples, stages } = *self;
        if !drives {
            return match self.is_default() {
                true => Ok(None),
                false => refuse("sampling", "a robot with body = \"driver\"", "none".into()),
            };
        }
        if !(1..=Sampling::STAGES_MAX).contains(&stages) {
            return refuse("sampling.stages", "1 to 64", stages.to_string());
        }
        if stages > 1 && account != Account::Actions {
            let need = "1, unless there is one driver, and all others are helicopters";
            return refuse("sampling.stages", need, stages.to_string());
        }
        if stages > 1 && !flies {
            let need = "1 without a helicopter, whose flights begin the stages";
            return refuse("sampling.stages", need, stages.to_string());
        }
        for (field, samples) in
            [("sampling.rover_samples", rover_samples), ("sampling.helicopter_samples", helicopter_samples)]
        {
            if !(1..=SAMPLES_MAX).contains(&samples) {
                return refuse(field, "1 to 1000000", samples.to_string());
            }
        }
        Ok(Some(Sampling { seed, rover_samples, helicopter_samples, stages }))
    }
}

fn is_default_rover_samples(samples: &u32) -> bool {
    *samples == SamplingRules::default().rover_samples
}

fn is_default_helicopter_samples(samples: &u32) -> bool {
    *samples == SamplingRules::default().helicopter_samples
}

fn is_one(stages: &u32) -> bool {
    *stages == 1
}
