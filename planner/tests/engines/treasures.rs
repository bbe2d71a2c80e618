//! Treasures: exact over what is left to collect, paid once.

use std::collections::BTreeSet;

use contract::{Action, Cell, Collected, Decision, Direction, ObservedMap, Profile};
use planner::mdp::hunt::Hunt;
use planner::mdp::model::Model;
use planner::mdp::treasure_sets::EXACT_MAX;
use planner::{Budget, Planner, algorithm};
use solver::{Hop, Kind, Leaving, Scatter};

use crate::world::{PROFILES, Soils, World, with_treasures};

/// Values of the process whose state is (cell, treasures left), by Jacobi iteration over all of it at
/// once: values[set][node]. Written from the definition, apart from the planner's own treatment.
fn brute_force(world: &World, map: &ObservedMap, here: Cell) -> (Model, Vec<Vec<f64>>) {
    let plain = with_treasures(map.clone(), &[]);
    let state = world.state(here, contract::Decision(0), 0);
    let model = Model::new(&world.situation(&plain, &state));
    let nodes: Vec<usize> = map.treasures().iter().map(|&cell| model.lattice.node(cell).unwrap()).collect();
    let process = &model.world;
    let rules = process.rules();
    let sets = 1_usize << nodes.len();
    let mut values = vec![vec![0.0_f64; process.nodes()]; sets];
    loop {
        let mut next = values.clone();
        for set in 0..sets {
            let worth = |to: usize| match process.kind(to) {
                Kind::Lost => rules.loss,
                Kind::Goal => process.payoff(to),
                Kind::Free => match nodes.iter().position(|&treasure| treasure == to) {
                    Some(number) if set & 1 << number != 0 => {
                        let collected = process.payoff(to) + world.leg.payoff.treasure;
                        collected + values[set & !(1 << number)][to]
                    }
                    _ => process.payoff(to) + values[set][to],
                },
            };
            let free = |node: &usize| process.kind(*node) == Kind::Free;
            for node in (0..process.nodes()).filter(free) {
                let hops = Hop::ALL.map(|hop| {
                    let Scatter { intended, stayed, left, right } = process.scatter(node, hop);
                    let towards = |hop: Hop| match (process.neighbour(node, hop), rules.leaving) {
                        (Some(to), _) => worth(to),
                        (None, Leaving::Stays) => worth(node),
                        (None, Leaving::Loses) => rules.loss,
                    };
                    let sum = intended * towards(hop)
                        + stayed * worth(node)
                        + left * towards(hop.left())
                        + right * towards(hop.right());
                    let waits = process.soil(node).wait > 0.0;
                    let waited = if waits { process.payoff(node) + rules.discount * sum } else { sum };
                    rules.discount * waited
                });
                next[set][node] = hops.into_iter().fold(f64::NEG_INFINITY, f64::max);
            }
        }
        let change = |(a, b): (&f64, &f64)| (a - b).abs();
        let most = next.iter().flatten().zip(values.iter().flatten()).map(change).fold(0.0, f64::max);
        values = next;
        if most < 1e-10 {
            return (model, values);
        }
    }
}

