//! Flies the trials of a plan on all cores, whatever they are, and writes the rows in order.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, mpsc};
use std::time::Duration;

use ::campaign::{Shard, TrialPlan};
use node::{Exit, Failure, Node, ShutdownSignal};
use report::Format;
use serde::Serialize;

use super::run_args::Args;
use super::store::{self, Manifest, Store, Times};
use crate::progress::Progress;
use crate::stdout::print;

/// Trials per job that may be flown ahead of the next row: bounds the rows held in memory.
const AHEAD_PER_JOB: u64 = 32;

/// Pause between two writes to the files, nanoseconds: a kill loses no more than the rows of this time.
const FLUSH_NS: u64 = 500_000_000;

/// Longest wait for a row before checking whether to stop.
const TICK: Duration = Duration::from_millis(50);

/// Rows are gathered for so long before they are kept; a thread flies some five ordinary missions meanwhile.
const GATHER: Duration = Duration::from_millis(3);

/// The answer; field names are those of the JSON. Times are of this machine.
#[derive(Clone, Debug, Serialize)]
pub struct Run {
    /// Folder with the rows; what is not UTF-8 in it is replaced.
    #[serde(serialize_with = "report::path_as_text")]
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

/// How the trials of a plan are flown.
pub trait Flight: Send + Sync + 'static {
    /// What decides the rows.
    type Plan: TrialPlan<Row: Send + 'static>;

    /// Flies trial `number`. The row depends on plan and number only.
    ///
    /// # Errors
    /// If the trial cannot be flown.
    fn fly(&self, number: u64) -> Result<(<Self::Plan as TrialPlan>::Row, Times), Failure>;

    /// Time the paper reports for the trial of a row, seconds; 0 where it has none.
    fn paper_s(&self, _row: &<Self::Plan as TrialPlan>::Row) -> f64 {
        0.0
    }
}

/// Flies the shard of `plan` that `args` ask for; exit code 130 if interrupted, with all rows kept that were complete up to then.
///
/// # Errors
/// Exit code 2 if the folder is wrong.
pub fn run<F: Flight>(args: &Args, plan: F::Plan, flight: F) -> Result<Exit, Failure> {
    let jobs =
        args.jobs.map_or_else(|| std::thread::available_parallelism().map_or(1, usize::from), usize::from);
    let out = args.out.clone().unwrap_or_else(|| default_folder(plan.identity().name, args.shard));
    let manifest = Manifest { shard: args.shard, plan };
    let (shard, due) = (args.shard, args.shard.len(manifest.plan.trials()));
    if store::is_finished(&out, &manifest) {
        let run = Run::over(out, shard, due);
        return tell(&run, args.format);
    }
    let mut store = Store::open(&out, &manifest, args.resume)?;
    let held = store.done();
    let started = Node::now();
    let Some(paper_s) = fly_all(&manifest, flight, jobs, &mut store)? else {
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
    tell(&run, args.format)
}

fn tell(run: &Run, format: Format) -> Result<Exit, Failure> {
    print(&match format {
        Format::Json => serde_json::to_string(run).map_err(Failure::run)? + "\n",
        Format::Text => run.text(),
    })?;
    Ok(Exit::Done)
}

impl Run {
    /// The answer where the folder holds all trials already.
    fn over(out: PathBuf, shard: Shard, trials: u64) -> Self {
        tracing::info!("{} has already ended, nothing flown", out.display());
        Self {
            out,
            shard,
            trials,
            flown: 0,
            jobs: 0,
            wall_s: 0.0,
            episodes_per_s: 0.0,
            paper_s: 0.0,
            paper_ratio: None,
            commit: crate::COMMIT,
            processor: node::host::processor(),
        }
    }

    fn text(&self) -> String {
        let Self { out, trials, flown, jobs, wall_s, episodes_per_s, .. } = self;
        if *flown == 0 {
            return format!("Already ended, nothing flown: {} holds all {trials} trials.\n", out.display());
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
fn fly_all<F: Flight>(
    manifest: &Manifest<F::Plan>,
    flight: F,
    jobs: usize,
    store: &mut Store<F::Plan>,
) -> Result<Option<f64>, Failure> {
    let shutdown = ShutdownSignal::new()?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(jobs)
        // The panic is logged already; the trial will never arrive.
        .panic_handler(|_| std::process::exit(101))
        .build()
        .map_err(Failure::run)?;
    let (shard, trials) = (manifest.shard, manifest.plan.trials());
    let flight = Arc::new(flight);
    let due = shard.len(trials);
    let mut progress = Progress::begin("trials", due, store.done(), Node::now());
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
            let (flight, landed) = (Arc::clone(&flight), landed.clone());
            pool.spawn(move || {
                let number = shard.nth(index, trials).expect("every index has a trial");
                // Fails only after an interruption.
                let _ = landed.send((index, flight.fly(number)));
            });
        }
        begun = last;
        // Not row by row: to be woken for each costs more than to keep it.
        std::thread::sleep(GATHER);
        early.extend(flown.recv_timeout(TICK));
        early.extend(flown.try_iter());
        while let Some(row) = early.remove(&store.done()) {
            let (row, times) = row?;
            paper_s += flight.paper_s(&row);
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

fn default_folder(name: &str, shard: Shard) -> PathBuf {
    let Shard { number, count } = shard;
    let name = if shard == Shard::WHOLE { name.to_owned() } else { format!("{name}-{number}-of-{count}") };
    Path::new("out").join(name)
}
