//! Roles that only one process of an instance may have.

use std::fs;
use std::io::{Read, Seek, Write};
use std::time::Duration;

use contract::Role;
use rustix::fs::FlockOperation;

use super::instance::Instance;
use super::lock::{MembershipLock, waiting};
use crate::error::NodeError;
use crate::file_lock::{try_flock, unlock};
use crate::private_file::owner_only;
use crate::waiting::{Joining, Waiting};

/// Proof that this process alone has a role in its instance.
#[derive(Debug)]
pub struct Claim {
    lock: fs::File,
    _membership: MembershipLock,
}

impl Drop for Claim {
    fn drop(&mut self) {
        // An empty file names no holder to the next process.
        let _ = self.lock.set_len(0);
        unlock(&self.lock);
    }
}

impl Instance {
    /// Claims a role that only one process of the instance may have, until the claim is dropped or its holder dies.
    ///
    /// # Errors
    /// [`NodeError::Held`] names the process that holds it.
    pub fn claim(&self, role: Role) -> Result<Claim, NodeError> {
        self.claim_after(role, &waiting())
    }

    /// As [`Instance::claim`], waiting as patiently as a process that joins, and for no longer than until a signal comes.
    ///
    /// # Errors
    /// As [`Instance::claim`].
    pub fn claim_patiently(&self, role: Role, joining: Joining) -> Result<Claim, NodeError> {
        self.claim_after(role, &joining.waiting()?)
    }

    fn claim_after(&self, role: Role, waiting: &Waiting) -> Result<Claim, NodeError> {
        let membership = MembershipLock::enter(self, waiting)?;
        let path = self.root().join(format!("{role}.lock"));
        let open = |error| NodeError::system("open", &path, error);
        let mut lock = owner_only(0o600).create(true).truncate(false).open(&path).map_err(open)?;
        // The holder writes its process number right after it got the lock: give it a moment to do so.
        for _ in 0..50 {
            if try_flock(&lock, FlockOperation::NonBlockingLockExclusive, &path)? {
                let write = |error| NodeError::system("write", &path, error);
                lock.set_len(0).map_err(write)?;
                writeln!(lock, "{}", std::process::id()).map_err(write)?;
                return Ok(Claim { lock, _membership: membership });
            }
            let mut text = String::new();
            lock.rewind().and_then(|()| lock.read_to_string(&mut text)).map_err(open)?;
            if let Ok(pid) = text.trim().parse() {
                return Err(NodeError::Held { instance: self.name().into(), role, holder: Some(pid) });
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        Err(NodeError::Held { instance: self.name().into(), role, holder: None })
    }
}
