//! Processes of a simulation: they start, work, sleep, are stopped, die and leave.

use std::rc::Rc;
use std::task::{Context, Poll, Waker};

use contract::{Incarnation, RobotSet, Role, Status};
use process::Exit;

use super::Simulation;
use super::slot::{Running, Slot, WorkLoop};
use crate::fault::Victim;
use crate::life::Life;
use crate::ports::SimulatedPorts;
use crate::setup;
use crate::work_loops;
use crate::world::{Event, MS};

impl Simulation<'_> {
    /// The life in a slot, if it is that one.
    pub(super) fn life(&self, slot: usize, incarnation: Incarnation) -> Option<Rc<Life>> {
        let process = self.slots[slot].process.as_ref()?;
        (process.life.incarnation == incarnation).then(|| Rc::clone(&process.life))
    }

    /// A sleep ends, unless that was brought forward or the process is stopped.
    pub(super) fn wake(&mut self, slot: usize, incarnation: Incarnation) {
        let Some(life) = self.life(slot, incarnation) else { return };
        let due = life.wakes_at.get() == Some(self.world.borrow().time_ns);
        if due && life.sleeping.get() && life.stopped_until.get().is_none() {
            life.wakes_at.set(None);
            life.woken.set(true);
            self.work(slot);
        }
    }

    /// A computation is done; a process that was stopped meanwhile finds out when it goes on.
    pub(super) fn computed(&mut self, slot: usize, incarnation: Incarnation) {
        let Some(life) = self.life(slot, incarnation) else { return };
        if let Some(until_ns) = life.stopped_until.get() {
            return self.world.borrow_mut().schedule(until_ns, Event::Computed(slot, incarnation));
        }
        life.computed.set(true);
        self.work(slot);
    }

    /// SIGCONT, if it is time: goes on where it was stopped.
    pub(super) fn resume(&mut self, slot: usize, incarnation: Incarnation) {
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
    pub(super) fn work(&mut self, slot: usize) {
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

    pub(super) fn left(&mut self, slot: usize, role: Role, exit: Exit) {
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
    pub(super) fn kill(&mut self, slot: usize, restart_ns: Option<u64>, succeeds: bool) {
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

    pub(super) fn start(&mut self, slot: usize) {
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

    pub(super) fn new_life(&mut self, slot: usize) -> Rc<Life> {
        self.lives += 1;
        let incarnation = Incarnation(self.lives);
        let Slot { role, seat, takeover, blind, foreign, succeeds_pid, .. } = self.slots[slot];
        let world = self.world.borrow();
        Rc::new(Life {
            version: if foreign { setup::foreign_version() } else { setup::version() },
            blind,
            robots: seat.map_or(RobotSet::NONE, |seat| seat.robots),
            is_suited: seat.is_some_and(|seat| world.checker.suits(seat)),
            takeover,
            succeeds_pid,
            ..Life::new(slot, role, incarnation, world.setup.slow)
        })
    }

    pub(super) fn stop(&mut self, victim: Victim, ns: u64) {
        let Some(slot) = self.find(victim) else { return };
        let Some(process) = &self.slots[slot].process else { return };
        let world = &mut *self.world.borrow_mut();
        let until_ns = world.time_ns + ns;
        world.stirred_ns = world.stirred_ns.max(until_ns);
        world.coverage.count("stopped", process.life.role.as_str());
        world.stop(&process.life, until_ns);
    }

    pub(super) fn join(&mut self, slot: Slot) {
        self.slots.push(slot);
        self.start(self.slots.len() - 1);
    }

    pub(super) fn find(&self, victim: Victim) -> Option<usize> {
        let leader = self.world.borrow().checker.leader().incarnation;
        self.slots.iter().position(|slot| {
            slot.process.as_ref().is_some_and(|process| match victim {
                Victim::Role(role) => process.life.role == role,
                Victim::Leader => process.life.incarnation == leader,
                Victim::Rival => process.life.role == Role::Planner && process.life.incarnation != leader,
            })
        })
    }
}
