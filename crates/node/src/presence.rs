//! Who belongs to an instance, and the tidying up by whoever leaves last.
//!
//! Every process of an instance holds a shared `flock` on one file in its folder. The kernel gives it back
//! when the process dies, however it dies. Who can turn it into an exclusive lock is alone, and removes what
//! is left: at entering, leftovers of those who died; at leaving, everything. A newcomer who meanwhile
//! opened the file that was just removed notices that the path no longer leads to it, and begins anew.

use std::fs::{self, File};
use std::io::ErrorKind;
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt};
use std::path::Path;
use std::time::{Duration, Instant};

use iceoryx2::prelude::{CallbackProgression, Node, NodeState, ipc};
use rustix::fs::{FlockOperation, flock};
use rustix::io::Errno;

use crate::NodeError;
use crate::instance::{Cleaned, Instance};

/// File whose lock tells who lives.
const LOCK: &str = "presence.lock";

/// How long to wait for another's tidying up.
const PATIENCE: Duration = Duration::from_secs(5);

/// How often a leaver looks whether it is the last: somebody may be looking at the very same moment.
const FAREWELLS: usize = 4;

/// Membership of an instance, for as long as it is held.
#[derive(Debug)]
pub(crate) struct Presence {
    lock: File,
    instance: Instance,
}

impl Presence {
    /// Enters the instance, creating its folder if need be. Who enters first finds it empty: leftovers of
    /// the dead are removed.
    pub(crate) fn enter(instance: &Instance) -> Result<Self, NodeError> {
        let (lock, alone) = acquire(instance, true)?;
        // From here on whoever fails leaves as everybody does.
        let presence = Self { lock, instance: instance.clone() };
        if alone {
            wipe(instance)?;
            instance.check_elsewhere()?;
            instance.label()?;
        }
        let path = instance.root().join(LOCK);
        // Between giving up the exclusive lock and having the shared one, another may have come first.
        if alone && !try_flock(&presence.lock, FlockOperation::NonBlockingLockShared, &path)? {
            drop(presence);
            return Self::enter(instance);
        }
        instance.label()?;
        Ok(presence)
    }

    /// Removes everything of an instance without live processes.
    pub(crate) fn clean(instance: &Instance) -> Result<Cleaned, NodeError> {
        let (lock, alone) = acquire(instance, true)?;
        if !alone || lives(instance)? {
            return Ok(Cleaned::Alive);
        }
        let (files, bytes) = wipe(instance)?;
        remove_root(instance);
        drop(lock);
        Ok(Cleaned::Removed { files, bytes })
    }

    /// Whether a process of the instance lives.
    pub(crate) fn is_alive(instance: &Instance) -> Result<bool, NodeError> {
        if !instance.exists() {
            return Ok(false);
        }
        match acquire(instance, false) {
            Ok((_lock, alone)) => Ok(!alone),
            Err(NodeError::System { source, .. }) if source.kind() == ErrorKind::NotFound => Ok(false),
            Err(error) => Err(error),
        }
    }

    fn leave(&self) -> Result<(), NodeError> {
        let path = self.instance.root().join(LOCK);
        for attempt in 0..FAREWELLS {
            if attempt > 0 {
                std::thread::sleep(Duration::from_millis(1));
            }
            if !is_current(&self.lock, &path) {
                return Ok(());
            }
            if try_flock(&self.lock, FlockOperation::NonBlockingLockExclusive, &path)? {
                if is_current(&self.lock, &path) {
                    wipe(&self.instance)?;
                    remove_root(&self.instance);
                }
                return Ok(());
            }
        }
        Ok(())
    }
}

impl Drop for Presence {
    fn drop(&mut self) {
        if let Err(error) = self.leave() {
            tracing::warn!("could not tidy up behind the last process: {error}");
        }
        unlock(&self.lock);
    }
}

