//! The ports of the real world: shared memory, the monotonic clock, signals.
//!
//! Nothing else uses iceoryx2. An [`Instance`] is one mission's part of shared memory. A process joins it as a
//! [`Node`], which opens typed ports: writers publish domain types, readers return `Result<Domain, Refusal>` of a
//! private copy. What each service carries, and how it is opened, is declared in `contract`, once.
//!
//! ```no_run
//! use contract::{RobotId, Role, State};
//! use node::{Instance, Node};
//! use process::{Ports, Reader as _, TICK_NS};
//!
//! # fn main() -> Result<(), node::NodeError> {
//! let mut node = Node::join(&Instance::new("mission-7")?, Role::Monitor)?;
//! let mut states = node.reader::<State>(RobotId(0), true)?;
//! while !node.stop_requested() {
//!     process::block_on(node.wait(TICK_NS));
//!     if let Some(Ok(state)) = states.newest() {
//!         println!("decision {}", state.decision);
//!     }
//! }
//! # Ok(())
//! # }
//! ```
//!
//! The processes that live clean up after those that died, and the last to leave removes everything.
//!
//! No modules import each other in a circle (`tests/structure.rs`).

mod cleanup;
mod clock;
mod crash;
mod error;
mod exit;
mod file_lock;
pub mod host;
pub mod inspect;
mod lock_holder;
mod log;
mod membership;
mod memory_budget;
mod middleware;
mod node;
mod nonce;
mod output_path;
pub mod peer;
mod ports;
mod private_file;
pub mod relay;
mod session;
mod shared_memory;
mod shutdown;
mod signature;
mod terminal;
mod waiting;

pub use crash::crash_point;
pub use error::NodeError;
pub use exit::main;
pub use lock_holder::LockHolder;
pub use log::{hold_log_back, log_is_readable_by_others, log_to_stderr};
pub use membership::build_id::version;
pub use membership::claim::Claim;
pub use membership::foreign::{ForeignFile, Removal};
pub use membership::instance::Instance;
pub use membership::lock::Cleaned;
pub use memory_budget::{MemoryBudget, ServiceBudget, free_bytes};
pub use node::{Node, Wake, run};
pub use nonce::random_run;
pub use output_path::{output_file_of, output_path};
pub use ports::{Client, Reader, Server, Writer};
pub use process::{Exit, Failure};
pub use shared_memory::SHARED_MEMORY;
pub use shutdown::{ShutdownSignal, StopReason};
pub use terminal::{stderr_has_colours, stderr_redraws};
pub use waiting::Joining;
