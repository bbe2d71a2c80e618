//! Which messages a recording or a live viewer gets, on which channel.
//!
//! It requests what was missed, or was published before it began: executed decisions from `hop/past` until it has all of
//! them, the map from `hop/snapshot`, announced routes from `hop/routes`, and what the motion model told of decisions from
//! `hop/details`. The answers are written too, routes as announcements.

use std::collections::{BTreeMap, BTreeSet};

use contract::limits::{ASK_AGAIN_NS, PAST_PAGE_RECORDS};
use contract::message::Message as _;
use contract::{
    Announcement, Brief, Decision, DetailPage, DetailRequest, Incarnation, Leader, MapRequest, MonotonicNs,
    PastPage, PastRequest, PriorPage, PriorRequest, RobotId, RoutePage, RouteRequest, RunId, State, Status,
    Team, Vetoed,
};
use follow::{Link, PastFollower, PriorFollower, Replica};
use prost::Message as _;

use crate::announced_routes::AnnouncedRoutes;
use crate::channel::ROBOT;
use crate::proto::foxglove::log::Level;
use crate::view::{self, ViewMessage, Views};
use crate::waiting_records::WaitingRecords;
use crate::{Channel, JsonMessage, RecordedMessage, SequenceGap, SequenceGaps};

/// Time between two requests for the past while less than a page is missing, nanoseconds.
const PAST_PERIOD_NS: u64 = 250_000_000;

/// Most processes whose start is logged.
const LOGGED_PROCESSES_MAX: usize = 4096;

/// Requests that the caller has to send for the recorder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Requests {
    /// Request to `hop/past`.
    pub past: Option<PastRequest>,
    /// Request to `hop/snapshot`.
    pub map: Option<MapRequest>,
    /// Request to `hop/prior`.
    pub prior: Option<PriorRequest>,
    /// Request to `hop/routes`.
    pub route: Option<RouteRequest>,
    /// Request to `hop/details`.
    pub detail: Option<DetailRequest>,
}

impl Requests {
    /// `later` where it has a request, else this.
    #[must_use]
    pub fn or(self, later: Requests) -> Self {
        Self {
            past: later.past.or(self.past),
            map: later.map.or(self.map),
            prior: later.prior.or(self.prior),
            route: later.route.or(self.route),
            detail: later.detail.or(self.detail),
        }
    }
}

/// A message to write.
#[derive(Clone, Debug, PartialEq)]
pub struct EncodedMessage {
    /// Where to.
    pub topic: Topic,
    /// Protobuf of the channel's schema, or JSON.
    pub data: Vec<u8>,
    /// When it was published; when it was received, if it has no such time.
    pub published: MonotonicNs,
    /// When it was received or made.
    pub logged: MonotonicNs,
}

/// Where a message is written to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Topic {
    /// A channel with a schema.
    Known(Channel),
    /// Commands of a robot but the first, whose are in [`Channel::Command`].
    Commands(RobotId),
    /// JSON under the name of its service.
    Json(String),
}

impl Topic {
    /// Its name.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Topic::Known(channel) => channel.name(),
            Topic::Commands(robot) => contract::Command::SERVICE.name_of(*robot),
            Topic::Json(name) => name.clone(),
        }
    }

    /// The channel whose schema its messages have.
    #[must_use]
    pub fn schema(&self) -> Option<Channel> {
        match self {
            Topic::Known(channel) => Some(*channel),
            Topic::Commands(_) => Some(Channel::Command),
            Topic::Json(_) => None,
        }
    }
}

/// Follows missions, one after another.
pub struct Transcript {
    out: Vec<EncodedMessage>,
    gaps: SequenceGaps,
    missing: BTreeMap<String, u64>,
    brief: Option<Brief>,
    state: Option<State>,
    /// The records that came, and those that are missing.
    past: PastFollower,
    /// How often the past was read again from its beginning.
    pasts: u64,
    map: Replica,
    views: Views,
    routes: AnnouncedRoutes,
    details: WaitingRecords,
    /// Of uncertain ground, for viewers: it is not written.
    prior: PriorFollower,
    processes: BTreeSet<Incarnation>,
}

impl Default for Transcript {
    fn default() -> Self {
        Self {
            out: Vec::new(),
            gaps: SequenceGaps::default(),
            missing: BTreeMap::new(),
            brief: None,
            state: None,
            past: PastFollower::default(),
            pasts: 0,
            map: Replica::new(ROBOT),
            views: Views::default(),
            routes: AnnouncedRoutes::default(),
            details: WaitingRecords::default(),
            prior: PriorFollower::default(),
            processes: BTreeSet::new(),
        }
    }
}

