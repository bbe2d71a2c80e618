//! `hopper known`: repeats Sakamoto & Kubota 2022, which plans on fully known ground.

pub mod findings;
pub mod plan;
pub mod search;

use node::{Exit, Failure};

/// Planning on fully known ground.
#[derive(clap::Subcommand, Clone, Debug)]
pub enum Command {
    /// Repeat every plan of the paper, and report which of its claims hold.
    Findings(findings::Args),
    /// Plan one experiment at one weight: policy, path, and the ground along it.
    Plan(plan::Args),
    /// Search for the reading of what the paper leaves open that reproduces most of it; takes minutes.
    Search(search::Args),
}

/// Runs the command.
///
/// # Errors
/// Exit code 2 for a wrong flag; 1 if files cannot be written.
pub fn run(command: &Command) -> Result<Exit, Failure> {
    match command {
        Command::Findings(args) => findings::run(args),
        Command::Plan(args) => plan::run(args),
        Command::Search(args) => search::run(args),
    }
}

/// A table in the format asked for.
pub(crate) fn table<const COLUMNS: usize>(
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
fn heading(form: Form, words: &str) -> String {
    match form {
        Form::Markdown => format!("## {words}\n\n"),
        Form::Text | Form::Json => format!("{words}\n"),
    }
}

/// Writes `files` into `dir`, which is created if it does not exist.
fn write_out<'a>(dir: &Path, files: impl IntoIterator<Item = (String, &'a str)>) -> Result<(), Failure> {
    fs::create_dir_all(dir)
        .map_err(|error| Failure::usage(format!("--out {} cannot be made: {error}", dir.display())))?;
    for (name, text) in files {
        let path = dir.join(name);
        fs::write(&path, text)
            .map_err(|error| Failure::run(format!("{} cannot be written: {error}", path.display())))?;
    }
    Ok(())
}
