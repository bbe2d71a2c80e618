//! The planner process: ports around the [`Pilot`] and its [`Planner`].

use std::cell::RefCell;
use std::collections::VecDeque;

use contract::{
    Account, Action, Announcement, Brief, Command, Control, Decision, MapPatch, MapRequest, Order, Policy,
    PriorRequest, Refusal, Robot, RobotId, RobotSet, Role, RouteRequest, RunId, State, TableRequest, Team,
};
use process::{
    Client, Failure, Membership, Ports, Process, Reader, Terms, Turn, Writer, accept, log_refusal,
};

use crate::algorithm;
use crate::built_in::suited;
use crate::pilot::{Effect, Event, Pilot, PilotConfig};
use crate::{Budget, Planner, Pulse};

/// Points at which a test may kill this process: see [`Ports::pass`].
pub const CRASH_POINTS: &[&str] =
    &["planner.joined", "planner.map_received", "planner.planned", "planner.sent"];

/// Which robots a planner commands, and how it takes command.
#[derive(Clone, Copy, Debug, Default)]
pub struct Claim {
    /// Robots that this process plans for.
    pub robots: RobotSet,
    /// Take the next term from a living leader, once.
    pub takeover: bool,
    /// A process known to be dead: its term may be taken at once.
    pub succeeds_pid: Option<u32>,
}

/// The ports of a planner of routes.
struct RoutePorts<P: Ports> {
    priors: P::Client<PriorRequest>,
    routes: P::Client<RouteRequest>,
    /// For each robot that it may command.
    announcements: Vec<(RobotId, P::Writer<Announcement>)>,
}

impl<P: Ports> RoutePorts<P> {
    fn open(ports: &mut P, robots: RobotSet) -> Result<Self, P::Error> {
        let announcement = |robot| Ok((robot, ports.writer(robot)?));
        let announcements = robots.iter().map(announcement).collect::<Result<_, _>>()?;
        Ok(Self { announcements, priors: ports.client(RobotId(0))?, routes: ports.client(RobotId(0))? })
    }
}

/// Commands robots, or stands by.
pub struct PlannerProcess<P: Ports> {
    membership: Membership<P>,
    /// The robots that it may command.
    robots: RobotSet,
    pilot: Pilot,
    planner: Box<dyn Planner>,
    briefs: P::Reader<Brief>,
    states: P::Reader<State>,
    teams: P::Reader<Team>,
    maps: P::Reader<MapPatch>,
    snapshots: P::Client<MapRequest>,
    controls: P::Reader<Control>,
    /// For each robot that it may command.
    commands: Vec<(RobotId, P::Writer<Command>)>,
    /// Only of a planner of routes.
    routes: Option<RoutePorts<P>>,
    /// From the first request on: few missions have a motion table.
    tables: Option<P::Client<TableRequest>>,
    policies: P::Writer<Policy>,
    policy_sent: PolicySent,
    /// Of the last plan: see [`crate::Plan::error_bound`].
    error_bound: f64,
    /// Malformed messages about the map that the log has mentioned.
    refusals_logged: u64,
    /// The run that was heard of last, if it is none for this planner, and why.
    unfit: Option<(RunId, String)>,
}

impl<P: Ports> PlannerProcess<P> {
    /// Joins the instance with an algorithm.
    ///
    /// # Errors
    /// If a port cannot be had.
    pub async fn join(
        ports: &mut P,
        planner: Box<dyn Planner>,
        claim: Claim,
        terms: Terms,
    ) -> Result<Self, P::Error> {
        // What is not a robot's own goes by the name of the first.
        let robot = RobotId(0);
        let announces = planner.announces();
        let command = |robot| Ok((robot, ports.writer(robot)?));
        let commands = claim.robots.iter().map(command).collect::<Result<_, _>>()?;
        let mut membership = Membership::join(ports, Role::Planner, planner.name(), terms)?;
        membership.tell_robots(claim.robots);
        let process = Self {
            membership,
            robots: claim.robots,
            pilot: Pilot::new(PilotConfig {
                robots: claim.robots,
                incarnation: ports.incarnation(),
                pid: ports.pid(),
                planner: planner.name(),
                takeover: claim.takeover,
                succeeds_pid: claim.succeeds_pid,
            }),
            planner,
            maps: ports.reader(robot, true)?,
            briefs: ports.reader(robot, false)?,
            states: ports.reader(robot, false)?,
            teams: ports.reader(robot, false)?,
            snapshots: ports.client(robot)?,
            controls: ports.reader(robot, false)?,
            routes: announces.then(|| RoutePorts::open(ports, claim.robots)).transpose()?,
            commands,
            tables: None,
            policies: ports.writer(robot)?,
            policy_sent: PolicySent::default(),
            error_bound: 0.0,
            refusals_logged: 0,
            unfit: None,
        };
        ports.pass("planner.joined").await;
        Ok(process)
    }

