//! The perception process: ports around the [`Cartographer`].

use contract::{
    Brief, MapPatch, MapRequest, Name, PastRequest, RobotId, Role, RouteRequest, State, TruthRequest,
};
use process::{
    Client, Failure, Membership, Ports, Process, Reader, Server, Terms, Turn, Writer, accept, log_refusal,
};

use crate::{Cartographer, Effect, Event};

/// Points at which a test may kill this process: see [`Ports::pass`].
pub const CRASH_POINTS: &[&str] = &[
    "perception.joined",
    "perception.state_received",
    "perception.sensed",
    "perception.part_published",
    "perception.published",
];

/// Builds the observed map and serves it.
pub struct Perception<P: Ports> {
    membership: Membership<P>,
    cartographer: Cartographer,
    briefs: P::Reader<Brief>,
    truths: P::Client<TruthRequest>,
    states: P::Reader<State>,
    past: P::Client<PastRequest>,
    /// Opened in a mission whose robots have routes.
    routes: Option<P::Client<RouteRequest>>,
    maps: P::Writer<MapPatch>,
    snapshots: P::Server<MapRequest>,
}

impl<P: Ports> Perception<P> {
    /// Joins the instance. `cartographer` knows nothing yet.
    ///
    /// # Errors
    /// If a port cannot be had.
    pub async fn join(ports: &mut P, cartographer: Cartographer, terms: Terms) -> Result<Self, P::Error> {
        let robot = RobotId(0);
        let perception = Self {
            membership: Membership::join(ports, Role::Perception, Name::NONE, terms)?,
            states: ports.reader(robot, true)?,
            briefs: ports.reader(robot, false)?,
            truths: ports.client(robot)?,
            past: ports.client(robot)?,
            routes: None,
            maps: ports.writer(robot)?,
            snapshots: ports.server(robot)?,
            cartographer,
        };
        ports.pass("perception.joined").await;
        Ok(perception)
    }

    /// What it has mapped so far.
    #[must_use]
    pub fn cartographer(&self) -> &Cartographer {
        &self.cartographer
    }

    /// The cartographer of a process that takes no more turns.
    #[must_use]
    pub fn into_cartographer(self) -> Cartographer {
        self.cartographer
    }

    /// Everything that came since, in the order in which the cartographer needs it.
    async fn receive(&mut self, ports: &mut P) -> Vec<Effect> {
        let mut effects = Vec::new();
        for _ in 0..self.membership.depth() {
            if self.membership.hear(ports.now()).is_none() {
                break;
            }
        }
        if let Some(brief) = accept(self.briefs.newest()) {
            append(&mut effects, self.cartographer.on(Event::Brief(brief), ports.now()));
        }
        if let Some(page) = accept(self.truths.receive()) {
            append(&mut effects, self.cartographer.on(Event::Truth(page), ports.now()));
        }
        if let Some(state) = accept(self.states.newest()) {
            ports.pass("perception.state_received").await;
            append(&mut effects, self.cartographer.on(Event::State(state), ports.now()));
        }
        if let Some(page) = self.routes.as_mut().and_then(|routes| accept(routes.receive())) {
            append(&mut effects, self.cartographer.on(Event::Route(page), ports.now()));
        }
        if let Some(page) = accept(self.past.receive()) {
            append(&mut effects, self.cartographer.on(Event::Past(page), ports.now()));
        }
        append(&mut effects, self.cartographer.on(Event::Tick, ports.now()));
        effects
    }

    async fn carry_out(&mut self, effect: Effect, ports: &mut P) -> Result<(), P::Error> {
        match effect {
            Effect::RequestPast(request) => self.past.request(request)?,
            Effect::RequestRoute(request) => {
                let routes = match &mut self.routes {
                    Some(routes) => routes,
                    closed => closed.insert(ports.client(RobotId(0))?),
                };
                routes.request(request)?;
            }
            Effect::RequestTruth(request) => self.truths.request(request)?,
            Effect::PublishMap => {
                let sensed = ports.now();
                ports.pass("perception.sensed").await;
                for patch in self.cartographer.patches(sensed, &mut || ports.now()) {
                    self.maps.publish(patch)?;
                    ports.pass("perception.part_published").await;
                }
                ports.pass("perception.published").await;
            }
            Effect::Refused(refusal) => log_refusal(&refusal),
            Effect::Finished(status) => self.membership.mission_ended(status, ports.now()),
        }
        Ok(())
    }
}

impl<P: Ports> Process<P> for Perception<P> {
    async fn turn(&mut self, ports: &mut P) -> Result<Turn, Failure> {
        for effect in self.receive(ports).await {
            self.carry_out(effect, ports).await.map_err(Into::into)?;
        }
        // After the patches: a page never covers a landing that is not published.
        let (cartographer, mut is_asked) = (&self.cartographer, false);
        let page = |request: &MapRequest| {
            is_asked = true;
            cartographer.page(request)
        };
        for refusal in self.snapshots.serve(page).map_err(Into::into)? {
            log_refusal(&refusal);
        }
        if is_asked || self.membership.is_watched(ports.now()) {
            self.membership.stay_a_moment(ports.now());
        }
        self.maps.idle();
        self.membership.close_turn(ports, self.cartographer.seen(), self.cartographer.waits_for())
    }
}

/// Adds what an event asks for: most ask for nothing, and most turns have one list, which is taken as it is.
fn append(effects: &mut Vec<Effect>, mut more: Vec<Effect>) {
    if more.is_empty() {
        return;
    }
    if effects.is_empty() {
        *effects = more;
    } else {
        effects.append(&mut more);
    }
}
