//! What a plan of faults does to a simulation.

use std::rc::Rc;

use super::Simulation;
use super::slot::Slot;
use crate::fault::{Fault, Kind};
use crate::forgery::forge;
use crate::world::{Event, MS, ProcessFault};

impl Simulation<'_> {
    pub(super) fn inflict(&mut self, fault: &Fault) {
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

    pub(super) fn disturb_machine(&mut self, kind: &Kind) {
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

    pub(super) fn lose_power(&mut self, thousandths: u64, restart_ns: u64) {
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
    pub(super) fn begin_run(&mut self, restart_ns: u64) {
        if self.world.borrow().checker.status().is_over() || self.slots[0].process.is_none() {
            return;
        }
        self.kill(0, None, false);
        self.begin_mission(restart_ns);
        self.world.borrow_mut().coverage.count("run", "new");
    }

    /// hopper-sim, which does not run, is started on another mission.
    pub(super) fn begin_mission(&mut self, restart_ns: u64) {
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
}
