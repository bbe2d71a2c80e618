//! A policy carried out: seeded journeys with every slip drawn.

use contract::{Branch, Decision, RobotId};
use motion::{Domain, Draw};
use serde::Serialize;

use crate::model::BRANCHES;
use crate::{KnownError, Model, Solution, World};

/// Most trials of one execution.
pub const TRIALS_MAX: u64 = 10_000_000;
/// Hops after which a journey has failed: ten times the map's two sides.
pub const HOPS_MAX: u64 = 400;

/// What became of the journeys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Execution {
    /// Journeys begun.
    pub trials: u64,
    /// Journeys that got to the goal within [`HOPS_MAX`] hops.
    pub successes: u64,
    /// Journeys that left the map.
    pub lost: u64,
    /// Hops of the successes, together.
    pub hops: u64,
}

impl Execution {
    /// Share of journeys that succeeded.
    #[must_use]
    pub fn success(&self) -> f64 {
        self.successes as f64 / self.trials as f64
    }

    /// Mean hops of a success; `None` without one.
    #[must_use]
    pub fn mean_hops(&self) -> Option<f64> {
        (self.successes > 0).then(|| self.hops as f64 / self.successes as f64)
    }
}

/// Carries the policy out `trials` times. Hop k of trial n is drawn as decision k of seed + n, the way
/// every mission's is ([`motion::draw`]), so it depends on nothing else.
///
/// # Errors
/// [`KnownError::Trials`] if there are none, or more than [`TRIALS_MAX`].
pub fn execute(
    world: &World,
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
        match journey(world, model, solution, seed.wrapping_add(trial)) {
            Journey::Arrived { hops } => {
                execution.successes += 1;
                execution.hops += hops;
            }
            Journey::Lost => execution.lost += 1,
            Journey::Underway => {}
        }
    }
    Ok(execution)
}

enum Journey {
    Arrived { hops: u64 },
    Lost,
    Underway,
}

fn journey(world: &World, model: &Model, solution: &Solution, seed: u64) -> Journey {
    let index = |cell| world.grid.index(cell).expect("start and goal on the map");
    let (mut at, goal) = (index(world.start), index(world.goal));
    for hops in 0..HOPS_MAX {
        if at == goal {
            return Journey::Arrived { hops };
        }
        let Some(choice) = solution.policy[at] else { return Journey::Underway };
        let uniform = Draw::new(seed, Domain::Motion, RobotId(0), Decision(hops)).uniform();
        let branch: Branch = model.choices[choice].scatter.branch(uniform);
        let landing = BRANCHES.iter().position(|&one| one == branch).expect("a branch of a hop");
        at = model.landings[choice][landing].index;
        if at == model.cells() {
            return Journey::Lost;
        }
    }
    if at == goal { Journey::Arrived { hops: HOPS_MAX } } else { Journey::Underway }
}
