//! How much shared memory an instance needs, and how much there is.
//!
//! A file in shared memory that outgrows it ends the process with SIGBUS rather than an error, at the first write to a
//! page that is not there. So the size is checked first, and every page is reserved before any is used: after that it
//! does not matter who fills the rest.

use std::any::TypeId;
use std::io::ErrorKind;

use contract::message::{Capacity, PublishSubscribe, Visitor};
use contract::{Announcement, Command, Message, Payload, PriorRequest, Request, RobotId, RouteRequest};
use rustix::fs::{FallocateFlags, fallocate};
use rustix::io::Errno;

use crate::error::NodeError;
use crate::membership::instance::Instance;
use crate::private_file::owner_only;
use crate::shared_memory::SHARED_MEMORY;

/// Bytes the middleware puts before each message, rounded up.
const OVERHEAD_BYTES: usize = 64;

/// Bytes for everything else: services, connections, events.
const MANAGEMENT_BYTES: u64 = 4 << 20;

/// Bytes that must be free for a process to join: more than its part of the above, since others connect to it without
/// asking.
const ENTRY_BYTES: u64 = 1 << 20;

/// Shared memory of one service.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct ServiceBudget {
    /// Name of the service, such as `hop/state`.
    pub service: String,
    /// Writers that are allowed for.
    pub writers: usize,
    /// Messages that each writer has memory for.
    pub slots: usize,
    /// Bytes of each slot.
    pub slot_bytes: usize,
    /// Bytes of all slots of all writers.
    pub bytes: u64,
}

/// Shared memory of an instance.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct MemoryBudget {
    /// Bytes the mission needs in all.
    pub need_bytes: u64,
    /// Bytes free at present.
    pub free_bytes: u64,
    /// The services that need them.
    pub services: Vec<ServiceBudget>,
}

impl MemoryBudget {
    /// The budget of a mission of `robots` robots on a grid of `cells` cells.
    ///
    /// # Errors
    /// If the size of shared memory cannot be read.
    pub fn of(cells: usize, robots: u16) -> Result<Self, NodeError> {
        let mut sum = Services { cells, robots, services: Vec::new() };
        contract::wire::visit(&mut sum);
        let services = sum.services;
        let need_bytes = services.iter().map(|service| service.bytes).sum::<u64>() + MANAGEMENT_BYTES;
        Ok(Self { need_bytes, free_bytes: free_bytes()?, services })
    }

    /// Fails early if there is not enough shared memory, counting what processes of `instance` have already.
    ///
    /// # Errors
    /// [`NodeError::NoRoom`] with both numbers.
    pub fn check(&self, instance: &Instance) -> Result<(), NodeError> {
        let used_bytes: u64 = instance.files().iter().map(|(_, bytes)| bytes).sum();
        check("the mission", self.need_bytes, self.free_bytes + used_bytes)
    }
}

/// Collects the budgets of all services of a mission.
struct Services {
    cells: usize,
    robots: u16,
    services: Vec<ServiceBudget>,
}

impl Visitor for Services {
    fn message<M: Message>(&mut self) {
        let service = M::SERVICE;
        // Of the services that carry a robot's number, only commands and routes are opened for each. A single hopper has no
        // route.
        let is_route = TypeId::of::<M>() == TypeId::of::<Announcement>();
        if is_route && self.robots == 1 {
            return;
        }
        let is_own = is_route || TypeId::of::<M>() == TypeId::of::<Command>();
        let robots = if is_own { self.robots } else { 1 };
        for robot in (0..robots).map(RobotId) {
            let cells = match service.capacity {
                Capacity::Cells(cells) => cells,
                Capacity::Grid => self.cells,
            };
            self.services.push(of_writers::<M>(robot, cells, service.expected_publishers));
        }
    }

    fn request<Q: Request>(&mut self) {
        let of_routes = [TypeId::of::<PriorRequest>(), TypeId::of::<RouteRequest>()];
        if self.robots == 1 && of_routes.contains(&TypeId::of::<Q>()) {
            return;
        }
        self.services.push(of_server::<Q>(RobotId(0)));
    }
}

