//! `hopper view`: shows a past mission with the page of running ones.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use contract::{
    Account, Brief, Detail, DetailPage, MonotonicNs, MotionTable, PastPage, Policy, Record, RobotId, Route,
    RoutePage, State, Team,
};
use hopper_sim::{JournalReader, Mission};
use monitor::shell::{PAGE_ADDRESS, address, serve_on};
use monitor::web::Page;
use monitor::web::hosts::host_name;
use monitor::{History, Input, Watcher};
use node::{Exit, Failure, ShutdownSignal};
use planner::{Budget, Situation};
use scenario::ResolvedScenario;

use crate::commands::journal::folder;
use crate::mission::{Robots, Sensed};
use crate::tool;

/// The robot whose topics a mission is published on.
const ROBOT: RobotId = RobotId(0);

/// Arguments of `hopper view`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// Folder of a journal, output folder of a run, or a recording.
    #[arg(value_name = "JOURNAL|RUN|RECORDING")]
    path: PathBuf,
    #[command(flatten)]
    serve: ServeArgs,
}

/// Where the page of a past mission is served.
#[derive(clap::Args, Clone, Debug)]
pub struct ServeArgs {
    /// Address or port of the page; port 0 picks a free one, which the log names.
    #[arg(long, value_name = "ADDR", default_value = PAGE_ADDRESS, value_parser = address)]
    web: SocketAddr,
    /// Serve the page under this name too: that of a proxy, or of this machine in its network. May be repeated; localhost
    /// and numeric addresses need not be named.
    #[arg(long, value_name = "NAME", value_parser = host_name)]
    web_host: Vec<String>,
    /// Open the page in the browser of this desktop.
    #[arg(long)]
    open: bool,
}

/// Serves the page of the mission until Ctrl-C.
///
/// # Errors
/// If the path holds no mission, or the address cannot be had.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    if args.path.is_file() {
        // Recordings are read by a program of their own, which gets the same arguments.
        return tool::exec("hopper-recordings", std::env::args_os().skip(1));
    }
    let history = history_of_journal(&folder(&args.path)?)?;
    serve(history, &args.serve)
}

/// Serves the page of `history` until Ctrl-C.
///
/// # Errors
/// If the address cannot be had, or signals cannot be watched.
pub fn serve(mut history: History, args: &ServeArgs) -> Result<Exit, Failure> {
    // Before the page's address is known: from then on a signal may come.
    let shutdown = ShutdownSignal::new()?;
    history.end();
    if history.is_interrupted() {
        let decisions = history.hops().map_or(0, |hops| hops.due().0);
        tracing::warn!(
            "the mission was interrupted after {decisions} decisions, or is flown by another process: it has no outcome here"
        );
    }
    let page = Page::open(args.web, &args.web_host, false, Arc::new(Mutex::new(history)))?;
    if args.open {
        page.open_in_browser();
    }
    serve_on(&page, &shutdown, false, "")?;
    Ok(Exit::Done)
}

/// The history of the mission whose journal is in `dir`, as its monitor had it, with the policy behind the last
/// decision.
///
/// # Errors
/// If the journal cannot be read or is not sound, or the ground that it was flown on is not at hand.
pub fn history_of_journal(dir: &Path) -> Result<History, Failure> {
    let journal = JournalReader::open(dir)?;
    journal.require_sound()?;
    let (header, world) = (journal.header(), journal.world()?);
    let mut replay = Replay::begin(&header.brief, &world, header.seed);
    let mut records = journal.records();
    while let Some(record) = records.next().transpose()? {
        replay.record(&record, records.routes(), records.detail());
    }
    Ok(replay.end())
}

/// Passes on the prior of uncertain ground and the motion table of the planners, as hopper-sim would serve them. `hopper view` has the
/// scenario, and no hopper-sim.
pub fn gather_pages(history: &mut History, brief: &Brief, world: &ResolvedScenario, now: MonotonicNs) {
    let mission = Mission { brief: brief.clone(), ..Mission::of(world, 0) };
    let wanted = history.wanted(now);
    let prior = wanted.prior.and_then(|request| mission.prior_page(&request, brief.grid.cells()));
    let table = wanted.table.and_then(|request| mission.table_page(&request, MotionTable::ROWS));
    prior
        .map(Input::Prior)
        .into_iter()
        .chain(table.map(Input::Table))
        .for_each(|page| _ = history.on(page, now));
}

