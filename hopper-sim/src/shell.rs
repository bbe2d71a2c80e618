//! The command line of hopper-sim, its journal file, and its life in shared memory.

use std::cell::RefCell;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;

use contract::{Brief, MotionModel, Profile, Record, Role, RunId};
use node::{Exit, Failure, Instance, Joining, MemoryBudget, Node};
use process::{Ports as _, Terms, block_on};
use report::{Process, Summary, SummaryBuilder};
use scenario::{Overrides, Preset, ResolvedScenario, Scenario};

use crate::elevation_args::ElevationArgs;
use crate::journal::JournalError;
use crate::process::{HopperSim, SimTerms};
use crate::{Journal, JournalHeader, Mission, Pace, crash};

/// What a mission is about: the scenario with what the command line changes in it.
#[derive(clap::Args, Clone, Debug)]
pub struct MissionArgs {
    /// Scenario: a TOML file, or a name that `hopper scenario list` explains [default: hard, or with --dem one that
    /// fits the elevation model].
    #[arg(long, value_name = "NAME|FILE")]
    pub scenario: Option<PathBuf>,
    /// Seed of the hops' scatter [default: 1].
    #[arg(long, allow_negative_numbers = true)]
    pub seed: Option<u64>,
    /// Reading of the model, instead of the scenario's: paper-2023, hopper or paper-2022.
    #[arg(long, value_name = "NAME")]
    pub profile: Option<Profile>,
    /// Where hops end in truth, instead of the scenario's: law, collision or contact.
    #[arg(long, value_name = "MODEL")]
    pub dynamics: Option<MotionModel>,
    /// Gravity and soils of a body, with contact dynamics unless --dynamics law: moon, mars, phobos, ryugu or bennu.
    #[arg(long, value_name = "BODY")]
    pub preset: Option<Preset>,
    /// Where planners believe hops to end, instead of the scenario's: a table of `hopper motion derive`.
    #[arg(long, value_name = "FILE")]
    pub table: Option<PathBuf>,
    /// Budget of one decision, landing to commit [default: the scenario's, 600ms].
    #[arg(long, value_parser = positive_duration, value_name = "DURATION", allow_hyphen_values = true)]
    pub budget: Option<Duration>,
    /// Elevation model: of its own accord, or instead of that of --scenario.
    #[arg(long, value_name = "FILE")]
    pub dem: Option<PathBuf>,
    /// How the elevation model is read.
    #[command(flatten)]
    pub elevation: ElevationArgs,
    /// How fast landings follow each other: max, real (as the hop flies), a multiple of that (3600x), or a rate in hertz.
    #[arg(long, default_value = "max", value_name = "max|real|Nx|HZ", allow_negative_numbers = true)]
    pub pace: Pace,
}

impl MissionArgs {
    /// The seed, or its default.
    #[must_use]
    pub fn seed(&self) -> u64 {
        self.seed.unwrap_or(1)
    }

    /// Whether anything is given that says which mission this is, the seed aside.
    #[must_use]
    pub fn is_given(&self) -> bool {
        let of_ground = self.dem.is_some() || self.elevation.nodata.is_some();
        self.scenario.is_some()
            || self.profile.is_some()
            || self.dynamics.is_some()
            || self.preset.is_some()
            || self.table.is_some()
            || of_ground
    }

    /// The world of the mission.
    ///
    /// # Errors
    /// Exit code 2 with what is wrong with the scenario or its terrain.
    pub fn world(&self) -> Result<ResolvedScenario, Failure> {
        let resolved = self.scenario()?.resolve();
        let world = resolved.map_err(|error| Failure::usage(format!("{error}{}", self.dem_alone())))?;
        for warning in world.warnings.iter().filter(|warning| warning.is_of_ground()) {
            tracing::warn!("{warning}");
        }
        Ok(world)
    }

    /// The scenario of the mission, as the command line changes it.
    ///
    /// # Errors
    /// Exit code 2 if there is none, or it is not one.
    pub fn scenario(&self) -> Result<Scenario, Failure> {
        let dem = self.dem.as_deref().map(|dem| self.elevation.model(dem)).transpose()?;
        let overrides = Overrides {
            profile: self.profile,
            dynamics: self.dynamics,
            preset: self.preset,
            decision_budget_ns: self.budget.map(nanoseconds),
            dem: dem.clone(),
            nodata: self.elevation.nodata().map(<[f64]>::to_vec),
            table: self.table.clone(),
        };
        if let (None, Some(dem)) = (&self.scenario, &dem) {
            let fitted = scenario::fitted_with(dem, self.elevation.nodata()).map_err(Failure::usage)?;
            tracing::info!("flying over {fitted}; --scenario FILE chooses otherwise");
            return Ok(fitted.scenario.with(&Overrides { dem: None, ..overrides }));
        }
        let scenario =
            scenario::load(self.scenario.as_deref().unwrap_or(Path::new("hard"))).map_err(Failure::usage)?;
        Ok(scenario.with(&overrides))
    }

