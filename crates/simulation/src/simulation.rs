//! The whole system in one thread, under a virtual clock and a plan of faults.

use std::cell::{Cell, RefCell};
use std::future::Future;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::pin::Pin;
use std::rc::Rc;
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll, Waker};

use contract::{
    Action, Decision, Incarnation, Leader, MonotonicNs, Name, Record, RobotSet, Role, Route, RunId, Status,
};
use hopper_sim::{Journal, JournalError, JournalHeader, JournalReader, Mission};
use lockstep::PlannerSchedule;
use process::{Exit, Failure};
use serde::Serialize;
use tracing::subscriber::{NoSubscriber, with_default};

use crate::coverage::Coverage;
use crate::disk::Disk;
use crate::fault::{Fault, Kind, Plan, Victim};
use crate::figures;
use crate::forgery::forge;
use crate::life::Life;
use crate::ports::SimulatedPorts;
use crate::setup::{self, Seat, Setup};
use crate::violation::Violation;
use crate::work_loops;
use crate::world::{Event, Line, MS, ProcessFault, Shared, World};

/// A mission in which nothing has been executed and no fault felt for so long has stalled, nanoseconds.
const STALL_NS: u64 = 5_000 * MS;

/// A mission has stalled earlier if nothing else explains it either: a plan that takes long, a pause, an action under way, a turn
/// that is kept for another planner, nanoseconds.
const CALM_NS: u64 = 3_000 * MS;

/// How long peers have to leave once hopper-sim has ended, nanoseconds.
const AFTERMATH_NS: u64 = 300 * MS;

/// Most events of a simulation.
const EVENTS_MAX: u64 = 1_000_000;

/// Lives of other instances have numbers from here on.
const ELSEWHERE: u64 = 1 << 40;

/// hopper-sim that could not open its journal is started again after this long, nanoseconds.
const RETRY_NS: u64 = 100 * MS;

/// What a simulation came to.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Report {
    /// The first promise that did not hold, if one did not.
    pub violation: Option<Violation>,
    /// Events simulated.
    pub events: u64,
    /// Decisions executed, those of earlier runs included.
    pub decisions: u64,
    /// Time that passed for the processes, nanoseconds.
    pub virtual_ns: u64,
    /// Longest time in which nothing was executed and no fault was felt, nanoseconds.
    pub idle_ns: u64,
    /// Longest time in which nothing was executed and no fault, plan, pause, action or reservation explains it, nanoseconds.
    pub calm_ns: u64,
    /// How often each event happened that the simulation shall meet.
    pub coverage: Coverage,
    /// What happened, if it was to be traced.
    pub trace: Vec<Line>,
}

/// A mission to be simulated instead of the one that a seed draws, with planners for all of its robots.
#[derive(Clone, Debug)]
pub struct Given {
    /// The mission.
    pub mission: Mission,
    /// Its planner processes.
    pub planners: Vec<Seat>,
}

impl Given {
    /// The `number`th mission of this world: the first, or another run with other draws.
    fn mission(&self, number: u64) -> Mission {
        let Mission { mut brief, seed, .. } = self.mission.clone();
        // A scenario has no run: each mission needs one of its own.
        brief.run = RunId(brief.run.0.wrapping_add(u128::from(number) + 1));
        Mission { brief, seed: seed.wrapping_add(number), ..self.mission.clone() }
    }
}

/// Simulates `plan` to the end of its mission, or to the first violation.
#[must_use]
pub fn simulate(plan: &Plan, traced: bool) -> Report {
    run(plan, None, traced)
}

/// Simulates `plan` on a mission of the caller's, whose vehicles are those that the plan is made
/// for.
#[must_use]
pub fn simulate_given(plan: &Plan, given: &Given, traced: bool) -> Report {
    run(plan, Some(given), traced)
}

