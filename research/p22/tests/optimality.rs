//! Value iteration against brute force: on small worlds no policy whatsoever is better.

use contract::{Cell, Grid, Ground, Soil};
use p22::{Edge, Experiment, GoalPayoff, HalfHops, KnownMap, Model, P22, PayoffCell, Plan, Reading, Weights};
use proptest::prelude::*;

/// A world of 3 × 2 cells from one corner to the other.
fn small(heights_m: [f64; 6], sand: [bool; 6], stepped: bool) -> KnownMap {
    let grid = Grid::new(3, 2, 1.0, 1).unwrap();
    let ground = (0..6).map(|n| Ground {
        height_m: heights_m[n],
        gradient: if stepped { [0.0; 2] } else { [heights_m[n], heights_m[5 - n] - 0.2] },
        soil: if sand[n] { Soil::Sand } else { Soil::Hard },
        passable: true,
        ..Ground::FLAT
    });
    let template = KnownMap::new(if stepped { Experiment::Rocks } else { Experiment::Heterogeneous }, &P22);
    KnownMap {
        grid,
        ground: ground.collect(),
        start: Cell::new(0, 0),
        goal: Cell::new(2, 1),
        stepped,
        ..template
    }
}

/// The values of the policy that takes `choices[cell]`, by Gaussian elimination of V = γ (r + P V).
fn values(model: &Model, payoffs: &[f64], goal_value: f64, choices: &[Option<usize>]) -> Vec<f64> {
    let count = model.cells();
    let mut rows: Vec<Vec<f64>> = (0..count)
        .map(|cell| {
            let mut row = vec![0.0; count + 1];
            row[cell] = 1.0;
            match choices[cell] {
                None if model.pinned_goal == Some(cell) => row[count] = goal_value,
                // A cell where nothing is offered keeps the value it began with.
                None => row[count] = payoffs.iter().copied().fold(0.0, f64::min),
                Some(choice) => {
                    row[count] = model.discount * payoffs[choice];
                    for landing in model.landings[choice].iter().filter(|landing| landing.index < count) {
                        row[landing.index] -= model.discount * landing.factor;
                    }
                }
            }
            row
        })
        .collect();
    for pivot in 0..count {
        let best =
            (pivot..count).max_by(|&a, &b| rows[a][pivot].abs().total_cmp(&rows[b][pivot].abs())).unwrap();
        rows.swap(pivot, best);
        let lead = rows[pivot].clone();
        for (_, row) in rows.iter_mut().enumerate().filter(|(other, _)| *other != pivot) {
            let factor = row[pivot] / lead[pivot];
            row.iter_mut().zip(&lead).for_each(|(value, lead)| *value -= factor * lead);
        }
    }
    (0..count).map(|cell| rows[cell][count] / rows[cell][cell]).collect()
}

/// Every policy there is.
fn policies(model: &Model) -> Vec<Vec<Option<usize>>> {
    let mut all = vec![Vec::new()];
    for cell in 0..model.cells() {
        let choices: Vec<Option<usize>> = match model.choices_of(cell).map(Some).collect::<Vec<_>>() {
            none if none.is_empty() => vec![None],
            some => some,
        };
        all = all
            .into_iter()
            .flat_map(|policy: Vec<Option<usize>>| {
                choices.iter().map(move |&choice| [policy.clone(), vec![choice]].concat()).collect::<Vec<_>>()
            })
            .collect();
    }
    all
}

/// P-KNOWN-OPTIMAL: On small worlds no policy is better than the planned one.
#[test]
fn no_policy_of_all_is_better_anywhere_than_the_one_found() {
    let worlds = [
        small([0.0, 0.3, 0.1, -0.2, 0.2, 0.05], [false, true, false, true, false, false], false),
        small([0.0, 0.25, 0.0, 0.0, 1.0, 0.0], [false; 6], true),
    ];
    let readings = [
        P22,
        Reading { goal_payoff: GoalPayoff::Once, edge: Edge::Stays, payoff_at: PayoffCell::Arrival, ..P22 },
        Reading {
            goal_payoff: GoalPayoff::ForEver,
            edge: Edge::Dropped,
            half_hops: HalfHops::OnePeriod,
            ..P22
        },
    ];
    let mut judged = 0;
    for (world, reading) in worlds.iter().flat_map(|world| readings.map(|reading| (world, reading))) {
        let reading = Reading { tolerance: 1e-12, discount: 0.9, ..reading };
        let model = Model::new(world, &reading);
        let weights = Weights::new(0.6, 10.0).unwrap();
        let (payoffs, goal_value) = (model.payoffs(&weights), model.goal_value(&weights));
        let plan = Plan::new(world, &model, &reading, weights);
        assert!(plan.solution.settled);
        let own = values(&model, &payoffs, goal_value, &plan.solution.policy);
        for (got, need) in plan.solution.values.iter().zip(&own) {
            assert!((got - need).abs() < 1e-9, "the values are those of the policy: {got} {need}");
        }
        for policy in policies(&model) {
            judged += 1;
            for (cell, value) in values(&model, &payoffs, goal_value, &policy).into_iter().enumerate() {
                assert!(value <= own[cell] + 1e-9, "{policy:?} is better at {cell}: {value} {}", own[cell]);
            }
        }
    }
    assert!(judged > 5_000, "{judged} policies");
}

#[test]
fn sweeps_that_keep_their_choices_lead_to_the_same_values() {
    // A tolerance above the fixed point's makes every sweep choose; a small one lets twelve keep.
    for experiment in Experiment::ALL {
        let weights = Weights::new(0.4, 10.0).unwrap();
        let [loose, tight] =
            [2e-6, 1e-9].map(|tolerance| Plan::of(experiment, &Reading { tolerance, ..P22 }, weights));
        let bound = 2e-6 / (1.0 - P22.discount);
        for (loose, tight) in loose.solution.values.iter().zip(&tight.solution.values) {
            assert!((loose - tight).abs() <= bound, "{experiment}: {loose} {tight}");
        }
        assert!(tight.solution.sweeps < loose.solution.sweeps);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    /// P-KNOWN-OPTIMAL.
    #[test]
    fn the_values_are_those_of_a_linear_solve_of_the_policy(
        heights_m in prop::array::uniform6(-0.4..0.4f64),
        sand in prop::array::uniform6(any::<bool>()),
        stepped: bool,
        safety in 0.0..1.0f64,
    ) {
        let world = small(heights_m, sand, stepped);
        let reading = Reading { tolerance: 1e-12, ..P22 };
        let model = Model::new(&world, &reading);
        let weights = Weights::new(safety, 10.0).unwrap();
        let plan = Plan::new(&world, &model, &reading, weights);
        let need = values(&model, &model.payoffs(&weights), model.goal_value(&weights), &plan.solution.policy);
        for (got, need) in plan.solution.values.iter().zip(need) {
            prop_assert!((got - need).abs() < 1e-8, "need {need}, got {got}");
        }
    }
}
