//! One simulated process: a machine in the shell that its real work loop would be.
//!
//! Each role's turn repeats what its shell does between machine and port, in the same order: which queue
//! is read when, what is newest-wins, where the named points lie, when it beats and when it leaves. A turn
//! is cut into steps, so that a process may die or be stopped between any two of them.

mod arbitration;
mod charting;
mod piloting;
mod watching;

use std::collections::VecDeque;
use std::rc::Rc;

use contract::roster::BEAT_PERIOD_NS;
use contract::{
    Decision, Heartbeat, Incarnation, MapPage, MapPatch, MapRequest, MonotonicNs, Name, PastPage,
    PastRequest, Policy, Record, RobotId, Role, Roster, RunId, Status, TruthPage, TruthRequest,
};
use hopper_sim::{Arbiter, Journal, Storage, crash};
use monitor::Watcher;
use perception::Cartographer;
use planner::pilot::{Commission, Pilot};
use planner::{Plan, Planner};

use super::message::{Message, Topic};
use super::stage::{Blow, Happening, MS, Stage};

/// How long a work loop sleeps at most, nanoseconds.
const TICK_NS: u64 = 10 * MS;

/// How often the monitor looks, nanoseconds.
const MONITOR_PERIOD_NS: u64 = 50 * MS;

/// A peer that has seen the end of the mission goes on beating this long, nanoseconds.
const FAREWELL_NS: u64 = 120 * MS;

/// How long the end is served at most, nanoseconds.
pub(super) const LINGER_NS: u64 = 2_000 * MS;

/// What can be asked for.
const PAST: usize = 0;
const TRUTH: usize = 1;
const MAP: usize = 2;

/// How a turn of the work loop went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Turned {
    /// To its end; the next is scheduled.
    Done,
    /// It was stopped, or is planning, and will go on.
    Pending,
    /// The process died, and is started again after so many nanoseconds.
    Died(u64),
    /// The process left, its work done.
    Left,
}

/// A step of a turn.
#[derive(Debug)]
enum Step {
    /// A named point.
    Pass(&'static str),
    /// hopper-sim publishes the brief.
    Announce,
    Arbiter(hopper_sim::Event),
    ForArbiter(hopper_sim::Effect),
    Commit(Box<Record>),
    /// hopper-sim ticks, once the crew is assembled.
    TickIfAssembled,
    /// hopper-sim answers for the past, then for the truth.
    Serve,
    /// perception answers for the map.
    ServeMap,
    Cartographer(perception::Event),
    ForCartographer(perception::Effect),
    PublishMap(MonotonicNs),
    /// A planner tells of the policy behind its command, since somebody listens.
    PublishPolicy(Box<Policy>),
    PublishPart(Box<MapPatch>),
    Pilot(planner::pilot::Event),
    ForPilot(planner::pilot::Effect),
    Watcher(Box<monitor::Event>),
    ForWatcher(monitor::Effect),
    /// What was put off is carried out now.
    Execute,
    /// Beats, leaves or goes to sleep.
    Close,
}

/// What is at a process's core.
#[allow(clippy::large_enum_variant, reason = "there are five of them")]
enum Machine {
    Sim { arbiter: Arbiter, journal: Journal<Box<dyn Storage>>, assembled: bool, finished: Option<Status> },
    Perception { cartographer: Cartographer },
    Planner { pilot: Pilot, commission: Commission, planner: Box<dyn Planner>, blind: bool },
    Monitor { watcher: Watcher },
}

/// One life of one process.
pub(super) struct Process {
    pub slot: usize,
    pub role: Role,
    pub life: Incarnation,
    pub pid: u32,
    machine: Machine,
    inbox: [VecDeque<Message>; Topic::ALL.len()],
    /// The rest of this turn.
    agenda: VecDeque<Step>,
    /// What comes before it: effects of what was just heard.
    steps: VecDeque<Step>,
    /// Effects that the shell carries out once all is heard.
    deferred: VecDeque<Step>,
    executing: bool,
    /// When the next turn is.
    turn_ns: Option<u64>,
    /// Whether an event came while a turn was on.
    rung: bool,
    pub stopped_until: Option<u64>,
    planning: Option<(Plan, MonotonicNs)>,
    last_beat: Heartbeat,
    beat_at: Option<MonotonicNs>,
    roster: Roster,
    ended: Option<MonotonicNs>,
    stays: bool,
    /// Requests so far for past, truth and map, and whether the last waits for its answer.
    asked: [(u64, bool); 3],
}

impl Process {
    fn new(
        slot: usize,
        life: Incarnation,
        pid: u32,
        machine: Machine,
        stays: bool,
        first: Vec<Step>,
    ) -> Self {
        let (role, planner) = match &machine {
            Machine::Sim { .. } => (Role::HopperSim, Name::NONE),
            Machine::Perception { .. } => (Role::Perception, Name::NONE),
            Machine::Planner { commission, .. } => (Role::Planner, commission.planner),
            Machine::Monitor { .. } => (Role::Monitor, Name::NONE),
        };
        let last_beat = Heartbeat {
            role,
            incarnation: life,
            pid,
            version: Name::NONE,
            planner,
            counter: 0,
            run: RunId::default(),
            decision: Decision(0),
            status: Status::Underway,
        };
        Self {
            slot,
            role,
            life,
            pid,
            machine,
            inbox: Default::default(),
            agenda: first.into(),
            steps: VecDeque::new(),
            deferred: VecDeque::new(),
            executing: false,
            turn_ns: None,
            rung: false,
            stopped_until: None,
            planning: None,
            last_beat,
            beat_at: None,
            roster: Roster::default(),
            ended: None,
            stays,
            asked: [(0, false); 3],
        }
    }

