//! Where shared memory is.

/// The file system that holds all instances.
pub const SHARED_MEMORY: &str = "/dev/shm";
