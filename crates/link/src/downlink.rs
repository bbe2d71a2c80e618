//! The downlink: messages in, packets out.

use std::collections::VecDeque;

use contract::{
    Brief, Decision, DetailPage, DetailRequest, MapPage, MapPatch, MapRequest, MonotonicNs, PastPage,
    PastRequest, RobotId, RoutePage, RouteRequest, RunId, State, Team, Vetoed,
};
use follow::{Heard, Mission};
use telemetry::{Event, EventKind, Kind, Latency, MissionTime, Packet, Telemetry};

use crate::budget::{Budget, Passes};
use crate::clock::MissionClock;
use crate::history::{History, Page};
use crate::map_sender::MapSender;
use crate::shares::Shares;

/// Events that wait; of more the first are passed over, and counted.
const EVENTS_WAITING: usize = 256;

/// Mission time after which the brief, and the last patch of the map, are told again: the ground may have missed them.
const AGAIN: u64 = 600 * MissionTime::UNITS_PER_S;

/// Mission time that a summary of times covers at least.
const SUMMARY: u64 = 600 * MissionTime::UNITS_PER_S;

/// Bytes of a packet at least and at most, as far as it can be cut: what goes down in eight seconds, so that an event
/// does not wait longer.
const PACKET_BYTES: [u64; 2] = [512, 4096];

/// How the downlink is set up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Bits in a second of mission time; `None` for any number.
    pub rate: Option<u64>,
    /// When the ground can be reached; `None` for always.
    pub passes: Option<Passes>,
    /// Mission time that a decision takes: observing, planning and hopping.
    pub step: MissionTime,
}

/// A message for the downlink.
#[derive(Clone, Debug)]
#[allow(missing_docs, reason = "named after their messages")]
pub enum Input {
    Brief(Brief),
    State(State),
    Team(Team),
    Patch(MapPatch),
    Page(MapPage),
    Past(PastPage),
    Route(RoutePage),
    Detail(DetailPage),
}

/// What is to be asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Requests {
    /// Cells of the map.
    pub map: Option<MapRequest>,
    /// Executed decisions.
    pub past: Option<PastRequest>,
    /// Points of a route.
    pub route: Option<RouteRequest>,
    /// What the motion model tells of a decision.
    pub detail: Option<DetailRequest>,
}

impl Requests {
    /// These, and `later` where there is none.
    #[must_use]
    pub fn or(self, later: Self) -> Self {
        Self {
            map: self.map.or(later.map),
            past: self.past.or(later.past),
            route: self.route.or(later.route),
            detail: self.detail.or(later.detail),
        }
    }
}

/// What was sent, and what waits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Packets of each kind, in the order of [`Kind::ALL`].
    pub packets: [u64; Kind::ALL.len()],
    /// Their bytes.
    pub bytes: [u64; Kind::ALL.len()],
    /// States that a newer one replaced before they were sent.
    pub states_replaced: u64,
    /// Events that were passed over since too many waited.
    pub events_passed_over: u64,
    /// Cells that wait.
    pub cells_waiting: usize,
    /// Decisions that wait, in the journal most of them.
    pub decisions_waiting: u64,
}

/// Who shares what events and the brief leave, with their weights.
const SHARES: [(Class, u64); 4] =
    [(Class::State, 4), (Class::Map, 8), (Class::History, 3), (Class::Latency, 1)];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Class {
    State,
    Map,
    History,
    Latency,
}

/// Takes the messages of a mission and makes packets of them.
///
/// Events go first, then the brief; the rest share: a quarter the newest state, half the map, and the rest executed
/// decisions and summaries of times. What one has no use for the others get.
#[derive(Clone, Debug)]
pub struct Downlink {
    settings: Settings,
    clock: MissionClock,
    budget: Budget,
    packet_bytes: u64,
    mission: Mission,
    events: VecDeque<Event>,
    /// When the brief is due.
    brief_due: Option<MissionTime>,
    state_waits: bool,
    /// The team of the state, which is sent before it.
    team_waits: Option<Team>,
    map: MapSender,
    /// When the last patch is told again.
    reminder_due: MissionTime,
    history: History,
    latency: Latency,
    /// When the summary of times is due.
    latency_due: MissionTime,
    shares: Shares<4>,
    /// Packets of each kind so far, which number them.
    sequences: [u16; Kind::ALL.len()],
    now: MissionTime,
    tally: Tally,
}

impl Downlink {
    /// A downlink that knows no mission yet. The first packet says that the link has begun.
    #[must_use]
    pub fn new(settings: &Settings) -> Self {
        let [least, most] = PACKET_BYTES;
        let started = Event::new(EventKind::LinkStarted, RobotId(0), Decision(0));
        Self {
            settings: *settings,
            clock: MissionClock::new(settings.step),
            budget: Budget::new(settings.rate, settings.passes),
            packet_bytes: settings.rate.map_or(most, |rate| rate.clamp(least, most)),
            mission: Mission::default(),
            events: VecDeque::from([started]),
            brief_due: None,
            state_waits: false,
            team_waits: None,
            map: MapSender::new(),
            reminder_due: MissionTime::default(),
            history: History::default(),
            latency: Latency::default(),
            latency_due: MissionTime::from_units(SUMMARY),
            shares: Shares::new(SHARES.map(|(_, weight)| weight)),
            sequences: [0; Kind::ALL.len()],
            now: MissionTime::default(),
            tally: Tally::default(),
        }
    }

