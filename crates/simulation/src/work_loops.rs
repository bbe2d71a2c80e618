//! The work loops of the processes that ship, each joined to simulated ports as its shell joins it to real ones.

use std::cell::RefCell;
use std::io::Write;
use std::rc::Rc;
use std::sync::{Arc, Mutex};

use contract::{Decision, Detail, MonotonicNs, PastPage, Record, RefusalCounts, RobotId, Route, RunId};
use hopper_sim::process::{HopperSim, SimTerms};
use hopper_sim::{Attachment, Journal, JournalError, RecordStore, crash};
use monitor::process::{Display, Monitor};
use monitor::{History, Progress, Screen, View, Watcher};
use perception::Cartographer;
use perception::process::Perception;
use planner::process::{Claim, PlannerProcess};
use process::{Exit, Failure, Ports, Process, Terms, Turn};
use recorder::{Recorder, RecorderPorts, Sink};

use crate::chance::Chance;
use crate::disk::Disk;
use crate::figures;
use crate::observed::Observed;
use crate::ports::SimulatedPorts;
use crate::screen::Somebody;
use crate::setup::{Seat, Setup};
use crate::world::MS;

/// At one in so many decisions of several robots some are played with commands that nobody sends.
const PLAY_ONE_IN: u64 = 12;

/// How long the end is served at most, nanoseconds.
const LINGER_NS: u64 = 2_000 * MS;

pub(crate) async fn simulator(mut ports: SimulatedPorts, journal: Journal<Disk>) -> Result<Exit, Failure> {
    let (mission, terms) = {
        let world = ports.world.borrow();
        let Setup { pace, control, .. } = world.setup;
        let terms =
            SimTerms { pace, linger_ns: LINGER_NS, control, deadlines: true, terms: Terms::default() };
        (world.checker.mission().clone(), terms)
    };
    ports.pass(crash::JOURNAL_OPENED).await;
    let last = journal.last().copied();
    let (life, world) = (Rc::clone(&ports.life), Rc::clone(&ports.world));
    let executed = move |record: &Record| {
        let world = &mut *world.borrow_mut();
        let found = world.stamps.executed(life.incarnation, record);
        world.stamped(found);
        let (received, executed) = life.commands.get();
        life.commands.set((received, executed + u64::from(!record.origin.is_fallback())));
    };
    let page_records = ports.world.borrow().setup.page_records;
    let records = Pages { journal, page_records };
    let sim = HopperSim::join(&mut ports, mission, (records, last), executed, terms).await?;
    let chance = Chance::new(ports.life.incarnation.0 ^ ports.world.borrow().setup.uptime_ns, "play");
    let mut judged = Judged { sim, refused: RefusalCounts::default(), kept: [0; 3], played: None, chance };
    process::run(&mut judged, &mut ports).await
}

/// A journal whose pages are short: a real one holds the whole past of most missions here.
struct Pages {
    journal: Journal<Disk>,
    /// Most records of a page.
    page_records: usize,
}

impl RecordStore for Pages {
    fn run(&self) -> RunId {
        RecordStore::run(&self.journal)
    }

    fn append(&mut self, record: &Record, attachment: Option<&Attachment>) -> Result<(), JournalError> {
        self.journal.append(record, attachment)
    }

    fn detail(&self, decision: Decision) -> Result<Option<Detail>, JournalError> {
        self.journal.detail(decision)
    }

    fn routes(&self) -> Result<Vec<Route>, JournalError> {
        RecordStore::routes(&self.journal)
    }

    fn page(&self, from: Decision) -> Result<PastPage, JournalError> {
        let mut page = self.journal.page(from)?;
        page.records.truncate(self.page_records);
        Ok(page)
    }

    fn check(&self) -> Result<(), JournalError> {
        self.journal.check()
    }
}

/// Reasons for which hopper-sim refuses.
pub const REASONS: [&str; 18] = [
    "wrong_run",
    "wrong_robot",
    "repeated_decision",
    "future_decision",
    "other_past",
    "stale_term",
    "future_term",
    "not_leader",
    "unknown_life",
    "yielding",
    "mission_over",
    "busy",
    "malformed",
    "vetoed",
    "not_due",
    "occupied",
    "unknown_route",
    "beyond_budget",
];

/// Lets the checker see what hopper-sim has refused.
struct Judged<O: FnMut(&Record)> {
    sim: HopperSim<SimulatedPorts, Pages, O>,
    /// Refusals up to the last turn.
    refused: RefusalCounts,
    /// Takeovers for which a decision was kept until then, those that had let one pass, and those beside another.
    kept: [u64; 3],
    /// The decision of the last turn, and chance for what is played from there.
    played: Option<Decision>,
    chance: Chance,
}

