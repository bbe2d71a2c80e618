//! How landings are spaced, paused and ordered.

use contract::{Control, Incarnation, MonotonicNs, Order, Pace, Role, State, Vetoed};

use super::{Checker, Pacing};
use crate::life::Life;
use crate::reservation::Reservations;
use crate::scouts::Scouts;

impl Checker {
    /// hopper-sim publishes a state at `now`.
    pub fn published(&mut self, state: &State, now: MonotonicNs) {
        self.require(state.landed <= now, "no state is published before its landing", || {
            format!("state {} was published {} ns before", state.decision, state.landed.since_ns(now))
        });
        self.spaced(state);
        let Some(held) = self.state_at(state.decision).filter(|held| held.run == state.run) else {
            return self.violate("nothing is published that the journal does not hold", || {
                format!("state {} of run {}", state.decision, state.run)
            });
        };
        // While a hop is in the air the state before it is published again, with what was vetoed then.
        let need = match self.records.get(state.decision.0 as usize) {
            Some(record) => record.vetoed,
            None if state.status.is_over() => Vetoed::NONE,
            None => self.to_veto(held.pose.cell),
        };
        let told = state.vetoed.union(need) == need;
        self.require(told, "only what is seen to be dangerous is vetoed", || {
            format!("state {}: {:?} are vetoed, {need:?} are dangerous", state.decision, state.vetoed)
        });
        let timeless = State {
            vetoed: Vetoed::NONE,
            landed: MonotonicNs(0),
            published: MonotonicNs(0),
            last_timing: held.last_timing,
            ..*state
        };
        self.require(timeless == held, "nothing is published that the journal does not hold", || {
            format!("state {} is {timeless:?}, the journal has {held:?}", state.decision)
        });
        self.landed(state);
    }

    /// Landings follow each other no faster than the pace, where no order changes it.
    fn spaced(&mut self, state: &State) {
        let Pacing { control, landed, .. } = self.pacing;
        if self.records.len() as u64 > state.decision.0 {
            // What is published again while the next hop is in the air has landed before.
            return;
        }
        let Some((decision, last)) = self.pacing.landed.replace((state.decision, state.landed)) else {
            return;
        };
        let (false, Some(pace)) = (control, self.pacing.paces.first().copied()) else { return };
        let period_ns = match pace {
            Pace::Hertz(hertz) => (1e9 / hertz) as u64 - 1,
            Pace::Times(times) => {
                let lasts_ns = self.scouts().map_or(0, Scouts::lasts_ns);
                ((lasts_ns as f64 / times) as u64).saturating_sub(1)
            }
            Pace::Max | Pace::Real => return,
        };
        let apart_ns = state.landed.since_ns(last);
        self.require(state.decision == decision || apart_ns >= period_ns, "landings keep the pace", || {
            format!("state {} landed {apart_ns} ns after {landed:?} at {pace}", state.decision)
        });
    }

    /// Landings wait while hopper-sim is paused.
    fn landed(&mut self, state: &State) {
        let pacing = &mut self.pacing;
        let last = pacing.published.replace(state.decision);
        pacing.told = state.published;
        if pacing.paused && !pacing.resumed && last.is_some_and(|last| state.decision > last) {
            pacing.landings += 1;
        }
        let (landings, steps) = (pacing.landings, pacing.steps);
        self.require(landings <= steps, "landings wait while the mission is paused", || {
            format!("{landings} landings were published during a pause with {steps} single steps")
        });
    }

    /// A life of hopper-sim begins: a pause does not outlive the one before.
    pub(crate) fn sim_started(&mut self, incarnation: Incarnation, pace: Pace) {
        self.sim = incarnation;
        // What is kept for one robot while another is due is not computed here.
        self.reservations = Reservations::default();
        self.reservations.unsure = self.robots.is_some();
        self.policy = None;
        self.pacing = Pacing::begin(self.pacing.control, pace);
    }

    /// hopper-sim publishes how landings are paced.
    pub(crate) fn paced(&mut self, message: &contract::Pacing) {
        let Pacing { control, paces, .. } = &self.pacing;
        let obeyed =
            message.obeys == *control && (*control || !message.paused) && paces.contains(&message.pace);
        let control = *control;
        self.require(
            obeyed,
            "orders are obeyed by a hopper-sim started with --control, and by no other",
            || format!("with control {control} the pacing is {message:?}"),
        );
        let pacing = &mut self.pacing;
        // A step may have been ordered in the turn of the pause, before this message.
        if !message.paused {
            (pacing.steps, pacing.landings) = (0, 0);
        }
        (pacing.paused, pacing.resumed) = (message.paused, false);
    }

    /// A process receives an order.
    pub(crate) fn ordered(&mut self, life: &Life, control: &Control) {
        let is_sim = life.role == Role::HopperSim && control.run == self.mission.brief.run;
        match control.order {
            Order::Step if is_sim => self.pacing.steps += 1,
            // Resumed and paused again in one turn, it lets one landing come, and no pacing message says so. In a turn without
            // a pause several may come before the message.
            Order::Resume if is_sim => {
                (self.pacing.steps, self.pacing.resumed) = (self.pacing.steps + 1, true);
            }
            Order::Pause if is_sim => self.pacing.resumed = false,
            Order::Pace(pace) if is_sim && self.pacing.control => {
                self.pacing.paces.push(pace);
            }
            // A planner may still be in the run before.
            Order::HandOver(incarnation) if incarnation == life.incarnation => {
                self.handed_over.insert(incarnation);
            }
            _ => {}
        }
    }
}