fn run(plan: &Plan, given: Option<&Given>, traced: bool) -> Report {
    let mut simulation = Simulation::new(plan, given, traced);
    // What simulated processes log is not the log of whoever simulates them.
    let run = || with_default(NoSubscriber::default(), || simulation.run());
    let ended = catch_unwind(AssertUnwindSafe(run));
    if let Err(panic) = ended {
        let text = panic.downcast_ref::<String>().cloned();
        let text = text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned()));
        let text = text.unwrap_or_default();
        // Whoever panicked may have held the world.
        if let Ok(mut world) = simulation.world.try_borrow_mut() {
            world.checker.violate("nothing panics", || text);
        } else {
            return Report {
                violation: Some(Violation { rule: "nothing panics", detail: text }),
                ..Report::default()
            };
        }
    }
    simulation.report()
}

/// The hops that `planner` flies on from the journal that holds `kept`, as some other hopper-sim would have written them down.
fn fly_elsewhere(mission: &Mission, kept: &[Record], planner: Name, hops: u64) -> Vec<Record> {
    let held = kept.last().map(|record| record.leader).unwrap_or_default();
    let from = Decision(kept.len() as u64);
    let leader = Leader {
        term: held.term.next(),
        incarnation: Incarnation(ELSEWHERE + held.term.0),
        pid: u32::MAX,
        planner,
    };
    let Some(template) = kept.last() else { return Vec::new() };
    let next = Record { decision: from, leader, origin: contract::Origin::Planner, ..*template };
    let schedule =
        PlannerSchedule::from_records(kept.iter().chain([&next]).map(|record| Ok::<_, ()>(*record)))
            .expect("no record is an error");
    let mut flown = Vec::new();
    // What comes after the hops asked for is flown for nothing: missions are short.
    let ended = lockstep::fly(mission.clone(), &schedule, &mut || MonotonicNs(0), &mut |record| {
        if record.decision >= from && flown.len() < hops as usize && !record.status.is_over() {
            flown.push(Record { leader, ..*record });
        }
    });
    ended.map_or_else(|_| Vec::new(), |_| flown)
}

/// Appends a record, with the points of the route that it announces.
fn append(journal: &mut Journal<Disk>, record: &Record, routes: &[Route]) -> Result<(), JournalError> {
    let announced = routes.iter().find(|route| record.action == Action::Announce(route.id()));
    match announced {
        Some(route) => journal.append_announced(record, route),
        None => journal.append(record),
    }
}

/// A place for one process, whichever life it is in.
struct Slot {
    role: Role,
    seat: Option<Seat>,
    takeover: bool,
    blind: bool,
    foreign: bool,
    succeeds_pid: Option<u32>,
    process: Option<Running>,
}

/// The work loop of one life, from its start to its end.
type WorkLoop = Pin<Box<dyn Future<Output = Result<Exit, Failure>>>>;

struct Running {
    life: Rc<Life>,
    work: WorkLoop,
}

impl Slot {
    fn of(role: Role) -> Self {
        let (seat, succeeds_pid, process) = (None, None, None);
        Self { role, seat, takeover: false, blind: false, foreign: false, succeeds_pid, process }
    }

    fn of_planner(seat: Seat) -> Self {
        Self { seat: Some(seat), ..Self::of(Role::Planner) }
    }
}

struct Simulation<'a> {
    plan: &'a Plan,
    given: Option<&'a Given>,
    world: Shared,
    slots: Vec<Slot>,
    lives: u64,
    /// Faults of the plan that have begun.
    begun: usize,
    missions: u64,
    power_lost: bool,
    /// Whether a journal was replaced while peers lived.
    replaced: bool,
    ended_ns: Option<u64>,
    events: u64,
    idle_ns: u64,
    calm_ns: u64,
}

impl<'a> Simulation<'a> {
    fn new(plan: &'a Plan, given: Option<&'a Given>, traced: bool) -> Self {
        let mut setup = Setup::of(plan.missions, plan.seed);
        if let Some(given) = given {
            setup.stand_by = setup.stand_by.and(given.planners.first().copied());
            setup.mission = given.mission(0);
            setup.planners = given.planners.clone();
        }
        let mut slots: Vec<Slot> = [Role::HopperSim, Role::Perception].map(Slot::of).into();
        let planners: Vec<Slot> = setup.planners.iter().copied().map(Slot::of_planner).collect();
        slots.extend(planners);
        slots.push(Slot::of(Role::Monitor));
        slots.extend(setup.stand_by.map(Slot::of_planner));
        let mut world = World::new(plan.seed, setup, traced);
        for slot in 0..slots.len() {
            let at_ns = world.chance.below(30 * MS);
            world.schedule(at_ns, Event::Start(slot));
        }
        Self {
            plan,
            given,
            world: Rc::new(RefCell::new(world)),
            slots,
            lives: 0,
            begun: 0,
            missions: 0,
            power_lost: false,
            replaced: false,
            ended_ns: None,
            events: 0,
            idle_ns: 0,
            calm_ns: 0,
        }
    }

