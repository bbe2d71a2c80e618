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
//! Before a command is executed the [`Guard`] judges it. What it vetoes is refused by name and published with the
//! state, so that a planner chooses again. If a deadline is given and no command is accepted until then, the
//! fallback acts in the planner's stead, and the record says so.

use contract::mission::pace::Launch;
use contract::protocol::peer_table::SILENCE_NS;
use contract::{
    Action, Announcement, Brief, Collected, Command, Control, Decision, Digest, Heartbeat, Incarnation,
    Leader, MonotonicNs, Origin, Outcome, Pacing, PeerTable, Policy, Pose, Record, Refusal, RefusalCounts,
    RobotId, RobotSet, Role, Route, RouteId, State, Status, Team, Timing, Vetoed,
};

use crate::dynamics::{Execution, execute};
use crate::guard::{Fallback, Guard};
use crate::mission::opening_status;
use crate::{Mission, Pace, ROBOT, RobotTeam, Throttle};

/// How often the current state is published again, nanoseconds: a lost sample costs no more.
pub const REPUBLISH_NS: u64 = 100_000_000;

/// How long the end is served to a role that nobody plays, nanoseconds, once all others know it.
const LATE_COMER_NS: u64 = 250_000_000;

/// How long a decision is at least kept for a planner that takes over, nanoseconds; twice the
/// decision budget if that is longer.
pub const BID_GRACE_NS: u64 = SILENCE_NS;

/// How long peers may go on beating without knowing the run before it is published again, nanoseconds: the brief
/// is published once, and whoever missed it would miss it for ever.
pub const ANNOUNCE_NS: u64 = SILENCE_NS;

/// What the arbiter receives.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "an event is made, taken, and gone")]
pub enum Event {
    /// A command came, or a message that was none.
    Command(Result<Command, Refusal>),
    /// A command of a life of which no heartbeat has been heard. It is judged like any other, but neither executed nor
    /// is a decision kept for it: it may be of another build, and is sent again.
    Stranger(Command),
    /// The points of a route came that a command may announce, or a message that was none.
    Announcement(Result<Announcement, Refusal>),
    /// The journal holds the record of the last [`Effect::Append`].
    Appended,
    /// The journal could not take the record of the last [`Effect::Append`].
    AppendFailed,
    /// A peer's heartbeat came.
    Heartbeat(Heartbeat),
    /// An order came, or a message that was none.
    Control(Result<Control, Refusal>),
    /// A planner's policy came; the last one is kept for the fallback.
    Policy(Policy),
    /// What the fallback did at the decision that is due when this mission was flown before: done again, as
    /// recorded. Deadlines pass by the clock, so a mission that is repeated goes by its journal.
    Repeat(Fallback),
    /// A message that is no command was malformed: it is counted, and nothing else.
    Refused(Refusal),
    /// Time has passed; the first publishes the state, and is the landing it tells of.
    Tick,
}

/// What the arbiter wants done.
#[derive(Clone, Debug, PartialEq)]
pub enum Effect {
    /// Append this record, then answer [`Event::Appended`] or [`Event::AppendFailed`].
    Append(Record),
    /// Publish the brief again: a peer does not know of this run.
    Announce,
    /// Tell everyone; only after its record is in the journal.
    Publish(State),
    /// Tell of a refused command; it is counted already.
    Refused(Refusal),
    /// The mission is over and everyone knows, or has been waited for. Comes once.
    Finished(Status),
}

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

