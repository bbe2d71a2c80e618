//! What simulated processes stand on: time, the network between them, the disk, and the checker.

use std::any::Any;
use std::cell::RefCell;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::rc::{Rc, Weak};

use contract::protocol::peer_table::SILENCE_NS;
use contract::{
    Command, Incarnation, MapPage, MapPatch, MapRequest, MonotonicNs, PriorPage, PriorRequest, Refusal,
    RobotId, Role, RoutePage, RouteRequest,
};
use serde::Serialize;

use crate::chance::Chance;
use crate::checker::Checker;
use crate::chosen;
use crate::coverage::Coverage;
use crate::disk::Disk;
use crate::fault::Kind;
use crate::life::Life;
use crate::route_memory::RouteMemory;
use crate::setup::Setup;
use crate::stamps::Stamps;
use crate::stream::{Answered, Asked, Stream};

/// How long a message takes, nanoseconds.
const TRANSPORT_NS: u64 = 5_000;

/// Turns that may end before a message is read: that in which it came, perhaps behind its reader's back, and the next,
/// in which an answer that came twice is received once.
const TURNS_UNREAD: u64 = 2;

/// Sleeps of a life before they are judged. One in forty wake-ups takes more than 1 ms; without a wake-up most sleeps do.
const SLEEPS_MIN: u64 = 16;

/// A millisecond, nanoseconds.
pub(crate) const MS: u64 = 1_000_000;

/// The world as its processes share it.
pub(crate) type Shared = Rc<RefCell<World>>;

/// Something that will happen.
pub(crate) enum Event {
    /// The sleep of a life ends, if it still means to at this moment.
    Wake(usize, Incarnation),
    /// A message reaches a reader.
    Arrive(Letter),
    /// A life is done computing.
    Computed(usize, Incarnation),
    /// A stopped life goes on.
    Resume(usize, Incarnation),
    /// A process is started.
    Start(usize),
    /// The fault of this number begins.
    Fault(usize),
    /// The disk has room again.
    DiskFreed,
    /// The journal is at its path again.
    JournalBack,
}

/// A message on its way.
pub(crate) struct Letter {
    stream: Stream,
    writer: Incarnation,
    pub reader: Rc<Life>,
    wakes: bool,
    /// Its number among those from this writer to this reader on its stream.
    number: u64,
    /// Puts it into the reader's queue, if that is still open; whether an older message gave way.
    deliver: Box<dyn FnOnce() -> bool>,
}

struct Scheduled {
    at_ns: u64,
    order: u64,
    event: Event,
}

impl PartialEq for Scheduled {
    fn eq(&self, other: &Self) -> bool {
        self.order == other.order
    }
}
impl Eq for Scheduled {}
impl PartialOrd for Scheduled {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Scheduled {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        (self.at_ns, self.order).cmp(&(other.at_ns, other.order))
    }
}

/// One open reader, server, or client.
struct Endpoint {
    stream: Stream,
    /// Whose service it is: a message about one robot reaches nobody who listens for another.
    robot: RobotId,
    life: Rc<Life>,
    wakes: bool,
    /// The [`Queue`] of what it reads; gone once it is closed.
    queue: Weak<dyn Any>,
    /// The turn during which the oldest message in the queue came.
    oldest: Box<dyn Fn() -> Option<u64>>,
}

/// A queue of messages that were received, or refused, each with the turn of the reader during which it came.
pub(crate) type Queue<T> = RefCell<std::collections::VecDeque<(u64, Result<T, Refusal>)>>;

/// A death or a stop that waits at a named point.
#[derive(Clone, Copy, Debug)]
pub(crate) enum ProcessFault {
    Kill { restart_ns: u64 },
    Stop { ns: u64 },
}

/// A line of the trace.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Line {
    /// When, milliseconds since the simulation began.
    pub ms: f64,
    /// What happened, in words.
    pub text: String,
}

