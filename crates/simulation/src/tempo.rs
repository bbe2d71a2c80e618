//! When a committed hop has to land, by the rules that the documentation states for pace, pause, step and orders.

use contract::{MonotonicNs, Order, Pace};

/// Orders obeyed within [`WINDOW_NS`] at most.
const ORDERS_MAX: u32 = 32;

/// The window over which orders are counted, nanoseconds.
const WINDOW_NS: u64 = 1_000_000_000;

/// How one life of hopper-sim paces landings.
#[derive(Clone, Debug)]
pub(crate) struct Tempo {
    /// Whether it obeys orders.
    pub obeys: bool,
    /// The pace in force.
    pub pace: Pace,
    pub paused: bool,
    /// One landing may come though it is paused.
    step: bool,
    /// When the present window began, and the orders obeyed in it.
    window: (MonotonicNs, u32),
    flying: Option<Flying>,
    /// When the hop before landed.
    landed: Option<MonotonicNs>,
}

/// A hop that is committed and has not landed.
#[derive(Clone, Debug)]
struct Flying {
    /// The pace at its commit.
    pace: Pace,
    /// Simulated time that it takes, nanoseconds.
    lasts_ns: u64,
    /// When its commit was seen.
    since: MonotonicNs,
    /// Orders obeyed since: when, the pace then in force, and whether a step was due.
    orders: Vec<(MonotonicNs, Pace, bool)>,
}

impl Tempo {
    /// The tempo of a life of hopper-sim that has landed nothing yet.
    pub fn begin(obeys: bool, pace: Pace) -> Self {
        let window = (MonotonicNs(0), 0);
        Self { obeys, pace, paused: false, step: false, window, flying: None, landed: None }
    }

    /// hopper-sim receives an order of its mission.
    pub fn order(&mut self, order: Order, now: MonotonicNs) {
        if now.0.saturating_sub(self.window.0.0) >= WINDOW_NS {
            self.window = (now, 0);
        }
        if !self.obeys || self.window.1 >= ORDERS_MAX {
            return;
        }
        self.window.1 += 1;
        match order {
            Order::Pause => (self.paused, self.step) = (true, false),
            Order::Resume => (self.paused, self.step) = (false, false),
            // Where nothing is paused there is nothing to step.
            Order::Step => self.step = self.paused,
            Order::Pace(pace) => self.pace = pace,
            Order::HandOver(_) => {}
        }
        if let Some(flying) = &mut self.flying {
            flying.orders.push((now, self.pace, self.step));
        }
    }

    /// A hop was committed that takes so long in simulated time.
    pub fn committed(&mut self, lasts_ns: u64, now: MonotonicNs) {
        self.flying = Some(Flying { pace: self.pace, lasts_ns, since: now, orders: Vec::new() });
    }

    /// Whether nothing needs to be executed at `now`: landings have to wait, or the hop in the air has not landed.
    pub fn is_quiet(&self, now: MonotonicNs) -> bool {
        let lands = self.flying.as_ref().and_then(|flying| self.due(flying.since));
        self.holds() || lands.is_some_and(|lands| now < lands)
    }

    /// Whether landings have to wait.
    pub fn holds(&self) -> bool {
        self.paused && !self.step
    }

    /// Whether a hop is in the air.
    pub fn is_flying(&self) -> bool {
        self.flying.is_some()
    }

    /// When the hop in the air, which was committed at `committed`, has to land; `None` if that cannot be told.
    pub fn due(&self, committed: MonotonicNs) -> Option<MonotonicNs> {
        let (flying, last) = (self.flying.as_ref()?, self.landed?);
        let by_pace = |pace: Pace| match pace {
            Pace::Max => committed.0,
            Pace::Real => committed.0 + flying.lasts_ns,
            Pace::Times(times) => committed.0 + (flying.lasts_ns as f64 / times).round() as u64,
            Pace::Hertz(hertz) => committed.0.max(last.0 + (1e9 / hertz).round() as u64),
        };
        let mut due = by_pace(flying.pace);
        for (ordered, pace, step) in &flying.orders {
            // An order never lands a hop in the past, and only a step lands it at once.
            due = if *step { ordered.0 } else { by_pace(*pace).max(ordered.0) };
        }
        Some(MonotonicNs(due))
    }

    /// A state is published for the first time: its hop has landed at `landed`. The first one that a life publishes uses up no
    /// step.
    pub fn land(&mut self, landed: MonotonicNs) {
        self.step &= self.landed.is_none() && self.flying.is_none();
        (self.flying, self.landed) = (None, Some(landed));
    }
}
