//! Ports of the downlink: what it reads of a mission, and what it asks for.

use contract::{
    Brief, DetailRequest, MapPatch, MapRequest, PastRequest, Refusal, Request, RobotId, RouteRequest, State,
    Team,
};
use process::{Client, Ports, Reader, accept};

use crate::downlink::{Downlink, Input, Requests};

/// Longest and shortest pause between two looks, nanoseconds.
const PERIODS_NS: [u64; 2] = [20_000_000, 1_000_000];

/// Patches or states of one look at which their queues are a quarter full.
const MANY: [usize; 2] = [4, 16];

/// Readers of what goes down, and clients for what was missed. They write nothing, so a mission costs the same with
/// them as with a monitor.
pub struct DownlinkPorts<P: Ports> {
    briefs: P::Reader<Brief>,
    states: P::Reader<State>,
    teams: P::Reader<Team>,
    maps: P::Reader<MapPatch>,
    past: P::Client<PastRequest>,
    snapshots: P::Client<MapRequest>,
    routes: Late<P, RouteRequest>,
    details: Late<P, DetailRequest>,
    period_ns: u64,
}

/// A client that is opened with its first request.
enum Late<P: Ports, Q: Request> {
    NotNeeded,
    Open(P::Client<Q>),
    /// All places were taken.
    Full,
}

impl<P: Ports, Q: Request> Late<P, Q> {
    fn ask(&mut self, ports: &mut P, request: Option<Q>) -> Result<(), P::Error> {
        let Some(request) = request else { return Ok(()) };
        if let Late::NotNeeded = self {
            *self = match ports.client(RobotId(0)) {
                Ok(client) => Late::Open(client),
                Err(error) => {
                    tracing::warn!("{} is not sent to the ground: {error}", Q::SERVICE.name);
                    Late::Full
                }
            };
        }
        match self {
            Late::Open(client) => client.request(request),
            Late::NotNeeded | Late::Full => Ok(()),
        }
    }

    fn receive(&mut self) -> Option<Q::Response> {
        match self {
            Late::Open(client) => accept(client.receive()),
            Late::NotNeeded | Late::Full => None,
        }
    }
}

impl<P: Ports> DownlinkPorts<P> {
    /// Opens every port.
    ///
    /// # Errors
    /// If a port cannot be had.
    pub fn open(ports: &mut P) -> Result<Self, P::Error> {
        let robot = RobotId(0);
        Ok(Self {
            briefs: ports.reader(robot, false)?,
            states: ports.reader(robot, false)?,
            teams: ports.reader(robot, false)?,
            maps: ports.reader(robot, false)?,
            past: ports.client(robot)?,
            snapshots: ports.client(robot)?,
            routes: Late::NotNeeded,
            details: Late::NotNeeded,
            period_ns: PERIODS_NS[0],
        })
    }

    /// How long to wait for the next look at most, nanoseconds: the less the fuller the queues were.
    #[must_use]
    pub fn period_ns(&self) -> u64 {
        self.period_ns
    }

    /// Passes everything that came to `downlink`, and asks for what it lacks.
    ///
    /// # Errors
    /// If a port fails.
    pub fn turn(&mut self, ports: &mut P, downlink: &mut Downlink) -> Result<(), P::Error> {
        let mut inputs = Vec::new();
        // The page before the patches: with it come all patches published before it was made.
        let page = accept(self.snapshots.receive());
        inputs.extend(accept(self.briefs.newest()).map(Input::Brief));
        inputs.extend(known(self.teams.drain(), Input::Team));
        let states = known(self.states.drain(), Input::State);
        let maps = known(self.maps.drain(), Input::Patch);
        let is_full = maps.len() >= MANY[0] || states.len() >= MANY[1];
        self.period_ns = if is_full { PERIODS_NS[1] } else { PERIODS_NS[0].min(2 * self.period_ns) };
        inputs.extend(states);
        inputs.extend(maps);
        inputs.extend(page.map(Input::Page));
        inputs.extend(accept(self.past.receive()).map(Input::Past));
        inputs.extend(self.routes.receive().map(Input::Route));
        inputs.extend(self.details.receive().map(Input::Detail));
        let now = ports.now();
        let mut wanted = Requests::default();
        for input in inputs {
            wanted = wanted.or(downlink.on(input, now));
        }
        let wanted = wanted.or(downlink.ask(now));
        downlink.advance(now);
        if wanted != Requests::default() {
            // The next page is asked for at once.
            self.period_ns = PERIODS_NS[1];
        }
        if let Some(request) = wanted.map {
            self.snapshots.request(request)?;
        }
        if let Some(request) = wanted.past {
            self.past.request(request)?;
        }
        self.routes.ask(ports, wanted.route)?;
        self.details.ask(ports, wanted.detail)
    }
}

/// The well-formed messages; others are logged and dropped.
fn known<M>(messages: Vec<Result<M, Refusal>>, input: impl Fn(M) -> Input) -> Vec<Input> {
    messages.into_iter().filter_map(|message| accept(Some(message))).map(input).collect()
}
