//! The whole system in one thread, under a virtual clock and a plan of faults.

mod faults;
mod given;
mod journal;
mod processes;
mod report;
mod slot;

use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::rc::Rc;

use contract::Role;
use tracing::subscriber::{NoSubscriber, with_default};

pub use given::Given;
pub use report::Report;

use crate::fault::Plan;
use crate::setup::Setup;
use crate::violation::Violation;
use crate::world::{Event, MS, Shared, World};
use slot::Slot;

/// A mission in which nothing has been executed and no fault felt for so long has stalled, nanoseconds.
const STALL_NS: u64 = 5_000 * MS;

/// A mission has stalled earlier if nothing else explains it either: a plan that takes long, a pause, an action under way, a turn
/// that is kept for another planner, nanoseconds.
const CALM_NS: u64 = 3_000 * MS;

/// How long peers have to leave once hopper-sim has ended, nanoseconds.
const AFTERMATH_NS: u64 = 300 * MS;

/// Most events of a simulation.
const EVENTS_MAX: u64 = 1_000_000;

/// Simulates `plan` to the end of its mission, or to the first violation.
#[must_use]
pub fn simulate(plan: &Plan, traced: bool) -> Report {
    run(plan, None, traced)
}

/// Simulates `plan` on a mission of the caller's, whose robots are those that the plan is made
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
}
