//! `hopper run`: a mission from start to end, as four processes or in lockstep.

use std::path::{Path, PathBuf};
use std::time::Duration;

use contract::{Digest, Name, Role, Status};
use hopper_sim::shell::{MissionArgs, print_summary};
use hopper_sim::{Journal, JournalReader, Pace};
use monitor::record_args::RecordArgs;
use monitor::shell::ViewArgs;
use node::inspect::{NodeHealth, NodeReport, nodes};
use node::{Exit, Failure, Instance, ShutdownSignal};
use report::Summary;
use scenario::ResolvedScenario;

use crate::mission::OutputDir;
use crate::mission::child::Supervised;
use crate::mission::comparison::against_lockstep;
use crate::mission::launch::{Launch, Recording};
use crate::mission::planner_command::PlannerCommand;
use crate::mission::run::in_lockstep;
use crate::mission::supervisor::{self, Flight};
use crate::progress::while_working;
use lockstep::PlannerSchedule;

/// Pause between two looks whether the page is still served.
const PAGE_PERIOD: Duration = Duration::from_millis(100);

/// Arguments of `hopper run`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    #[command(flatten)]
    mission: MissionArgs,
    #[arg(long, value_name = "NAME", help = format!(
        "Algorithm of the planner: {}; with --lockstep also clairvoyant [default: mdp, or for each robot what the scenario \
         names]",
        planner::listed()
    ))]
    planner: Option<String>,
    /// Start this program as the planner of each robot, in place of the built-in one: "python my_planner.py". Its
    /// environment has HOPPER_INSTANCE and HOPPER_ROBOT.
    #[arg(long, value_name = "COMMAND", conflicts_with_all = ["planner", "lockstep", "planners_from"])]
    planner_command: Option<PlannerCommand>,
    /// Name of the instance; processes of different instances never talk to each other.
    #[arg(long, env = "HOPPER_INSTANCE", default_value = "hopper", value_name = "NAME")]
    instance: String,
    /// Folder for journal, summary and picture; one that holds a journal of the same mission is resumed
    /// [default: a new folder under out/].
    #[arg(long, value_name = "DIR", value_parser = node::output_path())]
    out: Option<PathBuf>,
    /// Run in one thread, without shared memory; the digest is the same.
    #[arg(long, conflicts_with_all = ["pace", "web", "web_exit", "open", "control"])]
    lockstep: bool,
    /// With --lockstep: repeat the mission of this journal or run, each decision by the planner that commanded then.
    #[arg(long, requires = "lockstep", conflicts_with = "planner", value_name = "DIR")]
    planners_from: Option<PathBuf>,
    /// Exit with code 3 if a decision missed its budget.
    #[arg(long)]
    strict_budget: bool,
    /// When a process keeps dying, how long to hold before the mission is stopped, so that another can be
    /// started by hand.
    #[arg(long, default_value = "60s", value_parser = humantime::parse_duration, value_name = "DURATION")]
    patience: Duration,
    #[command(flatten)]
    view: ViewArgs,
    /// What mission.svg is drawn for: screen, or paper, which is one column wide without a title.
    #[arg(long, default_value_t, value_name = "STYLE")]
    picture: report::PictureStyle,
    /// Format of the summary on standard output.
    #[arg(long, default_value = "text")]
    format: report::Format,
    #[command(flatten)]
    record: RecordArgs,
}

