//! The planner's values against an independent dense linear solve, and its own account of itself.

use contract::{Action, Branch, Cell, Decision, Direction, ObservedMap, PolicyCell, Profile, RobotId, Soil};
use motion::{Domain, Draw, landing, transition};
use nalgebra::{DMatrix, DVector};
use planner::belief::Belief;
use planner::mdp::Mdp;
use planner::mdp::model::Model;
use planner::payoff::LandingPayoff;
use planner::{Budget, Plan, PlanStatus, Planner};

use crate::world::{PROFILES, Soils, World};

/// Bellman's right-hand side at `cell` for one hop, written anew: constant and coefficients of V.
fn backup(
    world: &World,
    map: &ObservedMap,
    loss: f64,
    cell: Cell,
    direction: Direction,
) -> (f64, Vec<(usize, f64)>) {
    let leg = &world.leg;
    let (payoff, belief) = (LandingPayoff::new(leg), Belief::new(leg, map));
    let gamma = leg.payoff.discount;
    let sand = belief.ground(cell).soil == Soil::Sand;
    let factor = if sand { gamma * gamma } else { gamma };
    let mut constant = if sand { gamma * payoff.of(cell, belief.ground(cell)) } else { 0.0 };
    let mut coefficients = Vec::new();
    let scatter = transition(&leg.motion, belief.ground(cell), direction);
    for branch in [Branch::Intended, Branch::Stayed, Branch::Left, Branch::Right] {
        let p = factor * scatter.probability(branch);
        let mut to = landing(&leg.grid, cell, direction, branch);
        if !leg.grid.contains(to) && leg.profile == Profile::Paper2023 {
            to = cell;
        }
        match leg.grid.index(to) {
            Some(_) if to == leg.goal => constant += p * leg.payoff.goal,
            Some(index) if belief.ground(to).passable => {
                constant += p * payoff.of(to, belief.ground(to));
                coefficients.push((index, p));
            }
            _ => constant += p * loss,
        }
    }
    (constant, coefficients)
}

/// Solves V = c + P V for the policy with LU, and holds the planner's values to it.
fn check(world: &World, map: &ObservedMap) -> Option<Plan> {
    let state = world.state(world.leg.start, Decision(0), 0);
    let situation = world.situation(map, &state);
    let mut planner = Mdp::default();
    let plan = planner.plan(&situation, &Budget::default());
    let Some(policy) = planner.policy() else {
        assert!(plan.status == PlanStatus::Infeasible || world.leg.start == world.leg.goal);
        assert_eq!(plan.action, Action::Hold);
        return None;
    };
    assert_eq!(plan.status, PlanStatus::Solved);
    assert!(plan.error_bound <= 1e-6, "within {}", plan.error_bound);
    let grid = world.leg.grid;
    assert_eq!(plan.action, policy[grid.index(world.leg.start).unwrap()].action);

    let loss = Model::new(&situation).world.rules().loss;
    let mut matrix = DMatrix::identity(grid.cells(), grid.cells());
    let mut right = DVector::zeros(grid.cells());
    for (index, PolicyCell { action, value }) in policy.iter().enumerate() {
        let Action::Hop(direction) = action else {
            right[index] = *value;
            continue;
        };
        let (constant, coefficients) = backup(world, map, loss, grid.cell(index), *direction);
        right[index] = constant;
        coefficients.into_iter().for_each(|(to, p)| matrix[(index, to)] -= p);
    }
    let solved = matrix.lu().solve(&right).expect("a discounted process has one solution");
    for (index, PolicyCell { action, value }) in policy.iter().enumerate() {
        let scale = solved[index].abs().max(1.0);
        assert!((solved[index] - value).abs() <= 1e-6 * scale, "{index}: {} or {value}", solved[index]);
        if *action == Action::Hold {
            continue;
        }
        // Optimal: no hop is better than the policy's by more than the certified error.
        let best = Direction::ALL.map(|direction| {
            let (constant, coefficients) = backup(world, map, loss, grid.cell(index), direction);
            constant + coefficients.iter().map(|&(to, p)| p * solved[to]).sum::<f64>()
        });
        let best = best.into_iter().fold(f64::NEG_INFINITY, f64::max);
        assert!(best - solved[index] <= 2e-6 * scale, "{index}: {best} beats {}", solved[index]);
    }
    Some(plan)
}