/// The lock file of the instance, locked: exclusively and alone (`true`), or shared with others (`false`).
fn acquire(instance: &Instance, create: bool) -> Result<(File, bool), NodeError> {
    let path = instance.root().join(LOCK);
    let started = Instant::now();
    while started.elapsed() < PATIENCE {
        if create {
            make_root(instance)?;
        }
        let opened = fs::OpenOptions::new()
            .read(true)
            .write(true)
            .create(create)
            .truncate(false)
            .mode(0o600)
            .open(&path);
        let lock = match opened {
            Ok(lock) => lock,
            // The last process has just left and taken the folder with it.
            Err(error) if error.kind() == ErrorKind::NotFound && create => continue,
            Err(error) => return Err(NodeError::system("open", &path, error)),
        };
        for (operation, alone) in
            [(FlockOperation::NonBlockingLockExclusive, true), (FlockOperation::NonBlockingLockShared, false)]
        {
            if try_flock(&lock, operation, &path)? && is_current(&lock, &path) {
                return Ok((lock, alone));
            }
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    Err(NodeError::Busy { root: instance.root().into(), waited_s: PATIENCE.as_secs_f64() })
}

fn make_root(instance: &Instance) -> Result<(), NodeError> {
    let root = instance.root();
    match fs::DirBuilder::new().mode(0o700).create(root) {
        Ok(()) => {}
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
        Err(error) => return Err(NodeError::system("create", root, error)),
    }
    match fs::symlink_metadata(root) {
        Ok(data) if data.is_dir() && data.uid() == instance.user() => Ok(()),
        Ok(data) => Err(NodeError::ForeignRoot { root: root.into(), need: instance.user(), got: data.uid() }),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        Err(error) => Err(NodeError::system("inspect", root, error)),
    }
}

/// Takes or changes a lock; `false` if others stand against it.
pub(crate) fn try_flock(file: &File, operation: FlockOperation, path: &Path) -> Result<bool, NodeError> {
    loop {
        match flock(file, operation) {
            Ok(()) => return Ok(true),
            Err(Errno::WOULDBLOCK) => return Ok(false),
            Err(Errno::INTR) => {}
            Err(error) => return Err(NodeError::system("lock", path, error)),
        }
    }
}

/// Whether somebody lives in a folder that is not ours to enter.
pub(crate) fn is_held(root: &Path) -> Result<bool, NodeError> {
    let path = root.join(LOCK);
    let Ok(lock) = File::open(&path) else { return Ok(false) };
    let held = !try_flock(&lock, FlockOperation::NonBlockingLockExclusive, &path)?;
    unlock(&lock);
    Ok(held)
}

/// Gives up a lock. Closing the file would not do: a child that another thread has forked and that has not
/// yet come to its exec holds the very same open file, and the lock with it.
pub(crate) fn unlock(file: &File) {
    let _ = flock(file, FlockOperation::Unlock);
}

/// Whether the path still leads to this very file.
fn is_current(file: &File, path: &Path) -> bool {
    let identity = |data: fs::Metadata| (data.dev(), data.ino());
    match (file.metadata(), fs::metadata(path)) {
        (Ok(ours), Ok(theirs)) => identity(ours) == identity(theirs),
        _ => false,
    }
}

/// Whether the middleware knows a live node, besides all locks.
fn lives(instance: &Instance) -> Result<bool, NodeError> {
    let mut alive = false;
    Node::<ipc::Service>::list(&instance.config(), |state| {
        alive |= matches!(state, NodeState::Alive(_));
        CallbackProgression::Continue
    })
    .map_err(|error| NodeError::Middleware { what: "listing nodes", cause: error.to_string() })?;
    Ok(alive)
}

/// Removes all but the lock file; the caller holds it exclusively. Returns files and bytes.
fn wipe(instance: &Instance) -> Result<(usize, u64), NodeError> {
    let (mut count, mut bytes) = (0, 0);
    for (path, size) in instance.files() {
        removed(&path, fs::remove_file(&path))?;
        count += 1;
        bytes += size;
    }
    for entry in fs::read_dir(instance.root()).into_iter().flatten().flatten() {
        let path = entry.path();
        if entry.file_name() == LOCK {
            continue;
        }
        count += 1;
        let is_dir = entry.file_type().is_ok_and(|kind| kind.is_dir());
        if is_dir {
            removed(&path, fs::remove_dir_all(&path))?;
        } else {
            removed(&path, fs::remove_file(&path))?;
        }
    }
    Ok((count, bytes))
}

/// What is gone already is as good as removed.
fn removed(path: &Path, result: std::io::Result<()>) -> Result<(), NodeError> {
    match result {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(NodeError::system("remove", path, error)),
        _ => Ok(()),
    }
}

/// Removes the lock file, then the folder unless a newcomer has already begun anew in it.
fn remove_root(instance: &Instance) {
    let _ = fs::remove_file(instance.root().join(LOCK));
    let _ = fs::remove_dir(instance.root());
}
