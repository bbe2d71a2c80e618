//! The hopper-sim process: shared memory, clock and journal file around the [`Arbiter`].

use std::collections::{BTreeMap, VecDeque};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;

use contract::limits::TRUTH_PAGE_CELLS;
use contract::{
    Brief, Heartbeat, Incarnation, MonotonicNs, Name, Profile, Record, Refusal, RobotId, Role, Roster,
    Status, Tempo, TruthRequest,
};
use node::peer::{Builds, Patience, TICK, refuse};
use node::{
    BriefWriter, CommandReader, ControlReader, Exit, Failure, Instance, Node, PastServer, PolicyReader, Room,
    StateWriter, TempoWriter, TruthServer, crash_point,
};
use report::{Process, Summary, SummaryBuilder};
use scenario::{Overrides, ResolvedScenario, Scenario};

use crate::{Arbiter, Effect, Event, Journal, JournalError, JournalHeader, Mission, Pace, crash};

/// What a mission is about: the scenario with what the command line changes in it.
#[derive(clap::Args, Clone, Debug)]
pub struct MissionArgs {
    /// Scenario: hard, heterogeneous, sandy, … or a TOML file; `hopper scenario` explains.
    /// [default: hard]
    #[arg(long, value_name = "NAME|FILE")]
    pub scenario: Option<String>,
    /// Seed of the hops' scatter [default: 1].
    #[arg(long, allow_negative_numbers = true)]
    pub seed: Option<u64>,
    /// Reading of the model, instead of the scenario's: paper-2023 or hopper.
    #[arg(long, value_name = "NAME")]
    pub profile: Option<Profile>,
    /// Budget of one decision, landing to commit [default: the scenario's, 600ms].
    #[arg(long, value_parser = positive_duration, value_name = "DURATION", allow_hyphen_values = true)]
    pub budget: Option<Duration>,
    /// Elevation model, instead of the scenario's.
    #[arg(long, value_name = "FILE")]
    pub dem: Option<PathBuf>,
    /// How fast landings follow each other: max, real (as the hop flies), or a rate in hertz.
    #[arg(long, default_value = "max", value_name = "max|real|HZ", allow_negative_numbers = true)]
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
        self.scenario.is_some() || self.profile.is_some() || self.dem.is_some()
    }

    /// The world of the mission.
    ///
    /// # Errors
    /// Exit code 2 with what is wrong with the scenario or its terrain.
    pub fn world(&self) -> Result<ResolvedScenario, Failure> {
        self.scenario()?.resolve().map_err(Failure::usage)
    }

    /// The scenario of the mission, as the command line changes it.
    ///
    /// # Errors
    /// Exit code 2 if there is none, or it is not one.
    pub fn scenario(&self) -> Result<Scenario, Failure> {
        let overrides = Overrides {
            profile: self.profile,
            decision_budget_ns: self.budget.map(|budget| budget.as_nanos() as u64),
            dem: self.dem.clone(),
        };
        let scenario = scenario::load(self.scenario.as_deref().unwrap_or("hard")).map_err(Failure::usage)?;
        Ok(scenario.with(&overrides))
    }
}

/// How long before a landing hopper-sim no longer sleeps.
const AWAKE: Duration = Duration::from_micros(300);

/// Lives of one role that the summary names; a mission of any length stays bounded.
const LIVES_MAX: usize = 256;

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
    #[arg(long, default_value = "out/journal", value_name = "DIR")]
    journal: PathBuf,
    /// Force each record to the disk, so that the promise covers power loss too.
    #[arg(long)]
    sync: bool,
    /// Serve the end of the mission at most this long to peers that have not seen it.
    #[arg(long, default_value = "2s", value_parser = humantime::parse_duration, value_name = "DURATION")]
    linger: Duration,
    /// Give up with exit code 4 when no perception or no planner beats for this time, e.g. 30s
    /// [default: wait forever].
    #[arg(long, value_parser = humantime::parse_duration, value_name = "DURATION")]
    wait: Option<Duration>,
    /// Heed orders to pause, go on, step or change the pace, as the monitor's page gives them.
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
/// or nobody came within `--wait`.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let world = args.mission.world()?;
    let instance = Instance::new(&args.instance)?;
    let _claim = instance.claim(Role::HopperSim)?;
    let mut service = Service::open(args, &instance, world)?;
    let exit = service.serve(args)?;
    print_summary(&service.summary(), args.format)?;
    Ok(exit)
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
    let fault = |error: JournalError| Failure::new(error.exit(), error.to_string());
    let journal = if Journal::exists(dir) {
        Journal::resume(dir, &expected, sync).map_err(fault)?
    } else {
        Journal::create(dir, &expected.with_run(node::random_run()?), sync).map_err(fault)?
    };
    Ok(journal)
}