/// A map on which a share of the cells, drawn from `seed`, has been seen.
fn partly_seen(world: &World, seed: u64, share: f64) -> ObservedMap {
    let drawn = |index| Draw::new(seed, Domain::Motion, RobotId(8), Decision(index as u64)).uniform();
    world.seen_where(|index| drawn(index) < share)
}

/// P-SOLVED: The values equal those of an independent linear solve of the final policy.
#[test]
fn value_iteration_agrees_with_the_linear_solve() {
    let mut solved = 0;
    for seed in 0..120 {
        for profile in PROFILES {
            let world = World::random(seed, profile);
            let map = partly_seen(&world, seed, [0.0, 0.3, 0.7, 1.0][seed as usize % 4]);
            solved += usize::from(check(&world, &map).is_some());
        }
    }
    assert!(solved > 180, "only {solved} of 240 worlds have a way to the goal");
}

#[test]
fn value_iteration_agrees_with_the_linear_solve_on_the_worlds_of_the_paper() {
    for soils in [Soils::Hard, Soils::Heterogeneous, Soils::Sandy] {
        for profile in PROFILES {
            let world = World::paper(soils, [0.5, 0.5], profile);
            let map = partly_seen(&world, 1, 0.5);
            assert!(check(&world, &map).is_some());
        }
    }
}

#[test]
fn ground_without_slips_is_planned_on_in_a_session_and_from_nothing() {
    // 1 - 0.9 - 0.1 is just below 0 in floating point, and 1 - 0.7 - 0.3 just above.
    let shares =
        (0..=10_u32).map(|tenths| [f64::from(10 - tenths), f64::from(tenths)].map(|share| share / 10.0));
    let negative = |[intended, stuck]: &[f64; 2]| 1.0 - intended - stuck < 0.0;
    assert!(shares.clone().any(|share| negative(&share)), "the case in point is among them");
    for [intended, stuck] in shares.filter(|[intended, _]| *intended > 0.0) {
        for soils in [Soils::Hard, Soils::Sandy] {
            for profile in PROFILES {
                let mut world = World::paper(soils, [0.5, 0.5], profile);
                for motion in [&mut world.leg.motion.hard, &mut world.leg.motion.sand] {
                    (motion.intended, motion.stuck, motion.sideways) = (intended, stuck, 0.0);
                }
                let plan_within = |work_max| {
                    let budget = Budget::of(work_max);
                    world.plan_within(&mut Mdp::default(), &world.unseen(), world.leg.start, &budget)
                };
                let [online, cold] = [None, Some(u64::MAX)].map(plan_within);
                assert_eq!((online.status, online.action), (PlanStatus::Solved, cold.action), "{intended}");
                assert_eq!(cold.status, PlanStatus::Solved);
            }
        }
    }
}

#[test]
fn a_session_and_a_solve_from_nothing_choose_the_same_hop_however_far_out_the_discount() {
    let mut compared = 0;
    for seed in 0..24 {
        let world = World::doubtful(seed);
        let mut veteran = Mdp::default();
        for share in [0.3, 0.7, 1.0] {
            let map = partly_seen(&world, seed, share);
            for cell in world.leg.grid.iter().filter(|cell| *cell != world.leg.goal) {
                let [warm, cold] = [None, Some(u64::MAX)].map(|work_max| {
                    let mut novice = Mdp::default();
                    let mdp = if work_max.is_none() { &mut veteran } else { &mut novice };
                    world.plan_within(mdp, &map, cell, &Budget::of(work_max)).action
                });
                assert_eq!(warm, cold, "{cell}, seed {seed}, {share} seen");
                compared += 1;
            }
        }
    }
    assert!(compared > 1_000, "{compared}");
}

