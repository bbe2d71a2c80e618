//! Files in shared memory that bear an instance's name and are not its user's.
//!
//! Shared memory is open to every user, and the names of some of the middleware's files can be foretold. Whoever makes
//! such a file first could read and change what this user's processes share through it, or keep them from starting. So a
//! process looks for them before it joins and after each thing it makes, and uses none.

use std::fmt;
use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::PathBuf;

use super::instance::Instance;
use crate::error::NodeError;
use crate::shared_memory::SHARED_MEMORY;

/// A file of another user, or a symbolic link, where one of an instance belongs.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct ForeignFile {
    /// Where it is.
    pub path: PathBuf,
    /// Number of the user who owns it.
    pub owner: u32,
    /// Whether it is a symbolic link.
    pub is_link: bool,
}

impl fmt::Display for ForeignFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = if self.is_link { "a symbolic link" } else { "a file" };
        write!(f, "{}, {what} of user {},", self.path.display(), self.owner)
    }
}

/// What became of a [`ForeignFile`] that was to be removed.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Removal {
    /// The file.
    #[serde(flatten)]
    pub file: ForeignFile,
    /// Why it could not be removed; `None` if it was.
    pub refused: Option<String>,
}

impl Instance {
    /// Files beside the folder that bear this instance's name and belong to another user, or are symbolic links.
    ///
    /// # Errors
    /// If shared memory cannot be listed.
    pub fn foreign_files(&self) -> Result<Vec<ForeignFile>, NodeError> {
        let entries = fs::read_dir(SHARED_MEMORY)
            .map_err(|error| NodeError::system("list", SHARED_MEMORY.as_ref(), error))?;
        let prefix = self.prefix();
        let mut foreign: Vec<_> = entries
            .flatten()
            .filter(|entry| entry.file_name().to_str().is_some_and(|name| name.starts_with(&prefix)))
            // Not followed, if it is a link.
            .filter_map(|entry| Some((entry.path(), entry.metadata().ok()?)))
            .filter(|(_, data)| data.uid() != self.user() || data.is_symlink())
            .map(|(path, data)| ForeignFile { path, owner: data.uid(), is_link: data.is_symlink() })
            .collect();
        foreign.sort_by(|a, b| a.path.cmp(&b.path));
        Ok(foreign)
    }

    /// Fails if there is any such file.
    pub(crate) fn refuse_foreign_files(&self) -> Result<(), NodeError> {
        match self.foreign_files()?.into_iter().next() {
            Some(file) => Err(NodeError::ForeignFile {
                file: file.to_string(),
                need: self.user(),
                instance: self.name().into(),
            }),
            None => Ok(()),
        }
    }

    /// Removes those files, as far as the operating system allows: root may, or the owner of a link. Nothing else of
    /// the instance is touched, and no folder is removed.
    ///
    /// # Errors
    /// If shared memory cannot be listed.
    pub fn remove_foreign_files(&self) -> Result<Vec<Removal>, NodeError> {
        let removal = |file: ForeignFile| {
            let refused = fs::remove_file(&file.path).err().map(|error| error.to_string());
            Removal { file, refused }
        };
        Ok(self.foreign_files()?.into_iter().map(removal).collect())
    }
}