/// Everything that is no process.
pub(crate) struct World {
    /// Since the simulation began, whatever any clock says.
    pub time_ns: u64,
    /// What CLOCK_MONOTONIC read when it began, in the sense of `time_ns`; a reboot sets it.
    booted_ns: i128,
    pub wall_offset_ns: i64,
    order: u64,
    events: BinaryHeap<Reverse<Scheduled>>,
    pub disk: Disk,
    pub lives: Vec<Rc<Life>>,
    endpoints: Vec<Endpoint>,
    /// The last message of each living writer, where a late reader gets it.
    history: BTreeMap<(Stream, RobotId, Incarnation), Rc<dyn Any>>,
    /// How many messages have gone from a writer to a reader, and the highest number that has arrived.
    links: BTreeMap<(Stream, Incarnation, Incarnation), (u64, u64)>,
    /// What happens to the next messages, with how many are left.
    link_faults: Vec<(Kind, Stream, u64)>,
    process_faults: Vec<(&'static str, ProcessFault)>,
    pub checker: Checker,
    pub stamps: Stamps,
    pub coverage: Coverage,
    trace: Option<Vec<Line>>,
    pub setup: Setup,
    pub chance: Chance,
    /// When a fault was last felt, or a decision executed.
    pub stirred_ns: u64,
    /// Until when a plan, a pause, an action or a reservation explains that nothing is executed.
    pub explained_ns: u64,
    /// Until hopper-sim is started again after it died writing, nanoseconds.
    pub torn_restart_ns: u64,
    /// The last genuine command.
    pub commanded: Option<Command>,
    pub decisions: u64,
    /// The sequence number of the last patch published, and the fingerprint of the map it led to.
    pub patched: Option<(u64, u64)>,
    /// What is remembered for the counters of rare events around routes.
    pub route_memory: RouteMemory,
    /// Whether another mission has begun since; messages of the one before may come late.
    pub is_another_mission: bool,
}

impl World {
    pub fn new(seed: u64, setup: Setup, traced: bool) -> Self {
        Self {
            time_ns: 0,
            booted_ns: -i128::from(setup.uptime_ns),
            wall_offset_ns: 0,
            order: 0,
            events: BinaryHeap::new(),
            disk: Disk::default(),
            lives: Vec::new(),
            endpoints: Vec::new(),
            history: BTreeMap::new(),
            links: BTreeMap::new(),
            link_faults: Vec::new(),
            process_faults: Vec::new(),
            checker: Checker::new(&setup, chosen::of(&setup)),
            stamps: Stamps::default(),
            coverage: Coverage::default(),
            trace: traced.then(Vec::new),
            setup,
            chance: Chance::new(seed, "stage"),
            stirred_ns: 0,
            explained_ns: 0,
            torn_restart_ns: 0,
            commanded: None,
            decisions: 0,
            patched: None,
            route_memory: RouteMemory::default(),
            is_another_mission: false,
        }
    }

    /// Simulated time since the machine started.
    pub fn monotonic(&self) -> MonotonicNs {
        MonotonicNs((i128::from(self.time_ns) - self.booted_ns) as u64)
    }

    /// For how long nothing has been executed though nothing explains it.
    pub fn calm_ns(&mut self) -> u64 {
        if self.checker.is_quiet(self.monotonic()) {
            self.explained_ns = self.explained_ns.max(self.time_ns);
        }
        self.time_ns.saturating_sub(self.stirred_ns.max(self.explained_ns))
    }

    /// CLOCK_MONOTONIC begins anew, a boot's time above zero.
    pub fn reboot(&mut self) {
        let uptime_ns = self.chance.between(1_500_000_000, 30_000_000_000);
        self.booted_ns = i128::from(self.time_ns) - i128::from(uptime_ns);
    }

    pub fn note(&mut self, text: impl FnOnce() -> String) {
        if let Some(trace) = &mut self.trace {
            trace.push(Line { ms: self.time_ns as f64 / 1e6, text: text() });
        }
    }

    /// What was found of a stamp.
    pub fn stamped(&mut self, found: Result<(), String>) {
        if let Err(detail) = found {
            self.checker.violate("every stamp is the moment that it names", || detail);
        }
    }

    /// What was found of a figure.
    pub fn figured(&mut self, found: Result<(), String>) {
        if let Err(detail) = found {
            self.checker.violate("every figure is that of its decisions", || detail);
        }
    }

    pub fn take_trace(&mut self) -> Vec<Line> {
        self.trace.take().unwrap_or_default()
    }

