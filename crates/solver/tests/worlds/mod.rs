//! Random worlds, and their exact solutions.

use nalgebra::{DMatrix, DVector};
use solver::specimen::{DISCOUNT, Draw, HARD, SAND, Specimen};
use solver::{Hop, Kind, Leaving, Rules, Site, Soil, World, action_values};

/// A small world with everything in it: both ways of leaving, several soils and goals or none, walls, steep
/// slopes, odd shapes.
pub fn random(seed: u64) -> World {
    let mut draw = Draw(seed);
    let sides = [1, 2, 3, 5, 7, 11, 13, 16, 17, 23];
    let mut side = || sides[(draw.uniform() * sides.len() as f64) as usize];
    let (width, height) = (side(), side());
    let leaving = if draw.uniform() < 0.5 { Leaving::Stays } else { Leaving::Loses };
    let discount = [DISCOUNT, 0.9, 0.999, 0.0][(draw.uniform() * 4.0) as usize];
    let between = Soil::mixture(&[(0.25, HARD), (0.75, SAND)], discount);
    let stuck = Soil { intended: 0.1, stuck: 0.9, sideways: 0.0, wait: 0.0 };
    let loss = draw.between(-2000.0, 0.0);
    let soils = vec![HARD, SAND, between, stuck];
    let mut world = World::new(width, height, Rules { discount, loss, leaving, soils }).unwrap();
    let flat = draw.uniform() < 0.2;
    let walls = draw.between(0.0, 0.4);
    let (low, high) = (draw.between(-10.0, 0.0), draw.between(0.0, 10.0));
    for node in 0..world.nodes() {
        let kind = match draw.uniform() {
            share if share < walls => Kind::Lost,
            share if share > 0.97 => Kind::Goal,
            _ => Kind::Free,
        };
        let payoff = if kind == Kind::Goal { 100.0 } else { draw.between(low, high) };
        let slope = if flat { 0.0 } else { 1.2 };
        let (slope_east, slope_north) = (draw.between(-slope, slope), draw.between(-slope, slope));
        let soil = (draw.uniform() * 4.0) as u8;
        world.set(node, Site { kind, payoff, slope_east, slope_north, soil });
    }
    world
}

/// Small worlds of hills, traps among them.
pub fn hills(seed: u64) -> World {
    let specimen = match seed % 4 {
        0 | 1 => Specimen::plain(7 + (seed % 9) as usize, seed),
        _ => Specimen::trap(7 + (seed % 9) as usize, seed),
    };
    let leaving = if seed.is_multiple_of(2) { Leaving::Stays } else { Leaving::Loses };
    Specimen { leaving, ..specimen }.world().unwrap()
}

/// V* by policy iteration, each policy evaluated by a dense linear solve.
pub fn exact(world: &World) -> Vec<f64> {
    let mut policy = vec![Hop::North; world.nodes()];
    for _ in 0..200 {
        let values = evaluate(world, &policy);
        let mut changed = false;
        for node in (0..world.nodes()).filter(|&node| world.kind(node) == Kind::Free) {
            let worth = action_values(world, &values, node);
            let best = Hop::ALL.into_iter().max_by(|&a, &b| worth[a as usize].total_cmp(&worth[b as usize]));
            let best = best.unwrap();
            if worth[best as usize] > worth[policy[node] as usize] + 1e-10 {
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

fn evaluate(world: &World, policy: &[Hop]) -> Vec<f64> {
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
