//! Somebody in front of the monitor: looks at policies, and gives orders.

use contract::{MonotonicNs, Order, Pace};
use monitor::{History, Screen, Wish};
use process::Failure;

use crate::chance::Chance;

/// Orders of one mission at most, resumptions aside.
const ORDERS_MAX: u64 = 12;

/// How long somebody waits before resuming, and before trying that again, nanoseconds.
const PAUSE_NS: u64 = 200_000_000;

/// Somebody who orders this and that, and always resumes what is paused.
pub(crate) struct Somebody {
    chance: Chance,
    orders: u64,
    paused_since: Option<MonotonicNs>,
    looks_at_policy: bool,
}

impl Somebody {
    pub fn new(chance: Chance) -> Self {
        Self { chance, orders: 0, paused_since: None, looks_at_policy: false }
    }

    fn order(&mut self, history: &History) -> Option<Order> {
        match self.chance.below(6) {
            0 | 1 => Some(Order::Pause),
            2 => Some(Order::Step),
            3 => Some(Order::Pace(Pace::Hertz(self.chance.pick(&[30.0, 80.0, 400.0])))),
            _ => history.stand_by().map(|peer| Order::HandOver(peer.beat.incarnation)),
        }
    }
}

impl Screen for Somebody {
    fn wants_policy(&self) -> bool {
        self.looks_at_policy
    }

    fn show(&mut self, history: &History, now: MonotonicNs) -> Result<Vec<Wish>, Failure> {
        self.looks_at_policy ^= self.chance.one_in(5);
        if history.pacing().is_some_and(|pacing| pacing.paused) {
            let since = *self.paused_since.get_or_insert(now);
            if now.since_ns(since) > PAUSE_NS {
                self.paused_since = Some(now);
                return Ok(vec![Wish::Order(Order::Resume)]);
            }
            return Ok(if self.chance.one_in(3) { vec![Wish::Order(Order::Step)] } else { Vec::new() });
        }
        self.paused_since = None;
        if self.orders >= ORDERS_MAX || !self.chance.one_in(3) {
            return Ok(Vec::new());
        }
        self.orders += 1;
        Ok(self.order(history).map(Wish::Order).into_iter().collect())
    }
}
