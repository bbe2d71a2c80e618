//! The file in an instance's folder that says whose it is: name, user and build, one a line.

use std::fs;
use std::io::Write;
use std::path::Path;

use super::build_id::BuildId;
use crate::error::NodeError;
use crate::private_file::owner_only;

const FILE: &str = "instance";

/// What the label of a folder says.
pub(super) struct Label {
    pub(super) name: String,
    pub(super) user: Option<u32>,
    /// Older builds wrote none.
    pub(super) build: Option<BuildId>,
}

impl Label {
    /// The label in the folder `root`, if there is one.
    pub(super) fn read(root: &Path) -> Option<Self> {
        let text = fs::read_to_string(root.join(FILE)).ok()?;
        let mut lines = text.lines();
        Some(Self {
            name: lines.next()?.to_owned(),
            user: lines.next().and_then(|line| line.parse().ok()),
            build: lines.next().and_then(|line| line.parse().ok()),
        })
    }

    pub(super) fn write(root: &Path, name: &str, user: u32, build: &BuildId) -> Result<(), NodeError> {
        // Renamed into place, so that nobody reads half of it.
        let draft = root.join(format!("{FILE}.{}", std::process::id()));
        owner_only(0o600)
            .create(true)
            .truncate(true)
            .open(&draft)
            .and_then(|mut file| write!(file, "{name}\n{user}\n{build}\n"))
            .and_then(|()| fs::rename(&draft, root.join(FILE)))
            .map_err(|error| NodeError::system("write", &draft, error))
    }

    /// The build in words.
    pub(super) fn build_text(&self) -> String {
        self.build
            .as_ref()
            .map_or_else(|| "an older build that does not state its version".into(), ToString::to_string)
    }
}