    /// hopper-sim, its journal open.
    pub fn sim(
        slot: usize,
        life: Incarnation,
        pid: u32,
        journal: Journal<Box<dyn Storage>>,
        stage: &mut Stage<'_>,
    ) -> Self {
        let mission = stage.witness.mission().clone();
        let (pace, now) = (stage.setup.pace, stage.now());
        let arbiter = Arbiter::new(mission, journal.last(), pace, LINGER_NS, now);
        let machine = Machine::Sim { arbiter, journal, assembled: false, finished: None };
        let first =
            vec![Step::Pass(crash::JOURNAL_OPENED), Step::Announce, Step::Pass(crash::JOINED), Step::Close];
        Self::new(slot, life, pid, machine, false, first)
    }

    /// perception.
    pub fn perception(slot: usize, life: Incarnation, pid: u32, stays: bool, patch_cells: usize) -> Self {
        let cartographer = Cartographer::new(RobotId(0)).with_patches_of(patch_cells);
        let machine = Machine::Perception { cartographer };
        Self::new(slot, life, pid, machine, stays, vec![Step::Pass("perception.joined"), Step::Close])
    }

    /// A planner.
    pub fn planner(
        slot: usize,
        commission: Commission,
        planner: Box<dyn Planner>,
        blind: bool,
        stays: bool,
    ) -> Self {
        let Commission { incarnation, pid, .. } = commission;
        let machine = Machine::Planner { pilot: Pilot::new(commission), commission, planner, blind };
        Self::new(slot, incarnation, pid, machine, stays, vec![Step::Pass("planner.joined"), Step::Close])
    }

    /// A monitor.
    pub fn monitor(slot: usize, life: Incarnation, pid: u32, stays: bool) -> Self {
        let machine = Machine::Monitor { watcher: Watcher::new(RobotId(0)) };
        Self::new(slot, life, pid, machine, stays, vec![Step::Pass("monitor.joined"), Step::Close])
    }

    /// A message is there.
    pub fn receive(&mut self, message: Message, stage: &mut Stage<'_>) {
        let topic = message.topic();
        let queue = &mut self.inbox[topic as usize];
        if queue.len() >= topic.buffer() {
            queue.pop_front();
            if topic.buffer() > 1 {
                stage.coverage.count("overflow", topic.as_str());
            }
        }
        queue.push_back(message);
        if topic.wakes(self.role) {
            self.ring(stage);
        }
    }

    fn ring(&mut self, stage: &mut Stage<'_>) {
        if self.is_idle() {
            let at_ns = stage.time_ns + stage.wake_ns();
            self.turn_at(at_ns, stage);
        } else {
            self.rung = true;
        }
    }

    fn is_idle(&self) -> bool {
        self.steps.is_empty()
            && self.agenda.is_empty()
            && self.planning.is_none()
            && self.stopped_until.is_none()
    }

    fn turn_at(&mut self, at_ns: u64, stage: &mut Stage<'_>) {
        if self.turn_ns.is_none_or(|due_ns| at_ns < due_ns) {
            self.turn_ns = Some(at_ns);
            stage.schedule(at_ns, Happening::Turn(self.slot, self.life));
        }
    }

    /// SIGSTOP until `until_ns`.
    pub fn stop(&mut self, until_ns: u64, stage: &mut Stage<'_>) {
        let until_ns = self.stopped_until.map_or(until_ns, |known| known.max(until_ns));
        self.stopped_until = Some(until_ns);
        stage.schedule(until_ns, Happening::Resume(self.slot, self.life));
    }