/// Flies the mission and prints its summary.
///
/// # Errors
/// Exit code 2 if an argument, the scenario or the output folder is wrong; 1 if the processes cannot run.
// Long: one step of a run after the other.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    check(args)?;
    let args = &Args { planners_from: journal_of(args)?, ..args.clone() };
    let (world, seed) = match &args.planners_from {
        Some(dir) => world_of_journal(args, dir)?,
        None => (args.mission.world()?, args.mission.seed()),
    };
    let planners = planners(args, &world)?;
    if let Some(summary) = ended(args, &world, seed)? {
        print_summary(&summary, args.format)?;
        return Ok(exit(&summary, args.strict_budget, false));
    }
    if !args.lockstep {
        check_instance(&args.instance)?;
    }
    let (output_dir, journal) = OutputDir::open(args.out.clone(), &world, seed)?;
    // A recording that is full goes on in FILE-2, FILE-3, …: those of earlier missions are not this one's.
    let earlier: Vec<PathBuf> = recordings(args, 1).collect();
    // Watched from here on, so that no Ctrl-C is lost between the end of the mission and its page.
    let shutdown = (!args.lockstep).then(ShutdownSignal::new).transpose()?;
    let flight = fly(args, (&world, seed), &planners, &output_dir, journal)?;
    let Some(mut summary) = flight.summary else {
        return Err(match flight.verdict {
            Ok(true) => {
                let dir = output_dir.dir().display();
                let message = format!(
                    "interrupted before the first decision; the same command with --out {dir} begins anew"
                );
                Failure::new(Exit::Interrupted, message)
            }
            Ok(false) => {
                Failure::new(Exit::Failed, "hopper-sim ended without a summary: its log above says why")
            }
            Err(failure) => failure,
        });
    };
    // A disk that is full by now hides neither how the mission went nor why it was stopped.
    let illustrated = output_dir.illustrate(&world, &mut summary, args.picture);
    let recorded = recordings(args, 0).filter(|file| !earlier.contains(file));
    for (number, file) in (1..).zip(recorded) {
        let name = if number == 1 { "recording".into() } else { format!("recording-{number}") };
        summary.artifacts.insert(name, file);
    }
    let kept = illustrated.and(output_dir.keep(&summary));
    let printed = print_summary(&summary, args.format);
    let unwritten = kept.and(printed);
    if let Err(failure) = &unwritten {
        tracing::error!("{failure}");
    }
    let interrupted = flight.verdict?;
    if let (Some(page), Some(shutdown)) = (flight.page, shutdown) {
        serve_on(page, &shutdown)?;
    }
    if interrupted {
        tracing::warn!(
            "interrupted: the same command with --out {} resumes the mission",
            output_dir.dir().display()
        );
    }
    if !interrupted {
        unwritten?;
    }
    if !flight.watched
        && !interrupted
        && let Some(path) = &args.record.record
    {
        let message = format!(
            "--record {} needs a complete recording, got one that is not whole: the log above says why; the \
             mission itself is complete",
            path.display()
        );
        return Err(Failure::new(Exit::Failed, message));
    }
    Ok(exit(&summary, args.strict_budget, interrupted))
}

/// The summary of the mission if the output folder holds it from its start to its end: then nothing is left to fly.
///
/// # Errors
/// Exit code 2 if something is to be done with a mission that flies.
fn ended(args: &Args, world: &ResolvedScenario, seed: u64) -> Result<Option<Summary>, Failure> {
    if args.planners_from.is_some() {
        return Ok(None);
    }
    let Some(dir) = args.out.as_deref() else { return Ok(None) };
    let Some(summary) = OutputDir::ended(dir, world, seed) else { return Ok(None) };
    let shown = dir.display();
    if let Some(file) = &args.record.record {
        return Err(Failure::usage(format!(
            "--record {} needs a mission that flies, got --out {shown}, which has already ended: name another folder",
            file.display()
        )));
    }
    tracing::info!("{shown} has already ended, nothing flown; `hopper view {shown}` shows it");
    Ok(Some(summary))
}

/// Waits for Ctrl-C, or for the end of the monitor that serves its page on.
fn serve_on(mut page: Supervised, shutdown: &ShutdownSignal) -> Result<(), Failure> {
    while shutdown.stop_reason().is_none() && page.ended()?.is_none() {
        shutdown.wait(PAGE_PERIOD);
    }
    page.release();
    page.output();
    Ok(())
}

