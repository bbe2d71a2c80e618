//! Computes the plans of the paper and checks its claims.

use serde::Serialize;

use crate::{Case, Claim, Experiment, KnownMap, Model, Plan, Reading, Weights, claims};

/// Every plan of the paper with its claims about them, under one reading.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Findings {
    /// Reading of the paper that was used.
    pub reading: Reading,
    /// The plans: eleven each on hard, heterogeneous and sandy ground, heterogeneous ground with the goal
    /// at 50 and w = (1, 0), the rocks at w = (0.5, 0.5).
    pub cases: Vec<Case>,
    /// Claims of the paper, in its order.
    pub claims: Vec<Claim>,
}

impl Findings {
    /// Computes all plans under `reading` and checks the claims.
    #[must_use]
    pub fn new(reading: &Reading) -> Self {
        let mut cases = Vec::new();
        let half = Weights { safety: 0.5, information: 0.5, goal: Weights::GOAL };
        let safe = Weights { safety: 1.0, information: 0.0, goal: Weights::GOAL_RAISED };
        for experiment in Experiment::ALL {
            let map = KnownMap::new(experiment, reading);
            let model = Model::new(&map, reading);
            let weights: Vec<Weights> = match experiment {
                Experiment::Rocks => vec![half],
                Experiment::Heterogeneous => Weights::eleven().chain([safe]).collect(),
                Experiment::Hard | Experiment::Sandy => Weights::eleven().collect(),
            };
            for weights in weights {
                let Plan { solution, path, .. } = Plan::new(&map, &model, reading, weights);
                let (sweeps, settled) = (solution.sweeps, solution.settled);
                cases.push(Case { experiment, weights, path, sweeps, settled });
            }
        }
        let claims = claims::all(&cases, reading);
        Self { reading: *reading, cases, claims }
    }

    /// The plans of one experiment with a goal payoff of 10, w1 ascending.
    pub fn of(&self, experiment: Experiment) -> impl Iterator<Item = &Case> {
        claims::of(&self.cases, experiment)
    }

    /// The plan with the goal payoff of 50 (fig. 10).
    ///
    /// # Panics
    /// Never: [`Findings::new`] computes it.
    #[must_use]
    pub fn raised(&self) -> &Case {
        claims::raised(&self.cases)
    }

    /// Number of claims that hold, and of claims, not counting those that hold by construction.
    #[must_use]
    pub fn score(&self) -> (usize, usize) {
        let judged = self.claims.iter().filter(|claim| !claim.by_construction);
        (judged.clone().filter(|claim| claim.holds).count(), judged.count())
    }
}
