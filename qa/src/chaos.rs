//! `hopper chaos`: real missions through four processes, one of which is killed, stopped and restarted.
//!
//! [`crate::simulate`] injects faults under a virtual clock; this uses the operating system's kill -9, SIGSTOP and
//! SIGTERM, at every named crash point and at times drawn from a seed, start-up included. A seed always gives the
//! same plan; which decision is under way when a fault strikes depends on the machine. After each mission the
//! journal is compared with lockstep, and shared memory must be empty before any cleanup.

pub mod mission;
pub mod plan;
pub mod tally;
pub mod world;

use std::fmt::Write as _;

use contract::Role;
use hopper::progress::Progress;
use hopper::stdout::print;
use hopper::tool;
use node::{Exit, Failure, Node, ShutdownSignal};
use report::{Format, table};
use serde::Serialize;

use mission::{Broken, fly};
use plan::{ON_HARD_GROUND, Plan};
use tally::Tally;
pub use world::World;

/// Failed missions after which the command stops.
const FAILURES_MAX: usize = 5;

/// Arguments of `hopper chaos`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// Faults to inject into each role: kills, pauses, restarts.
    #[arg(long, default_value_t = 500, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    faults: u64,
    /// Role to inject them into: hopper-sim, perception, planner or monitor [default: each in turn].
    #[arg(long, value_name = "ROLE")]
    role: Option<Role>,
    /// Seed of the first mission; the following count up from it.
    #[arg(long, default_value_t = 1, value_name = "SEED")]
    seed: u64,
    /// Scenario of the missions, with the planners that its robots name: built in or a TOML file [default: hard].
    #[arg(long, value_name = "NAME|FILE")]
    scenario: Option<String>,
    /// Inject no fault before so many decisions were executed; then none comes at start-up or at a crash point.
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    after: u64,
    /// Format of the answer on standard output: text or json.
    #[arg(long, default_value_t)]
    format: Format,
}

/// A mission in which a promise did not hold.
#[derive(Clone, Debug, Serialize)]
pub struct Failing {
    /// Its faults as planned.
    pub plan: Plan,
    /// The promise that did not hold, and what was found instead.
    #[serde(flatten)]
    pub broken: Broken,
    /// Folder in which its journal and logs are kept.
    pub folder: std::path::PathBuf,
}

/// The answer; field names are those of the JSON.
#[derive(Clone, Debug, Serialize)]
struct Answer {
    missions: u64,
    decisions: u64,
    roles: Vec<Tally>,
    failures: Vec<Failing>,
    wall_s: f64,
    commit: &'static str,
    processor: String,
    /// Flags with which a mission is repeated, each with a space before it.
    #[serde(skip)]
    flags: String,
}

/// Runs the command: done if every promise held, failed otherwise.
///
/// # Errors
/// If a process cannot be started or a folder not be made, or the command is interrupted.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let hopper = tool::sibling("hopper")?;
    let shutdown = ShutdownSignal::new()?;
    let world = World::named(args.scenario.as_deref().unwrap_or("hard"))?;
    let victims = args.role.map_or_else(|| Role::ALL.to_vec(), |role| vec![role]);
    let started = Node::now();
    let due = args.faults.saturating_mul(victims.len() as u64);
    let (mut done, mut progress) = (0, Progress::begin("faults", due, 0, started));
    let mut answer = Answer {
        missions: 0,
        decisions: 0,
        roles: victims.into_iter().map(Tally::new).collect(),
        failures: Vec::new(),
        wall_s: 0.0,
        commit: hopper::COMMIT,
        processor: node::host::processor(),
        flags: args.again(),
    };
    for seed in args.seed.. {
        if answer.failures.len() >= FAILURES_MAX
            || answer.roles.iter().all(|tally| tally.faults >= args.faults)
        {
            break;
        }
        let undisturbed = world.fly(seed)?;
        let decisions = match &args.scenario {
            None if args.after == 1 => ON_HARD_GROUND,
            _ => (args.after, undisturbed.decisions.saturating_sub(1)),
        };
        if decisions.0 > decisions.1 {
            return Err(Failure::usage(format!(
                "--after needs to be less than the decisions of the mission of seed {seed}, which are {}; got {}",
                undisturbed.decisions, args.after
            )));
        }
        for tally in answer.roles.iter_mut().filter(|tally| tally.faults < args.faults) {
            let plan = Plan::of(seed, tally.role, world.seats().len(), decisions);
            let folder = tempfile::Builder::new().prefix("hopper-chaos-").tempdir().map_err(Failure::run)?;
            let flown = fly(&hopper, &plan, &world, folder.path(), undisturbed, &shutdown)?;
            tally.add(&flown);
            answer.missions += 1;
            answer.decisions += flown.decisions;
            // The last mission of a role may have more faults than were left to be delivered.
            done = (done + flown.delivered.len() as u64).min(due);
            progress.show(done, Node::now());
            if let Some(broken) = flown.broken {
                tracing::error!("seed {seed}, {}: {} {}", plan.victim, broken.promise, broken.detail);
                answer.failures.push(Failing { plan, broken, folder: folder.keep() });
            }
        }
    }
    progress.end();
    answer.wall_s = Node::now().since_ns(started) as f64 / 1e9;
    print(&match args.format {
        Format::Json => serde_json::to_string(&answer).map_err(Failure::run)? + "\n",
        Format::Text => answer.text(),
    })?;
    Ok(if answer.failures.is_empty() { Exit::Done } else { Exit::Failed })
}

impl Args {
    /// The flags that say which missions these are.
    fn again(&self) -> String {
        let mut flags = String::new();
        if let Some(scenario) = &self.scenario {
            let _ = write!(flags, " --scenario {scenario}");
        }
        if self.after > 1 {
            let _ = write!(flags, " --after {}", self.after);
        }
        flags
    }
}

impl Answer {
    fn text(&self) -> String {
        let rows: Vec<_> = self.roles.iter().map(row).collect();
        let mut text = table(
            ["victim", "missions", "faults", "failures", "at 95 % below", "recovery p50", "p99", "longest"],
            &rows,
        );
        for tally in &self.roles {
            let kinds: Vec<String> =
                tally.kinds.iter().map(|(kind, count)| format!("{kind} {count}")).collect();
            let _ = writeln!(text, "{}: {}", tally.role, kinds.join(", "));
        }
        let Self { missions, decisions, failures, wall_s, .. } = self;
        let _ = writeln!(text, "{missions} missions, {decisions} decisions in {wall_s:.0} s");
        if failures.is_empty() {
            let _ = writeln!(text, "every digest equals that of lockstep, and nothing was left behind");
        }
        for Failing { plan, broken, folder } in failures {
            let Plan { seed, victim, faults, .. } = plan;
            let _ = writeln!(text, "seed {seed} breaks: {}\n  {}", broken.promise, broken.detail);
            let _ = writeln!(text, "  planned for {victim}: {faults:?}");
            let more = &self.flags;
            let _ = writeln!(text, "  again: hopper chaos --seed {seed} --role {victim} --faults 1{more}");
            let _ = writeln!(text, "  journal and logs: {}", folder.display());
        }
        text
    }
}

fn row(tally: &Tally) -> [String; 8] {
    let ms = |ms: f64| format!("{ms:.1} ms");
    [
        tally.role.to_string(),
        tally.missions.to_string(),
        tally.faults.to_string(),
        tally.failures.to_string(),
        tally.bound.map_or_else(|| "-".into(), |bound| format!("{bound:.1e}")),
        ms(tally.recovery.p50_ms),
        ms(tally.recovery.p99_ms),
        ms(tally.recovery.max_ms),
    ]
}
