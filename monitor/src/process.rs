//! The monitor process: ports around the [`Watcher`], its display and its observers.
//!
//! No message wakes it: it looks twenty times a second, so that watching costs the watched nothing, and fills what it
//! missed from `hop/past`.

use contract::{
    Brief, Decision, MapPatch, MonotonicNs, Name, PastRequest, Refusal, RobotId, Role, RunId, State, Status,
    Team,
};
use process::{Client, Exit, Failure, Membership, Ports, Process, Reader, TICK_NS, Terms, Turn};

use crate::{Effect, Event, Progress, View, Watcher};

/// Points at which a test may kill this process: see [`Ports::pass`].
pub const CRASH_POINTS: &[&str] = &["monitor.joined", "monitor.state_received"];

/// How often the monitor looks, nanoseconds.
const PERIOD_NS: u64 = 50_000_000;

/// Shows progress as a line or a bar.
pub trait Display {
    /// Shows how the mission stands at `now`, as `watcher` has folded it: ten times a second, and at its end.
    fn show(&mut self, progress: &Progress, watcher: &Watcher, now: MonotonicNs);

    /// The mission is over; `watcher` holds all of it.
    ///
    /// # Errors
    /// If what was asked for cannot be written.
    fn finished(&mut self, watcher: &Watcher, now: MonotonicNs) -> Result<(), Failure>;
}

/// Follows the mission with ports of its own: a recording, a live connection.
pub trait Observer<P: Ports> {
    /// How long to wait for the next look at most, nanoseconds.
    fn period_ns(&self) -> u64;

    /// Takes what came since, and writes what is due. An error of a file ends the recording, not the monitor.
    ///
    /// # Errors
    /// If a port fails.
    fn turn(&mut self, ports: &mut P) -> Result<(), Failure>;

    /// Whether it needs no more from hopper-sim: it has the record of every decision of `run` before `decision`, or has
    /// given up.
    fn is_whole_until(&self, run: RunId, decision: Decision) -> bool;

    /// Takes what came since and ends.
    ///
    /// # Errors
    /// If the file could not be written.
    fn finish(&mut self, ports: &mut P) -> Result<(), Failure>;
}

/// Watches the mission of one robot.
pub struct Monitor<P: Ports, D: Display> {
    membership: Membership<P>,
    watcher: Watcher,
    display: D,
    view: Option<View<P>>,
    observers: Vec<Box<dyn Observer<P>>>,
    briefs: P::Reader<Brief>,
    states: P::Reader<State>,
    teams: P::Reader<Team>,
    maps: P::Reader<MapPatch>,
    past: P::Client<PastRequest>,
    /// The end of the mission, while the last records are waited for.
    over: Option<Status>,
}

impl<P: Ports, D: Display> Monitor<P, D> {
    /// Joins the instance.
    ///
    /// # Errors
    /// If a port cannot be had.
    pub async fn join(
        ports: &mut P,
        display: D,
        view: Option<View<P>>,
        observers: Vec<Box<dyn Observer<P>>>,
        terms: Terms,
    ) -> Result<Self, P::Error> {
        let robot = RobotId(0);
        let monitor = Self {
            membership: Membership::join(ports, Role::Monitor, Name::NONE, terms)?,
            watcher: Watcher::new(robot),
            display,
            view,
            observers,
            briefs: ports.reader(robot, false)?,
            states: ports.reader(robot, false)?,
            teams: ports.reader(robot, false)?,
            maps: ports.reader(robot, false)?,
            past: ports.client(robot)?,
            over: None,
        };
        ports.pass("monitor.joined").await;
        Ok(monitor)
    }

    /// Ends every observer, whatever ended the watch.
    ///
    /// # Errors
    /// If the file could not be written.
    pub fn finish(&mut self, ports: &mut P) -> Result<(), Failure> {
        let mut ended = Ok(());
        for mut observer in self.observers.drain(..) {
            ended = ended.and(observer.finish(ports));
        }
        ended
    }

    /// What it has folded so far.
    #[must_use]
    pub fn watcher(&self) -> &Watcher {
        &self.watcher
    }

