//! A* and D* Lite against exhaustive relaxation, against each other, and as they fly.

use contract::{Action, Cell, Decision, Direction, Grid, ObservedMap, Profile, RobotId};
use motion::{Domain, Draw};
use planner::route::costs::{Costs, FORBIDDEN, at_least};
use planner::route::dstar_lite::IncrementalSearch;
use planner::route::{Found, Search, astar};
use planner::{Budget, PlanStatus, algorithm};

use crate::world::{PROFILES, Soils, World};

/// Cost from every cell to the goal, by relaxing every hop until nothing changes.
fn relaxed(costs: &Costs, grid: &Grid, goal: Cell) -> Vec<u64> {
    let mut least = vec![FORBIDDEN; grid.cells()];
    least[grid.index(goal).unwrap()] = 0;
    loop {
        let before = least.clone();
        for (index, hops) in costs.hops.iter().enumerate() {
            for direction in Direction::ALL {
                let to = grid.hop(grid.cell(index), direction);
                if hops[direction as usize] != FORBIDDEN {
                    let through = hops[direction as usize].saturating_add(least[grid.index(to).unwrap()]);
                    least[index] = least[index].min(through);
                }
            }
        }
        if least == before {
            return least;
        }
    }
}

/// The first of north, east, south, west that begins a cheapest route.
fn expected(costs: &Costs, least: &[u64], grid: &Grid, here: Cell) -> Search {
    let index = grid.index(here).unwrap();
    let cost = least[index];
    if cost == FORBIDDEN {
        return Search::NoRoute;
    }
    let begins = |direction: &Direction| {
        let hop = costs.hops[index][*direction as usize];
        hop != FORBIDDEN && hop.saturating_add(least[grid.index(grid.hop(here, *direction)).unwrap()]) == cost
    };
    Search::Found(Found { direction: Direction::ALL.into_iter().find(begins).unwrap(), cost })
}

fn partly_seen(world: &World, seed: u64, share: f64) -> ObservedMap {
    let drawn = |index| Draw::new(seed, Domain::Motion, RobotId(7), Decision(index as u64)).uniform();
    world.seen_where(|index| drawn(index) < share)
}

fn costs(world: &World, map: &ObservedMap, here: Cell) -> Costs {
    let state = world.state(here, Decision(0), 0);
    Costs::new(&world.situation(map, &state))
}

/// P-ROUTE: A* and D* Lite find the cheapest routes of exhaustive relaxation, and recognise
/// infeasible missions.
#[test]
fn both_find_the_cheapest_routes_of_exhaustive_relaxation() {
    let (mut routes, mut dead_ends) = (0, 0);
    for seed in 0..60 {
        for profile in PROFILES {
            let world = World::random(seed, profile);
            let (grid, goal) = (world.leg.grid, world.leg.goal);
            let map = partly_seen(&world, seed, [0.0, 0.4, 0.8, 1.0][seed as usize % 4]);
            let costs = costs(&world, &map, world.leg.start);
            let least = relaxed(&costs, &grid, goal);
            for here in grid.iter().filter(|&cell| cell != goal && grid.on_same_lattice(cell, goal)) {
                let need = expected(&costs, &least, &grid, here);
                let (found, expansions) = astar::search(&costs, &grid, here, goal, &Budget::default());
                assert_eq!(found, need, "A*, world {seed}, {profile}, from {here}");
                assert!(expansions <= grid.cells() as u64, "A* expands no cell twice");
                let mut search = IncrementalSearch::new(costs.clone(), grid, here, goal);
                assert_eq!(
                    search.search(&Budget::default()).0,
                    need,
                    "D* Lite, world {seed}, {profile}, from {here}"
                );
                match need {
                    Search::NoRoute => dead_ends += 1,
                    _ => routes += 1,
                }
                let bound = at_least(&grid, costs.cheapest, here, goal);
                assert!(bound <= least[grid.index(here).unwrap()], "the bound is admissible");
            }
        }
    }
    assert!(routes > 2_000 && dead_ends > 20, "{routes} routes, {dead_ends} dead ends");
}

