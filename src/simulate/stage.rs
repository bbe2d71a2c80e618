//! What simulated processes stand on: time, the post, the disk, and who watches.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use contract::{Command, Incarnation, MonotonicNs, Role};
use serde::Serialize;

use super::chance::Chance;
use super::coverage::Coverage;
use super::disk::Disk;
use super::fault::Kind;
use super::meddler::Meddler;
use super::message::{Message, Topic};
use super::setup::Setup;
use super::witness::Witness;

/// How long a message takes, nanoseconds.
const TRANSPORT_NS: u64 = 5_000;

/// Something that will happen.
#[derive(Debug)]
pub(super) enum Happening {
    /// The work loop of a life turns, if it still means to at this moment.
    Turn(usize, Incarnation),
    /// A message reaches a reader.
    Arrive(Letter),
    /// A planner is done with planning.
    Planned(usize, Incarnation),
    /// A stopped process goes on.
    Resume(usize, Incarnation),
    /// A process is started.
    Start(usize),
    /// The fault of this number begins.
    Fault(usize),
    /// The disk has room again.
    Free,
}

/// A message on its way.
#[derive(Clone, Debug)]
pub(super) struct Letter {
    pub writer: Incarnation,
    pub reader: Address,
    pub message: Message,
    /// Its number among those from this writer to this reader on its topic.
    number: u64,
}

#[derive(Debug)]
struct Scheduled {
    at_ns: u64,
    order: u64,
    happening: Happening,
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

/// A living process as the post knows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Address {
    pub slot: usize,
    pub life: Incarnation,
    pub role: Role,
}

/// A death or a stop that waits at a named point.
#[derive(Clone, Copy, Debug)]
pub(super) enum Blow {
    Kill { restart_ns: u64 },
    Stop { ns: u64 },
}

/// A line of the trace.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Line {
    /// When, milliseconds since the simulation began.
    pub ms: f64,
    /// What happened.
    pub text: String,
}

/// Everything that is no process.
pub(super) struct Stage<'a> {
    /// Since the simulation began, whatever any clock says.
    pub time_ns: u64,
    /// What CLOCK_MONOTONIC read when it began, in the sense of `time_ns`; a reboot sets it.
    booted_ns: i128,
    pub wall_offset_ns: i64,
    order: u64,
    queue: BinaryHeap<Reverse<Scheduled>>,
    pub disk: Disk,
    pub readers: Vec<Address>,
    /// The last message of each living writer, where a late reader gets it.
    history: BTreeMap<(Topic, Incarnation), Message>,
    /// How many messages have gone from a writer to a reader, and the highest number that has arrived.
    links: BTreeMap<(Topic, Incarnation, Incarnation), (u64, u64)>,
    /// What befalls the next messages, with how many are left.
    snags: Vec<(Kind, Topic, u64)>,
    ambushes: Vec<(&'static str, Blow)>,
    pub witness: Witness,
    pub coverage: Coverage,
    trace: Option<Vec<Line>>,
    pub meddler: &'a mut dyn Meddler,
    pub setup: Setup,
    pub chance: Chance,
    /// When a fault was last felt, or a decision executed.
    pub stirred_ns: u64,
    /// Until hopper-sim is started again after it died writing, nanoseconds.
    pub torn_restart_ns: u64,
    /// The last genuine command.
    pub commanded: Option<Command>,
    pub decisions: u64,
}

impl<'a> Stage<'a> {
    pub fn new(seed: u64, setup: Setup, meddler: &'a mut dyn Meddler, traced: bool) -> Self {
        Self {
            time_ns: 0,
            booted_ns: -i128::from(setup.uptime_ns),
            wall_offset_ns: 0,
            order: 0,
            queue: BinaryHeap::new(),
            disk: Disk::default(),
            readers: Vec::new(),
            history: BTreeMap::new(),
            links: BTreeMap::new(),
            snags: Vec::new(),
            ambushes: Vec::new(),
            witness: Witness::new(&setup.mission),
            coverage: Coverage::default(),
            trace: traced.then(Vec::new),
            meddler,
            setup,
            chance: Chance::new(seed, "stage"),
            stirred_ns: 0,
            torn_restart_ns: 0,
            commanded: None,
            decisions: 0,
        }
    }

    /// What a process reads when it asks for the time: CLOCK_MONOTONIC.
    pub fn now(&mut self) -> MonotonicNs {
        let monotonic = self.monotonic();
        let wall = MonotonicNs(monotonic.0.saturating_add_signed(self.wall_offset_ns));
        self.meddler.clock(monotonic, wall)
    }

    /// What CLOCK_MONOTONIC reads, whatever a process takes for it.
    pub fn monotonic(&self) -> MonotonicNs {
        MonotonicNs((i128::from(self.time_ns) - self.booted_ns) as u64)
    }

