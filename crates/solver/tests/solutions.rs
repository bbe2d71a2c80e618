//! Solutions and their certificates, against exact ones.

mod worlds;

use nalgebra::{DMatrix, DVector};
use solver::fixtures::{Fixture, HARD, SAND, SplitMix64};
use solver::{
    Effort, GoalSearch, GridWorld, Hop, Kind, Leaving, Rules, Site, Soil, SolveStatus, Solver, action_values,
    certificate, certify, policy,
};
use worlds::{hills, inside, random};

/// What the dense solve itself may be off by, relative to the largest value.
const DENSE: f64 = 1e-10;

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(1.0, |max, value| value.abs().max(max))
}

fn error(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// P-CERTIFIED: Values lie within the error bound they carry, in trap worlds and in solves cut
/// short too.
#[test]
fn values_lie_within_their_bound_of_the_linear_solve_on_hundreds_of_worlds() {
    let mut solver = Solver::new();
    for seed in 0..400 {
        for world in [random(seed), hills(seed)] {
            let solution = solver.solve(&world, &Effort::default());
            let bound = solution.certificate.error_bound;
            assert!(solution.status.is_converged(), "seed {seed}");
            assert_eq!(solution.status == SolveStatus::Solved, bound <= 1e-6, "seed {seed}");
            // Where values are large, floating point is the limit.
            let limit =
                4.0 * certificate::rounding(2.0 * world.afterstate_max()) / (1.0 - world.rules().discount);
            assert!(bound <= limit.max(1e-6), "seed {seed}: bound {bound}");
            let exact = exact(&world);
            let error = error(solver.values(), &exact);
            assert!(error <= bound + DENSE * largest(&exact), "seed {seed}: error {error}, bound {bound}");
        }
    }
}

/// P-CERTIFIED.
#[test]
fn a_cut_solve_is_valid_and_says_how_far_off_it_is() {
    let mut solver = Solver::new();
    for seed in 0..60 {
        for world in [random(seed), hills(seed)] {
            let exact = exact(&world);
            for sweeps_max in [0, 1, 7, 20, 40] {
                let solution = solver.solve(&world, &Effort { sweeps_max, ..Effort::default() });
                assert!(solution.sweeps <= sweeps_max, "seed {seed}: {solution:?}");
                let bound = solution.certificate.error_bound;
                assert!(error(solver.values(), &exact) <= bound + DENSE * largest(&exact), "seed {seed}");
                assert_eq!(solution.status == SolveStatus::Solved, bound <= 1e-6, "seed {seed}");
                for node in 0..world.nodes() {
                    let hop = policy::hop(&world, solver.values(), node, 1e-6);
                    assert_eq!(hop.is_some(), world.kind(node) == Kind::Free);
                }
            }
        }
    }
}

#[test]
fn a_tighter_error_is_reached_where_it_is_asked_for() {
    let mut solver = Solver::new();
    for seed in 0..40 {
        let world = hills(seed);
        let solution = solver.solve(&world, &Effort { error_max: 1e-8, ..Effort::default() });
        assert_eq!(solution.status, SolveStatus::Solved);
        assert!(solution.certificate.error_bound <= 1e-8, "seed {seed}: {solution:?}");
    }
}

#[test]
fn the_certificate_is_what_a_plain_sweep_from_the_definition_measures() {
    let mut solver = Solver::new();
    for seed in 0..200 {
        for world in [random(seed), hills(seed)] {
            for sweeps_max in [1, u64::MAX] {
                let solution = solver.solve(&world, &Effort { sweeps_max, ..Effort::default() });
                assert_eq!(solution.certificate, certify(&world, solver.values()), "seed {seed}");
            }
        }
    }
}

#[test]
fn perturbed_values_are_refused() {
    let mut solver = Solver::new();
    let world = Fixture::plain(20, 3).world().unwrap();
    assert!(
        certify(&world, {
            solver.solve(&world, &Effort::default());
            solver.values()
        })
        .error_bound
            <= 1e-6
    );
    for (seed, perturbation) in [(1, 1e-5), (2, -1e-5), (3, 1.0), (4, f64::NAN), (5, f64::INFINITY)] {
        let mut values = solver.values().to_vec();
        let node = (SplitMix64(seed).uniform() * values.len() as f64) as usize;
        values[node] += perturbation;
        let bound = certify(&world, &values).error_bound;
        assert!(bound.is_nan() || bound > 1e-6, "{perturbation} at {node} passed with {bound}");
        assert!(perturbation.abs() <= bound || perturbation.is_nan());
    }
}

#[test]
fn a_goal_well_inside_is_solved_for_from_all_sides() {
    let mut solver = Solver::new();
    for seed in 0..60 {
        let world = inside(seed);
        for sweeps_max in [0, 1, 7, 25, 60, u64::MAX] {
            let solution = solver.solve(&world, &Effort { sweeps_max, ..Effort::default() });
            assert_eq!(solution.certificate, certify(&world, solver.values()), "seed {seed}");
            assert!(solution.sweeps <= sweeps_max, "seed {seed}: {solution:?}");
            assert_eq!(solution.status == SolveStatus::Solved, solution.certificate.error_bound <= 1e-6);
            assert!(
                sweeps_max < u64::MAX || solution.status == SolveStatus::Solved,
                "seed {seed}: {solution:?}"
            );
        }
        if seed < 2 {
            let exact = exact(&world);
            let bound = solver.solve(&world, &Effort::default()).certificate.error_bound;
            assert!(error(solver.values(), &exact) <= bound + DENSE * largest(&exact), "seed {seed}");
        }
    }
}

#[test]
fn a_large_trap_world_is_certified() {
    let world = Fixture::trap(120, 5).world().unwrap();
    let mut solver = Solver::new();
    let solution = solver.solve(&world, &Effort::default());
    assert_eq!(solution.status, SolveStatus::Solved);
    assert!(certify(&world, solver.values()).error_bound <= 1e-6);
    // A trap it is: lingering pays more than the goal.
    let start = Fixture::trap(120, 5).start();
    assert!(solver.values()[start] > 100.0);
}

#[test]
fn payoffs_beyond_single_precision_are_solved_to_the_limit_of_double_precision() {
    let soils = vec![HARD];
    let rules = Rules { discount: 0.9, loss: -1e40, leaving: Leaving::Loses, soils };
    let mut world = GridWorld::new(4, 3, rules).unwrap();
    world.set(5, Site { kind: Kind::Goal, payoff: 1e38, slope_east: 0.0, slope_north: 0.0, soil: 0 });
    let mut solver = Solver::new();
    let solution = solver.solve(&world, &Effort::default());
    assert_eq!(solution.status, SolveStatus::AtLimit);
    let exact = exact(&world);
    assert!(error(solver.values(), &exact) <= 1e-9 * largest(&exact));
}

/// P-SOLVED-HONEST: A solve is called solved only if its bound is finite and within the requested
/// error: never if that error is negative, NaN, or below what floating point can certify.
#[test]
fn solved_means_that_the_bound_is_within_the_error_asked_for() {
    let world = |discount: f64, payoff: f64| {
        let rules = Rules { discount, loss: -1.0, leaving: Leaving::Stays, soils: vec![HARD] };
        let mut world = GridWorld::new(12, 12, rules).expect("a world in range");
        let site = |kind, payoff| Site { kind, payoff, slope_east: 0.0, slope_north: 0.0, soil: 0 };
        world.set(143, site(Kind::Goal, 100.0));
        world.set(65, site(Kind::Free, payoff));
        world
    };
    let almost_one = 1.0 - 1e-15;
    // Whether an error can be certified, or is none.
    let cases = [
        (0.99, 0.0, 1e-6, SolveStatus::Solved),
        (0.99, 0.0, f64::INFINITY, SolveStatus::Solved),
        (0.99, 0.0, 0.0, SolveStatus::AtLimit),
        (0.99, 0.0, -1.0, SolveStatus::AtLimit),
        (0.99, 0.0, f64::NEG_INFINITY, SolveStatus::AtLimit),
        (0.99, 0.0, f64::NAN, SolveStatus::AtLimit),
        (0.99, 1e20, 1e-6, SolveStatus::AtLimit),
        (0.99, 1e300, 1e-6, SolveStatus::AtLimit),
        (0.99, 1e308, 1e-6, SolveStatus::AtLimit),
        (0.99, -1e308, 1e-6, SolveStatus::AtLimit),
        (0.99, 1e308, f64::INFINITY, SolveStatus::AtLimit),
        (almost_one, 0.0, 1e-6, SolveStatus::AtLimit),
        (almost_one, -1.0, 1e-6, SolveStatus::AtLimit),
    ];
    for (discount, payoff, error_max, need) in cases {
        let world = world(discount, payoff);
        let mut solver = Solver::new();
        let solution = solver.solve(&world, &Effort { error_max, ..Effort::default() });
        let bound = solution.certificate.error_bound;
        assert_eq!(solution.status, need, "{discount} {payoff} {error_max}: {bound}");
        assert_eq!(need == SolveStatus::Solved, bound.is_finite() && bound <= error_max, "{bound}");
        assert!(!bound.is_nan() && certify(&world, solver.values()).error_bound == bound);
    }
}

#[test]
fn a_walled_in_goal_is_told_from_one_that_can_be_reached() {
    let soils = vec![HARD];
    let mut world =
        GridWorld::new(5, 5, Rules { discount: 0.99, loss: -300.0, leaving: Leaving::Stays, soils }).unwrap();
    let site = |kind| Site { kind, payoff: 0.0, slope_east: 0.0, slope_north: 0.0, soil: 0 };
    world.set(24, site(Kind::Goal));
    world.set(19, site(Kind::Lost));
    let mut reach = GoalSearch::default();
    assert!(reach.leads_to_goal(&world, 0));
    world.set(23, site(Kind::Lost));
    assert!(!reach.leads_to_goal(&world, 0));
    assert!(reach.leads_to_goal(&world, 24));
    let solution = Solver::new().solve(&world, &Effort::default());
    assert_eq!(solution.status, SolveStatus::Solved, "values exist all the same");
}

#[test]
fn a_slope_at_the_limit_lets_no_hop_away_uphill_so_a_goal_above_it_cannot_be_reached_that_way() {
    let hop_only = Soil { intended: 1.0, stuck: 0.0, sideways: 0.0, wait: 0.0 };
    let rules = Rules { discount: 0.99, loss: -300.0, leaving: Leaving::Stays, soils: vec![hop_only] };
    let mut world = GridWorld::new(2, 1, rules).unwrap();
    world.set(1, Site { kind: Kind::Goal, payoff: 100.0, slope_east: 0.0, slope_north: 0.0, soil: 0 });
    assert!(GoalSearch::default().leads_to_goal(&world, 0));
    world.set(0, Site { kind: Kind::Free, payoff: 0.0, slope_east: 3.0, slope_north: 0.0, soil: 0 });
    assert!(!GoalSearch::default().leads_to_goal(&world, 0));
}

#[test]
fn a_mixture_of_soils_is_worth_the_mean_of_its_parts() {
    let share = 0.3;
    let mixture = Soil::mixture(&[(share, SAND), (1.0 - share, HARD)], 0.99);
    let rules =
        Rules { discount: 0.99, loss: -500.0, leaving: Leaving::Loses, soils: vec![HARD, SAND, mixture] };
    let mut draw = SplitMix64(9);
    for _ in 0..100 {
        let mut world = GridWorld::new(3, 3, rules.clone()).unwrap();
        let values: Vec<f64> = (0..9).map(|_| draw.between(-100.0, 100.0)).collect();
        let site = Site {
            kind: Kind::Free,
            payoff: draw.between(-10.0, 10.0),
            slope_east: draw.between(-1.0, 1.0),
            slope_north: draw.between(-1.0, 1.0),
            soil: 0,
        };
        let [hard, sand, mixed] = [0, 1, 2].map(|soil| {
            world.set(4, Site { soil, ..site });
            action_values(&world, &values, 4)
        });
        for hop in Hop::ALL.map(|hop| hop as usize) {
            let mean = share * sand[hop] + (1.0 - share) * hard[hop];
            assert!((mixed[hop] - mean).abs() < 1e-10, "{mixed:?} {mean}");
        }
    }
}

/// V* by policy iteration, each policy evaluated by a dense linear solve.
fn exact(world: &GridWorld) -> Vec<f64> {
    let mut policy = vec![Hop::North; world.nodes()];
    for _ in 0..200 {
        let values = evaluate(world, &policy);
        let mut changed = false;
        for node in (0..world.nodes()).filter(|&node| world.kind(node) == Kind::Free) {
            let hop_values = action_values(world, &values, node);
            let best = Hop::ALL
                .into_iter()
                .max_by(|&a, &b| hop_values[a as usize].total_cmp(&hop_values[b as usize]));
            let best = best.expect("four hops");
            if hop_values[best as usize] > hop_values[policy[node] as usize] + 1e-10 {
                policy[node] = best;
                changed = true;
            }
        }
        if !changed {
            return values;
        }
    }
    panic!("policy iteration ends");
}

fn evaluate(world: &GridWorld, policy: &[Hop]) -> Vec<f64> {
    let (nodes, rules) = (world.nodes(), world.rules());
    let mut matrix = DMatrix::<f64>::identity(nodes, nodes);
    let mut side = DVector::zeros(nodes);
    for node in 0..nodes {
        if world.kind(node) != Kind::Free {
            side[node] = if world.kind(node) == Kind::Lost { rules.loss } else { 0.0 };
            continue;
        }
        let (hop, wait) = (policy[node], world.soil(node).wait);
        let scatter = world.scatter(node, hop);
        let landing = rules.discount * (1.0 - wait + wait * rules.discount);
        side[node] = rules.discount * wait * world.payoff(node);
        let landings = [
            (Some(node), scatter.stayed),
            (world.neighbour(node, hop), scatter.intended),
            (world.neighbour(node, hop.left()), scatter.left),
            (world.neighbour(node, hop.right()), scatter.right),
        ];
        for (to, probability) in landings {
            let to = to.or((rules.leaving == Leaving::Stays).then_some(node));
            match to.map(|to| (to, world.kind(to))) {
                Some((to, Kind::Free)) => {
                    side[node] += landing * probability * world.payoff(to);
                    matrix[(node, to)] -= landing * probability;
                }
                Some((to, Kind::Goal)) => side[node] += landing * probability * world.payoff(to),
                Some((_, Kind::Lost)) | None => side[node] += landing * probability * rules.loss,
            }
        }
    }
    matrix.lu().solve(&side).expect("a discounted process has one solution").as_slice().to_vec()
}

/// P-ENDS. Where hops mostly slip, over-relaxed sweeps have gone round in circles.
#[test]
fn every_solve_ends_where_hops_mostly_slip() {
    let slips = Soil { intended: 0.18, stuck: 0.12, sideways: 0.35, wait: 0.0 };
    let only = Soil { intended: 0.0, stuck: 0.0, sideways: 0.5, wait: 0.1 };
    let stuck = Soil { intended: 0.0, stuck: 1.0, sideways: 0.0, wait: 0.3 };
    // In the last ten they did.
    let circles = [13_985, 78_723, 105_267, 133_370, 190_758, 209_154, 236_423, 243_842, 256_007, 281_103];
    for seed in (0..1_000).chain(circles) {
        let mut draw = SplitMix64(seed);
        let side = 2 + (18.0 * draw.uniform()) as usize;
        let leaving = if seed % 2 == 0 { Leaving::Loses } else { Leaving::Stays };
        let discount = [0.9, 0.99][(seed / 2 % 2) as usize];
        let rules = Rules { discount, loss: 0.0, leaving, soils: vec![slips, only, stuck] };
        let mut world = GridWorld::new(side, side, rules).expect("a world in range");
        for node in 0..world.nodes() {
            let slope = |draw: &mut SplitMix64| {
                [-1.0, 1.0, 0.0, draw.between(-1.0, 1.0)][(4.0 * draw.uniform()) as usize]
            };
            let (slope_east, slope_north) = (slope(&mut draw), slope(&mut draw));
            let soil = (3.0 * draw.uniform()) as u8;
            let kind = if draw.uniform() < 0.05 { Kind::Lost } else { Kind::Free };
            world.set(node, Site { kind, payoff: draw.between(-1.0, 1.0), slope_east, slope_north, soil });
        }
        let goal = (draw.uniform() * world.nodes() as f64) as usize;
        world.set(goal, Site { kind: Kind::Goal, payoff: 5.0, ..world.site(goal) });
        let effort = Effort { error_max: 1e-7, sweeps_max: 50_000 };
        let solution = Solver::new().solve(&world, &effort);
        assert_eq!(solution.status, SolveStatus::Solved, "seed {seed}, {solution:?}");
    }
}