/// The processes of a mission as far as a page needs them, fed from its journal.
struct Replay<'a> {
    brief: &'a Brief,
    table: Option<Arc<MotionTable>>,
    history: History,
    watcher: Watcher,
    sensed: Sensed,
    robots: Option<Robots>,
    last: State,
}

impl<'a> Replay<'a> {
    fn begin(brief: &'a Brief, world: &ResolvedScenario, seed: u64) -> Self {
        let now = MonotonicNs(1);
        let sensed = Sensed::new(world, brief, seed);
        let mut replay = Self {
            brief,
            table: world.table.clone(),
            history: History::new(ROBOT),
            watcher: Watcher::new(ROBOT),
            robots: Robots::at_start(world, brief),
            last: State { landed: now, published: now, ..*sensed.state() },
            sensed,
        };
        replay.history.on(Input::Brief(brief), now);
        replay.watcher.on(monitor::Event::Brief(brief.clone()), now);
        if let Some(team) = replay.team() {
            replay.history.on(Input::Team(&team), now);
        }
        gather_pages(&mut replay.history, brief, world, now);
        replay.state();
        replay
    }

    fn record(&mut self, record: &Record, routes: &[Route], detail: Option<&Detail>) {
        self.sensed.record(record, routes);
        let committed = record.timing.committed;
        self.last = record.state_after(self.brief.run, committed, committed);
        if let Some(robots) = &mut self.robots {
            robots.record(record, routes);
        }
        self.state();
        self.announced(record, routes);
        if let Some(detail) = detail.cloned() {
            let (run, decision) = (self.brief.run, record.decision);
            self.history.on(Input::Detail(&DetailPage { run, decision, detail }), self.last.landed);
        }
    }

    /// All robots after the last record; `None` where there is a single hopper.
    fn team(&self) -> Option<Team> {
        self.robots.as_ref().map(|robots| robots.team(&self.last))
    }

    /// Passes on the route that the decision announced, if it announced one.
    fn announced(&mut self, record: &Record, routes: &[Route]) {
        let (run, now) = (self.brief.run, self.last.landed);
        let page = PastPage { run, robot: ROBOT, from: record.decision, records: vec![*record] };
        self.history.on(Input::Past(&page), now);
        let wanted = self.history.wanted(now).route;
        let route = wanted.and_then(|request| routes.iter().find(|route| route.id() == request.id));
        if let Some(route) = route.cloned() {
            self.history.on(Input::Route(&RoutePage { run, route }), now);
        }
    }

    /// Passes the newest state on, and what is seen from it.
    fn state(&mut self) {
        let (state, now) = (self.last, self.last.landed);
        self.history.on(Input::State(&state), now);
        self.watcher.on(monitor::Event::State(state), now);
        for patch in self.sensed.patches(now) {
            self.watcher.on(monitor::Event::Map(patch.clone()), now);
            self.history.on(Input::Patch(patch), now);
        }
        self.history.on(Input::Tick, now);
    }

    fn end(mut self) -> History {
        let now = self.last.landed;
        if let Some(team) = self.team() {
            self.history.on(Input::Team(&team), now);
            self.watcher.on(monitor::Event::Team(team), now);
        }
        if let Some(policy) = self.policy() {
            self.history.on(Input::Policy(policy), now);
        }
        if let Some(progress) = self.watcher.progress(now) {
            self.history.set_progress(progress);
        }
        self.history
    }

    /// The policy that the last planner in command had at the end, if it has one.
    fn policy(&self) -> Option<Policy> {
        if self.brief.account != Account::Hopper {
            return None;
        }
        let map = self.sensed.map();
        let mut planner = planner::algorithm(self.last.leader.planner.as_str()).ok()?;
        let mut state = self.last;
        if state.status.is_over()
            && let Some(last) = state.last
        {
            // Where the mission has ended there is nothing to plan for.
            state.pose.cell = last.from;
        }
        let leg = self.brief.leg(state.visits);
        let plan = planner.plan(
            &Situation { table: self.table.as_deref(), ..Situation::alone(self.brief, &leg, map, &state) },
            &Budget::default(),
        );
        Some(Policy {
            run: self.brief.run,
            robot: ROBOT,
            decision: state.decision,
            planner: planner.name(),
            error_bound: plan.error_bound,
            cells: planner.policy()?,
        })
    }
}
