//! The ports of a simulated process: queues instead of shared memory, virtual time instead of a clock.

use std::any::Any;
use std::convert::Infallible;
use std::future::{pending, poll_fn};
use std::rc::Rc;
use std::sync::PoisonError;
use std::task::Poll;

use contract::{
    Branch, Brief, Command, Control, Heartbeat, Incarnation, MapPage, MapPatch, MapRequest, Message,
    MonotonicNs, Name, Order, Pacing, PastPage, PastRequest, Policy, Record, Refusal, Request, RobotId, Role,
    State, Team, TruthPage, TruthRequest,
};
use hopper_sim::crash;
use planner::Situation;
use process::{Failure, Ports};

use crate::checker::Known;
use crate::life::{Life, Pass};
use crate::recorded::decisions_recorded;
use crate::setup::Missions;
use crate::stream::{Answered, Asked, Stream};
use crate::world::{Event, MS, ProcessFault, Queue, Shared, World};

/// What one life has of the world.
#[derive(Clone)]
pub(crate) struct SimulatedPorts {
    pub world: Shared,
    pub life: Rc<Life>,
}

/// Simulated ports always open, and sending always has room.
#[derive(Debug)]
pub(crate) struct Never(Infallible);

impl std::fmt::Display for Never {
    fn fmt(&self, _: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0 {}
    }
}

impl From<Never> for Failure {
    fn from(never: Never) -> Self {
        match never.0 {}
    }
}

pub(crate) struct Reader<M> {
    ports: SimulatedPorts,
    queue: Rc<Queue<M>>,
}

pub(crate) struct Writer {
    ports: SimulatedPorts,
    robot: RobotId,
}

pub(crate) struct Client<Q: Request> {
    ports: SimulatedPorts,
    robot: RobotId,
    answers: Rc<Queue<Answered<Q::Response>>>,
    /// Requests so far, and whether the last waits for its answer.
    asked: u64,
    waits: bool,
}

pub(crate) struct Server<Q: Request> {
    ports: SimulatedPorts,
    robot: RobotId,
    requests: Rc<Queue<Asked<Q>>>,
}

impl SimulatedPorts {
    fn open<T: Clone + 'static>(&self, robot: RobotId, wakes: bool) -> Rc<Queue<T>> {
        self.world.borrow_mut().open(robot, &self.life, wakes)
    }

    /// Dies here, to be started again after so long.
    async fn die(&self, restart_ns: u64) {
        self.life.dies.set(Some(restart_ns));
        pending().await
    }

    /// Goes on once nothing stops it.
    async fn resumed(&self) {
        poll_fn(|_| if self.life.stopped_until.get().is_none() { Poll::Ready(()) } else { Poll::Pending })
            .await;
    }
}

impl Ports for SimulatedPorts {
    type Error = Never;
    type Reader<M: Message> = Reader<M>;
    type Writer<M: Message> = Writer;
    type Client<Q: Request> = Client<Q>;
    type Server<Q: Request> = Server<Q>;

    fn reader<M: Message>(&mut self, robot: RobotId, wakes: bool) -> Result<Reader<M>, Never> {
        assert!(!wakes || M::SERVICE.event, "{} has no events", M::SERVICE.name);
        Ok(Reader { queue: self.open(robot, wakes), ports: self.clone() })
    }

    fn try_reader<M: Message>(&mut self, robot: RobotId) -> Result<Reader<M>, Never> {
        self.reader(robot, false)
    }

    fn writer<M: Message>(&mut self, robot: RobotId) -> Result<Writer, Never> {
        assert!(M::SERVICE.writers.contains(&self.life.role), "{} is not this role's", M::SERVICE.name);
        Ok(Writer { ports: self.clone(), robot })
    }

    fn client<Q: Request>(&mut self, robot: RobotId) -> Result<Client<Q>, Never> {
        Ok(Client { answers: self.open(robot, true), ports: self.clone(), robot, asked: 0, waits: false })
    }

