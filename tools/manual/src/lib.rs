//! Shell completions and manual pages of `hopper`, its tools included.

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use clap::{CommandFactory, Subcommand};
use clap_complete::Shell;
use contract::Profile;
use hopper::stdout::print;
use node::{Exit, Failure};

/// The commands of `hopper` that this package serves.
#[derive(Subcommand, Clone, Debug)]
pub enum Command {
    /// Print the completions for a shell.
    Completions(Completions),
    /// Print the manual page, or write those of all commands to a folder.
    Man(Man),
}

/// Arguments of `hopper completions`.
#[derive(clap::Args, Clone, Debug)]
#[command(after_help = "Examples:
  hopper completions bash > ~/.local/share/bash-completion/completions/hopper
  hopper completions zsh > ~/.zfunc/_hopper
  hopper completions fish > ~/.config/fish/completions/hopper.fish")]
pub struct Completions {
    /// Shell to print them for.
    shell: Shell,
}

/// Arguments of `hopper man`.
#[derive(clap::Args, Clone, Debug)]
#[command(after_help = "Examples:
  hopper man | man -l -
  hopper man --out ~/.local/share/man/man1")]
pub struct Man {
    /// Write the page of every command to this folder.
    #[arg(long, value_name = "DIR", value_parser = node::output_path())]
    out: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// Exit code 2 if the folder cannot be written; 1 if standard output cannot.
pub fn run(command: &Command) -> Result<Exit, Failure> {
    let hopper = hopper_command();
    let mut text = Vec::new();
    match command {
        Command::Completions(Completions { shell }) => {
            let mut hopper = completed(hopper);
            clap_complete::generate(*shell, &mut hopper, "hopper", &mut text);
            text = with_files(&String::from_utf8_lossy(&text)).into_bytes();
        }
        Command::Man(Man { out: None }) => {
            clap_mangen::Man::new(hopper).render(&mut text).map_err(Failure::run)?
        }
        Command::Man(Man { out: Some(dir) }) => {
            let written = std::fs::create_dir_all(dir).and_then(|()| clap_mangen::generate_to(hopper, dir));
            written.map_err(|error| {
                Failure::usage(format!("--out {} cannot be written: {error}", dir.display()))
            })?;
            tracing::info!("wrote the page of every command to {}", dir.display());
        }
    }
    print(&String::from_utf8_lossy(&text))?;
    Ok(Exit::Done)
}

/// The command line of `hopper` with that of every tool in its place.
#[must_use]
pub fn hopper_command() -> clap::Command {
    let tools = [
        hopper_dynamics::Command::augment_subcommands(clap::Command::new("hopper-dynamics")),
        hopper_figures::Command::augment_subcommands(clap::Command::new("hopper-figures")),
        hopper_recordings::Command::augment_subcommands(clap::Command::new("hopper-recordings")),
        hopper_research::Command::augment_subcommands(clap::Command::new("hopper-research")),
        hopper_qa::Command::augment_subcommands(clap::Command::new("hopper-qa")),
        Command::augment_subcommands(clap::Command::new("hopper-manual")),
    ];
    let mut hopper = hopper::cli::Cli::command();
    for tool in tools {
        // What is for developers alone is not served by `hopper`.
        let served_by_hopper: Vec<_> = tool
            .get_subcommands()
            .filter(|command| !command.is_hide_set() && hopper.find_subcommand(command.get_name()).is_some())
            .collect();
        for command in served_by_hopper {
            let about =
                hopper.find_subcommand(command.get_name()).and_then(clap::Command::get_about).cloned();
            // In the list of commands it keeps the name of its program.
            let served = command.clone().about(about.unwrap_or_default());
            hopper = hopper.mut_subcommand(command.get_name(), |_| served);
        }
    }
    hopper
}

/// The names of built-in scenarios.
fn scenarios() -> Vec<&'static str> {
    scenario::BUILT_IN.into_iter().map(|(name, _)| name).collect()
}

/// The names of built-in campaigns.
fn campaigns() -> Vec<&'static str> {
    hopper::commands::campaign::BUILT_IN.into_iter().map(|(name, _)| name).collect()
}

/// The names of all planners, whatever mission they are for.
fn algorithms() -> impl Iterator<Item = &'static str> {
    let all =
        [planner::ALGORITHMS, planner::COVER_ALGORITHMS, planner::DRIVE_ALGORITHMS, planner::FLY_ALGORITHMS];
    all.into_iter().flatten().copied()
}

/// The command line with the values that its arguments know, for shells to offer. It is for completions only: what the
/// arguments accept is wider.
fn completed(command: clap::Command) -> clap::Command {
    let name = command.get_name().to_owned();
    let command = command.mut_args(|argument| {
        let values = match (name.as_str(), argument.get_id().as_str()) {
            (_, "scenario") => scenarios(),
            ("run", "file") => campaigns(),
            (_, "planner") => algorithms().chain([planner::CLAIRVOYANT]).collect(),
            (_, "algorithm") => algorithms().collect(),
            (_, "profile") => Profile::ALL.map(Profile::as_str).into(),
            (_, "pace") => vec!["max", "real", "3600x"],
            (_, "topic") => hopper::commands::topic::names(),
            _ => return argument,
        };
        argument.value_parser(PossibleValuesParser::new(values))
    });
    command.mut_subcommands(completed)
}

/// The completions with files beside the names where an argument takes either.
fn with_files(completions: &str) -> String {
    [scenarios(), campaigns()].iter().fold(completions.to_owned(), |text, names| {
        let (list, first) = (names.join(" "), names[0]);
        text.replace(&format!("compgen -W \"{list}\""), &format!("compgen -f -W \"{list}\""))
            .replace(&format!(":({list})"), &format!(":{{_files; compadd {list}}}"))
            .replace(&format!(" -r -f -a \"{first}\\t"), &format!(" -r -F -a \"{first}\\t"))
    })
}
