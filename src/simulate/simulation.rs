//! The whole system in one thread, under a virtual clock and a plan of faults.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::rc::Rc;

use contract::{Command, Decision, Incarnation, MonotonicNs, Name, Refusal, RobotId, Role, RunId, Term};
use hopper_sim::{History, Journal, JournalHeader, Mission};
use planner::pilot::Commission;
use serde::Serialize;

use super::coverage::Coverage;
use super::fault::{Fault, Forgery, Kind, Plan, Victim};
use super::meddler::Meddler;
use super::message::Message;
use super::process::{Process, Turned, pid_of};
use super::setup::{self, Setup};
use super::stage::{Address, Blow, Happening, Line, MS, Stage};
use super::witness::Violation;
use crate::lockstep::{self, Crew};

/// A mission in which nothing has been executed and no fault felt for so long has stalled, nanoseconds.
const STALL_NS: u64 = 30_000 * MS;

/// How long peers have to leave once hopper-sim has ended, nanoseconds.
const AFTERMATH_NS: u64 = 300 * MS;

/// Most events of a simulation.
const EVENTS_MAX: u64 = 1_000_000;

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
    /// Time that passed for the machines, nanoseconds.
    pub virtual_ns: u64,
    /// What came up.
    pub coverage: Coverage,
    /// What happened, if it was to be traced.
    pub trace: Vec<Line>,
}

/// Simulates `plan` to the end of its mission, or to the first violation.
pub fn simulate(plan: &Plan, meddler: &mut dyn Meddler, traced: bool) -> Report {
    let mut simulation = Simulation::new(plan, meddler, traced);
    let ended = catch_unwind(AssertUnwindSafe(|| simulation.run()));
    if let Err(panic) = ended {
        let text = panic.downcast_ref::<String>().cloned();
        let text = text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned()));
        simulation.stage.witness.accuse("no machine panics", || text.unwrap_or_default());
    }
    simulation.report()
}

/// A place for one process, whichever life it is in.
struct Slot {
    role: Role,
    planner: Option<Name>,
    takeover: bool,
    blind: bool,
    succeeds_pid: Option<u32>,
    process: Option<Process>,
}

impl Slot {
    fn of(role: Role) -> Self {
        Self { role, planner: None, takeover: false, blind: false, succeeds_pid: None, process: None }
    }

    fn of_planner(planner: Name) -> Self {
        Self { planner: Some(planner), ..Self::of(Role::Planner) }
    }
}

struct Simulation<'a> {
    plan: &'a Plan,
    stage: Stage<'a>,
    slots: Vec<Slot>,
    lives: u64,
    /// Faults of the plan that have begun.
    begun: usize,
    missions: u64,
    power_lost: bool,
    ended_ns: Option<u64>,
    events: u64,
}

impl<'a> Simulation<'a> {
    fn new(plan: &'a Plan, meddler: &'a mut dyn Meddler, traced: bool) -> Self {
        let setup = Setup::of(plan.seed);
        let mut slots: Vec<Slot> = [Role::HopperSim, Role::Perception].map(Slot::of).into();
        slots.push(Slot::of_planner(setup.planner));
        slots.push(Slot::of(Role::Monitor));
        slots.extend(setup.stand_by.map(Slot::of_planner));
        let mut stage = Stage::new(plan.seed, setup, meddler, traced);
        for slot in 0..slots.len() {
            let at_ns = stage.chance.below(30 * MS);
            stage.schedule(at_ns, Happening::Start(slot));
        }
        Self {
            plan,
            stage,
            slots,
            lives: 0,
            begun: 0,
            missions: 0,
            power_lost: false,
            ended_ns: None,
            events: 0,
        }
    }

    fn report(mut self) -> Report {
        Report {
            violation: self.stage.witness.violation().cloned(),
            events: self.events,
            decisions: self.stage.decisions,
            virtual_ns: self.stage.time_ns,
            trace: self.stage.take_trace(),
            coverage: self.stage.coverage,
        }
    }

    fn run(&mut self) {
        loop {
            self.begin_faults();
            let Some(happening) = self.stage.next() else { break };
            self.events += 1;
            self.happen(happening);
            if self.stage.witness.violation().is_some() {
                return;
            }
            if let Some(ended_ns) = self.ended_ns {
                let alone = self.slots.iter().all(|slot| slot.process.is_none());
                if alone || self.stage.time_ns > ended_ns + AFTERMATH_NS {
                    break;
                }
                continue;
            }
            let idle_ns = self.stage.time_ns.saturating_sub(self.stage.stirred_ns);
            if idle_ns > STALL_NS || self.events > EVENTS_MAX {
                let (decisions, status) = (self.stage.decisions, self.stage.witness.status());
                return self.stage.witness.accuse("the mission ends once faults stop", || {
                    format!("it stalls after {decisions} decisions, {status}")
                });
            }
        }
        self.conclude();
    }