impl<O: FnMut(&Record)> Process<SimulatedPorts> for Judged<O> {
    async fn turn(&mut self, ports: &mut SimulatedPorts) -> Result<Turn, Failure> {
        let turn = self.sim.turn(ports).await?;
        let refused = self.sim.arbiter().refusals();
        let now = ports.now();
        let world = &mut *ports.world.borrow_mut();
        for reason in REASONS {
            (self.refused.of(reason)..refused.of(reason))
                .for_each(|_| world.coverage.count("refusal", reason));
        }
        if self.refused != *refused {
            self.refused = refused.clone();
        }
        let decision = self.sim.arbiter().state().decision;
        if self.played != Some(decision) && self.chance.one_in(PLAY_ONE_IN) {
            world.checker.play(self.sim.arbiter(), &mut self.chance, &mut world.coverage, now);
        }
        self.played = Some(decision);
        let (received, executed) = ports.life.commands.get();
        world.checker.answered(refused, executed);
        let kept = world.checker.reservations();
        let counts = [("kept", kept.kept), ("slow_bidder", kept.slow), ("two_robots_kept", kept.two_kept)];
        for ((name, count), before) in counts.into_iter().zip(&mut self.kept) {
            (*before..count).for_each(|_| world.coverage.count("reservation", name));
            *before = count;
        }
        let judged = executed + refused.0.values().sum::<u64>();
        // One may be accepted that the journal has not taken yet.
        if received > judged + 1 {
            world.checker.violate("every command is executed or refused", || {
                format!("hopper-sim received {received} commands, and executed or refused {judged}")
            });
        }
        Ok(turn)
    }
}

fn peer_terms(ports: &SimulatedPorts) -> Terms {
    Terms { wait: None, stay: ports.world.borrow().setup.stay }
}

pub(crate) async fn perception(mut ports: SimulatedPorts) -> Result<Exit, Failure> {
    let terms = peer_terms(&ports);
    let patch_cells = ports.world.borrow().setup.patch_cells;
    let cartographer = Cartographer::new(RobotId(0)).with_patches_of(patch_cells);
    let mut perception = Perception::join(&mut ports, cartographer, terms).await?;
    process::run(&mut perception, &mut ports).await
}

pub(crate) async fn planner(mut ports: SimulatedPorts, seat: Seat) -> Result<Exit, Failure> {
    let terms = peer_terms(&ports);
    let planner = planner::algorithm(seat.planner.as_str()).expect("setups name known algorithms");
    let planner = Box::new(Observed { planner, seen: Arc::clone(&ports.life.situation) });
    let (takeover, succeeds_pid) = (ports.life.takeover, ports.life.succeeds_pid);
    let claim = Claim { robots: seat.robots, takeover, succeeds_pid };
    let mut planner = PlannerProcess::join(&mut ports, planner, claim, terms).await?;
    process::run(&mut planner, &mut ports).await
}

pub(crate) async fn monitor(mut ports: SimulatedPorts) -> Result<Exit, Failure> {
    let terms = peer_terms(&ports);
    let (screen, records, seed) = {
        let world = ports.world.borrow();
        (world.setup.screen, world.setup.records, ports.life.incarnation.0 ^ world.setup.uptime_ns)
    };
    let view = screen.then(|| {
        let history = Arc::new(Mutex::new(History::new(RobotId(0))));
        let world = Rc::clone(&ports.world);
        let screens: Vec<Box<dyn Screen>> = vec![Box::new(Somebody::new(Chance::new(seed, "screen"), world))];
        View::open(&mut ports, history, screens, true)
    });
    let observers = if records { vec![recorder(&mut ports)?] } else { Vec::new() };
    let checked = Checked { ports: ports.clone() };
    let mut monitor = Monitor::join(&mut ports, checked, view.transpose()?, observers, terms).await?;
    let exit = process::run(&mut monitor, &mut ports).await?;
    monitor.finish(&mut ports)?;
    Ok(exit)
}

fn recorder(
    ports: &mut SimulatedPorts,
) -> Result<Box<dyn monitor::process::Observer<SimulatedPorts>>, Failure> {
    let bytes: Rc<RefCell<Vec<u8>>> = Rc::default();
    *ports.life.recording.borrow_mut() = Some(Rc::clone(&bytes));
    let opened = RecorderPorts::open(ports, false)?;
    let now = ports.now();
    Ok(Box::new(Recorder::begin(&Default::default(), opened, Memory(bytes), now)?))
}

/// A recording in memory.
struct Memory(Rc<RefCell<Vec<u8>>>);

impl Write for Memory {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.borrow_mut().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl Sink for Memory {
    fn name(&self) -> String {
        "memory".into()
    }

    fn load(&mut self, _now: MonotonicNs, _least_ns: u64) -> Option<recording::MachineLoad> {
        None
    }
}

/// Lets the checker see what the monitor has folded.
struct Checked {
    ports: SimulatedPorts,
}

impl Checked {
    fn check(&self, watcher: &Watcher, is_final: bool) {
        let Some(tally) = watcher.tally() else { return };
        let world = &mut *self.ports.world.borrow_mut();
        let run = watcher.seen().0;
        world.checker.watched(tally, run, is_final);
        if is_final && run == world.checker.mission().brief.run {
            let known = world.checker.records().get(..tally.due().0 as usize);
            let landings = known.and_then(|records| world.stamps.landings(records));
            let found = landings.map_or(Ok(()), |landings| figures::check_tally(tally, &landings));
            world.figured(found);
        }
    }
}

impl Display for Checked {
    fn show(&mut self, _progress: &Progress, watcher: &Watcher, _now: MonotonicNs) {
        self.check(watcher, false);
    }

    fn finished(&mut self, watcher: &Watcher, _now: MonotonicNs) -> Result<(), Failure> {
        self.check(watcher, true);
        Ok(())
    }
}
