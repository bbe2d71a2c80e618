//! The state machine of a planner process: when to plan, for which term to speak, when to step back.
//!
//! A pilot answers a state only when state and map are of one run and one decision. It speaks for the
//! term in force if it leads, and for the next term if it may take over: nobody leads yet, it was told
//! to (once), its predecessor is known to be dead, or the leader's heartbeat stands still. hopper-sim
//! decides; a pilot that lost the race reads so from the next state. It may command several robots, each under a term of its
//! own: one robot is due at a time, and only for it there is something to plan.
//!
//! If hopper-sim's guard vetoes its command, the same state comes again with the veto, and the pilot plans
//! anew. A planner that insists on what is vetoed stands still.

use std::collections::BTreeSet;

use contract::protocol::peer_table::SILENCE_NS;
use contract::{
    Action, Brief, Command, Decision, Digest, Heartbeat, Incarnation, Leader, MapPage, MapPatch, MapRequest,
    Member, MonotonicNs, Name, PeerTable, Pose, PriorGathering, PriorPage, PriorRequest, Refusal, Replica,
    RobotId, RobotSet, RouteId, RoutePage, RouteRequest, Routes, RunId, State, Status, Team, Term, Timeline,
    Vetoed,
};

use crate::closed::ClosedMap;
use crate::others::{occupant, taken, wait_or_hold};
use crate::plan::Scouting;
use crate::{Plan, PlanStatus, Situation};

/// An unanswered command is sent again after this long.
pub const RESEND_NS: u64 = 10_000_000;

/// A leader whose process is gone needs to be silent only this long: a process of another container is
/// gone to us though it lives, but it beats.
pub const DEATH_SILENCE_NS: u64 = SILENCE_NS / 5;

/// Who this planner is, and what it may presume.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PilotConfig {
    /// The robots that it may command.
    pub robots: RobotSet,
    /// Tells this life of the process from earlier ones.
    pub incarnation: Incarnation,
    /// This process; 0 in lockstep.
    pub pid: u32,
    /// Algorithm, as heartbeats and records name it.
    pub planner: Name,
    /// Take the next term from a living leader, once.
    pub takeover: bool,
    /// A process known to be dead: its term may be taken at once.
    pub succeeds_pid: Option<u32>,
}

/// What a pilot hears.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant, reason = "an event is made, taken, and gone")]
pub enum Event {
    /// The brief; one of a new run drops all that was known.
    Brief(Brief),
    /// The state.
    State(State),
    /// All robots as of a state.
    Team(Team),
    /// What a landing changed in the observed map.
    Patch(MapPatch),
    /// A page of the observed map that was asked for; after all patches that were there when it came.
    Page(MapPage),
    /// A page of the prior that was asked for.
    Prior(PriorPage),
    /// A route that was asked for.
    Route(RoutePage),
    /// A message about the map was malformed.
    Refused(Refusal),
    /// A sign of life.
    Heartbeat(Heartbeat),
    /// The operating system knows of no process with this number.
    Gone(u32),
    /// This planner shall claim the next term of each robot that it serves and does not lead, once, as with `--takeover`.
    HandOver,
    /// The plan that was asked for, with the moments at which planning began and ended.
    Planned(Plan, MonotonicNs, MonotonicNs),
    /// Time passes.
    Tick,
}

/// What a pilot wants done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Ask for the observed map.
    RequestMap(MapRequest),
    /// Ask for the prior.
    RequestPrior(PriorRequest),
    /// Ask for the points of a route.
    RequestRoute(RouteRequest),
    /// Plan for [`Pilot::situation`], then report [`Event::Planned`]; unless the plan was reported meanwhile
    /// ([`Pilot::awaits_plan`]).
    Plan,
    /// Send the command.
    Send(Command),
    /// This planner now commands, under the given term.
    Leads(Term),
    /// Another planner commands now; this one no longer does.
    StepsBack(Term),
    /// Another planner commands, and this one waits for its end.
    StandsBy(Leader),
    /// The mission is over.
    Finished(Status),
}