    /// Faults whose decision has come.
    fn begin_faults(&mut self) {
        while let Some(fault) = self.plan.faults.get(self.begun) {
            if fault.decision > self.stage.decisions || self.ended_ns.is_some() {
                return;
            }
            self.stage.schedule(self.stage.time_ns + fault.after_ns, Happening::Fault(self.begun));
            self.begun += 1;
        }
    }

    fn happen(&mut self, happening: Happening) {
        match happening {
            Happening::Turn(slot, life) => self.with(slot, life, Process::turn),
            Happening::Planned(slot, life) => self.with(slot, life, Process::planned),
            Happening::Resume(slot, life) => self.with(slot, life, Process::resume),
            Happening::Arrive(letter) => {
                let reader = letter.reader;
                self.with(reader.slot, reader.life, |process, stage| {
                    stage.arrived(&letter);
                    process.receive(letter.message, stage);
                    Turned::Pending
                });
            }
            Happening::Start(slot) => self.start(slot),
            Happening::Fault(index) => {
                if self.ended_ns.is_none() {
                    self.stage.stirred_ns = self.stage.stirred_ns.max(self.stage.time_ns);
                    let plan = self.plan;
                    self.befall(&plan.faults[index]);
                }
            }
            Happening::Free => {
                self.stage.note(|| "the disk has room again".into());
                self.stage.disk.free();
            }
        }
    }