    /// SIGCONT, if it is time: goes on where it was stopped.
    pub fn resume(&mut self, stage: &mut Stage<'_>) -> Turned {
        if self.stopped_until.is_none_or(|until_ns| until_ns > stage.time_ns) {
            return Turned::Pending;
        }
        self.stopped_until = None;
        stage.coverage.count("process", "resumed");
        if self.planning.is_some() {
            return Turned::Pending;
        }
        if self.is_idle() {
            self.turn_ns = None;
            self.begin_turn(stage);
        }
        self.work(stage)
    }

    /// A turn is due, unless it was brought forward or the process is busy.
    pub fn turn(&mut self, stage: &mut Stage<'_>) -> Turned {
        if self.turn_ns != Some(stage.time_ns) || !self.is_idle() {
            return Turned::Pending;
        }
        self.turn_ns = None;
        self.begin_turn(stage);
        self.work(stage)
    }

    /// Planning is done; a process that was stopped meanwhile takes note when it goes on.
    pub fn planned(&mut self, stage: &mut Stage<'_>) -> Turned {
        if let Some(until_ns) = self.stopped_until {
            stage.schedule(until_ns, Happening::Planned(self.slot, self.life));
            return Turned::Pending;
        }
        let Some((plan, started)) = self.planning.take() else { return Turned::Pending };
        let ended = stage.now();
        self.steps.push_front(Step::Pilot(planner::pilot::Event::Planned(plan, started, ended)));
        self.steps.push_front(Step::Pass("planner.planned"));
        self.work(stage)
    }

    /// The first turn of a life.
    pub fn begin(&mut self, stage: &mut Stage<'_>) -> Turned {
        self.work(stage)
    }

    fn take(&mut self, topic: Topic) -> VecDeque<Message> {
        std::mem::take(&mut self.inbox[topic as usize])
    }

    fn newest(&mut self, topic: Topic) -> Option<Message> {
        self.take(topic).pop_back()
    }

    /// The beats of others, taken note of.
    fn beats(&mut self, stage: &mut Stage<'_>) -> Vec<Heartbeat> {
        let now = stage.now();
        let beats: Vec<Heartbeat> = self.take(Topic::Heartbeat).iter().filter_map(beat_of).collect();
        for beat in &beats {
            self.roster.observe(*beat, now);
            let heard = stage.monotonic();
            stage.witness.heard(self.life, beat, heard);
        }
        beats
    }

    /// The answers to the last request for the past.
    fn pages(&mut self) -> Vec<PastPage> {
        self.answers(PAST, Topic::Answered, |message| match message {
            Message::Answered(page, number) => Some(((*page).clone(), number)),
            _ => None,
        })
    }

    /// The answers to the last request for the truth.
    fn truth_pages(&mut self) -> Vec<TruthPage> {
        self.answers(TRUTH, Topic::TruthAnswered, |message| match message {
            Message::TruthAnswered(page, number) => Some(((*page).clone(), number)),
            _ => None,
        })
    }

    /// The answers to the last request for the map.
    fn map_pages(&mut self) -> Vec<MapPage> {
        self.answers(MAP, Topic::MapAnswered, |message| match message {
            Message::MapAnswered(page, number) => Some(((*page).clone(), number)),
            _ => None,
        })
    }

    fn answers<P>(&mut self, of: usize, topic: Topic, page: impl Fn(Message) -> Option<(P, u64)>) -> Vec<P> {
        let mut pages = Vec::new();
        for (answer, number) in self.take(topic).into_iter().filter_map(page) {
            if self.asked[of] == (number, true) {
                self.asked[of].1 = false;
                pages.push(answer);
            }
        }
        pages
    }