    /// Why the algorithm does not suit the mission that was heard of last, if it does not.
    #[must_use]
    pub fn unfit(&self) -> Option<&str> {
        self.unfit.as_ref().map(|(_, why)| why.as_str())
    }

    /// The algorithm that plans for the robots.
    pub fn planner(&mut self) -> &mut dyn Planner {
        self.planner.as_mut()
    }

    /// Everything that came since, in the order in which the pilot needs it.
    async fn receive(&mut self, ports: &mut P) -> VecDeque<Effect> {
        let mut effects = VecDeque::new();
        for _ in 0..self.membership.depth() {
            let Some(beat) = self.membership.hear(ports.now()) else { break };
            if let Ok(beat) = beat {
                append(&mut effects, self.pilot.on(Event::Heartbeat(beat), ports.now()));
            }
        }
        if let Some(brief) = accept(self.briefs.newest()).filter(|brief| self.can_plan_for(brief)) {
            append(&mut effects, self.pilot.on(Event::Brief(brief), ports.now()));
        }
        if let Some(state) = accept(self.states.newest()) {
            append(&mut effects, self.pilot.on(Event::State(state), ports.now()));
        }
        // After the state, so that it is no older.
        if let Some(team) = accept(self.teams.newest()).filter(|team| self.plans_for(team.run)) {
            append(&mut effects, self.pilot.on(Event::Team(team), ports.now()));
        }
        self.receive_map(&mut effects, ports).await;
        if let Some(page) = self.tables.as_mut().and_then(|tables| accept(tables.receive())) {
            append(&mut effects, self.pilot.on(Event::Table(page), ports.now()));
        }
        self.receive_routes(&mut effects, ports);
        self.receive_orders(&mut effects, ports);
        if let Some(gone) = self.pilot.rival_pid().filter(|&pid| !ports.process_exists(pid)) {
            append(&mut effects, self.pilot.on(Event::Gone(gone), ports.now()));
        }
        append(&mut effects, self.pilot.on(Event::Tick, ports.now()));
        effects
    }

    /// The page is received first and folded last: with it come all patches published before it was made.
    async fn receive_map(&mut self, effects: &mut VecDeque<Effect>, ports: &mut P) {
        let page = self.snapshots.receive();
        for _ in 0..self.maps.depth() {
            let Some(patch) = self.maps.receive() else { break };
            ports.pass("planner.map_received").await;
            append(effects, self.pilot.on(event(patch, Event::Patch), ports.now()));
        }
        if let Some(page) = page {
            ports.pass("planner.map_received").await;
            append(effects, self.pilot.on(event(page, Event::Page), ports.now()));
        }
    }

    /// Pages of the prior, and announced routes.
    fn receive_routes(&mut self, effects: &mut VecDeque<Effect>, ports: &mut P) {
        let Some(RoutePorts { priors, routes, .. }) = &mut self.routes else { return };
        if let Some(page) = accept(priors.receive()) {
            append(effects, self.pilot.on(Event::Prior(page), ports.now()));
        }
        if let Some(page) = accept(routes.receive()) {
            append(effects, self.pilot.on(Event::Route(page), ports.now()));
        }
    }

    fn receive_orders(&mut self, effects: &mut VecDeque<Effect>, ports: &mut P) {
        for _ in 0..self.controls.depth() {
            let Some(control) = self.controls.receive() else { break };
            let Some(control) = accept(Some(control)) else { continue };
            let addressed = control.run == self.pilot.seen().0;
            if addressed && control.order == Order::HandOver(ports.incarnation()) {
                append(effects, self.pilot.on(Event::HandOver, ports.now()));
            }
        }
    }

    async fn carry_out(&mut self, effect: &Effect, ports: &mut P) -> Result<Vec<Effect>, P::Error> {
        match *effect {
            Effect::RequestMap(request) => self.snapshots.request(request)?,
            Effect::RequestPrior(request) => {
                if let Some(routes) = &mut self.routes {
                    routes.priors.request(request)?;
                }
            }
            Effect::RequestTable(request) => {
                let tables = match &mut self.tables {
                    Some(tables) => tables,
                    none => none.insert(ports.client(RobotId(0))?),
                };
                tables.request(request)?;
            }
            Effect::RequestRoute(request) => {
                if let Some(routes) = &mut self.routes {
                    routes.routes.request(request)?;
                }
            }
            Effect::Plan => return Ok(self.plan(ports).await),
            Effect::Send(ref command) => {
                let (run, decision) = (command.run, command.decision);
                // hopper-sim obeys nobody whom it has not heard.
                self.membership.beat(self.pilot.seen(), ports.now())?;
                self.announce(command)?;
                if let Some((_, commands)) =
                    self.commands.iter_mut().find(|(robot, _)| *robot == command.robot)
                {
                    commands.publish(*command)?;
                }
                ports.pass("planner.sent").await;
                self.publish_policy(run, decision);
            }
            Effect::Leads(term) => tracing::info!("in command, term {term}"),
            Effect::StepsBack(term) => {
                tracing::info!("another planner commands, term {term}: standing by");
            }
            Effect::StandsBy(leader) => tracing::info!(
                "standing by: {} (process {}) commands, term {}",
                leader.planner,
                leader.pid,
                leader.term
            ),
            Effect::Finished(status) => self.membership.mission_ended(status, ports.now()),
        }
        Ok(Vec::new())
    }