/// What was planned last; the term is filled in when it is sent.
#[derive(Clone, Copy, Debug)]
struct Planned {
    command: Command,
    due: Due,
    sent: MonotonicNs,
}

/// What is planned for: a decision, on the timeline of a digest, and what the guard has vetoed there.
type Due = (RunId, Decision, Digest, Vetoed);

/// What the pilot knows of who leads one robot, and what it has asked for.
#[derive(Clone, Copy, Debug)]
struct RobotView {
    /// Who led it when it was last heard of, and in which run.
    leader: Option<(RunId, Leader)>,
    /// When `leader` was first heard to lead.
    leader_since: MonotonicNs,
    takeover: bool,
    leads: bool,
    /// The term last spoken for in this run.
    asked: Option<Term>,
}

/// The mission as a hopper has it that is not the only one: from its start to its goal, and where it stands. So to whoever plans
/// it is a mission like any other.
#[derive(Clone, Copy, Debug)]
struct OwnWay {
    brief: Brief,
    state: State,
}

/// What planners are given of state and robots: what follows from the past that the digest names.
#[derive(Clone, Debug, Default)]
struct Given {
    state: Option<State>,
    team: Option<Team>,
    /// The routes that robots of that team follow, as far as they are known. Which others are known depends on the life of this
    /// process.
    routes: Routes,
    /// Which these are.
    followed: BTreeSet<RouteId>,
}

/// Whose turn it is, and who leads that robot.
#[derive(Clone, Copy, Debug)]
struct Turn {
    robot: RobotId,
    leader: Leader,
}

/// Commands robots, or stands by.
#[derive(Debug)]
pub struct Pilot {
    config: PilotConfig,
    brief: Option<Brief>,
    /// The brief of the leg of the present state.
    leg: Option<Brief>,
    /// What the hopper that is due plans for, if it has a goal of its own.
    own: Option<OwnWay>,
    /// The map that it is given, if robots stand on it for good.
    closed: Option<ClosedMap>,
    state: Option<State>,
    /// The robots as last told of; those of the present state only if [`Team::is_of`] says so.
    team: Option<Team>,
    /// What planners are given of both: no more than a command names.
    given: Given,
    map: Replica,
    /// What is known beforehand of uncertain ground.
    prior: PriorGathering,
    /// The announced routes, as far as they are known.
    routes: Routes,
    peer_table: PeerTable,
    /// One for each robot, up to the last that it may command.
    views: Vec<RobotView>,
    /// A process that no longer exists.
    gone: Option<u32>,
    /// When time last passed: a pilot that was stopped itself has missed the leader's beats.
    ticked: MonotonicNs,
    /// The decision for which a plan was asked and has not been reported.
    planning: Option<Due>,
    planned: Option<Planned>,
    finished: bool,
}

impl Pilot {
    /// A pilot who knows nothing yet.
    #[must_use]
    pub fn new(config: PilotConfig) -> Self {
        let view = RobotView {
            leader: None,
            leader_since: MonotonicNs(0),
            takeover: config.takeover,
            leads: false,
            asked: None,
        };
        Self {
            config,
            brief: None,
            leg: None,
            own: None,
            closed: None,
            state: None,
            team: None,
            given: Given::default(),
            map: Replica::new(RobotId(0)),
            prior: PriorGathering::default(),
            routes: Routes::default(),
            peer_table: PeerTable::default(),
            views: vec![view; config.robots.iter().last().map_or(0, |last| usize::from(last.0) + 1)],
            gone: None,
            ticked: MonotonicNs(0),
            planning: None,
            planned: None,
            finished: false,
        }
    }