    /// Takes a message that came at `now`.
    pub fn on(&mut self, input: Input, now: MonotonicNs) -> Requests {
        let mut wanted = Requests::default();
        match input {
            Input::Brief(brief) => self.brief(brief),
            Input::State(state) => self.state(&state, now),
            Input::Team(team) => self.mission.hear_team(team),
            Input::Patch(patch) => wanted.map = self.map.patch(patch, now),
            Input::Page(page) => wanted.map = self.map.page(&page, now),
            Input::Past(page) => {
                if self.history.page(&page) {
                    self.past_lost();
                }
            }
            Input::Route(page) => self.history.route(page),
            Input::Detail(page) => self.history.detail(page),
        }
        wanted
    }

    /// What is to be asked for at `now`.
    pub fn ask(&mut self, now: MonotonicNs) -> Requests {
        Requests {
            map: self.map.ask(now),
            past: self.history.ask_past(now),
            route: self.history.ask_route(now),
            detail: self.history.ask_detail(now),
        }
    }

    /// It is `now`: more may be sent, and what is told again from time to time may be due.
    pub fn advance(&mut self, now: MonotonicNs) {
        self.now = self.clock.at(now);
        self.budget.advance(self.now);
        if self.reminder_due <= self.now && !self.map.has() {
            self.reminder_due = MissionTime::from_units(self.now.units() + AGAIN);
            self.map.remind();
        }
    }

    /// Mission time as of the last [`Downlink::advance`].
    #[must_use]
    pub fn now(&self) -> MissionTime {
        self.now
    }

    /// What was sent, and what waits.
    #[must_use]
    pub fn tally(&self) -> Tally {
        Tally { cells_waiting: self.map.waiting(), decisions_waiting: self.history.waiting(), ..self.tally }
    }

    /// Cells of the map that went down, each counted once.
    #[must_use]
    pub fn sent_cells(&self) -> usize {
        self.map.sent_cells()
    }

    /// Sends cells again which the patches `first..=last` brought.
    pub fn map_again(&mut self, first: u64, last: u64) {
        self.map.again(first, last);
    }

    /// Sends the decisions `first..=last` again.
    pub fn history_again(&mut self, first: u64, last: u64) {
        self.history.again(first, last);
    }

    /// Whether it needs no more from hopper-sim and perception to send everything of `run` before `decision`.
    #[must_use]
    pub fn is_whole_until(&self, run: RunId, decision: Decision) -> bool {
        self.mission.run() != Some(run)
            || self.history.is_read_until(decision.0) && self.history.has_all_pages()
    }

