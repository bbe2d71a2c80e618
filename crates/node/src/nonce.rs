//! Random numbers that name a run or a life; nothing an engine computes depends on them.

use contract::{Incarnation, RunId};
use rustix::rand::{GetRandomFlags, getrandom};

use crate::error::NodeError;

fn random<const N: usize>() -> Result<[u8; N], NodeError> {
    let mut bytes = [0; N];
    let mut filled = 0;
    while filled < N {
        match getrandom(&mut bytes[filled..], GetRandomFlags::empty()) {
            Ok(count) => filled += count,
            Err(rustix::io::Errno::INTR) => {}
            Err(error) => return Err(NodeError::system("read", "getrandom".as_ref(), error)),
        }
    }
    Ok(bytes)
}

/// A run's nonce, never zero.
///
/// # Errors
/// If the kernel has no random numbers.
pub fn random_run() -> Result<RunId, NodeError> {
    Ok(RunId(u128::from_le_bytes(random()?).max(1)))
}

/// A life's nonce, never zero.
pub(crate) fn random_incarnation() -> Result<Incarnation, NodeError> {
    Ok(Incarnation(u64::from_le_bytes(random()?).max(1)))
}
