//! How good the rover's routes are on the worlds of the study, beside a bound that no route can pass.

use p21::{Samples, monte_carlo};
use routing::{ett_exact, lower_bound, rrt_star_ett};
use rover::Caution;

/// P-ROUTE-GAP: On worlds of the study `ett_exact` is within 4 % of the proven bound, and RRT* is
/// not below it.
#[test]
fn the_exact_search_is_close_to_a_proven_bound_and_rrt_star_is_not_below_it() {
    for seed in 1..=4 {
        let world = monte_carlo(seed);
        let costs = world.prior.expected_time(Caution::default());
        let bound = lower_bound(&costs, &world.trip);
        let exact = ett_exact(&costs, &world.trip, 0.0).unwrap().cost;
        let sampled = rrt_star_ett(&costs, &world.trip, Samples::MONTE_CARLO.rover, seed).unwrap().cost;
        println!("world {seed}: bound {bound:.4}, exact {exact:.4}, RRT* {sampled:.4} Sol");
        assert!(bound <= exact && exact <= 1.04 * bound, "{exact} against a bound of {bound}");
        assert!(bound <= sampled && exact <= 1.001 * sampled, "{exact} against RRT* with {sampled}");
    }
}