    /// For a scenario that does not fit the elevation model put under it: the argument that fits one to the model.
    fn dem_alone(&self) -> String {
        match &self.dem {
            Some(dem)
                if self.scenario.is_some() && scenario::fitted_with(dem, self.elevation.nodata()).is_ok() =>
            {
                format!(
                    "; to fly over this model as it is, leave --scenario out: hopper run --dem {}",
                    dem.display()
                )
            }
            _ => String::new(),
        }
    }
}

/// A duration above zero.
fn positive_duration(text: &str) -> Result<Duration, String> {
    match humantime::parse_duration(text) {
        Ok(duration) if duration > Duration::ZERO => Ok(duration),
        Ok(_) => Err("a budget needs to be above zero".into()),
        Err(error) => Err(format!("a duration is e.g. 600ms or 2s; {error}")),
    }
}

/// Arguments of `hopper-sim` and of `hopper sim`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    #[command(flatten)]
    mission: MissionArgs,
    /// Instance to serve; processes of different instances never meet.
    #[arg(long, env = "HOPPER_INSTANCE", default_value = "hopper", value_name = "NAME")]
    instance: String,
    /// Folder of the journal: created, or resumed if it holds one of this very mission.
    #[arg(long, default_value = "out/journal", value_name = "DIR", value_parser = node::output_path())]
    journal: PathBuf,
    /// Force each record to the disk, so that the promise covers power loss too.
    #[arg(long)]
    sync: bool,
    /// Serve the end of the mission at most this long to peers that have not seen it.
    #[arg(long, default_value = "2s", value_parser = humantime::parse_duration, value_name = "DURATION")]
    linger: Duration,
    /// Give up with exit code 4 when no perception, or no planner of a robot that still acts, beats for this time, e.g. 30s
    /// [default: wait forever].
    #[arg(long, value_parser = humantime::parse_duration, value_name = "DURATION")]
    wait: Option<Duration>,
    /// Hold at most this long when the journal was deleted, replaced or cut, or cannot be read, or when a stopped process
    /// keeps others from joining; then exit with code 1.
    #[arg(long, default_value = "60s", value_parser = humantime::parse_duration, value_name = "DURATION")]
    patience: Duration,
    /// Resume the journal of this run, and begin none.
    #[arg(long, hide = true, value_parser = run_id, value_name = "RUN")]
    resume_run: Option<RunId>,
    /// Decisions that the run to be resumed has published.
    #[arg(long, hide = true, default_value_t = 0, value_name = "N")]
    published: u64,
    /// Obey orders to pause, resume, step or change the pace, as the monitor's page gives them.
    #[arg(long)]
    control: bool,
    /// Form of the summary on standard output.
    #[arg(long, default_value = "text")]
    format: report::Format,
    /// End when standard input closes: the parent holds its other end.
    #[arg(long, hide = true)]
    lifeline: bool,
}

/// Runs the process until the mission ends; the exit code tells its outcome.
///
/// # Errors
/// If the scenario, the journal or shared memory is at fault, the instance has a hopper-sim already,
/// or a peer was waited for longer than `--wait`.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let world = args.mission.world()?;
    let instance = Instance::new(&args.instance)?;
    let joining = Joining { lifeline: args.lifeline, ..Joining::patiently(args.patience) };
    let _claim = instance.claim_patiently(Role::HopperSim, joining)?;
    let seed = args.mission.seed();
    let journal = match args.resume_run {
        Some(run) => resume_journal(args, &world, run)?,
        None => open_journal(&args.journal, &world, seed, args.sync)?,
    };
    let brief = Brief { run: journal.header().run(), ..world.brief.clone() };
    let mut summary = SummaryBuilder::new(&brief, seed);
    for record in journal.records() {
        summary.record(&record.map_err(Failure::run)?);
    }
    MemoryBudget::of(brief.grid.cells(), brief.robots.count())?.check(&instance)?;
    let mut node = Node::join_with(&instance, Role::HopperSim, joining)?;
    let summary_so_far = RefCell::new(summary);
    let (exit, summary) = block_on(async {
        node.pass(crash::JOURNAL_OPENED).await;
        let mission = Mission { brief: brief.clone(), ..Mission::of(&world, seed) };
        let last = journal.last().copied();
        let executed = |record: &Record| summary_so_far.borrow_mut().record(record);
        let sim = HopperSim::join(&mut node, mission, (journal, last), executed, args.terms()).await?;
        let mut sim = sim.holding_at_most(args.patience);
        tracing::info!(
            run = %brief.run, scenario = %brief.scenario, seed,
            "joined instance {:?} at decision {}, journal in {}",
            args.instance, sim.arbiter().state().decision, args.journal.display()
        );
        let exit = process::run(&mut sim, &mut node).await?;
        Ok::<_, Failure>((exit, sum_up(&summary_so_far.borrow(), &sim, node.pid())))
    })?;
    print_summary(&summary, args.format)?;
    // A child of `hopper run` leaves that word to its parent.
    if exit == Exit::Interrupted && !args.lifeline {
        let journal = args.journal.display();
        tracing::warn!("interrupted: the same command with --journal {journal} resumes the mission");
    }
    Ok(exit)
}

