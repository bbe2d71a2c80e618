//! Ports that are opened during a mission: readers of what has a service for each robot, and clients once they are needed.

use contract::message::{Message, Request};
use contract::{Announcement, Brief, Command, RobotId};
use process::{Client, Ports, Reader, accept};

/// Readers of commands and announcements of all robots but the first, which are open from the beginning.
pub(crate) struct RobotPorts<P: Ports> {
    commands: Vec<P::Reader<Command>>,
    announcements: Vec<P::Reader<Announcement>>,
    /// Number of robots for which they were opened, and whether these have routes.
    opened: (u16, bool),
}

impl<P: Ports> Default for RobotPorts<P> {
    fn default() -> Self {
        Self { commands: Vec::new(), announcements: Vec::new(), opened: (1, false) }
    }
}

impl<P: Ports> RobotPorts<P> {
    /// Opens what the mission of `brief` has, and closes what it lacks. A service whose places are all taken is not read.
    pub fn follow(&mut self, ports: &mut P, brief: &Brief) {
        let count = brief.robots.count();
        let wanted = (count, count > 1 && brief.has_routes());
        if self.opened == wanted {
            return;
        }
        *self = Self { opened: wanted, ..Self::default() };
        for robot in (1..count).map(RobotId) {
            self.commands.extend(opened(ports, robot));
            if brief.has_routes() {
                self.announcements.extend(opened(ports, robot));
            }
        }
    }

    /// The commands that came, and how many there were of one robot at most.
    pub fn commands(&mut self) -> (Vec<Command>, usize) {
        let of_robots: Vec<_> =
            self.commands.iter_mut().map(|commands| well_formed(commands.drain())).collect();
        let longest = of_robots.iter().map(Vec::len).max().unwrap_or(0);
        (of_robots.into_iter().flatten().collect(), longest)
    }

    /// The announcements that came.
    pub fn announcements(&mut self) -> Vec<Announcement> {
        self.announcements.iter_mut().flat_map(|reader| well_formed(reader.drain())).collect()
    }
}

/// A reader, unless all places are taken.
fn opened<P: Ports, M: Message>(ports: &mut P, robot: RobotId) -> Option<P::Reader<M>> {
    let reader = ports.try_reader(robot);
    reader.map_err(|error| tracing::warn!("{} is not read: {error}", M::SERVICE.name_of(robot))).ok()
}

/// A client that is opened with the first request.
pub(crate) struct LateClient<P: Ports, Q: Request> {
    client: Option<P::Client<Q>>,
    /// Whether all places were taken.
    is_full: bool,
}

impl<P: Ports, Q: Request> Default for LateClient<P, Q> {
    fn default() -> Self {
        Self { client: None, is_full: false }
    }
}

impl<P: Ports, Q: Request> LateClient<P, Q> {
    /// Sends the request, if there is one and there is a place; else logs `loss` once.
    ///
    /// # Errors
    /// If sending fails.
    pub fn ask(&mut self, ports: &mut P, request: Option<Q>, loss: &str) -> Result<(), P::Error> {
        if self.is_full {
            return Ok(());
        }
        let Some(request) = request else { return Ok(()) };
        if self.client.is_none() {
            match ports.client(RobotId(0)) {
                Ok(client) => self.client = Some(client),
                Err(error) => {
                    tracing::warn!("{loss}: {error}");
                    self.is_full = true;
                }
            }
        }
        self.client.as_mut().map_or(Ok(()), |client| client.request(request))
    }

    /// The answer, if one came.
    pub fn receive(&mut self) -> Option<Q::Response> {
        accept(self.client.as_mut().and_then(Client::receive))
    }

    /// Whether nothing can be asked, since all places were taken.
    pub fn is_full(&self) -> bool {
        self.is_full
    }
}

/// The well-formed messages; others are logged and dropped.
pub fn well_formed<M>(messages: Vec<Result<M, contract::Refusal>>) -> Vec<M> {
    messages.into_iter().filter_map(|received| accept(Some(received))).collect()
}
