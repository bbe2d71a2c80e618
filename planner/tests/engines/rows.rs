//! Payoffs and Bellman's right-hand side against numbers worked out by hand.

use contract::{Cell, Decision, DistanceNorm, Grid, Ground, Profile, Range, Soil, Weights};
use planner::mdp::model::{LOSS, Model};
use planner::payoff::{LandingPayoff, PERIOD_PRICE};
use solver::{Kind, Leaving, action_values};

use crate::world::{PROFILES, World};

/// 3 × 3 cells seen, start in the south-west, goal in the north-east, the middle on sand.
fn nine_cells(profile: Profile) -> World {
    let grid = Grid::new(3, 3, 1.0, 1).unwrap();
    let mut cells = vec![Ground::FLAT; 9];
    cells[4] =
        Ground { height_m: 0.5, gradient: [0.06, -0.08], soil: Soil::Sand, passable: true, ..Ground::FLAT };
    let weights = Weights { safety: 2.0, information: 4.0, distance: 10.0 };
    let mut world = World::new(grid, cells, (Cell::new(0, 0), Cell::new(2, 2)), weights, profile);
    world.leg.priors.safety = Range { min: -0.1, max: 4.9 };
    world.leg.priors.height_m = Range { min: -0.5, max: 1.5 };
    world
}

fn model(world: &World) -> Model {
    let (map, state) = (world.seen(), world.state(world.leg.start, Decision(0), 0));
    Model::new(&world.situation(&map, &state))
}

#[track_caller]
fn close(got: f64, need: f64) {
    assert!((got - need).abs() <= 1e-12 * need.abs().max(1.0), "need {need}, got {got}");
}

#[test]
fn the_payoff_is_the_weighted_sum_of_the_paper() {
    let world = nine_cells(Profile::Paper2023);
    let payoff = LandingPayoff::new(&world.leg);
    let of = |x, y| payoff.of(Cell::new(x, y), world.ground(Cell::new(x, y)).unwrap());
    // Flat hard ground: S = (0 + 0.1)/5, I = 0.5/2. D = −1 at the start, −1/2 in the middle.
    close(of(0, 0), 2.0 * 0.02 + 4.0 * 0.25 - 10.0);
    close(of(2, 1), 2.0 * 0.02 + 4.0 * 0.25 - 10.0 / 8_f64.sqrt());
    // |∇h| = 0.1 on sand, T = −5: S = (−0.1 + 5 + 0.1)/5 = 1. Height 0.5: I = 0.5.
    close(of(1, 1), 2.0 + 4.0 * 0.5 - 5.0);
    close(of(2, 2), 100.0);
}

/// P-READINGS.
#[test]
fn distance_and_leaving_are_read_as_the_brief_says() {
    let mut world = nine_cells(Profile::Paper2023);
    world.leg.reading.distance = DistanceNorm::Manhattan;
    let of = |world: &World, x, y| {
        LandingPayoff::new(&world.leg).of(Cell::new(x, y), world.ground(Cell::new(x, y)).unwrap())
    };
    // One of the four cells from start to goal is left at (2, 1), two at (0, 2), and all at the start.
    close(of(&world, 2, 1), 2.0 * 0.02 + 4.0 * 0.25 - 10.0 / 4.0);
    close(of(&world, 0, 2), 2.0 * 0.02 + 4.0 * 0.25 - 10.0 / 2.0);
    close(of(&world, 0, 0), 2.0 * 0.02 + 4.0 * 0.25 - 10.0);
    world.leg.reading.distance_scale_cells = Some(8.0);
    close(of(&world, 2, 1), 2.0 * 0.02 + 4.0 * 0.25 - 10.0 / 8.0);

    assert_eq!(model(&world).world.rules().leaving, Leaving::Stays);
    world.leg.reading.leaving = Some(-100.0);
    let rules = model(&world).world.rules().clone();
    assert_eq!((rules.leaving, rules.loss), (Leaving::Loses, -100.0));
    // West of the start, on hard flat ground: the hop leaves unless it slips, to the south as well, or to (0, 1).
    let values = vec![0.0; 9];
    let west = action_values(&model(&world).world, &values, 0)[3];
    close(west, 0.99 * (0.95 * -100.0 + 0.05 * of(&world, 0, 1)));
}

#[test]
fn in_profile_hopper_safety_is_the_slope_alone() {
    let mut world = nine_cells(Profile::Hopper);
    let (middle, price) = (Cell::new(1, 1), 10.0 * PERIOD_PRICE);
    let of = |world: &World| LandingPayoff::new(&world.leg).of(middle, world.ground(middle).unwrap());
    // The range of −|∇h| − T is 5 wide with T = −5; the rest is the slopes': none.
    close(of(&world), 2.0 * (1.0 - 0.1 / 5.0) + 4.0 * 0.5 - 5.0 - price);
    // 5.2 wide, 0.2 of which are the slopes'.
    world.leg.priors.safety = Range { min: -0.2, max: 5.0 };
    close(of(&world), 2.0 * (1.0 - 0.1 / 0.2) + 4.0 * 0.5 - 5.0 - price);
    // Whichever sign the brief gives T.
    world.leg.payoff.sand_term = 5.0;
    world.leg.priors.safety = Range { min: -5.2, max: 0.0 };
    close(of(&world), 2.0 * (1.0 - 0.1 / 0.2) + 4.0 * 0.5 - 5.0 - price);
}

