//! An instance: the name and the files of one mission in shared memory.
//!
//! Everything an instance owns is either in its folder `/dev/shm/hop_<tag>/` or a file beside it whose name begins
//! with `hop_<tag>_`. The tag hashes the user and the instance's name, so instances and users never meet.

use std::collections::BTreeSet;
use std::fs;
use std::io::ErrorKind;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::time::Duration;

use iceoryx2::prelude::{Config, FileName, SemanticString};
use xxhash_rust::xxh3::xxh3_64;

use super::label::Label;
use crate::error::NodeError;
use crate::shared_memory::SHARED_MEMORY;

/// Longest name of an instance, characters.
pub const NAME_MAX: usize = 64;

/// Every name of ours in shared memory begins with this.
const PREFIX: &str = "hop_";

/// Hexadecimal digits of a tag.
const TAG_DIGITS: usize = 12;

/// The name of one mission's part of shared memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Instance {
    name: String,
    user: u32,
    tag: String,
    root: PathBuf,
}

impl Instance {
    /// The instance `name` of this user. Nothing is created yet.
    ///
    /// # Errors
    /// If the name is empty, longer than 64 characters, not printable ASCII without spaces, or like a flag.
    pub fn new(name: &str) -> Result<Self, NodeError> {
        let is_printable = name.bytes().all(|byte| byte.is_ascii_graphic());
        if name.is_empty() || name.len() > NAME_MAX || !is_printable || name.starts_with('-') {
            return Err(NodeError::InstanceName { max: NAME_MAX, got: name.into() });
        }
        let user = rustix::process::getuid().as_raw();
        let tag = tag(user, name);
        let root = Path::new(SHARED_MEMORY).join(format!("{PREFIX}{tag}"));
        Ok(Self { name: name.into(), user, tag, root })
    }

    /// Every instance of this user that has a folder or files, live or left over, sorted by name.
    ///
    /// # Errors
    /// If shared memory cannot be listed.
    pub fn all() -> Result<Vec<Self>, NodeError> {
        let user = rustix::process::getuid().as_raw();
        let listing = |error| NodeError::system("list", SHARED_MEMORY.as_ref(), error);
        let mut tags = BTreeSet::new();
        for entry in fs::read_dir(SHARED_MEMORY).map_err(listing)?.flatten() {
            let name = entry.file_name();
            let Some(tag) = name.to_str().and_then(tag_of) else { continue };
            if entry.metadata().is_ok_and(|data| data.uid() == user) {
                tags.insert(tag.to_owned());
            }
        }
        let instance = |tag: String| {
            let root = Path::new(SHARED_MEMORY).join(format!("{PREFIX}{tag}"));
            // A process that died while it made its folder left it without a label.
            Self { name: Label::read(&root).map_or_else(|| "?".into(), |label| label.name), user, tag, root }
        };
        let mut found: Vec<_> = tags.into_iter().map(instance).collect();
        found.sort_by(|a, b| a.name.cmp(&b.name));
        Ok(found)
    }

    /// The name, 1 to 64 printable ASCII characters; `?` if it was left without a label.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The folder that holds locks, label and the middleware's records.
    #[must_use]
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// The number of the user it belongs to.
    #[must_use]
    pub fn user(&self) -> u32 {
        self.user
    }

    /// Whether the folder exists, whether in use or left over.
    #[must_use]
    pub fn exists(&self) -> bool {
        self.root.is_dir()
    }

    /// Everything in shared memory that bears this instance's tag, the folder included, in use or left over.
    ///
    /// # Errors
    /// If shared memory cannot be listed.
    pub fn paths(&self) -> Result<Vec<PathBuf>, NodeError> {
        let entries = fs::read_dir(SHARED_MEMORY)
            .map_err(|error| NodeError::system("list", SHARED_MEMORY.as_ref(), error))?;
        let ours = |name: &str| tag_of(name) == Some(&self.tag);
        let mut paths: Vec<PathBuf> = entries
            .flatten()
            .filter(|entry| entry.file_name().to_str().is_some_and(ours))
            .map(|entry| entry.path())
            .collect();
        paths.sort();
        Ok(paths)
    }

