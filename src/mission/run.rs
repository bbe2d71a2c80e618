//! A mission flown by one thread, without shared memory.

use contract::{Action, Brief};
use hopper_sim::{Journal, Mission};
use node::{Exit, Failure, Node};
use report::{Summary, SummaryBuilder};
use scenario::ResolvedScenario;

use super::OutputDir;
use lockstep::PlannerSchedule;

/// Flies `world` with `seed` in this thread, into the `journal` of the folder.
///
/// # Errors
/// If the output folder holds a mission already, or cannot be written.
pub fn in_lockstep(
    world: &ResolvedScenario,
    seed: u64,
    schedule: &PlannerSchedule,
    output_dir: &OutputDir,
    mut journal: Journal,
) -> Result<Summary, Failure> {
    if !journal.is_empty() {
        return Err(Failure::new(
            Exit::Usage,
            format!(
                "--lockstep needs a fresh output folder, got {} with {} decisions: name another with --out",
                output_dir.dir().display(),
                journal.len()
            ),
        ));
    }
    output_dir.describe(world, seed)?;
    let brief = Brief { run: journal.header().run(), ..world.brief.clone() };
    let mission =
        Mission { brief: brief.clone(), terrain: world.terrain.clone(), seed, faults: world.faults.clone() };
    let mut summary = SummaryBuilder::new(&brief, seed);
    let mut failed = None;
    // What announces a route is written once the routes are known: with the mission's end.
    let mut unwritten = Vec::new();
    let flown = lockstep::fly(mission, schedule, &mut Node::now, &mut |record| {
        summary.record(record);
        if brief.has_routes() {
            unwritten.push(*record);
        } else if let Err(error) = journal.append(record) {
            failed.get_or_insert(error);
        }
    })
    .map_err(|error| Failure::new(Exit::Usage, error.to_string()))?;
    for record in &unwritten {
        let route = flown.routes.iter().find(|route| record.action == Action::Announce(route.id()));
        let appended = match route {
            Some(route) => journal.append_announced(record, route),
            None => journal.append(record),
        };
        appended.map_err(Failure::run)?;
    }
    match failed {
        Some(error) => Err(Failure::run(error)),
        None => Ok(summary.build(&flown.state, flown.team.as_ref(), &flown.refusals)),
    }
}
