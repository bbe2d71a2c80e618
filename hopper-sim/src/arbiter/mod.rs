//! The state machine that decides which command becomes a hop, and tells when it has.
//!
//! One command at a time is under way:
//!
//! ```text
//! Resting --Command--> Committing --Appended--> Flying --landing--> Resting
//!                        |    ^
//!             AppendFailed    Tick: the very same record again
//!                        v    |
//!                       Unwritten
//! ```
//!
//! At [`Pace::Max`] the flight takes no time: landing and the next state follow the commit at once.
//! Nothing is known to the world before the journal holds it; what the journal holds is published again
//! and again until the world has moved on.
//!
//! Before a command is executed the [`Guard`](crate::Guard) judges it. What it vetoes is refused by name and published with the
//! state, so that a planner chooses again. If a deadline is given and no command is accepted until then, the
//! fallback acts in the planner's stead, and the record says so.

mod admission;
mod bid;
mod event;
mod execution;
mod landing;
mod presence;

use contract::{
    Action, Collected, Decision, Detail, Digest, Leader, MonotonicNs, Origin, Pacing, PeerTable, Policy,
    Pose, Record, Refusal, RefusalCounts, RobotId, RobotSet, Route, RouteId, State, Team, Timing, Vetoed,
};

use crate::{Attachment, Mission, Pace, ROBOT, RobotTeam, Throttle};
pub use bid::BID_GRACE_NS;
use bid::Bid;
pub use event::{Effect, Event};
pub use presence::ANNOUNCE_NS;

/// How often the current state is published again, nanoseconds: a lost sample costs no more.
pub const REPUBLISH_NS: u64 = 100_000_000;

#[derive(Clone, Copy, Debug)]
enum Phase {
    /// Waits for a command.
    Resting,
    /// The journal has been asked to take the record.
    Committing(Record),
    /// The journal could not; the next tick asks again.
    Unwritten(Record),
    /// Committed, in the air; `State::landed` of the next state is the landing to come.
    Flying(State),
}

/// Sole judge of commands and sole source of states.
#[derive(Clone, Debug)]
pub struct Arbiter {
    mission: Mission,
    throttle: Throttle,
    linger_ns: u64,
    /// Whether deadlines pass by the clock.
    deadlines: bool,
    state: State,
    /// The robots. They are one decision ahead of the state while that is under way.
    robots: RobotTeam,
    /// What is published of them with the state; nothing of a hopper alone.
    team: Option<Team>,
    phase: Phase,
    /// At most one for each robot.
    bids: Vec<Bid>,
    /// The last policy heard of; kept only if there may be a fallback.
    policy: Option<Policy>,
    /// The first decision of the present leg that this life knows of.
    leg_began: Decision,
    /// When the current state was last published; `None` before the first time.
    sent: Option<MonotonicNs>,
    finished: bool,
    /// Since when peers are heard that do not know of this run.
    unknown_since: Option<MonotonicNs>,
    peer_table: PeerTable,
    refusals: RefusalCounts,
}

impl Arbiter {
    /// The arbiter of a new mission, or of one resumed behind `last`, the journal's last record:
    /// leader and term are those of the record, and a hop that was in the air has landed at `now`. Unless a hopper
    /// is alone, [`Arbiter::recall`] needs all records first.
    ///
    /// `linger_ns` is how long the final state is served at most for peers that have not seen it.
    ///
    /// # Panics
    /// If the terrain is not on the brief's grid or the start is not on it.
    #[must_use]
    pub fn new(
        mission: Mission,
        last: Option<&Record>,
        pace: Pace,
        linger_ns: u64,
        now: MonotonicNs,
    ) -> Self {
        let brief = &mission.brief;
        assert!(mission.terrain.grid == brief.grid, "the terrain lies on the grid of the brief");
        let first = brief.robots[0].start.cell;
        let start = mission.terrain.ground(first).expect("the start lies on the grid");
        let mut robots = RobotTeam::new(&mission);
        let (status, visits) = robots.opening();
        if let Some(last) = last
            && !brief.has_team()
        {
            robots.resume(&mission.terrain, last);
        }
        let state = match last {
            Some(record) => record.state_after(brief.run, now, MonotonicNs(0)),
            None => State {
                run: brief.run,
                robot: ROBOT,
                decision: Decision(0),
                steps: brief.reading.opening_steps,
                visits,
                status,
                leader: Leader::default(),
                pose: Pose { cell: first, height_m: start.height_m },
                collected: Collected::default(),
                vetoed: Vetoed::NONE,
                last: None,
                last_origin: Origin::Planner,
                last_vetoed: Vetoed::NONE,
                previous: Digest::default(),
                digest: mission.genesis(),
                landed: now,
                published: MonotonicNs(0),
                last_timing: Timing::default(),
            },
        };
        Self {
            team: brief.has_team().then(|| robots.team(&state)),
            robots,
            mission,
            throttle: Throttle::new(pace),
            linger_ns,
            deadlines: true,
            state,
            phase: Phase::Resting,
            bids: Vec::new(),
            policy: None,
            leg_began: Decision(0),
            sent: None,
            finished: false,
            unknown_since: None,
            peer_table: PeerTable::default(),
            refusals: RefusalCounts::default(),
        }
    }