    fn report(self) -> Report {
        let mut world = self.world.borrow_mut();
        Report {
            violation: world.checker.violation().cloned(),
            events: self.events,
            decisions: world.decisions,
            virtual_ns: world.time_ns,
            idle_ns: self.idle_ns,
            calm_ns: self.calm_ns,
            trace: world.take_trace(),
            coverage: std::mem::take(&mut world.coverage),
        }
    }

    fn run(&mut self) {
        loop {
            self.begin_faults();
            let Some(event) = self.world.borrow_mut().next() else { break };
            self.events += 1;
            self.handle(event);
            let world = &mut *self.world.borrow_mut();
            if world.checker.violation().is_some() {
                return;
            }
            if let Some(ended_ns) = self.ended_ns {
                let alone = self.slots.iter().all(|slot| slot.process.is_none());
                if alone || world.time_ns > ended_ns + AFTERMATH_NS {
                    break;
                }
                continue;
            }
            if world.disk.take_misplaced_write() {
                return world
                    .checker
                    .violate("nothing is committed while the journal is not at its path", || {
                        "a record was written into a file that a restart would not find".into()
                    });
            }
            let idle_ns = world.time_ns.saturating_sub(world.stirred_ns);
            self.idle_ns = self.idle_ns.max(idle_ns);
            let calm_ns = world.calm_ns();
            self.calm_ns = self.calm_ns.max(calm_ns);
            if calm_ns > CALM_NS {
                let (decisions, status) = (world.decisions, world.checker.status());
                return world
                    .checker
                    .violate("a decision follows within bounded time while all live", || {
                        format!("none has for {calm_ns} ns after {decisions} decisions, {status}")
                    });
            }
            if idle_ns > STALL_NS || self.events > EVENTS_MAX {
                let (decisions, status) = (world.decisions, world.checker.status());
                return world.checker.violate("the mission ends once faults stop", || {
                    format!("it stalls after {decisions} decisions, {status}")
                });
            }
        }
        self.conclude();
    }

    /// Faults whose decision has come.
    fn begin_faults(&mut self) {
        let world = &mut *self.world.borrow_mut();
        while let Some(fault) = self.plan.faults.get(self.begun) {
            if fault.decision > world.decisions || self.ended_ns.is_some() {
                return;
            }
            world.schedule(world.time_ns + fault.after_ns, Event::Fault(self.begun));
            self.begun += 1;
        }
    }

    fn handle(&mut self, event: Event) {
        match event {
            Event::Wake(slot, incarnation) => self.wake(slot, incarnation),
            Event::Computed(slot, incarnation) => self.computed(slot, incarnation),
            Event::Resume(slot, incarnation) => self.resume(slot, incarnation),
            Event::Arrive(letter) => self.world.borrow_mut().arrive(letter),
            Event::Start(slot) => self.start(slot),
            Event::Fault(index) => {
                if self.ended_ns.is_none() {
                    let world = &mut *self.world.borrow_mut();
                    world.stirred_ns = world.stirred_ns.max(world.time_ns);
                }
                if self.ended_ns.is_none() {
                    let plan = self.plan;
                    self.inflict(&plan.faults[index]);
                }
            }
            Event::DiskFreed => {
                let world = &mut *self.world.borrow_mut();
                world.note(|| "the disk has room again".into());
                world.disk.free();
            }
            Event::JournalBack => {
                let world = &mut *self.world.borrow_mut();
                world.note(|| "the journal is back".into());
                world.disk.misplace(None);
            }
        }
    }

