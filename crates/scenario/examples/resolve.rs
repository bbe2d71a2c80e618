//! Prints a scenario with every default filled in: `cargo run --example resolve -- NAME|FILE`.

#![allow(clippy::print_stdout, reason = "an example shows its result")]

fn main() -> Result<(), scenario::ScenarioError> {
    let selector = std::env::args().nth(1).unwrap_or_else(|| "hard".into());
    let world = scenario::load(&selector)?.resolve()?;
    println!("{}", world.resolved);
    for warning in world.warnings {
        println!("# {warning}");
    }
    Ok(())
}
