//! Bounded reading of text files, and short messages about their faults.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use crate::ScenarioError;

/// Longest scenario or campaign, bytes.
pub const TEXT_BYTES_MAX: u64 = 1 << 20;

/// Longest line of a TOML error message, characters.
const LINE_CHARACTERS_MAX: usize = 160;

/// The text of the file at `path`, which may be a pipe.
///
/// # Errors
/// [`ScenarioError::Read`] if it cannot be read or is not UTF-8, [`ScenarioError::TooLong`] if it holds more than
/// `bytes_max` bytes.
pub fn read(path: &Path, bytes_max: u64) -> Result<String, ScenarioError> {
    let unread = |source: io::Error| ScenarioError::Read { path: path.into(), source };
    let mut bytes = Vec::new();
    let mut file = File::open(path).map_err(unread)?.take(bytes_max + 1);
    file.read_to_end(&mut bytes).map_err(unread)?;
    if bytes.len() as u64 > bytes_max {
        return Err(ScenarioError::TooLong { path: path.into(), bytes_max });
    }
    String::from_utf8(bytes).map_err(|error| unread(io::Error::new(io::ErrorKind::InvalidData, error)))
}

/// The message of a TOML error with its lines shortened: the line it quotes may be as long as the whole text.
#[must_use]
pub fn toml_error(error: &toml::de::Error) -> String {
    let brief = |line: &str| match line.char_indices().nth(LINE_CHARACTERS_MAX) {
        Some((end, _)) => format!("{} ...", line[..end].trim_end()),
        None => line.trim_end().to_owned(),
    };
    error.to_string().trim_end().lines().map(brief).collect::<Vec<_>>().join("\n")
}