    pub fn schedule(&mut self, at_ns: u64, event: Event) {
        self.order += 1;
        let at_ns = at_ns.max(self.time_ns);
        self.events.push(Reverse(Scheduled { at_ns, order: self.order, event }));
    }

    /// The next thing that happens; time passes to it.
    pub fn next(&mut self) -> Option<Event> {
        let Reverse(Scheduled { at_ns, event, .. }) = self.events.pop()?;
        self.time_ns = at_ns;
        Some(event)
    }

    /// How long the operating system takes to run a process that is woken.
    fn wake_ns(&mut self) -> u64 {
        if self.chance.one_in(40) {
            self.chance.duration_ns(MS / 4, 15 * MS)
        } else {
            self.chance.between(2_000, 90_000)
        }
    }

    /// A life's sleep ends at `at_ns`, unless it ends before.
    pub fn wake_at(&mut self, life: &Life, at_ns: u64) {
        if life.wakes_at.get().is_none_or(|due_ns| at_ns < due_ns) {
            life.wakes_at.set(Some(at_ns));
            self.schedule(at_ns, Event::Wake(life.slot, life.incarnation));
        }
    }

    /// A message that wakes has come.
    fn ring(&mut self, life: &Life) {
        if life.sleeping.get() && life.stopped_until.get().is_none() {
            let at_ns = self.time_ns + self.wake_ns();
            self.wake_at(life, at_ns);
        } else {
            life.rung.set(true);
        }
    }

    /// SIGSTOP until `until_ns`.
    pub fn stop(&mut self, life: &Life, until_ns: u64) {
        let until_ns = life.stopped_until.get().map_or(until_ns, |known| known.max(until_ns));
        life.stopped_until.set(Some(until_ns));
        life.message_since.set(None);
        self.explained_ns = self.explained_ns.max(until_ns);
        self.schedule(until_ns, Event::Resume(life.slot, life.incarnation));
    }

    /// A process begins to live.
    pub fn enter(&mut self, life: Rc<Life>) {
        self.change(&life);
        self.lives.push(life);
    }

    /// A process is gone, with its endpoints and its history.
    pub fn leave(&mut self, incarnation: Incarnation) {
        if let Some(life) = self.lives.iter().find(|life| life.incarnation == incarnation) {
            self.change(life);
        }
        self.lives.retain(|life| life.incarnation != incarnation);
        self.endpoints.retain(|endpoint| endpoint.life.incarnation != incarnation);
        self.history.retain(|(.., writer), _| *writer != incarnation);
    }

    /// A process comes or goes: another perception may begin anew in the midst of a landing.
    fn change(&self, life: &Life) {
        if life.role == Role::Perception {
            self.lives.iter().for_each(|life| life.disturb_map(self.time_ns));
        }
    }

    /// A turn of a process ends: whatever was there two turns ago has been read.
    pub fn turned(&mut self, life: &Life) {
        let turns = life.turns.get() + 1;
        life.turns.set(turns);
        let unread =
            |endpoint: &&Endpoint| (endpoint.oldest)().is_some_and(|turn| turn + TURNS_UNREAD < turns);
        let own = |endpoint: &&Endpoint| endpoint.life.incarnation == life.incarnation;
        let unread = self.endpoints.iter().filter(own).find(unread).map(|endpoint| endpoint.stream);
        if let Some(stream) = unread {
            let role = life.role;
            self.checker.violate("every turn reads what has come", || {
                format!("{role} leaves a message of {} unread for two turns", stream.as_str())
            });
        }
    }

    /// A sleep of a process ends.
    pub fn woke(&mut self, life: &Life) {
        let now = self.monotonic();
        if now.since_ns(life.turned_at.replace(now)) > SILENCE_NS / 2 {
            life.listening_since.set(now);
        }
        let Some(since_ns) = life.message_since.take() else { return };
        let (count, late) = life.sleeps.get();
        let (count, late) = (count + 1, late + u64::from(self.time_ns - since_ns > MS));
        life.sleeps.set((count, late));
        if count >= SLEEPS_MIN && 2 * late > count {
            let role = life.role;
            self.checker.violate("a message wakes the process that waits for it", || {
                format!("{role} slept on for more than 1 ms at {late} of {count} messages")
            });
        }
    }