    /// The middleware's files beside the folder: path and bytes in use.
    #[must_use]
    pub fn files(&self) -> Vec<(PathBuf, u64)> {
        let prefix = self.prefix();
        let mut files: Vec<_> = fs::read_dir(SHARED_MEMORY)
            .into_iter()
            .flatten()
            .flatten()
            .filter(|entry| entry.file_name().to_str().is_some_and(|name| name.starts_with(&prefix)))
            .filter_map(|entry| Some((entry.path(), entry.metadata().ok()?)))
            .filter(|(_, data)| data.is_file() && data.uid() == self.user)
            .map(|(path, data)| (path, data.blocks() * 512))
            .collect();
        files.sort();
        files
    }

    /// Takes other users' access away. The middleware makes one file, its count of nodes, writable for everybody.
    pub(crate) fn close_to_others(&self) -> Result<(), NodeError> {
        for (path, _) in self.files() {
            let closing = fs::symlink_metadata(&path).and_then(|data| match data.mode() & 0o077 {
                0 => Ok(()),
                _ => fs::set_permissions(&path, fs::Permissions::from_mode(0o600)),
            });
            match closing {
                Err(error) if error.kind() != ErrorKind::NotFound => {
                    return Err(NodeError::system("close to others", &path, error));
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Another user who has an instance of this name, which this user may not enter. The name of its folder shows
    /// it, although the folder is closed.
    #[must_use]
    pub fn namesake(&self) -> Option<u32> {
        let entries = fs::read_dir(SHARED_MEMORY).into_iter().flatten().flatten();
        entries.filter_map(|entry| Some((entry.file_name(), entry.metadata().ok()?))).find_map(
            |(file, data)| {
                let (user, name) = (data.uid(), file.to_str()?);
                let theirs = format!("{PREFIX}{}", tag(user, &self.name));
                (data.is_dir() && user != self.user && name == theirs).then_some(user)
            },
        )
    }

    /// Another user's instance of the same name in words, to be appended to a message; empty if there is none.
    #[must_use]
    pub fn namesake_hint(&self) -> String {
        let Some(user) = self.namesake() else { return String::new() };
        format!("; user {user} has an instance {:?} too, closed to user {}", self.name, self.user)
    }

    /// What the names of the files beside the folder begin with.
    pub(crate) fn prefix(&self) -> String {
        format!("{PREFIX}{}_", self.tag)
    }

    /// The middleware's configuration: nothing of it is read from files, and nothing is outside the instance.
    pub(crate) fn config(&self) -> Config {
        let mut config = Config::default();
        let root = self.root.to_str().expect("the root is made of ASCII");
        let path = iceoryx2::prelude::Path::new(root.as_bytes()).expect("the root is a short absolute path");
        config.global.set_root_path(&path);
        config.global.prefix =
            FileName::new(self.prefix().as_bytes()).expect("the prefix is made of hexadecimal digits");
        // The module `cleanup` cleans up; what is made under the creation lock must not wait for it.
        config.global.service.cleanup_dead_nodes_on_open = false;
        config.global.node.cleanup_dead_nodes_on_creation = false;
        config.global.node.cleanup_dead_nodes_on_destruction = false;
        config.global.creation_timeout = Duration::from_millis(500);
        config
    }
}

/// The tag in the name of a folder or file of ours: `hop_<tag>` or `hop_<tag>_…`.
fn tag_of(name: &str) -> Option<&str> {
    let (tag, rest) = name.strip_prefix(PREFIX)?.split_at_checked(TAG_DIGITS)?;
    let ours = tag.bytes().all(|byte| byte.is_ascii_hexdigit()) && (rest.is_empty() || rest.starts_with('_'));
    ours.then_some(tag)
}

fn tag(user: u32, name: &str) -> String {
    let mut tag = format!("{:016x}", xxh3_64(format!("{user}/{name}").as_bytes()));
    tag.truncate(TAG_DIGITS);
    tag
}