/// P-TREASURES: With known treasures, the plan is the optimum over all subsets that may be left to
/// collect.
///
/// 2^k models give the optimum of the process over (cell, treasures left).
#[test]
fn the_plan_with_treasures_is_the_optimum_over_all_that_may_be_left() {
    let mut compared = 0;
    for profile in PROFILES {
        for seed in 0..8 {
            let mut world = World::random(seed, profile);
            world.leg.payoff.treasure = [3.0, 40.0][(seed % 2) as usize];
            let (start, goal) = (world.leg.start, world.leg.goal);
            let grid = world.leg.grid;
            let eligible = |cell: &Cell| {
                let passable = world.ground(*cell).is_some_and(|ground| ground.passable);
                passable && ![start, goal].contains(cell) && grid.on_same_lattice(*cell, goal)
            };
            let treasures: Vec<Cell> = grid.iter().filter(eligible).step_by(5).take(3).collect();
            let map = with_treasures(world.seen(), &treasures);
            let mut mdp = planner::mdp::Mdp::default();
            let plan = world.plan(&mut mdp, &map, start);
            let Some(policy) = mdp.policy() else { continue };
            let (model, values) = brute_force(&world, &map, start);
            let all = (1 << treasures.len()) - 1;
            for (index, policy) in policy.iter().enumerate() {
                let cell = grid.cell(index);
                let free = |node: &usize| model.world.kind(*node) == Kind::Free;
                let Some(node) = model.lattice.node(cell).filter(free) else {
                    continue;
                };
                // Standing on a treasure's cell it has been collected.
                let taken = treasures.iter().position(|treasure| *treasure == cell);
                let set = taken.map_or(all, |number| all & !(1 << number));
                let scale = 1.0 + values[set][node].abs();
                assert!((policy.value - values[set][node]).abs() < 1e-7 * scale, "{cell} in world {seed}");
                compared += 1;
            }
            assert_ne!(plan.action, Action::Hold);
        }
    }
    assert!(compared > 300, "{compared}");
}

#[test]
fn a_treasure_is_worth_a_detour_that_its_payoff_covers() {
    for profile in PROFILES {
        let mut world = World::flat(9, Cell::new(3, 4), Cell::new(7, 4), profile);
        let aside = Cell::new(3, 2);
        let mut first = |payoff: f64, treasures: Vec<Cell>| {
            world.leg.payoff.treasure = payoff;
            let map = with_treasures(world.seen(), &treasures);
            world.plan(&mut *algorithm("mdp").unwrap(), &map, Cell::new(3, 4)).action
        };
        assert_eq!(first(0.0, vec![aside]), first(0.0, vec![]), "nothing for nothing");
        // Two hops aside and back: four periods, each at a price of up to 40 in profile hopper.
        assert_eq!(first(200.0, vec![aside]), Action::Hop(Direction::South), "{profile}");
        assert_ne!(first(200.0, vec![]), Action::Hop(Direction::South), "collected, it is forgotten");
        assert_ne!(first(0.1, vec![aside]), Action::Hop(Direction::South), "too little to turn for");
    }
}

/// The mission of a hopper that sees everything, treasures collected as it lands on them.
#[test]
fn nobody_lingers_at_a_treasure() {
    for name in ["mdp", "greedy", "astar"] {
        let mut world = World::paper(Soils::Hard, [0.5, 0.5], Profile::Paper2023);
        world.leg.payoff.treasure = 1_000.0;
        let all = [Cell::new(4, 4), Cell::new(6, 3), Cell::new(12, 10)];
        let mut map = with_treasures(world.seen(), &all);
        let mut planner = algorithm(name).unwrap();
        let (mut cell, mut landings) = (world.leg.start, BTreeSet::new());
        for decision in 0..150 {
            if cell == world.leg.goal {
                break;
            }
            let action = world.plan(&mut *planner, &map, cell).action;
            (cell, _) = world.hop(cell, action, 3, contract::Decision(decision));
            landings.insert(cell);
            let left: Vec<Cell> =
                map.treasures().iter().copied().filter(|treasure| *treasure != cell).collect();
            map.set_treasures(&left);
        }
        assert_eq!(cell, world.leg.goal, "{name}");
        if name == "mdp" {
            assert!(map.treasures().is_empty() && all.iter().all(|cell| landings.contains(cell)));
        }
    }
}

#[test]
fn of_more_treasures_than_are_planned_for_the_nearest_count() {
    let mut world = World::flat(9, Cell::new(4, 4), Cell::new(8, 8), Profile::Hopper);
    world.leg.payoff.treasure = 150.0;
    let near: Vec<Cell> = [(4, 3), (3, 4), (3, 3), (4, 2)].map(|(x, y)| Cell::new(x, y)).into();
    assert_eq!(near.len(), EXACT_MAX);
    let value = |treasures: Vec<Cell>| {
        let mut mdp = planner::mdp::Mdp::default();
        let map = with_treasures(world.seen(), &treasures);
        world.plan(&mut mdp, &map, Cell::new(4, 4));
        mdp.policy().unwrap()[world.leg.grid.index(Cell::new(4, 4)).unwrap()].value
    };
    let with_a_far_one = [&near[..], &[Cell::new(0, 8)]].concat();
    assert_eq!(value(with_a_far_one), value(near));
}

