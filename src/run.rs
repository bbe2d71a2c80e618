//! `hopper run`: a mission from start to end, as four processes or in lockstep.

use std::path::{Path, PathBuf};
use std::time::Duration;

use contract::{Brief, Digest, Name, Status};
use hopper_sim::shell::{MissionArgs, open_journal, print_summary};
use hopper_sim::{History, Mission, Pace};
use monitor::recorder::RecordArgs;
use monitor::shell::ViewArgs;
use node::{Exit, Failure, Node};
use report::{Summary, SummaryBuilder};
use scenario::{ResolvedScenario, Scenario};

use crate::lockstep::{self, Crew};
use crate::outbox::Outbox;
use crate::supervisor::{self, Flight};

/// Arguments of `hopper run`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    #[command(flatten)]
    pub(crate) mission: MissionArgs,
    /// Algorithm of the planner: mdp, greedy, astar, dstar_lite, hold; in lockstep also clairvoyant.
    #[arg(long, default_value = "mdp", value_name = "NAME")]
    pub(crate) planner: String,
    /// Instance to run as; processes of different instances never meet.
    #[arg(long, env = "HOPPER_INSTANCE", default_value = "hopper", value_name = "NAME")]
    pub(crate) instance: String,
    /// Folder for journal, summary and picture; one that holds this mission's journal is resumed
    /// [default: a new folder under out/].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Run the same machines in one thread, without shared memory; the digest is the same.
    #[arg(long, conflicts_with_all = ["pace", "web"])]
    pub(crate) lockstep: bool,
    /// Let those planners command which this journal tells of, each for its decisions.
    #[arg(long, requires = "lockstep", conflicts_with = "planner", value_name = "DIR")]
    pub(crate) planners_from: Option<PathBuf>,
    /// Exit with code 3 if a decision missed its budget.
    #[arg(long)]
    pub(crate) strict_budget: bool,
    /// How long to hold for help by hand when a process keeps dying, before the mission is stopped.
    #[arg(long, default_value = "60s", value_parser = humantime::parse_duration, value_name = "DURATION")]
    pub(crate) patience: Duration,
    #[command(flatten)]
    pub(crate) view: ViewArgs,
    /// Form of the summary on standard output.
    #[arg(long, default_value = "text")]
    pub(crate) format: report::Format,
    #[command(flatten)]
    pub(crate) record: RecordArgs,
}

/// Flies the mission and prints its summary.
///
/// # Errors
/// If the arguments, the scenario or the output folder are at fault, or the processes cannot run.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    if args.view.control && args.view.web.is_none() {
        return Err(Failure::usage("--control needs --web to give orders from"));
    }
    if args.view.web.is_some() && args.mission.pace == Pace::Max {
        tracing::info!(
            "at --pace max a mission is over before a browser has opened: --pace 2 gives time to look"
        );
    }
    let clairvoyant = args.lockstep && args.planner == planner::CLAIRVOYANT;
    if !clairvoyant {
        planner::algorithm(&args.planner).map_err(Failure::usage)?;
    }
    check_recording(args)?;
    check_page(args)?;
    let (world, seed) = match &args.planners_from {
        Some(dir) => flown_world(args, dir)?,
        None => (args.mission.world()?, args.mission.seed()),
    };
    let outbox = Outbox::open(args.out.clone(), &world, seed)?;
    // A recording goes on beside files of others.
    let others: Vec<PathBuf> = recordings(args, 1).collect();
    let flight = if args.lockstep {
        let summary = in_lockstep(&world, seed, &crew(args)?, &outbox)?;
        check_repetition(args, summary.digest)?;
        Flight { summary: Some(summary), verdict: Ok(false), watched: true }
    } else {
        supervisor::fly(args, &outbox)?
    };
    let Some(mut summary) = flight.summary else {
        return Err(match flight.verdict {
            Ok(true) => Failure::new(Exit::Interrupted, "interrupted before anything was executed"),
            Ok(false) => {
                Failure::new(Exit::Failed, "hopper-sim ended without a summary: its log above says why")
            }
            Err(failure) => failure,
        });
    };
    outbox.illustrate(&world, &mut summary)?;
    let recorded = recordings(args, 0).filter(|file| !others.contains(file));
    for (number, file) in (1..).zip(recorded) {
        let name = if number == 1 { "recording".into() } else { format!("recording-{number}") };
        summary.artifacts.insert(name, file);
    }
    outbox.keep(&summary)?;
    print_summary(&summary, args.format)?;
    let interrupted = flight.verdict?;
    if let Some(path) = args.record.record.as_ref().filter(|_| !flight.watched && !interrupted) {
        let message = format!(
            "--record {} needs a recording to the end, got one that is not whole: the log above says why; of the \
             mission itself nothing is missing",
            path.display()
        );
        return Err(Failure::new(Exit::Failed, message));
    }
    Ok(exit(&summary, args.strict_budget, interrupted))
}