/// P-MENDED: An incrementally repaired search decides like a new one, and like A*.
#[test]
fn a_mended_search_decides_as_a_new_one_and_as_a_star() {
    let mut decisions = 0;
    let mut worlds: Vec<World> = PROFILES.map(|p| World::paper(Soils::Sandy, [0.5, 0.5], p)).into();
    worlds.extend(PROFILES.map(|p| World::paper(Soils::Heterogeneous, [0.5, 0.5], p)));
    worlds.extend(PROFILES.map(|p| World::flat(12, Cell::new(0, 0), Cell::new(11, 11), p)));
    let mut mended = algorithm("dstar_lite").unwrap();
    let (mut mended_work, mut new_work) = (0, 0);
    for seed in 0..16 {
        for world in &worlds {
            world.fly(&mut *mended, seed, |situation, plan| {
                let new = algorithm("dstar_lite").unwrap().plan(situation, &Budget::default());
                let star = algorithm("astar").unwrap().plan(situation, &Budget::default());
                assert_eq!((plan.action, plan.status), (new.action, new.status));
                assert_eq!((plan.action, plan.status), (star.action, star.status));
                (mended_work, new_work) = (mended_work + plan.work, new_work + new.work);
                decisions += 1;
            });
        }
    }
    assert!(decisions > 2_000, "only {decisions} decisions compared");
    assert!(mended_work < new_work, "mending took {mended_work} expansions, new searches {new_work}");
}

/// P-ROUTE.
#[test]
fn a_wall_as_far_as_is_known_is_infeasible_and_a_gap_in_it_is_tried() {
    let mut world = World::flat(9, Cell::new(1, 1), Cell::new(7, 7), Profile::Hopper);
    for x in 0..9 {
        let index = world.leg.grid.index(Cell::new(x, 4)).unwrap();
        world.cells[index].passable = false;
    }
    for name in ["astar", "dstar_lite"] {
        let mut planner = algorithm(name).unwrap();
        let start = world.leg.start;
        assert_eq!(world.plan(&mut *planner, &world.unseen(), start).status, PlanStatus::Solved);
        let shut = world.plan(&mut *planner, &world.seen(), start);
        assert_eq!((shut.action, shut.status), (Action::Hold, PlanStatus::Infeasible), "{name}");
        let map = world.seen_where(|index| index != 4 * 9 + 8);
        let gap = world.plan(&mut *planner, &map, start);
        assert_eq!((gap.action, gap.status), (Action::Hop(Direction::North), PlanStatus::Solved), "{name}");
        assert_eq!(world.plan(&mut *planner, &map, Cell::new(-1, 3)).status, PlanStatus::Infeasible);
        assert_eq!(world.plan(&mut *planner, &map, world.leg.goal).status, PlanStatus::Solved);
    }
}

/// P-MENDED.
#[test]
fn a_search_that_is_cut_holds_whatever_was_kept() {
    let world = World::paper(Soils::Hard, [0.5, 0.5], Profile::Hopper);
    for name in ["astar", "dstar_lite"] {
        let mut planner = algorithm(name).unwrap();
        let mut plan = |work_max| {
            world.plan_within(&mut *planner, &world.seen(), world.leg.start, &Budget::of(work_max))
        };
        let whole = plan(None);
        let cut = plan(Some(whole.work / 2));
        assert_eq!((cut.action, cut.status), (Action::Hold, PlanStatus::Cut), "{name}");
        assert_eq!(cut.work, whole.work / 2);
        assert_eq!(plan(Some(whole.work)), whole, "{name}");
    }
}

#[test]
fn an_expected_hop_costs_what_its_tries_cost() {
    // Hard: 2 / 0.9 steps. Sand: 0.3 / 0.7 failed tries at 2 steps, then 3.
    let world = World::paper(Soils::Hard, [0.5, 0.5], Profile::Hopper);
    let costs = costs(&world, &world.unseen(), world.leg.start);
    assert_eq!(costs.cheapest, 2_222_222);
    assert_eq!(costs.hops[0], [2_222_222, 2_222_222, FORBIDDEN, FORBIDDEN]);
    let mut sandy = World::paper(Soils::Sandy, [0.5, 0.5], Profile::Hopper);
    sandy.cells[210].gradient = [0.0, 0.0];
    let costs = self::costs(&sandy, &sandy.seen(), sandy.leg.start);
    assert_eq!(costs.hops[210], [3_857_143; 4]);
}
