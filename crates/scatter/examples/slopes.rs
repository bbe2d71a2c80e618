//! Prints how a slope changes where a hop lands: `cargo run --example slopes`.

#![allow(clippy::print_stdout, reason = "an example shows its result")]

use scatter::{FlatScatter, slope_in_limits};

fn main() {
    let sand = FlatScatter { intended: 0.7, stuck: 0.1, sideways: 0.1 };
    println!("uphill   intended  stays  left  right");
    for degrees in [0, 5, 10, 15, 20, 25, 30] {
        let slope = slope_in_limits(f64::from(degrees).to_radians().tan(), 30_f64.to_radians());
        let landing = sand.on_slope(slope, 0.0);
        println!(
            "{degrees:4}°    {:8.2} {:6.2} {:5.2} {:6.2}",
            landing.intended, landing.stayed, landing.left, landing.right
        );
    }
}
