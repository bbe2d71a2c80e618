//! Readers of every public message, and clients for what was missed.

use contract::message::{Message as _, Visitor};
use contract::{
    Announcement, Brief, Command, Control, DetailPage, DetailRequest, Heartbeat, MapPatch, MapRequest,
    MonotonicNs, Pacing, PastRequest, Policy, PriorPage, PriorRequest, RobotId, RoutePage, RouteRequest,
    State, Team,
};
use process::{Client, Ports, Reader, accept};
use recording::{JsonMessage, RecordedMessage as Message, Requests, Transcript};

use crate::robot_ports::{LateClient, RobotPorts, well_formed};

/// Longest and shortest pause between two looks, nanoseconds.
const PERIODS_NS: [u64; 2] = [20_000_000, 1_000_000];

/// Messages of one look at which the shortest queues, those of patches and commands, are a quarter full.
const MANY: usize = 4;

/// Readers of every public message, and clients for what was missed.
pub struct RecorderPorts<P: Ports> {
    briefs: P::Reader<Brief>,
    states: P::Reader<State>,
    teams: P::Reader<Team>,
    announcements: P::Reader<Announcement>,
    maps: P::Reader<MapPatch>,
    commands: P::Reader<Command>,
    beats: P::Reader<Heartbeat>,
    controls: P::Reader<Control>,
    pacings: P::Reader<Pacing>,
    policies: Option<P::Reader<Policy>>,
    past: P::Client<PastRequest>,
    snapshots: P::Client<MapRequest>,
    /// Of the robots but the first, once the brief says how many there are.
    robots: RobotPorts<P>,
    priors: LateClient<P, PriorRequest>,
    routes: LateClient<P, RouteRequest>,
    details: LateClient<P, DetailRequest>,
    /// One reader for each message without a schema of ours.
    others: Vec<Drain>,
    period_ns: u64,
}

/// What one look found.
#[derive(Debug, Default)]
pub struct Received {
    early: Vec<Message>,
    teams: Vec<Team>,
    announcements: Vec<Announcement>,
    ordered: Vec<Message>,
    prior: Option<PriorPage>,
    route: Option<RoutePage>,
    detail: Option<DetailPage>,
    others: Vec<JsonMessage>,
}

/// Gives the messages of one service that came since the last call.
type Drain = Box<dyn FnMut() -> Vec<JsonMessage>>;

/// Opens a reader for each message that is recorded as JSON.
struct Others<'p, P: Ports> {
    ports: &'p mut P,
    readers: Vec<Drain>,
    error: Option<P::Error>,
}

impl<P: Ports + 'static> Visitor for Others<'_, P> {
    fn message<M: contract::Message>(&mut self) {
        let service = M::SERVICE.name;
        let has_a_reader = service == Team::SERVICE.name || service == Announcement::SERVICE.name;
        if JsonMessage::topic::<M>().is_none() || has_a_reader || self.error.is_some() {
            return;
        }
        match self.ports.reader::<M>(RobotId(0), false) {
            Ok(mut reader) => self.readers.push(Box::new(move || {
                let messages = reader.drain().into_iter().filter_map(|message| accept(Some(message)));
                messages.filter_map(|message| JsonMessage::of(&message)).collect()
            })),
            Err(error) => self.error = Some(error),
        }
    }

    fn request<Q: contract::Request>(&mut self) {}
}

