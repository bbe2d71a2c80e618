//! One process at a time makes nodes, services and ports, so that what is half-made is a dead one's.
//!
//! The middleware marks a file of its own as unfinished by its mode and waits for whoever is at it. If that
//! process was killed, everybody waits in vain; and if the file is an empty shared memory and we are root,
//! without a time limit (iceoryx2 0.10, `posix_shared_memory::Builder::open_impl`: an empty mapping is tried
//! again and again). So we make things under a lock of the instance. The kernel takes it from the dead, and
//! whoever has it removes what is unfinished before making anything.
//!
//! Connections between two ports are the exception: they are made whenever the ports meet, outside of the
//! lock. An unfinished one is removed when one of its ports is known to be dead: then nobody needs it.

use std::fs::{self, File};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use iceoryx2::identifiers::UniqueNodeId;
use iceoryx2::prelude::Config;
use rustix::fs::FlockOperation;

use crate::presence::try_flock;
use crate::undertaker::folder;
use crate::{Instance, NodeError, SHARED_MEMORY};

/// File whose lock is the right to make things.
const LOCK: &str = "scaffold.lock";

/// Mode of a service's description, or of a node's tag for a service or port, until it is complete.
const STORAGE_UNFINISHED: u32 = 0o600;

/// Mode of a node's context file, or of a shared memory, until it is complete.
const MEMORY_UNFINISHED: u32 = 0o200;

/// Ending of the shared memory between two ports; its name holds the numbers of both.
const CONNECTION: &str = ".connection";

/// The lock.
#[derive(Debug)]
pub(crate) struct Scaffold {
    lock: File,
    root: PathBuf,
    prefix: String,
}

/// The right to make things, and to remove what is unfinished.
#[derive(Debug)]
pub(crate) struct Hold<'a>(&'a Scaffold);

impl Scaffold {
    /// The caller belongs to the instance.
    pub(crate) fn open(instance: &Instance) -> Result<Self, NodeError> {
        let path = instance.root().join(LOCK);
        let opened = fs::OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .mode(0o600)
            .open(&path);
        let lock = opened.map_err(|error| NodeError::system("open", &path, error))?;
        Ok(Self { lock, root: instance.root().into(), prefix: instance.prefix() })
    }

    /// Waits for the right, at most as long as `patience` lasts; making one thing takes milliseconds.
    pub(crate) fn hold(&self, patience: Duration) -> Result<Hold<'_>, NodeError> {
        let started = Instant::now();
        loop {
            if let Some(hold) = self.try_hold()? {
                return Ok(hold);
            }
            if started.elapsed() > patience {
                return Err(NodeError::Busy { root: self.root.clone(), waited_s: patience.as_secs_f64() });
            }
            std::thread::sleep(Duration::from_micros(500));
        }
    }

    /// Takes the right if nobody has it.
    pub(crate) fn try_hold(&self) -> Result<Option<Hold<'_>>, NodeError> {
        let operation = FlockOperation::NonBlockingLockExclusive;
        Ok(try_flock(&self.lock, operation, &self.root.join(LOCK))?.then(|| Hold(self)))
    }
}

impl Hold<'_> {
    /// Removes what the dead left unfinished; returns how many files.
    pub(crate) fn clear_unfinished(&self) -> usize {
        let mut removed = 0;
        for path in files(SHARED_MEMORY.as_ref(), "", MEMORY_UNFINISHED) {
            let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
            if name.starts_with(&self.0.prefix) && !name.ends_with(CONNECTION) {
                removed += remove(&path);
            }
        }
        for path in files(&self.0.root.join("services"), ".service", STORAGE_UNFINISHED) {
            removed += remove(&path);
        }
        for context in files(&self.0.root.join("nodes"), ".node_monitor_context", MEMORY_UNFINISHED) {
            let text = context.to_string_lossy();
            let state = text.trim_end_matches("_context");
            // The context goes last: without it, nobody would know of the others.
            for path in [state.into(), PathBuf::from(format!("{state}_owner_lock")), context.clone()] {
                removed += remove(&path);
            }
        }
        removed
    }
}

impl Drop for Hold<'_> {
    fn drop(&mut self) {
        let _ = try_flock(&self.0.lock, FlockOperation::Unlock, &self.0.root);
    }
}

/// Removes what a dead node left unfinished, its connections and its tags: what would hold up whoever frees
/// it, or keep its folder from being removed. Only the node itself makes tags, and before what they stand
/// for; a connection with one dead end is of no use, whoever is at it.
pub(crate) fn clear_dead(config: &Config, dead: &UniqueNodeId) {
    let prefix = config.global.prefix.to_string();
    let folder = folder(config, dead);
    // A port's tag is named after its number, finished or not.
    let ports: Vec<String> = fs::read_dir(&folder)
        .into_iter()
        .flatten()
        .flatten()
        .filter_map(|entry| {
            Some(entry.file_name().to_str()?.strip_prefix(&prefix)?.strip_suffix(".port_tag")?.to_owned())
        })
        .collect();
    for path in files(SHARED_MEMORY.as_ref(), CONNECTION, MEMORY_UNFINISHED) {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let ends = name.trim_end_matches(CONNECTION).rsplit('_').take(2);
        if name.starts_with(&prefix) && ends.into_iter().any(|end| ports.iter().any(|port| port == end)) {
            remove(&path);
        }
    }
    for path in files(&folder, "_tag", STORAGE_UNFINISHED) {
        remove(&path);
    }
}

/// Files in `folder` of that ending and that mode. They are not opened: closing one would give back the
/// locks that this very process holds on it.
fn files(folder: &Path, ending: &str, mode: u32) -> Vec<PathBuf> {
    fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .filter(|entry| entry.file_name().to_str().is_some_and(|name| name.ends_with(ending)))
        .filter(|entry| entry.metadata().is_ok_and(|data| data.mode() & 0o777 == mode))
        .map(|entry| entry.path())
        .collect()
}

fn remove(path: &Path) -> usize {
    let removed = fs::remove_file(path).is_ok();
    if removed {
        tracing::debug!("removed what a dead process left unfinished: {}", path.display());
    }
    usize::from(removed)
}