    /// Takes note of `event` at `now` and says what is to be done.
    pub fn on(&mut self, event: Event, now: MonotonicNs) -> Vec<Effect> {
        // Most events ask for nothing; these two for one effect as a rule.
        let mut effects = match event {
            Event::Patch(_) | Event::Planned(..) => Vec::with_capacity(1),
            _ => Vec::new(),
        };
        let routes_may_change = matches!(event, Event::Brief(_) | Event::Team(_) | Event::Route(_));
        let leg_may_change = match &event {
            Event::Brief(_) => true,
            Event::State(state) => {
                let known = self.state.as_ref();
                let is_patrol = self.brief.as_ref().is_some_and(|brief| brief.patrol.is_some());
                let is_same =
                    |known: &State| known.run == state.run && (known.visits == state.visits || !is_patrol);
                !known.is_some_and(is_same)
            }
            _ => false,
        };
        match event {
            Event::Brief(brief) => {
                self.brief(brief);
                // Who leads the robots of the state may have been told before it was known which robots there are.
                if self.state.as_ref().is_some_and(|state| state.run == brief.run) {
                    self.note_leaders(now, &mut effects);
                }
            }
            // By reference, here as elsewhere: a state is large, and copied once.
            Event::State(ref state) => self.state(state, now, &mut effects),
            Event::Team(team) => {
                self.given.team = Some(team.of_its_past());
                self.team = Some(team);
                self.note_leaders(now, &mut effects);
            }
            Event::Patch(patch) => effects.extend(self.map.patch(patch, now).map(Effect::RequestMap)),
            Event::Page(page) => effects.extend(self.map.page(&page, now).map(Effect::RequestMap)),
            Event::Prior(page) => {
                if let Err(refusal) = self.prior.page(page) {
                    self.map.refuse(&refusal);
                }
            }
            Event::Route(page) => {
                self.routes.page(page);
            }
            Event::Refused(refusal) => self.map.refuse(&refusal),
            Event::Heartbeat(beat) => self.peer_table.observe(beat, now),
            Event::Gone(pid) => self.gone = Some(pid),
            Event::HandOver => self.hand_over(),
            Event::Planned(plan, started, ended) => self.planned(&plan, started, ended, now, &mut effects),
            Event::Tick => self.tick(now, &mut effects),
        }
        if leg_may_change {
            let known = self.brief.as_ref().zip(self.state.as_ref());
            self.leg = known.map(|(brief, state)| brief.leg(state.visits));
        }
        if self.brief.as_ref().is_some_and(|brief| brief.mixed.is_some()) {
            self.own = self.own_way();
            self.close();
        }
        if routes_may_change && self.brief.as_ref().is_some_and(|brief| brief.scout.is_some()) {
            self.give_routes();
        }
        self.gather(now, &mut effects);
        self.plan(now, &mut effects);
        effects
    }

    /// What the hopper that is due plans for; `None` unless it has a goal of its own, and brief, state, robots and map agree.
    fn own_way(&self) -> Option<OwnWay> {
        let brief = self.brief.as_ref().filter(|brief| brief.mixed.is_some())?;
        let state = self.given.state.as_ref()?;
        let team = self.given.team.as_ref().filter(|team| team.is_of(state))?;
        let member = team.member(team.due)?;
        let goal = member.robot.vehicle.hop_goal()?;
        let map = self.map.map().filter(|map| map.is_of(state))?;
        let cell = member.at.cell;
        let pose = Pose { cell, height_m: map.ground(cell)?.height_m };
        let start = member.robot.start.cell;
        Some(OwnWay {
            brief: Brief { start, goal, ..brief.for_hopper(team.due) },
            state: State { pose, ..*state },
        })
    }

    /// Makes the cells impassable where other robots stand, for the hopper that is due if it is one of those commanded here.
    fn close(&mut self) {
        let team = self.own.and(self.team.as_ref()).filter(|team| self.config.robots.has(team.due));
        let (Some(team), Some(map)) = (team, self.map.map()) else { return };
        let mut closed: Vec<usize> = taken(team, &map.grid).filter_map(|cell| map.grid.index(cell)).collect();
        closed.sort_unstable();
        closed.dedup();
        let known = self.closed.take();
        self.closed = match known {
            _ if closed.is_empty() => None,
            Some(known) if known.is_of(map, &closed) => Some(known),
            known => Some(ClosedMap::of(known, map, closed)),
        };
    }