impl Transcript {
    /// What is to be written since the last call.
    #[must_use]
    pub fn take(&mut self) -> Vec<EncodedMessage> {
        std::mem::take(&mut self.out)
    }

    /// The run that is followed.
    #[must_use]
    pub fn run(&self) -> Option<RunId> {
        self.brief.as_ref().map(|brief| brief.run)
    }

    /// The last state.
    #[must_use]
    pub fn state(&self) -> Option<&State> {
        self.state.as_ref()
    }

    /// How often the past was read again from its beginning, and the first decision whose record is missing.
    #[must_use]
    pub fn written(&self) -> (u64, Decision) {
        (self.pasts, self.due())
    }

    /// Whether the mission is over and every record is there.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.state.is_some_and(|state| state.status.is_over() && self.due() >= state.decision)
    }

    /// Number of missing messages so far, by topic.
    #[must_use]
    pub fn missing(&self) -> &BTreeMap<String, u64> {
        &self.missing
    }

    /// Takes a message received at `now`. Of messages received together, pass states, patches and commands in the
    /// order of their publication, and pages last.
    pub fn on(&mut self, message: RecordedMessage, now: MonotonicNs) -> Requests {
        self.write(&message, now);
        let mut requests = Requests::default();
        match message {
            RecordedMessage::Brief(brief) => self.brief(brief, now),
            RecordedMessage::State(state) => self.on_state(&state, now),
            RecordedMessage::Patch(patch) => {
                if self.is_of_run(patch.run, patch.robot) {
                    let gap = self.gaps.patch(&patch);
                    self.record_gap(gap, now);
                }
                requests.map = self.map.patch(patch, now);
            }
            RecordedMessage::Page(page) => requests.map = self.map.page(&page, now),
            RecordedMessage::Heartbeat(beat) => {
                let gap = self.gaps.beat(&beat);
                self.record_gap(gap, now);
                if self.processes.len() < LOGGED_PROCESSES_MAX && self.processes.insert(beat.incarnation) {
                    let text = format!("{} processes, process {} {}", beat.role, beat.pid, beat.planner);
                    self.log(Level::Info, beat.role.as_str(), text.trim_end().into(), now);
                }
            }
            RecordedMessage::Past(page) => requests.past = self.past(&page, now),
            RecordedMessage::Policy(policy) => {
                if self.is_of_run(policy.run, policy.robot) {
                    self.views.policy(policy);
                }
            }
            RecordedMessage::Command(_)
            | RecordedMessage::Control(_)
            | RecordedMessage::Pacing(_)
            | RecordedMessage::Host(_)
            | RecordedMessage::Gap(_) => {}
        }
        requests
    }

    /// Takes a message that has no schema of ours, received at `now`.
    pub fn on_json(&mut self, message: &JsonMessage, now: MonotonicNs) {
        let topic = Topic::Json(message.topic.clone());
        self.out.push(EncodedMessage { topic, data: message.json.clone(), published: now, logged: now });
    }

    /// Takes where all robots are, received at `now`. Pass it before the state it was published with.
    pub fn on_team(&mut self, team: &Team, now: MonotonicNs) {
        if let Some(message) = JsonMessage::of(team) {
            self.on_json(&message, now);
        }
        if self.run() == Some(team.run) {
            self.views.team(team, self.map.map());
            self.routes.team(team);
        }
    }

    /// Takes a page of the prior that was asked for.
    pub fn on_prior(&mut self, page: PriorPage) {
        // A page that cannot be is asked for again.
        let _ = self.prior.page(page);
        if let Some(prior) = self.prior.take() {
            self.views.prior(&prior.cells);
        }
    }

    /// Whether the expected speeds of uncertain ground are still to come.
    #[must_use]
    pub fn lacks_prior(&self) -> bool {
        self.prior.is_missing()
    }

    /// Takes a route that a robot will take, received at `now`.
    pub fn on_announcement(&mut self, announcement: &Announcement, now: MonotonicNs) {
        self.write_announcement(announcement, now);
        if self.is_of_run(announcement.run, announcement.robot) {
            self.views.announcement(announcement);
        }
    }

    /// Takes a route that was asked for: it is written as the announcement that did not come.
    pub fn on_route(&mut self, page: &RoutePage, now: MonotonicNs) {
        if self.run() != Some(page.run) {
            return;
        }
        for announcement in self.routes.page(page) {
            self.write_announcement(&announcement, now);
            if self.routes.is_last(announcement.robot, &announcement.route) {
                self.views.announcement(&announcement);
            }
        }
    }

    /// Whether the points of routes that robots announced are still to come.
    #[must_use]
    pub fn lacks_routes(&self) -> bool {
        self.routes.lacks_points()
    }

    /// Takes what the motion model told of a decision, as asked for, received at `now`.
    pub fn on_detail(&mut self, page: DetailPage, now: MonotonicNs) {
        let Some((page, is_new)) = self.details.page(page) else { return };
        if is_new && let Some(message) = JsonMessage::of_answer::<DetailRequest>(&page) {
            self.on_json(&message, now);
        }
        self.draw_records(false);
        if let Some(state) = self.state.filter(|state| state.decision == page.decision.next()) {
            let messages = self.views.rest(&state, page.detail.rest_m);
            self.put_views(messages, now);
        }
    }

    /// Whether what the motion model told of some decision is still to come.
    #[must_use]
    pub fn lacks_details(&self) -> bool {
        self.details.is_missing()
    }

    /// Number of details of the run that were written.
    pub(crate) fn details_written(&self) -> usize {
        self.details.written()
    }

    /// Draws the ways of the decisions whose details are there, or of all.
    fn draw_records(&mut self, all: bool) {
        while let Some((record, detail)) = self.details.next(all) {
            self.views.record(&record, detail.as_ref());
        }
    }

    /// Number of routes of the run that were written.
    pub(crate) fn routes_written(&self) -> usize {
        self.routes.written()
    }

    fn write_announcement(&mut self, announcement: &Announcement, now: MonotonicNs) {
        let &Announcement { run, robot, ref route } = announcement;
        if let Some(message) = JsonMessage::of_robot(announcement, robot) {
            self.on_json(&message, now);
        }
        if self.is_of_run(run, robot) {
            self.routes.wrote(robot, route);
        }
    }

    /// Lets time pass; returns the requests that are due.
    pub fn tick(&mut self, now: MonotonicNs) -> Requests {
        self.draw(now, false);
        let route = self.run().and_then(|run| self.routes.ask(run, now));
        let (past, map, prior) = (self.past_wanted(now), self.map.ask(now), self.prior.ask(now));
        Requests { past, map, prior, route, detail: self.details.ask(now) }
    }

    /// Adds what viewers shall see at the end.
    pub fn finish(&mut self, now: MonotonicNs) {
        self.draw_records(true);
        self.draw(now, true);
    }

    fn brief(&mut self, brief: Brief, now: MonotonicNs) {
        if self.brief.as_ref().is_some_and(|known| known.run == brief.run) {
            return;
        }
        self.gaps.begin();
        (self.brief, self.state) = (Some(brief.clone()), None);
        self.views.begin(&brief);
        self.routes = AnnouncedRoutes::default();
        self.details.begin(brief.run);
        self.prior.begin(&brief);
        self.forget_past();
        self.map = Replica::new(ROBOT);
        self.map.begin(&brief);
        let text = format!("run {} of {} in profile {}", brief.run, brief.scenario, brief.profile);
        self.log(Level::Info, "hopper-sim", text, now)
    }

    /// Whether a message belongs to the current run; only within a run are sequence numbers consecutive.
    fn is_of_run(&self, run: RunId, robot: RobotId) -> bool {
        self.brief.as_ref().is_some_and(|brief| brief.run == run && robot.0 < brief.robots.count())
    }

    fn on_state(&mut self, state: &State, now: MonotonicNs) {
        let Some(brief) = &self.brief else { return };
        if state.run != brief.run || !state.is_news(brief.robots.count(), self.state.as_ref()) {
            return;
        }
        let gap = self.gaps.state(state);
        self.record_gap(gap, now);
        let before = self.state.replace(*state);
        if self.past.is_contradicted_by(state) && !self.past.is_late(state) {
            // A journal that has lost its tail, or was flown on elsewhere: those decisions are executed again.
            self.forget_past();
        }
        if before.is_none_or(|before| before.decision != state.decision) {
            let messages = self.views.state(state);
            self.put_views(messages, now);
        }
        self.log_state(before.as_ref(), state, now)
    }

    /// Logs what a state means to a person: leader, vetoes, fallback, end.
    fn log_state(&mut self, before: Option<&State>, state: &State, now: MonotonicNs) {
        let led = before.map_or(Leader::default(), |before| before.leader);
        if (state.leader.incarnation, state.leader.term) != (led.incarnation, led.term) {
            let Leader { planner, pid, term, .. } = state.leader;
            let text = format!("{planner}, process {pid}, commands under term {term}");
            self.log(Level::Info, "planner", text, now);
        }
        if state.vetoed != before.map_or(Vetoed::NONE, |before| before.vetoed) && !state.vetoed.is_empty() {
            let text =
                format!("the guard vetoed {} actions at decision {}", state.vetoed.count(), state.decision);
            self.log(Level::Warning, "guard", text, now);
        }
        if state.last_origin.is_fallback() && before.is_some_and(|before| before.decision != state.decision) {
            let text =
                format!("the fallback acted ({}) before decision {}", state.last_origin, state.decision);
            self.log(Level::Warning, "guard", text, now);
        }
        if state.status.is_over() && before.is_none_or(|before| !before.status.is_over()) {
            let level = if state.status == Status::Goal { Level::Info } else { Level::Error };
            let text = format!("the mission is over: {} after {} decisions", state.status, state.decision);
            self.log(level, "hopper-sim", text, now);
        }
    }

    /// Counts executed decisions; returns the next request if they were a full page and more are missing.
    fn past(&mut self, page: &PastPage, now: MonotonicNs) -> Option<PastRequest> {
        if !self.is_of_run(page.run, page.robot) {
            return None;
        }
        for record in &page.records {
            match self.past.link(record) {
                Link::Next => {
                    self.details.record(record);
                    self.draw_records(false);
                    self.routes.record(record);
                    self.past.fold(record);
                }
                Link::OtherDecision => {}
                Link::Broken => return None,
                Link::PastIsLost => {
                    self.forget_past();
                    return None;
                }
            }
        }
        let is_whole = self.state.is_none_or(|state| self.due() >= state.decision);
        if page.records.len() < PAST_PAGE_RECORDS || is_whole {
            return None;
        }
        self.past.ask(page.run, ROBOT, now)
    }

    /// Asks for all records again.
    fn forget_past(&mut self) {
        self.past.begin_anew();
        self.pasts += 1;
        self.views.forget_past();
        self.routes.forget_missing();
        self.details.forget_past();
    }

    /// First decision whose record is still missing.
    fn due(&self) -> Decision {
        self.past.due()
    }

    fn past_wanted(&mut self, now: MonotonicNs) -> Option<PastRequest> {
        let (brief, state) = (self.brief.as_ref()?, self.state?);
        let behind = state.decision.0.saturating_sub(self.due().0);
        let urgent = behind >= PAST_PAGE_RECORDS as u64 || state.status.is_over();
        let pause_ns = if urgent { ASK_AGAIN_NS } else { PAST_PERIOD_NS };
        if behind == 0 {
            return None;
        }
        self.past.ask_after(brief.run, ROBOT, now, pause_ns)
    }

    /// Writes for viewers what changed and is due, or everything that changed if the file ends.
    fn draw(&mut self, now: MonotonicNs, ends: bool) {
        let messages = self.views.draw(self.map.map(), now, ends);
        self.put_views(messages, now);
    }

    fn put_views(&mut self, messages: Vec<ViewMessage>, now: MonotonicNs) {
        for (channel, data, moment) in messages {
            self.put(channel, data, moment, now);
        }
    }

    fn record_gap(&mut self, gap: Option<SequenceGap>, now: MonotonicNs) {
        let Some(gap) = gap else { return };
        let missing = self.missing.entry(gap.topic.clone()).or_default();
        *missing = missing.saturating_add(gap.missing());
        let text = format!("{} {} of {} did not reach the recorder", gap.missing(), gap.counted, gap.topic);
        self.write(&RecordedMessage::Gap(gap), now);
        self.log(Level::Warning, "recorder", text, now)
    }

    fn log(&mut self, level: Level, name: &str, text: String, now: MonotonicNs) {
        self.put(Channel::ViewLog, view::line(level, name, text, now).encode_to_vec(), now, now);
    }

    fn write(&mut self, message: &RecordedMessage, now: MonotonicNs) {
        let topic = match message {
            RecordedMessage::Command(command) if command.robot != ROBOT => Topic::Commands(command.robot),
            _ => Topic::Known(message.topic()),
        };
        let published = message.published().unwrap_or(now);
        self.out.push(EncodedMessage { topic, data: message.encode(), published, logged: now });
    }

    fn put(&mut self, channel: Channel, data: Vec<u8>, published: MonotonicNs, logged: MonotonicNs) {
        self.out.push(EncodedMessage { topic: Topic::Known(channel), data, published, logged });
    }
}