fn fly(
    args: &Args,
    (world, seed): (&ResolvedScenario, u64),
    planners: &[Name],
    output_dir: &OutputDir,
    journal: Journal,
) -> Result<Flight, Failure> {
    if args.lockstep {
        let schedule = schedule(args, planners)?;
        let summary =
            while_working("flying in lockstep", || in_lockstep(world, seed, &schedule, output_dir, journal))?;
        check_repetition(args, summary.digest)?;
        return Ok(Flight { summary: Some(summary), verdict: Ok(false), watched: true, page: None });
    }
    output_dir.describe(world, seed)?;
    let launch = Launch {
        instance: args.instance.clone(),
        planners: planners.to_vec(),
        planner_command: args.planner_command.clone(),
        falls_back: world.brief.guard.deadline_ns > 0,
        seed,
        pace: args.mission.pace,
        view: args.view.clone(),
        recording: args
            .record
            .record
            .as_ref()
            .map(|file| Recording { file: file.clone(), with_policies: args.record.record_policies }),
        patience: args.patience,
    };
    supervisor::fly(&launch, output_dir, journal)
}

/// The files of the recording asked for that exist, without the first `skipped`.
fn recordings(args: &Args, skipped: usize) -> impl Iterator<Item = PathBuf> {
    let files = args.record.record.as_deref().map(monitor::record_args::files);
    files.into_iter().flatten().skip(skipped).take_while(|file| file.exists())
}

/// Rejects arguments that cannot work before anything is started.
fn check(args: &Args) -> Result<(), Failure> {
    if args.view.control && args.view.web.is_none() {
        tracing::info!(
            "orders come from a page or a terminal: hopper monitor --tui --control --instance {}, or --web here",
            args.instance
        );
    }
    if args.view.web.is_some() && args.mission.pace == Pace::Max {
        tracing::info!(
            "at --pace max the mission is over before a browser has opened; --pace 2 is slow enough"
        );
    }
    let given = args.planner.as_deref().filter(|name| !args.lockstep || *name != planner::CLAIRVOYANT);
    given.map(planner::algorithm).transpose().map_err(Failure::usage)?;
    if let Some(command) = &args.planner_command {
        command.check().map_err(Failure::usage)?;
    }
    check_recording(args)?;
    check_page(args)
}

/// The planner of each robot, in the order of their numbers.
///
/// # Errors
/// Exit code 2 if one is not known, or cannot plan for the scenario's task.
fn planners(args: &Args, world: &ResolvedScenario) -> Result<Vec<Name>, Failure> {
    let given: Option<Name> = args.planner.as_deref().map(str::parse).transpose().map_err(Failure::usage)?;
    if (!args.lockstep || world.brief.has_team())
        && let Some(name) = given
    {
        planner::algorithm(name.as_str()).map_err(Failure::usage)?;
    }
    let scenario = world.brief.scenario;
    planner::assigned(&world.brief, given, &world.planners)
        .map_err(|error| Failure::usage(error.in_scenario(scenario)))
}

/// The folder of the journal that `--planners-from` names.
fn journal_of(args: &Args) -> Result<Option<PathBuf>, Failure> {
    args.planners_from.as_deref().map(crate::commands::journal::folder).transpose()
}

/// Refuses an instance in which a mission is flying, before a folder is made for another: hopper-sim would refuse it too
/// late, and does so for two missions that start in the same moment.
fn check_instance(name: &str) -> Result<(), Failure> {
    let Some(pid) = flying_in(&Instance::new(name)?)? else { return Ok(()) };
    let mut others = (2..).map(|number| format!("{name}-{number}"));
    let free = others.find(|other| {
        let instance = Instance::new(other).ok();
        instance.is_some_and(|instance| instance.is_alive().is_ok_and(|alive| !alive))
    });
    Err(Failure::new(
        Exit::Peer,
        format!(
            "instance {name:?} flies a mission already (hopper-sim is process {pid}): for another at the same time, \
             give it a name of its own: --instance {}",
            free.unwrap_or_default()
        ),
    ))
}

/// Process number of the live hopper-sim of an instance, if it has one.
fn flying_in(instance: &Instance) -> Result<Option<u32>, Failure> {
    if !instance.exists() {
        return Ok(None);
    }
    let sim = Role::HopperSim.to_string();
    let is_sim = |node: &NodeReport| node.health == NodeHealth::Alive && node.name == sim;
    Ok(nodes(instance)?.into_iter().find(is_sim).and_then(|node| node.pid))
}

