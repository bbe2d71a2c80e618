//! What a pilot knows of the mission, and what a planner is given of it.

use contract::{
    Account, Brief, Decision, Leader, Leg, MapPage, MapPatch, MapRequest, Member, MonotonicNs, Pose,
    PriorPage, Refusal, RobotId, RobotSet, RouteId, RoutePage, RunId, State, Status, TablePage, Team,
};
use follow::{Heard, Mission, PriorFollower, Replica, RouteFollower, TableFollower};

use super::effect::Effect;
use super::given::Given;
use crate::Situation;
use crate::closed::ClosedMap;
use crate::others::taken;
use crate::plan::{Scouting, leg_at};

/// Whose turn it is, and who leads that robot.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turn {
    pub robot: RobotId,
    pub leader: Leader,
}

/// Brief, state, robots, map, prior and routes, as far as they are known.
#[derive(Debug)]
pub(super) struct Knowledge {
    /// The robots that are planned for.
    robots: RobotSet,
    mission: Mission,
    /// The leg of the robot that is due, if it hops.
    leg: Option<Leg>,
    /// The state for a hopper among other robots: its pose is that of the hopper that is due, whoever acted.
    own_state: Option<State>,
    /// The map that it is given, if robots stand on it for good.
    closed: Option<ClosedMap>,
    /// What planners are given of state and robots: no more than a command names.
    given: Given,
    map: Replica,
    /// What is known beforehand of uncertain ground.
    prior: PriorFollower,
    /// Where hops end, as planners are to believe it.
    table: TableFollower,
    routes: RouteFollower,
}

impl Knowledge {
    /// Nothing is known yet.
    pub fn new(robots: RobotSet) -> Self {
        Self {
            robots,
            mission: Mission::default(),
            leg: None,
            own_state: None,
            closed: None,
            given: Given::default(),
            map: Replica::new(RobotId(0)),
            prior: PriorFollower::default(),
            table: TableFollower::default(),
            routes: RouteFollower::default(),
        }
    }

    /// Takes the brief; whether it is of another run than the one before.
    pub fn brief(&mut self, brief: Brief) -> bool {
        let before = self.mission.hear_brief(brief.clone());
        self.prior.begin(&brief);
        self.table.begin(&brief);
        if brief.sampling.is_some() {
            self.routes.begin(brief.run);
        }
        self.map.begin(&brief);
        self.begin_leg();
        self.give_routes();
        before.is_none_or(|known| known.run != brief.run)
    }

    /// Takes the state; whether it is news.
    pub fn state(&mut self, state: &State) -> bool {
        let visits_in_turn = self.mission.brief().is_some_and(|brief| brief.visits().is_some());
        let is_same_leg =
            |known: &State| known.run == state.run && (known.visits == state.visits || !visits_in_turn);
        let leg_may_change = !self.mission.state().is_some_and(is_same_leg);
        match self.mission.hear_state(state) {
            Heard::Nothing => return false,
            Heard::News => {}
            // The map may hold cells that were seen on hops which never were.
            Heard::AnotherPast => self.map.begin_anew(),
        }
        self.given.state = self.mission.state().map(State::of_its_past);
        if leg_may_change {
            self.begin_leg();
        }
        true
    }

    /// Takes the robots as of a state.
    pub fn team(&mut self, team: Team) {
        self.given.team = Some(team.of_its_past());
        self.mission.hear_team(team);
        self.begin_leg();
        self.give_routes();
    }

    /// Takes what a landing changed; what is to be asked for.
    pub fn patch(&mut self, patch: MapPatch, now: MonotonicNs) -> Option<MapRequest> {
        self.map.patch(patch, now)
    }

    /// Takes a page of the map; what is to be asked for next.
    pub fn page(&mut self, page: &MapPage, now: MonotonicNs) -> Option<MapRequest> {
        self.map.page(page, now)
    }

    /// Takes a page of the prior.
    pub fn prior(&mut self, page: PriorPage) {
        if let Err(refusal) = self.prior.page(page) {
            self.map.refuse(&refusal);
        }
    }

