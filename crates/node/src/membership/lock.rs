//! Who belongs to an instance, and the cleaning up by whoever leaves last.
//!
//! Every process of an instance holds a shared `flock` on one file in its folder. The kernel releases it when the
//! process dies, however it dies. A process that can turn it into an exclusive lock is alone, and removes what is
//! left: on entering, what the dead left behind; on leaving, everything. A newcomer that meanwhile opened the file
//! that was just removed notices that the path no longer leads to it, and starts over.

use std::fs::{self, File};
use std::io::ErrorKind;
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::Path;
use std::time::Duration;

use iceoryx2::prelude::{CallbackProgression, Node, NodeState};
use rustix::fs::FlockOperation;

use super::build_id::BuildId;
use super::instance::Instance;
use super::label::Label;
use crate::error::NodeError;
use crate::file_lock::{try_flock, unlock};
use crate::middleware::Ipc;
use crate::private_file::owner_only;
use crate::shared_memory::SHARED_MEMORY;
use crate::waiting::{Joining, Waiting};

/// File whose lock shows who lives. Builds of all versions lock this name, so that none takes a live instance of
/// another for a leftover.
const FILE: &str = "presence.lock";

/// How long to wait while another process cleans up, where nobody says how long.
const PATIENCE: Duration = Duration::from_secs(5);

/// How often a leaver checks whether it is the last: somebody may be looking at the same moment.
const LEAVE_TRIES: usize = 4;

/// Membership of an instance, for as long as it is held.
#[derive(Debug)]
pub(crate) struct MembershipLock {
    file: File,
    instance: Instance,
}

/// What [`Instance::clean`] found and did.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Cleaned {
    /// There was nothing to remove.
    Nothing,
    /// A process of the instance lives; nothing was touched.
    Alive,
    /// Nobody was left, and what dead processes left behind was removed.
    Removed {
        /// Files removed, in the folder and beside it.
        files: usize,
        /// Bytes of shared memory freed.
        bytes: u64,
    },
}

impl Instance {
    /// Whether a process of the instance lives: proved by its locks.
    ///
    /// # Errors
    /// If the locks cannot be asked.
    pub fn is_alive(&self) -> Result<bool, NodeError> {
        if !self.exists() {
            return Ok(false);
        }
        check_root(self)?;
        match acquire(self, false, &waiting()) {
            Ok((_lock, alone)) => Ok(!alone),
            Err(NodeError::System { source, .. }) if source.kind() == ErrorKind::NotFound => Ok(false),
            Err(error) => Err(error),
        }
    }

    /// Removes everything of the instance if, and only if, no process of it lives: proved by its locks, never by age.
    ///
    /// # Errors
    /// If a file cannot be removed, or the folder belongs to another user.
    pub fn clean(&self) -> Result<Cleaned, NodeError> {
        self.clean_up(&waiting())
    }

    /// As [`Instance::clean`], waiting as patiently as a process that joins, and for no longer than until a signal comes.
    ///
    /// # Errors
    /// As [`Instance::clean`].
    pub fn clean_patiently(&self, joining: Joining) -> Result<Cleaned, NodeError> {
        self.clean_up(&joining.waiting()?)
    }

    fn clean_up(&self, waiting: &Waiting) -> Result<Cleaned, NodeError> {
        if !self.exists() && self.files().is_empty() {
            return Ok(Cleaned::Nothing);
        }
        let (lock, alone) = acquire(self, true, waiting)?;
        if !alone || has_live_node(self)? {
            return Ok(Cleaned::Alive);
        }
        let (files, bytes) = wipe(self)?;
        remove_root(self);
        drop(lock);
        Ok(Cleaned::Removed { files, bytes })
    }
}

impl MembershipLock {
    /// Enters the instance, creating its folder if need be. The first to enter removes what the dead left behind.
    pub(crate) fn enter(instance: &Instance, waiting: &Waiting) -> Result<Self, NodeError> {
        let (file, alone) = acquire(instance, true, waiting)?;
        // Whoever fails from here on leaves like everybody else.
        let membership = Self { file, instance: instance.clone() };
        if alone {
            wipe(instance)?;
            check_elsewhere(instance)?;
            check_label(instance)?;
        }
        let path = instance.root().join(FILE);
        // Between releasing the exclusive lock and taking the shared one, another process may come first.
        if alone && !try_flock(&membership.file, FlockOperation::NonBlockingLockShared, &path)? {
            drop(membership);
            return Self::enter(instance, waiting);
        }
        check_label(instance)?;
        instance.refuse_foreign_files()?;
        Ok(membership)
    }

    fn leave(&self) -> Result<(), NodeError> {
        let path = self.instance.root().join(FILE);
        for attempt in 0..LEAVE_TRIES {
            if attempt > 0 {
                std::thread::sleep(Duration::from_millis(1));
            }
            if !is_current(&self.file, &path) {
                return Ok(());
            }
            if try_flock(&self.file, FlockOperation::NonBlockingLockExclusive, &path)? {
                if is_current(&self.file, &path) {
                    wipe(&self.instance)?;
                    remove_root(&self.instance);
                }
                return Ok(());
            }
        }
        Ok(())
    }
}

impl Drop for MembershipLock {
    fn drop(&mut self) {
        if let Err(error) = self.leave() {
            tracing::warn!("could not clean up behind the last process: {error}");
        }
        unlock(&self.file);
    }
}

/// The wait of whoever does not say how long it waits.
pub(super) fn waiting() -> Waiting {
    Waiting::new(PATIENCE, None)
}