#[test]
fn in_profile_hopper_every_period_short_of_the_goal_has_the_same_price_on_top() {
    let [hopper, paper] = [Profile::Hopper, Profile::Paper2023].map(|profile| {
        let mut world = nine_cells(profile);
        world.leg.weights.safety = 0.0;
        let payoff = LandingPayoff::new(&world.leg);
        world.leg.grid.iter().map(|cell| payoff.of(cell, &Ground::FLAT)).collect::<Vec<_>>()
    });
    for (index, (hopper, paper)) in hopper.into_iter().zip(paper).enumerate() {
        close(paper - hopper, if index == 8 { 0.0 } else { 10.0 * PERIOD_PRICE });
    }
}

#[test]
fn a_start_on_the_goal_has_no_distance_to_lose() {
    let mut world = nine_cells(Profile::Paper2023);
    world.leg.start = world.leg.goal;
    close(LandingPayoff::new(&world.leg).of(Cell::new(0, 0), &Ground::FLAT), 2.0 * 0.02 + 4.0 * 0.25);
}

#[test]
fn leaving_the_map_counts_as_staying_in_the_paper_and_as_a_loss_in_hopper() {
    for profile in PROFILES {
        let world = nine_cells(profile);
        let model = model(&world);
        let node = |x, y| model.lattice.node(Cell::new(x, y)).unwrap();
        let values: Vec<f64> = (0..9).map(f64::from).collect();
        let worth = |x, y| model.world.payoff(node(x, y)) + values[node(x, y)];
        let left = match profile {
            Profile::Paper2023 => worth(0, 0),
            Profile::Hopper => LOSS + model.world.payoff(node(0, 0)) / (1.0 - 0.99),
            Profile::Paper2022 => unreachable!("it has listed hops"),
        };
        // North, east, south, west from the corner, on hard flat ground.
        let need = [
            0.99 * (0.9 * worth(0, 1) + 0.05 * left + 0.05 * worth(1, 0)),
            0.99 * (0.9 * worth(1, 0) + 0.05 * worth(0, 1) + 0.05 * left),
            0.99 * (0.9 * left + 0.05 * worth(1, 0) + 0.05 * left),
            0.99 * (0.9 * left + 0.05 * left + 0.05 * worth(0, 1)),
        ];
        for (got, need) in action_values(&model.world, &values, node(0, 0)).into_iter().zip(need) {
            close(got, need);
        }
    }
}

#[test]
fn a_hop_from_sand_takes_two_periods() {
    let world = nine_cells(Profile::Paper2023);
    let model = model(&world);
    let node = |x, y| model.lattice.node(Cell::new(x, y)).unwrap();
    let worth = |x, y| model.world.payoff(node(x, y));
    // Values 0; slope 0.06 to the east, so t = atan(0.06)/(π/6) forwards, and for the sideways slips
    // of a hop east the slope to the south, 0.08, on its right.
    let t = 0.06_f64.atan() / std::f64::consts::FRAC_PI_6;
    let t_right = 0.08_f64.atan() / std::f64::consts::FRAC_PI_6;
    let next = 0.7 * (1.0 - t) * worth(2, 1)
        + (0.7 * t + 0.1) * worth(1, 1)
        + 0.1 * (1.0 - t_right) * worth(1, 2)
        + 0.1 * (1.0 + t_right) * worth(1, 0);
    close(action_values(&model.world, &[0.0; 9], node(1, 1))[1], 0.99 * (worth(1, 1) + 0.99 * next));
}

#[test]
fn landing_on_impassable_ground_or_at_the_goal_ends_the_life() {
    let mut world = nine_cells(Profile::Paper2023);
    world.cells[5].passable = false;
    let model = model(&world);
    let node = |x, y| model.lattice.node(Cell::new(x, y)).unwrap();
    let (south_of_goal, west_of_goal, middle) = (node(2, 1), node(1, 2), node(1, 1));
    assert_eq!(model.world.kind(south_of_goal), Kind::Lost);
    let values = [1000.0; 9];
    // East from (1, 2): the goal ahead counts 100 and nothing after; left leaves, so stays; right is the middle.
    let here = model.world.payoff(west_of_goal) + 1000.0;
    close(
        action_values(&model.world, &values, west_of_goal)[1],
        0.99 * (0.9 * 100.0 + 0.05 * here + 0.05 * (model.world.payoff(middle) + 1000.0)),
    );
    close(model.world.afterstate_value(&values, south_of_goal), model.world.rules().loss);
}

#[test]
fn only_the_lattice_of_the_goal_is_modelled() {
    let grid = Grid::new(8, 7, 0.5, 3).unwrap();
    let weights = Weights { safety: 0.0, information: 0.0, distance: 10.0 };
    let corners = (Cell::new(1, 0), Cell::new(4, 3));
    let world = World::new(grid, vec![Ground::FLAT; 56], corners, weights, Profile::Hopper);
    let Model { lattice, world } = model(&world);
    let free: Vec<usize> = (0..world.nodes()).filter(|&node| world.kind(node) == Kind::Free).collect();
    let cells: Vec<Cell> = free.iter().map(|&node| lattice.cell(node)).collect();
    let need = [(1, 0), (4, 0), (7, 0), (1, 3), (7, 3), (1, 6), (4, 6), (7, 6)];
    assert_eq!(cells, need.map(|(x, y)| Cell::new(x, y)));
    for node in free {
        assert_eq!(lattice.node(lattice.cell(node)), Some(node));
    }
    assert_eq!(lattice.node(Cell::new(2, 0)), None);
    assert_eq!(lattice.node(Cell::new(10, 0)), None);
}