    /// Takes a page of the motion table.
    pub fn table(&mut self, page: TablePage) {
        if let Err(refusal) = self.table.page(page) {
            self.map.refuse(&refusal);
        }
    }

    /// Takes a route that was asked for.
    pub fn route(&mut self, page: RoutePage) {
        self.routes.page(page);
        self.give_routes();
    }

    /// Counts a message that was malformed.
    pub fn refuse(&mut self, refusal: &Refusal) {
        self.map.refuse(refusal);
    }

    /// What is to be asked for of the map at `now`.
    pub fn ask_for_map(&mut self, now: MonotonicNs) -> Option<MapRequest> {
        self.map.ask(now)
    }

    /// Brings up to date what follows from several messages: leg, state and map of a hopper among other robots.
    pub fn refresh(&mut self) {
        if self.mission.brief().is_some_and(|brief| brief.account != Account::Hopper) {
            self.begin_leg();
            self.own_state = self.own_state();
            self.close();
        }
    }

    /// Asks for what is missing of the motion table, and where robots go from point to point of the prior and of the announced routes.
    pub fn gather(&mut self, now: MonotonicNs, effects: &mut Vec<Effect>) {
        effects.extend(self.table.ask(now).map(Effect::RequestTable));
        if !self.needs_scouting() {
            return;
        }
        effects.extend(self.prior.ask(now).map(Effect::RequestPrior));
        if let Some(id) = self.unknown_route() {
            self.routes.need(id);
        }
        effects.extend(self.routes.ask(now).map(Effect::RequestRoute));
    }