    /// Plans between two readings of the clock, beating as the work goes on. Does nothing if there is nothing to
    /// plan any more.
    async fn plan(&mut self, ports: &mut P) -> Vec<Effect> {
        let seen = self.pilot.seen();
        if !self.pilot.awaits_plan() {
            return Vec::new();
        }
        let Some(situation) = self.pilot.situation() else { return Vec::new() };
        let started = ports.now();
        let plan = {
            let host = RefCell::new((&mut self.membership, &mut *ports));
            let beat = || {
                let (membership, ports) = &mut *host.borrow_mut();
                let now = ports.now();
                if let Err(error) = membership.beat(seen, now) {
                    tracing::debug!("beating while planning: {error}");
                }
            };
            self.planner.plan(&situation, &Budget { pulse: Pulse::new(&beat), ..Budget::default() })
        };
        ports.computed().await;
        let ended = ports.now();
        ports.pass("planner.planned").await;
        self.error_bound = plan.error_bound;
        self.pilot.on(Event::Planned(plan, started, ended), ended)
    }

    /// Sends the points of a route before the command that announces it.
    fn announce(&mut self, command: &Command) -> Result<(), P::Error> {
        let (Action::Announce(id), Some(ports)) = (command.action, &mut self.routes) else { return Ok(()) };
        let Some(route) = self.planner.announced().filter(|route| route.id() == id) else { return Ok(()) };
        let (run, robot) = (command.run, command.robot);
        match ports.announcements.iter_mut().find(|(known, _)| *known == robot) {
            Some((_, announcements)) => {
                announcements.publish(Announcement { run, robot, route: route.clone() })
            }
            None => Ok(()),
        }
    }

    /// For display and for hopper-sim's fallback, and after the command: it may take long, and its failure must not
    /// end the mission.
    fn publish_policy(&mut self, run: RunId, decision: Decision) {
        if !self.policy_sent.is_due(run, decision, self.policies.readers()) {
            return;
        }
        let Some(situation) = self.pilot.situation() else { return };
        if situation.brief.account != Account::Hopper {
            return;
        }
        // Only a hopper's mission has policies, and its hopper is robot 0.
        let (run, robot, decision) = (situation.state.run, RobotId(0), situation.state.decision);
        let Some(cells) = self.planner.policy() else { return };
        let (planner, error_bound) = (self.planner.name(), self.error_bound);
        let policy = Policy { run, robot, decision, planner, error_bound, cells };
        if let Err(error) = self.policies.publish(policy) {
            tracing::warn!("the policy of decision {decision} is not published: {error}");
        }
    }

    /// Whether the mission has all robots that are to be commanded, and the algorithm can plan for them.
    /// Otherwise the log says so once, and the brief is ignored: a wrong brief does not stop the planner.
    fn can_plan_for(&mut self, brief: &Brief) -> bool {
        if let Some(error) = self.mismatch(brief) {
            self.refuse(brief.run, error);
            return false;
        }
        // The brief comes again when some other peer has missed it.
        self.unfit = None;
        true
    }

    /// Why nothing can be planned for that mission, if there is a reason.
    fn mismatch(&self, brief: &Brief) -> Option<String> {
        let (scenario, count, got) = (brief.scenario, brief.robots.count(), self.planner.name());
        if let Some(missing) = self.robots.iter().find(|robot| robot.0 >= count) {
            return Some(format!("scenario {scenario} has robots 0 to {}, got robot {missing}", count - 1));
        }
        let (whose, need) = if brief.robots.iter().any(|robot| self.suits(brief, robot)) {
            let mut own = self.robots.iter().filter_map(|number| Some((number, brief.robots.at(number)?)));
            let (number, robot) = own.find(|(_, robot)| !self.suits(brief, robot))?;
            (format!("robot {number} of "), suited(brief, robot))
        } else {
            let mut need: Vec<&str> = Vec::new();
            for name in brief.robots.iter().flat_map(|robot| suited(brief, robot)) {
                if !need.contains(&name) {
                    need.push(name);
                }
            }
            (String::new(), need)
        };
        Some(format!("{whose}scenario {scenario} needs one of the planners {}, got {got}", need.join(", ")))
    }

