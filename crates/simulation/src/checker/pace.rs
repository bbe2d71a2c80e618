//! How landings are spaced, paused and ordered.

use contract::{Control, Decision, Incarnation, MonotonicNs, Order, Pace, RobotId, Role, State, Vetoed};

use super::Checker;
use super::pacing::Pacing;
use crate::life::Life;
use crate::offers::Offers;
use crate::reservation::Reservations;
use crate::tempo::Tempo;

impl Checker {
    /// hopper-sim publishes a state at `now`.
    pub fn published(&mut self, state: &State, now: MonotonicNs) {
        self.require(state.landed <= now, "no state is published before its landing", || {
            format!("state {} was published {} ns before", state.decision, state.landed.since_ns(now))
        });
        let Some(held) = self.state_at(state.decision).filter(|held| held.run == state.run) else {
            return self.violate("nothing is published that the journal does not hold", || {
                format!("state {} of run {}", state.decision, state.run)
            });
        };
        // While a hop is in the air the state before it is published again, with what was vetoed then.
        let need = match self.records.get(state.decision.0 as usize) {
            Some(record) => record.vetoed,
            None if state.status.is_over() => Vetoed::NONE,
            None => self.to_veto(),
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
        self.landed(state, now);
    }

    /// A landing comes when pace and orders have it, and not while the mission is paused.
    fn landed(&mut self, state: &State, now: MonotonicNs) {
        let last = self.pacing.published.replace(state.decision);
        if last == Some(state.decision) || self.records.len() as u64 > state.decision.0 {
            // Published again, perhaps while the next hop is in the air.
            self.pacing.told = state.published;
            return;
        }
        let tempo = &self.pacing.tempo;
        let (holds, due) = (last.is_some() && tempo.holds(), tempo.due(state.last_timing.committed));
        self.require(!holds, "landings wait while the mission is paused", || {
            format!("state {} was published at {now:?}", state.decision)
        });
        self.require(due.is_none_or(|due| due == state.landed), "landings keep the pace", || {
            format!("state {} landed at {:?}, needs {due:?}", state.decision, state.landed)
        });
        let robot = self.due();
        let pacing = &mut self.pacing;
        pacing.tempo.land(state.landed);
        pacing.told = state.published;
        if last.is_some() {
            self.reservations.landed(state.decision, robot);
        }
    }

    /// A life of hopper-sim begins: a pause does not outlive the one before.
    pub(crate) fn sim_started(&mut self, incarnation: Incarnation, pace: Pace) {
        self.sim = incarnation;
        self.reservations = Reservations::default();
        self.offers = Offers::default();
        self.policy = None;
        self.pacing = Pacing::begin(self.pacing.tempo.obeys, pace);
        self.pacing.began = Decision(self.records.len() as u64);
    }

    /// hopper-sim publishes how landings are paced.
    pub(crate) fn paced(&mut self, message: &contract::Pacing) {
        let Tempo { obeys, pace, paused, .. } = self.pacing.tempo;
        let is_so = (message.obeys, message.pace, message.paused) == (obeys, pace, paused);
        self.require(
            is_so,
            "orders are obeyed by a hopper-sim started with --control, and by no other",
            || format!("the pacing is {message:?}, needs {pace}, paused {paused}, obeys {obeys}"),
        );
    }

    /// A process receives an order.
    pub(crate) fn ordered(&mut self, life: &Life, control: &Control, now: MonotonicNs) {
        let Control { run, robot, order } = *control;
        if life.role == Role::HopperSim && run == self.mission.brief.run && robot == RobotId(0) {
            self.pacing.tempo.order(order, now);
        }
        // A planner may still be in the run before.
        if let Order::HandOver(incarnation) = order
            && incarnation == life.incarnation
        {
            self.acquaintance.handed_over.insert(incarnation);
            if life.role == Role::Planner && life.map_whole.get() == Some(run) {
                self.told_to_take_over(life);
            }
        }
    }
}