    /// Asks for what is missing of the prior and of the announced routes, where robots go from point to point.
    fn gather(&mut self, now: MonotonicNs, effects: &mut Vec<Effect>) {
        if !self.needs_scouting() {
            return;
        }
        effects.extend(self.prior.ask(now).map(Effect::RequestPrior));
        if let Some(id) = self.unknown_route() {
            self.routes.want(id);
        }
        effects.extend(self.routes.ask(now).map(Effect::RequestRoute));
    }

    /// Whether a robot that it may command goes from point to point over uncertain ground: then it needs to know the prior and
    /// the announced routes. Before the robots are known, as if one did.
    fn needs_scouting(&self) -> bool {
        let Some(brief) = self.brief.as_ref().filter(|brief| brief.scout.is_some()) else { return false };
        let team = self.team.as_ref().filter(|team| team.run == brief.run && brief.mixed.is_some());
        let travels = |member: &Member| member.robot.vehicle.start().is_some();
        team.is_none_or(|team| self.config.robots.iter().filter_map(|robot| team.member(robot)).any(travels))
    }

    /// A route that a robot follows and whose points are not known.
    fn unknown_route(&self) -> Option<RouteId> {
        let route = |member: &Member| member.travel.and_then(|travel| travel.route);
        let run = self.brief.as_ref()?.run;
        // Whoever stays for another run still holds the robots of the one before.
        let team = self.team.iter().filter(|team| team.run == run);
        let mut routes = team.flat_map(|team| team.members.iter().filter_map(route));
        routes.find(|id| self.routes.get(*id).is_none())
    }

    /// Gives planners the routes that robots follow, as far as they are known.
    fn give_routes(&mut self) {
        let members = self.given.team.iter().flat_map(|team| team.members.iter());
        let followed = members.filter_map(|member| member.travel?.route);
        let followed: BTreeSet<RouteId> = followed.filter(|id| self.routes.get(*id).is_some()).collect();
        if followed == self.given.followed {
            return;
        }
        let mut routes = Routes::default();
        followed.iter().filter_map(|id| self.routes.get(*id)).for_each(|route| routes.insert(route.clone()));
        (self.given.routes, self.given.followed) = (routes, followed);
    }