    /// This arbiter, which obeys [`Event::Control`] from now on.
    #[must_use]
    pub fn obeying_orders(mut self) -> Self {
        self.throttle.obey_orders();
        self
    }

    /// This arbiter for a mission that is repeated from its journal: no deadline passes by the
    /// clock, and what the fallback did comes as [`Event::Repeat`].
    #[must_use]
    pub fn without_deadlines(mut self) -> Self {
        self.deadlines = false;
        self
    }

    /// Takes note of the decisions of earlier lives, in order and page by page. Does nothing for a hopper alone,
    /// whose last record is enough.
    pub fn recall(&mut self, records: &[Record]) {
        if self.mission.brief.has_team() {
            records.iter().for_each(|record| self.robots.recall(&self.mission.terrain, record));
            self.team = Some(self.robots.team(&self.state));
        }
    }

    /// Adds routes that earlier lives announced, before their decisions are recalled.
    pub fn recall_routes(&mut self, routes: impl IntoIterator<Item = Route>) {
        routes.into_iter().for_each(|route| self.robots.recall_route(route));
    }

    /// Takes what the motion model told of the last action of `robot` in an earlier life.
    pub fn recall_detail(&mut self, robot: RobotId, detail: Detail) {
        self.robots.recall_detail(robot, detail);
    }

    /// What `record`, which is to be appended, names.
    #[must_use]
    pub fn attachment(&self, record: &Record) -> Option<Attachment> {
        if !record.detail.is_none() {
            return self.robots.detail(record.robot).cloned().map(Attachment::Detail);
        }
        match record.action {
            Action::Announce(id) => self.route(id).cloned().map(Attachment::Route),
            _ => None,
        }
    }

    /// All routes that robots of this mission have announced.
    pub fn routes(&self) -> impl Iterator<Item = &Route> {
        self.robots.routes()
    }

    /// The route with that fingerprint, if a robot of this mission has announced it.
    #[must_use]
    pub fn route(&self, id: RouteId) -> Option<&Route> {
        self.robots.route(id)
    }

    /// The announced route `id`; `None` if it is unknown, or if the journal does not hold the
    /// record yet that announces it.
    #[must_use]
    pub fn committed_route(&self, id: RouteId) -> Option<&Route> {
        let is_uncommitted = match &self.phase {
            Phase::Committing(record) | Phase::Unwritten(record) => record.action == Action::Announce(id),
            Phase::Resting | Phase::Flying(_) => false,
        };
        if is_uncommitted { None } else { self.route(id) }
    }