    /// Whether the algorithm can plan for a robot of that mission.
    fn suits(&self, brief: &Brief, robot: &Robot) -> bool {
        let name = self.planner.name();
        if algorithm(name.as_str()).is_ok() {
            return suited(brief, robot).contains(&name.as_str());
        }
        // A robot that goes from point to point moves along announced routes only.
        let can_move = self.planner.announces() || robot.body.along_route().is_none();
        self.planner.suits(robot) && can_move
    }

    /// Whether that run is the mission that is planned for. Robots of a mission that is not known are published again with each
    /// state.
    fn plans_for(&self, run: RunId) -> bool {
        self.pilot.known_brief().is_some_and(|brief| brief.run == run)
    }

    /// Notes why nothing can be planned, and logs it unless that was the last reason.
    fn refuse(&mut self, run: RunId, error: String) {
        if self.unfit.as_ref().is_none_or(|(_, known)| *known != error) {
            tracing::warn!("{error}; waiting for another mission");
        }
        self.unfit = Some((run, error));
    }

    /// What is missing, if anything.
    fn lacks(&self) -> Option<&'static str> {
        match &self.unfit {
            Some(_) => Some("hopper-sim: a mission that this planner can plan for"),
            None => self.pilot.waits_for(),
        }
    }

    /// Logs patches and pages that were well formed but made another map than their fingerprint says. Those of
    /// another run are counted without a line: between two missions they are to be expected.
    fn log_refusals(&mut self) {
        let count = self.pilot.map().refusals().of("malformed");
        if count > self.refusals_logged {
            tracing::warn!("{count} messages about the map were malformed or did not add up");
            self.refusals_logged = count;
        }
    }
}

impl<P: Ports> Process<P> for PlannerProcess<P> {
    async fn turn(&mut self, ports: &mut P) -> Result<Turn, Failure> {
        let mut effects = self.receive(ports).await;
        while let Some(effect) = effects.pop_front() {
            append(&mut effects, self.carry_out(&effect, ports).await.map_err(Into::into)?);
        }
        self.log_refusals();
        // Who cannot plan for a mission does not man it.
        self.membership.tell_robots(if self.unfit.is_some() { RobotSet::NONE } else { self.robots });
        self.commands.iter_mut().for_each(|(_, commands)| commands.idle());
        if let Some(routes) = &mut self.routes {
            routes.announcements.iter_mut().for_each(|(_, announcements)| announcements.idle());
        }
        self.membership.close_turn(ports, self.pilot.seen(), self.lacks())
    }
}

/// Which policy was published last, and to how many readers.
#[derive(Clone, Copy, Debug, Default)]
struct PolicySent {
    decision: Option<(RunId, Decision)>,
    readers: usize,
}

impl PolicySent {
    /// Whether the policy behind a decision is to be published: once for each decision, and again if more read by
    /// then, however often the command is sent.
    fn is_due(&mut self, run: RunId, decision: Decision, readers: usize) -> bool {
        let due = Some((run, decision));
        let news = readers > 0 && (self.decision != due || readers > self.readers);
        if news {
            self.decision = due;
        }
        self.readers = readers;
        news
    }
}

/// A message about the map as the pilot hears it; a malformed one is logged, and counted there.
fn event<T>(message: Result<T, Refusal>, event: impl Fn(T) -> Event) -> Event {
    match message {
        Ok(message) => event(message),
        Err(refusal) => {
            log_refusal(&refusal);
            Event::Refused(refusal)
        }
    }
}

/// Adds what an event asks for: most ask for nothing, and most that do come alone, so that their list is taken as it is.
fn append(effects: &mut VecDeque<Effect>, more: Vec<Effect>) {
    if more.is_empty() {
        return;
    }
    if effects.is_empty() {
        *effects = more.into();
    } else {
        effects.extend(more);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_policy_is_published_once_a_decision_and_again_to_who_comes_later() {
        let mut sent = PolicySent::default();
        let mut is_due = |decision, readers| sent.is_due(RunId(1), Decision(decision), readers);
        assert!(!is_due(0, 0), "nobody reads");
        assert!(is_due(0, 1), "the command is sent again, and somebody reads");
        assert!(!is_due(0, 1), "the command is sent again");
        assert!(is_due(0, 2), "one more reads");
        assert!(!is_due(0, 1), "one has gone");
        assert!(is_due(0, 2), "another has come");
        assert!(is_due(1, 2), "the next decision");
        assert!(!is_due(1, 2));
    }
}
