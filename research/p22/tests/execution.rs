//! Policies carried out, against the exact probabilities.

use p22::execution::{HOPS_MAX, execute};
use p22::{Experiment, KnownError, KnownMap, Model, P22, Plan, Weights};

/// Probability of being at the goal within [`HOPS_MAX`] hops, by pushing the distribution forward.
fn exact(world: &KnownMap, model: &Model, plan: &Plan) -> f64 {
    let (start, goal) = (world.grid.index(world.start).unwrap(), world.grid.index(world.goal).unwrap());
    let mut at = vec![0.0; model.cells() + 1];
    at[start] = 1.0;
    for _ in 0..HOPS_MAX {
        let mut next = vec![0.0; model.cells() + 1];
        for cell in 0..model.cells() {
            match plan.solution.policy[cell] {
                Some(choice) if cell != goal => {
                    let scatter = model.choices[choice].scatter;
                    let chances = [scatter.intended, scatter.stayed, scatter.left, scatter.right];
                    for (landing, chance) in model.landings[choice].iter().zip(chances) {
                        next[landing.index] += chance * at[cell];
                    }
                }
                _ => next[cell] += at[cell],
            }
        }
        next[model.cells()] += at[model.cells()];
        at = next;
    }
    at[goal]
}

/// P-KNOWN-EXECUTION: A policy that is carried out arrives with its exact probability, and journeys
/// depend on their seed alone.
#[test]
fn the_success_of_journeys_is_the_exact_probability_within_sampling_noise() {
    let trials = 4_000;
    for (experiment, safety) in [
        (Experiment::Hard, 0.3),
        (Experiment::Heterogeneous, 0.9),
        (Experiment::Sandy, 0.0),
        (Experiment::Sandy, 0.8),
        (Experiment::Rocks, 0.5),
    ] {
        let world = KnownMap::new(experiment, &P22);
        let model = Model::new(&world, &P22);
        let plan = Plan::new(&world, &model, &P22, Weights::new(safety, 10.0).unwrap());
        let need = exact(&world, &model, &plan);
        let got = execute(&world, &model, &plan.solution, 5, trials).unwrap();
        let error = (need * (1.0 - need) / trials as f64).sqrt();
        assert!((got.success() - need).abs() < 4.5 * error, "{experiment}: need {need}, got {got:?}");
        assert!(got.successes + got.lost <= trials);
    }
}

/// P-KNOWN-EXECUTION.
#[test]
fn journeys_depend_on_their_seed_alone() {
    let world = KnownMap::new(Experiment::Rocks, &P22);
    let model = Model::new(&world, &P22);
    let plan = Plan::new(&world, &model, &P22, Weights::new(0.5, 10.0).unwrap());
    let run = |seed, trials| execute(&world, &model, &plan.solution, seed, trials).unwrap();
    assert_eq!(run(9, 300), run(9, 300));
    assert_ne!(run(9, 300), run(10_009, 300));
    let (first, second, both) = (run(9, 100), run(109, 200), run(9, 300));
    assert_eq!(first.successes + second.successes, both.successes, "trial n has seed + n");
    assert_eq!(first.hops + second.hops, both.hops);
}

#[test]
fn no_trials_or_too_many_are_refused() {
    let world = KnownMap::new(Experiment::Rocks, &P22);
    let model = Model::new(&world, &P22);
    let plan = Plan::new(&world, &model, &P22, Weights::new(0.5, 10.0).unwrap());
    for trials in [0, 10_000_001] {
        let got = execute(&world, &model, &plan.solution, 1, trials).unwrap_err();
        assert_eq!(got, KnownError::Trials { max: 10_000_000, got: trials });
    }
}
