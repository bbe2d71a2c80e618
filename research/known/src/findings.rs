//! The paper's four observations, computed.

use serde::Serialize;

use crate::{Claim, Experiment, Model, Path, Plan, Reading, Weights, World, claims};

/// One plan of the paper.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Case {
    /// The world.
    pub experiment: Experiment,
    /// What was weighed.
    pub weights: Weights,
    /// The path.
    pub path: Path,
    /// Sweeps of value iteration.
    pub sweeps: u32,
    /// Whether the values settled.
    pub settled: bool,
}

/// Every plan of the paper with the claims that it makes of them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Findings {
    /// The reading.
    pub reading: Reading,
    /// The plans: eleven each on hard, heterogeneous and sandy ground, heterogeneous ground with the goal
    /// at 50 and w = (1, 0), the rocks at w = (0.5, 0.5).
    pub cases: Vec<Case>,
    /// The paper's claims.
    pub claims: Vec<Claim>,
}

impl Findings {
    /// Plans everything under `reading` and looks at it.
    #[must_use]
    pub fn new(reading: &Reading) -> Self {
        let mut cases = Vec::new();
        let half = Weights { safety: 0.5, information: 0.5, goal: Weights::GOAL };
        let safe = Weights { safety: 1.0, information: 0.0, goal: Weights::GOAL_RAISED };
        for experiment in Experiment::ALL {
            let world = World::new(experiment, reading);
            let model = Model::new(&world, reading);
            let weights: Vec<Weights> = match experiment {
                Experiment::Rocks => vec![half],
                Experiment::Heterogeneous => Weights::eleven().chain([safe]).collect(),
                Experiment::Hard | Experiment::Sandy => Weights::eleven().collect(),
            };
            for weights in weights {
                let Plan { solution, path, .. } = Plan::new(&world, &model, reading, weights);
                let (sweeps, settled) = (solution.sweeps, solution.settled);
                cases.push(Case { experiment, weights, path, sweeps, settled });
            }
        }
        let claims = claims::all(&cases, reading);
        Self { reading: *reading, cases, claims }
    }

    /// The plans of one world with the goal's payoff of 10, w1 ascending.
    pub fn of(&self, experiment: Experiment) -> impl Iterator<Item = &Case> {
        claims::of(&self.cases, experiment)
    }

    /// The plan with the raised goal.
    ///
    /// # Panics
    /// Never: [`Findings::new`] makes it.
    #[must_use]
    pub fn raised(&self) -> &Case {
        claims::raised(&self.cases)
    }

    /// Claims that hold, of those that a reading can be judged by; with the number of the latter.
    #[must_use]
    pub fn score(&self) -> (usize, usize) {
        let judged = self.claims.iter().filter(|claim| !claim.by_construction);
        (judged.clone().filter(|claim| claim.holds).count(), judged.count())
    }
}
