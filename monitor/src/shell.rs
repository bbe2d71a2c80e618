//! The monitor process: shared memory, clock and standard error around the [`Watcher`].
//!
//! It is never woken by a message: it looks twenty times a second, so that watching costs the watched
//! nothing, and fills what it missed from `hop/past`. Who wants to see the ground, too, has it folded from
//! patches; policies, which cost the planner something, are asked for while somebody looks at them.

use std::net::SocketAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use contract::{Control, MapPage, MonotonicNs, Name, Order, Policy, Refusal, RobotId, Role, Status, Tempo};
use node::peer::{Attendance, PeerArgs, TICK, refuse};
use node::{
    BriefReader, ControlWriter, Exit, Failure, Instance, MapReader, Node, NodeError, PastClient,
    PolicyReader, SnapshotClient, StateReader, TempoReader, crash_point,
};

use crate::recorder::{RecordArgs, RecordNotes, Recorder};
use crate::terminal::{self, Terminal};
use crate::web::Page;
use crate::{Display, Effect, Event, History, Input, Watcher};

/// Points at which a test may kill this process: see [`node::crash_point`].
pub const CRASH_POINTS: &[&str] = &["monitor.joined", "monitor.state_received"];

/// How often the monitor looks.
const PERIOD: Duration = Duration::from_millis(50);

/// Pause between two looks at the policy, nanoseconds, and that for each cell: a planner that looks ahead only as
/// far as it must works out the rest for the eye, of 821 × 821 cells in a good part of a second.
const POLICY_PERIOD_NS: u64 = 250_000_000;
const POLICY_CELL_NS: u64 = 10_000;

/// Pause before a place among the policy's readers is tried for again, nanoseconds.
const POLICY_PLACE_NS: u64 = 2_000_000_000;

/// Where the page is served unless an address is given.
pub const PAGE_ADDRESS: &str = "127.0.0.1:8427";

/// What there is to see, beside a line a second.
#[derive(clap::Args, Clone, Debug)]
pub struct ViewArgs {
    /// Serve the mission as a page at this address or port; port 0 picks a free one, the log tells which.
    #[arg(long, value_name = "ADDR", num_args = 0..=1, default_missing_value = PAGE_ADDRESS, value_parser = address)]
    pub web: Option<SocketAddr>,
    /// Let page or terminal pause, step, change the pace, and hand over to a stand-by planner.
    #[arg(long)]
    pub control: bool,
}

/// Arguments of `monitor` and of `hopper monitor`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    #[command(flatten)]
    peer: PeerArgs,
    #[command(flatten)]
    view: ViewArgs,
    /// Show the mission on this terminal, of at least 80 columns by 24 rows, over ssh too.
    #[arg(long)]
    tui: bool,
    /// Print the last progress as one JSON object on standard output when the mission ends.
    #[arg(long, default_value = "text")]
    format: report::Format,
    #[command(flatten)]
    record: RecordArgs,
    #[command(flatten)]
    notes: RecordNotes,
}

/// An address with its port, or a port of this machine's loopback.
fn address(text: &str) -> Result<SocketAddr, String> {
    let port = text.parse().ok().map(|port: u16| SocketAddr::from(([127, 0, 0, 1], port)));
    let need = || format!("an address is e.g. {PAGE_ADDRESS}, [::1]:8427, or a port alone; got {text:?}");
    port.or_else(|| text.parse().ok()).ok_or_else(need)
}

/// Runs the process until the mission ends.
///
/// # Errors
/// If shared memory or the page's address cannot be had, or nobody came within `--wait`.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let robot = RobotId(0);
    let instance = Instance::new(&args.peer.instance)?;
    let mut node = Node::join(&instance, Role::Monitor, Name::NONE)?;
    if args.peer.lifeline {
        node.hold_lifeline();
    }
    let mut view = View::open(args, &mut node, robot)?;
    let mut ports = Ports::open(&mut node, robot)?;
    let recording = (&args.record, &args.notes);
    let mut recorder = Recorder::open(recording, &mut node, args.peer.lifeline, Node::now())?;
    crash_point("monitor.joined");
    tracing::info!("joined instance {:?}", args.peer.instance);

    let mut attendance = Attendance::new(&args.peer, &instance);
    let watched = watch(args, &mut node, &mut ports, view.as_mut(), recorder.as_mut(), &mut attendance);
    // Whatever ended the watch, what was recorded has an end.
    let recorded = recorder.map_or(Ok(()), |mut recorder| recorder.finish(Node::now()));
    watched.and_then(|exit| recorded.map(|()| exit))
}

