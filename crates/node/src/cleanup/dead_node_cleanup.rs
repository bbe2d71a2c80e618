//! Frees what dead processes left behind, and may itself be killed at any moment.
//!
//! The middleware frees a port in two steps: it removes the port's tag, a file in the folder of its node, then it
//! releases the port's place in the service. A process that continues after a death between the two takes the missing
//! tag for damage, skips the port and forgets the node: the place is lost for as long as the service lives, and where
//! there is only one place, nobody can serve or write any more (iceoryx2 0.10: in
//! `__internal_remove_node_from_service`, `AlreadyRemoved` leads to `SkipPort`). So one process at a time cleans up;
//! it records the tags of the dead before it removes any, and a process that continues recreates the missing ones. The
//! middleware removes the tags that are left when all ports are free.

use std::fs;
use std::io::{ErrorKind, Write};
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};

use iceoryx2::node::{DeadNodeView, NodeCleanupFailure, NodeDetails, NodeView};
use iceoryx2::prelude::{CallbackProgression, Config, Node, NodeState};
use rustix::fs::FlockOperation;

use super::unfinished::{self, PORT_TAG, node_folder};
use crate::file_lock::{try_flock, unlock};
use crate::middleware::Ipc;
use crate::private_file::owner_only;

/// File whose lock is the right to clean up.
pub(super) const LOCK: &str = "cleanup.lock";

/// Folder of the recorded tags, one file a dead node.
const RECORDS: &str = "dead";

/// Frees what dead processes of the instance left behind; returns how many processes that were.
pub(crate) fn clean_up_dead_nodes(config: &Config) -> usize {
    let mut freed = 0;
    let listed = Node::<Ipc>::list(config, |state| {
        if let NodeState::Dead(dead) = state {
            match clean_up(&dead, config) {
                Ok(()) => freed += 1,
                Err(cause) => tracing::debug!("a dead process is not yet cleaned up: {cause}"),
            }
        }
        CallbackProgression::Continue
    });
    if let Err(error) = listed {
        tracing::debug!("could not look for dead processes: {error}");
    }
    freed
}

fn clean_up(dead: &DeadNodeView<Ipc>, config: &Config) -> Result<(), String> {
    let root = PathBuf::from(config.global.root_path().to_string());
    let text = |error: std::io::Error| error.to_string();
    let path = root.join(LOCK);
    let lock = owner_only(0o600).create(true).open(&path).map_err(text)?;
    if !try_flock(&lock, FlockOperation::NonBlockingLockExclusive, &path)
        .map_err(|error| error.to_string())?
    {
        return Err("another process is cleaning up".into());
    }
    let record = root.join(RECORDS).join(dead.id().value().to_string());
    let freed = keep_tags(&record, &node_folder(config, dead.id()))
        .map_err(text)
        .and_then(|()| remove(dead, config).map_err(|error| error.to_string()));
    if freed.is_ok() {
        let _ = fs::remove_file(&record);
    }
    unlock(&lock);
    freed
}

fn remove(dead: &DeadNodeView<Ipc>, config: &Config) -> Result<(), NodeCleanupFailure> {
    unfinished::remove_of_dead_node(config, dead.id());
    // A process that died while it was cleaned up after has lost its details, without which the middleware would
    // look in its default folders.
    let details = dead.details().clone().unwrap_or_else(|| NodeDetails::__internal_new(&None, config));
    DeadNodeView::<Ipc>::__internal_try_remove_stale_resources(*dead.id(), details)
}

/// Records the ports' tags in `folder`; if they are recorded already, recreates those that are missing.
fn keep_tags(record: &Path, folder: &Path) -> std::io::Result<()> {
    match fs::read_to_string(record) {
        Ok(names) => names.lines().try_for_each(|name| {
            match owner_only(0o400).create_new(true).open(folder.join(name)) {
                // It was not missing, or the node's folder is gone, and the last of its ports with it.
                Err(error) if !matches!(error.kind(), ErrorKind::AlreadyExists | ErrorKind::NotFound) => {
                    Err(error)
                }
                _ => Ok(()),
            }
        }),
        Err(error) if error.kind() == ErrorKind::NotFound => {
            let names = tags(folder);
            if names.is_empty() {
                return Ok(());
            }
            if let Some(records) = record.parent() {
                fs::DirBuilder::new().recursive(true).mode(0o700).create(records)?;
            }
            // Renamed into place, so that nobody reads half of it.
            let draft = record.with_extension(std::process::id().to_string());
            owner_only(0o600)
                .create(true)
                .truncate(true)
                .open(&draft)?
                .write_all(names.join("\n").as_bytes())?;
            fs::rename(&draft, record)
        }
        Err(error) => Err(error),
    }
}

/// Names of the ports' tags in `folder`.
fn tags(folder: &Path) -> Vec<String> {
    fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .filter_map(|entry| entry.file_name().into_string().ok())
        .filter(|name| name.ends_with(PORT_TAG))
        .collect()
}
