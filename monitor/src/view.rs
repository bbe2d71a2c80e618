//! What page and terminal need beyond other monitors: the history they show, and ports of their own.
//!
//! The map is folded from patches and pages. Policies cost the planner something, so they are read only while somebody
//! looks at them.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use contract::{
    Brief, Control, DetailPage, DetailRequest, MapPage, MapRequest, MonotonicNs, Order, Pacing, Policy,
    PriorPage, PriorRequest, RobotId, RoutePage, RouteRequest, TablePage, TableRequest,
};
use process::{Client, Failure, Ports, Reader, Writer, accept};

use crate::{Event, History, Input, Progress};

/// Pause between two looks at the policy, nanoseconds, and that for each cell: a planner that looks ahead only as
/// far as it must computes the rest for display, of 821 × 821 cells in a good part of a second.
const POLICY_PERIOD_NS: u64 = 250_000_000;
const POLICY_CELL_NS: u64 = 10_000;

/// Pause before a place among the policy's readers, or those who ask for prior, routes and details, is tried for again, nanoseconds.
const PLACE_NS: u64 = 2_000_000_000;

/// How long the end of a mission waits for the map of its end while a perception lives, nanoseconds: as long as that stays for it.
const LAST_MAP_NS: u64 = 5_000_000_000;

/// Something that shows the history: a page, a terminal.
pub trait Screen {
    /// Whether somebody looks at the policy.
    fn wants_policy(&self) -> bool;

    /// Shows the history as it stands at `now`; what whoever looks asks for.
    ///
    /// # Errors
    /// If the screen is gone.
    fn show(&mut self, history: &History, now: MonotonicNs) -> Result<Vec<Wish>, Failure>;
}

/// What whoever looks asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wish {
    /// Leave.
    Quit,
    /// Send an order to the mission.
    Order(Order),
}

/// The history of one robot's mission, the screens that show it, and its ports.
pub struct View<P: Ports> {
    history: Arc<Mutex<History>>,
    screens: Vec<Box<dyn Screen>>,
    robot: RobotId,
    snapshots: P::Client<MapRequest>,
    pacings: P::Reader<Pacing>,
    /// Only where orders are allowed.
    controls: Option<P::Writer<Control>>,
    /// Open while a policy is waited for: planners make them for readers only.
    policies: Option<P::Reader<Policy>>,
    /// When the next policy is to be looked at.
    policy_due: MonotonicNs,
    /// Whether the log has said that all places among the policy's readers are taken.
    policy_full: bool,
    /// Open in missions of robots that have routes.
    routes: Option<RoutePorts<P>>,
    /// When opening them is to be tried again; `None` before the first try.
    routes_due: Option<MonotonicNs>,
    /// Open once the motion model has told something of a decision.
    details: Option<P::Client<DetailRequest>>,
    /// When opening it is to be tried again; `None` before the first try.
    details_due: Option<MonotonicNs>,
    /// Open where planners believe a motion table.
    tables: Option<P::Client<TableRequest>>,
    /// When opening it is to be tried again; `None` before the first try.
    tables_due: Option<MonotonicNs>,
    /// Since when the map of the mission's end is waited for.
    map_awaited: Option<MonotonicNs>,
}

/// Asks for what planners of routes know.
struct RoutePorts<P: Ports> {
    /// Only where speeds are uncertain.
    priors: Option<P::Client<PriorRequest>>,
    routes: P::Client<RouteRequest>,
}

impl<P: Ports> RoutePorts<P> {
    fn open(ports: &mut P, brief: &Brief) -> Result<Self, P::Error> {
        let priors = brief.sampling.map(|_| ports.client(RobotId(0))).transpose()?;
        Ok(Self { priors, routes: ports.client(RobotId(0))? })
    }
}

/// What is received before the states: see [`crate::process`].
#[derive(Debug, Default)]
pub struct Early {
    pacing: Option<Pacing>,
    page: Option<MapPage>,
    prior: Option<PriorPage>,
    route: Option<RoutePage>,
    detail: Option<DetailPage>,
    table: Option<TablePage>,
}