fn check_page(args: &Args) -> Result<(), Failure> {
    if !args.view.web_host.is_empty() && args.view.web.is_none() {
        return Err(Failure::new(Exit::Usage, "--web-host needs --web: it names the page's server"));
    }
    let Some(address) = args.view.web.filter(|address| address.port() != 0) else { return Ok(()) };
    let tried = std::net::TcpListener::bind(address);
    tried.map(drop).map_err(|error| {
        let message = format!(
            "--web {address} cannot be listened on: {error}: choose another port, or 0 for a free one"
        );
        Failure::new(Exit::Usage, message)
    })
}

/// A recording needs processes that exchange messages, and never replaces an existing file.
fn check_recording(args: &Args) -> Result<(), Failure> {
    let Some(path) = &args.record.record else { return Ok(()) };
    if args.lockstep {
        let why = "--record needs processes whose messages it records, got --lockstep";
        return Err(Failure::new(Exit::Usage, why));
    }
    if path.exists() {
        let message = format!("--record {} exists already: name another file", path.display());
        return Err(Failure::new(Exit::Usage, message));
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
        let message = format!(
            "--record {} needs a folder that exists, got {}: create it first",
            path.display(),
            folder.display()
        );
        return Err(Failure::new(Exit::Usage, message));
    }
    Ok(())
}

/// World and seed of the journal in `dir`; if the command line names them too, they must be the same.
fn world_of_journal(args: &Args, dir: &Path) -> Result<(ResolvedScenario, u64), Failure> {
    let history = JournalReader::open(dir).map_err(Failure::usage)?;
    history.require_sound().map_err(Failure::usage)?;
    let world = history.world().map_err(Failure::usage)?;
    let (header, mission) = (history.header(), &args.mission);
    let given = match mission.is_given() {
        true => mission.world()?.brief.scenario_hash,
        false => header.brief.scenario_hash,
    };
    let seed = mission.seed.unwrap_or(header.seed);
    if (given, seed) != (header.brief.scenario_hash, header.seed) {
        let message = format!(
            "--planners-from needs the journal's own mission, scenario {} with seed {}, got another: \
             leave --scenario, --profile, --dynamics, --table, --dem and --seed out",
            header.brief.scenario, header.seed
        );
        return Err(Failure::new(Exit::Usage, message));
    }
    Ok((world, seed))
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

/// The repetition of a complete mission must have the digest of its journal.
fn check_repetition(args: &Args, digest: Digest) -> Result<(), Failure> {
    let Some(dir) = &args.planners_from else { return Ok(()) };
    let verified = hopper_sim::verify(dir).map_err(Failure::usage)?;
    if verified.outcome.is_over() && verified.digest != digest {
        let message =
            format!("the repeated mission has digest {digest}, the journal's is {}", verified.digest);
        return Err(Failure::new(Exit::Failed, message));
    }
    if let Some(difference) = against_lockstep(dir)? {
        let message = format!("the mission of {} is not repeated: {difference}", dir.display());
        return Err(Failure::new(Exit::Failed, message));
    }
    tracing::info!("the mission of {} is repeated, digest {digest}", dir.display());
    Ok(())
}

fn schedule(args: &Args, planners: &[Name]) -> Result<PlannerSchedule, Failure> {
    let usage = |error: &dyn std::fmt::Display| Failure::new(Exit::Usage, error.to_string());
    match &args.planners_from {
        Some(dir) => {
            let history = JournalReader::open(dir).map_err(|error| usage(&error))?;
            let schedule = PlannerSchedule::from_records(history.records()).map_err(|error| usage(&error))?;
            if !schedule.is_empty() {
                return Ok(schedule);
            }
            // Where nothing was to do, any planners repeat it.
            match hopper_sim::verify(dir).map_err(|error| usage(&error))?.outcome {
                Status::Underway => {
                    Err(usage(&format!("--planners-from {} holds no decision", dir.display())))
                }
                _ => Ok(PlannerSchedule::of_robots(planners)),
            }
        }
        None => Ok(PlannerSchedule::of_robots(planners)),
    }
}