/// Free bytes of shared memory.
///
/// # Errors
/// If the file system cannot be asked.
pub fn free_bytes() -> Result<u64, NodeError> {
    let status = rustix::fs::statvfs(SHARED_MEMORY)
        .map_err(|error| NodeError::system("inspect", SHARED_MEMORY.as_ref(), error))?;
    Ok(status.f_bavail * status.f_frsize)
}

/// Fails if there is no room for one more process.
pub(crate) fn check_entry(name: &str) -> Result<(), NodeError> {
    check(&format!("joining as {name}"), ENTRY_BYTES, free_bytes()?)
}

/// Fails if one more writer of messages of `cells` cells would outgrow shared memory.
pub(crate) fn check_writer<M: Message>(robot: RobotId, cells: usize) -> Result<(), NodeError> {
    check_service(&of_writers::<M>(robot, cells, 1))
}

/// Fails if a server would outgrow shared memory.
pub(crate) fn check_server<Q: Request>(robot: RobotId) -> Result<(), NodeError> {
    check_service(&of_server::<Q>(robot))
}

/// Reserves all pages of the instance's files, those of `what` among them.
///
/// # Errors
/// [`NodeError::NoRoom`] if there are not enough.
pub(crate) fn reserve(instance: &Instance, what: &str) -> Result<(), NodeError> {
    for (path, used_bytes) in instance.files() {
        let file = match owner_only(0o600).open(&path) {
            Ok(file) => file,
            // Gone with its owner, or not yet finished: then its maker will reserve it.
            Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::PermissionDenied) => {
                continue;
            }
            Err(error) => return Err(NodeError::system("open", &path, error)),
        };
        let bytes = file.metadata().map_err(|error| NodeError::system("inspect", &path, error))?.len();
        if bytes <= used_bytes {
            continue;
        }
        match fallocate(&file, FallocateFlags::empty(), 0, bytes) {
            // A file system that cannot reserve leaves us with the check alone.
            Ok(()) | Err(Errno::OPNOTSUPP | Errno::NOSYS) => {}
            Err(Errno::NOSPC) => {
                let (need_bytes, free_bytes) = (bytes - used_bytes, free_bytes()?);
                return Err(NodeError::NoRoom { what: what.into(), need_bytes, free_bytes });
            }
            Err(error) => return Err(NodeError::system("reserve", &path, error)),
        }
    }
    Ok(())
}

fn check_service(budget: &ServiceBudget) -> Result<(), NodeError> {
    check(&format!("service {}", budget.service), budget.bytes, free_bytes()?)
}

fn check(what: &str, need_bytes: u64, free_bytes: u64) -> Result<(), NodeError> {
    if need_bytes <= free_bytes {
        Ok(())
    } else {
        Err(NodeError::NoRoom { what: what.into(), need_bytes, free_bytes })
    }
}

/// Slots of a writer: what every reader may queue and hold, the history, and one being written.
fn of_writers<M: Message>(robot: RobotId, cells: usize, writers: usize) -> ServiceBudget {
    let PublishSubscribe { max_subscribers, buffer, borrowed, history, .. } = M::SERVICE;
    let slots = max_subscribers * (buffer + borrowed) + history + 1;
    let slot_bytes = (payload_bytes::<M>(cells) + OVERHEAD_BYTES).next_multiple_of(8);
    let bytes = (writers * slots * slot_bytes) as u64;
    ServiceBudget { service: M::SERVICE.name_of(robot), writers, slots, slot_bytes, bytes }
}

/// Slots of a server: per client two requests under way, each with an answer queued, held and being written.
fn of_server<Q: Request>(robot: RobotId) -> ServiceBudget {
    let slots = Q::SERVICE.max_clients * 2 * 3;
    let page_bytes = payload_bytes::<Q::Response>(Q::SERVICE.page);
    let slot_bytes = page_bytes + payload_bytes::<Q>(1) + 2 * OVERHEAD_BYTES;
    let bytes = (slots * slot_bytes) as u64;
    ServiceBudget { service: Q::SERVICE.name_of(robot), writers: 1, slots, slot_bytes, bytes }
}

fn payload_bytes<P: Payload>(cells: usize) -> usize {
    size_of::<P::Header>() + cells * size_of::<P::Cell>()
}