impl<P: Ports> View<P> {
    /// Opens the ports. `history` is shared with the screens.
    ///
    /// # Errors
    /// If a port cannot be had.
    pub fn open(
        ports: &mut P,
        history: Arc<Mutex<History>>,
        screens: Vec<Box<dyn Screen>>,
        control: bool,
    ) -> Result<Self, P::Error> {
        let robot = RobotId(0);
        Ok(Self {
            history,
            screens,
            robot,
            snapshots: ports.client(robot)?,
            pacings: ports.reader(robot, false)?,
            controls: control.then(|| ports.writer(robot)).transpose()?,
            policies: None,
            policy_due: MonotonicNs(0),
            policy_full: false,
            routes: None,
            routes_due: None,
            details: None,
            details_due: None,
            tables: None,
            tables_due: None,
            map_awaited: None,
        })
    }

    /// Shows the history on one more screen.
    pub fn add(&mut self, screen: Box<dyn Screen>) {
        self.screens.push(screen);
    }

    /// Adds how the mission stands.
    pub(crate) fn set_progress(&self, progress: Progress) {
        self.history().set_progress(progress);
    }

    pub(crate) fn receive_early(&mut self) -> Early {
        let mut routes = self.routes.as_mut();
        let priors = routes.as_mut().and_then(|ports| ports.priors.as_mut());
        Early {
            pacing: accept(self.pacings.newest()),
            page: accept(self.snapshots.receive()),
            prior: accept(priors.and_then(Client::receive)),
            route: accept(routes.and_then(|ports| ports.routes.receive())),
            detail: accept(self.details.as_mut().and_then(Client::receive)),
            table: accept(self.tables.as_mut().and_then(Client::receive)),
        }
    }

    /// Whether it needs no more from others: it has the prior, the motion table, the routes, the details and the map of the end, or
    /// cannot have them.
    pub(crate) fn is_whole(&self, has_perception: bool, now: MonotonicNs) -> bool {
        let waits =
            has_perception && self.map_awaited.is_some_and(|since| now.since_ns(since) <= LAST_MAP_NS);
        let history = self.history();
        let has_pages = self.routes.is_none() || !history.lacks_pages();
        let has_table = self.tables.is_none() || !history.lacks_table();
        !waits && has_pages && has_table && (self.details.is_none() || !history.lacks_details())
    }

    /// Adds to the history what came, and asks perception for what is missing.
    pub(crate) fn take(&mut self, events: &[Event], early: Early, ports: &mut P) -> Result<(), Failure> {
        let policy = self.policy(ports);
        let mut request = None;
        let mut history = self.history();
        let mut add = |news: Input<'_>| request = history.on(news, ports.now()).or(request);
        for event in events {
            match event {
                Event::Brief(brief) => add(Input::Brief(brief)),
                Event::State(state) => add(Input::State(state)),
                Event::Past(page) => add(Input::Past(page)),
                Event::Map(patch) => add(Input::Patch(patch.clone())),
                Event::Heartbeat(beat) => add(Input::Heartbeat(beat)),
                Event::Team(team) => add(Input::Team(team)),
                Event::Refused(_) | Event::Tick => {}
            }
        }
        let (page, pacing) = (early.page.as_ref().map(Input::Page), early.pacing.map(Input::Pacing));
        let (prior, route) = (early.prior.map(Input::Prior), early.route.as_ref().map(Input::Route));
        let (detail, table) = (early.detail.as_ref().map(Input::Detail), early.table.map(Input::Table));
        let late = [page, pacing, prior, table, route, detail, policy.map(Input::Policy), Some(Input::Tick)];
        late.into_iter().flatten().for_each(add);
        let lacks_map = history.lacks_last_map();
        drop(history);
        self.map_awaited = lacks_map.then(|| self.map_awaited.unwrap_or_else(|| ports.now()));
        if let Some(request) = request {
            self.snapshots.request(request).map_err(Into::into)?;
        }
        self.open_details(ports);
        self.open_tables(ports);
        self.ask_for_pages(ports)
    }

    /// Opens the client for details, once there are any.
    fn open_details(&mut self, ports: &mut P) {
        let now = ports.now();
        let is_due = self.details_due.is_none_or(|due| now >= due);
        if self.details.is_some() || !is_due || !self.history().lacks_details() {
            return;
        }
        match ports.client(RobotId(0)) {
            Ok(client) => self.details = Some(client),
            Err(error) => {
                if self.details_due.is_none() {
                    tracing::warn!("hops are shown from cell to cell until there is a place: {error}");
                }
                self.details_due = Some(now.plus_ns(PLACE_NS));
            }
        }
    }

