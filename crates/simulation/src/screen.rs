//! Somebody in front of the monitor: looks at policies, and gives orders.

use contract::{MonotonicNs, Order, Pace};
use monitor::history::Cursor;
use monitor::{History, Screen, Wish};
use process::Failure;
use serde_json::Value;

use crate::chance::Chance;
use crate::figures;
use crate::world::Shared;

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
    /// What it has read of the page.
    page: Cursor,
    world: Shared,
}

impl Somebody {
    pub fn new(chance: Chance, world: Shared) -> Self {
        let page = Cursor::default();
        Self { chance, orders: 0, paused_since: None, looks_at_policy: false, page, world }
    }

    /// Reads the decisions that are new on the page, and compares their times with those that the world saw.
    fn read(&mut self, history: &History, now: MonotonicNs) {
        while let Some(frame) = history.next(&mut self.page, now) {
            match frame.event {
                "mission" => {}
                "hops" => self.compare(history, &frame.data),
                // Decisions come first: there is none left.
                _ => return,
            }
        }
    }

    fn compare(&self, history: &History, data: &str) {
        let world = &mut *self.world.borrow_mut();
        if history.brief().is_none_or(|brief| brief.run != world.checker.run()) {
            return;
        }
        let data: Value = serde_json::from_str(data).unwrap_or_default();
        for row in data["rows"].as_array().into_iter().flatten() {
            let decision = row[0].as_u64().unwrap_or(u64::MAX) as usize;
            // Landing, robot and stages.
            let times: Vec<f64> =
                row.as_array().into_iter().flatten().skip(14).filter_map(Value::as_f64).collect();
            let record = world.checker.records().get(decision..=decision);
            let landing = record.and_then(|record| world.stamps.landings(record));
            let found = landing.map_or(Ok(()), |landing| figures::check_row(&times, &landing[0]));
            world.figured(found);
        }
    }

    fn order(&mut self, history: &History) -> Option<Order> {
        match self.chance.below(6) {
            0 | 1 => Some(Order::Pause),
            2 => Some(Order::Step),
            3 => Some(Order::Pace(self.chance.pick(&[
                Pace::Hertz(30.0),
                Pace::Hertz(80.0),
                Pace::Hertz(400.0),
                // Fast enough for a drive of hours.
                Pace::Times(1e6),
                Pace::Max,
            ]))),
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
        self.read(history, now);
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