/// The recording that was asked for and those that go on from it, after `skipped`, as far as they are there.
fn recordings(args: &Args, skipped: usize) -> impl Iterator<Item = PathBuf> {
    let files = args.record.record.as_deref().map(monitor::recorder::files);
    files.into_iter().flatten().skip(skipped).take_while(|file| file.exists())
}

/// The mission that a journal is of; whatever the command line says besides must agree with it.
fn flown_world(args: &Args, dir: &Path) -> Result<(ResolvedScenario, u64), Failure> {
    let history = History::open(dir).map_err(Failure::usage)?;
    let (header, mission) = (history.header(), &args.mission);
    let scenario = Scenario::parse(&header.resolved, &dir.display().to_string()).map_err(Failure::usage)?;
    let world = scenario.resolve().map_err(Failure::usage)?;
    let given = match mission.is_given() {
        true => mission.world()?.brief.scenario_hash,
        false => header.brief.scenario_hash,
    };
    let seed = mission.seed.unwrap_or(header.seed);
    if (given, seed) != (header.brief.scenario_hash, header.seed) {
        return Err(Failure::new(
            Exit::Usage,
            format!(
                "--planners-from needs the journal's own mission, scenario {} with seed {}, got another: \
                 leave --scenario, --profile, --dem and --seed out",
                header.brief.scenario, header.seed
            ),
        ));
    }
    Ok((world, seed))
}

/// A page that cannot be served is told before anything flies.
fn check_page(args: &Args) -> Result<(), Failure> {
    let Some(address) = args.view.web.filter(|address| address.port() != 0) else { return Ok(()) };
    let tried = std::net::TcpListener::bind(address);
    tried.map(drop).map_err(|error| {
        Failure::new(
            Exit::Usage,
            format!("--web {address} cannot be listened on: {error}: name another, or port 0"),
        )
    })
}

/// A recording is of messages between processes, and never written over another.
fn check_recording(args: &Args) -> Result<(), Failure> {
    let Some(path) = &args.record.record else { return Ok(()) };
    if args.lockstep {
        let why = "--record needs processes whose messages it records, got --lockstep";
        return Err(Failure::new(Exit::Usage, why));
    }
    if path.exists() {
        let message = format!("--record {} is there already: name another file", path.display());
        return Err(Failure::new(Exit::Usage, message));
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
        let message = format!(
            "--record {} needs a folder that is there, got {}: make it first",
            path.display(),
            folder.display()
        );
        return Err(Failure::new(Exit::Usage, message));
    }
    Ok(())
}

fn exit(summary: &Summary, strict_budget: bool, interrupted: bool) -> Exit {
    if interrupted {
        Exit::Interrupted
    } else if summary.outcome != Status::Goal {
        Exit::Failed
    } else if strict_budget && summary.latency.misses > 0 {
        Exit::Threshold
    } else {
        Exit::Done
    }
}

/// Flies `world` with `seed` in this thread, journal included.
///
/// # Errors
/// If the output folder holds a mission already, or cannot be written.
pub fn in_lockstep(
    world: &ResolvedScenario,
    seed: u64,
    crew: &Crew,
    outbox: &Outbox,
) -> Result<Summary, Failure> {
    let mut journal = open_journal(&outbox.journal_dir(), world, seed, false)?;
    if !journal.is_empty() {
        return Err(Failure::new(
            Exit::Usage,
            format!(
                "--lockstep needs a fresh output folder, got {} with {} decisions: name another with --out",
                outbox.dir().display(),
                journal.len()
            ),
        ));
    }
    let brief = Brief { run: journal.header().run(), ..world.brief };
    let mission = Mission { brief, terrain: world.terrain.clone(), seed };
    let mut summary = SummaryBuilder::new(&brief, seed);
    let mut failed = None;
    let flown = lockstep::fly(mission, crew, &mut Node::now, &mut |record| {
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

/// A repeated mission that went to its end has the digest of the first.
fn check_repetition(args: &Args, digest: Digest) -> Result<(), Failure> {
    let Some(dir) = &args.planners_from else { return Ok(()) };
    let verified = hopper_sim::verify(dir).map_err(Failure::usage)?;
    if verified.outcome.is_over() && verified.digest != digest {
        let message =
            format!("the repeated mission has digest {digest}, the journal's is {}", verified.digest);
        return Err(Failure::new(Exit::Failed, message));
    }
    tracing::info!("the mission of {} is repeated, digest {digest}", dir.display());
    Ok(())
}

fn crew(args: &Args) -> Result<Crew, Failure> {
    let usage = |error: &dyn std::fmt::Display| Failure::new(Exit::Usage, error.to_string());
    match &args.planners_from {
        Some(dir) => {
            let history = History::open(dir).map_err(|error| usage(&error))?;
            let crew = Crew::from_records(history.records()).map_err(|error| usage(&error))?;
            if crew.shifts().is_empty() && crew.fallbacks().is_empty() {
                return Err(usage(&format!("--planners-from {} tells of no decision", dir.display())));
            }
            Ok(crew)
        }
        None => {
            let planner: Name = args.planner.parse().map_err(|error| usage(&error))?;
            Ok(Crew::single(planner))
        }
    }
}
