//! A mission that a page watches: its processes and its monitor, turn by turn.

use std::cell::{Cell, RefCell};
use std::rc::Rc;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use contract::{Decision, MonotonicNs, Name, Order, RobotId};
use lockstep::{Clock, DirectPorts, Flight, Hooks, Tempo};
use monitor::history::{Cursor, Frame};
use monitor::process::{Display, Monitor};
use monitor::{History, Progress, Screen, View, Watcher, Wish};
use process::{Failure, Process, Terms, Turn, block_on};

use crate::Request;
use crate::request::Wanted;

/// What the page asks of the mission, until the monitor's next turn.
#[derive(Debug, Default)]
struct Wishes {
    orders: RefCell<Vec<Order>>,
    policy: Cell<bool>,
}

/// The page, as the monitor sees it.
struct Remote(Rc<Wishes>);

impl Screen for Remote {
    fn wants_policy(&self) -> bool {
        self.0.policy.get()
    }

    fn show(&mut self, _history: &History, _now: MonotonicNs) -> Result<Vec<Wish>, Failure> {
        Ok(self.0.orders.take().into_iter().map(Wish::Order).collect())
    }
}

/// Progress is in the history.
struct Silent;

impl Display for Silent {
    fn show(&mut self, _progress: &Progress, _watcher: &Watcher, _now: MonotonicNs) {}

    fn finished(&mut self, _watcher: &Watcher, _now: MonotonicNs) -> Result<(), Failure> {
        Ok(())
    }
}

/// A mission with its monitor, and one reader of it.
pub struct Session {
    flight: Flight<'static>,
    monitor: Monitor<DirectPorts<'static>, Silent>,
    ports: DirectPorts<'static>,
    history: Arc<Mutex<History>>,
    wishes: Rc<Wishes>,
    events: Cursor,
    policies: Cursor,
    suited: Vec<&'static str>,
    warnings: Vec<String>,
    over: bool,
}

impl Session {
    /// The mission before its first decision, over the ground of `dem` if the request names a file of it.
    ///
    /// # Errors
    /// What was needed and what was got, in a sentence.
    ///
    /// # Panics
    /// Never: direct ports always open.
    pub fn begin(request: &Request, dem: &Arc<[u8]>, clock: Clock<'static>) -> Result<Self, String> {
        let Wanted { mission, schedule, pace, suited, warnings } = request.mission(dem)?;
        let hooks = Hooks { make: Box::new(lockstep::algorithm), clock, observe: Box::new(|_| ()) };
        let tempo = Tempo { pace, control: true };
        let mut flight =
            Flight::begin(mission, &schedule, tempo, hooks).map_err(|error| error.to_string())?;
        let mut ports = flight.ports();
        let history = Arc::new(Mutex::new(History::new(RobotId(0))));
        let wishes = Rc::new(Wishes::default());
        let screens: Vec<Box<dyn Screen>> = vec![Box::new(Remote(Rc::clone(&wishes)))];
        let never = "direct ports always open";
        let view = View::open(&mut ports, Arc::clone(&history), screens, true).expect(never);
        let monitor = block_on(Monitor::join(&mut ports, Silent, Some(view), Vec::new(), Terms::default()))
            .expect(never);
        Ok(Self {
            flight,
            monitor,
            ports,
            history,
            wishes,
            events: Cursor::default(),
            policies: Cursor::of_policies(),
            suited,
            warnings,
            over: false,
        })
    }

    /// Algorithms that may take command.
    #[must_use]
    pub fn suited(&self) -> &[&'static str] {
        &self.suited
    }

    /// Warnings about the scenario.
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Lets every process take its turn, the monitor last; whether the mission is over.
    ///
    /// # Errors
    /// If a planner of the request cannot be had, or a process fails.
    pub fn turn(&mut self) -> Result<bool, String> {
        if !self.over {
            self.over = self.flight.round().map_err(|error| error.to_string())?;
        }
        let turn = block_on(self.monitor.turn(&mut self.ports)).map_err(|failure| failure.to_string())?;
        Ok(self.over || matches!(turn, Turn::Leave(_)))
    }

    /// The decision that is due.
    #[must_use]
    pub fn decision(&self) -> Decision {
        self.flight.state().decision
    }

    /// The digest chain so far.
    #[must_use]
    pub fn digest(&self) -> String {
        self.flight.state().digest.to_string()
    }

    /// Sends an order to the mission with the monitor's next turn.
    pub fn order(&mut self, order: Order) {
        self.wishes.orders.borrow_mut().push(order);
    }

    /// Has a fresh planner of this name command from the next decision on that nobody has commanded yet.
    ///
    /// # Errors
    /// If no planner of this name suits the mission.
    pub fn hand_over(&mut self, planner: &str) -> Result<(), String> {
        if self.suited.is_empty() {
            return Err("robots of this mission keep the planners that its scenario names".into());
        }
        if !self.suited.contains(&planner) {
            let need = self.suited.join(", ");
            return Err(format!("a planner that takes over needs to be one of {need}, got {planner:?}"));
        }
        let name: Name = planner.parse().map_err(|error| format!("{error}"))?;
        self.flight.hand_over(name);
        Ok(())
    }

    /// Whether policies are wanted; they cost the planner something.
    pub fn follow_policies(&mut self, wanted: bool) {
        if wanted && !self.wishes.policy.replace(wanted) {
            self.policies = Cursor::of_policies();
        }
        self.wishes.policy.set(wanted);
    }

    /// Has the next frames begin anew, for a page that was away.
    pub fn rewind(&mut self) {
        self.events = Cursor::default();
    }

    /// The next frame for the page, policies last.
    pub fn frame(&mut self, now: MonotonicNs) -> Option<Frame> {
        let history = Arc::clone(&self.history);
        let history = locked(&history);
        let policies = self.wishes.policy.get();
        history
            .next(&mut self.events, now)
            .or_else(|| policies.then(|| history.next(&mut self.policies, now)).flatten())
    }

    /// The history that the frames are of.
    pub fn history(&self) -> MutexGuard<'_, History> {
        locked(&self.history)
    }
}

fn locked(history: &Mutex<History>) -> MutexGuard<'_, History> {
    history.lock().unwrap_or_else(PoisonError::into_inner)
}