    fn server<Q: Request>(&mut self, robot: RobotId) -> Result<Server<Q>, Never> {
        assert!(Q::SERVICE.server == self.life.role, "{} is not this role's", Q::SERVICE.name);
        Ok(Server { requests: self.open(robot, true), ports: self.clone(), robot })
    }

    fn now(&mut self) -> MonotonicNs {
        self.world.borrow().monotonic()
    }

    fn incarnation(&self) -> Incarnation {
        self.life.incarnation
    }

    fn pid(&self) -> u32 {
        self.life.pid
    }

    fn version(&self) -> Name {
        self.life.version
    }

    fn process_exists(&self, pid: u32) -> bool {
        !self.life.blind && self.world.borrow().lives.iter().any(|life| life.pid == pid)
    }

    fn stop_requested(&self) -> bool {
        false
    }

    async fn wait(&mut self, timeout_ns: u64) {
        {
            let mut world = self.world.borrow_mut();
            world.turned(&self.life);
            let sleep_ns = if self.life.rung.take() {
                world.chance.between(1_000, 5_000)
            } else {
                timeout_ns.max(1_000)
            };
            self.life.sleeping.set(true);
            let at_ns = world.time_ns + sleep_ns;
            world.wake_at(&self.life, at_ns);
        }
        poll_fn(|_| if self.life.woken.take() { Poll::Ready(()) } else { Poll::Pending }).await;
        self.life.sleeping.set(false);
        self.world.borrow_mut().woke(&self.life);
    }

    async fn pass(&mut self, point: &'static str) {
        let (torn, fault) = {
            let world = &mut *self.world.borrow_mut();
            if point == crash::APPENDED {
                world.check_commit();
            }
            let torn = world.disk.take_torn().then_some(world.torn_restart_ns);
            if point == crash::APPEND_FAILED && torn.is_none() {
                world.coverage.count("journal", "append_failed");
                world.checker.append_failed();
            }
            (torn, world.pass(point))
        };
        if let Some(restart_ns) = torn {
            let world = &mut *self.world.borrow_mut();
            world.coverage.count("journal", "killed_writing");
            world.note(|| "hopper-sim dies writing".into());
            self.life.dies.set(Some(restart_ns));
        }
        if torn.is_some() {
            return pending().await;
        }
        match fault {
            Some(ProcessFault::Kill { restart_ns }) => self.die(restart_ns).await,
            Some(ProcessFault::Stop { ns }) => {
                {
                    let mut world = self.world.borrow_mut();
                    let until_ns = world.time_ns + ns;
                    world.stop(&self.life, until_ns);
                }
                self.resumed().await;
            }
            None => {}
        }
    }

    async fn computed(&mut self) {
        let seen = self.life.situation.lock().unwrap_or_else(PoisonError::into_inner).take();
        {
            let world = &mut *self.world.borrow_mut();
            if let Some((brief, map, state)) = seen {
                world.plans(
                    &self.life,
                    &Situation { brief: &brief, map: &map, state: &state, team: None, scouting: None },
                );
            }
            let slow = world.chance.one_in(60);
            let (plans, slow_ns) = self.life.slow.get();
            self.life.slow.set((plans.saturating_sub(1), slow_ns));
            let ns = if plans > 0 {
                slow_ns
            } else if slow {
                world.chance.duration_ns(MS, 1500 * MS)
            } else {
                world.chance.between(10_000, 900_000)
            };
            let at_ns = world.time_ns + ns;
            world.schedule(at_ns, Event::Computed(self.life.slot, self.life.incarnation));
        }
        poll_fn(|_| if self.life.computed.take() { Poll::Ready(()) } else { Poll::Pending }).await;
    }
}

impl<M: Message> process::Reader<M> for Reader<M> {
    fn receive(&mut self) -> Option<Result<M, Refusal>> {
        let (_, message) = self.queue.borrow_mut().pop_front()?;
        if let Ok(message) = &message {
            self.ports.world.borrow_mut().received(&self.ports.life, message);
        }
        Some(message)
    }

    fn depth(&self) -> usize {
        M::SERVICE.depth()
    }
}

impl<M: Message> process::Writer<M> for Writer {
    type Error = Never;

