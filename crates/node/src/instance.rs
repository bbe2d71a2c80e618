//! One mission's corner of shared memory: its name, its folder, its lock.
//!
//! Everything an instance owns is either in its folder `/dev/shm/hop_<tag>/` or a file beside it whose
//! name begins with `hop_<tag>_`; the tag hashes the user and the instance's name, so that instances and
//! users never meet. Who belongs to an instance holds a shared lock on a file in the folder for as long as
//! it lives (module `presence`); whoever gets that lock exclusively has thereby proved that nobody lives.

use std::collections::BTreeSet;
use std::fs;
use std::io::{ErrorKind, Read, Seek, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::time::Duration;

use contract::Role;
use iceoryx2::prelude::{Config, FileName, SemanticString};
use rustix::fs::FlockOperation;
use xxhash_rust::xxh3::xxh3_64;

use crate::NodeError;
use crate::edition::Edition;
use crate::presence::{self, Presence, try_flock, unlock};

/// The file system that holds everything.
pub const SHARED_MEMORY: &str = "/dev/shm";

/// Longest name of an instance, characters.
pub const NAME_MAX: usize = 64;

/// File in the folder that says whose it is: name, user, build, one a line.
const LABEL: &str = "instance";

/// What every name of ours in shared memory begins with.
const PREFIX: &str = "hop_";

/// Hexadecimal digits of a tag.
const TAG_DIGITS: usize = 12;

/// The name of one mission's corner of shared memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Instance {
    name: String,
    user: u32,
    tag: String,
    root: PathBuf,
}

/// What [`Instance::clean`] did.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Cleaned {
    /// There was nothing to remove.
    Nothing,
    /// A process of the instance lives; nothing was touched.
    Alive,
    /// Leftovers are gone.
    Removed {
        /// Files removed.
        files: usize,
        /// Bytes given back.
        bytes: u64,
    },
}

impl Instance {
    /// The instance `name` of this user. Nothing is created yet.
    ///
    /// # Errors
    /// If the name is empty, longer than 64 characters, or has other than printable ASCII.
    pub fn new(name: &str) -> Result<Self, NodeError> {
        if name.is_empty() || name.len() > NAME_MAX || !name.bytes().all(|byte| byte.is_ascii_graphic()) {
            return Err(NodeError::InstanceName { max: NAME_MAX, got: name.into() });
        }
        let user = rustix::process::getuid().as_raw();
        let tag = tag(user, name);
        let root = Path::new(SHARED_MEMORY).join(format!("{PREFIX}{tag}"));
        Ok(Self { name: name.into(), user, tag, root })
    }

