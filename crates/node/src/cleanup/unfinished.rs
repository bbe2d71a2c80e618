//! Files that the middleware had not finished when their maker died.
//!
//! The middleware marks a file of its own as unfinished by its mode, and waits for the process that makes it. If that
//! process was killed, everybody waits in vain; if the file is an empty shared memory and the waiting process is
//! root, without a time limit (iceoryx2 0.10, `posix_shared_memory::Builder::open_impl`: an empty mapping is tried
//! again and again).

use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use iceoryx2::identifiers::UniqueNodeId;
use iceoryx2::prelude::Config;

use crate::shared_memory::SHARED_MEMORY;

/// Mode of a service's description, or of a node's tag for a service or port, until it is complete.
const STORAGE_UNFINISHED: u32 = 0o600;

/// Mode of a node's context file, or of a shared memory, until it is complete.
const MEMORY_UNFINISHED: u32 = 0o200;

/// Ending of the shared memory between two ports; its name holds the numbers of both.
const CONNECTION: &str = ".connection";

/// Ending of the file that stands for a port in the folder of its node.
pub(super) const PORT_TAG: &str = ".port_tag";

/// The folder of a node's tags.
pub(super) fn node_folder(config: &Config, node: &UniqueNodeId) -> PathBuf {
    Path::new(&config.global.node_dir().to_string()).join(node.value().to_string())
}

/// Removes everything unfinished of an instance but connections, while nobody else can be making anything.
pub(super) fn remove_all(root: &Path, prefix: &str) {
    for path in files(SHARED_MEMORY.as_ref(), "", MEMORY_UNFINISHED) {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        if name.starts_with(prefix) && !name.ends_with(CONNECTION) {
            remove(&path);
        }
    }
    for path in files(&root.join("services"), ".service", STORAGE_UNFINISHED) {
        remove(&path);
    }
    for context in files(&root.join("nodes"), ".node_monitor_context", MEMORY_UNFINISHED) {
        let text = context.to_string_lossy();
        let state = text.trim_end_matches("_context");
        // The context goes last: without it, nobody would know of the others.
        for path in [state.into(), PathBuf::from(format!("{state}_owner_lock")), context.clone()] {
            remove(&path);
        }
    }
}

/// Removes what a dead node left unfinished, its connections and its tags: what would block the process that cleans
/// up after it, or keep its folder from being removed. Only the node itself makes tags, and before what they stand
/// for; a connection with one dead end is of no use, whoever is making it.
pub(super) fn remove_of_dead_node(config: &Config, dead: &UniqueNodeId) {
    let prefix = config.global.prefix.to_string();
    let folder = node_folder(config, dead);
    // A port's tag is named after its number, finished or not.
    let ports: Vec<String> = fs::read_dir(&folder)
        .into_iter()
        .flatten()
        .flatten()
        .filter_map(|entry| {
            Some(entry.file_name().to_str()?.strip_prefix(&prefix)?.strip_suffix(PORT_TAG)?.to_owned())
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

/// Files in `folder` of that ending and that mode. They are not opened: closing one would release the locks that this
/// very process holds on it.
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

fn remove(path: &Path) {
    if fs::remove_file(path).is_ok() {
        tracing::debug!("removed what a dead process left unfinished: {}", path.display());
    }
}
