//! The commands of `hopper` that are built into it, one file each.
//!
//! The four processes have their commands in their own packages; commands that few need are programs of their own,
//! see [`crate::tool`].

pub mod campaign;
pub mod doctor;
pub mod journal;
pub mod run;
pub mod scenario;
pub mod terrain;
pub mod topic;
pub mod view;
