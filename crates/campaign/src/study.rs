//! Campaigns of studies: a file that names a study, the plan of its trials, their rows.
//!
//! A trial is one case of a study on one world. Trials are counted world by world, so the worlds that an unfinished campaign
//! holds are complete, and the first of a longer campaign are those of a shorter one.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use crate::cell::hexadecimal;
use crate::file::{check_name, check_repetitions};
use crate::trial_plan::{Identity, check_hash, foreign};
use crate::{CampaignError, TrialPlan, TrialRow};

/// A study, with its settings: what its trials are, and what their results look like.
pub trait Study: Clone + Default + PartialEq + Serialize + DeserializeOwned {
    /// Its name in campaign files.
    const NAME: &'static str;

    /// Fewest worlds on which its report is meant.
    const WORLDS_MIN: u64;

    /// What one trial comes to. Serialised, it is always as many numbers and texts as [`Study::headings`] says.
    type Outcome: Clone + PartialEq + Serialize + DeserializeOwned;

    /// Headings of the outcome's columns in `trials.csv`.
    fn headings() -> Vec<String>;

    /// Names of the cases that are flown on each world, in the order of their numbers.
    fn cases() -> &'static [String];

    /// Refuses settings out of their range.
    ///
    /// # Errors
    /// [`CampaignError::Value`], which names the setting.
    fn check_settings(&self) -> Result<(), CampaignError>;

    /// Seed of a world in a campaign with `campaign_seed`.
    fn world_seed(campaign_seed: u64, repetition: u64) -> u64;

    /// Refuses an outcome that `case` cannot have.
    ///
    /// # Errors
    /// What it needs, what it has.
    fn check_outcome(case: usize, outcome: &Self::Outcome) -> Result<(), String>;
}

/// The field of a campaign file, and of `campaign.json`, that names a study.
const FIELD: &str = "study";

/// The study that a campaign file names, if it is TOML and names one.
#[must_use]
pub fn named_in_file(text: &str) -> Option<String> {
    // Other fields are read later: a table of all would refuse seeds from 2^63 on.
    #[derive(Deserialize)]
    struct Named {
        study: toml::Value,
    }
    let Named { study } = toml::from_str(text).ok()?;
    Some(study.as_str().map_or_else(|| study.to_string(), Into::into))
}

/// The study that a `campaign.json` names, if it is JSON and names one.
#[must_use]
pub fn named_in_manifest(text: &str) -> Option<String> {
    let value: serde_json::Value = serde_json::from_str(text).ok()?;
    Some(value.get(FIELD)?.as_str()?.into())
}

/// A campaign file that names a study.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, bound = "S: Study")]
pub struct StudyFile<S> {
    /// Name, up to 31 printable characters without spaces or slashes.
    pub name: String,
    /// Seed that every world's seed is derived from.
    pub seed: u64,
    /// Number of worlds.
    pub repetitions: u64,
    /// Name of the study.
    pub study: String,
    /// Settings of the study; its own where left out.
    #[serde(default)]
    pub settings: S,
}

impl<S: Study> StudyFile<S> {
    /// Reads a campaign from TOML; `origin` names the text in errors.
    ///
    /// # Errors
    /// If the text is not a campaign of this study, or a field is out of its range.
    pub fn parse(text: &str, origin: &str) -> Result<Self, CampaignError> {
        let file: Self = toml::from_str(text).map_err(|error| CampaignError::Toml {
            origin: origin.into(),
            message: scenario::text::toml_error(&error),
        })?;
        check_name(&file.name)?;
        file.clone().plan("").check_contents()?;
        Ok(file)
    }

    /// The plan; `version` is that of the program that will fly.
    #[must_use]
    pub fn plan(self, version: &str) -> StudyPlan<S> {
        let Self { name, seed, repetitions, study, settings } = self;
        let version = version.into();
        let mut plan = StudyPlan { name, seed, repetitions, version, hash: String::new(), study, settings };
        plan.hash = plan.fingerprint();
        plan
    }
}

/// Everything that determines the rows of a campaign of a study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "S: Study")]
pub struct StudyPlan<S> {
    /// Name of the campaign.
    pub name: String,
    /// Seed that every world's seed is derived from.
    pub seed: u64,
    /// Number of worlds.
    pub repetitions: u64,
    /// Version of the program that flies.
    pub version: String,
    /// SHA-256 over all other fields, hexadecimal.
    pub hash: String,
    /// Name of the study.
    pub study: String,
    /// Its settings.
    pub settings: S,
}

/// One case on one world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StudyTrial {
    /// Number in the whole campaign, from 0.
    pub number: u64,
    /// Number of its case, from 0.
    pub case: usize,
    /// Number of its world, from 0.
    pub repetition: u64,
    /// Seed of its world.
    pub seed: u64,
}