/// Turns the work loop until the mission ends, or whoever looks has had enough.
fn watch(
    args: &Args,
    node: &mut Node,
    ports: &mut Ports,
    mut view: Option<&mut View>,
    mut recorder: Option<&mut Recorder>,
    attendance: &mut Attendance,
) -> Result<Exit, Failure> {
    let mut watcher = Watcher::new(RobotId(0));
    let mut display = if args.tui { Display::default() } else { Display::on_stderr() };
    // The end of the mission, for as long as the last records are waited for.
    let mut over: Option<Status> = None;
    loop {
        let period = if ports.past.is_waiting() { TICK } else { PERIOD };
        node.wait(recorder.as_ref().map_or(period, |recorder| recorder.period().min(period)));
        if node.stop_requested().is_some() {
            display.finish();
            return Ok(Exit::Interrupted);
        }
        recorder.as_mut().map_or(Ok(()), |recorder| recorder.turn(Node::now()))?;
        // The tempo first: whoever is told of a pause has been told of every landing before it. Then the page: with
        // it come all patches published before it was made.
        let tempo = view.as_mut().and_then(|view| view.tempos.newest()).and_then(known);
        let page = view.as_mut().and_then(|view| view.snapshots.receive()).and_then(known);
        let events = ports.receive(node, attendance);
        if let Some(view) = &mut view {
            view.take(node, &events, tempo, page)?;
        }
        for event in events {
            for effect in watcher.on(event, Node::now()) {
                match effect {
                    Effect::RequestPast(request) => ports.past.request(&request)?,
                    Effect::Progress(progress) => {
                        display.show(&progress, Node::now());
                        if let Some(view) = &view {
                            view.account().set_progress(*progress);
                        }
                    }
                    Effect::Finished(status) => {
                        display.finish();
                        print(&watcher, args.format)?;
                        over = Some(status);
                    }
                }
            }
        }
        if let Some(view) = &mut view
            && view.show()?
        {
            return Ok(Exit::Done);
        }
        let (run, decision, mut status) = watcher.seen();
        let is_whole = recorder.as_ref().is_none_or(|recorder| recorder.is_whole_until(run, decision));
        let nobody_to_ask = || !watcher.roster().has(Role::HopperSim, Node::now());
        if is_whole || (over.is_some() || status.is_over()) && nobody_to_ask() {
            if let Some(status) = over.take() {
                attendance.mission_ended(status);
            }
        } else {
            // The end is not seen before every decision is recorded, so that hopper-sim stays to be asked.
            status = Status::Underway;
        }
        if attendance.close_turn(node, (run, decision, status), watcher.waits_for())? {
            return Ok(Exit::Done);
        }
    }
}

/// What every monitor reads.
struct Ports {
    briefs: BriefReader,
    states: StateReader,
    maps: MapReader,
    past: PastClient,
}

impl Ports {
    fn open(node: &mut Node, robot: RobotId) -> Result<Self, NodeError> {
        Ok(Self {
            briefs: node.brief_reader()?,
            states: node.state_reader(robot)?,
            maps: node.map_reader(robot)?,
            past: node.past_client()?,
        })
    }

    /// Everything that came since, and that time has passed.
    fn receive(&mut self, node: &mut Node, attendance: &mut Attendance) -> Vec<Event> {
        let mut events: Vec<Event> = Vec::new();
        for beat in node.heartbeats() {
            if beat.as_ref().is_ok_and(|beat| !attendance.hear(beat)) {
                continue;
            }
            events.push(heard(beat, Event::Heartbeat));
        }
        events.extend(self.briefs.newest().map(|brief| heard(brief, Event::Brief)));
        // The maps first: the mission may end with the last of these states.
        events.extend(self.maps.drain().map(|map| heard(map, Event::Map)));
        for state in self.states.drain() {
            crash_point("monitor.state_received");
            events.push(heard(state, Event::State));
        }
        while let Some(page) = self.past.receive() {
            events.push(heard(page, Event::Past));
        }
        events.push(Event::Tick);
        events
    }
}

/// Page, terminal, or both, with the account they show and what it needs beyond other monitors.
struct View {
    account: Arc<Mutex<History>>,
    page: Option<Page>,
    terminal: Option<Terminal>,
    robot: RobotId,
    snapshots: SnapshotClient,
    tempos: TempoReader,
    controls: Option<ControlWriter>,
    /// Open while a policy is waited for: planners make them for listeners only.
    policies: Option<PolicyReader>,
    /// When the next policy is to be looked at.
    look: MonotonicNs,
    /// Whether it was told that no place is left to read policies.
    placeless: bool,
}

impl View {
    fn open(args: &Args, node: &mut Node, robot: RobotId) -> Result<Option<Self>, Failure> {
        let ViewArgs { web, control } = args.view;
        if web.is_none() && !args.tui {
            let alone = || Failure::new(Exit::Usage, "--control needs --web or --tui to give orders from");
            return if control { Err(alone()) } else { Ok(None) };
        }
        let account = Arc::new(Mutex::new(History::new(robot)));
        let page = web.map(|address| Page::open(address, control, Arc::clone(&account))).transpose()?;
        Ok(Some(Self {
            account,
            page,
            robot,
            snapshots: node.snapshot_client(robot)?,
            tempos: node.tempo_reader(robot)?,
            controls: control.then(|| node.control_writer(robot)).transpose()?,
            policies: None,
            look: MonotonicNs(0),
            placeless: false,
            terminal: args.tui.then(|| Terminal::open(control)).transpose()?,
        }))
    }

