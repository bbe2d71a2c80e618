//! Where a simulated process runs, whichever life it is in.

use std::future::Future;
use std::pin::Pin;
use std::rc::Rc;

use contract::Role;
use process::{Exit, Failure};

use crate::life::Life;
use crate::setup::Seat;

/// A place for one process, whichever life it is in.
pub(super) struct Slot {
    pub role: Role,
    pub seat: Option<Seat>,
    pub takeover: bool,
    pub blind: bool,
    pub foreign: bool,
    pub succeeds_pid: Option<u32>,
    pub process: Option<Running>,
}

/// The work loop of one life, from its start to its end.
pub(super) type WorkLoop = Pin<Box<dyn Future<Output = Result<Exit, Failure>>>>;

pub(super) struct Running {
    pub life: Rc<Life>,
    pub work: WorkLoop,
}

impl Slot {
    pub fn of(role: Role) -> Self {
        let (seat, succeeds_pid, process) = (None, None, None);
        Self { role, seat, takeover: false, blind: false, foreign: false, succeeds_pid, process }
    }

    pub fn of_planner(seat: Seat) -> Self {
        Self { seat: Some(seat), ..Self::of(Role::Planner) }
    }
}
