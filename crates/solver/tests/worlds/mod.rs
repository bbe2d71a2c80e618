//! Random worlds for tests of the solver.

use solver::fixtures::{DISCOUNT, Fixture, GoalPlace, HARD, SAND, SplitMix64};
use solver::{GridWorld, Kind, Leaving, Rules, Site, Soil};

/// A small world with everything in it: both ways of leaving, several soils and goals or none, walls, steep
/// slopes, narrow shapes.
pub fn random(seed: u64) -> GridWorld {
    let mut draw = SplitMix64(seed);
    let sides = [1, 2, 3, 5, 7, 11, 13, 16, 17, 23];
    let mut side = || sides[(draw.uniform() * sides.len() as f64) as usize];
    let (width, height) = (side(), side());
    let leaving = if draw.uniform() < 0.5 { Leaving::Stays } else { Leaving::Loses };
    let discount = [DISCOUNT, 0.9, 0.999, 0.0][(draw.uniform() * 4.0) as usize];
    let between = Soil::mixture(&[(0.25, HARD), (0.75, SAND)], discount);
    let stuck = Soil { intended: 0.1, stuck: 0.9, sideways: 0.0, wait: 0.0 };
    let loss = draw.between(-2000.0, 0.0);
    let soils = vec![HARD, SAND, between, stuck];
    let mut world =
        GridWorld::new(width, height, Rules { discount, loss, leaving, soils }).expect("a sound world");
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
pub fn hills(seed: u64) -> GridWorld {
    let fixture = match seed % 4 {
        0 | 1 => Fixture::plain(7 + (seed % 9) as usize, seed),
        _ => Fixture::trap(7 + (seed % 9) as usize, seed),
    };
    let leaving = if seed.is_multiple_of(2) { Leaving::Stays } else { Leaving::Loses };
    Fixture { leaving, ..fixture }.world().expect("a sound world")
}

/// Worlds whose goal lies well inside, traps among them.
pub fn inside(seed: u64) -> GridWorld {
    let (width, height) = (34 + (seed % 17) as usize, 34 + (seed % 13) as usize);
    let fixture = if seed % 4 < 2 { Fixture::plain(1, seed) } else { Fixture::trap(1, seed) };
    let leaving = if seed.is_multiple_of(2) { Leaving::Stays } else { Leaving::Loses };
    Fixture { width, height, leaving, place: GoalPlace::Inside, ..fixture }.world().expect("a sound world")
}