    fn publish(&mut self, message: M) -> Result<(), Never> {
        let world = &mut *self.ports.world.borrow_mut();
        world.published(&self.ports.life, &message);
        world.publish(self.robot, self.ports.life.incarnation, message);
        Ok(())
    }

    fn readers(&self) -> usize {
        self.ports.world.borrow().readers::<M>()
    }
}

impl<Q: Request> process::Client<Q> for Client<Q> {
    type Error = Never;

    fn request(&mut self, request: Q) -> Result<(), Never> {
        self.asked += 1;
        self.waits = true;
        let world = &mut *self.ports.world.borrow_mut();
        world.coverage.count(Stream::of::<Asked<Q>>().as_str(), "sent");
        world.asked(&self.ports.life, &request);
        let asked = Asked { request, number: self.asked, asker: self.ports.life.incarnation };
        for (server, wakes, queue) in world.listening::<Asked<Q>>(self.robot) {
            world.send(self.ports.life.incarnation, &server, wakes, &queue, Ok(asked.clone()));
        }
        Ok(())
    }

    fn receive(&mut self) -> Option<Result<Q::Response, Refusal>> {
        while let Some((_, answer)) = self.answers.borrow_mut().pop_front() {
            match answer {
                // An answer to a request that was given up is not received.
                Ok(answer) if self.waits && answer.number == self.asked => {
                    self.waits = false;
                    let response = &answer.response as &dyn Any;
                    if let Some(page) = response.downcast_ref::<MapPage>()
                        && self.ports.life.role == Role::Planner
                    {
                        self.ports.world.borrow_mut().paged(&self.ports.life, page);
                    }
                    return Some(Ok(answer.response));
                }
                Ok(_) => {}
                Err(refusal) => return Some(Err(refusal)),
            }
        }
        None
    }

    fn is_waiting(&self) -> bool {
        self.waits
    }
}

impl<Q: Request> process::Server<Q> for Server<Q> {
    type Error = Never;

    fn serve(&mut self, mut answer: impl FnMut(&Q) -> Option<Q::Response>) -> Result<Vec<Refusal>, Never> {
        let mut refusals = Vec::new();
        let asked = std::mem::take(&mut *self.requests.borrow_mut());
        for (_, asked) in asked {
            let Asked { request, number, asker } = match asked {
                Ok(asked) => asked,
                Err(refusal) => {
                    refusals.push(refusal);
                    continue;
                }
            };
            let Some(mut response) = answer(&request) else { continue };
            let world = &mut *self.ports.world.borrow_mut();
            shorten(&mut response, world);
            world.answered(&response);
            for (client, wakes, queue) in world.listening::<Answered<Q::Response>>(self.robot) {
                if client.incarnation == asker {
                    let answered = Answered { response: response.clone(), number };
                    world.send(self.ports.life.incarnation, &client, wakes, &queue, Ok(answered));
                }
            }
        }
        Ok(refusals)
    }
}

/// Shortens a page: a real one holds the whole of these small worlds, and what takes one page tests nothing.
fn shorten<R: 'static>(response: &mut R, world: &World) {
    let records = world.setup.page_records;
    let cells = world.setup.page_cells;
    let response = response as &mut dyn Any;
    if let Some(page) = response.downcast_mut::<PastPage>() {
        page.records.truncate(records);
    } else if let Some(page) = response.downcast_mut::<TruthPage>() {
        page.cells.truncate(cells);
    } else if let Some(page) = response.downcast_mut::<MapPage>()
        && page.cells.len() > cells
    {
        page.cells.truncate(cells);
        page.next = page.cells.last().map_or(page.from, |cell| cell.index + 1);
    }
}

