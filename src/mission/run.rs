//! A mission flown by one thread, without shared memory.

use contract::Brief;
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
    let mission = Mission { brief: brief.clone(), ..Mission::of(world, seed) };
    let mut summary = SummaryBuilder::new(&brief, seed);
    let mut failed = None;
    // What names a route or a detail is written once those are known: with the mission's end.
    let mut unwritten = Vec::new();
    let flown = lockstep::fly(mission, schedule, &mut Node::now, &mut |record| {
        summary.record(record);
        if brief.has_routes() || !record.detail.is_none() {
            unwritten.push(*record);
        } else if let Err(error) = journal.append(record, None) {
            failed.get_or_insert(error);
        }
    })
    .map_err(|error| Failure::new(Exit::Usage, error.to_string()))?;
    for record in &unwritten {
        journal.append(record, flown.attachment(record).as_ref()).map_err(Failure::run)?;
    }
    match failed {
        Some(error) => Err(Failure::run(error)),
        None => Ok(summary.build(&flown.state, flown.team.as_ref(), &flown.refusals)),
    }
}
