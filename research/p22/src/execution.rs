//! Executes a policy: seeded trials in which every slip is drawn.

use contract::{Branch, Decision, RobotId};
use motion::{Domain, Draw};
use serde::Serialize;

use crate::model::BRANCHES;
use crate::{KnownError, KnownMap, Model, Solution};

/// Most trials of one execution.
pub const TRIALS_MAX: u64 = 10_000_000;
/// Hops after which a trial has failed: ten times the sum of the map's sides.
pub const HOPS_MAX: u64 = 400;

/// Outcomes of the trials.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Execution {
    /// Executions that were drawn, at most [`TRIALS_MAX`].
    pub trials: u64,
    /// Number of trials that reached the goal within [`HOPS_MAX`] hops.
    pub successes: u64,
    /// Number of trials that left the map.
    pub lost: u64,
    /// Hops of all successful trials together.
    pub hops: u64,
}

impl Execution {
    /// Share of successful trials, 0 to 1.
    #[must_use]
    pub fn success(&self) -> f64 {
        self.successes as f64 / self.trials as f64
    }

    /// Mean hops of the successful trials; `None` without any.
    #[must_use]
    pub fn mean_hops(&self) -> Option<f64> {
        (self.successes > 0).then(|| self.hops as f64 / self.successes as f64)
    }
}

/// Executes the policy `trials` times. Hop k of trial n is drawn like decision k of a mission with seed + n
/// ([`motion::draw`]), so it depends on nothing else.
///
/// # Errors
/// [`KnownError::Trials`] if `trials` is 0 or above [`TRIALS_MAX`].
pub fn execute(
    map: &KnownMap,
    model: &Model,
    solution: &Solution,
    seed: u64,
    trials: u64,
) -> Result<Execution, KnownError> {
    if !(1..=TRIALS_MAX).contains(&trials) {
        return Err(KnownError::Trials { max: TRIALS_MAX, got: trials });
    }
    let mut execution = Execution { trials, ..Execution::default() };
    for trial in 0..trials {
        match run_trial(map, model, solution, seed.wrapping_add(trial)) {
            TrialEnd::Arrived { hops } => {
                execution.successes += 1;
                execution.hops += hops;
            }
            TrialEnd::Lost => execution.lost += 1,
            TrialEnd::Underway => {}
        }
    }
    Ok(execution)
}

enum TrialEnd {
    Arrived { hops: u64 },
    Lost,
    Underway,
}

fn run_trial(map: &KnownMap, model: &Model, solution: &Solution, seed: u64) -> TrialEnd {
    let index = |cell| map.grid.index(cell).expect("start and goal on the map");
    let (mut at, goal) = (index(map.start), index(map.goal));
    for hops in 0..HOPS_MAX {
        if at == goal {
            return TrialEnd::Arrived { hops };
        }
        let Some(choice) = solution.policy[at] else { return TrialEnd::Underway };
        let uniform = Draw::new(seed, Domain::Motion, RobotId(0), Decision(hops)).uniform();
        let branch: Branch = model.choices[choice].scatter.branch(uniform);
        let landing = BRANCHES.iter().position(|&one| one == branch).expect("a branch of a hop");
        at = model.landings[choice][landing].index;
        if at == model.cells() {
            return TrialEnd::Lost;
        }
    }
    if at == goal { TrialEnd::Arrived { hops: HOPS_MAX } } else { TrialEnd::Underway }
}