    /// The life in a slot, if it is that one.
    fn life(&self, slot: usize, incarnation: Incarnation) -> Option<Rc<Life>> {
        let process = self.slots[slot].process.as_ref()?;
        (process.life.incarnation == incarnation).then(|| Rc::clone(&process.life))
    }

    /// A sleep ends, unless that was brought forward or the process is stopped.
    fn wake(&mut self, slot: usize, incarnation: Incarnation) {
        let Some(life) = self.life(slot, incarnation) else { return };
        let due = life.wakes_at.get() == Some(self.world.borrow().time_ns);
        if due && life.sleeping.get() && life.stopped_until.get().is_none() {
            life.wakes_at.set(None);
            life.woken.set(true);
            self.work(slot);
        }
    }

    /// A computation is done; a process that was stopped meanwhile finds out when it goes on.
    fn computed(&mut self, slot: usize, incarnation: Incarnation) {
        let Some(life) = self.life(slot, incarnation) else { return };
        if let Some(until_ns) = life.stopped_until.get() {
            return self.world.borrow_mut().schedule(until_ns, Event::Computed(slot, incarnation));
        }
        life.computed.set(true);
        self.work(slot);
    }

    /// SIGCONT, if it is time: goes on where it was stopped.
    fn resume(&mut self, slot: usize, incarnation: Incarnation) {
        let Some(life) = self.life(slot, incarnation) else { return };
        if life.stopped_until.get().is_none_or(|until_ns| until_ns > self.world.borrow().time_ns) {
            return;
        }
        life.stopped_until.set(None);
        self.world.borrow_mut().coverage.count("process", "resumed");
        if life.sleeping.get() {
            life.wakes_at.set(None);
            life.woken.set(true);
        }
        self.work(slot);
    }

    /// Lets a process work until it sleeps, computes, is stopped, dies or leaves.
    fn work(&mut self, slot: usize) {
        let Some(process) = &mut self.slots[slot].process else { return };
        let polled = process.work.as_mut().poll(&mut Context::from_waker(Waker::noop()));
        let (role, dies) = (process.life.role, process.life.dies.take());
        match (polled, dies) {
            (_, Some(restart_ns)) => self.kill(slot, Some(restart_ns), true),
            (Poll::Pending, None) => {}
            (Poll::Ready(Ok(exit)), None) => self.left(slot, role, exit),
            (Poll::Ready(Err(failure)), None) => {
                self.world.borrow_mut().checker.violate("no process fails", || format!("{role}: {failure}"));
            }
        }
    }

    fn left(&mut self, slot: usize, role: Role, exit: Exit) {
        {
            let world = &mut *self.world.borrow_mut();
            world.note(|| format!("{role} leaves"));
            world.coverage.count("left", role.as_str());
            if role == Role::HopperSim {
                let status = world.checker.status();
                let due = if status == Status::Goal { Exit::Done } else { Exit::Failed };
                if !status.is_over() || exit != due {
                    let detail = || format!("hopper-sim leaves with {exit:?} while the mission is {status}");
                    world.checker.violate("the end is that of the journal", detail);
                }
                let goes_on = world.setup.stay && self.missions == 0 && world.chance.one_in(3);
                self.ended_ns = (!goes_on).then_some(world.time_ns);
            }
        }
        self.kill(slot, None, false);
        if role == Role::HopperSim && self.ended_ns.is_none() {
            self.conclude();
            self.begin_mission(50 * MS);
            self.world.borrow_mut().coverage.count("run", "after_the_end");
        }
    }

    /// Ends a process at once.
    fn kill(&mut self, slot: usize, restart_ns: Option<u64>, succeeds: bool) {
        let Some(Running { life, work }) = self.slots[slot].process.take() else { return };
        drop(work);
        let world = &mut *self.world.borrow_mut();
        world.leave(life.incarnation);
        self.slots[slot].succeeds_pid = succeeds.then_some(life.pid);
        if let Some(restart_ns) = restart_ns {
            world.note(|| format!("{} {} is dead", life.role, life.incarnation));
            world.coverage.count("killed", life.role.as_str());
            world.schedule(world.time_ns + restart_ns, Event::Start(slot));
            world.stirred_ns = world.stirred_ns.max(world.time_ns + restart_ns);
        }
    }

