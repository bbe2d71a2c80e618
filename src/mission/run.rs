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
    let brief = Brief { run: journal.header().run(), ..world.brief };
    let mission = Mission { brief, terrain: world.terrain.clone(), seed };
    let mut summary = SummaryBuilder::new(&brief, seed);
    let mut failed = None;
    let flown = lockstep::fly(mission, schedule, &mut Node::now, &mut |record| {
        summary.record(record);
        if let Err(error) = journal.append(record) {
            failed.get_or_insert(error);
        }
    })
    .map_err(|error| Failure::new(Exit::Usage, error.to_string()))?;
    match failed {
        Some(error) => Err(Failure::run(error)),
        None => Ok(summary.build(&flown.state, &flown.refusals)),
    }
}