impl Args {
    fn terms(&self) -> SimTerms {
        SimTerms {
            pace: self.mission.pace,
            linger_ns: nanoseconds(self.linger),
            control: self.control,
            deadlines: true,
            terms: Terms { wait: self.wait, stay: false },
        }
    }
}

/// A duration in nanoseconds; one that is longer than any clock runs is as long as that.
fn nanoseconds(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}

/// The summary as the mission stands, with the processes that took part.
fn sum_up<O: FnMut(&Record)>(
    summary: &SummaryBuilder,
    sim: &HopperSim<Node, Journal, O>,
    own_pid: u32,
) -> Summary {
    let arbiter = sim.arbiter();
    let mut summary = summary.build(arbiter.state(), arbiter.team(), arbiter.refusals());
    let processes = std::iter::once((Role::HopperSim, own_pid)).chain(sim.lives());
    summary.processes = processes.map(|(role, pid)| Process { role, pid, restarts: 0 }).collect();
    summary
}

/// Writes the summary to standard output.
///
/// # Errors
/// If standard output is closed.
pub fn print_summary(summary: &Summary, format: report::Format) -> Result<(), Failure> {
    let text = match format {
        report::Format::Text => summary.to_string(),
        report::Format::Json => serde_json::to_string(summary).map_err(Failure::run)?,
    };
    match writeln!(std::io::stdout(), "{}", text.trim_end()) {
        // Whoever reads no further has what they wanted; the mission's outcome stands.
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        written => written.map_err(|error| {
            Failure::run(format!("the summary cannot be written to standard output: {error}"))
        }),
    }
}

/// Opens the journal of this very mission, or begins one.
///
/// # Errors
/// If the folder holds another mission's journal, a damaged one, or one in use.
pub fn open_journal(dir: &Path, world: &ResolvedScenario, seed: u64, sync: bool) -> Result<Journal, Failure> {
    let expected = JournalHeader::new(world, seed);
    let journal = if Journal::exists(dir) {
        Journal::resume(dir, &expected, &world.terrain, sync).map_err(|error| match &error {
            JournalError::Mismatch { .. } => Failure::new(
                error.exit(),
                format!(
                    "{}: {error}; ask for its own mission, or name another folder for this one",
                    dir.display()
                ),
            ),
            _ => error.into(),
        })?
    } else {
        Journal::create(dir, &expected.with_run(node::random_run()?), sync)?
    };
    warn_of_torn_tail(&journal);
    Ok(journal)
}

/// Opens the journal of `run`, which has published decisions: they are never flown again.
///
/// # Errors
/// If it is gone, another run's, in use, damaged, or shorter than what was published.
fn resume_journal(args: &Args, world: &ResolvedScenario, run: RunId) -> Result<Journal, Failure> {
    let expected = JournalHeader::new(world, args.mission.seed()).with_run(run);
    let journal = Journal::resume_run(&args.journal, &expected, &world.terrain, args.sync).map_err(
        |error| match error.exit() {
            Exit::Peer => Failure::new(Exit::Peer, error.to_string()),
            _ => Failure::run(format!("run {run} cannot be resumed, and is not begun anew: {error}")),
        },
    )?;
    let (need, got) = (args.published, journal.len());
    if got < need {
        return Err(Failure::run(format!(
            "run {run} cannot be resumed, and no hop is flown twice: {} needs the {need} decisions that were \
             published, got {got}",
            args.journal.display()
        )));
    }
    warn_of_torn_tail(&journal);
    Ok(journal)
}

fn warn_of_torn_tail(journal: &Journal) {
    if journal.torn_bytes() > 0 {
        tracing::warn!(
            "cut off {} bytes of a record that a killed process left incomplete",
            journal.torn_bytes()
        );
    }
}

fn run_id(text: &str) -> Result<RunId, String> {
    u128::from_str_radix(text, 16)
        .map(RunId)
        .map_err(|error| format!("a run is 32 hexadecimal digits; {error}"))
}
