//! What a message is: its wire form and the service that carries it, declared once, beside the wire type.
//!
//! Everything that iterates over messages (build fingerprint, memory budget, `hopper topic`, the recording, the
//! fault simulation) goes through [`crate::wire::visit`], the one list.

use std::fmt::Debug;

use serde::Serialize;

use crate::field::Field;
use crate::{Refusal, RobotId, Role};

/// A type that may cross shared memory under a versioned name.
pub trait Wire: bytemuck::Pod + std::fmt::Debug {
    /// Name with version; every version of a layout has its own.
    const NAME: &'static str;

    /// Its fields in the order of the layout, with what is accepted and why they are there.
    #[must_use]
    fn fields() -> Vec<Field> {
        Vec::new()
    }
}

/// The header of a message of one fixed size.
impl Wire for () {
    const NAME: &'static str = "()";
}

/// How a value crosses shared memory: a header and cells. A message of one fixed size has no header and one cell.
pub trait Payload: Clone + Debug + PartialEq + Serialize + Sized + 'static {
    /// What precedes the cells; `()` for a message of one fixed size.
    type Header: Wire;
    /// One element of the slice.
    type Cell: Wire;

    /// The header in its wire form.
    fn header(&self) -> Self::Header;

    /// How many of them are payload cells.
    fn cells(&self) -> usize;

    /// The cell at `index`, which is below [`Payload::cells`], in its wire form.
    fn cell(&self, index: usize) -> Self::Cell;

    /// Empties the cells, for whoever shows a message without them; how many there were. A message of one fixed size
    /// has none to empty.
    fn clear_cells(&mut self) -> Option<usize> {
        None
    }

    /// The value of a sample that has been copied out of shared memory.
    ///
    /// # Errors
    /// A refusal that names the first field out of range, or the number of cells.
    fn from_wire(header: &Self::Header, cells: &[Self::Cell]) -> Result<Self, Refusal>;
}

/// A message that is published.
pub trait Message: Payload {
    /// The service that carries it.
    const SERVICE: PublishSubscribe;
}

/// A message that is answered.
pub trait Request: Payload<Header = ()> {
    /// The answer, in pages.
    type Response: Payload;
    /// The service that carries both.
    const SERVICE: RequestResponse;
}

/// How a publish-subscribe service is opened: the same numbers whoever creates it first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PublishSubscribe {
    /// Service name; `rN` in it stands for the robot.
    pub name: &'static str,
    /// The roles that write it.
    pub writers: &'static [Role],
    /// Most publishers at once.
    pub max_publishers: usize,
    /// Publishers that the memory budget of an instance allows for.
    pub expected_publishers: usize,
    /// Most subscribers at once.
    pub max_subscribers: usize,
    /// Samples a late subscriber gets.
    pub history: usize,
    /// Samples a subscriber's queue holds before the oldest gives way.
    pub buffer: usize,
    /// Samples a subscriber may hold at once.
    pub borrowed: usize,
    /// Whether an event service of the same name wakes the readers that ask for it.
    pub event: bool,
    /// Most cells of a message.
    pub capacity: Capacity,
}

/// Most cells of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Capacity {
    /// At most this many cells. Shared memory for them is taken when the writer is made.
    Cells(usize),
    /// As many as the grid has. Shared memory is taken when the first message is published.
    Grid,
}

/// How a request-response service is opened. The server answers in pages, so that its memory depends on the
/// size of a page and not on how much there is to serve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RequestResponse {
    /// Service name; `rN` in it stands for the robot.
    pub name: &'static str,
    /// The role that answers.
    pub server: Role,
    /// Most clients at once.
    pub max_clients: usize,
    /// Most cells of a response.
    pub page: usize,
}

impl PublishSubscribe {
    /// A service with one writer, eight readers, and queues of one message that late readers get too.
    #[must_use]
    pub const fn new(name: &'static str, writers: &'static [Role]) -> Self {
        Self {
            name,
            writers,
            max_publishers: 1,
            expected_publishers: 1,
            max_subscribers: 8,
            history: 1,
            buffer: 1,
            borrowed: 1,
            event: false,
            capacity: Capacity::Cells(1),
        }
    }

    /// The name for `robot`.
    #[must_use]
    pub fn name_of(&self, robot: RobotId) -> String {
        name_of(self.name, robot)
    }

    /// The robot whose service has that name, of a service that has a robot's number in its name.
    #[must_use]
    pub fn robot_of(&self, name: &str) -> Option<RobotId> {
        let (before, after) = self.name.split_once(ROBOT)?;
        let number = name.strip_prefix(before)?.strip_prefix("/r")?.strip_suffix(after)?.strip_suffix('/')?;
        let robot = RobotId(number.parse().ok()?);
        (self.name_of(robot) == name).then_some(robot)
    }

    /// The last part of the name, by which people ask for it: `state` of `hop/state`.
    #[must_use]
    pub fn short_name(&self) -> &'static str {
        short_name(self.name)
    }

    /// Messages that the queues of all writers to one reader hold.
    #[must_use]
    pub const fn depth(&self) -> usize {
        self.max_publishers * self.buffer
    }
}

impl RequestResponse {
    /// The name for `robot`.
    #[must_use]
    pub fn name_of(&self, robot: RobotId) -> String {
        name_of(self.name, robot)
    }

    /// The last part of the name: `past` of `hop/past`.
    #[must_use]
    pub fn short_name(&self) -> &'static str {
        short_name(self.name)
    }
}

/// What stands for the robot in a name.
const ROBOT: &str = "/rN/";

fn name_of(pattern: &str, robot: RobotId) -> String {
    pattern.replace(ROBOT, &format!("/r{robot}/"))
}

fn short_name(name: &'static str) -> &'static str {
    name.rsplit_once('/').map_or(name, |(_, short)| short)
}

/// Looks at every message and request that there is: see [`crate::wire::visit`].
pub trait Visitor {
    /// A message that is published.
    fn message<M: Message>(&mut self);

    /// A message that is answered.
    fn request<Q: Request>(&mut self);
}

/// The wire form of a message of one fixed size, from the `From` and `TryFrom` of its wire type.
#[macro_export]
macro_rules! fixed_payload {
    ($message:ty => $wire:ty) => {
        impl $crate::message::Payload for $message {
            type Header = ();
            type Cell = $wire;

            fn header(&self) {}

            fn cells(&self) -> usize {
                1
            }

            #[inline]
            fn cell(&self, _index: usize) -> $wire {
                self.into()
            }

            fn from_wire((): &(), cells: &[$wire]) -> Result<Self, $crate::Refusal> {
                match cells {
                    [wire] => wire.try_into(),
                    _ => Err($crate::Refusal::malformed("payload", "one element", cells.len())),
                }
            }
        }
    };
}

/// The wire form of a header and cells, which stand in `$field`.
#[macro_export]
macro_rules! slice_payload {
    ($message:ty => $header:ty, $cell:ty, $field:ident, $from_wire:expr) => {
        impl $crate::message::Payload for $message {
            type Header = $header;
            type Cell = $cell;

            fn header(&self) -> $header {
                self.into()
            }

            fn cells(&self) -> usize {
                self.$field.len()
            }

            #[inline]
            fn cell(&self, index: usize) -> $cell {
                (&self.$field[index]).into()
            }

            fn clear_cells(&mut self) -> Option<usize> {
                Some(::std::mem::take(&mut self.$field).len())
            }

            fn from_wire(header: &$header, cells: &[$cell]) -> Result<Self, $crate::Refusal> {
                $from_wire(header, cells)
            }
        }
    };
}