/// P-TREASURE-HUNT: Profile `hopper` makes detours for treasures and searches for them while it has
/// steps to spare, and collects more than the paper's planner at no lower success.
#[test]
fn profile_hopper_makes_detours_for_treasures_while_it_has_steps_to_spare() {
    let here = Cell::new(3, 4);
    let action = |profile, treasures, steps| {
        let mut world = World::flat(9, here, Cell::new(7, 4), profile);
        world.leg.payoff.treasure = 20.0;
        world.leg.priors.treasures = treasures;
        let map = with_treasures(world.seen(), &[Cell::new(3, 2)]);
        let state = world.state(here, Decision(0), steps);
        let situation = world.situation(&map, &state);
        let hunts = Hunt::of(&situation).is_some();
        (hunts, planner::mdp::Mdp::default().plan(&situation, &Budget::default()).action)
    };
    let (south, east) = (Action::Hop(Direction::South), Action::Hop(Direction::East));
    assert_eq!(action(Profile::Hopper, 1, 0), (true, south));
    assert_eq!(action(Profile::Hopper, 1, 100), (true, south));
    // Four hops to the goal take nine steps, and 1.25 times as many and 30 are kept.
    assert_eq!(action(Profile::Hopper, 1, 110), (false, east), "of 150 steps 40 are left");
    assert_eq!(action(Profile::Hopper, 1, 200), (false, east), "beyond the limit");
    assert_eq!(action(Profile::Hopper, 0, 0), (false, east), "the brief tells of none");
    assert!(!action(Profile::Paper2023, 1, 0).0);
}

/// P-TREASURE-HUNT. Of two ways of equal length, a hunt takes the one from which more is seen.
#[test]
fn a_hunt_goes_where_unseen_cells_come_into_sight() {
    let (here, goal) = (Cell::new(0, 0), Cell::new(6, 6));
    for unseen_above in [true, false] {
        let mut world = World::flat(7, here, goal, Profile::Hopper);
        world.leg.payoff.treasure = 20.0;
        let grid = world.leg.grid;
        // One half is unseen, on one side of the diagonal.
        let map = world.seen_where(|index| {
            let cell = grid.cell(index);
            if unseen_above { cell.y <= cell.x + 1 } else { cell.x <= cell.y + 1 }
        });
        let mut first = |treasures, collected| {
            world.leg.priors.treasures = treasures;
            let mut state = world.state(here, Decision(0), 0);
            state.collected = collected;
            let situation = world.situation(&map, &state);
            planner::mdp::Mdp::default().plan(&situation, &Budget::default()).action
        };
        let towards = if unseen_above { Direction::North } else { Direction::East };
        assert_eq!(first(3, Collected(0b1)), Action::Hop(towards));
        assert_eq!(first(3, Collected(0b111)), first(0, Collected(0)), "all are found");
    }
}

/// P-TREASURE-HUNT. A freshly started planner decides like the one that has flown.
#[test]
fn a_hunt_does_not_depend_on_what_the_planner_remembers() {
    let mut world = World::paper(Soils::Hard, [0.5, 0.5], Profile::Hopper);
    world.leg.payoff.treasure = 20.0;
    world.leg.priors.treasures = 4;
    // Too few for a hunt at the start, and enough once half of the way has gone well.
    world.leg.limits.steps_max = 110;
    let (mut hunts, mut others) = (0, 0);
    for seed in 0..4 {
        world.fly(&mut planner::mdp::Mdp::default(), seed, |situation, plan| {
            let fresh = planner::mdp::Mdp::default().plan(situation, &Budget::default());
            assert_eq!((fresh.action, fresh.error_bound), (plan.action, plan.error_bound));
            *(if Hunt::of(situation).is_some() { &mut hunts } else { &mut others }) += 1;
        });
    }
    assert!(hunts > 0 && others > 0, "{hunts} {others}");
}