    /// Opens an endpoint; late, it gets what those who write still hold.
    pub fn open<T: Clone + 'static>(&mut self, robot: RobotId, life: &Rc<Life>, wakes: bool) -> Rc<Queue<T>> {
        let stream = Stream::of::<T>();
        let queue: Rc<Queue<T>> = Rc::default();
        let any: Rc<dyn Any> = Rc::clone(&queue) as Rc<dyn Any>;
        self.endpoints.retain(|endpoint| endpoint.queue.strong_count() > 0);
        let weak = Rc::downgrade(&queue);
        let oldest = Box::new(move || weak.upgrade()?.borrow().front().map(|(turn, _)| *turn));
        let queue_of_any = Rc::downgrade(&any);
        let life_of = Rc::clone(life);
        self.endpoints.push(Endpoint { stream, robot, life: life_of, wakes, queue: queue_of_any, oldest });
        let held: Vec<(Incarnation, T)> = self
            .history
            .iter()
            .filter(|((of, about, _), _)| (*of, *about) == (stream, robot))
            .filter_map(|((.., writer), message)| Some((*writer, message.downcast_ref::<T>()?.clone())))
            .collect();
        for (writer, message) in held {
            self.send(writer, life, wakes, &queue, Ok(message));
        }
        queue
    }