impl World {
    /// The checker looks at what the journal has just taken.
    fn check_commit(&mut self) {
        let Some(record) = self.disk.take_write().and_then(|frame| hopper_sim::journal::record_of(&frame))
        else {
            return;
        };
        self.count_rovers(&record);
        self.checker.executed(&record);
        self.checker.committed(&record);
        self.decisions += 1;
        self.stirred_ns = self.stirred_ns.max(self.time_ns);
        let Record { robot, decision, action, leader, .. } = record;
        if record.origin.is_fallback() {
            self.coverage.count("fallback", record.origin.as_str());
            let origin = record.origin;
            self.note(|| {
                format!("committed: decision {decision}, robot {robot}, {action}, by the fallback ({origin})")
            });
        } else {
            self.note(|| {
                let (planner, term) = (leader.planner, leader.term);
                format!(
                    "committed: decision {decision}, robot {robot}, {action}, by {planner} in term {term}"
                )
            });
        }
    }

    /// Rare events among several robots that a record shows.
    fn count_rovers(&mut self, record: &Record) {
        if self.setup.missions != Missions::Rovers {
            return;
        }
        if record.outcome.branch == Branch::Stranded {
            self.coverage.count("rovers", "stranded");
        }
        let others = (0..self.setup.mission.brief.robots).map(RobotId).filter(|robot| *robot != record.robot);
        let mut leaders =
            others.map(|robot| self.checker.leader_of(robot)).filter(|leader| leader.term.0 > 0);
        if leaders.any(|leader| leader.incarnation == record.leader.incarnation) {
            self.coverage.count("rovers", "two_led_by_one");
        } else if self.checker.leader_of(record.robot).incarnation != record.leader.incarnation {
            self.coverage.count("rovers", "another_leads");
        }
    }

    /// The checker looks at what is published.
    fn published<M: Message>(&mut self, life: &Life, message: &M) {
        let message = message as &dyn Any;
        let now = self.monotonic();
        if let Some(state) = message.downcast_ref::<State>() {
            self.checker.published(state, now);
            self.count_state(state);
            self.note(|| format!("hopper-sim publishes state {} ({})", state.decision, state.status));
        } else if let Some(team) = message.downcast_ref::<Team>() {
            self.checker.team_published(team);
            self.note(|| format!("hopper-sim publishes robots {}: {} is due", team.decision, team.due));
        } else if let Some(patch) = message.downcast_ref::<MapPatch>() {
            self.checker.mapped(patch);
            // Landings that perception folds from the past are in no patch, and a map that is built anew may be another.
            let follows = self.patched.is_none_or(|(sequence, after)| {
                let again = (patch.sequence, patch.after) == (sequence, after);
                again || (patch.sequence, patch.before) == (sequence + 1, after)
            });
            self.patched = Some((patch.sequence, patch.after));
            if !follows {
                self.lives.iter().for_each(|life| life.disturb_map(self.time_ns));
            }
            self.coverage.count("map", if patch.more > 0 { "part" } else { "landing" });
            self.note(|| {
                let MapPatch { sequence, through, more, .. } = patch;
                let cells = patch.cells.len();
                format!("perception publishes patch {sequence} through {through}, {cells} cells, {more} more")
            });
        } else if let Some(command) = message.downcast_ref::<Command>() {
            self.sent(life, command, now);
        } else if let Some(pacing) = message.downcast_ref::<Pacing>() {
            self.checker.paced(pacing);
            self.coverage.count("tempo", if pacing.paused { "paused" } else { "running" });
        } else if message.is::<Policy>() {
            let readers = self.readers::<Policy>();
            self.checker.policy_published(readers);
            self.coverage.count("policy", "published");
        } else if let Some(beat) = message.downcast_ref::<Heartbeat>() {
            self.acknowledged(life, beat, now);
        } else if message.is::<Brief>() {
            self.coverage.count("run", "announced");
        }
    }

    /// The first heartbeat of a recording monitor that acknowledges the end of the mission.
    fn acknowledged(&mut self, life: &Life, beat: &Heartbeat, now: MonotonicNs) {
        if !beat.status.is_over() || beat.run != self.checker.mission().brief.run {
            return;
        }
        if let Some(recording) = life.recording.take() {
            let decisions = decisions_recorded(&recording.borrow(), beat.run);
            self.checker.recorded(life.incarnation, &decisions, now);
            self.coverage.count("recording", "acknowledged");
        }
    }

