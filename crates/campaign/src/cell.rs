//! One cell of a campaign's grid: a resolved scenario and the planner that flies it.

use contract::{MotionModel, Profile, Weights};
use scenario::{ResolvedScenario, Scenario};
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use crate::CampaignError;

/// A cell with its resolved scenario, so that no other file than elevation models is needed to fly it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    /// Position in the plan, from 0.
    pub number: u64,
    /// Scenario as the campaign names it.
    pub scenario: String,
    /// Profile: which reading of the model is flown.
    pub profile: Profile,
    /// Name of the algorithm.
    pub planner: String,
    /// Weights w1, w2, w3 of the payoff.
    pub weights: Weights,
    /// Name of the reading of the model's open points, in a campaign that compares some.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reading: Option<String>,
    /// What decides where hops end.
    #[serde(default = "law", skip_serializing_if = "is_law")]
    pub dynamics: MotionModel,
    /// Steps after which a mission ends as a deadlock.
    pub steps_max: u64,
    /// SHA-256 over the resolved scenario and the planner, hexadecimal.
    pub config: String,
    /// The resolved scenario as canonical TOML.
    pub world: String,
}

impl Cell {
    pub(crate) fn new(
        number: u64,
        selector: &str,
        planner: &str,
        weights: Weights,
        reading: Option<&str>,
        world: &ResolvedScenario,
    ) -> Self {
        Self {
            number,
            scenario: selector.into(),
            profile: world.brief.profile,
            planner: planner.into(),
            weights,
            reading: reading.map(Into::into),
            dynamics: world.dynamics.model(),
            steps_max: world.brief.limits.steps_max,
            config: config(world, planner),
            world: world.resolved.clone(),
        }
    }

    /// Resolves the cell's scenario again.
    ///
    /// # Errors
    /// If an elevation file or mask is gone or has changed.
    pub fn world(&self) -> Result<ResolvedScenario, CampaignError> {
        let failed =
            |source| CampaignError::Scenario { selector: self.scenario.clone(), source: Box::new(source) };
        let world = Scenario::parse(&self.world, &self.scenario)
            .and_then(|scenario| scenario.resolve())
            .map_err(failed)?;
        let got = config(&world, &self.planner);
        if got != self.config {
            let (number, name) = (self.number, self.to_string());
            return Err(CampaignError::Changed { number, name, need: self.config.clone(), got });
        }
        Ok(world)
    }

    /// Seed of a repetition in a campaign with `campaign_seed`. It depends on what the cell holds, never on
    /// its position, so a grid can grow without changing its trials; nor on its reading, so that readings are
    /// compared on the same draws. It has 53 bits, which every reader of
    /// JSON represents exactly.
    #[must_use]
    pub fn seed(&self, campaign_seed: u64, repetition: u64) -> u64 {
        let mut hasher = Sha256::new();
        hasher.update(b"hopper campaign seed v1");
        hasher.update(campaign_seed.to_le_bytes());
        for text in [&self.scenario, &self.planner] {
            hasher.update((text.len() as u64).to_le_bytes());
            hasher.update(text);
        }
        hasher.update(self.profile.code().to_le_bytes());
        let Weights { safety, information, distance } = self.weights;
        for weight in [safety, information, distance] {
            hasher.update(weight.to_bits().to_le_bytes());
        }
        hasher.update(repetition.to_le_bytes());
        let bytes: [u8; 32] = hasher.finalize().into();
        bytes[..8].iter().fold(0, |seed, byte| seed << 8 | u64::from(*byte)) >> 11
    }
}

impl std::fmt::Display for Cell {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Weights { safety, information, .. } = self.weights;
        write!(f, "{} {} ({safety}, {information}) in {}", self.scenario, self.planner, self.profile)?;
        self.reading.as_ref().map_or(Ok(()), |reading| write!(f, ", {reading}"))
    }
}

/// What a cell is flown under that names nothing else.
fn law() -> MotionModel {
    MotionModel::Law
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks with a reference")]
pub(crate) fn is_law(model: &MotionModel) -> bool {
    *model == MotionModel::Law
}

fn config(world: &ResolvedScenario, planner: &str) -> String {
    let mut hasher = Sha256::new();
    hasher.update(b"hopper campaign cell v1");
    hasher.update(world.hash);
    hasher.update(planner);
    hexadecimal(&hasher.finalize())
}

pub(crate) fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
