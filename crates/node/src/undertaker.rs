//! Frees what dead processes left behind, and may itself be killed at any moment.
//!
//! The middleware frees a port in two steps: it removes the port's tag, a file in the folder of its node, then it
//! gives the port's place in the service back. Whoever goes on after a death between the two takes the missing
//! tag for damage, skips the port and forgets the node: the place is lost for as long as the service lives, and
//! where there is one place only, nobody serves or writes any more (iceoryx2 0.10: in
//! `__internal_remove_node_from_service`, `AlreadyRemoved` leads to `SkipPort`). So one process at a time frees,
//! the tags of the dead are written down before any is removed, and whoever goes on makes the missing ones again;
//! what tags are left over when all ports are free, the middleware removes.

use std::fs;
use std::io::{ErrorKind, Write};
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use iceoryx2::identifiers::UniqueNodeId;
use iceoryx2::node::{DeadNodeView, NodeCleanupFailure, NodeDetails, NodeView};
use iceoryx2::prelude::{CallbackProgression, Config, Node, NodeState};
use rustix::fs::FlockOperation;

use crate::base::Ipc;
use crate::presence::{try_flock, unlock};
use crate::scaffold::clear_dead;

/// File whose lock is the right to free.
const LOCK: &str = "undertaker.lock";

/// Folder of what is written down, one file a dead node.
const RECORDS: &str = "dead";

/// Ending of a port's tag.
const PORT_TAG: &str = ".port_tag";

/// Frees what dead processes of the instance left behind; returns how many of them.
pub(crate) fn free_the_dead(config: &Config) -> usize {
    let mut freed = 0;
    let listed = Node::<Ipc>::list(config, |state| {
        if let NodeState::Dead(dead) = state {
            match free(&dead, config) {
                Ok(()) => freed += 1,
                Err(cause) => tracing::debug!("a dead process is not yet freed: {cause}"),
            }
        }
        CallbackProgression::Continue
    });
    if let Err(error) = listed {
        tracing::debug!("could not look for dead processes: {error}");
    }
    freed
}

fn free(dead: &DeadNodeView<Ipc>, config: &Config) -> Result<(), String> {
    let root = PathBuf::from(config.global.root_path().to_string());
    let text = |error: std::io::Error| error.to_string();
    let path = root.join(LOCK);
    let lock = owner_only(0o600).create(true).open(&path).map_err(text)?;
    if !try_flock(&lock, FlockOperation::NonBlockingLockExclusive, &path)
        .map_err(|error| error.to_string())?
    {
        return Err("another process is at it".into());
    }
    let record = root.join(RECORDS).join(dead.id().value().to_string());
    let freed = keep_tags(&record, &folder(config, dead.id()))
        .map_err(text)
        .and_then(|()| remove(dead, config).map_err(|error| error.to_string()));
    if freed.is_ok() {
        let _ = fs::remove_file(&record);
    }
    unlock(&lock);
    freed
}

fn remove(dead: &DeadNodeView<Ipc>, config: &Config) -> Result<(), NodeCleanupFailure> {
    clear_dead(config, dead.id());
    // Who died while it was being freed has lost its details, without which the middleware would look in
    // its default folders.
    let details = dead.details().clone().unwrap_or_else(|| NodeDetails::__internal_new(&None, config));
    DeadNodeView::<Ipc>::__internal_try_remove_stale_resources(*dead.id(), details)
}

/// The folder of a node's tags.
pub(crate) fn folder(config: &Config, node: &UniqueNodeId) -> PathBuf {
    Path::new(&config.global.node_dir().to_string()).join(node.value().to_string())
}

/// Writes down the ports' tags in `folder`; if somebody has done so before, makes those again that are missing.
fn keep_tags(record: &Path, folder: &Path) -> std::io::Result<()> {
    match fs::read_to_string(record) {
        Ok(names) => names.lines().try_for_each(|name| {
            match owner_only(0o400).create_new(true).open(folder.join(name)) {
                // It was not missing, or the node's folder is gone and with it the last of its ports.
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

fn owner_only(mode: u32) -> fs::OpenOptions {
    let mut options = fs::OpenOptions::new();
    options.write(true).mode(mode);
    options
}