    fn start(&mut self, slot: usize) {
        if self.slots[slot].process.is_some() || self.ended_ns.is_some() {
            return;
        }
        let life = self.new_life(slot);
        let ports = SimulatedPorts { world: Rc::clone(&self.world), life: Rc::clone(&life) };
        let work: WorkLoop = match life.role {
            Role::HopperSim => {
                let Some(journal) = self.open_journal() else { return };
                Box::pin(work_loops::simulator(ports, journal))
            }
            Role::Perception => Box::pin(work_loops::perception(ports)),
            Role::Monitor => Box::pin(work_loops::monitor(ports)),
            Role::Planner => {
                let seat = self.slots[slot].seat.expect("a planner's slot has a seat");
                Box::pin(work_loops::planner(ports, seat))
            }
        };
        {
            let world = &mut *self.world.borrow_mut();
            world.note(|| format!("{} {} starts", life.role, life.incarnation));
            world.enter(Rc::clone(&life));
            if self.slots[slot].foreign {
                world.checker.foreign_started(life.incarnation);
            } else if life.takeover {
                world.checker.told_to_take_over(&life);
            }
            if life.role == Role::HopperSim {
                let pace = world.setup.pace;
                world.checker.sim_started(life.incarnation, pace);
                if self.replaced {
                    // What peers hold is asked for anew.
                    world.lives.iter().for_each(|life| life.disturb_map(world.time_ns));
                }
            }
        }
        self.slots[slot].process = Some(Running { life, work });
        self.work(slot);
    }

    fn new_life(&mut self, slot: usize) -> Rc<Life> {
        self.lives += 1;
        let incarnation = Incarnation(self.lives);
        let Slot { role, seat, takeover, blind, foreign, succeeds_pid, .. } = self.slots[slot];
        Rc::new(Life {
            slot,
            role,
            incarnation,
            pid: incarnation.0 as u32 + 1000,
            version: if foreign { setup::foreign_version() } else { setup::version() },
            blind,
            robots: seat.map_or(RobotSet(0), |seat| seat.robots),
            is_suited: seat.is_some_and(|seat| self.world.borrow().checker.suits(seat)),
            takeover,
            succeeds_pid,
            wakes_at: Cell::new(None),
            sleeping: Cell::new(false),
            woken: Cell::new(false),
            rung: Cell::new(false),
            computed: Cell::new(false),
            stopped_until: Cell::new(None),
            dies: Cell::new(None),
            situation: Arc::new(Mutex::new(None)),
            recording: RefCell::new(None),
            turns: Cell::new(0),
            map_whole: Cell::new(None),
            map_disturbed: Cell::new(false),
            answers_disturbed: Cell::new(false),
            disturbed_ns: Cell::new(None),
            repeated_ns: Cell::new(None),
            pass: Cell::default(),
            state_seen: Cell::new(None),
            leader_seen: Cell::default(),
            leader_at_turn: Cell::default(),
            team_seen: RefCell::default(),
            leaders_seen: RefCell::default(),
            listening_since: Cell::default(),
            turned_at: Cell::default(),
            slow: Cell::new(self.world.borrow().setup.slow),
            runs: RefCell::default(),
            message_since: Cell::new(None),
            sleeps: Cell::new((0, 0)),
            commands: Cell::new((0, 0)),
        })
    }

