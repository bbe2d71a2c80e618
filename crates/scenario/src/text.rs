//! Bounded reading of text files, and short messages about their faults.

use std::ffi::OsString;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use contract::spelling::did_you_mean;

use crate::ScenarioError;

/// Longest scenario or campaign, bytes.
pub const TEXT_BYTES_MAX: u64 = 1 << 20;

/// Most files that a message names.
const FILES_NAMED_MAX: usize = 3;

/// Most entries of a folder that are looked at for a file whose name was mistyped.
const ENTRIES_MAX: usize = 1000;

/// Longest line of a TOML error message, characters.
const LINE_CHARACTERS_MAX: usize = 160;

/// The text of the file at `path`, which may be a pipe.
///
/// # Errors
/// [`ScenarioError::Read`] if it cannot be read, [`ScenarioError::NotText`] if it is not UTF-8, [`ScenarioError::TooLong`] if it holds more than
/// `bytes_max` bytes.
pub fn read(path: &Path, bytes_max: u64) -> Result<String, ScenarioError> {
    if path.is_dir() {
        let names = toml_files(path);
        let files = names.iter().take(FILES_NAMED_MAX).map(|name| path.join(name).display().to_string());
        return Err(ScenarioError::Folder { path: path.into(), files: files.collect::<Vec<_>>().join(", ") });
    }
    let unread = |source: io::Error| ScenarioError::Read { path: path.into(), source };
    let mut bytes = Vec::new();
    let mut file = File::open(path).map_err(unread)?.take(bytes_max + 1);
    file.read_to_end(&mut bytes).map_err(unread)?;
    if bytes.len() as u64 > bytes_max {
        return Err(ScenarioError::TooLong { path: path.into(), bytes_max });
    }
    String::from_utf8(bytes).map_err(|_| ScenarioError::NotText { path: path.into(), hint: place_of(path) })
}

/// The end of a sentence about a file that is no text: where one with its ending belongs.
fn place_of(path: &Path) -> &'static str {
    let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
    match ending.to_str() {
        Some("tif" | "tiff" | "asc" | "img" | "lbl") => "; an elevation model is given by --dem",
        Some("mcap") => "; `hopper view` and `hopper bag` read recordings",
        _ => "",
    }
}

/// Whether `path` is meant as a file and not as a built-in name: it has a folder or an ending.
#[must_use]
pub fn is_file_name(path: &Path) -> bool {
    path.components().count() > 1 || path.extension().is_some()
}

/// The end of a sentence about a scenario or campaign that does not exist: which built-in one or which file of the same
/// folder it resembles; empty if none.
#[must_use]
pub fn meant(path: &Path, built_in: &[&str]) -> String {
    let (Some(name), Some(folder)) = (path.file_name(), path.parent()) else { return String::new() };
    let folder_is_here = folder.as_os_str().is_empty();
    let files: Vec<String> = toml_files(if folder_is_here { Path::new(".") } else { folder })
        .into_iter()
        .map(|file| file.to_string_lossy().into_owned())
        .collect();
    let name = name.to_string_lossy();
    if let Some(file) = files.iter().find(|file| file.strip_suffix(".toml") == Some(&*name)) {
        return format!("; did you mean {file}?");
    }
    // A built-in one has no file.
    if let Some(known) = name.strip_suffix(".toml").filter(|name| built_in.contains(name)) {
        return format!("; did you mean the built-in {known}?");
    }
    let meant = did_you_mean(&name, built_in.iter().copied().chain(files.iter().map(String::as_str)));
    match meant.is_empty() {
        // A name without its ending.
        true => did_you_mean(&format!("{name}.toml"), files.iter().map(String::as_str)),
        false => meant,
    }
}

/// The names of the TOML files in a folder, sorted; none if it cannot be read.
fn toml_files(folder: &Path) -> Vec<OsString> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let names = entries.take(ENTRIES_MAX).flatten().map(|entry| entry.file_name());
    let mut names: Vec<_> = names
        .filter(|name| Path::new(name).extension().is_some_and(|extension| extension == "toml"))
        .collect();
    names.sort();
    names
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