    /// How many endpoints of `T` are open.
    pub fn readers<T: 'static>(&self) -> usize {
        let stream = Stream::of::<T>();
        let open = |endpoint: &&Endpoint| endpoint.stream == stream && endpoint.queue.strong_count() > 0;
        self.endpoints.iter().filter(open).count()
    }

    /// Publishes to everyone who reads.
    pub fn publish<T: Clone + 'static>(&mut self, robot: RobotId, writer: Incarnation, message: T) {
        let stream = Stream::of::<T>();
        for (reader, wakes, queue) in self.listening::<T>(robot) {
            self.send(writer, &reader, wakes, &queue, Ok(message.clone()));
        }
        if stream.has_history() {
            self.history.insert((stream, robot, writer), Rc::new(message));
        }
    }

    /// Who reads `T` of a robot, with their queues.
    pub fn listening<T: Clone + 'static>(&self, robot: RobotId) -> Vec<(Rc<Life>, bool, Rc<Queue<T>>)> {
        let at = (Stream::of::<T>(), robot);
        let open = self.endpoints.iter().filter(|endpoint| (endpoint.stream, endpoint.robot) == at);
        open.filter_map(|endpoint| {
            let queue = endpoint.queue.upgrade()?.downcast::<Queue<T>>().ok()?;
            Some((Rc::clone(&endpoint.life), endpoint.wakes, queue))
        })
        .collect()
    }

    /// Sends to one reader, through whatever is wrong with the stream.
    pub fn send<T: Clone + 'static>(
        &mut self,
        writer: Incarnation,
        reader: &Rc<Life>,
        wakes: bool,
        queue: &Rc<Queue<T>>,
        message: Result<T, Refusal>,
    ) {
        let stream = Stream::of::<T>();
        let link = self.links.entry((stream, writer, reader.incarnation)).or_default();
        link.0 += 1;
        let number = link.0;
        // Nobody's own messages are disturbed: they never leave the process.
        let arrivals = if writer == reader.incarnation {
            vec![self.time_ns + TRANSPORT_NS]
        } else {
            self.arrivals(stream, reader)
        };
        for at_ns in arrivals {
            let (queue, life, message) = (Rc::downgrade(queue), Rc::clone(reader), message.clone());
            let deliver = Box::new(move || {
                let Some(queue) = queue.upgrade() else { return false };
                let mut queue = queue.borrow_mut();
                let overflows = queue.len() >= stream.buffer();
                if overflows {
                    queue.pop_front();
                }
                queue.push_back((life.turns.get(), message));
                overflows
            });
            let letter = Letter { stream, writer, reader: Rc::clone(reader), wakes, number, deliver };
            self.schedule(at_ns, Event::Arrive(letter));
        }
    }

    /// When the next message of a stream arrives: never, once, or twice.
    fn arrivals(&mut self, stream: Stream, reader: &Life) -> Vec<u64> {
        let mut arrivals = vec![self.time_ns + TRANSPORT_NS];
        if let Some(index) = self.link_faults.iter().position(|(_, at, _)| *at == stream) {
            if [Stream::of::<Asked<MapRequest>>(), Stream::of::<Answered<MapPage>>()].contains(&stream) {
                // The page that comes may be the answer to an earlier request.
                self.lives.iter().for_each(|life| life.disturb_map(self.time_ns));
            }
            self.disturb_answers(stream);
            if stream == Stream::of::<MapPatch>() {
                match self.link_faults[index].0 {
                    Kind::Duplicate { .. } => reader.repeat_patch(self.time_ns),
                    _ => reader.disturb_map(self.time_ns),
                }
            }
            let (kind, _, left) = &mut self.link_faults[index];
            *left -= 1;
            let (name, left) = (kind.as_str(), *left);
            match *kind {
                Kind::Lose { .. } => arrivals.clear(),
                Kind::Duplicate { later_ns, .. } => arrivals.push(arrivals[0] + later_ns),
                Kind::Delay { ns, .. } => arrivals[0] += ns,
                Kind::Reorder { apart_ns, .. } => arrivals[0] += left * apart_ns,
                _ => {}
            }
            if left == 0 {
                self.link_faults.swap_remove(index);
            }
            self.coverage.count(name, stream.as_str());
            self.stirred_ns = self.stirred_ns.max(arrivals.last().copied().unwrap_or(self.time_ns));
            let incarnation = reader.incarnation;
            self.note(|| format!("{name}: a {} message to {} {incarnation}", stream.as_str(), reader.role));
        }
        arrivals
    }

    /// Something is wrong with a message of `stream`: if that is a request for prior or route, or an answer, some planner may have to
    /// ask again.
    fn disturb_answers(&self, stream: Stream) {
        let asked = [Stream::of::<Asked<PriorRequest>>(), Stream::of::<Asked<RouteRequest>>()];
        let answered = [Stream::of::<Answered<PriorPage>>(), Stream::of::<Answered<RoutePage>>()];
        if asked.contains(&stream) || answered.contains(&stream) {
            self.lives.iter().for_each(|life| life.answers_disturbed.set(true));
        }
    }

    /// A message arrives, if its reader still lives.
    pub fn arrive(&mut self, letter: Letter) {
        let Letter { stream, writer, reader, wakes, number, deliver } = letter;
        if !self.lives.iter().any(|life| life.incarnation == reader.incarnation) {
            return;
        }
        let (_, highest) = self.links.entry((stream, writer, reader.incarnation)).or_default();
        if number < *highest {
            self.coverage.count("overtaken", stream.as_str());
        }
        *highest = number.max(*highest);
        if deliver() && stream.buffer() > 1 {
            self.coverage.count("overflow", stream.as_str());
            if stream == Stream::of::<MapPatch>() {
                reader.disturb_map(self.time_ns);
            }
            self.disturb_answers(stream);
        }
        let idle = reader.sleeping.get() && reader.stopped_until.get().is_none();
        if idle && reader.message_since.get().is_none() && reader.waits_for(stream) {
            reader.message_since.set(Some(self.time_ns));
        }
        if wakes {
            self.ring(&reader);
        }
    }

    pub fn add_link_fault(&mut self, kind: &Kind, stream: Stream, messages: u64) {
        self.link_faults.push((kind.clone(), stream, messages));
    }

    pub fn add_process_fault(&mut self, point: &'static str, fault: ProcessFault) {
        self.process_faults.push((point, fault));
    }

    /// A process passes a named point; what waits for it there.
    pub fn pass(&mut self, point: &'static str) -> Option<ProcessFault> {
        let index = self.process_faults.iter().position(|(at, _)| *at == point)?;
        let (_, fault) = self.process_faults.remove(index);
        let group = if matches!(fault, ProcessFault::Kill { .. }) { "killed_at" } else { "stopped_at" };
        self.coverage.count(group, point);
        self.stirred_ns = self.stirred_ns.max(self.time_ns);
        self.note(|| format!("{group} {point}"));
        Some(fault)
    }
}