    fn sent(&mut self, life: &Life, command: &Command, now: MonotonicNs) {
        let known = life.state_seen.get().map(|(run, decision, _)| (run, decision));
        let is_known = known == Some((command.run, command.decision));
        // Of several states that came at once the last counts, which need not be the newest: a command for the decision
        // before is refused as one that is repeated.
        let is_behind = known.is_some_and(|(run, due)| run == command.run && command.decision < due);
        let itself =
            contract::Leader { term: command.term, incarnation: command.incarnation, ..Default::default() };
        let of_team = || life.leader_in_team(command);
        let (leader, since) = match (is_known, is_behind, self.setup.missions) {
            (true, _, Missions::Hopper) => life.leader_seen.get(),
            (true, _, Missions::Rovers) => of_team().unwrap_or((itself, now)),
            (false, true, _) => (itself, now),
            (false, false, _) => (contract::Leader::default(), life.leader_seen.get().1),
        };
        let leader_lives = self.lives.iter().any(|life| life.pid == leader.pid);
        let leader = Known { leader, since, is_gone: life.blind || !leader_lives };
        if let Some(cause) = self.checker.sent(command, life, leader, now) {
            self.coverage.count("takeover_asked", cause);
        }
        self.note(|| {
            let Command { decision, action, term, planner, incarnation, robot, .. } = command;
            format!(
                "{planner} {incarnation} sends decision {decision}, {action}, term {term} of robot {robot}"
            )
        });
        if self.checker.is_own(life.version) {
            self.commanded = Some(*command);
        }
    }

    /// The checker looks at what is received.
    fn received<M: Message>(&mut self, life: &Life, message: &M) {
        let message = message as &dyn Any;
        let now = self.monotonic();
        if let Some(command) = message.downcast_ref::<Command>()
            && life.role == Role::HopperSim
        {
            let (received, executed) = life.commands.get();
            life.commands.set((received + 1, executed));
            self.checker.judged(command, now);
        } else if let Some(policy) = message.downcast_ref::<Policy>()
            && life.role == Role::HopperSim
        {
            self.checker.advised(policy);
        } else if let Some(state) = message.downcast_ref::<State>() {
            self.knows(life, state, now);
        } else if let Some(team) = message.downcast_ref::<Team>() {
            life.knows_team(team, now);
        } else if message.is::<MapPatch>() && life.role == Role::Planner {
            if let Pass::Under { .. } = life.pass.get() {
                self.coverage.count("map", "patch_between_pages");
            }
        } else if let Some(beat) = message.downcast_ref::<Heartbeat>() {
            if beat.incarnation != life.incarnation {
                self.checker.heard(life, beat, now);
            }
        } else if let Some(control) = message.downcast_ref::<Control>() {
            self.checker.ordered(life, control);
            if life.role == Role::HopperSim {
                self.coverage.count(
                    "order",
                    match control.order {
                        Order::Pause => "pause",
                        Order::Resume => "resume",
                        Order::Step => "step",
                        Order::Pace(_) => "pace",
                        Order::HandOver(_) => "hand_over",
                    },
                );
            }
        }
    }

    /// What a process knows of the mission from now on.
    fn knows(&mut self, life: &Life, state: &State, now: contract::MonotonicNs) {
        let known = life.state_seen.get().filter(|(run, ..)| *run == state.run);
        let is_old = known.is_some_and(|(_, decision, published)| {
            state.decision < decision && state.published <= published
        });
        if is_old {
            return;
        }
        life.state_seen.set(Some((state.run, state.decision, state.published)));
        let turn = life.turns.get() + 1;
        if life.leader_at_turn.get().0 != turn {
            life.leader_at_turn.set((turn, life.leader_seen.get()));
        }
        let (_, before) = life.leader_at_turn.get();
        if known.is_some() && before.0 == state.leader {
            life.leader_seen.set(before);
        } else if life.leader_seen.get().0 != state.leader || known.is_none() {
            life.leader_seen.set((state.leader, now));
        }
        let mut runs = life.runs.borrow_mut();
        if !runs.contains(&state.run) {
            runs.push(state.run);
            if runs.len() > 1 {
                self.coverage.count("stayed", life.role.as_str());
            }
        }
    }

