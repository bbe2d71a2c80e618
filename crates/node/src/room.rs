//! How much shared memory an instance needs, and how much there is.
//!
//! A file in shared memory that outgrows it ends the process with SIGBUS rather than an error, at the first
//! write to a page that is not there. So we look before we leap, and have every page given to us before we use
//! any: from then on it is of no matter who fills the rest.

use std::fs;
use std::io::ErrorKind;

use contract::limits::MAP_PATCH_CELLS;
use contract::service::{self, Exchange, Topic};
use contract::wire::{
    BriefV3, CommandV1, ControlV1, HeartbeatV1, MapPatchV1, MapRequestV1, PastRequestV1, PolicyCellV1,
    PolicyHeaderV1, SeenCellV1, StateV3, TempoV1, TruthRequestV1,
};
use contract::{MapPage, PastPage, RobotId, TruthPage};

use rustix::fs::{FallocateFlags, fallocate};
use rustix::io::Errno;

use crate::NodeError;
use crate::exchange::page_bytes;
use crate::instance::{Instance, SHARED_MEMORY};

/// Planners of one robot that are reckoned with: the leader and one that stands by.
const PLANNERS: usize = 2;

/// Processes that are reckoned with.
const PROCESSES: usize = 5;

/// Bytes the middleware puts before each message, rounded up.
const OVERHEAD: usize = 64;

/// Bytes for everything else: services, connections, events.
const MANAGEMENT_BYTES: u64 = 4 << 20;

/// Bytes that must be free for a process to join: more than its part of the above, since others connect to it
/// without asking.
const ENTRY_BYTES: u64 = 1 << 20;

/// Shared memory of one service.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct ServiceRoom {
    /// Name of the service.
    pub service: String,
    /// Writers that are reckoned with.
    pub writers: usize,
    /// Slots of each writer.
    pub slots: usize,
    /// Bytes of each slot.
    pub slot_bytes: usize,
    /// Bytes in all.
    pub bytes: u64,
}

/// Shared memory of an instance.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Room {
    /// Bytes needed.
    pub need_bytes: u64,
    /// Bytes free at present.
    pub free_bytes: u64,
    /// Where the need comes from.
    pub services: Vec<ServiceRoom>,
}

impl Room {
    /// The room for a mission of `robots` robots on a grid of `cells` cells.
    ///
    /// # Errors
    /// If shared memory cannot be asked for its size.
    pub fn of(cells: usize, robots: u16) -> Result<Self, NodeError> {
        let mut services = vec![
            exchange_room(&service::truth(), size_of::<TruthRequestV1>(), page_bytes::<TruthPage>),
            room(&service::brief(), 1, size_of::<BriefV3>()),
            room(&service::heartbeat(), PROCESSES, size_of::<HeartbeatV1>()),
            exchange_room(&service::past(), size_of::<PastRequestV1>(), page_bytes::<PastPage>),
        ];
        for robot in (0..robots).map(RobotId) {
            let patch = size_of::<MapPatchV1>() + MAP_PATCH_CELLS * size_of::<SeenCellV1>();
            let policy = size_of::<PolicyHeaderV1>() + cells * size_of::<PolicyCellV1>();
            services.extend([
                room(&service::state(robot), 1, size_of::<StateV3>()),
                room(&service::map(robot), 1, patch),
                exchange_room(&service::snapshot(robot), size_of::<MapRequestV1>(), page_bytes::<MapPage>),
                room(&service::command(robot), PLANNERS, size_of::<CommandV1>()),
                room(&service::control(robot), 1, size_of::<ControlV1>()),
                room(&service::tempo(robot), 1, size_of::<TempoV1>()),
                room(&service::policy(robot), PLANNERS, policy),
            ]);
        }
        let need_bytes = services.iter().map(|service| service.bytes).sum::<u64>() + MANAGEMENT_BYTES;
        Ok(Self { need_bytes, free_bytes: free_bytes()?, services })
    }

    /// Fails early if there is not enough, with what processes of `instance` have already.
    ///
    /// # Errors
    /// [`NodeError::NoRoom`] with both numbers.
    pub fn check(&self, instance: &Instance) -> Result<(), NodeError> {
        let used_bytes: u64 = instance.files().iter().map(|(_, bytes)| bytes).sum();
        check("the mission", self.need_bytes, self.free_bytes + used_bytes)
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

/// Has all pages of the instance's files given to us, those of `what` among them.
///
/// # Errors
/// [`NodeError::NoRoom`] if there are not enough.
pub(crate) fn reserve(instance: &Instance, what: &str) -> Result<(), NodeError> {
    for (path, used_bytes) in instance.files() {
        let file = match fs::OpenOptions::new().read(true).write(true).open(&path) {
            Ok(file) => file,
            // Gone with its owner, or not yet finished: then its maker reserves it.
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
            // A file system that gives no promises leaves us with the check alone.
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

/// Fails if one more writer of `topic` would outgrow shared memory.
pub(crate) fn check_topic(topic: &Topic, message_bytes: usize) -> Result<(), NodeError> {
    check(&format!("service {}", topic.name), room(topic, 1, message_bytes).bytes, free_bytes()?)
}

fn check(what: &str, need_bytes: u64, free_bytes: u64) -> Result<(), NodeError> {
    if need_bytes <= free_bytes {
        Ok(())
    } else {
        Err(NodeError::NoRoom { what: what.into(), need_bytes, free_bytes })
    }
}

/// Slots of a writer: what every reader may queue and hold, the history, and one being written.
fn room(topic: &Topic, writers: usize, message_bytes: usize) -> ServiceRoom {
    let slots = topic.max_subscribers * (topic.buffer + topic.borrowed) + topic.history + 1;
    let slot_bytes = (message_bytes + OVERHEAD).next_multiple_of(8);
    let bytes = (writers * slots * slot_bytes) as u64;
    ServiceRoom { service: topic.name.clone(), writers, slots, slot_bytes, bytes }
}

/// Fails if a server of `exchange` would outgrow shared memory.
pub(crate) fn check_exchange(
    exchange: &Exchange,
    request_bytes: usize,
    page_bytes: usize,
) -> Result<(), NodeError> {
    let room = exchange_room(exchange, request_bytes, |_| page_bytes);
    check(&format!("service {}", exchange.name), room.bytes, free_bytes()?)
}

/// Slots of a server: per client two requests under way, each with an answer queued, held and being written.
fn exchange_room(
    exchange: &Exchange,
    request_bytes: usize,
    page_bytes: impl Fn(&Exchange) -> usize,
) -> ServiceRoom {
    let slots = exchange.max_clients * 2 * 3;
    let slot_bytes = page_bytes(exchange) + request_bytes + 2 * OVERHEAD;
    ServiceRoom {
        service: exchange.name.clone(),
        writers: 1,
        slots,
        slot_bytes,
        bytes: (slots * slot_bytes) as u64,
    }
}