    /// Takes an event that happened at `now`; the effects are to be carried out in order.
    ///
    /// # Panics
    /// If the host reports an append that it was not asked for.
    // Long: an arm for each event.
    pub fn on(&mut self, event: Event, now: MonotonicNs) -> Vec<Effect> {
        // Most events ask for nothing; these two for one effect as a rule, and room for four would be slow to get.
        let mut effects = match event {
            Event::Command(_) | Event::Appended => Vec::with_capacity(1),
            _ => Vec::new(),
        };
        match event {
            Event::Command(Ok(ref command)) => match self.admit(command, now) {
                Ok(leader) => {
                    // A planner may answer what an earlier life published.
                    if self.sent.is_none() {
                        effects.push(self.take_up(now));
                    }
                    let record = self.execute(command, leader, now);
                    effects.push(self.commit(record));
                }
                Err(refusal) => {
                    self.keep_bid(self.bid_of(command, &refusal, now), now);
                    self.refuse(refusal, now, &mut effects);
                }
            },
            Event::Command(Err(refusal)) => self.refuse(refusal, now, &mut effects),
            Event::Announcement(announcement) => {
                if let Err(refusal) = announcement.and_then(|announcement| self.offer(announcement)) {
                    self.refuse(refusal, now, &mut effects);
                }
            }
            Event::Stranger(command) => {
                let unknown = Refusal::UnknownLife { incarnation: command.incarnation };
                let refusal = self.admit(&command, now).err().unwrap_or(unknown);
                self.refuse(refusal, now, &mut effects);
            }
            Event::Appended => {
                let Phase::Committing(record) = &self.phase else {
                    panic!("appended a record that was not to be appended");
                };
                self.phase = Phase::Flying(self.state_after(record, now));
                self.land(now, &mut effects);
            }
            Event::AppendFailed => {
                let Phase::Committing(record) = self.phase else {
                    panic!("failed to append a record that was not to be appended");
                };
                self.phase = Phase::Unwritten(record);
            }
            Event::Refused(refusal) => self.refusals.count(&refusal),
            Event::Heartbeat(beat) => {
                self.peer_table.observe(beat, now);
                effects.extend(self.announce(&beat, now));
            }
            Event::Control(control) => {
                if let Err(refusal) = control.and_then(|control| self.obey(&control, now)) {
                    self.refusals.count(&refusal);
                    effects.push(Effect::Refused(refusal));
                }
                self.land(now, &mut effects);
            }
            Event::Policy(policy) => self.keep(policy),
            Event::Repeat(fallback) => {
                let due = matches!(self.phase, Phase::Resting) && !self.state.status.is_over();
                effects.extend(due.then(|| self.fall_back(fallback, now)));
            }
            Event::Tick => {
                if let Phase::Unwritten(record) = self.phase {
                    effects.push(self.commit(record));
                }
                self.land(now, &mut effects);
                match self.sent {
                    None => effects.push(self.take_up(now)),
                    Some(sent) if now.since_ns(sent) >= REPUBLISH_NS => effects.push(self.publish(now)),
                    Some(_) => {}
                }
                if self.deadline().is_some_and(|deadline| now >= deadline) {
                    let fallback = self.fallback();
                    effects.push(self.fall_back(fallback, now));
                }
            }
        }
        effects.extend(self.conclude(now));
        effects
    }

    fn refuse(&mut self, refusal: Refusal, now: MonotonicNs, effects: &mut Vec<Effect>) {
        self.refusals.count(&refusal);
        let vetoed = refusal.vetoed();
        if let Some(action) = vetoed {
            self.state.vetoed = self.state.vetoed.with(action);
        }
        let late = matches!(refusal, Refusal::RepeatedDecision { .. } | Refusal::OtherPast { .. });
        let missed = vetoed.is_some() || late;
        effects.push(Effect::Refused(refusal));
        // Its sender may have missed the state that answers it. Before the mission is taken up the first tick tells all.
        if missed && self.sent.is_some() {
            effects.push(self.publish(now));
        }
    }

    /// The next moment at which a tick has something to do: a landing, a republication, the deadline of a
    /// decision, the end of the linger. A host may tick more often.
    #[must_use]
    pub fn wake_at(&self) -> Option<MonotonicNs> {
        let Some(sent) = self.sent else { return Some(self.state.landed) };
        let republication = sent.plus_ns(REPUBLISH_NS);
        let landing = match &self.phase {
            Phase::Flying(next) if !self.throttle.holds() => Some(next.landed),
            _ => None,
        };
        let end = self.is_lingering().then(|| self.state.published.plus_ns(self.linger_ns));
        [Some(republication), landing, end, self.deadline()].into_iter().flatten().min()
    }

    /// The current state: while a hop is under way, the one before it.
    #[must_use]
    pub fn state(&self) -> &State {
        &self.state
    }

    /// All robots as of the current state; `None` where there is a single hopper.
    #[must_use]
    pub fn team(&self) -> Option<&Team> {
        self.team.as_ref()
    }

    /// Number of robots.
    #[must_use]
    pub fn robots(&self) -> u16 {
        self.robots.count()
    }

    /// The robot whose turn it is by the current state.
    pub(crate) fn due(&self) -> RobotId {
        self.team.as_ref().map_or(ROBOT, |team| team.due)
    }

    /// The robots that still act.
    #[must_use]
    pub fn acting(&self) -> RobotSet {
        match &self.team {
            _ if self.state.status.is_over() => RobotSet::NONE,
            Some(team) => team.acting(),
            None => RobotSet::NONE.with(ROBOT),
        }
    }

    /// What is flown, the seed included, which no other process knows.
    #[must_use]
    pub fn mission(&self) -> &Mission {
        &self.mission
    }

    /// How landings are paced at present.
    #[must_use]
    pub fn pacing(&self) -> Pacing {
        Pacing {
            run: self.state.run,
            robot: self.state.robot,
            pace: self.throttle.pace(),
            paused: self.throttle.is_paused(),
            obeys: self.throttle.obeys(),
        }
    }

    /// What was refused so far, by reason.
    #[must_use]
    pub fn refusals(&self) -> &RefusalCounts {
        &self.refusals
    }
}