    /// Every instance of this user that has a folder or files, live or left over, in order of names.
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
            Self { name: read_label(&root).map_or_else(|| "?".into(), |label| label.name), user, tag, root }
        };
        let mut found: Vec<_> = tags.into_iter().map(instance).collect();
        found.sort_by(|a, b| a.name.cmp(&b.name));
        Ok(found)
    }

    /// The name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The folder.
    #[must_use]
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Whether the folder is there, be it of live processes or left over.
    #[must_use]
    pub fn exists(&self) -> bool {
        self.root.is_dir()
    }

    /// Whether a process of the instance lives: proved by its locks.
    ///
    /// # Errors
    /// If the locks cannot be asked.
    pub fn is_alive(&self) -> Result<bool, NodeError> {
        Presence::is_alive(self)
    }

    /// Claims what only one process of the instance may be, until the claim is dropped or its holder dies.
    ///
    /// # Errors
    /// [`NodeError::Held`] names the process that holds it.
    pub fn claim(&self, role: Role) -> Result<Claim, NodeError> {
        let presence = Presence::enter(self)?;
        let path = self.root.join(format!("{role}.lock"));
        let open = |error| NodeError::system("open", &path, error);
        let mut lock = fs::OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .mode(0o600)
            .open(&path)
            .map_err(open)?;
        // The holder writes its number right after it got the lock: give it a moment to do so.
        for _ in 0..50 {
            if try_flock(&lock, FlockOperation::NonBlockingLockExclusive, &path)? {
                let write = |error| NodeError::system("write", &path, error);
                lock.set_len(0).map_err(write)?;
                writeln!(lock, "{}", std::process::id()).map_err(write)?;
                return Ok(Claim { lock, _presence: presence });
            }
            let mut text = String::new();
            lock.rewind().and_then(|()| lock.read_to_string(&mut text)).map_err(open)?;
            if let Ok(pid) = text.trim().parse() {
                return Err(NodeError::Held { instance: self.name.clone(), role, holder: Some(pid) });
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        Err(NodeError::Held { instance: self.name.clone(), role, holder: None })
    }

    /// Removes everything of the instance if, and only if, no process of it lives: proved by its locks,
    /// never by age.
    ///
    /// # Errors
    /// If a file cannot be removed, or the folder belongs to somebody else.
    pub fn clean(&self) -> Result<Cleaned, NodeError> {
        if !self.exists() && self.files().is_empty() {
            return Ok(Cleaned::Nothing);
        }
        Presence::clean(self)
    }

    /// Everything in shared memory that bears this instance's tag, be it of live processes or left over.
    ///
    /// # Errors
    /// If shared memory cannot be listed.
    pub fn traces(&self) -> Result<Vec<PathBuf>, NodeError> {
        let entries = fs::read_dir(SHARED_MEMORY)
            .map_err(|error| NodeError::system("list", SHARED_MEMORY.as_ref(), error))?;
        let ours = |name: &str| tag_of(name) == Some(&self.tag);
        let mut traces: Vec<PathBuf> = entries
            .flatten()
            .filter(|entry| entry.file_name().to_str().is_some_and(ours))
            .map(|entry| entry.path())
            .collect();
        traces.sort();
        Ok(traces)
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

    /// The middleware makes one file, its count of nodes, writable for everybody: it becomes ours alone.
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

    pub(crate) fn user(&self) -> u32 {
        self.user
    }

    /// Another user who has an instance of this name, which this user may not enter. Its folder's name
    /// tells, although the folder is closed.
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

    /// Writes the label if it is missing, else holds it against our name and our build.
    pub(crate) fn label(&self) -> Result<(), NodeError> {
        let own = Edition::own();
        match read_label(&self.root) {
            Some(label) if label.name != self.name => Err(NodeError::Collision {
                root: self.root.clone(),
                need: self.name.clone(),
                got: label.name,
            }),
            Some(label) if label.edition.as_ref() == Some(&own) => Ok(()),
            Some(label) => Err(NodeError::Edition {
                instance: self.name.clone(),
                need: label.edition_text(),
                got: own.to_string(),
            }),
            None => {
                // Renamed into place, so that nobody reads half of it.
                let draft = self.root.join(format!("{LABEL}.{}", std::process::id()));
                let written = fs::OpenOptions::new()
                    .write(true)
                    .create(true)
                    .truncate(true)
                    .mode(0o600)
                    .open(&draft)
                    .and_then(|mut file| write!(file, "{}\n{}\n{own}\n", self.name, self.user));
                written
                    .and_then(|()| fs::rename(&draft, self.root.join(LABEL)))
                    .map_err(|error| NodeError::system("write", &draft, error))
            }
        }
    }

    /// Refuses if another build, which names folders in another way, keeps this very instance elsewhere: we
    /// would wait for each other in vain.
    pub(crate) fn check_elsewhere(&self) -> Result<(), NodeError> {
        for entry in fs::read_dir(SHARED_MEMORY).into_iter().flatten().flatten() {
            let (root, data) = (entry.path(), entry.metadata());
            if root == self.root || !data.is_ok_and(|data| data.is_dir() && data.uid() == self.user) {
                continue;
            }
            let Some(label) = read_label(&root) else { continue };
            if label.name == self.name && label.user == Some(self.user) && presence::is_held(&root)? {
                return Err(NodeError::Elsewhere {
                    instance: self.name.clone(),
                    edition: label.edition_text(),
                    own: Edition::own().to_string(),
                    need: root,
                    got: self.root.clone(),
                });
            }
        }
        Ok(())
    }

    pub(crate) fn prefix(&self) -> String {
        format!("{PREFIX}{}_", self.tag)
    }

    /// The middleware's configuration: nothing of it from files, nothing outside the instance.
    pub(crate) fn config(&self) -> Config {
        let mut config = Config::default();
        let root = self.root.to_str().expect("the root is made of ASCII");
        let path = iceoryx2::prelude::Path::new(root.as_bytes()).expect("the root is a short absolute path");
        config.global.set_root_path(&path);
        config.global.prefix =
            FileName::new(self.prefix().as_bytes()).expect("the prefix is made of hexadecimal digits");
        // We see to the dead ourselves; what is made under the scaffold's lock shall not wait for it.
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

/// The tag of a user's instance.
fn tag(user: u32, name: &str) -> String {
    let mut tag = format!("{:016x}", xxh3_64(format!("{user}/{name}").as_bytes()));
    tag.truncate(TAG_DIGITS);
    tag
}

/// Whose a folder is.
struct Label {
    name: String,
    user: Option<u32>,
    /// A build older than editions tells none.
    edition: Option<Edition>,
}

impl Label {
    fn edition_text(&self) -> String {
        self.edition
            .as_ref()
            .map_or_else(|| "an older build that does not tell its version".into(), ToString::to_string)
    }
}

fn read_label(root: &Path) -> Option<Label> {
    let text = fs::read_to_string(root.join(LABEL)).ok()?;
    let mut lines = text.lines();
    Some(Label {
        name: lines.next()?.to_owned(),
        user: lines.next().and_then(|line| line.parse().ok()),
        edition: lines.next().and_then(|line| line.parse().ok()),
    })
}

/// Proof that this process alone plays a role in its instance.
#[derive(Debug)]
pub struct Claim {
    lock: fs::File,
    _presence: Presence,
}

impl Drop for Claim {
    fn drop(&mut self) {
        // An emptied file names nobody to who comes next.
        let _ = self.lock.set_len(0);
        unlock(&self.lock);
    }
}
