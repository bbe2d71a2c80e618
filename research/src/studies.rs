//! Studies of papers as campaigns: what a trial of each is, and how it is flown.
//!
//! A study is flown trial by trial, each on a world of its own seed. `hopper scouting` and `hopper coverage` keep the outcomes
//! in memory, `hopper campaign run` keeps them as rows; the report is made of the same outcomes either way.

pub mod coverage;
pub mod large;
pub mod monte_carlo;
pub mod single;
mod team;

use ::campaign::{Study, StudyPlan};
use node::Failure;
use rayon::prelude::*;

pub use team::{Planner, is_0};

/// Version of what decides the rows of studies: that of `hopper`, and a hash of the sources that only studies use.
pub fn version() -> String {
    format!("{}.{}", hopper::commands::campaign::store::VERSION, env!("RESEARCH_SOURCES"))
}

/// A study that this program can fly.
pub trait Flown: Study<Outcome: Send> + Send + Sync + 'static {
    /// What all trials share.
    type Ground: Send + Sync + 'static;

    /// Makes what all trials share.
    fn ground(&self) -> Self::Ground;

    /// Flies `case` on the world of `seed`.
    ///
    /// # Errors
    /// If the world cannot be made, or the mission does not end.
    fn fly(&self, ground: &Self::Ground, case: usize, seed: u64) -> Result<Self::Outcome, Failure>;
}

/// All cases of a study on one world.
#[derive(Clone, Debug, PartialEq)]
pub struct FlownWorld<S: Study> {
    /// Seed of the world.
    pub seed: u64,
    /// What each case came to.
    pub outcomes: Vec<S::Outcome>,
}

/// The plan of `repetitions` worlds from `seed` on.
pub fn plan<S: Flown>(settings: S, seed: u64, repetitions: u64) -> StudyPlan<S> {
    let (name, study) = (S::NAME.into(), S::NAME.into());
    ::campaign::StudyFile { name, seed, repetitions, study, settings }.plan(&version())
}

/// Flies every trial of a plan on all cores, and keeps the outcomes in memory.
///
/// # Errors
/// Those of a trial that fails.
pub fn fly_all<S: Flown>(plan: &StudyPlan<S>) -> Result<Vec<FlownWorld<S>>, Failure> {
    let (ground, cases) = (plan.settings.ground(), S::cases().len() as u64);
    let outcomes = (0..plan.repetitions * cases).into_par_iter().map(|number| {
        let trial = plan.trial(number).expect("a trial of the plan");
        plan.settings.fly(&ground, trial.case, trial.seed)
    });
    let mut outcomes = outcomes.collect::<Result<Vec<_>, _>>()?.into_iter();
    let world = |repetition: u64| FlownWorld {
        seed: S::world_seed(plan.seed, repetition),
        outcomes: outcomes.by_ref().take(cases as usize).collect(),
    };
    Ok((0..plan.repetitions).map(world).collect())
}