    /// Whether the mission is over, and everything has been sent.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.mission.state_of_run().is_some_and(|state| state.status.is_over()) && self.is_idle()
    }

    /// Whether everything has been sent.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.events.is_empty()
            && !self.is_brief_due()
            && !self.state_waits
            && !self.map.has()
            && self.history.waiting() == 0
            && !self.history.has()
    }

    /// The next packet, if there is one and it may be sent now.
    pub fn take(&mut self) -> Option<Vec<u8>> {
        if !self.budget.is_open() {
            return None;
        }
        let (body, share) = self.next()?;
        let kind = body.kind();
        let place = Kind::ALL.iter().position(|one| *one == kind).expect("a kind of the list");
        let sequence = self.sequences[place];
        self.sequences[place] = (sequence + 1) % (1 << 14);
        let bytes = Packet { time: self.now, sequence, body }.encode();
        let bits = 8 * bytes.len() as u64;
        self.budget.spend(bits);
        if let Some(share) = share {
            let has = self.has();
            self.shares.sent(share, bits, has);
        }
        self.tally.packets[place] += 1;
        self.tally.bytes[place] += bytes.len() as u64;
        Some(bytes)
    }

    /// What is sent next, and whose share it is of.
    fn next(&mut self) -> Option<(Telemetry, Option<usize>)> {
        if let Some(event) = self.events.pop_front() {
            return Some((Telemetry::Event(event), None));
        }
        if self.is_brief_due()
            && let Some(brief) = self.mission.brief()
        {
            self.brief_due = Some(MissionTime::from_units(self.now.units() + AGAIN));
            return Some((Telemetry::Brief(brief.clone()), None));
        }
        let has = self.has();
        let place = self.shares.next(has)?;
        let body = match SHARES[place].0 {
            Class::State => self.next_state()?,
            Class::Map => Telemetry::Map(self.map.next(self.cells_max())),
            Class::History => match self.history.next_page() {
                Some(Page::Route(page)) => Telemetry::Route(page),
                Some(Page::Detail(page)) => Telemetry::Detail(page),
                None => Telemetry::Past(self.history.next(self.records_max())?),
            },
            Class::Latency => {
                self.latency_due = MissionTime::from_units(self.now.units() + SUMMARY);
                Telemetry::Latency(std::mem::take(&mut self.latency))
            }
        };
        Some((body, Some(place)))
    }

    /// Which of [`SHARES`] have something to send.
    fn has(&self) -> [bool; 4] {
        SHARES.map(|(class, _)| match class {
            Class::State => self.state_waits,
            Class::Map => self.map.has(),
            Class::History => self.history.has(),
            Class::Latency => self.latency.count > 0 && self.latency_due <= self.now,
        })
    }

    fn is_brief_due(&self) -> bool {
        self.mission.brief().is_some() && self.brief_due.is_none_or(|due| due <= self.now)
    }

    /// The newest state, or its team before it.
    fn next_state(&mut self) -> Option<Telemetry> {
        if let Some(team) = self.team_waits.take() {
            return Some(Telemetry::Team(team));
        }
        self.state_waits = false;
        self.mission.state_of_run().copied().map(Telemetry::State)
    }

    fn cells_max(&self) -> usize {
        let body = Kind::Map.body();
        let cells = (self.packet_bytes as usize).saturating_sub(body.head_bytes()) / body.cell_bytes();
        cells.clamp(1, contract::limits::MAP_PATCH_CELLS)
    }

    fn records_max(&self) -> usize {
        let body = Kind::Past.body();
        let records = (self.packet_bytes as usize).saturating_sub(body.head_bytes()) / body.cell_bytes();
        records.clamp(1, contract::limits::PAST_PAGE_RECORDS)
    }

    fn brief(&mut self, brief: Brief) {
        let before = self.mission.run();
        if before.is_some_and(|before| before != brief.run) {
            // Mission time begins again, and what waited of another mission is dropped. Packets are numbered on.
            let (sequences, tally) = (self.sequences, self.tally);
            *self = Self { sequences, tally, events: VecDeque::new(), ..Self::new(&self.settings) };
        }
        self.map.begin(&brief);
        self.history.begin(&brief);
        if before != Some(brief.run) {
            self.brief_due = None;
        }
        self.mission.hear_brief(brief);
    }

    fn state(&mut self, state: &State, now: MonotonicNs) {
        let before = self.mission.state_of_run().copied();
        if self.mission.run() != Some(state.run) {
            return;
        }
        match self.mission.hear_state(state) {
            Heard::Nothing => return,
            Heard::AnotherPast => self.past_lost(),
            Heard::News if self.history.is_contradicted_by(state) => self.past_lost(),
            Heard::News => {}
        }
        let Some(state) = self.mission.state_of_run().copied() else { return };
        let is_news = before.is_none_or(|before| {
            (before.decision, before.digest, before.vetoed, before.status, before.leader.term)
                != (state.decision, state.digest, state.vetoed, state.status, state.leader.term)
        });
        if !is_news {
            return;
        }
        self.clock.decision(state.decision, now);
        self.history.state(&state);
        self.events_of(before.as_ref(), &state);
        if before.is_none_or(|before| before.decision < state.decision) && state.last.is_some() {
            self.latency.add(Decision(state.decision.0 - 1), &state.last_timing);
        }
        self.tally.states_replaced += u64::from(self.state_waits);
        self.state_waits = true;
        self.team_waits = self.mission.team_of_state().cloned();
    }

    /// Events that follow from `state` after the one before.
    fn events_of(&mut self, before: Option<&State>, state: &State) {
        let event = |kind| Event::new(kind, state.robot, state.decision);
        let Some(before) = before else {
            self.event(event(EventKind::MissionFound));
            if state.status.is_over() {
                self.event(Event::mission_ended(state.decision, state.status));
            }
            return;
        };
        if state.vetoed != Vetoed::NONE && (before.decision, before.vetoed) != (state.decision, state.vetoed)
        {
            self.event(Event { value: state.vetoed.0.into(), ..event(EventKind::Vetoed) });
        }
        if state.leader.term != before.leader.term {
            let (value, name) = (state.leader.term.0, state.leader.planner);
            self.event(Event { value, name, ..event(EventKind::LeaderChanged) });
        }
        if state.collected != before.collected {
            self.event(Event { value: state.collected.0.count_ones().into(), ..event(EventKind::Collected) });
        }
        if state.status.is_over() && !before.status.is_over() {
            self.event(Event::mission_ended(state.decision, state.status));
        }
    }

    /// The journal has lost decisions: map and history are sent again.
    fn past_lost(&mut self) {
        let decision = self.mission.state().map(|state| state.decision).unwrap_or_default();
        self.event(Event::new(EventKind::PastLost, RobotId(0), decision));
        self.map.begin_anew();
        self.history.begin_anew();
        self.latency = Latency::default();
    }

    fn event(&mut self, event: Event) {
        if self.events.len() == EVENTS_WAITING {
            self.events.pop_front();
            self.tally.events_passed_over += 1;
        }
        self.events.push_back(event);
    }
}