    /// Opens the journal, or begins one; what cannot be opened for want of room is tried again.
    fn open_journal(&mut self) -> Option<Journal<Disk>> {
        let world = &mut *self.world.borrow_mut();
        let Mission { brief, terrain, seed, fleet } = world.checker.mission();
        let header =
            JournalHeader { brief: *brief, seed: *seed, resolved: String::new(), fleet: fleet.clone() };
        let (disk, sync) = (world.disk.clone(), world.setup.sync);
        let file = disk.clone();
        let fresh = disk.is_empty();
        let opened = if fresh {
            Journal::create_on(file, &header, sync)
        } else {
            Journal::resume_on(file, &header, terrain, sync)
        };
        let torn = disk.take_torn();
        match opened {
            Ok(journal) => {
                if fresh {
                    world.coverage.count("journal", "begun");
                    if !sync {
                        // Losing power before a header is durable loses the run, which nobody has flown yet.
                        let _ = hopper_sim::Storage::sync(&disk);
                    }
                } else {
                    let over = world.checker.status().is_over();
                    world.coverage.count("journal", if over { "resumed_at_the_end" } else { "resumed" });
                    if journal.len() > contract::limits::PAST_PAGE_RECORDS as u64 {
                        world.coverage.count("journal", "resumed_beyond_a_page");
                    }
                }
                if journal.torn_bytes() > 0 {
                    world.coverage.count("journal", "torn_tail_cut");
                }
                let records: Result<Vec<_>, _> = journal.records().collect();
                match records {
                    Ok(records) => {
                        let may_have_lost = std::mem::take(&mut self.power_lost) && !sync;
                        if records.len() < world.checker.records().len() {
                            world.stamps.rewound();
                        }
                        world.checker.reopened(&records, may_have_lost);
                        world.checker.routes_read(journal.routes());
                    }
                    Err(error) => world.checker.violate("the journal can be read", || error.to_string()),
                }
                Some(journal)
            }
            Err(error) => {
                if fresh {
                    // The real one is written aside and renamed: a failure leaves none.
                    disk.erase();
                }
                if torn || disk.is_full() || disk.is_misplaced() {
                    world.coverage.count("journal", "open_failed");
                    world.note(|| format!("hopper-sim cannot start: {error}"));
                    world.schedule(world.time_ns + RETRY_NS, Event::Start(0));
                } else {
                    world.checker.violate("the journal can be opened again", || error.to_string());
                }
                None
            }
        }
    }

    fn inflict(&mut self, fault: &Fault) {
        let kind = &fault.kind;
        let shared = Rc::clone(&self.world);
        {
            let world = &mut *shared.borrow_mut();
            world.coverage.count("fault", kind.as_str());
            world.note(|| format!("fault: {kind:?}"));
        }
        match *kind {
            Kind::Lose { stream, messages }
            | Kind::Duplicate { stream, messages, .. }
            | Kind::Delay { stream, messages, .. }
            | Kind::Reorder { stream, messages, .. } => {
                shared.borrow_mut().add_link_fault(kind, stream, messages);
            }
            Kind::Kill { victim, restart_ns, succeeds } => {
                if let Some(slot) = self.find(victim) {
                    self.kill(slot, Some(restart_ns), succeeds);
                }
            }
            Kind::KillAt { point, restart_ns } => {
                shared.borrow_mut().add_process_fault(point, ProcessFault::Kill { restart_ns });
            }
            Kind::Stop { victim, ns } => self.stop(victim, ns),
            Kind::StopAt { point, ns } => {
                shared.borrow_mut().add_process_fault(point, ProcessFault::Stop { ns });
            }
            Kind::Rival { seat, takeover, blind } => {
                self.join(Slot { takeover, blind, ..Slot::of_planner(seat) });
            }
            Kind::ForeignBuild { seat } => {
                self.join(Slot { takeover: true, foreign: true, ..Slot::of_planner(seat) });
            }
            Kind::PowerLoss { thousandths, restart_ns } => self.lose_power(thousandths, restart_ns),
            Kind::NewRun { restart_ns } => self.begin_run(restart_ns),
            Kind::LoseTail { records, restart_ns } => self.replace_journal(records, None, restart_ns),
            Kind::Elsewhere { records, planner, hops, restart_ns } => {
                self.replace_journal(records, Some((planner, hops)), restart_ns);
            }
            Kind::Slow { victim, plans, ns } => {
                if let Some(process) = self.find(victim).and_then(|slot| self.slots[slot].process.as_ref()) {
                    process.life.slow.set((plans, ns));
                    let world = &mut *shared.borrow_mut();
                    world.stirred_ns = world.stirred_ns.max(world.time_ns + plans * ns);
                }
            }
            Kind::Forge { forgery } => forge(&mut self.world.borrow_mut(), forgery),
            Kind::Tear { .. } | Kind::Full { .. } | Kind::Misplaced { .. } | Kind::WallClock { .. } => {
                self.disturb_machine(kind);
            }
        }
    }