    /// Reads the ports in the order of the shell.
    fn begin_turn(&mut self, stage: &mut Stage<'_>) {
        let mut agenda = VecDeque::new();
        match self.role {
            Role::HopperSim => {
                for message in self.take(Topic::Command) {
                    if let Message::Command(command) = message {
                        agenda.push_back(Step::Arbiter(hopper_sim::Event::Command((*command).clone())));
                    }
                }
                if let Some(Message::Policy(policy)) = self.newest(Topic::Policy) {
                    agenda.push_back(Step::Arbiter(hopper_sim::Event::Policy((*policy).clone())));
                }
                for beat in self.beats(stage) {
                    agenda.push_back(Step::Arbiter(hopper_sim::Event::Heartbeat(beat)));
                }
                agenda.extend([Step::TickIfAssembled, Step::Serve]);
            }
            Role::Perception => {
                self.beats(stage);
                if let Some(Message::Brief(brief)) = self.newest(Topic::Brief) {
                    agenda.push_back(Step::Cartographer(perception::Event::Brief(*brief)));
                }
                for page in self.truth_pages() {
                    agenda.push_back(Step::Cartographer(perception::Event::Truth(page)));
                }
                if let Some(Message::State(state)) = self.newest(Topic::State) {
                    agenda.push_back(Step::Pass("perception.state_received"));
                    agenda.push_back(Step::Cartographer(perception::Event::State(*state)));
                }
                for page in self.pages() {
                    agenda.push_back(Step::Cartographer(perception::Event::Past(page)));
                }
                agenda.extend([Step::Cartographer(perception::Event::Tick), Step::Execute, Step::ServeMap]);
            }
            Role::Planner => {
                for beat in self.beats(stage) {
                    agenda.push_back(Step::Pilot(planner::pilot::Event::Heartbeat(beat)));
                }
                if let Some(Message::Brief(brief)) = self.newest(Topic::Brief) {
                    agenda.push_back(Step::Pilot(planner::pilot::Event::Brief(*brief)));
                }
                if let Some(Message::State(state)) = self.newest(Topic::State) {
                    agenda.push_back(Step::Pilot(planner::pilot::Event::State(*state)));
                }
                for message in self.take(Topic::Map) {
                    if let Message::Map(patch) = message {
                        agenda.push_back(Step::Pass("planner.map_received"));
                        agenda.push_back(Step::Pilot(planner::pilot::Event::Patch((*patch).clone())));
                    }
                }
                for page in self.map_pages() {
                    agenda.push_back(Step::Pilot(planner::pilot::Event::Page(page)));
                }
                agenda.extend([Step::Pilot(planner::pilot::Event::Tick), Step::Execute]);
            }
            Role::Monitor => {
                let mut events: Vec<monitor::Event> =
                    self.beats(stage).into_iter().map(monitor::Event::Heartbeat).collect();
                if let Some(Message::Brief(brief)) = self.newest(Topic::Brief) {
                    events.push(monitor::Event::Brief(*brief));
                }
                if let Some(Message::Map(patch)) = self.newest(Topic::Map) {
                    events.push(monitor::Event::Map((*patch).clone()));
                }
                let mut passes = 0;
                for message in self.take(Topic::State) {
                    if let Message::State(state) = message {
                        passes += 1;
                        events.push(monitor::Event::State(*state));
                    }
                }
                events.extend(self.pages().into_iter().map(monitor::Event::Past));
                events.push(monitor::Event::Tick);
                agenda.extend((0..passes).map(|_| Step::Pass("monitor.state_received")));
                agenda.extend(events.into_iter().map(|event| Step::Watcher(Box::new(event))));
            }
        }
        agenda.push_back(Step::Close);
        self.agenda = agenda;
        self.executing = false;
    }

    /// Works through the turn until it ends or is cut short.
    fn work(&mut self, stage: &mut Stage<'_>) -> Turned {
        while let Some(step) = self.steps.pop_front().or_else(|| self.agenda.pop_front()) {
            let turned = match step {
                Step::Pass(point) => match stage.pass(point) {
                    Some(Blow::Kill { restart_ns }) => Turned::Died(restart_ns),
                    Some(Blow::Stop { ns }) => {
                        self.stop(stage.time_ns + ns, stage);
                        Turned::Pending
                    }
                    None => Turned::Done,
                },
                Step::Close => return self.close(stage),
                Step::Commit(record) => self.commit(&record, stage),
                Step::ForPilot(effect) => self.for_pilot(effect, stage),
                step => {
                    self.step(step, stage);
                    Turned::Done
                }
            };
            if turned != Turned::Done {
                return turned;
            }
        }
        Turned::Done
    }

