//! The process shell: the only user of iceoryx2, clocks, signals, heartbeats and lifelines.
//!
//! An [`Instance`] is one mission's corner of shared memory. A process joins it as a [`Node`] and makes
//! typed ports from it: writers publish domain types, readers hand out `Result<Domain, Refusal>` of a private
//! copy. A work loop waits, looks at its readers, lets its engine decide, publishes, and beats:
//!
//! ```no_run
//! use contract::{Decision, Name, RobotId, Role, RunId, Status, service};
//! use node::peer::TICK;
//! use node::{Instance, Node};
//!
//! # fn main() -> Result<(), node::NodeError> {
//! let robot = RobotId(0);
//! let mut node = Node::join(&Instance::new("mission-7")?, Role::Monitor, Name::NONE)?;
//! node.listen(&service::state(robot))?;
//! let mut states = node.state_reader(robot)?;
//! while node.stop_requested().is_none() {
//!     node.wait(TICK);
//!     if let Some(Ok(state)) = states.newest() {
//!         node.beat(state.run, state.decision, state.status)?;
//!     }
//! }
//! # Ok(())
//! # }
//! ```
//!
//! What a process leaves behind is freed by the others' janitors; who leaves last removes everything.

mod base;
mod clock;
mod crash;
mod edition;
mod error;
mod exchange;
mod exit;
pub mod host;
pub mod inspect;
mod instance;
mod janitor;
mod log;
mod message;
mod node;
mod nonce;
mod on_demand;
mod parcel;
pub mod peer;
mod port;
mod presence;
pub mod relay;
mod room;
mod scaffold;
mod undertaker;
mod vigil;

pub use clock::now;
pub use crash::crash_point;
pub use error::NodeError;
pub use exchange::{
    Client, PastClient, PastServer, Server, SnapshotClient, SnapshotServer, TruthClient, TruthServer,
};
pub use exit::{Exit, Failure, main};
pub use instance::{Claim, Cleaned, Instance, SHARED_MEMORY};
pub use log::{hold_log_back, log_to_stderr};
pub use message::{Plain, Question, Sheet};
pub use node::{Node, Wake, version};
pub use nonce::random_run;
pub use on_demand::{OnDemand, PolicyPort};
pub use port::{
    BriefReader, BriefWriter, CommandReader, CommandWriter, ControlReader, ControlWriter, HeartbeatReader,
    HeartbeatWriter, MapReader, MapWriter, PolicyReader, PolicyWriter, Reader, SheetReader, SheetWriter,
    StateReader, StateWriter, TempoReader, TempoWriter, Writer,
};
pub use room::{Room, ServiceRoom, free_bytes};
pub use vigil::{Stop, Vigil};
