//! Plans with a bound on the risk, and their world as a linear program reads it.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use serde_json::{Value, json};
use solver::fixtures::Fixture;
use solver::risk::{Process, Question, RiskBound, bounded};
use solver::{GridWorld, Hop, Kind, Leaving};

/// One node in so many is a hole.
const HOLES_EVERY: u64 = 8;

/// Where between the least risk and that without a bound the bounds lie, geometrically.
const SHARES: [f64; 4] = [0.02, 0.3, 0.6, 0.95];

/// Options of `risk`.
#[derive(Debug, clap::Args)]
pub struct Risk {
    /// Nodes per side of the square world.
    side: usize,
    /// Folder of the world's files.
    folder: PathBuf,
    /// Seed of the world.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Writes the world, plans for several bounds, and says what came out and how long it took.
pub fn plan(args: &Risk) -> Result<Value, Box<dyn Error>> {
    let fixture = Fixture { leaving: Leaving::Loses, ..Fixture::inner(args.side, args.seed) };
    let world = with_holes(&fixture)?;
    let process = Process::of_grid(&world);
    let (node, charge) = (fixture.start(), 20.0 * args.side as f64);
    let place = process.place(node).ok_or("no chain of hops leads from the start to the goal")?;
    fs::create_dir_all(&args.folder)?;
    write_rows(&world, node, &args.folder)?;
    let ask = |bound: f64| -> Result<_, Box<dyn Error>> {
        let question = Question { node, bound: RiskBound::new(bound)?, charge };
        let begun = Instant::now();
        let plan = bounded(&process, &question, &|| ()).ok_or("no plan")?;
        Ok((plan, begun.elapsed().as_secs_f64()))
    };
    let begun = Instant::now();
    let free = process.solve(charge, None, &|| ());
    let free_s = begun.elapsed().as_secs_f64();
    drop(free);
    let most = ask(1.0 - f64::EPSILON)?.0.risk;
    let least = ask(1e-9)?.0.least.map_or(1e-9, |least| least.at_most);
    let mut answers = Vec::new();
    for share in SHARES {
        let bound = least * (most / least).powf(share);
        let (plan, seconds) = ask(bound)?;
        answers.push(json!({
            "bound": bound,
            "cost": plan.cost,
            "dual": plan.lower_bound,
            "steps": plan.steps,
            "risk": plan.risk,
            "multiplier": plan.multiplier,
            "solves": plan.solves,
            "seconds": seconds,
            "feasible": plan.is_feasible(),
        }));
    }
    Ok(json!({
        "side": args.side,
        "places": process.places(),
        "start": place,
        "charge": charge,
        "free_seconds": free_s,
        "least": least,
        "most": most,
        "answers": answers,
    }))
}

/// The world of `fixture` with holes that depend on its seed, none at the start or the goal.
fn with_holes(fixture: &Fixture) -> Result<GridWorld, Box<dyn Error>> {
    let mut world = fixture.world()?;
    let mut state = fixture.seed ^ 0x5851_f42d_4c95_7f2d;
    for node in 0..world.nodes() {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let is_hole = (state >> 33).is_multiple_of(HOLES_EVERY);
        if is_hole && node != fixture.start() && world.kind(node) == Kind::Free {
            world.set(node, solver::Site { kind: Kind::Lost, ..world.site(node) });
        }
    }
    Ok(world)
}

/// Four rows a node, whatever its kind: `to` has four landings a row, −1 where it ends at a goal and −2 where it is lost.
///
/// It is written from the world's slope law, not from the process that plans are made with.
fn write_rows(world: &GridWorld, start: usize, folder: &Path) -> Result<(), Box<dyn Error>> {
    let (mut to, mut probabilities, mut steps) = (Vec::new(), Vec::new(), Vec::new());
    for node in 0..world.nodes() {
        for hop in Hop::ALL {
            let scatter = world.scatter(node, hop);
            let landings = [
                (world.neighbour(node, hop), scatter.intended),
                (Some(node), scatter.stayed),
                (world.neighbour(node, hop.left()), scatter.left),
                (world.neighbour(node, hop.right()), scatter.right),
            ];
            for (at, probability) in landings {
                let ends = match at.map(|at| (at, world.kind(at))) {
                    Some((_, Kind::Goal)) => -1,
                    None | Some((_, Kind::Lost)) => -2,
                    Some((at, Kind::Free)) => at as i32,
                };
                to.extend(ends.to_le_bytes());
                probabilities.extend(probability.to_le_bytes());
            }
            // Two steps a hop, and one more for an intended hop that takes two periods.
            steps.extend((2.0 + world.soil(node).wait * scatter.intended).to_le_bytes());
        }
    }
    let free: Vec<u8> = (0..world.nodes()).map(|node| u8::from(world.kind(node) == Kind::Free)).collect();
    fs::write(folder.join("to.i32"), to)?;
    fs::write(folder.join("probabilities.f64"), probabilities)?;
    fs::write(folder.join("steps.f64"), steps)?;
    fs::write(folder.join("free.u8"), free)?;
    fs::write(folder.join("start.json"), json!({ "start": start }).to_string())?;
    Ok(())
}
