//! The greedy planner against hand-made situations.

use contract::{Action, Cell, Direction, Ground, Profile, Soil};
use planner::{PlanStatus, algorithm};

use crate::world::{PROFILES, Soils, World, with_treasures};

/// A flat world of 5 × 5 with the hopper in the middle, the goal north of it, and rocks around.
fn rocks(profile: Profile, directions: &[Direction]) -> (World, Cell) {
    let middle = Cell::new(2, 2);
    let mut world = World::flat(5, Cell::new(2, 0), Cell::new(2, 4), profile);
    for direction in directions {
        let index = world.leg.grid.index(world.leg.grid.hop(middle, *direction)).unwrap();
        world.cells[index] = Ground { passable: false, ..Ground::FLAT };
    }
    (world, middle)
}

#[test]
fn greedy_takes_the_neighbour_with_the_largest_payoff() {
    // Sand attracts under the paper's T: S is 1 there, 0 on flat hard ground, and w1 outweighs D.
    let mut world = World::paper(Soils::Hard, [100.0, 0.0], Profile::Paper2023);
    let here = Cell::new(10, 10);
    let west = world.leg.grid.index(Cell::new(9, 10)).unwrap();
    world.cells[west].soil = Soil::Sand;
    world.leg.priors.safety.max += 5.0;
    let plan = |world: &World| world.plan(&mut *algorithm("greedy").unwrap(), &world.seen(), here).action;
    assert_eq!(plan(&world), Action::Hop(Direction::West));
    world.leg.profile = Profile::Hopper;
    assert_ne!(plan(&world), Action::Hop(Direction::West), "in profile hopper sand attracts nobody");
}

#[test]
fn greedy_hops_onto_the_goal_whatever_else_pays() {
    let world = World::paper(Soils::Hard, [90.0, 0.0], Profile::Paper2023);
    let beside = Cell::new(17, 18);
    let plan = world.plan(&mut *algorithm("greedy").unwrap(), &world.unseen(), beside);
    assert_eq!(plan.action, Action::Hop(Direction::East));
}

#[test]
fn greedy_in_profile_hopper_never_hops_towards_known_rocks() {
    use Direction::{East, North, South, West};
    let plan =
        |(world, here): (World, Cell)| world.plan(&mut *algorithm("greedy").unwrap(), &world.seen(), here);
    assert_eq!(plan(rocks(Profile::Hopper, &[])).action, Action::Hop(North));
    assert_eq!(plan(rocks(Profile::Hopper, &[North])).action, Action::Hop(East));
    assert_eq!(plan(rocks(Profile::Hopper, &[North, East, West])).action, Action::Hop(South));
    let shut_in = plan(rocks(Profile::Hopper, &Direction::ALL));
    assert_eq!((shut_in.action, shut_in.status), (Action::Hold, PlanStatus::Infeasible));
    assert_eq!(plan(rocks(Profile::Paper2023, &[North])).action, Action::Hop(North));
}

#[test]
fn greedy_never_hops_off_the_map() {
    let world = World::flat(5, Cell::new(0, 0), Cell::new(4, 4), Profile::Paper2023);
    for cell in world.leg.grid.iter() {
        let plan = world.plan(&mut *algorithm("greedy").unwrap(), &world.unseen(), cell);
        match plan.action {
            Action::Hop(direction) => {
                assert!(world.leg.grid.contains(world.leg.grid.hop(cell, direction)))
            }
            Action::Hold => assert_eq!(cell, world.leg.goal),
            _ => panic!("a hopper does not drive or fly"),
        }
    }
}

#[test]
fn greedy_takes_a_treasure_beside_it_and_no_other() {
    for profile in PROFILES {
        let world = World::paper(Soils::Hard, [0.5, 0.5], profile);
        let here = Cell::new(5, 5);
        let towards = |treasures: Vec<Cell>| {
            let map = with_treasures(world.seen(), &treasures);
            world.plan(&mut *algorithm("greedy").unwrap(), &map, here).action
        };
        assert_eq!(towards(vec![Cell::new(5, 4)]), Action::Hop(Direction::South));
        assert_eq!(towards(vec![Cell::new(5, 3)]), towards(vec![]), "it looks no further than one hop");
    }
}