/// Everything that lives as long as the process serves.
struct Service {
    node: Node,
    arbiter: Arbiter,
    journal: Journal,
    summary: SummaryBuilder,
    roster: Roster,
    builds: Builds,
    /// The first lives heard of, by role: at most [`LIVES_MAX`] each.
    lives: BTreeMap<Role, Vec<(Incarnation, u32)>>,
    states: StateWriter,
    briefs: BriefWriter,
    truths: TruthServer,
    commands: CommandReader,
    controls: ControlReader,
    tempos: TempoWriter,
    /// The tempo told last.
    told: Option<Tempo>,
    /// Listened to only where there may be a fallback: planners write policies for listeners alone.
    policies: Option<PolicyReader>,
    past: PastServer,
    assembled: bool,
    /// Whether the last append failed.
    holding: bool,
    finished: Option<Status>,
}

impl Service {
    fn open(args: &Args, instance: &Instance, world: ResolvedScenario) -> Result<Self, Failure> {
        let journal = open_journal(&args.journal, &world, args.mission.seed(), args.sync)?;
        crash_point(crash::JOURNAL_OPENED);
        if journal.torn_bytes() > 0 {
            tracing::warn!(
                "cut {} bytes that a death tore off the journal's last record",
                journal.torn_bytes()
            );
        }
        let brief = Brief { run: journal.header().run(), ..world.brief };
        let robot = RobotId(0);
        Room::of(brief.grid.cells(), brief.robots)?.check(instance)?;
        let mut node = Node::join(instance, Role::HopperSim, Name::NONE)?;
        if args.lifeline {
            node.hold_lifeline();
        }
        let mut summary = SummaryBuilder::new(&brief, args.mission.seed());
        for record in journal.records() {
            summary.record(&record.map_err(Failure::run)?);
        }
        let mut service = Self {
            briefs: node.brief_writer()?,
            truths: node.truth_server()?,
            states: node.state_writer(robot)?,
            commands: node.command_reader(robot)?,
            controls: node.control_reader(robot)?,
            tempos: node.tempo_writer(robot)?,
            told: None,
            policies: (brief.guard.deadline_ns > 0).then(|| node.policy_reader(robot)).transpose()?,
            past: node.past_server()?,
            arbiter: Arbiter::new(
                Mission { brief, terrain: world.terrain, seed: args.mission.seed() },
                journal.last(),
                args.mission.pace,
                args.linger.as_nanos() as u64,
                Node::now(),
            ),
            node,
            journal,
            summary,
            roster: Roster::default(),
            builds: Builds::default(),
            lives: BTreeMap::new(),
            assembled: false,
            holding: false,
            finished: None,
        };
        if args.control {
            service.arbiter = service.arbiter.heeding_orders();
        }
        service.node.listen(&contract::service::command(robot))?;
        service.announce()?;
        crash_point(crash::JOINED);
        tracing::info!(
            run = %brief.run, scenario = %brief.scenario, seed = args.mission.seed(),
            "joined instance {:?} at decision {}", args.instance, service.arbiter.state().decision
        );
        Ok(service)
    }

    /// Tells of the run: once, and again when a peer has missed it.
    fn announce(&self) -> Result<(), Failure> {
        self.briefs.publish(&self.arbiter.mission().brief)?;
        Ok(())
    }

    /// Tells of the tempo when it has changed.
    fn tell_tempo(&mut self) -> Result<(), Failure> {
        let tempo = self.arbiter.tempo();
        if self.told != Some(tempo) {
            if self.told.is_some() {
                tracing::info!(paused = tempo.paused, pace = %tempo.pace, "told to change the tempo");
            }
            self.told = Some(tempo);
            self.tempos.publish(&tempo)?;
        }
        Ok(self.tempos.idle()?)
    }

    fn serve(&mut self, args: &Args) -> Result<Exit, Failure> {
        let mut patience = Patience::new(args.wait, self.node.instance());
        loop {
            self.node.wait(self.timeout());
            if self.node.stop_requested().is_some() {
                return Ok(Exit::Interrupted);
            }
            for command in self.commands.drain().collect::<Vec<_>>() {
                let command = command.and_then(|command| match self.builds.refuse(command.incarnation) {
                    Some(refusal) => Err(refusal),
                    None => Ok(command),
                });
                self.feed(Event::Command(command))?;
            }
            for control in self.controls.drain().collect::<Vec<_>>() {
                self.feed(Event::Control(control))?;
            }
            match self.policies.as_mut().and_then(|policies| policies.newest()) {
                Some(Ok(policy)) => self.feed(Event::Policy(policy))?,
                Some(Err(refusal)) => self.refused(refusal)?,
                None => {}
            }
            for beat in self.node.heartbeats() {
                match beat {
                    Ok(beat) if self.builds.admit(&beat) => {
                        self.meet(&beat);
                        self.feed(Event::Heartbeat(beat))?;
                    }
                    Ok(_) => {}
                    Err(refusal) => self.refused(refusal)?,
                }
            }
            if self.is_assembled() {
                self.feed(Event::Tick)?;
            }
            let due = self.arbiter.state().decision;
            let Self { past, journal, .. } = self;
            let refusals = past.serve(|request| {
                let ours = request.run == journal.header().run();
                let mut page = journal
                    .page(request.from)
                    .inspect_err(|error| tracing::error!("the past cannot be served: {error}"))
                    .ok()
                    .filter(|_| ours)?;
                // A hop that is still in the air has not been seen to land.
                page.records.retain(|record| record.decision < due);
                Some(page)
            })?;
            let Self { truths, arbiter, .. } = self;
            let page = |request: &TruthRequest| arbiter.mission().truth_page(request, TRUTH_PAGE_CELLS);
            let of_truth = truths.serve(page)?;
            for refusal in refusals.into_iter().chain(of_truth) {
                self.refused(refusal)?;
            }
            self.states.idle()?;
            self.briefs.idle()?;
            self.tell_tempo()?;
            let state = *self.arbiter.state();
            self.node.beat(state.run, state.decision, state.status)?;
            if let Some(status) = self.finished {
                return Ok(if status == Status::Goal { Exit::Done } else { Exit::Failed });
            }
            let now = Node::now();
            patience.check(self.waits_for(now), now)?;
        }
    }

