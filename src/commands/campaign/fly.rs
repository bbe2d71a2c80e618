//! `hopper campaign run`: flies every trial of a shard in lockstep, and writes the rows in order.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, mpsc};
use std::time::Duration;

use ::campaign::row::TrialResult;
use ::campaign::{BUILT_IN, Campaign, Plan, Row, Shard, Trial, paper};
use contract::{Action, Brief, Name, RunId};
use hopper_sim::Mission;
use node::{Exit, Failure, Node, ShutdownSignal};
use report::Format;
use scenario::ResolvedScenario;
use scenario::text::{self, TEXT_BYTES_MAX};
use serde::Serialize;

use super::progress::Progress;
use super::store::{self, Manifest, Store, Times};
use crate::stdout::print;
use lockstep::PlannerSchedule;

/// Trials per job that may be flown ahead of the next row: bounds the rows held in memory.
const AHEAD_PER_JOB: u64 = 32;

/// Pause between two writes to the files, nanoseconds: a kill loses no more than the rows of this time.
const FLUSH_NS: u64 = 500_000_000;

/// Longest wait for a row before checking whether to stop.
const TICK: Duration = Duration::from_millis(50);

/// Rows are gathered for so long before they are kept; a thread flies some five ordinary missions meanwhile.
const GATHER: Duration = Duration::from_millis(3);

/// Arguments of `hopper campaign run`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// The campaign: a TOML file, or the name of a built-in one; see `hopper campaign list`.
    #[arg(value_name = "NAME|FILE")]
    file: PathBuf,
    /// Threads to fly on [default: one per core].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=4096))]
    jobs: Option<u16>,
    /// Fly the I-th of N equal parts only, I from 1 to N.
    #[arg(long, value_name = "I/N", default_value = "1/1")]
    shard: Shard,
    /// Continue where an earlier run into the same folder ended.
    #[arg(long)]
    resume: bool,
    /// Folder for the rows [default: out/NAME, or out/NAME-I-of-N for a shard].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Format of the summary on standard output: text or json.
    #[arg(long, default_value_t)]
    format: Format,
}

/// The answer; field names are those of the JSON. Times are of this machine.
#[derive(Clone, Debug, Serialize)]
pub struct Run {
    /// Folder with the rows.
    pub out: PathBuf,
    /// Part of the campaign that was flown.
    pub shard: Shard,
    /// Trials in the folder.
    pub trials: u64,
    /// Trials flown by this run.
    pub flown: u64,
    /// Threads that flew missions side by side.
    pub jobs: usize,
    /// Time the run took, seconds.
    pub wall_s: f64,
    /// Trials flown per second.
    pub episodes_per_s: f64,
    /// Time the paper reports for the same trials, seconds; 0 for a campaign with cells that the paper does not have.
    pub paper_s: f64,
    /// How many times faster than the paper: `paper_s` over `wall_s`.
    pub paper_ratio: Option<f64>,
    /// Commit that this program was built from.
    pub commit: &'static str,
    /// Model name of the processor.
    pub processor: String,
}

/// Flies the campaign; exit code 130 if interrupted, with all rows kept that were complete up to then.
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
    let jobs =
        args.jobs.map_or_else(|| std::thread::available_parallelism().map_or(1, usize::from), usize::from);
    let out = args.out.clone().unwrap_or_else(|| default_folder(&plan, args.shard));
    let manifest = Manifest { shard: args.shard, plan };
    let mut store = Store::open(&out, &manifest, args.resume)?;
    let (shard, plan) = (args.shard, &manifest.plan);
    let due = shard.len(plan.trials());
    let held = store.done();
    let started = Node::now();
    let Some(paper_s) = fly_all(&manifest, worlds, jobs, &mut store)? else {
        tracing::warn!(
            "interrupted: {} of {due} trials are kept in {}; the same command with --resume continues",
            store.done(),
            out.display()
        );
        return Ok(Exit::Interrupted);
    };

    let wall_s = Node::now().since_ns(started) as f64 / 1e9;
    let flown = due - held;
    let run = Run {
        out,
        shard,
        trials: due,
        flown,
        jobs,
        wall_s,
        episodes_per_s: if flown > 0 { flown as f64 / wall_s } else { 0.0 },
        paper_s,
        paper_ratio: (paper_s > 0.0).then(|| paper_s / wall_s),
        commit: crate::COMMIT,
        processor: node::host::processor(),
    };
    store.keep(&run)?;
    print(&match args.format {
        Format::Json => serde_json::to_string(&run).map_err(Failure::run)? + "\n",
        Format::Text => run.text(),
    })?;
    Ok(Exit::Done)
}

impl Run {
    fn text(&self) -> String {
        let Self { out, trials, flown, jobs, wall_s, episodes_per_s, .. } = self;
        if *flown == 0 {
            return format!("Nothing left to fly: {} holds all {trials} trials.\n", out.display());
        }
        let mut text = format!(
            "{flown} episodes in {wall_s:.1} s on {jobs} {}: {episodes_per_s:.0} episodes/s.\n",
            if *jobs == 1 { "thread" } else { "threads" }
        );
        if let Some(ratio) = self.paper_ratio {
            text += &format!(
                "The paper's machine would have needed {}: {ratio:.0} times as long.\n",
                long(self.paper_s)
            );
        }
        text + &format!("{trials} rows in {}; see: hopper campaign report {}\n", out.display(), out.display())
    }
}

/// A duration in the unit that fits it.
fn long(duration_s: f64) -> String {
    if duration_s < 100.0 { format!("{duration_s:.1} s") } else { format!("{:.1} h", duration_s / 3600.0) }
}