    /// The moment at which CLOCK_MONOTONIC will read `at`.
    pub fn time_of(&self, at: MonotonicNs) -> u64 {
        (i128::from(at.0) + self.booted_ns).max(0) as u64
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

    pub fn take_trace(&mut self) -> Vec<Line> {
        self.trace.take().unwrap_or_default()
    }

    pub fn schedule(&mut self, at_ns: u64, happening: Happening) {
        self.order += 1;
        let at_ns = at_ns.max(self.time_ns);
        self.queue.push(Reverse(Scheduled { at_ns, order: self.order, happening }));
    }

    /// The next thing that happens; time passes to it.
    pub fn next(&mut self) -> Option<Happening> {
        let Reverse(Scheduled { at_ns, happening, .. }) = self.queue.pop()?;
        self.time_ns = at_ns;
        Some(happening)
    }

    /// How long the operating system takes to run a process whose event came.
    pub fn wake_ns(&mut self) -> u64 {
        if self.chance.one_in(40) {
            self.chance.duration_ns(MS / 4, 15 * MS)
        } else {
            self.chance.between(2_000, 90_000)
        }
    }

    /// A process enters: late, it gets what those who write still hold.
    pub fn enter(&mut self, address: Address) {
        self.readers.push(address);
        let held: Vec<(Incarnation, Message)> = self
            .history
            .iter()
            .filter(|((topic, _), _)| topic.is_read_by(address.role))
            .map(|((_, writer), message)| (*writer, message.clone()))
            .collect();
        for (writer, message) in held {
            self.send(writer, address, message);
        }
    }

    /// A process is gone, and its history with it.
    pub fn leave(&mut self, life: Incarnation) {
        self.readers.retain(|address| address.life != life);
        self.history.retain(|(_, writer), _| *writer != life);
    }

    /// Its last message on `topic` goes with the port.
    pub fn drop_history(&mut self, writer: Incarnation, topic: Topic) {
        self.history.remove(&(topic, writer));
    }

    /// Publishes to everyone who reads the topic, but oneself.
    pub fn publish(&mut self, writer: Incarnation, message: Message) {
        let topic = message.topic();
        let reads = |reader: &&Address| topic.is_read_by(reader.role) && reader.life != writer;
        let readers: Vec<Address> = self.readers.iter().filter(reads).copied().collect();
        for reader in readers {
            self.send(writer, reader, message.clone());
        }
        if topic.has_history() {
            self.history.insert((topic, writer), message);
        }
    }

    /// Sends to one reader, through whatever befalls the topic.
    pub fn send(&mut self, writer: Incarnation, reader: Address, message: Message) {
        let topic = message.topic();
        let link = self.links.entry((topic, writer, reader.life)).or_default();
        link.0 += 1;
        let number = link.0;
        let mut arrivals = vec![self.time_ns + TRANSPORT_NS];
        if let Some(index) = self.snags.iter().position(|(_, at, _)| *at == topic) {
            let (kind, _, left) = &mut self.snags[index];
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
                self.snags.swap_remove(index);
            }
            self.coverage.count(name, topic.as_str());
            self.stirred_ns = arrivals.last().copied().unwrap_or(self.time_ns);
            self.note(|| format!("{name}: a {} message to {} {}", topic.as_str(), reader.role, reader.life));
        }
        for at_ns in arrivals {
            let letter = Letter { writer, reader, message: message.clone(), number };
            self.schedule(at_ns, Happening::Arrive(letter));
        }
    }

    /// Takes note of an arrival, and whether another message has overtaken it.
    pub fn arrived(&mut self, letter: &Letter) {
        let topic = letter.message.topic();
        let (_, highest) = self.links.entry((topic, letter.writer, letter.reader.life)).or_default();
        if letter.number < *highest {
            self.coverage.count("overtaken", topic.as_str());
        }
        *highest = letter.number.max(*highest);
    }

    pub fn snag(&mut self, kind: &Kind, topic: Topic, messages: u64) {
        self.snags.push((kind.clone(), topic, messages));
    }

    pub fn ambush(&mut self, point: &'static str, blow: Blow) {
        self.ambushes.push((point, blow));
    }

    /// A process passes a named point.
    pub fn pass(&mut self, point: &'static str) -> Option<Blow> {
        let index = self.ambushes.iter().position(|(at, _)| *at == point)?;
        let (_, blow) = self.ambushes.remove(index);
        let group = if matches!(blow, Blow::Kill { .. }) { "killed_at" } else { "stopped_at" };
        self.coverage.count(group, point);
        self.stirred_ns = self.time_ns;
        self.note(|| format!("{group} {point}"));
        Some(blow)
    }
}

/// A millisecond, nanoseconds.
pub(super) const MS: u64 = 1_000_000;