    fn step(&mut self, step: Step, stage: &mut Stage<'_>) {
        match step {
            Step::Announce => self.announce(stage),
            Step::Arbiter(event) => self.arbitrate(event, stage),
            Step::ForArbiter(effect) => self.for_arbiter(effect, stage),
            Step::TickIfAssembled => {
                let now = stage.now();
                let Machine::Sim { arbiter, assembled, .. } = &mut self.machine else { return };
                *assembled |= arbiter.is_manned(&self.roster, now);
                if *assembled {
                    self.arbitrate(hopper_sim::Event::Tick, stage);
                }
            }
            Step::Serve => {
                self.serve(stage);
                self.serve_truth(stage);
            }
            Step::ServeMap => self.serve_map(stage),
            Step::Cartographer(event) => self.chart(event, stage),
            Step::ForCartographer(effect) => self.for_cartographer(effect, stage),
            Step::PublishMap(sensed) => self.publish_map(sensed, stage),
            Step::PublishPolicy(policy) => stage.publish(self.life, Message::Policy(Rc::new(*policy))),
            Step::PublishPart(patch) => self.publish_part(*patch, stage),
            Step::Pilot(event) => self.fly(event, stage),
            Step::Watcher(event) => self.watch(*event, stage),
            Step::ForWatcher(effect) => self.for_watcher(effect, stage),
            Step::Execute => {
                self.executing = true;
                self.steps.append(&mut self.deferred);
            }
            Step::Pass(_) | Step::Commit(_) | Step::ForPilot(_) | Step::Close => unreachable!("done by work"),
        }
    }

    /// Asks for the past; a request before it that has no answer yet is given up.
    fn ask(&mut self, request: PastRequest, stage: &mut Stage<'_>) {
        let number = self.number(PAST);
        stage.coverage.count("past", "asked");
        stage.publish(self.life, Message::Asked(request, number, self.life));
    }

    fn ask_truth(&mut self, request: TruthRequest, stage: &mut Stage<'_>) {
        let number = self.number(TRUTH);
        stage.coverage.count("truth", "asked");
        stage.publish(self.life, Message::TruthAsked(request, number, self.life));
    }

    fn ask_map(&mut self, request: MapRequest, stage: &mut Stage<'_>) {
        let number = self.number(MAP);
        stage.coverage.count("snapshot", "asked");
        stage.publish(self.life, Message::MapAsked(request, number, self.life));
    }

    /// The number of a new request.
    fn number(&mut self, of: usize) -> u64 {
        self.asked[of] = (self.asked[of].0 + 1, true);
        self.asked[of].0
    }

    fn answer(&self, client: Incarnation, answer: Message, stage: &mut Stage<'_>) {
        let asker = stage.readers.iter().copied().find(|reader| reader.life == client);
        if let Some(asker) = asker {
            stage.send(self.life, asker, answer);
        }
    }

    /// Closes the turn: beats, and leaves or sleeps.
    fn close(&mut self, stage: &mut Stage<'_>) -> Turned {
        let now = stage.now();
        let (run, decision, status) = match &self.machine {
            Machine::Sim { arbiter, .. } => {
                let state = arbiter.state();
                (state.run, state.decision, state.status)
            }
            Machine::Perception { cartographer, .. } => cartographer.seen(),
            Machine::Planner { pilot, .. } => pilot.seen(),
            Machine::Monitor { watcher } => watcher.seen(),
        };
        let due = self.beat_at.is_none_or(|at| now.since_ns(at) >= BEAT_PERIOD_NS);
        if due || (run, status) != (self.last_beat.run, self.last_beat.status) {
            let counter = self.last_beat.counter + 1;
            self.last_beat = Heartbeat { counter, run, decision, status, ..self.last_beat };
            self.beat_at = Some(now);
            stage.publish(self.life, Message::Heartbeat(Rc::new(self.last_beat)));
        }
        let farewell = self.ended.is_some_and(|ended| now.since_ns(ended) >= FAREWELL_NS);
        let done = match &self.machine {
            Machine::Sim { finished, .. } => finished.is_some(),
            _ => farewell && !self.stays,
        };
        if done {
            return Turned::Left;
        }
        let sleep_ns = match &self.machine {
            Machine::Sim { arbiter, assembled: true, .. } => arbiter
                .wake_at()
                .map_or(TICK_NS, |at| stage.time_of(at).saturating_sub(stage.time_ns).clamp(1_000, TICK_NS)),
            Machine::Monitor { .. } if !self.asked[PAST].1 => MONITOR_PERIOD_NS,
            _ => TICK_NS,
        };
        let sleep_ns =
            if std::mem::take(&mut self.rung) { stage.chance.between(1_000, 5_000) } else { sleep_ns };
        self.turn_at(stage.time_ns + sleep_ns, stage);
        Turned::Done
    }
}

/// Cells on a page of truth or map, in the scale of these worlds.
fn page_cells(stage: &Stage<'_>) -> usize {
    8 * stage.setup.page_records
}

fn beat_of(message: &Message) -> Option<Heartbeat> {
    match message {
        Message::Heartbeat(beat) => Some(**beat),
        _ => None,
    }
}

/// The process number of a life; each life of a simulation has one of its own.
pub(super) fn pid_of(life: Incarnation) -> u32 {
    life.0 as u32 + 1000
}
