//! Times bounded plans on seeded worlds: `cargo run --release -p hopper-solver --example risk -- 20 50 200`.

#![allow(clippy::disallowed_methods, clippy::print_stdout, reason = "an example that measures time")]

use std::time::Instant;

use solver::Leaving;
use solver::fixtures::Fixture;
use solver::risk::{Process, Question, RiskBound, bounded};

fn main() {
    for side in std::env::args().skip(1) {
        let side: usize = side.parse().expect("a side is a number of nodes");
        let fixture = Fixture { leaving: Leaving::Loses, ..Fixture::plain(side, 1) };
        let world = fixture.world().expect("a world of that size");
        let begun = Instant::now();
        let process = Process::of_grid(&world);
        println!("{side}: process of {} places in {:?}", process.places(), begun.elapsed());
        let ask = |bound: f64| {
            let bound = RiskBound::new(bound).expect("a bound");
            let question = Question { node: fixture.start(), bound, charge: 20.0 * side as f64 };
            let begun = Instant::now();
            let sweeps = std::cell::Cell::new(0_u32);
            let plan = bounded(&process, &question, &|| sweeps.set(sweeps.get() + 1))
                .expect("a goal that can be reached");
            println!(
                "  bound {:.3e}: risk {:.6} steps {:.3} cost {:.4} dual {:.4} gap {:.2e} λ {:.4e}, {} solves, {} sweeps, {:?} {:?}",
                bound.get(),
                plan.risk,
                plan.steps,
                plan.cost,
                plan.lower_bound,
                plan.gap() / plan.cost,
                plan.multiplier,
                plan.solves,
                sweeps.get(),
                begun.elapsed(),
                plan.least
            );
            plan.risk
        };
        let free = ask(1.0 - 1e-9);
        for share in [0.9, 0.5, 0.2, 0.05, 1e-2, 1e-4] {
            ask(share * free);
        }
    }
}