    /// Everything that came since, and that time has passed.
    async fn receive(&mut self, ports: &mut P) -> Vec<Event> {
        let mut events: Vec<Event> = Vec::new();
        for _ in 0..self.membership.depth() {
            let Some(beat) = self.membership.hear(ports.now()) else { break };
            events.push(event(beat, Event::Heartbeat));
        }
        events.extend(self.briefs.newest().map(|brief| event(brief, Event::Brief)));
        // All of them: each may tell of a route that the next one no longer does.
        events.extend(self.teams.drain().into_iter().map(|team| event(team, Event::Team)));
        // The maps first: the mission may end with the last of these states.
        events.extend(self.maps.drain().into_iter().map(|map| event(map, Event::Map)));
        for state in self.states.drain() {
            ports.pass("monitor.state_received").await;
            events.push(event(state, Event::State));
        }
        events.extend(self.past.receive().map(|page| event(page, Event::Past)));
        events.push(Event::Tick);
        events
    }

    fn carry_out(&mut self, effect: Effect, now: MonotonicNs) -> Result<(), Failure> {
        match effect {
            Effect::RequestPast(request) => self.past.request(request).map_err(Into::into)?,
            Effect::Progress(progress) => {
                self.display.show(&progress, &self.watcher, now);
                if let Some(view) = &self.view {
                    view.set_progress(*progress);
                }
            }
            Effect::Finished(status) => {
                self.display.finished(&self.watcher, now)?;
                self.over = Some(status);
            }
        }
        Ok(())
    }

    /// Whether page and terminal have what they show of uncertain ground, routes, and the ground that was seen.
    fn is_shown_whole(&self, now: MonotonicNs) -> bool {
        let has_perception = self.watcher.peer_table().has(Role::Perception, now);
        self.view.as_ref().is_none_or(|view| view.is_whole(has_perception, now))
    }

    /// What the heartbeat acknowledges. The end of the mission is acknowledged only once the record of every decision
    /// is in the file, and prior and routes are on the page, so that hopper-sim stays to be asked.
    fn acknowledged(&mut self, now: MonotonicNs) -> (RunId, Decision, Status) {
        let (run, decision, status) = self.watcher.seen();
        let is_whole = self.is_shown_whole(now)
            && self.observers.iter().all(|observer| observer.is_whole_until(run, decision));
        let nobody_to_ask = || !self.watcher.peer_table().has(Role::HopperSim, now);
        if is_whole || (self.over.is_some() || status.is_over()) && nobody_to_ask() {
            if let Some(status) = self.over.take() {
                self.membership.mission_ended(status, now);
            }
            (run, decision, status)
        } else {
            (run, decision, Status::Underway)
        }
    }
}

impl<P: Ports, D: Display> Process<P> for Monitor<P, D> {
    async fn turn(&mut self, ports: &mut P) -> Result<Turn, Failure> {
        for observer in &mut self.observers {
            observer.turn(ports)?;
        }
        // Before the states: a pacing message is never shown before a landing that preceded it, nor a page before a
        // patch that is in it.
        let early = self.view.as_mut().map(View::receive_early);
        let events = self.receive(ports).await;
        if let (Some(view), Some(early)) = (&mut self.view, early) {
            view.take(&events, early, ports)?;
        }
        for event in events {
            for effect in self.watcher.on(event, ports.now()) {
                self.carry_out(effect, ports.now())?;
            }
        }
        if let Some(view) = &mut self.view
            && view.show(ports)?
        {
            return Ok(Turn::Leave(Exit::Done));
        }
        let seen = self.acknowledged(ports.now());
        let turn = self.membership.close_turn(ports, seen, self.watcher.waits_for())?;
        let look_ns =
            if self.past.is_waiting() || !self.is_shown_whole(ports.now()) { TICK_NS } else { PERIOD_NS };
        let observe_ns = self.observers.iter().map(|observer| observer.period_ns()).min();
        Ok(match turn {
            Turn::Sleep(_) => Turn::Sleep(observe_ns.map_or(look_ns, |period_ns| period_ns.min(look_ns))),
            leave @ Turn::Leave(_) => leave,
        })
    }
}

/// A message as the watcher receives it; a malformed one is counted there.
fn event<T>(message: Result<T, Refusal>, event: impl Fn(T) -> Event) -> Event {
    message.map_or_else(Event::Refused, event)
}
