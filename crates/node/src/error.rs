//! What can go wrong between a process and the middleware.

use std::path::{Path, PathBuf};

use contract::Role;
use process::{Exit, Failure};

use crate::lock_holder::LockHolder;
use crate::shared_memory::SHARED_MEMORY;

/// Why a process could not join, open a port, or send.
#[derive(Debug, thiserror::Error)]
pub enum NodeError {
    /// The instance's name cannot be used.
    #[error(
        "an instance needs a name of 1 to {max} printable ASCII characters without spaces, the first no hyphen, got {got:?}"
    )]
    InstanceName {
        /// Most characters that a name may have.
        max: usize,
        /// The name asked for.
        got: String,
    },
    /// The instance's folder belongs to another user.
    #[error("{root} needs to be a folder of user {need}, got one of user {got}")]
    ForeignRoot {
        /// Folder of the instance.
        root: PathBuf,
        /// Number of our user.
        need: u32,
        /// Number of its owner.
        got: u32,
    },
    /// A file of another user bears the instance's name.
    #[error(
        "{file} bears the name of instance {instance:?} of user {need}, and is not used: remove it with `hopper doctor \
         --instance {instance} --clean`, which its owner and root may do, or name another --instance"
    )]
    ForeignFile {
        /// The file, in shared memory, and its owner.
        file: String,
        /// Number of our user.
        need: u32,
        /// Name of the instance.
        instance: String,
    },
    /// Two names share one folder.
    #[error("{root} needs to hold instance {need:?}, got {got:?}; choose another name")]
    Collision {
        /// Folder of the instance.
        root: PathBuf,
        /// The name that this process asked for.
        need: String,
        /// The name in the folder's label.
        got: String,
    },
    /// Processes of another build live in the instance.
    #[error(
        "instance {instance:?} is run by {need}, this process is {got}: run all processes of an instance from one \
         build"
    )]
    OtherBuild {
        /// Name of the instance.
        instance: String,
        /// The build of the processes that live in the instance.
        need: String,
        /// The build of this process.
        got: String,
    },
    /// Another build keeps the same instance elsewhere.
    #[error(
        "instance {instance:?} of this user lives in {need}, run by {build}, and this process ({own_build}) would \
         look in {got}: run all processes of an instance from one build"
    )]
    Elsewhere {
        /// Name of the instance.
        instance: String,
        /// Folder in which the instance lives.
        need: PathBuf,
        /// Folder in which this process would look for the instance.
        got: PathBuf,
        /// The build of the processes that live in the instance.
        build: String,
        /// The build of this process.
        own_build: String,
    },
    /// Another process makes or removes something in the instance and does not finish; it may be stopped.
    #[error(
        "{path} needs to be free for a moment, and has been held for {waited_s} s by {}",
        holder.as_ref().map_or("another process".into(), ToString::to_string)
    )]
    Busy {
        /// Lock file of the instance.
        path: PathBuf,
        /// Time that was waited for it, seconds.
        waited_s: f64,
        /// The process that holds it, if it can be seen.
        holder: Option<Box<LockHolder>>,
    },
    /// This process is to stop, and was still waiting for another.
    #[error("interrupted while waiting for another process of the instance")]
    Interrupted,
    /// Another process has a role that only one may have.
    #[error("instance {instance:?} needs one {role}, and process {} is it", holder.map_or("unknown".into(), |pid| pid.to_string()))]
    Held {
        /// Name of the instance.
        instance: String,
        /// The role that is taken.
        role: Role,
        /// Process number of the holder, if it has written it down.
        holder: Option<u32>,
    },
    /// The service exists with another type or quality of service.
    #[error("service {service} needs {need}, got {got}; are all processes of one version?")]
    Mismatch {
        /// Name of the service.
        service: String,
        /// What this process opens it with.
        need: String,
        /// What it was created with.
        got: String,
    },
    /// The service or port could not be opened in time.
    #[error("service {service}: {what} needs to succeed within {waited_s} s, last got {cause}")]
    Open {
        /// Name of the service.
        service: String,
        /// The step that failed, such as `publishing`.
        what: &'static str,
        /// Time spent on trying, seconds.
        waited_s: f64,
        /// The middleware's last error.
        cause: String,
    },
    /// Every place of the service is taken.
    #[error(
        "service {service} needs a free place for {what}, but all are taken: end a process that has one, or name another \
         --instance; `hopper doctor` lists the processes"
    )]
    Full {
        /// Name of the service.
        service: String,
        /// What the place is for, such as `publishing`.
        what: &'static str,
    },
    /// A message has more cells than its writer was made for.
    #[error("service {service} needs at most {need} cells in a message, got {got}")]
    Oversize {
        /// Name of the service.
        service: String,
        /// Cells the writer was made for.
        need: usize,
        /// Cells of the message.
        got: usize,
    },
    /// A message could not be handed over.
    #[error("service {service} needs room for a message, got {cause}")]
    Send {
        /// Name of the service.
        service: String,
        /// What iceoryx2 answered.
        cause: String,
    },
    /// Shared memory is too small.
    #[error(
        "{what} needs {need_bytes} bytes of shared memory, got {free_bytes} free in {}: free some, or enlarge it (in \
         a container, --shm-size)",
        SHARED_MEMORY
    )]
    NoRoom {
        /// Who needs it, such as `joining as planner`.
        what: String,
        /// Bytes that it needs.
        need_bytes: u64,
        /// Bytes free in `/dev/shm` when it was asked for.
        free_bytes: u64,
    },
    /// The operating system refused.
    #[error("{what} {path}: {source}")]
    System {
        /// What was tried, as a verb such as `open`.
        what: &'static str,
        /// The file it was tried on.
        path: PathBuf,
        /// What the operating system answered.
        source: std::io::Error,
    },
    /// The middleware could not be listed or asked.
    #[error("{what} needs to succeed, got {cause}")]
    Middleware {
        /// The step that failed, such as `listing nodes`.
        what: &'static str,
        /// What iceoryx2 answered.
        cause: String,
    },
}

impl NodeError {
    pub(crate) fn system(what: &'static str, path: &Path, source: impl Into<std::io::Error>) -> Self {
        Self::System { what, path: path.into(), source: source.into() }
    }

    /// The exit code of a process that ends on this.
    #[must_use]
    pub fn exit(&self) -> Exit {
        match self {
            Self::InstanceName { .. } => Exit::Usage,
            Self::Interrupted => Exit::Interrupted,
            Self::Held { .. }
            | Self::Full { .. }
            | Self::Mismatch { .. }
            | Self::Collision { .. }
            | Self::OtherBuild { .. }
            | Self::Elsewhere { .. }
            | Self::ForeignRoot { .. }
            | Self::ForeignFile { .. } => Exit::Peer,
            _ => Exit::Failed,
        }
    }
}

impl From<NodeError> for Failure {
    fn from(error: NodeError) -> Self {
        Self::new(error.exit(), error.to_string())
    }
}
