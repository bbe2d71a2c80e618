//! Ports that hand messages over by a direct call: every reader has its queue, every writer the queues of all readers.

use std::any::{Any, TypeId};
use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, VecDeque};
use std::convert::Infallible;
use std::future::ready;
use std::rc::{Rc, Weak};

use contract::{Incarnation, Message, MonotonicNs, Name, Refusal, Request, RobotId};
use process::{Failure, Ports};

/// Reads the time.
pub type Clock<'c> = Box<dyn FnMut() -> MonotonicNs + 'c>;

/// What connects the processes of one mission.
pub(super) struct Bus<'c> {
    /// By message and robot.
    channels: RefCell<BTreeMap<(TypeId, RobotId), Rc<dyn Any>>>,
    clock: RefCell<Clock<'c>>,
    /// What the clock read last: once a turn, and after each computation.
    now: Cell<MonotonicNs>,
}

/// The ports of one process.
#[derive(Clone)]
pub struct DirectPorts<'c> {
    bus: Rc<Bus<'c>>,
    incarnation: Incarnation,
}

/// Direct ports always open, and sending always has room.
#[derive(Debug)]
pub struct Never(Infallible);

type Queue<T> = RefCell<VecDeque<T>>;

/// Who reads a message, and the last one, if late readers get it.
struct Channel<T> {
    readers: RefCell<Vec<Weak<Queue<T>>>>,
    last: RefCell<Option<T>>,
}

/// Messages that wait to be read.
pub struct Reader<M>(Rc<Queue<M>>);

/// Where messages of one kind are published.
pub struct Writer<M>(Rc<Channel<M>>);

type Asked<Q> = (Q, Weak<Queue<<Q as Request>::Response>>);

/// Sends requests of one kind.
pub struct Client<Q: Request> {
    servers: Rc<Channel<Asked<Q>>>,
    answers: Rc<Queue<Q::Response>>,
    waits: bool,
}

/// Answers requests of one kind.
pub struct Server<Q: Request>(Rc<Queue<Asked<Q>>>);

impl<'c> Bus<'c> {
    pub fn new(clock: Clock<'c>) -> Rc<Self> {
        let (channels, clock) = (RefCell::default(), RefCell::new(clock));
        Rc::new(Self { channels, clock, now: Cell::new(MonotonicNs(0)) })
    }

    pub fn ports(self: &Rc<Self>, incarnation: Incarnation) -> DirectPorts<'c> {
        DirectPorts { bus: Rc::clone(self), incarnation }
    }

    pub fn look_at_clock(&self) {
        self.now.set((self.clock.borrow_mut())());
    }

    fn channel<T: 'static>(&self, robot: RobotId) -> Rc<Channel<T>> {
        let mut channels = self.channels.borrow_mut();
        let channel = channels.entry((TypeId::of::<T>(), robot)).or_insert_with(|| {
            let (readers, last) = (RefCell::default(), RefCell::new(None));
            Rc::new(Channel::<T> { readers, last })
        });
        Rc::clone(channel).downcast().expect("a channel is found under its type")
    }

    fn queue<T: Clone + 'static>(&self, robot: RobotId) -> Rc<Queue<T>> {
        let channel = self.channel::<T>(robot);
        let queue: Rc<Queue<T>> = Rc::new(RefCell::new(channel.last.borrow().iter().cloned().collect()));
        channel.readers.borrow_mut().push(Rc::downgrade(&queue));
        queue
    }
}

impl<T: Clone> Channel<T> {
    fn send(&self, message: T) {
        let readers = self.readers.borrow();
        let mut open = readers.iter().filter_map(Weak::upgrade);
        // One reader is the rule, and needs no copy.
        let Some(mut reader) = open.next() else { return };
        for next in open {
            reader.borrow_mut().push_back(message.clone());
            reader = next;
        }
        reader.borrow_mut().push_back(message);
    }
}

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