    fn disturb_machine(&mut self, kind: &Kind) {
        let world = &mut *self.world.borrow_mut();
        match *kind {
            Kind::Tear { thousandths, restart_ns } => {
                world.disk.tear_next_write(thousandths);
                world.torn_restart_ns = restart_ns;
            }
            Kind::Full { room, stubborn, ns } => {
                world.disk.fill(room, stubborn);
                world.stirred_ns = world.stirred_ns.max(world.time_ns + ns);
                world.schedule(world.time_ns + ns, Event::DiskFreed);
            }
            Kind::Misplaced { place, ns } => {
                world.disk.misplace(Some(place));
                world.stirred_ns = world.stirred_ns.max(world.time_ns + ns);
                world.schedule(world.time_ns + ns, Event::JournalBack);
            }
            Kind::WallClock { ns } => world.wall_offset_ns = world.wall_offset_ns.saturating_add(ns),
            _ => {}
        }
    }

    fn stop(&mut self, victim: Victim, ns: u64) {
        let Some(slot) = self.find(victim) else { return };
        let Some(process) = &self.slots[slot].process else { return };
        let world = &mut *self.world.borrow_mut();
        let until_ns = world.time_ns + ns;
        world.stirred_ns = world.stirred_ns.max(until_ns);
        world.coverage.count("stopped", process.life.role.as_str());
        world.stop(&process.life, until_ns);
    }

    fn join(&mut self, slot: Slot) {
        self.slots.push(slot);
        self.start(self.slots.len() - 1);
    }

    fn find(&self, victim: Victim) -> Option<usize> {
        let leader = self.world.borrow().checker.leader().incarnation;
        self.slots.iter().position(|slot| {
            slot.process.as_ref().is_some_and(|process| match victim {
                Victim::Role(role) => process.life.role == role,
                Victim::Leader => process.life.incarnation == leader,
                Victim::Rival => process.life.role == Role::Planner && process.life.incarnation != leader,
            })
        })
    }

    fn lose_power(&mut self, thousandths: u64, restart_ns: u64) {
        for slot in 0..self.slots.len() {
            let delay_ns = self.world.borrow_mut().chance.below(30 * MS);
            self.kill(slot, Some(restart_ns + delay_ns), false);
            // Whoever had left comes again: without --sync the end of a mission may be lost.
            let world = &mut *self.world.borrow_mut();
            world.schedule(world.time_ns + restart_ns + delay_ns, Event::Start(slot));
        }
        let world = &mut *self.world.borrow_mut();
        world.disk.lose_power(thousandths);
        world.reboot();
        self.power_lost = true;
    }

    /// Another mission, in the midst of this one; whoever saw the end of this one may have left.
    fn begin_run(&mut self, restart_ns: u64) {
        if self.world.borrow().checker.status().is_over() || self.slots[0].process.is_none() {
            return;
        }
        self.kill(0, None, false);
        self.begin_mission(restart_ns);
        self.world.borrow_mut().coverage.count("run", "new");
    }

    /// hopper-sim, which does not run, is started on another mission.
    fn begin_mission(&mut self, restart_ns: u64) {
        self.missions += 1;
        let mission = match self.given {
            Some(given) => given.mission(self.missions),
            None => self.plan.missions.mission(self.plan.seed, self.missions),
        };
        let world = &mut *self.world.borrow_mut();
        if world.checker.violation().is_some() {
            return;
        }
        world.disk.erase();
        world.checker.begin(&mission);
        world.is_another_mission = true;
        world.schedule(world.time_ns + restart_ns, Event::Start(0));
        world.stirred_ns = world.stirred_ns.max(world.time_ns + restart_ns);
    }