impl<P: Ports + 'static> RecorderPorts<P> {
    /// Opens every port; that of policies only if they are wanted, since planners make them for readers alone.
    ///
    /// # Errors
    /// If a port cannot be had.
    pub fn open(ports: &mut P, with_policies: bool) -> Result<Self, P::Error> {
        let robot = RobotId(0);
        let mut others = Others { ports, readers: Vec::new(), error: None };
        contract::wire::visit(&mut others);
        let Others { ports, readers: others, error } = others;
        if let Some(error) = error {
            return Err(error);
        }
        Ok(Self {
            briefs: ports.reader(robot, false)?,
            states: ports.reader(robot, false)?,
            teams: ports.reader(robot, false)?,
            announcements: ports.reader(robot, false)?,
            maps: ports.reader(robot, false)?,
            commands: ports.reader(robot, false)?,
            beats: ports.reader(robot, false)?,
            controls: ports.reader(robot, false)?,
            pacings: ports.reader(robot, false)?,
            policies: with_policies.then(|| ports.reader(robot, false)).transpose()?,
            past: ports.client(robot)?,
            snapshots: ports.client(robot)?,
            robots: RobotPorts::default(),
            priors: LateClient::default(),
            routes: LateClient::default(),
            details: LateClient::default(),
            others,
            period_ns: PERIODS_NS[0],
        })
    }

    /// Sends the requests.
    ///
    /// # Errors
    /// If a port fails.
    pub fn ask(&mut self, ports: &mut P, wanted: Requests) -> Result<(), P::Error> {
        if let Some(request) = wanted.past {
            self.past.request(request)?;
        }
        if let Some(request) = wanted.map {
            self.snapshots.request(request)?;
        }
        self.priors.ask(ports, wanted.prior, "viewers get no expected speeds")?;
        self.routes.ask(ports, wanted.route, "routes whose announcements were missed are not recorded")?;
        self.details.ask(ports, wanted.detail, "impacts and exact rest positions are not recorded")
    }

    /// Whether the prior can be had.
    #[must_use]
    pub fn can_have_prior(&self) -> bool {
        !self.priors.is_full()
    }

    /// Whether routes can be asked for.
    #[must_use]
    pub fn can_have_routes(&self) -> bool {
        !self.routes.is_full()
    }

    /// Whether what the motion model tells can be asked for.
    #[must_use]
    pub fn can_have_details(&self) -> bool {
        !self.details.is_full()
    }

    /// How long to wait for the next look at most, nanoseconds: the less the fuller the queues were.
    #[must_use]
    pub fn period_ns(&self) -> u64 {
        self.period_ns
    }

    /// Reads policies from now on, or no longer. That there is no place for another reader is no error: it is tried again.
    pub fn want_policies(&mut self, ports: &mut P, wanted: bool) {
        if !wanted {
            self.policies = None;
        } else if self.policies.is_none() {
            self.policies = ports.try_reader(RobotId(0)).ok();
        }
    }

    /// Everything that came, in the order of publication.
    pub fn receive(&mut self, ports: &mut P) -> Received {
        // The page before the patches: with it come all patches published before it was made.
        let page = accept(self.snapshots.receive()).map(Message::Page);
        // Teams before states, and states before patches, so that none comes without what it belongs to.
        let teams = well_formed(self.teams.drain());
        let mut ordered = known(self.states.drain(), Message::State);
        let states = ordered.len();
        ordered.extend(known(self.maps.drain(), Message::Patch));
        let maps = ordered.len() - states;
        ordered.extend(known(self.commands.drain(), Message::Command));
        let mut commands = ordered.len() - states - maps;
        let (of_robots, longest) = self.robots.commands();
        ordered.extend(of_robots.into_iter().map(Message::Command));
        commands = commands.max(longest);
        // Stable: what was published at one moment stays in the order of its services.
        ordered.sort_by_key(Message::published);
        let mut early = known(self.beats.drain(), Message::Heartbeat);
        let briefs = well_formed(self.briefs.drain());
        if let Some(brief) = briefs.last() {
            self.robots.follow(ports, brief);
        }
        early.extend(briefs.into_iter().map(Message::Brief));
        early.extend(known(self.pacings.drain(), Message::Pacing));
        early.extend(known(self.controls.drain(), Message::Control));
        ordered.extend(page);
        ordered.extend(accept(self.past.receive()).map(Message::Past));
        ordered.extend(accept(self.policies.as_mut().and_then(Reader::newest)).map(Message::Policy));
        let most = maps.max(commands).max(states / 4);
        self.period_ns = if most >= MANY { PERIODS_NS[1] } else { PERIODS_NS[0].min(self.period_ns * 2) };
        let mut announcements = well_formed(self.announcements.drain());
        announcements.extend(self.robots.announcements());
        let (prior, route, detail) = (self.priors.receive(), self.routes.receive(), self.details.receive());
        if prior.is_some() || route.is_some() || detail.is_some() {
            // The next page is asked for at once.
            self.period_ns = PERIODS_NS[1];
        }
        let others = self.others.iter_mut().flat_map(|drain| drain()).collect();
        Received { early, teams, announcements, ordered, prior, route, detail, others }
    }
}

impl Received {
    /// Passes everything to `transcript` in order; returns what it requests.
    pub fn tell(self, transcript: &mut Transcript, now: MonotonicNs) -> Requests {
        let mut wanted = Requests::default();
        for message in self.early {
            wanted = wanted.or(transcript.on(message, now));
        }
        for team in &self.teams {
            transcript.on_team(team, now);
        }
        for announcement in &self.announcements {
            transcript.on_announcement(announcement, now);
        }
        for message in self.ordered {
            wanted = wanted.or(transcript.on(message, now));
        }
        if let Some(page) = self.prior {
            transcript.on_prior(page);
        }
        if let Some(page) = &self.route {
            transcript.on_route(page, now);
        }
        if let Some(page) = self.detail {
            transcript.on_detail(page, now);
        }
        for message in &self.others {
            transcript.on_json(message, now);
        }
        wanted
    }
}

fn known<M>(messages: Vec<Result<M, contract::Refusal>>, message: impl Fn(M) -> Message) -> Vec<Message> {
    well_formed(messages).into_iter().map(message).collect()
}
