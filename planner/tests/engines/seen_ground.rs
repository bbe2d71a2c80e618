//! Plans over seen ground alone, a reading of the paper.

use contract::{Action, Cell, Direction, Ground, Profile, UnseenGround};
use planner::mdp::Mdp;
use planner::mdp::model::Model;
use planner::payoff::LandingPayoff;
use planner::{PlanStatus, Planner};
use solver::{Hop, Kind, Leaving, Scatter};

use crate::world::{Soils, World, with_treasures};

const READINGS: [UnseenGround; 3] = [UnseenGround::Stays, UnseenGround::Leaves, UnseenGround::Ends];

/// Values of each node by Jacobi iteration from the definition, apart from the planner's own treatment; 0 where nothing is seen.
fn brute_force(world: &World, seen: impl Fn(Cell) -> bool) -> (Model, Vec<f64>) {
    let map = world.seen_where(|index| seen(world.leg.grid.cell(index)));
    let state = world.state(world.leg.start, contract::Decision(0), 0);
    let model = Model::new(&world.situation(&map, &state));
    let (process, rules) = (&model.world, model.world.rules());
    let direction = |cell: Cell| -> f64 {
        let [safety, information, distance] = LandingPayoff::new(&world.leg).terms(cell, &Ground::FLAT);
        safety + information + distance
    };
    let mut values = vec![0.0_f64; process.nodes()];
    loop {
        let worth = |to: usize, from: usize| match (seen(model.lattice.cell(to)), process.kind(to)) {
            (true, Kind::Lost) => rules.loss,
            (true, Kind::Goal) => process.payoff(to),
            (true, Kind::Free) => process.payoff(to) + values[to],
            (false, _) => match world.leg.reading.unseen {
                UnseenGround::Stays => process.payoff(from) + values[from],
                UnseenGround::Leaves => rules.loss,
                // r + γ r + γ² r + …
                UnseenGround::Ends => direction(model.lattice.cell(to)) / (1.0 - rules.discount),
                UnseenGround::Flat => unreachable!(),
            },
        };
        let mut next = values.clone();
        #[allow(clippy::needless_range_loop, reason = "a node has a number in several lists")]
        for node in 0..process.nodes() {
            if process.kind(node) != Kind::Free || !seen(model.lattice.cell(node)) {
                continue;
            }
            let hops = Hop::ALL.map(|hop| {
                let Scatter { intended, stayed, left, right } = process.scatter(node, hop);
                let towards = |hop: Hop| match (process.neighbour(node, hop), rules.leaving) {
                    (Some(to), _) => worth(to, node),
                    (None, Leaving::Stays) => worth(node, node),
                    (None, Leaving::Loses) => rules.loss,
                };
                let sum = intended * towards(hop)
                    + stayed * worth(node, node)
                    + left * towards(hop.left())
                    + right * towards(hop.right());
                let waits = process.soil(node).wait > 0.0;
                rules.discount * if waits { process.payoff(node) + rules.discount * sum } else { sum }
            });
            next[node] = hops.into_iter().fold(f64::NEG_INFINITY, f64::max);
        }
        let most = next.iter().zip(&values).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        values = next;
        if most < 1e-11 {
            return (model, values);
        }
    }
}

/// P-READINGS.
#[test]
fn the_plan_over_seen_ground_has_the_values_of_its_definition() {
    let mut compared = 0;
    for unseen in READINGS {
        for seed in 0..6 {
            let mut world = World::random(seed, Profile::Paper2023);
            world.leg.reading.unseen = unseen;
            world.leg.reading.leaving = [None, Some(-40.0)][seed as usize % 2];
            let (start, grid) = (world.leg.start, world.leg.grid);
            let is_seen = |cell: Cell| cell == start || (cell.x * 5 + cell.y * 3 + seed as i32) % 7 > 2;
            let (model, values) = brute_force(&world, is_seen);
            let map = world.seen_where(|index| is_seen(grid.cell(index)));
            let mut mdp = Mdp::default();
            world.plan(&mut mdp, &map, start);
            // None off the goal's lattice.
            let Some(policy) = mdp.policy() else { continue };
            for (index, policy) in policy.iter().enumerate() {
                let Some(node) = model.lattice.node(grid.cell(index)) else { continue };
                let scale = 1.0 + values[node].abs();
                let (got, need) = (policy.value, values[node]);
                assert!((got - need).abs() < 1e-6 * scale, "{unseen:?}, world {seed}: {got} for {need}");
                compared += usize::from(need != 0.0);
            }
        }
    }
    assert!(compared > 200, "{compared}");
}

/// P-READINGS.
#[test]
fn on_a_map_that_is_seen_whole_all_readings_of_unseen_ground_plan_alike() {
    let mut compared = 0;
    for soils in [Soils::Hard, Soils::Heterogeneous, Soils::Sandy] {
        let mut world = World::paper(soils, [0.5, 0.5], Profile::Paper2023);
        let plans = |world: &World, treasures: &[Cell]| {
            let map = with_treasures(world.seen(), treasures);
            let mut mdp = Mdp::default();
            let cells = world
                .leg
                .grid
                .iter()
                .step_by(23)
                .filter(|cell| *cell != world.leg.goal && !treasures.contains(cell));
            cells.map(|cell| world.plan(&mut mdp, &map, cell).action).collect::<Vec<_>>()
        };
        for treasures in [&[][..], &[Cell::new(12, 4), Cell::new(10, 10)]] {
            world.leg.reading.unseen = UnseenGround::Flat;
            let need = plans(&world, treasures);
            for unseen in READINGS {
                world.leg.reading.unseen = unseen;
                assert_eq!(plans(&world, treasures), need, "{soils:?}, {unseen:?}");
                compared += need.len();
            }
        }
    }
    assert!(compared > 200, "{compared}");
}

/// P-READINGS.
#[test]
fn out_of_sight_of_the_goal_the_distance_leads_there() {
    for unseen in READINGS {
        let mut world = World::flat(30, Cell::new(2, 15), Cell::new(27, 15), Profile::Paper2023);
        world.leg.reading.unseen = unseen;
        let here = Cell::new(10, 15);
        let mut map = world.unseen();
        world.sense(&mut map, here);
        map.mark();
        let plan = world.plan(&mut Mdp::default(), &map, here);
        assert_eq!(plan.status, PlanStatus::Solved, "{unseen:?}");
        if unseen != UnseenGround::Leaves {
            assert_eq!(plan.action, Action::Hop(Direction::East), "{unseen:?}");
        }
        assert_ne!(plan.action, Action::Hold, "{unseen:?}");
    }
}