impl<S: Study> StudyPlan<S> {
    /// Trial `number`, counted world by world, case by case; `None` beyond the last.
    #[must_use]
    pub fn trial(&self, number: u64) -> Option<StudyTrial> {
        let cases = S::cases().len() as u64;
        let (repetition, case) = (number / cases, (number % cases) as usize);
        let seed = S::world_seed(self.seed, repetition);
        (repetition < self.repetitions).then_some(StudyTrial { number, case, repetition, seed })
    }

    /// SHA-256 over study and settings, hexadecimal: the same for every campaign that flies the same.
    #[must_use]
    pub fn config(&self) -> String {
        hexadecimal(&self.hasher("hopper study v1").finalize())
    }

    fn fingerprint(&self) -> String {
        let mut hasher = self.hasher("hopper study campaign v1");
        for text in [&self.name, &self.version, &format!("{} {}", self.seed, self.repetitions)] {
            hasher.update((text.len() as u64).to_le_bytes());
            hasher.update(text);
        }
        hexadecimal(&hasher.finalize())
    }

    fn hasher(&self, domain: &str) -> Sha256 {
        let settings = serde_json::to_string(&self.settings).expect("settings are numbers and text");
        let mut hasher = Sha256::new();
        for text in [domain, &self.study, &settings] {
            hasher.update((text.len() as u64).to_le_bytes());
            hasher.update(text);
        }
        hasher
    }

    fn check_contents(&self) -> Result<(), CampaignError> {
        if self.study != S::NAME {
            let got = format!("{:?}", self.study);
            return Err(CampaignError::Value { field: FIELD, need: S::NAME.into(), got });
        }
        self.settings.check_settings()?;
        check_repetitions(self.repetitions, S::cases().len() as u64, S::WORLDS_MIN)
    }
}

impl<S: Study> TrialPlan for StudyPlan<S> {
    type Row = StudyRow<S>;

    fn identity(&self) -> Identity<'_> {
        let Self { name, seed, repetitions, version, hash, .. } = self;
        Identity { name, seed: *seed, repetitions: *repetitions, version, hash }
    }

    fn trials(&self) -> u64 {
        S::cases().len() as u64 * self.repetitions
    }

    fn check_plan(&self) -> Result<(), CampaignError> {
        check_hash(self.fingerprint(), &self.hash)?;
        self.check_contents()
    }

    fn check(&self, row: &StudyRow<S>) -> Result<(), CampaignError> {
        let config = self.config();
        let trial = match self.trial(row.trial) {
            Some(trial) if row.config == config => trial,
            _ => return Err(foreign(row.trial, &format!("configuration {config}"), &row.config)),
        };
        let need = StudyRow::new(self, &trial, row.outcome.clone());
        if *row != need {
            return Err(foreign(row.trial, &need.line(), &row.line()));
        }
        S::check_outcome(trial.case, &row.outcome)
            .map_err(|reason| CampaignError::Outcome { trial: row.trial, reason })
    }
}

/// The result of one trial of a study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "S: Study")]
pub struct StudyRow<S: Study> {
    /// Number in the whole campaign, from 0.
    pub trial: u64,
    /// Number of its case, from 0.
    pub cell: u64,
    /// Number of its world, from 0.
    pub repetition: u64,
    /// Seed of its world.
    pub seed: u64,
    /// SHA-256 over study and settings, hexadecimal.
    pub config: String,
    /// Version of the program that flew it.
    pub version: String,
    /// Name of its case.
    pub case: String,
    /// What it came to.
    pub outcome: S::Outcome,
}

impl<S: Study> StudyRow<S> {
    /// The row of `trial` with its outcome.
    #[must_use]
    pub fn new(plan: &StudyPlan<S>, trial: &StudyTrial, outcome: S::Outcome) -> Self {
        Self {
            trial: trial.number,
            cell: trial.case as u64,
            repetition: trial.repetition,
            seed: trial.seed,
            config: plan.config(),
            version: plan.version.clone(),
            case: S::cases()[trial.case].clone(),
            outcome,
        }
    }
}

impl<S: Study> TrialRow for StudyRow<S> {
    fn trial(&self) -> u64 {
        self.trial
    }

    fn headings() -> Vec<String> {
        let own = ["trial", "cell", "repetition", "seed", "config", "version", "case"];
        own.map(String::from).into_iter().chain(S::headings()).collect()
    }

    fn check(&self) -> Result<(), String> {
        // What an outcome may be depends on its case, which only the plan knows for certain.
        Ok(())
    }
}