impl Ports for DirectPorts<'_> {
    type Error = Never;
    type Reader<M: Message> = Reader<M>;
    type Writer<M: Message> = Writer<M>;
    type Client<Q: Request> = Client<Q>;
    type Server<Q: Request> = Server<Q>;

    fn reader<M: Message>(&mut self, robot: RobotId, _wakes: bool) -> Result<Reader<M>, Never> {
        Ok(Reader(self.bus.queue(robot)))
    }

    fn try_reader<M: Message>(&mut self, robot: RobotId) -> Result<Reader<M>, Never> {
        self.reader(robot, false)
    }

    fn writer<M: Message>(&mut self, robot: RobotId) -> Result<Writer<M>, Never> {
        Ok(Writer(self.bus.channel(robot)))
    }

    fn client<Q: Request>(&mut self, robot: RobotId) -> Result<Client<Q>, Never> {
        Ok(Client { servers: self.bus.channel(robot), answers: Rc::default(), waits: false })
    }

    fn server<Q: Request>(&mut self, robot: RobotId) -> Result<Server<Q>, Never> {
        Ok(Server(self.bus.queue(robot)))
    }

    fn now(&mut self) -> MonotonicNs {
        self.bus.now.get()
    }

    fn incarnation(&self) -> Incarnation {
        self.incarnation
    }

    fn pid(&self) -> u32 {
        0
    }

    fn version(&self) -> Name {
        Name::NONE
    }

    fn process_exists(&self, _pid: u32) -> bool {
        true
    }

    fn stop_requested(&self) -> bool {
        false
    }

    fn wait(&mut self, _timeout_ns: u64) -> impl Future<Output = ()> {
        ready(())
    }

    fn pass(&mut self, _point: &'static str) -> impl Future<Output = ()> {
        ready(())
    }

    fn computed(&mut self) -> impl Future<Output = ()> {
        self.bus.look_at_clock();
        ready(())
    }
}

impl<M: Message> process::Reader<M> for Reader<M> {
    fn receive(&mut self) -> Option<Result<M, Refusal>> {
        Some(Ok(self.0.borrow_mut().pop_front()?))
    }

    fn depth(&self) -> usize {
        self.0.borrow().len()
    }

    fn newest(&mut self) -> Option<Result<M, Refusal>> {
        let mut queue = self.0.borrow_mut();
        let newest = queue.pop_back()?;
        queue.clear();
        Some(Ok(newest))
    }
}

impl<M: Message> process::Writer<M> for Writer<M> {
    type Error = Never;

    fn publish(&mut self, message: M) -> Result<(), Never> {
        if M::SERVICE.history > 0 {
            *self.0.last.borrow_mut() = Some(message.clone());
        }
        self.0.send(message);
        Ok(())
    }

    fn readers(&self) -> usize {
        self.0.readers.borrow().iter().filter(|reader| reader.strong_count() > 0).count()
    }
}

impl<Q: Request> process::Client<Q> for Client<Q> {
    type Error = Never;

    fn request(&mut self, request: Q) -> Result<(), Never> {
        // One request at a time: an answer that is still there was given up.
        self.answers.borrow_mut().clear();
        self.servers.send((request, Rc::downgrade(&self.answers)));
        self.waits = true;
        Ok(())
    }

    fn receive(&mut self) -> Option<Result<Q::Response, Refusal>> {
        let answer = self.answers.borrow_mut().pop_front()?;
        self.waits = false;
        Some(Ok(answer))
    }

    fn is_waiting(&self) -> bool {
        self.waits
    }
}

impl<Q: Request> process::Server<Q> for Server<Q> {
    type Error = Never;

    fn serve(&mut self, mut answer: impl FnMut(&Q) -> Option<Q::Response>) -> Result<Vec<Refusal>, Never> {
        if self.0.borrow().is_empty() {
            return Ok(Vec::new());
        }
        let asked = std::mem::take(&mut *self.0.borrow_mut());
        for (index, (request, asker)) in asked.iter().enumerate() {
            // A client asks one thing at a time: its last request counts.
            let again = asked.iter().skip(index + 1).any(|(_, later)| later.ptr_eq(asker));
            if again {
                continue;
            }
            let Some(answers) = asker.upgrade() else { continue };
            match answer(request) {
                Some(response) => answers.borrow_mut().push_back(response),
                // Clients ask again after a while, but no time passes here: it is answered once it can be.
                None => self.0.borrow_mut().push_back((request.clone(), asker.clone())),
            }
        }
        Ok(Vec::new())
    }
}