    /// What there is to plan for; `None` unless brief, state and map agree and a decision is due.
    pub fn situation(&self) -> Option<Situation<'_>> {
        let (brief, state, map) = (self.mission.brief()?, self.given.state.as_ref()?, self.map.map()?);
        if brief.run != state.run || !map.is_of(state) || state.status.is_over() {
            return None;
        }
        let team = self.given.team.as_ref().filter(|team| team.is_of(state));
        let is_mine = match team {
            Some(team) => self.robots.has(team.due),
            None => !brief.has_team(),
        };
        if !is_mine {
            return None;
        }
        let goes_to_points = |team: &Team| team.member(team.due).is_some_and(|due| due.travel.is_some());
        let needs_scouting = self.needs_scouting() && team.is_none_or(goes_to_points);
        let scouting = if needs_scouting { Some(self.scouting()?) } else { None };
        let due = brief.robots.at(team.map_or(RobotId(0), |team| team.due))?;
        if !due.body.hops() {
            return Some(Situation { brief, leg: None, map, state, team, scouting, table: None });
        }
        if self.table.is_missing() {
            return None;
        }
        let (leg, table) = (Some(self.leg.as_ref()?), self.table.table());
        Some(match brief.account {
            Account::Hopper => Situation { brief, leg, map, state, team, scouting, table },
            Account::Actions | Account::ActionsWithoutWaits => {
                let map = self.closed.as_ref().map_or(map, ClosedMap::map);
                Situation { brief, leg, map, state: self.own_state.as_ref()?, team, scouting, table }
            }
        })
    }

    /// The newest state.
    pub fn known_state(&self) -> Option<&State> {
        self.mission.state()
    }

    /// The newest state, if it is of the brief's run.
    pub fn state_of_run(&self) -> Option<&State> {
        self.mission.state_of_run()
    }

    /// The newest brief.
    pub fn known_brief(&self) -> Option<&Brief> {
        self.mission.brief()
    }

    /// The observed map as it is known.
    pub fn map(&self) -> &Replica {
        &self.map
    }

    /// The run, decision and status last seen.
    pub fn seen(&self) -> (RunId, Decision, Status) {
        match self.mission.state_of_run() {
            Some(state) => (state.run, state.decision, state.status),
            None => (RunId::default(), Decision(0), Status::Underway),
        }
    }

    /// What is missing, if anything.
    pub fn waits_for(&self) -> Option<&'static str> {
        let (Some(brief), Some(state)) = (self.mission.brief(), self.mission.state()) else {
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
        if self.table.is_missing() {
            return Some("hopper-sim: the motion table");
        }
        let behind = !self.map.map().is_some_and(|map| map.is_of(state));
        (behind && !state.status.is_over()).then_some("perception: no map of this decision yet")
    }

    /// Whose turn it is by the present state. Where there is a single hopper, its own.
    pub fn turn(&self) -> Option<Turn> {
        let state = self.mission.state()?;
        if !self.mission.brief().is_some_and(Brief::has_team) {
            return Some(Turn { robot: state.robot, leader: state.leader });
        }
        let team = self.mission.team_of_state()?;
        Some(Turn { robot: team.due, leader: team.member(team.due)?.leader })
    }

    /// Who leads `robot` by the present state.
    pub fn leader_of(&self, robot: RobotId) -> Option<Leader> {
        let state = self.mission.state()?;
        if !self.mission.brief().is_some_and(Brief::has_team) {
            return (robot == state.robot).then_some(state.leader);
        }
        Some(self.mission.team_of_state()?.member(robot)?.leader)
    }

    fn begin_leg(&mut self) {
        let known = self.mission.brief().zip(self.mission.state());
        self.leg = known.and_then(|(brief, state)| {
            let due = if brief.has_team() { self.mission.team()?.due } else { RobotId(0) };
            leg_at(brief, self.map.map(), state, due)
        });
    }

    fn give_routes(&mut self) {
        if self.mission.brief().is_some_and(|brief| brief.sampling.is_some()) {
            self.given.give_routes(self.routes.known());
        }
    }

    /// The state as the hopper that is due has it; `None` unless one is due, and state, robots and map agree.
    fn own_state(&self) -> Option<State> {
        let (state, team, map) = (self.given.state.as_ref()?, self.given.team.as_ref()?, self.map.map()?);
        if self.leg.is_none() || !team.is_of(state) || !map.is_of(state) {
            return None;
        }
        let cell = team.member(team.due)?.at.cell;
        let pose = Pose { cell, height_m: map.ground(cell)?.height_m };
        Some(State { pose, ..*state })
    }

    /// Makes the cells impassable where other robots stand, for the hopper that is due if it is one of those commanded here.
    fn close(&mut self) {
        let (Some(_), Some(brief), Some(team), Some(map)) =
            (&self.own_state, self.mission.brief(), self.mission.team(), self.map.map())
        else {
            return;
        };
        if !self.robots.has(team.due) {
            return;
        }
        let mut closed: Vec<usize> = taken(brief, team).filter_map(|cell| map.grid.index(cell)).collect();
        closed.sort_unstable();
        closed.dedup();
        let known = self.closed.take();
        self.closed = match known {
            _ if closed.is_empty() => None,
            Some(known) if known.is_of(map, &closed) => Some(known),
            known => Some(ClosedMap::of(known, map, closed)),
        };
    }

    /// Whether a robot that is planned for goes from point to point over uncertain ground: then it needs to know the prior and
    /// the announced routes.
    fn needs_scouting(&self) -> bool {
        let Some(brief) = self.mission.brief().filter(|brief| brief.sampling.is_some()) else { return false };
        let mut own = self.robots.iter().filter_map(|robot| brief.robots.at(robot));
        own.any(|robot| robot.body.along_route().is_some())
    }

    /// A route that a robot follows and whose points are not known.
    fn unknown_route(&self) -> Option<RouteId> {
        let route = |member: &Member| member.travel.and_then(|travel| travel.route);
        let run = self.mission.run()?;
        // Whoever stays for another run still holds the robots of the one before.
        let team = self.mission.team().filter(|team| team.run == run)?;
        let mut routes = team.members.iter().filter_map(route);
        routes.find(|id| self.routes.known().get(*id).is_none())
    }

    /// The prior and the routes that robots follow; `None` while something is missing.
    fn scouting(&self) -> Option<Scouting<'_>> {
        if self.unknown_route().is_some() {
            return None;
        }
        Some(Scouting { prior: self.prior.prior()?, routes: &self.given.routes })
    }
}
