//! `hopper campaign run`: flies every trial of a shard, missions in lockstep, and writes the rows in order.

use std::path::Path;

use ::campaign::row::TrialResult;
use ::campaign::{Campaign, Plan, Row, Trial};
use contract::{Account, Action, Brief, Name, RunId};
use hopper_sim::Mission;
use node::{Exit, Failure, Node};
use scenario::ResolvedScenario;
use scenario::text::{self, TEXT_BYTES_MAX};

use super::built_in::BUILT_IN;
use super::run_args::Args;
use super::store::{self, Times};
use super::trials;
use lockstep::PlannerSchedule;

/// Flies a campaign of missions; exit code 130 if interrupted, with all rows kept that were complete up to then.
///
/// # Errors
/// Exit code 2 if the campaign, a flag or the folder is wrong.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let plan = plan(&args.file)?;
    let worlds =
        plan.cells.iter().map(|cell| cell.world()).collect::<Result<Vec<_>, _>>().map_err(Failure::usage)?;
    for (cell, world) in plan.cells.iter().zip(&worlds) {
        schedule(world, &cell.planner)?;
    }
    // Of a campaign of one's own the paper says nothing.
    let paper_s = plan.cells.iter().map(p23::cell_episode_s).collect::<Option<_>>().unwrap_or_default();
    let missions = Missions { plan: plan.clone(), worlds, paper_s };
    trials::run(args, plan, missions)
}

/// The missions of a grid.
struct Missions {
    plan: Plan,
    worlds: Vec<ResolvedScenario>,
    /// Time the paper reports for a mission of each cell, seconds; nothing if a cell is not the paper's.
    paper_s: Vec<f64>,
}

impl trials::Flight for Missions {
    type Plan = Plan;

    fn fly(&self, number: u64) -> Result<(Row, Times), Failure> {
        let trial = self.plan.trial(number).expect("a trial of the plan");
        fly(&self.plan, &self.worlds[trial.cell.number as usize], &trial)
    }

    fn paper_s(&self, row: &Row) -> f64 {
        usize::try_from(row.cell).ok().and_then(|cell| self.paper_s.get(cell)).copied().unwrap_or(0.0)
    }
}

/// The text of a built-in campaign or a campaign file.
///
/// # Errors
/// Exit code 2 if there is neither.
pub fn text(file: &Path) -> Result<String, Failure> {
    let built_in = BUILT_IN.into_iter().find(|(name, _)| Path::new(name) == file);
    match built_in {
        Some((_, text)) => Ok(text.to_owned()),
        None if !file.exists() => {
            let names = BUILT_IN.map(|(name, _)| name);
            let (meant, file) = (text::meant(file, &names), file.display());
            Err(Failure::usage(match meant.as_str() {
                "" => format!("{file}: need a campaign file or one of {}, found neither", names.join(", ")),
                meant => format!("{file}: need a campaign, found none{meant}"),
            }))
        }
        None => text::read(file, TEXT_BYTES_MAX).map_err(Failure::usage),
    }
}

/// An error of the campaign in `file`, which names it.
pub fn refused(file: &Path, error: &::campaign::CampaignError) -> Failure {
    match error {
        ::campaign::CampaignError::Toml { .. } => Failure::usage(error),
        error => Failure::usage(format!("{}: {error}", file.display())),
    }
}

/// The plan of a built-in campaign or a campaign file, planners checked.
fn plan(file: &Path) -> Result<Plan, Failure> {
    let campaign =
        Campaign::parse(&text(file)?, &file.display().to_string()).map_err(|error| refused(file, &error))?;
    // Campaigns fly in lockstep, so the clairvoyant is allowed.
    for name in campaign.planners.iter().filter(|name| *name != planner::CLAIRVOYANT) {
        planner::algorithm(name)
            .map_err(|error| Failure::usage(format!("{}: planners: {error}", file.display())))?;
    }
    let folder = file.parent().unwrap_or(Path::new(""));
    campaign.plan(folder, store::VERSION).map_err(|error| refused(file, &error))
}

/// Who commands the robots of `world` if `planner` is given: the robots that it does not suit keep their own.
///
/// # Errors
/// If it suits none of them.
pub(super) fn schedule(world: &ResolvedScenario, planner: &str) -> Result<PlannerSchedule, Failure> {
    let given: Name = planner.parse().map_err(Failure::usage)?;
    let scenario = world.brief.scenario;
    let planners = planner::assigned(&world.brief, Some(given), &world.planners)
        .map_err(|error| Failure::usage(error.in_scenario(scenario)))?;
    Ok(if world.brief.has_team() {
        PlannerSchedule::of_robots(&planners)
    } else {
        PlannerSchedule::single(given)
    })
}

/// Flies one trial in lockstep. The row depends on plan and trial only.
///
/// # Errors
/// If the planner of the trial is unknown.
pub fn fly(plan: &Plan, world: &ResolvedScenario, trial: &Trial<'_>) -> Result<(Row, Times), Failure> {
    let brief = Brief { run: RunId(1), ..world.brief.clone() };
    let mission = Mission { brief: brief.clone(), ..Mission::of(world, trial.seed) };
    let schedule = schedule(world, &trial.cell.planner)?;
    let (mut hops, mut planning_ns) = (0, 0);
    let started = Node::now();
    let flown = lockstep::fly(mission, &schedule, &mut Node::now, &mut |record| {
        let is_hop = record.action.hop().is_some();
        hops +=
            u64::from(if brief.account == Account::Hopper { is_hop } else { record.action != Action::Hold });
        planning_ns += record.timing.planning_ended.since_ns(record.timing.planning_started);
    })
    .map_err(Failure::usage)?;
    let episode_ns = Node::now().since_ns(started);
    let ending = TrialResult {
        outcome: flown.state.status,
        steps: flown.state.steps,
        hops,
        treasures: flown.state.collected.count(),
        coverage: flown.map.coverage(),
        digest: flown.state.digest,
    };
    let seconds = |ns: u64| ns as f64 / 1e9;
    let times =
        Times { trial: trial.number, planning_s: seconds(planning_ns), episode_s: seconds(episode_ns) };
    Ok((Row::new(plan, trial, ending), times))
}