    /// Lets a process act, if that life still is.
    fn with(
        &mut self,
        slot: usize,
        life: Incarnation,
        act: impl FnOnce(&mut Process, &mut Stage<'a>) -> Turned,
    ) {
        let Some(process) = self.slots[slot].process.as_mut().filter(|process| process.life == life) else {
            return;
        };
        match act(process, &mut self.stage) {
            Turned::Done | Turned::Pending => {}
            Turned::Died(restart_ns) => self.kill(slot, Some(restart_ns), true),
            Turned::Left => {
                let role = self.slots[slot].role;
                self.stage.note(|| format!("{role} leaves"));
                self.stage.coverage.count("left", role.as_str());
                self.kill(slot, None, false);
                if role == Role::HopperSim {
                    self.ended_ns = Some(self.stage.time_ns);
                }
            }
        }
    }

    /// Ends a process at once.
    fn kill(&mut self, slot: usize, restart_ns: Option<u64>, succeeds: bool) {
        let Some(process) = self.slots[slot].process.take() else { return };
        self.stage.leave(process.life);
        self.slots[slot].succeeds_pid = succeeds.then_some(process.pid);
        if let Some(restart_ns) = restart_ns {
            self.stage.note(|| format!("{} {} is dead", process.role, process.life));
            self.stage.coverage.count("killed", process.role.as_str());
            self.stage.schedule(self.stage.time_ns + restart_ns, Happening::Start(slot));
            self.stage.stirred_ns = self.stage.stirred_ns.max(self.stage.time_ns + restart_ns);
        }
    }

    fn start(&mut self, slot: usize) {
        if self.slots[slot].process.is_some() || self.ended_ns.is_some() {
            return;
        }
        self.lives += 1;
        let life = Incarnation(self.lives);
        let (pid, stays) = (pid_of(life), self.stage.setup.stay);
        let role = self.slots[slot].role;
        let process = match role {
            Role::HopperSim => {
                let Some(journal) = self.open_journal() else { return };
                Process::sim(slot, life, pid, journal, &mut self.stage)
            }
            Role::Perception => Process::perception(slot, life, pid, stays, self.stage.setup.patch_cells),
            Role::Monitor => Process::monitor(slot, life, pid, stays),
            Role::Planner => self.planner(slot, life),
        };
        self.stage.note(|| format!("{role} {life} starts"));
        self.stage.enter(Address { slot, life, role });
        self.slots[slot].process = Some(process);
        self.with(slot, life, Process::begin);
    }

    fn planner(&self, slot: usize, incarnation: Incarnation) -> Process {
        let Slot { planner, takeover, blind, succeeds_pid, .. } = self.slots[slot];
        let name = planner.expect("a planner's slot names its algorithm");
        let pid = pid_of(incarnation);
        let robot = RobotId(0);
        let commission = Commission { robot, incarnation, pid, planner: name, takeover, succeeds_pid };
        let algorithm = planner::algorithm(name.as_str()).expect("setups name known algorithms");
        Process::planner(slot, commission, algorithm, blind, self.stage.setup.stay)
    }

    /// Opens the journal, or begins one; what cannot be opened for want of room is tried again.
    fn open_journal(&mut self) -> Option<Journal<Box<dyn hopper_sim::Storage>>> {
        let Mission { brief, seed, .. } = self.stage.witness.mission();
        let header = JournalHeader { brief: *brief, seed: *seed, resolved: String::new() };
        let (disk, sync) = (self.stage.disk.clone(), self.stage.setup.sync);
        let file = self.stage.meddler.storage(&disk);
        let fresh = disk.is_empty();
        let opened = if fresh {
            Journal::create_on(file, &header, sync)
        } else {
            Journal::resume_on(file, &header, sync)
        };
        let torn = disk.take_torn();
        match opened {
            Ok(journal) => {
                if fresh {
                    // Losing power before a header is durable loses the run, which nobody has flown yet.
                    let _ = hopper_sim::Storage::sync(&disk);
                } else {
                    let over = self.stage.witness.status().is_over();
                    self.stage.coverage.count("journal", if over { "resumed_at_the_end" } else { "resumed" });
                }
                if journal.torn_bytes() > 0 {
                    self.stage.coverage.count("journal", "torn_tail_cut");
                }
                let records: Result<Vec<_>, _> = journal.records().collect();
                match records {
                    Ok(records) => {
                        let may_have_lost = std::mem::take(&mut self.power_lost) && !sync;
                        self.stage.witness.reopened(&records, may_have_lost);
                    }
                    Err(error) => self.stage.witness.accuse("the journal can be read", || error.to_string()),
                }
                Some(journal)
            }
            Err(error) => {
                if fresh {
                    // The real one is written aside and renamed: a failure leaves none.
                    disk.erase();
                }
                if torn || disk.is_full() {
                    self.stage.coverage.count("journal", "open_failed");
                    self.stage.note(|| format!("hopper-sim cannot start: {error}"));
                    self.stage.schedule(self.stage.time_ns + RETRY_NS, Happening::Start(0));
                } else {
                    self.stage.witness.accuse("the journal can be opened again", || error.to_string());
                }
                None
            }
        }
    }

    // Faults

    fn befall(&mut self, fault: &Fault) {
        let kind = &fault.kind;
        self.stage.coverage.count("fault", kind.as_str());
        self.stage.note(|| format!("fault: {kind:?}"));
        let now_ns = self.stage.time_ns;
        match *kind {
            Kind::Lose { topic, messages }
            | Kind::Duplicate { topic, messages, .. }
            | Kind::Delay { topic, messages, .. }
            | Kind::Reorder { topic, messages, .. } => self.stage.snag(kind, topic, messages),
            Kind::Kill { victim, restart_ns, succeeds } => {
                if let Some(slot) = self.find(victim) {
                    self.kill(slot, Some(restart_ns), succeeds);
                }
            }
            Kind::KillAt { point, restart_ns } => self.stage.ambush(point, Blow::Kill { restart_ns }),
            Kind::Stop { victim, ns } => {
                if let Some(slot) = self.find(victim) {
                    self.stage.stirred_ns = self.stage.stirred_ns.max(now_ns + ns);
                    let Some(process) = &mut self.slots[slot].process else { return };
                    self.stage.coverage.count("stopped", process.role.as_str());
                    process.stop(now_ns + ns, &mut self.stage);
                }
            }
            Kind::StopAt { point, ns } => self.stage.ambush(point, Blow::Stop { ns }),
            Kind::Tear { thousandths, restart_ns } => {
                self.stage.disk.tear_next_write(thousandths);
                self.stage.torn_restart_ns = restart_ns;
            }
            Kind::Full { room, stubborn, ns } => {
                self.stage.disk.fill(room, stubborn);
                self.stage.stirred_ns = self.stage.stirred_ns.max(now_ns + ns);
                self.stage.schedule(now_ns + ns, Happening::Free);
            }
            Kind::Rival { planner, takeover, blind } => {
                self.slots.push(Slot { takeover, blind, ..Slot::of_planner(planner) });
                self.start(self.slots.len() - 1);
            }
            Kind::WallClock { ns } => {
                self.stage.wall_offset_ns = self.stage.wall_offset_ns.saturating_add(ns);
            }
            Kind::PowerLoss { thousandths, restart_ns } => self.lose_power(thousandths, restart_ns),
            Kind::NewRun { restart_ns } => self.begin_run(restart_ns),
            Kind::Forge { forgery } => self.forge(forgery),
        }
    }

    fn find(&self, victim: Victim) -> Option<usize> {
        let leader = self.stage.witness.leader().incarnation;
        self.slots.iter().position(|slot| {
            slot.process.as_ref().is_some_and(|process| match victim {
                Victim::Role(role) => process.role == role,
                Victim::Leader => process.life == leader,
                Victim::Rival => process.role == Role::Planner && process.life != leader,
            })
        })
    }

    fn lose_power(&mut self, thousandths: u64, restart_ns: u64) {
        for slot in 0..self.slots.len() {
            let delay_ns = self.stage.chance.below(30 * MS);
            self.kill(slot, Some(restart_ns + delay_ns), false);
            // Whoever had left comes again: without --sync the end of a mission may be lost.
            self.stage.schedule(self.stage.time_ns + restart_ns + delay_ns, Happening::Start(slot));
        }
        self.stage.disk.lose_power(thousandths);
        self.stage.reboot();
        self.power_lost = true;
    }

    /// Another mission, in the midst of this one; whoever saw the end of this one may have left.
    fn begin_run(&mut self, restart_ns: u64) {
        if self.stage.witness.status().is_over() || self.slots[0].process.is_none() {
            return;
        }
        self.kill(0, Some(restart_ns), false);
        self.stage.disk.erase();
        self.missions += 1;
        let mission = setup::mission(self.plan.seed, self.missions);
        self.stage.witness.begin(&mission);
        self.stage.coverage.count("run", "new");
    }

    fn forge(&mut self, forgery: Forgery) {
        let Some(command) = self.stage.commanded else { return };
        let Some(sim) = self.stage.readers.iter().copied().find(|reader| reader.role == Role::HopperSim)
        else {
            return;
        };
        let rogue = Incarnation(u64::MAX);
        let witness = &self.stage.witness;
        let (run, due, held) =
            (witness.mission().brief.run, witness.records().len() as u64, witness.leader().term);
        let forged =
            Command { run, decision: Decision(due), term: held.next(), incarnation: rogue, ..command };
        let message = match forgery {
            Forgery::Run => Ok(Command { run: RunId(run.0 ^ 1), ..forged }),
            Forgery::Robot => Ok(Command { robot: RobotId(7), ..forged }),
            Forgery::Repeated if due == 0 => return,
            Forgery::Repeated => Ok(Command { decision: Decision(due - 1), ..forged }),
            Forgery::Future => Ok(Command { decision: Decision(due + 1_000), ..forged }),
            Forgery::Leap => Ok(Command { term: Term(held.0 + 1_000), ..forged }),
            Forgery::Stale | Forgery::Usurped if held == Term(0) => return,
            Forgery::Stale => Ok(Command { term: Term(held.0 - 1), ..forged }),
            Forgery::Usurped => Ok(Command { term: held, ..forged }),
            Forgery::Malformed => Err(Refusal::malformed("action", "0 to 4", 9)),
        };
        self.stage.send(rogue, sim, Message::Command(Rc::new(message)));
    }

    // The end

    /// The journal as it lies on the disk, and the undisturbed mission with the same shifts.
    fn conclude(&mut self) {
        let witness = &mut self.stage.witness;
        let records: Result<Vec<_>, _> = History::on(self.stage.disk.clone(), "disk".into())
            .and_then(|history| history.records().collect());
        match records {
            Ok(records) if records == witness.records() => {}
            Ok(records) => {
                let held = witness.records().len();
                return witness.accuse("what is committed is never lost", || {
                    format!("the disk holds {} records, {held} were committed", records.len())
                });
            }
            Err(error) => return witness.accuse("the journal can be read", || error.to_string()),
        }
        let records = witness.records().iter().map(|record| Ok::<_, ()>(*record));
        let crew = Crew::from_records(records).expect("no record is an error");
        let mission = witness.mission().clone();
        let last = witness.records().last().map(|record| (record.decision.next(), record.digest));
        let flown = lockstep::fly(mission, &crew, &mut || MonotonicNs(0), &mut |_| ());
        let need = flown.map(|flown| Some((flown.state.decision, flown.state.digest))).unwrap_or_default();
        if last != need {
            witness.accuse("the mission has the digest of the undisturbed one", || {
                format!("it ended as {last:?}, undisturbed as {need:?}")
            });
        }
        self.stage.coverage.count("ended", self.stage.witness.status().as_str());
    }
}