    fn account(&self) -> MutexGuard<'_, History> {
        self.account.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds to the account what came, asks perception for what is missing.
    fn take(
        &mut self,
        node: &Node,
        events: &[Event],
        tempo: Option<Tempo>,
        page: Option<MapPage>,
    ) -> Result<(), Failure> {
        let policy = self.policy(node);
        let mut request = None;
        let mut account = self.account();
        let mut add = |news: Input<'_>| request = account.on(news, Node::now()).or(request);
        for event in events {
            match event {
                Event::Brief(brief) => add(Input::Brief(brief)),
                Event::State(state) => add(Input::State(state)),
                Event::Past(page) => add(Input::Past(page)),
                Event::Map(patch) => add(Input::Patch(patch.clone())),
                Event::Heartbeat(beat) => add(Input::Heartbeat(beat)),
                Event::Refused(_) | Event::Tick => {}
            }
        }
        let (page, tempo) = (page.as_ref().map(Input::Page), tempo.map(Input::Tempo));
        let late = [page, tempo, policy.map(Input::Policy), Some(Input::Tick)];
        late.into_iter().flatten().for_each(add);
        drop(account);
        request.map_or(Ok(()), |request| self.snapshots.request(&request))?;
        Ok(())
    }

    /// Shows the account and passes orders on; whether whoever looks has had enough.
    fn show(&mut self) -> Result<bool, Failure> {
        let mut orders = Vec::new();
        if let Some(page) = &self.page {
            page.notify();
            orders.extend(page.orders());
        }
        if let Some(terminal) = &mut self.terminal {
            let account = self.account.lock().unwrap_or_else(PoisonError::into_inner);
            for order in terminal.turn(&account, Node::now())? {
                match order {
                    terminal::KeyAction::Quit => return Ok(true),
                    terminal::KeyAction::Order(order) => orders.push(order),
                }
            }
        }
        let run = self.account().brief().map(|brief| brief.run);
        if let (Some(run), Some(controls)) = (run, &self.controls) {
            for order in orders {
                tracing::info!("asked to {}", words(&order));
                controls.publish(&Control { run, robot: self.robot, order })?;
            }
            controls.idle()?;
        }
        Ok(false)
    }

    fn wants_policy(&self) -> bool {
        self.page.as_ref().is_some_and(Page::wants_policy)
            || self.terminal.as_ref().is_some_and(Terminal::wants_policy)
    }

    /// A policy, now and then, while somebody wants to see one.
    fn policy(&mut self, node: &Node) -> Option<Policy> {
        let now = Node::now();
        if !self.wants_policy() || now < self.look {
            self.policies = None;
            return None;
        }
        if self.policies.is_none() {
            match node.try_policy_reader(self.robot) {
                Ok(reader) => self.policies = Some(reader),
                Err(error) => {
                    if !std::mem::replace(&mut self.placeless, true) {
                        tracing::warn!("no policy is shown until there is a place to read it from: {error}");
                    }
                    self.look = now.plus_ns(POLICY_PLACE_NS);
                    return None;
                }
            }
        }
        let policy = self.policies.as_mut().and_then(|policies| policies.newest()).and_then(known);
        if let Some(policy) = &policy {
            self.look = now.plus_ns(POLICY_PERIOD_NS + POLICY_CELL_NS * policy.cells.len() as u64);
        }
        policy
    }
}

/// A message; a malformed one is told and dropped.
fn known<T>(message: Result<T, Refusal>) -> Option<T> {
    message.inspect_err(refuse).ok()
}

fn words(order: &Order) -> String {
    match order {
        Order::Pause => "pause".into(),
        Order::Resume => "go on".into(),
        Order::Step => "step".into(),
        Order::Pace(pace) => format!("land at pace {pace}"),
        Order::HandOver(life) => format!("hand over to the planner of life {life}"),
    }
}

/// A message as the watcher hears it; a malformed one is counted there.
fn heard<T>(message: Result<T, Refusal>, event: impl Fn(T) -> Event) -> Event {
    message.map_or_else(Event::Refused, event)
}

/// The last progress on standard output, for programs.
fn print(watcher: &Watcher, format: report::Format) -> Result<(), Failure> {
    use std::io::Write;
    let (report::Format::Json, Some(progress)) = (format, watcher.progress(Node::now())) else {
        return Ok(());
    };
    let text = serde_json::to_string(&progress).map_err(Failure::run)?;
    writeln!(std::io::stdout(), "{text}").map_err(Failure::run)
}
