//! Who belongs to an instance: its name and files, the lock that its processes hold, and the build they are of.

pub(crate) mod build_id;
pub(crate) mod claim;
pub(crate) mod foreign;
pub(crate) mod instance;
mod label;
pub(crate) mod lock;