/// Flies what is missing in `store`, rows in order, and returns what the paper's machine would have needed, in
/// seconds; `None` if interrupted. Trials under way are then left as they are: they end with the process.
fn fly_all(
    manifest: &Manifest,
    worlds: Vec<ResolvedScenario>,
    jobs: usize,
    store: &mut Store,
) -> Result<Option<f64>, Failure> {
    let shutdown = ShutdownSignal::new()?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(jobs)
        // The panic is logged already; the trial will never arrive.
        .panic_handler(|_| std::process::exit(101))
        .build()
        .map_err(Failure::run)?;
    let (shard, plan) = (manifest.shard, Arc::new(manifest.plan.clone()));
    let worlds: Arc<[ResolvedScenario]> = worlds.into();
    let due = shard.len(plan.trials());
    // Of a campaign of one's own the paper says nothing.
    let paper_s_of: Vec<f64> =
        plan.cells.iter().map(paper::cell_episode_s).collect::<Option<_>>().unwrap_or_default();
    let mut progress = Progress::begin(due, store.done(), Node::now());
    if store.done() < due {
        tracing::info!(
            "{} of {due} trials are in the folder; flying the others on {jobs} threads",
            store.done()
        );
    }
    let (landed, flown) = mpsc::channel();
    let (mut begun, mut early) = (store.done(), BTreeMap::new());
    let (mut flushed, mut paper_s) = (Node::now(), 0.0);
    while store.done() < due {
        let last = due.min(store.done() + AHEAD_PER_JOB * jobs as u64);
        for index in begun..last {
            let (plan, worlds, landed) = (Arc::clone(&plan), Arc::clone(&worlds), landed.clone());
            pool.spawn(move || {
                let number = shard.nth(index, plan.trials());
                let trial = number.and_then(|number| plan.trial(number)).expect("every index has a trial");
                // Fails only after an interruption.
                let _ = landed.send((index, fly(&plan, &worlds[trial.cell.number as usize], &trial)));
            });
        }
        begun = last;
        // Not row by row: to be woken for each costs more than to keep it.
        std::thread::sleep(GATHER);
        early.extend(flown.recv_timeout(TICK));
        early.extend(flown.try_iter());
        while let Some(row) = early.remove(&store.done()) {
            let (row, times) = row?;
            paper_s += usize::try_from(row.cell).ok().and_then(|cell| paper_s_of.get(cell)).unwrap_or(&0.0);
            store.append(&row, &times)?;
        }
        let now = Node::now();
        if now.since_ns(flushed) >= FLUSH_NS || store.done() == due {
            flushed = now;
            store.flush()?;
        }
        progress.show(store.done(), now);
        if shutdown.stop_reason().is_some() {
            progress.end();
            store.flush()?;
            return Ok(None);
        }
    }
    progress.end();
    Ok(Some(paper_s))
}

/// The plan of a built-in campaign or a campaign file, planners checked.
fn plan(file: &Path) -> Result<Plan, Failure> {
    let built_in = BUILT_IN.into_iter().find(|(name, _)| Path::new(name) == file);
    let text = match built_in {
        Some((_, text)) => text.to_owned(),
        None if !file.exists() => {
            let names = BUILT_IN.map(|(name, _)| name).join(", ");
            let file = file.display();
            return Err(Failure::usage(format!(
                "{file} cannot be read: need a campaign file or one of {names}, got no such file"
            )));
        }
        None => text::read(file, TEXT_BYTES_MAX).map_err(Failure::usage)?,
    };
    let at = |error: &dyn std::fmt::Display| Failure::usage(format!("{}: {error}", file.display()));
    let campaign = Campaign::parse(&text, &file.display().to_string()).map_err(|error| match error {
        error @ ::campaign::CampaignError::Toml { .. } => Failure::usage(error),
        error => at(&error),
    })?;
    // Campaigns fly in lockstep, so the clairvoyant is allowed.
    for name in campaign.planners.iter().filter(|name| *name != planner::CLAIRVOYANT) {
        planner::algorithm(name).map_err(|error| at(&format!("planners: {error}")))?;
    }
    let folder = file.parent().unwrap_or(Path::new(""));
    campaign.plan(folder, store::VERSION).map_err(|error| at(&error))
}

/// Who commands the robots of `world` if `planner` is given: the robots that it does not suit keep their own.
///
/// # Errors
/// If it suits none of them.
fn schedule(world: &ResolvedScenario, planner: &str) -> Result<PlannerSchedule, Failure> {
    let given: Name = planner.parse().map_err(Failure::usage)?;
    let scenario = world.brief.scenario;
    let planners = planner::assigned(&world.brief, &world.vehicles(), Some(given), &world.planners)
        .map_err(|error| Failure::usage(error.in_scenario(scenario)))?;
    Ok(if world.fleet.is_some() {
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
    let brief = Brief { run: RunId(1), ..world.brief };
    let mission =
        Mission { brief, terrain: world.terrain.clone(), seed: trial.seed, fleet: world.fleet.clone() };
    let schedule = schedule(world, &trial.cell.planner)?;
    let (mut hops, mut planning_ns) = (0, 0);
    let started = Node::now();
    let flown = lockstep::fly(mission, &schedule, &mut Node::now, &mut |record| {
        let is_hop = matches!(record.action, Action::Hop(_));
        hops += u64::from(if brief.is_of_hopper() { is_hop } else { record.action != Action::Hold });
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

fn default_folder(plan: &Plan, shard: Shard) -> PathBuf {
    let name = if shard == Shard::WHOLE {
        plan.name.clone()
    } else {
        format!("{}-{}-of-{}", plan.name, shard.number, shard.count)
    };
    Path::new("out").join(name)
}
