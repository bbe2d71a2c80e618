//! The command `hopper`: missions as separate processes or in lockstep, and the tools around them.

pub mod bag;
pub mod campaign;
pub mod chaos;
pub mod child;
pub mod doctor;
pub mod endure;
pub mod gallery;
pub mod journal;
pub mod known;
pub mod latency;
pub mod manual;
pub mod moment;
pub mod outbox;
pub mod run;
pub mod scenario;
pub mod simulate;
pub mod supervisor;
pub mod terrain;
pub mod topic;

pub use simulation::lockstep;