    /// Rare events that a published state shows.
    fn count_state(&mut self, state: &State) {
        if let [.., before, last] = self.checker.disc_cells()
            && before != last
            && state.decision.0 > 0
        {
            self.coverage.count("map", "discs_differ");
        }
    }

    /// A planner receives a page of the map.
    fn paged(&mut self, life: &Life, page: &MapPage) {
        // What was disturbed may be under way for half a second, and lie unread for another half.
        const UNDISTURBED_NS: u64 = 1_100 * MS;
        let awake_ns = self.monotonic().since_ns(life.listening_since.get());
        let is_past = |at_ns: u64| self.time_ns > at_ns + UNDISTURBED_NS;
        // A life to which that never happened has nothing under way from before its birth.
        let quiet = life.disturbed_ns.get().is_none_or(|at_ns| is_past(at_ns) && awake_ns > UNDISTURBED_NS);
        let once = life.repeated_ns.get().is_none_or(is_past);
        let is_clean = match life.pass.get() {
            Pass::Under { is_clean } => is_clean && page.from > 0,
            Pass::None | Pass::Over { .. } => quiet && page.from == 0,
        };
        if (page.next as usize) < page.grid.cells() {
            return life.pass.set(Pass::Under { is_clean: is_clean || quiet && page.from == 0 });
        }
        life.pass.set(Pass::Over { is_clean, turn: life.turns.get() });
        let name = match (is_clean, once) {
            (true, true) => "pass_undisturbed",
            (true, false) => "pass_repeated",
            (false, _) => "pass_disturbed",
        };
        self.coverage.count("map", name);
        if is_clean && once {
            // The map is whole now, whatever was disturbed before: nothing may be asked for any more.
            life.map_whole.set(Some(page.run));
            life.map_disturbed.set(false);
        }
    }

    /// The checker looks at what is asked.
    fn asked<Q: 'static>(&mut self, life: &Life, request: &Q) {
        if let Pass::Over { turn, .. } = life.pass.get()
            && turn == life.turns.get()
        {
            // The page is received, and not folded in yet: what comes before it may ask once more.
            return;
        }
        if let Some(request) = (request as &dyn Any).downcast_ref::<MapRequest>()
            && life.role == Role::Planner
            && request.from == 0
            && let Pass::Over { is_clean, .. } = life.pass.replace(Pass::None)
        {
            self.coverage.count("map", "asked_again");
            let is_empty = request.observation == 0;
            if is_clean && is_empty && !self.is_another_mission {
                let incarnation = life.incarnation;
                self.checker
                    .violate("a pass over the pages that missed no patch makes the whole map", || {
                        format!("planner {incarnation} asks for all of it again")
                    });
            }
        }
        if let Some(request) = (request as &dyn Any).downcast_ref::<MapRequest>()
            && life.role == Role::Planner
            && life.map_whole.get() == Some(request.run)
            && !life.map_disturbed.get()
            && !self.is_another_mission
        {
            let incarnation = life.incarnation;
            self.checker.violate("who receives every patch asks for no page", || {
                format!("planner {incarnation} asks for the map from cell {}", request.from)
            });
        }
    }

    /// The checker looks at an answer.
    fn answered<R: 'static>(&mut self, response: &R) {
        let response = response as &dyn Any;
        if let Some(page) = response.downcast_ref::<PastPage>() {
            self.checker.served(page);
            self.coverage.count(Stream::of::<Asked<PastRequest>>().as_str(), "answered");
        } else if let Some(page) = response.downcast_ref::<MapPage>() {
            self.checker.paged(page);
            self.coverage.count(Stream::of::<Asked<MapRequest>>().as_str(), "answered");
        } else if response.is::<TruthPage>() {
            self.coverage.count(Stream::of::<Asked<TruthRequest>>().as_str(), "answered");
        }
    }

    /// Where a planner stands when it plans.
    pub fn plans(&mut self, life: &Life, situation: &Situation<'_>) {
        self.checker.plans(situation);
        let state = situation.state;
        life.map_whole.set(Some(state.run));
    }
}
