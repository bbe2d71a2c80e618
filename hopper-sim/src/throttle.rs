//! When a committed hop may land: home of pace, pause, single step.
//!
//! All of it moves landings in time and nothing else, so no digest depends on it.

use contract::mission::pace::Launch;
use contract::{MonotonicNs, Order, Pace, Refusal};

/// Orders obeyed within [`WINDOW_NS`] at most: nobody clicks faster, whoever floods is not heard.
pub const ORDERS_MAX: u32 = 32;

/// The window over which orders are counted, nanoseconds.
pub const WINDOW_NS: u64 = 1_000_000_000;

/// Pace of landings, held back while paused.
#[derive(Clone, Debug)]
pub struct Throttle {
    pace: Pace,
    paused: bool,
    /// One landing may come though paused.
    step: bool,
    /// Whether orders are obeyed at all.
    obeys: bool,
    /// When the present window began, and the orders obeyed in it.
    window: (MonotonicNs, u32),
}

impl Throttle {
    /// Landings at `pace` from the start, deaf to orders.
    #[must_use]
    pub fn new(pace: Pace) -> Self {
        Self { pace, paused: false, step: false, obeys: false, window: (MonotonicNs(0), 0) }
    }

    /// From now on orders are obeyed.
    pub fn obey_orders(&mut self) {
        self.obeys = true;
    }

    /// Whether orders are obeyed.
    #[must_use]
    pub fn obeys(&self) -> bool {
        self.obeys
    }

    /// The one in force: that of the last order, or of the start.
    #[must_use]
    pub fn pace(&self) -> Pace {
        self.pace
    }

    /// Whether landings are held back.
    #[must_use]
    pub fn is_paused(&self) -> bool {
        self.paused
    }

    /// Carries out `order`, given at `now`.
    ///
    /// # Errors
    /// If orders are not obeyed, or too many came within [`WINDOW_NS`].
    pub fn obey(&mut self, order: Order, now: MonotonicNs) -> Result<(), Refusal> {
        if !self.obeys {
            return Err(Refusal::malformed("control", "a hopper-sim started with --control", "one without"));
        }
        if now.since_ns(self.window.0) >= WINDOW_NS {
            self.window = (now, 0);
        }
        if self.window.1 >= ORDERS_MAX {
            let need = format!("at most {ORDERS_MAX} orders a second");
            return Err(Refusal::malformed("control", &need, "more"));
        }
        self.window.1 += 1;
        match order {
            Order::Pause => (self.paused, self.step) = (true, false),
            Order::Resume => (self.paused, self.step) = (false, false),
            Order::Step => self.step = self.paused,
            Order::Pace(pace) => self.pace = pace,
            Order::HandOver(_) => {}
        }
        Ok(())
    }

    /// Whether landings are held back at this moment.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.paused && !self.step
    }

    /// A landing came: a single step is used up.
    pub fn landed(&mut self) {
        self.step = false;
    }

    /// When a hop just committed lands.
    #[must_use]
    pub fn landing(&self, launch: &Launch) -> MonotonicNs {
        self.pace.landing(launch)
    }

    /// When a hop in the air lands after an order at `now`: not before, and a step at once.
    #[must_use]
    pub fn landing_anew(&self, launch: &Launch, now: MonotonicNs) -> MonotonicNs {
        if self.step { now } else { self.landing(launch).max(now) }
    }
}
