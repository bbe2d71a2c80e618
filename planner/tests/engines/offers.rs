//! Planners of hoppers with the vertical hop, and of the payoff of the predecessor paper: they command what is offered on seen ground,
//! keep the law of planners, and go where the values say.

use contract::{Action, Cell, Direction, Profile, Vetoed};
use planner::{ALGORITHMS, Budget, PlanStatus, Planner, Situation, algorithm};

use crate::world::World;

/// A world drawn from `seed`, rough enough that hops collide, with the vertical hop.
fn rough(seed: u64, profile: Profile) -> World {
    let mut world = World::random(seed, profile);
    world.leg.motion.vertical = true;
    world
}

/// The actions that the seen ground offers at the hopper's cell.
fn offered(situation: &Situation<'_>) -> [Option<Action>; 4] {
    let (leg, map, from) = (situation.leg(), situation.map, situation.state.pose.cell);
    let ground = map.ground(from).unwrap();
    let height_m = |cell| map.ground(cell).map(|ground| ground.height_m);
    motion::offers(&leg.motion, &leg.grid, (from, ground), height_m)
        .map(|offer| offer.map(|offer| offer.action))
}

fn choice(planner: &mut dyn Planner, situation: &Situation<'_>, vetoed: Vetoed) -> Action {
    let state = contract::State { vetoed, ..*situation.state };
    planner.plan(&Situation { state: &state, ..*situation }, &Budget::default()).action
}

/// P-UP-LAW: Whatever a planner has planned before, it commands what a fresh one does; it commands only what the seen ground offers, and
/// neither insists on what is vetoed nor minds the veto of what it would not choose.
#[test]
fn planners_keep_their_law_and_command_what_is_offered() {
    for name in ALGORITHMS {
        let (mut ups, mut decisions) = (0, 0);
        for profile in Profile::ALL {
            for seed in 0..12 {
                let mut kept = algorithm(name).unwrap();
                rough(seed, profile).fly(&mut *algorithm(name).unwrap(), seed, |situation, plan| {
                    decisions += 1;
                    assert_eq!(choice(&mut *kept, situation, Vetoed::NONE), plan.action, "{name} {seed}");
                    let offers = offered(situation);
                    ups += u32::from(matches!(plan.action, Action::Up(_)));
                    if let Some(direction) = plan.action.hop() {
                        assert_eq!(offers[direction as usize], Some(plan.action), "{name} {seed}");
                    }
                    let mut vetoed = Vetoed::NONE;
                    let mut action = plan.action;
                    while action != Action::Hold {
                        assert!(!vetoed.has(action), "{name} insists on {action}");
                        vetoed = vetoed.with(action);
                        action = choice(&mut *kept, situation, vetoed);
                    }
                    for other in offers.into_iter().flatten().filter(|other| *other != plan.action) {
                        let action = choice(&mut *kept, situation, Vetoed::NONE.with(other));
                        assert_eq!(action, plan.action, "{name} {seed}: {other} is vetoed");
                    }
                });
            }
        }
        assert!(decisions > 100, "{name}: {decisions}");
        assert!(ups > 10 || *name == "hold", "{name}: {ups} of {decisions}");
    }
}

/// P-UP-VALUES.
#[test]
fn what_the_mdp_says_of_its_values_holds_and_a_budget_only_widens_it() {
    for seed in 0..12 {
        let world = rough(seed, Profile::Hopper);
        let mut planner = algorithm("mdp").unwrap();
        let plan = world.plan(&mut *planner, &world.seen(), world.leg.start);
        if plan.status != PlanStatus::Solved || world.leg.start == world.leg.goal {
            continue;
        }
        assert!(plan.error_bound <= 1e-6, "{plan:?}");
        let solved = planner.policy().unwrap();
        for work in [1, 3, 10] {
            let cut =
                world.plan_within(&mut *planner, &world.seen(), world.leg.start, &Budget::of(Some(work)));
            assert!(cut.work <= work);
            let policy = planner.policy().unwrap();
            let off = policy.iter().zip(&solved).map(|(cut, solved)| (cut.value - solved.value).abs());
            let worst = off.fold(0.0, f64::max);
            assert!(worst <= cut.error_bound + plan.error_bound, "seed {seed}: {worst} {cut:?}");
        }
    }
}

/// P-UP-WALL: A wall that no hop clears is climbed at the goal's row by all planners of routes and by the model; a wall higher than the vertical
/// hop's apex is walked around.
#[test]
fn a_low_wall_is_climbed_and_a_high_one_is_not() {
    for (height_m, name) in [0.3, 0.6]
        .into_iter()
        .flat_map(|height_m| ["mdp", "astar", "dstar_lite"].map(|name| (height_m, name)))
    {
        let (start, goal) = (Cell::new(4, 6), Cell::new(7, 6));
        let mut world = World::flat(13, start, goal, Profile::Hopper);
        world.leg.motion.vertical = true;
        for (index, ground) in world.cells.iter_mut().enumerate() {
            let (x, y) = (index % 13, index / 13);
            // Open at the northern end, far away.
            ground.height_m = if x == 5 && y < 12 { height_m } else { 0.0 };
        }
        let plan = world.plan(&mut *algorithm(name).unwrap(), &world.seen(), start);
        let need = match height_m < 0.4 {
            true => Action::Up(Direction::East),
            false => Action::Hop(Direction::North),
        };
        assert_eq!((plan.action, plan.status), (need, PlanStatus::Solved), "{name} {height_m}");
    }
    // Shut in on a cell, none of them moves.
    for name in ["mdp", "astar", "dstar_lite", "greedy"] {
        let start = Cell::new(4, 6);
        let mut world = World::flat(13, start, Cell::new(7, 6), Profile::Hopper);
        world.leg.motion.vertical = true;
        for (index, ground) in world.cells.iter_mut().enumerate() {
            ground.height_m = if index == 6 * 13 + 4 { 0.0 } else { 0.6 };
        }
        let plan = world.plan(&mut *algorithm(name).unwrap(), &world.seen(), start);
        assert_eq!((plan.action, plan.status), (Action::Hold, PlanStatus::Infeasible), "{name}");
    }
}