#[test]
fn what_absorbs_pays_once_and_loosens_no_tolerance_for_ever() {
    let mut world = World::paper(Soils::Hard, [0.5, 0.5], Profile::Hopper);
    world.leg.payoff.goal = 1.0e6;
    let cold = Budget::of(Some(u64::MAX));
    let plan = world.plan_within(&mut Mdp::default(), &world.seen(), world.leg.start, &cold);
    // The limit of floating point for the largest worth there is, not for a goal's payoff at every step.
    let limit = 64.0 * f64::EPSILON * 1.0e6 / (1.0 - world.leg.payoff.discount);
    assert!(plan.status == PlanStatus::Solved && plan.error_bound <= limit, "{plan:?}, limit {limit:e}");
}

#[test]
fn rewards_beyond_the_precision_of_the_tolerance_are_still_solved() {
    let mut world = World::paper(Soils::Sandy, [9.0e5, 9.0e5], Profile::Hopper);
    world.leg.payoff.goal = -1.0e6;
    let mut planner = Mdp::default();
    let plan = world.plan(&mut planner, &world.seen(), world.leg.start);
    assert_eq!(plan.status, PlanStatus::Solved, "{plan:?}");
}

#[test]
fn a_budget_cuts_between_sweeps_and_says_how_far_it_came() {
    let world = World::paper(Soils::Sandy, [0.5, 0.5], Profile::Hopper);
    let mut planner = Mdp::default();
    let mut plan_within =
        |work_max| world.plan_within(&mut planner, &world.seen(), world.leg.start, &Budget::of(work_max));
    // Without a budget the plan is the online model's, which counts other work.
    let whole = plan_within(Some(u64::MAX));
    assert_eq!(whole.status, PlanStatus::Solved);
    assert_eq!(plan_within(None).action, whole.action);
    let mut error_bound = f64::INFINITY;
    for work in [0, 1, 5, whole.work / 2] {
        let cut = plan_within(Some(work));
        assert_eq!((cut.status, cut.work), (PlanStatus::Cut, work));
        assert!(matches!(cut.action, Action::Hop(_)));
        assert!(cut.error_bound < error_bound && cut.error_bound > whole.error_bound, "{cut:?}");
        error_bound = cut.error_bound;
    }
    assert_eq!(plan_within(Some(whole.work)), whole);
}

#[test]
fn a_goal_walled_off_as_far_as_is_known_is_infeasible() {
    let goal = Cell::new(7, 7);
    let mut world = World::flat(9, Cell::new(1, 1), goal, Profile::Hopper);
    for x in 0..9 {
        let index = world.leg.grid.index(Cell::new(x, 4)).unwrap();
        world.cells[index].passable = false;
    }
    let mut planner = Mdp::default();
    let mut plan = |map: &ObservedMap, cell| world.plan(&mut planner, map, cell);
    assert_eq!(plan(&world.unseen(), world.leg.start).status, PlanStatus::Solved);
    let walled_off = plan(&world.seen(), world.leg.start);
    assert_eq!((walled_off.action, walled_off.status), (Action::Hold, PlanStatus::Infeasible));
    assert_eq!(plan(&world.seen(), Cell::new(2, 6)).status, PlanStatus::Solved);
    // One cell of the wall unseen: there may be a way.
    let map = world.seen_where(|index| index != 4 * 9 + 8);
    assert_eq!(plan(&map, world.leg.start).status, PlanStatus::Solved);
    // Off the map, or at the goal, there is nothing to plan.
    assert_eq!(plan(&map, Cell::new(-1, 3)), Plan::at_once(Action::Hold, PlanStatus::Infeasible));
    assert_eq!(plan(&map, goal), Plan::at_once(Action::Hold, PlanStatus::Solved));
}

#[test]
fn a_start_off_the_goals_lattice_is_infeasible() {
    let mut world = World::flat(9, Cell::new(1, 1), Cell::new(7, 7), Profile::Hopper);
    world.leg.grid.hop_cells = 2;
    let mut planner = Mdp::default();
    assert_eq!(world.plan(&mut planner, &world.seen(), Cell::new(1, 1)).status, PlanStatus::Solved);
    assert_eq!(world.plan(&mut planner, &world.seen(), Cell::new(2, 1)).status, PlanStatus::Infeasible);
    assert_eq!(planner.policy(), None, "the policy of an earlier plan is not this one's");
}