    /// Opens the client for the motion table, where planners believe one.
    fn open_tables(&mut self, ports: &mut P) {
        let now = ports.now();
        let is_due = self.tables_due.is_none_or(|due| now >= due);
        if self.tables.is_some() || !is_due || !self.history().lacks_table() {
            return;
        }
        match ports.client(RobotId(0)) {
            Ok(client) => self.tables = Some(client),
            Err(error) => {
                if self.tables_due.is_none() {
                    tracing::warn!("no reasons for hops are shown until there is a place: {error}");
                }
                self.tables_due = Some(now.plus_ns(PLACE_NS));
            }
        }
    }

    /// Asks hopper-sim for prior, motion table, routes and details, where there are any.
    fn ask_for_pages(&mut self, ports: &mut P) -> Result<(), Failure> {
        let now = ports.now();
        let is_due = self.routes_due.is_none_or(|due| now >= due);
        let known = self.routes.as_ref();
        let lacks =
            |brief: &Brief| known.is_none_or(|ports| ports.priors.is_none() && brief.sampling.is_some());
        let brief =
            self.history().brief().filter(|brief| is_due && brief.has_routes() && lacks(brief)).cloned();
        if let Some(brief) = brief {
            match RoutePorts::open(ports, &brief) {
                Ok(opened) => self.routes = Some(opened),
                Err(error) => {
                    if self.routes_due.is_none() {
                        tracing::warn!(
                            "no expected speeds and routes are shown until there is a place: {error}"
                        );
                    }
                    self.routes_due = Some(now.plus_ns(PLACE_NS));
                }
            }
        }
        if self.routes.is_none() && self.details.is_none() && self.tables.is_none() {
            return Ok(());
        }
        let wanted = self.history().wanted(now);
        if let (Some(request), Some(tables)) = (wanted.table, &mut self.tables) {
            tables.request(request).map_err(Into::into)?;
        }
        if let (Some(request), Some(details)) = (wanted.detail, &mut self.details) {
            details.request(request).map_err(Into::into)?;
        }
        let Some(routes) = &mut self.routes else { return Ok(()) };
        if let (Some(request), Some(priors)) = (wanted.prior, &mut routes.priors) {
            priors.request(request).map_err(Into::into)?;
        }
        if let Some(request) = wanted.route {
            routes.routes.request(request).map_err(Into::into)?;
        }
        Ok(())
    }

    /// Shows the history and passes orders on; whether whoever looks has had enough.
    pub(crate) fn show(&mut self, ports: &mut P) -> Result<bool, Failure> {
        let mut orders = Vec::new();
        for screen in &mut self.screens {
            let history = self.history.lock().unwrap_or_else(PoisonError::into_inner);
            for wish in screen.show(&history, ports.now())? {
                match wish {
                    Wish::Quit => return Ok(true),
                    Wish::Order(order) => orders.push(order),
                }
            }
        }
        let run = self.history().brief().map(|brief| brief.run);
        if let (Some(run), Some(controls)) = (run, &mut self.controls) {
            for order in orders {
                tracing::info!("asked to {}", words(&order));
                controls.publish(Control { run, robot: self.robot, order }).map_err(Into::into)?;
            }
            controls.idle();
        }
        Ok(false)
    }

    fn history(&self) -> MutexGuard<'_, History> {
        self.history.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A policy, now and then, while somebody wants to see one.
    fn policy(&mut self, ports: &mut P) -> Option<Policy> {
        let now = ports.now();
        if !self.screens.iter().any(|screen| screen.wants_policy()) || now < self.policy_due {
            self.policies = None;
            return None;
        }
        if self.policies.is_none() {
            match ports.try_reader(self.robot) {
                Ok(reader) => self.policies = Some(reader),
                Err(error) => {
                    if !std::mem::replace(&mut self.policy_full, true) {
                        tracing::warn!("no policy is shown until there is a place to read it from: {error}");
                    }
                    self.policy_due = now.plus_ns(PLACE_NS);
                    return None;
                }
            }
        }
        let policy = accept(self.policies.as_mut().and_then(Reader::newest));
        if let Some(policy) = &policy {
            self.policy_due = now.plus_ns(POLICY_PERIOD_NS + POLICY_CELL_NS * policy.cells.len() as u64);
        }
        policy
    }
}

fn words(order: &Order) -> String {
    match order {
        Order::Pause => "pause".into(),
        Order::Resume => "resume".into(),
        Order::Step => "step".into(),
        Order::Pace(pace) => format!("land at pace {pace}"),
        Order::HandOver(life) => format!("hand over to the planner of life {life}"),
    }
}
