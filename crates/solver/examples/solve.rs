//! Solves a world with a hill in the way, and prints the hop at each node: `cargo run --release --example solve`.

#![allow(clippy::print_stdout, reason = "an example shows its result")]

use solver::{Effort, Error, GridWorld, Hop, Kind, Leaving, Rules, Site, Soil, Solver, policy};

const WIDTH: usize = 24;
const HEIGHT: usize = 12;

fn main() -> Result<(), Error> {
    let hard = Soil { intended: 0.9, stuck: 0.0, sideways: 0.05, wait: 0.0 };
    let rules = Rules { discount: 0.99, loss: -100.0, leaving: Leaving::Loses, soils: vec![hard] };
    let mut world = GridWorld::new(WIDTH, HEIGHT, rules)?;
    for node in 0..world.nodes() {
        let (x, y) = ((node % WIDTH) as f64 - 12.0, (node / WIDTH) as f64 - 5.0);
        // The slopes of a bell of height 4 and breadth 3 nodes, as shares of the slope limit.
        let fall = -4.0 / 9.0 * (-(x * x + y * y) / 18.0).exp();
        // The steeper, the worse.
        let payoff = fall * x.hypot(y);
        world.set(
            node,
            Site { kind: Kind::Free, payoff, slope_east: x * fall, slope_north: y * fall, soil: 0 },
        );
    }
    let goal = 6 * WIDTH + 22;
    world.set(goal, Site { kind: Kind::Goal, payoff: 100.0, ..world.site(goal) });

    let mut solver = Solver::new();
    let solution = solver.solve(&world, &Effort { error_max: 1e-6, sweeps_max: u64::MAX });
    for y in (0..HEIGHT).rev() {
        let row = (0..WIDTH).map(|x| letter(policy::hop(&world, solver.values(), y * WIDTH + x, 0.0)));
        println!("{}", row.collect::<String>());
    }
    println!(
        "in error by at most {:.1e}, after {} sweeps",
        solution.certificate.error_bound, solution.sweeps
    );
    Ok(())
}

fn letter(hop: Option<Hop>) -> char {
    match hop {
        Some(Hop::North) => '^',
        Some(Hop::East) => '>',
        Some(Hop::South) => 'v',
        Some(Hop::West) => '<',
        None => 'G',
    }
}