/// Writes the label if it is missing, otherwise compares it with our name and our build.
fn check_label(instance: &Instance) -> Result<(), NodeError> {
    let (root, own) = (instance.root(), BuildId::own());
    match Label::read(root) {
        None => Label::write(root, instance.name(), instance.user(), &own),
        Some(label) if label.name != instance.name() => {
            Err(NodeError::Collision { root: root.into(), need: instance.name().into(), got: label.name })
        }
        Some(label) if label.build.as_ref() == Some(&own) => Ok(()),
        Some(label) => Err(NodeError::OtherBuild {
            instance: instance.name().into(),
            need: label.build_text(),
            got: own.to_string(),
        }),
    }
}

/// Refuses if another build, which names folders in another way, keeps this very instance elsewhere: both would wait
/// for each other in vain.
fn check_elsewhere(instance: &Instance) -> Result<(), NodeError> {
    for entry in fs::read_dir(SHARED_MEMORY).into_iter().flatten().flatten() {
        let (root, data) = (entry.path(), entry.metadata());
        if root == instance.root() || !data.is_ok_and(|data| data.is_dir() && data.uid() == instance.user()) {
            continue;
        }
        let Some(label) = Label::read(&root) else { continue };
        if label.name == instance.name() && label.user == Some(instance.user()) && is_held(&root)? {
            return Err(NodeError::Elsewhere {
                instance: instance.name().into(),
                build: label.build_text(),
                own_build: BuildId::own().to_string(),
                need: root,
                got: instance.root().into(),
            });
        }
    }
    Ok(())
}

/// The lock file of the instance, locked: exclusively and alone (`true`), or shared with others (`false`).
fn acquire(instance: &Instance, create: bool, waiting: &Waiting) -> Result<(File, bool), NodeError> {
    let path = instance.root().join(FILE);
    waiting.until(&path, Duration::from_millis(1), || {
        if create {
            make_root(instance)?;
        }
        let opened = owner_only(0o600).create(create).truncate(false).open(&path);
        let lock = match opened {
            Ok(lock) => lock,
            // The last process has just left and removed the folder.
            Err(error) if error.kind() == ErrorKind::NotFound && create => return Ok(None),
            Err(error) => return Err(NodeError::system("open", &path, error)),
        };
        for (operation, alone) in
            [(FlockOperation::NonBlockingLockExclusive, true), (FlockOperation::NonBlockingLockShared, false)]
        {
            if try_flock(&lock, operation, &path)? && is_current(&lock, &path) {
                return Ok(Some((lock, alone)));
            }
        }
        Ok(None)
    })
}

fn make_root(instance: &Instance) -> Result<(), NodeError> {
    let root = instance.root();
    match fs::DirBuilder::new().mode(0o700).create(root) {
        Ok(()) => {}
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
        Err(error) => return Err(NodeError::system("create", root, error)),
    }
    check_root(instance)
}

/// Refuses what stands in the place of the instance's folder and is none of this user's.
fn check_root(instance: &Instance) -> Result<(), NodeError> {
    let root = instance.root();
    match fs::symlink_metadata(root) {
        Ok(data) if data.is_dir() && data.uid() == instance.user() => Ok(()),
        Ok(data) => Err(NodeError::ForeignRoot { root: root.into(), need: instance.user(), got: data.uid() }),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        Err(error) => Err(NodeError::system("inspect", root, error)),
    }
}

/// Whether a process lives in a folder that may be another build's.
fn is_held(root: &Path) -> Result<bool, NodeError> {
    let path = root.join(FILE);
    let Ok(lock) = File::open(&path) else { return Ok(false) };
    let held = !try_flock(&lock, FlockOperation::NonBlockingLockExclusive, &path)?;
    unlock(&lock);
    Ok(held)
}

/// Whether the path still leads to this very file.
fn is_current(file: &File, path: &Path) -> bool {
    let identity = |data: fs::Metadata| (data.dev(), data.ino());
    match (file.metadata(), fs::metadata(path)) {
        (Ok(ours), Ok(theirs)) => identity(ours) == identity(theirs),
        _ => false,
    }
}

/// Whether the middleware knows a live node, whatever the locks say.
fn has_live_node(instance: &Instance) -> Result<bool, NodeError> {
    let mut alive = false;
    Node::<Ipc>::list(&instance.config(), |state| {
        alive |= matches!(state, NodeState::Alive(_));
        CallbackProgression::Continue
    })
    .map_err(|error| NodeError::Middleware { what: "listing nodes", cause: error.to_string() })?;
    Ok(alive)
}

/// Removes all but the lock file, which the caller holds exclusively. Returns files and bytes.
fn wipe(instance: &Instance) -> Result<(usize, u64), NodeError> {
    let (mut count, mut bytes) = (0, 0);
    for (path, size) in instance.files() {
        removed(&path, fs::remove_file(&path))?;
        count += 1;
        bytes += size;
    }
    for entry in fs::read_dir(instance.root()).into_iter().flatten().flatten() {
        let path = entry.path();
        if entry.file_name() == FILE {
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

/// A file that is gone already counts as removed.
fn removed(path: &Path, result: std::io::Result<()>) -> Result<(), NodeError> {
    match result {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(NodeError::system("remove", path, error)),
        _ => Ok(()),
    }
}

/// Removes the lock file, then the folder unless a newcomer has already started over in it.
fn remove_root(instance: &Instance) {
    let _ = fs::remove_file(instance.root().join(FILE));
    let _ = fs::remove_dir(instance.root());
}
