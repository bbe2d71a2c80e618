//! The ports of a simulated process: queues instead of shared memory, virtual time instead of a clock.

use std::any::Any;
use std::convert::Infallible;
use std::future::{pending, poll_fn};
use std::rc::Rc;
use std::sync::PoisonError;
use std::task::Poll;

use contract::{
    Decision, Incarnation, MapPage, Message, MonotonicNs, Name, PastPage, PriorPage, Refusal, Request,
    RobotId, Role, TruthPage,
};
use hopper_sim::crash;
use process::{Failure, Ports};

use crate::life::Life;
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
            let (life, now) = (self.life.incarnation, world.monotonic());
            match point {
                crash::BEFORE_APPEND => {
                    let due = Decision(world.checker.records().len() as u64);
                    world.stamps.accepted(life, due);
                }
                crash::APPENDED => world.check_commit(&self.life),
                "perception.sensed" => world.stamps.sensed(life, now),
                _ => {}
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
        if point == crash::APPENDED {
            let world = &mut *self.world.borrow_mut();
            let now = world.monotonic();
            world.stamps.committed(self.life.incarnation, now);
        }
    }

    async fn computed(&mut self) {
        let seen = self.life.situation.lock().unwrap_or_else(PoisonError::into_inner).take();
        {
            let world = &mut *self.world.borrow_mut();
            if let Some(given) = seen {
                world.plans(&self.life, &given.situation());
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
            world.explained_ns = world.explained_ns.max(at_ns);
            world.schedule(at_ns, Event::Computed(self.life.slot, self.life.incarnation));
        }
        poll_fn(|_| if self.life.computed.take() { Poll::Ready(()) } else { Poll::Pending }).await;
        let world = &mut *self.world.borrow_mut();
        let now = world.monotonic();
        world.stamps.planned(self.life.incarnation, now);
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
                    self.ports.world.borrow_mut().answered_to(&self.ports.life, response, answer.server);
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
            world.answered(&request, &response);
            if let Some(page) = (&response as &dyn Any).downcast_ref::<MapPage>() {
                let found = world.stamps.page(self.ports.life.incarnation, page);
                world.stamped(found);
            }
            for (client, wakes, queue) in world.listening::<Answered<Q::Response>>(self.robot) {
                if client.incarnation == asker {
                    let server = self.ports.life.incarnation;
                    let answered = Answered { response: response.clone(), number, server };
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
    } else if let Some(page) = response.downcast_mut::<PriorPage>() {
        page.cells.truncate(cells);
    } else if let Some(page) = response.downcast_mut::<MapPage>()
        && page.cells.len() > cells
    {
        page.cells.truncate(cells);
        page.next = page.cells.last().map_or(page.from, |cell| cell.index + 1);
    }
}
