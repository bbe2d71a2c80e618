//! The formats in which the studies answer.

use std::fmt;
use std::fs;
use std::path::Path;

use hopper_sim::private_file::{self, FileError};
use node::Failure;

/// Format of an answer.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Form {
    /// Text for a terminal.
    #[default]
    Text,
    /// One JSON object.
    Json,
    /// A Markdown document.
    Markdown,
}

impl fmt::Display for Form {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Form::Text => "text",
            Form::Json => "json",
            Form::Markdown => "markdown",
        })
    }
}

/// A table in the format asked for.
pub fn table<const COLUMNS: usize>(
    form: Form,
    headings: [&str; COLUMNS],
    rows: &[[String; COLUMNS]],
) -> String {
    match form {
        Form::Markdown => ::campaign::markdown::table(headings, rows),
        Form::Text | Form::Json => report::table(headings, rows) + "\n",
    }
}

/// A heading in the format asked for.
pub fn heading(form: Form, words: &str) -> String {
    match form {
        Form::Markdown => format!("## {words}\n\n"),
        Form::Text | Form::Json => format!("{words}\n"),
    }
}

/// Writes `files` into `dir`, which is created if it does not exist.
///
/// # Errors
/// Exit code 2 if the folder cannot be created, 1 if a file cannot be written.
pub fn write_out<'a>(dir: &Path, files: impl IntoIterator<Item = (String, &'a str)>) -> Result<(), Failure> {
    fs::create_dir_all(dir)
        .map_err(|error| Failure::usage(format!("--out {} cannot be made: {error}", dir.display())))?;
    for (name, text) in files {
        let path = dir.join(name);
        private_file::write_shared(&path, text).map_err(|error| match error {
            FileError::Io { path, source, .. } => {
                Failure::run(format!("{} cannot be written: {source}", path.display()))
            }
            refused => Failure::usage(refused),
        })?;
    }
    Ok(())
}
