//! Missions as figures: their states side by side, and their ends under three weightings.

use contract::Status;
use hopper::mission::Snapshot;
use node::Failure;
use report::PictureGrid;

use super::flight::Flight;
use super::{Figure, SEED};

/// A world of Sakamoto & Kunii 2023.
#[derive(Clone, Copy, Debug)]
pub struct World {
    /// Name of the built-in scenario.
    pub scenario: &'static str,
    /// The world's name as headings spell it.
    pub name: &'static str,
    /// Its ground in words.
    ground: &'static str,
}

/// The worlds, in the paper's order.
pub const WORLDS: &[World] = &[
    World { scenario: "hard", name: "Hard ground", ground: "hills and hollows, no sand" },
    World {
        scenario: "heterogeneous",
        name: "Heterogeneous ground",
        ground: "the same hills with a rectangle of sand in the way",
    },
    World {
        scenario: "sandy",
        name: "Sandy ground",
        ground: "the same hills, sand wherever the ground is below 0.1 m",
    },
    World {
        scenario: "large",
        name: "The large map",
        ground: "50 × 50 cells, our hills and sand, since the paper's are in a figure only",
    },
    World {
        scenario: "treasures",
        name: "Treasure hunting",
        ground: "hard ground with four treasures, each known once seen and collected once",
    },
];

/// Algorithms and what they are called.
const PLANNERS: [(&str, &str); 2] = [("mdp", "MDP"), ("greedy", "Greedy")];
/// The paper's three columns: w1 of safety, w2 of information.
const WEIGHTS: [[f64; 2]; 3] = [[1.0, 0.0], [0.5, 0.5], [0.0, 1.0]];

/// Initial, halfway and final states of both planners.
///
/// # Errors
/// If the scenario cannot be flown.
pub fn states(world: &World) -> Result<Figure, Failure> {
    let flights: Vec<Flight> = PLANNERS
        .iter()
        .map(|(planner, _)| Flight::new(world.scenario, planner, None))
        .collect::<Result<_, _>>()?;
    let snapshots = |flight: &Flight| [0, flight.hops() / 2, flight.hops()].map(|hops| flight.snapshot(hops));
    let snapshots: Vec<[Snapshot; 3]> = flights.iter().map(snapshots).collect();
    let mut views = Vec::new();
    for ((_, name), (flight, snapshots)) in PLANNERS.iter().zip(flights.iter().zip(&snapshots)) {
        for snapshot in snapshots {
            let what = match snapshot.hops {
                0 => "before the first hop".to_owned(),
                hops if hops < flight.hops() => format!("after {hops} of {} hops", flight.hops()),
                _ => ending(snapshot),
            };
            let seen = 100.0 * snapshot.map.coverage();
            views.push(flight.view(snapshot, format!("{name}: {what}, {seen:.0} % seen")));
        }
    }
    let title = format!("{}: initial, halfway and final states", world.name);
    let caption = format!("{}; w1 = 0.5, w2 = 0.5, profile paper-2023, seed {SEED}", world.ground);
    let grid = PictureGrid { title: title.clone(), caption, columns: 3, views };
    Ok(Figure {
        name: format!("states-{}", world.scenario),
        title,
        text: format!(
            "In the manner of the figures of Sakamoto & Kunii 2023 ({}). Above the MDP, whose policy before \
             each hop covers the whole map; below the greedy planner, which sees no further than the next cell.",
            world.ground
        ),
        svg: grid.svg().map_err(Failure::run)?,
    })
}

/// Final states of both planners under the three weightings.
///
/// # Errors
/// If the scenario cannot be flown.
pub fn weights(world: &World) -> Result<Figure, Failure> {
    let mut flights = Vec::new();
    for (planner, name) in PLANNERS {
        for weights in WEIGHTS {
            flights.push((name, weights, Flight::new(world.scenario, planner, Some(weights))?));
        }
    }
    let snapshots: Vec<Snapshot> =
        flights.iter().map(|(_, _, flight)| flight.snapshot(flight.hops())).collect();
    let views = flights.iter().zip(&snapshots).map(|((name, [safety, information], flight), snapshot)| {
        flight.view(snapshot, format!("{name}, w = ({safety}, {information}): {}", ending(snapshot)))
    });
    let title = format!("{}: three weightings", world.name);
    let caption = format!("{}; final states, w = (w1, w2), profile paper-2023, seed {SEED}", world.ground);
    let grid = PictureGrid { title: title.clone(), caption, columns: 3, views: views.collect() };
    Ok(Figure {
        name: format!("weights-{}", world.scenario),
        title,
        text:
            "From safety alone, w = (1, 0), on the left to information alone, w = (0, 1), on the right; one \
               mission each, the figure after it tells how a hundred end."
                .into(),
        svg: grid.svg().map_err(Failure::run)?,
    })
}

fn ending(snapshot: &Snapshot) -> String {
    let steps = snapshot.steps;
    match snapshot.outcome {
        Status::Goal => format!("goal in {steps} steps"),
        Status::LeftMap => format!("off the map at step {steps}"),
        Status::Lost => format!("lost at step {steps}"),
        Status::Deadlock => format!("deadlock, {steps} steps"),
        Status::Underway => format!("{steps} steps"),
    }
}