/// A takeover that came too late for one decision, and for which the robot's next is kept: without it, a slow
/// planner would lose every race against a quick incumbent.
#[derive(Clone, Copy, Debug)]
struct Bid {
    incarnation: Incarnation,
    robot: RobotId,
    /// The decision that is kept.
    decision: Decision,
    /// When the bid was made.
    since: MonotonicNs,
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
    /// The robots, unless there is a single hopper. They are one decision ahead of the state while that is under way.
    robots: Option<RobotTeam>,
    /// What is published of the robots with the state.
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
    /// leader and term are those of the record, and a hop that was in the air has landed at `now`. Of a mission of several
    /// robots [`Arbiter::recall`] needs all records first.
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
        let start = mission.terrain.ground(brief.start).expect("the start lies on the grid");
        let state = match last {
            Some(record) => record.state_after(brief.run, now, MonotonicNs(0)),
            None => State {
                run: brief.run,
                robot: ROBOT,
                decision: Decision(0),
                steps: brief.reading.opening_steps,
                visits: 0,
                status: opening_status(brief),
                leader: Leader::default(),
                pose: Pose { cell: brief.start, height_m: start.height_m },
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
        let robots = mission.fleet.as_ref().map(|fleet| RobotTeam::new(brief, &mission.terrain, fleet));
        let state = match (&robots, last) {
            (Some(robots), None) => {
                let (status, visits) = robots.opening(brief);
                State { status, visits, ..state }
            }
            _ => state,
        };
        Self {
            team: robots.as_ref().map(|robots| robots.team(&state)),
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

    /// Takes note of the decisions of earlier lives, in order and page by page. For the mission of a single hopper the last
    /// record tells all.
    pub fn recall(&mut self, records: &[Record]) {
        if let Some(robots) = &mut self.robots {
            records.iter().for_each(|record| robots.recall(&self.mission.terrain, record));
            self.team = Some(robots.team(&self.state));
        }
    }

    /// Adds routes that earlier lives announced, before their decisions are recalled.
    pub fn recall_routes(&mut self, routes: impl IntoIterator<Item = Route>) {
        if let Some(robots) = &mut self.robots {
            routes.into_iter().for_each(|route| robots.recall_route(route));
        }
    }

    /// All routes that robots of this mission have announced.
    pub fn routes(&self) -> impl Iterator<Item = &Route> {
        self.robots.iter().flat_map(RobotTeam::routes)
    }

    /// The route with that fingerprint, if a robot of this mission has announced it.
    #[must_use]
    pub fn route(&self, id: RouteId) -> Option<&Route> {
        self.robots.as_ref()?.route(id)
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
        let vetoed = match refusal {
            Refusal::Vetoed { action, .. } | Refusal::Occupied { action, .. } => Some(action),
            _ => None,
        };
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
        self.robots.as_ref().map_or(1, RobotTeam::count)
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

    /// Whether the mission can go on: somebody senses who has its ground, and somebody plans for the robot that is due. One
    /// that is over, or under way with a fallback, needs nobody.
    #[must_use]
    pub fn is_manned(&self, peer_table: &PeerTable, now: MonotonicNs) -> bool {
        let senses = peer_table.has_of_run(Role::Perception, self.state.run, now);
        let due = RobotSet::NONE.with(self.due());
        let plans = peer_table.without_planner(due, now).is_empty();
        self.state.status.is_over() || self.falls_back() || senses && plans
    }

    /// Whether the guard's fallback acts where no planner does in time: once a mission with a deadline is under way.
    #[must_use]
    pub fn falls_back(&self) -> bool {
        // What is repeated from its journal may begin with what the fallback did.
        let has_begun = self.state.decision > Decision(0) || !self.deadlines;
        self.mission.brief.guard.deadline_ns > 0 && has_begun
    }

    /// The robot whose planner is to command next, if nothing is under way and nobody acts in its place.
    #[must_use]
    pub fn awaited(&self) -> Option<RobotId> {
        let rests = matches!(self.phase, Phase::Resting) && !self.state.status.is_over();
        if rests && !self.falls_back() { Some(self.due()) } else { None }
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

    /// Keeps the points of a route.
    fn offer(&mut self, announcement: Announcement) -> Result<(), Refusal> {
        if announcement.run != self.state.run {
            return Err(Refusal::WrongRun { need: self.state.run, got: announcement.run });
        }
        match &mut self.robots {
            Some(robots) => robots.offer(announcement),
            None => Err(Refusal::malformed("route", "a mission whose robots have routes", "another")),
        }
    }

    /// A refused command asks for the next term if it was only too late.
    fn bid_of(&self, command: &Command, refusal: &Refusal, now: MonotonicNs) -> Option<Bid> {
        let late = matches!(refusal, Refusal::Busy { .. } | Refusal::RepeatedDecision { .. });
        let robot = command.robot;
        if robot.0 >= self.robots() {
            return None;
        }
        let takes_over = command.term == self.leader(robot).term.next();
        // Whoever let one decision pass that was kept for it is too slow to be waited for.
        let slow = self.bid_for(robot).is_some_and(|bid| bid.incarnation == command.incarnation);
        let due = self.state.decision;
        let is_next = matches!(self.phase, Phase::Resting) && robot == self.due();
        let decision = if is_next { due } else { due.next() };
        let bid = Bid { incarnation: command.incarnation, robot, decision, since: now };
        (late && takes_over && !slow).then_some(bid)
    }

    /// Remembers a new bid for a robot, unless one for it stands.
    fn keep_bid(&mut self, bid: Option<Bid>, now: MonotonicNs) {
        let Some(bid) = bid.filter(|bid| self.standing_bid(bid.robot, now).is_none()) else { return };
        self.bids.retain(|known| known.robot != bid.robot);
        self.bids.push(bid);
    }

    /// The last bid for `robot`.
    fn bid_for(&self, robot: RobotId) -> Option<Bid> {
        self.bids.iter().find(|bid| bid.robot == robot).copied()
    }

    /// The bid for which the present decision of `robot`, or the one being executed, is still kept at `now`.
    fn standing_bid(&self, robot: RobotId, now: MonotonicNs) -> Option<Bid> {
        let bid = self.bid_for(robot)?;
        let grace_ns = BID_GRACE_NS.max(self.mission.brief.limits.decision_budget_ns.saturating_mul(2));
        let kept_since = bid.since.max(self.state.published);
        let open = bid.decision == self.state.decision && now.since_ns(kept_since) < grace_ns;
        (open || bid.decision > self.state.decision).then_some(bid)
    }

    /// Who leads once `command` is executed, if the command stands up to every check.
    fn admit(&self, command: &Command, now: MonotonicNs) -> Result<Leader, Refusal> {
        let leader = self.judge(command, now)?;
        self.refusal_of(command.action).map_or(Ok(leader), Err)
    }

    /// Why the robot that is due shall not execute `action`, whoever commands it, if there is a reason.
    pub(crate) fn refusal_of(&self, action: Action) -> Option<Refusal> {
        let refusal = self.robots.as_ref().and_then(|robots| robots.refusal(&self.mission.terrain, action));
        if refusal.is_some() || self.robots_not_hopping().is_some() {
            return refusal;
        }
        let (may_wait, need) = match self.mission.brief.mixed {
            Some(_) => (true, "a hop, wait or hold: the robot is a hopper"),
            None => (false, "a hop or hold: the robot is a hopper"),
        };
        let is_of_hopper = match action {
            Action::Hold | Action::Hop(_) => true,
            Action::Wait => may_wait,
            _ => false,
        };
        if !is_of_hopper {
            return Some(Refusal::malformed("command.action", need, action));
        }
        let need = self.mission.brief.guard.hazard_max;
        self.guard().veto(action).map(|got| Refusal::Vetoed { action, need, got })
    }

    /// Takes note of what an earlier life vetoed at the decision that is due.
    ///
    /// # Errors
    /// The first action that is not vetoed.
    pub(crate) fn recall_vetoes(&mut self, vetoed: Vetoed) -> Result<(), Action> {
        let is_vetoed = |action: &Action| {
            matches!(self.refusal_of(*action), Some(Refusal::Vetoed { .. } | Refusal::Occupied { .. }))
        };
        match Action::ALL.into_iter().filter(|action| vetoed.has(*action)).find(|action| !is_vetoed(action)) {
            Some(action) => Err(action),
            None => {
                self.state.vetoed = vetoed;
                Ok(())
            }
        }
    }

    /// The record that an admitted command leads to, outcome drawn.
    fn execute(&mut self, command: &Command, leader: Leader, now: MonotonicNs) -> Record {
        let state = &self.state;
        let timing = Timing {
            landed: state.landed,
            state_published: state.published,
            sensed: command.sensed,
            map_published: command.map_published,
            planning_started: command.planning_started,
            planning_ended: command.planning_ended,
            accepted: now,
            committed: now,
        };
        let mut record = self.record(leader, command.action, Origin::Planner, timing);
        (record.observation, record.work, record.cut) = (command.observation, command.work, command.cut);
        record
    }

    /// The record of `action`, its outcome drawn; nothing in it that only a planner knows.
    fn record(&mut self, leader: Leader, action: Action, origin: Origin, timing: Timing) -> Record {
        let state = &self.state;
        let (robot, execution) = match &mut self.robots {
            Some(robots) => robots.execute(&self.mission, state, leader, action),
            None => (ROBOT, execute(&self.mission, state, action)),
        };
        let Execution { outcome, pose, collected, steps, visits, status } = execution;
        let mut record = Record {
            robot,
            decision: state.decision,
            leader,
            action,
            origin,
            vetoed: state.vetoed,
            observation: 0,
            work: 0,
            cut: false,
            outcome,
            pose,
            collected,
            steps,
            visits,
            status,
            timing,
            previous: state.digest,
            digest: state.digest,
        };
        record.digest = record.previous.chain(&record);
        record
    }

    /// The robots, unless it is a hopper's turn.
    fn robots_not_hopping(&self) -> Option<&RobotTeam> {
        self.robots.as_ref().filter(|robots| !robots.is_turn_of_hopper())
    }

    /// Pose and goal of the hopper that is due, if it has a goal of its own.
    fn own_way(&self) -> Option<(Pose, contract::Cell)> {
        self.robots.as_ref()?.own_way(&self.mission.terrain)
    }

    /// The guard where the hopper stands.
    fn guard(&self) -> Guard<'_> {
        let pose = self.own_way().map_or(self.state.pose, |(pose, _)| pose);
        Guard::new(&self.mission.brief, &self.mission.terrain, self.due(), pose)
    }

    /// Whether the fallback may follow a policy: a policy leads to one goal, and hoppers of a mixed mission have one each.
    pub(crate) fn follows_policies(&self) -> bool {
        self.mission.brief.mixed.is_none() && self.robots_not_hopping().is_none()
    }

    /// What is done at the deadline.
    pub(crate) fn fallback(&self) -> Fallback {
        match self.robots_not_hopping() {
            Some(robots) => robots.fallback(&self.mission.terrain),
            None => {
                let refusal = |robots: &RobotTeam, action| robots.refusal(&self.mission.terrain, action);
                let may =
                    |action| self.robots.as_ref().is_none_or(|robots| refusal(robots, action).is_none());
                self.guard().fallback(self.goal(), self.policy(), may)
            }
        }
    }

    /// When the fallback acts, unless a command is accepted before; `None` if it does not.
    fn deadline(&self) -> Option<MonotonicNs> {
        let deadline_ns = self.mission.brief.guard.deadline_ns;
        let waits = matches!(self.phase, Phase::Resting) && !self.state.status.is_over();
        (deadline_ns > 0 && self.deadlines && waits && self.sent.is_some())
            .then(|| self.state.published.plus_ns(deadline_ns))
    }

    /// Acts in the planner's stead. Who commands goes on commanding: the term stays.
    fn fall_back(&mut self, Fallback { action, origin }: Fallback, now: MonotonicNs) -> Effect {
        let State { landed, published, .. } = self.state;
        let leader = self.leader(self.due());
        let timing =
            Timing { landed, state_published: published, accepted: now, committed: now, ..Timing::default() };
        let record = self.record(leader, action, origin, timing);
        self.commit(record)
    }

    fn keep(&mut self, policy: Policy) {
        let Brief { run, guard, grid, .. } = self.mission.brief;
        let fits = policy.run == run && policy.robot == ROBOT && policy.cells.len() == grid.cells();
        // A policy leads to one goal, and hoppers of a mixed mission have one each.
        let fits = fits && self.mission.brief.mixed.is_none();
        if guard.deadline_ns > 0 && fits && policy.decision <= self.state.decision.next() {
            self.policy = Some(policy);
        }
    }

    /// The goal in force.
    fn goal(&self) -> contract::Cell {
        self.own_way().map_or_else(|| self.mission.brief.goal_after(self.state.visits), |(_, goal)| goal)
    }

    /// The last policy of the algorithm in command. On a patrol one that leads to another goal is none.
    fn policy(&self) -> Option<&Policy> {
        let leads_here = |policy: &&Policy| policy.decision >= self.leg_began;
        let in_command = self.leader(ROBOT).planner;
        self.policy.as_ref().filter(|policy| policy.planner == in_command).filter(leads_here)
    }

    /// Who leads once `command` is executed; or why it is not.
    fn judge(&self, command: &Command, now: MonotonicNs) -> Result<Leader, Refusal> {
        let Command { run, robot, decision, incarnation, .. } = *command;
        let need = self.state.decision;
        if run != self.state.run {
            return Err(Refusal::WrongRun { need: self.state.run, got: run });
        }
        if robot.0 >= self.robots() {
            return Err(Refusal::WrongRobot { robots: self.robots(), got: robot.0.into() });
        }
        if decision < need {
            return Err(Refusal::RepeatedDecision { need, got: decision });
        }
        if decision > need {
            return Err(Refusal::FutureDecision { need, got: decision });
        }
        if command.digest != self.state.digest {
            let (need, got) = (self.state.digest, command.digest);
            return Err(Refusal::OtherPast { decision, need, got });
        }
        if self.state.status.is_over() {
            return Err(Refusal::MissionOver);
        }
        if robot != self.due() {
            return Err(Refusal::NotDue { need: self.due(), got: robot });
        }
        let leader = self.succession(command)?;
        if !matches!(self.phase, Phase::Resting) {
            return Err(Refusal::Busy { decision: need });
        }
        match self.standing_bid(robot, now) {
            Some(bid) if bid.incarnation != incarnation => Err(Refusal::Yielding { decision: need }),
            _ => Ok(leader),
        }
    }

    /// Who leads `robot`, counting a command that is being executed.
    fn leader(&self, robot: RobotId) -> Leader {
        if let Some(robots) = &self.robots {
            return robots.leader(robot);
        }
        match &self.phase {
            Phase::Resting => self.state.leader,
            Phase::Committing(record) | Phase::Unwritten(record) => record.leader,
            Phase::Flying(next) => next.leader,
        }
    }

    /// Compare-and-swap of the term: its holder goes on, or the next one begins, whoever asks first.
    /// A term counts as begun from the acceptance of its first command, before that is committed.
    fn succession(&self, command: &Command) -> Result<Leader, Refusal> {
        let held = self.leader(command.robot);
        let (need, got) = (held.term, command.term);
        let Command { incarnation, pid, planner, .. } = *command;
        if got == need.next() {
            Ok(Leader { term: got, incarnation, pid, planner })
        } else if got > need {
            Err(Refusal::FutureTerm { need, got })
        } else if got < need {
            Err(Refusal::StaleTerm { need, got })
        } else if held != Leader::default() && (incarnation, planner) == (held.incarnation, held.planner) {
            Ok(held)
        } else {
            Err(Refusal::NotLeader { term: need })
        }
    }

    fn commit(&mut self, record: Record) -> Effect {
        self.phase = Phase::Committing(record);
        Effect::Append(record)
    }

    /// Simulated time that the action just committed takes, seconds; in a team, until the next robot's turn.
    fn lasts_s(&self, outcome: &Outcome) -> f64 {
        match &self.robots {
            Some(robots) => robots.elapsed_s(),
            None => outcome.flight.flight_time_s * f64::from(outcome.flight.flights),
        }
    }

    /// The state that `record`, committed at `committed`, leads to when it lands.
    fn state_after(&self, record: &Record, committed: MonotonicNs) -> State {
        let lasts_s = self.lasts_s(&record.outcome);
        let launch = Launch { last_landed: self.state.landed, committed, lasts_s };
        let landed = self.throttle.landing(&launch);
        let mut next = record.state_after(self.state.run, landed, MonotonicNs(0));
        next.last_timing.committed = committed;
        next
    }

    /// Takes up the next state and publishes it, if its landing has come.
    fn land(&mut self, now: MonotonicNs, effects: &mut Vec<Effect>) {
        let Phase::Flying(next) = &self.phase else { return };
        if now < next.landed || self.throttle.holds() {
            return;
        }
        let decision = next.decision;
        if next.visits != self.state.visits {
            self.leg_began = decision;
        }
        self.state = *next;
        self.phase = Phase::Resting;
        self.throttle.landed();
        if let Some(robots) = &self.robots {
            self.team = Some(robots.team(&self.state));
            let due = self.due();
            for bid in self.bids.iter_mut().filter(|bid| bid.robot != due && bid.decision == decision) {
                // It is not that robot's turn: the one to come is kept.
                bid.decision = decision.next();
            }
        }
        self.sent = None;
        effects.push(self.publish(now));
    }

    /// Carries out an order: a hop in the air lands when the pace now in force has it, and a pause counts
    /// as flight, in no decision's time.
    fn obey(&mut self, control: &Control, now: MonotonicNs) -> Result<(), Refusal> {
        let Control { run, robot, order } = *control;
        if run != self.state.run {
            return Err(Refusal::WrongRun { need: self.state.run, got: run });
        }
        if robot != ROBOT {
            return Err(Refusal::WrongRobot { robots: 1, got: robot.0.into() });
        }
        self.throttle.obey(order, now)?;
        if let Phase::Flying(next) = &self.phase {
            let mut next = *next;
            let (last_landed, committed) = (self.state.landed, next.last_timing.committed);
            let lasts_s = next.last.map_or(0.0, |outcome| self.lasts_s(&outcome));
            next.landed = self.throttle.landing_anew(&Launch { last_landed, committed, lasts_s }, now);
            self.phase = Phase::Flying(next);
        }
        Ok(())
    }

    /// The mission begins, or is taken up again where an earlier life ended: its landing is now.
    fn take_up(&mut self, now: MonotonicNs) -> Effect {
        self.state.landed = now;
        self.publish(now)
    }

    /// Publishes the current state: stamped the first time, unchanged ever after.
    fn publish(&mut self, now: MonotonicNs) -> Effect {
        if self.sent.is_none() {
            self.state.published = now;
        }
        self.sent = Some(now);
        Effect::Publish(self.state)
    }

    /// The brief again, if peers that do not know of the run go on without it.
    fn announce(&mut self, beat: &Heartbeat, now: MonotonicNs) -> Option<Effect> {
        if beat.run == self.state.run || beat.role == Role::HopperSim {
            return None;
        }
        let since = *self.unknown_since.get_or_insert(now);
        let waited_ns = now.since_ns(since);
        if waited_ns > 2 * ANNOUNCE_NS {
            // Those of then know it by now, or are gone.
            self.unknown_since = Some(now);
            return None;
        }
        if waited_ns < ANNOUNCE_NS {
            return None;
        }
        self.unknown_since = None;
        Some(Effect::Announce)
    }

    /// Whether the final state is out and its peers are waited for.
    fn is_lingering(&self) -> bool {
        self.state.status.is_over() && self.sent.is_some() && !self.finished
    }

    /// Finishes once everyone who lives has seen the end and nobody is missing, or the linger is up.
    fn conclude(&mut self, now: MonotonicNs) -> Option<Effect> {
        if !self.is_lingering() {
            return None;
        }
        let (run, status) = (self.state.run, self.state.status);
        let is_peer = |role: &Role| *role != Role::HopperSim;
        let here = |role: Role| self.peer_table.has(role, now);
        let served_ns = now.since_ns(self.state.published);
        // Perception and a planner of each robot flew the mission; whoever else may come is given a moment.
        let planned = self.peer_table.without_planner(RobotSet::first(self.robots()), now).is_empty();
        let everyone_is_here =
            here(Role::Perception) && planned && (here(Role::Monitor) || served_ns >= LATE_COMER_NS);
        let everyone_knows = self
            .peer_table
            .live(now)
            .filter(|peer| is_peer(&peer.beat.role))
            .all(|peer| peer.beat.run == run && peer.beat.status == status);
        let waited_enough = served_ns >= self.linger_ns;
        self.finished = waited_enough || (everyone_is_here && everyone_knows);
        self.finished.then_some(Effect::Finished(status))
    }
}