    /// Tells of a malformed message, and counts it.
    fn refused(&mut self, refusal: Refusal) -> Result<(), Failure> {
        refuse(&refusal);
        self.feed(Event::Refused(refusal))
    }

    /// The mission begins once somebody can sense and somebody plans, so that no decision's time counts the
    /// wait for processes to start, or for perception to gather the truth. A mission that is over is told to
    /// whoever comes, and one that was under way with a fallback is taken up at once.
    fn is_assembled(&mut self) -> bool {
        let now = Node::now();
        self.assembled |= self.arbiter.is_manned(&self.roster, now);
        self.assembled
    }

    /// Until the next moment that matters: a tick, or shortly before the landing, which is then awaited
    /// awake, since a sleeping process wakes a tenth of a millisecond late.
    fn timeout(&self) -> Duration {
        if !self.assembled {
            return TICK;
        }
        let due = self.arbiter.wake_at().map(|at| Duration::from_nanos(at.since_ns(Node::now())));
        due.map_or(TICK, |due| due.saturating_sub(AWAKE).min(TICK))
    }

    fn feed(&mut self, event: Event) -> Result<(), Failure> {
        let mut effects: VecDeque<_> = self.arbiter.on(event, Node::now()).into();
        while let Some(effect) = effects.pop_front() {
            match effect {
                Effect::Append(record) => effects.extend(self.append(&record)),
                Effect::Announce => self.announce()?,
                Effect::Publish(state) => {
                    self.states.publish(&state)?;
                    crash_point(crash::PUBLISHED);
                }
                Effect::Refused(refusal) => tracing::debug!(reason = refusal.reason(), "refused: {refusal}"),
                Effect::Finished(status) => self.finished = Some(status),
            }
        }
        Ok(())
    }

    /// The commit point.
    fn append(&mut self, record: &Record) -> Vec<Effect> {
        crash_point(crash::BEFORE_APPEND);
        match self.journal.append(record) {
            Ok(()) => {
                crash_point(crash::APPENDED);
                let now = Node::now();
                let mut committed = *record;
                committed.timing.committed = now;
                self.summary.record(&committed);
                if record.origin.is_fallback() {
                    let (decision, action, origin) = (record.decision, record.action, record.origin);
                    tracing::warn!(
                        "no acceptable command for decision {decision}: fell back to {action}, by {origin}"
                    );
                }
                if std::mem::take(&mut self.holding) {
                    tracing::info!("the journal took decision {}: going on", record.decision);
                }
                self.arbiter.on(Event::Appended, now)
            }
            Err(error) => {
                // Tried again at every tick: said once.
                if !std::mem::replace(&mut self.holding, true) {
                    tracing::error!("holding at decision {}: {error}", record.decision);
                }
                self.arbiter.on(Event::AppendFailed, Node::now())
            }
        }
    }

    fn meet(&mut self, beat: &Heartbeat) {
        self.roster.observe(*beat, Node::now());
        let lives = self.lives.entry(beat.role).or_default();
        let is_known = lives.iter().any(|(incarnation, _)| *incarnation == beat.incarnation);
        if !is_known && lives.len() < LIVES_MAX {
            lives.push((beat.incarnation, beat.pid));
        }
    }

    fn waits_for(&self, now: MonotonicNs) -> Option<&'static str> {
        if self.arbiter.state().status.is_over() {
            None
        } else if !self.roster.has(Role::Perception, now) {
            Some("perception")
        } else if !self.roster.has(Role::Planner, now) {
            Some("a planner")
        } else {
            None
        }
    }

    fn summary(&self) -> Summary {
        let mut summary = self.summary.build(self.arbiter.state(), self.arbiter.refusals());
        let own = Process { role: Role::HopperSim, pid: self.node.pid(), restarts: 0 };
        let heard = self.lives.iter().flat_map(|(role, lives)| {
            lives.iter().map(|(_, pid)| Process { role: *role, pid: *pid, restarts: 0 })
        });
        summary.processes = std::iter::once(own).chain(heard).collect();
        summary
    }
}