    /// The prior and the routes that robots follow; `None` while something is missing.
    fn scouting(&self) -> Option<Scouting<'_>> {
        if self.unknown_route().is_some() {
            return None;
        }
        Some(Scouting { prior: self.prior.prior()?, routes: &self.given.routes })
    }

    /// What there is to plan for; `None` unless brief, state and map agree and a decision is due.
    #[must_use]
    pub fn situation(&self) -> Option<Situation<'_>> {
        match (&self.leg, &self.given.state, self.map.map()) {
            (Some(brief), Some(state), Some(map))
                if brief.run == state.run && map.is_of(state) && !state.status.is_over() =>
            {
                let team = self.given.team.as_ref().filter(|team| team.is_of(state));
                let is_mine = match team {
                    Some(team) => self.config.robots.has(team.due),
                    None => !brief.has_team(),
                };
                let goes_to_points =
                    |team: &Team| team.member(team.due).is_some_and(|due| due.travel.is_some());
                let needs_scouting = self.needs_scouting() && team.is_none_or(goes_to_points);
                let scouting = if needs_scouting { Some(self.scouting()?) } else { None };
                let hops = |team: &Team| team.member(team.due).is_some_and(|due| due.robot.vehicle.hops());
                let (brief, state, map) = match (&self.own, brief.mixed.is_some() && team.is_some_and(hops)) {
                    (Some(own), true) => {
                        (&own.brief, &own.state, self.closed.as_ref().map_or(map, ClosedMap::map))
                    }
                    (None, true) => return None,
                    (_, false) => (brief, state, map),
                };
                is_mine.then_some(Situation { brief, map, state, team, scouting })
            }
            _ => None,
        }
    }

    /// Whether a plan was asked for that has not been reported, and still can be made. What is heard between
    /// two plans may ask for a plan twice: the second is that of the first.
    #[must_use]
    pub fn awaits_plan(&self) -> bool {
        self.planning.is_some()
    }

    /// The run, decision and status last seen, for the heartbeat.
    #[must_use]
    pub fn seen(&self) -> (RunId, Decision, Status) {
        match (&self.brief, &self.state) {
            (Some(brief), Some(state)) if brief.run == state.run => (state.run, state.decision, state.status),
            _ => (RunId::default(), Decision(0), Status::Underway),
        }
    }

    /// The process of the planner in command, if it is another one.
    #[must_use]
    pub fn rival_pid(&self) -> Option<u32> {
        let leader = self.turn()?.leader;
        (leader.term > Term(0) && leader.incarnation != self.config.incarnation).then_some(leader.pid)
    }

    /// The brief that was heard last.
    #[must_use]
    pub fn known_brief(&self) -> Option<&Brief> {
        self.brief.as_ref()
    }

    /// What this planner holds of the observed map, and how it came by it.
    #[must_use]
    pub fn map(&self) -> &Replica {
        &self.map
    }

    /// What is missing, if anything.
    #[must_use]
    pub fn waits_for(&self) -> Option<&'static str> {
        let (Some(brief), Some(state)) = (&self.brief, &self.state) else {
            return Some("hopper-sim: no brief or no state yet");
        };
        if brief.run != state.run {
            return Some("hopper-sim: brief and state of one run");
        }
        if self.turn().is_none() {
            return Some("hopper-sim: the robots of this decision");
        }
        if self.needs_scouting() && self.scouting().is_none() {
            return Some("hopper-sim: the prior, or the routes of this decision");
        }
        let behind = !self.map.map().is_some_and(|map| map.is_of(state));
        (behind && !state.status.is_over()).then_some("perception: no map of this decision yet")
    }

    fn hand_over(&mut self) {
        for robot in self.config.robots.iter() {
            let view = &mut self.views[usize::from(robot.0)];
            if !view.leads {
                (view.takeover, view.asked) = (true, None);
            }
        }
    }

    /// Whose turn it is by the present state. Where there is a single hopper, its own.
    fn turn(&self) -> Option<Turn> {
        let state = self.state.as_ref()?;
        if !self.brief.as_ref().is_some_and(Brief::has_team) {
            return Some(Turn { robot: state.robot, leader: state.leader });
        }
        let team = self.team.as_ref().filter(|team| team.is_of(state))?;
        Some(Turn { robot: team.due, leader: team.member(team.due)?.leader })
    }

    /// Whose turn it is, if that robot may be commanded.
    fn own_turn(&self) -> Option<Turn> {
        self.turn().filter(|turn| self.config.robots.has(turn.robot))
    }

    /// Who leads `robot` by the present state.
    fn leader_of(&self, robot: RobotId) -> Option<Leader> {
        let state = self.state.as_ref()?;
        if !self.brief.as_ref().is_some_and(Brief::has_team) {
            return (robot == state.robot).then_some(state.leader);
        }
        let team = self.team.as_ref().filter(|team| team.is_of(state))?;
        Some(team.member(robot)?.leader)
    }

    /// Takes note of who leads the robots that this pilot may command.
    fn note_leaders(&mut self, now: MonotonicNs, effects: &mut Vec<Effect>) {
        for robot in self.config.robots.iter() {
            if let Some(leader) = self.leader_of(robot) {
                self.note_leader(robot, leader, now, effects);
            }
        }
    }

    fn note_leader(&mut self, robot: RobotId, leader: Leader, now: MonotonicNs, effects: &mut Vec<Effect>) {
        let Some(&State { run, status, .. }) = self.state.as_ref() else { return };
        let view = &mut self.views[usize::from(robot.0)];
        let news = view.leader != Some((run, leader));
        if news {
            (view.leader, view.leader_since) = (Some((run, leader)), now);
        }
        let led = view.leads;
        view.leads = leader.incarnation == self.config.incarnation;
        if view.asked.is_some_and(|asked| asked < leader.term) {
            // That term has come and gone, and may have been ours: what fires once is not tried again.
            view.takeover = false;
        }
        let leads = view.leads;
        if leads && !led {
            view.takeover = false;
            effects.push(Effect::Leads(leader.term));
        }
        if led && !leads {
            effects.push(Effect::StepsBack(leader.term));
        } else if news && !status.is_over() && self.term_for(robot, leader, now).is_none() {
            effects.push(Effect::StandsBy(leader));
        }
    }

    fn brief(&mut self, brief: Brief) {
        if self.brief.is_none_or(|known| known.run != brief.run) {
            self.planned = None;
            self.finished = false;
            for view in &mut self.views {
                (view.leads, view.asked) = (false, None);
            }
        }
        self.brief = Some(brief);
        if brief.scout.is_some() {
            self.prior.begin(brief.run);
            self.routes.begin(brief.run);
        }
        self.map.begin(&brief);
    }

    fn state(&mut self, state: &State, now: MonotonicNs, effects: &mut Vec<Effect>) {
        let known = self.state.as_ref().filter(|known| known.run == state.run);
        let robots = self.brief.as_ref().map_or(1, |brief| brief.robots);
        if state.robot.0 >= robots || known.is_some_and(|known| state.is_older_than(known)) {
            return;
        }
        if known.is_some_and(|known| Timeline::through(known).is_contradicted_by(state)) {
            // The map may hold cells that were seen on hops which never were.
            self.map.begin_anew();
        }
        let same = known.filter(|known| (known.decision, known.digest) == (state.decision, state.digest));
        // A veto stands, though an older copy of the state or another life of hopper-sim may not tell of it.
        let vetoed = state.vetoed.union(same.map_or(Vetoed::NONE, |known| known.vetoed));
        let state = State { vetoed, ..*state };
        (self.state, self.given.state) = (Some(state), Some(state.of_its_past()));
        self.note_leaders(now, effects);
        if state.status.is_over()
            && !self.finished
            && self.brief.as_ref().is_some_and(|brief| brief.run == state.run)
        {
            self.finished = true;
            effects.push(Effect::Finished(state.status));
        }
    }

    /// The term this pilot may speak for at `now`; `None` while it stands by.
    fn term(&self, now: MonotonicNs) -> Option<Term> {
        let Turn { robot, leader } = self.own_turn()?;
        self.term_for(robot, leader, now)
    }

    /// The term under which to command `robot`, which it may command and `leader` leads; `None` if
    /// it shall not.
    fn term_for(&self, robot: RobotId, leader: Leader, now: MonotonicNs) -> Option<Term> {
        let view = self.views.get(usize::from(robot.0))?;
        if leader.incarnation == self.config.incarnation {
            return Some(leader.term);
        }
        let vacant = leader.term == Term(0);
        let bereft = self.config.succeeds_pid.is_some_and(|pid| pid == leader.pid);
        (vacant || view.takeover || bereft || self.leader_is_silent(leader, view, now))
            .then(|| leader.term.next())
    }

    fn leader_is_silent(&self, leader: Leader, view: &RobotView, now: MonotonicNs) -> bool {
        let heard = self.peer_table.peer(leader.incarnation).map_or(view.leader_since, |peer| peer.advanced);
        let limit_ns = if self.gone == Some(leader.pid) { DEATH_SILENCE_NS } else { SILENCE_NS };
        now.since_ns(heard.max(view.leader_since)) > limit_ns
    }

    /// Asks for a plan if one is due.
    fn plan(&mut self, now: MonotonicNs, effects: &mut Vec<Effect>) {
        let planned = self.planned.as_ref().zip(self.state.as_ref());
        if self.planning.is_none() && planned.is_some_and(|(planned, state)| is_for(&planned.due, state)) {
            return;
        }
        let Some(due) = self.situation().map(|situation| due(situation.state)) else {
            // Whoever was asked for a plan may have found nothing to plan for.
            self.planning = None;
            return;
        };
        let is_planned = self.planned.as_ref().is_some_and(|planned| planned.due == due);
        if is_planned || self.planning == Some(due) || self.term(now).is_none() {
            return;
        }
        self.planning = Some(due);
        effects.push(Effect::Plan);
    }

    fn planned(
        &mut self,
        plan: &Plan,
        started: MonotonicNs,
        ended: MonotonicNs,
        now: MonotonicNs,
        effects: &mut Vec<Effect>,
    ) {
        let asked = self.planning.take();
        let (Some(situation), Some(map)) = (self.situation(), self.map.map()) else { return };
        let due = due(situation.state);
        if asked != Some(due) {
            return;
        }
        let command = Command {
            run: situation.state.run,
            robot: situation.team.map_or(RobotId(0), |team| team.due),
            decision: situation.state.decision,
            digest: situation.state.digest,
            term: Term(0),
            action: self.among_others(&situation, plan.action),
            // Of the map as it is, whatever the planner was given.
            observation: map.observation(),
            planner: self.config.planner,
            incarnation: self.config.incarnation,
            pid: self.config.pid,
            work: plan.work,
            cut: plan.status == PlanStatus::Cut,
            sensed: situation.map.sensed,
            map_published: situation.map.published,
            planning_started: started,
            planning_ended: ended,
        };
        self.planned = Some(Planned { command, due, sent: now });
        self.send(now, effects);
    }

    /// What is commanded of what was planned: nothing that is vetoed, or not for a robot of that kind. The planner of a hopper
    /// with a goal of its own knows of no other robots. So where it holds, or would have the hopper hop onto its goal while
    /// another robot is there, the hopper waits for the others.
    fn among_others(&self, situation: &Situation<'_>, planned: Action) -> Action {
        let may = fits(situation, planned) && !situation.state.vetoed.has(planned);
        let action = if may { planned } else { Action::Hold };
        let (Some(team), true) = (situation.team, self.own.is_some()) else { return action };
        let Situation { brief, state, .. } = *situation;
        let is_in_vain = match action {
            Action::Hop(direction) => {
                let aim = brief.grid.hop(state.pose.cell, direction);
                aim == brief.goal && occupant(team, &brief.grid, aim).is_some()
            }
            _ => action == Action::Hold,
        };
        if is_in_vain { wait_or_hold(team) } else { action }
    }

    /// Sends what was planned, under the term that may be spoken for.
    fn send(&mut self, now: MonotonicNs, effects: &mut Vec<Effect>) {
        let Some(Turn { robot, leader }) = self.own_turn() else { return };
        let Some(term) = self.term_for(robot, leader, now) else { return };
        self.views[usize::from(robot.0)].asked = Some(term);
        let Some(planned) = &mut self.planned else { return };
        planned.sent = now;
        effects.push(Effect::Send(Command { term, ..planned.command }));
    }

    fn tick(&mut self, now: MonotonicNs, effects: &mut Vec<Effect>) {
        if now.since_ns(self.ticked) > SILENCE_NS / 2 {
            self.views.iter_mut().for_each(|view| view.leader_since = now);
        }
        self.ticked = now;
        effects.extend(self.map.ask(now).map(Effect::RequestMap));
        self.resend(now, effects);
    }

    fn resend(&mut self, now: MonotonicNs, effects: &mut Vec<Effect>) {
        let Some(planned) = self.planned.as_ref().filter(|planned| now.since_ns(planned.sent) >= RESEND_NS)
        else {
            return;
        };
        if self.situation().is_some_and(|situation| is_for(&planned.due, situation.state)) {
            self.send(now, effects);
        }
    }
}

/// Whether the robot that is due could ever do that: a planner may be told to command a robot of another kind.
fn fits(situation: &Situation<'_>, action: Action) -> bool {
    let Some(due) = situation.team.and_then(|team| team.member(team.due)) else { return true };
    let hops = due.robot.vehicle.hops();
    action == Action::Hold || hops == matches!(action, Action::Hop(_))
}

fn due(state: &State) -> Due {
    (state.run, state.decision, state.digest, state.vetoed)
}

/// Whether it is `state` that `due` tells of. Asked at every event: nothing is copied.
fn is_for((run, decision, digest, vetoed): &Due, state: &State) -> bool {
    (run, decision, digest, vetoed) == (&state.run, &state.decision, &state.digest, &state.vetoed)
}