    /// hopper-sim ends, and its journal loses the last `records`; or those, and is flown on elsewhere by another planner for
    /// some hops. All other processes live on.
    fn replace_journal(&mut self, records: u64, elsewhere: Option<(Name, u64)>, restart_ns: u64) {
        let can = |world: &World| !world.checker.status().is_over() && !world.disk.is_full();
        if !can(&self.world.borrow()) {
            return;
        }
        self.kill(0, Some(restart_ns), false);
        let Some(journal) = self.open_journal() else { return };
        let routes = journal.routes().to_vec();
        drop(journal);
        let world = &mut *self.world.borrow_mut();
        if !can(world) || world.checker.records().is_empty() {
            return;
        }
        let held = world.checker.records().to_vec();
        let mut kept = held[..held.len().saturating_sub(records as usize)].to_vec();
        if let Some((planner, hops)) = elsewhere {
            kept.extend(fly_elsewhere(world.checker.mission(), &kept, planner, hops));
        }
        let Mission { brief, seed, fleet, .. } = world.checker.mission();
        let header =
            JournalHeader { brief: *brief, seed: *seed, resolved: String::new(), fleet: fleet.clone() };
        let elsewhere = Disk::default();
        let written = Journal::create_on(elsewhere.clone(), &header, true)
            .and_then(|mut journal| kept.iter().try_for_each(|record| append(&mut journal, record, &routes)));
        written.expect("a disk that is not full takes everything");
        world.disk.restore(&elsewhere);
        world.lives.iter().for_each(|life| life.disturb_map(world.time_ns));
        let relation = if kept.len() > held.len() { "replaced_after" } else { "replaced_before" };
        world.coverage.count("journal", relation);
        world.note(|| format!("the journal held {} records, and now holds {}", held.len(), kept.len()));
        world.checker.replaced(&kept);
        world.stamps.rewound();
        self.replaced = true;
        world.stirred_ns = world.stirred_ns.max(world.time_ns + restart_ns);
    }

    /// The journal as it lies on the disk, and the undisturbed mission with the same planners.
    fn conclude(&mut self) {
        let world = &mut *self.world.borrow_mut();
        let checker = &mut world.checker;
        let read = JournalReader::on(world.disk.clone(), "disk".into()).and_then(|history| {
            let mut reader = history.records();
            let records: Vec<Record> = reader.by_ref().collect::<Result<_, _>>()?;
            Ok((records, reader.into_routes()))
        });
        let records = match read {
            Ok((records, routes)) if records == checker.records() => {
                checker.routes_read(&routes);
                records
            }
            Ok((records, _)) => {
                let held = checker.records().len();
                return checker.violate("what is committed is never lost", || {
                    format!("the disk holds {} records, {held} were committed", records.len())
                });
            }
            Err(error) => return checker.violate("the journal can be read", || error.to_string()),
        };
        let schedule = PlannerSchedule::from_records(records.iter().map(|record| Ok::<_, ()>(*record)))
            .expect("no record is an error");
        let mission = checker.mission().clone();
        let last = Some((Decision(checker.records().len() as u64), checker.digest()));
        let mut undisturbed = Vec::new();
        let flown = lockstep::fly(mission, &schedule, &mut || MonotonicNs(0), &mut |record| {
            undisturbed.push(*record)
        });
        let need = flown.map(|flown| Some((flown.state.decision, flown.state.digest))).unwrap_or_default();
        if last != need {
            checker.violate("the mission has the digest of the undisturbed one", || {
                let (got, need) = (last.map(|last| last.0), need.map(|need| need.0));
                let differs = records.iter().zip(&undisturbed).find(|(is, due)| is.digest != due.digest);
                format!("it ended at {got:?}, undisturbed at {need:?}; first, with its undisturbed record: {differs:?}")
            });
        }
        let differs = records.iter().zip(&undisturbed).find(|(is, due)| is.observation != due.observation);
        if last == need
            && let Some((record, _)) = differs
        {
            let decision = record.decision;
            checker.violate("every decision was taken on the map of the undisturbed mission", || {
                format!("decision {decision} was taken on another")
            });
        }
        let status = checker.status().as_str();
        world.coverage.count("ended", status);
        let flown: Vec<Record> = records.iter().map(|record| world.stamps.as_flown(record)).collect();
        let found = figures::check(&world.checker.mission().brief, &flown);
        world.figured(found);
    }
}
