//! Commands of `hopper` that are served by programs of their own.
//!
//! What only some users need is not built with `cargo run --release`, which so stays short: recordings, reproductions,
//! quality rigs, the manual. Each such program is a package. `hopper COMMAND …` replaces itself with the program of
//! that command, which stands in the same folder as `hopper` and gets the same arguments.

use std::ffi::{OsStr, OsString};
use std::os::unix::process::CommandExt as _;
use std::path::PathBuf;
use std::process::{Command, ExitCode};

use node::{Exit, Failure};

/// Programs and the commands they serve. A program has the name of its package.
pub const TOOLS: [(&str, &[&str]); 8] = [
    ("hopper-dynamics", &["motion", "validate"]),
    // Commands that draw run it themselves, for PDF.
    ("hopper-figures", &["gif"]),
    ("hopper-recordings", &["bag", "latency"]),
    // `hopper campaign` runs it itself, for campaigns that name a study.
    ("hopper-research", &["coverage", "gallery", "known", "scouting"]),
    ("hopper-qa", &["chaos", "endure", "simulate"]),
    // `hopper monitor` runs it itself, for --tui, --record and --foxglove.
    ("hopper-view", &[]),
    ("hopper-link", &["link"]),
    ("hopper-manual", &["completions", "man"]),
];

/// Which build of `hopper` called, for the program that it calls.
const CALLER: &str = "HOPPER_CALLER";

/// What tells one build from another: release, commit, and a hash of the sources that decide results.
const BUILD: &str =
    concat!(env!("CARGO_PKG_VERSION"), " ", env!("HOPPER_COMMIT"), " ", env!("HOPPER_SOURCES"));

/// Arguments of a command that another program serves, passed on as they are.
#[derive(clap::Args, Clone, Debug)]
pub struct Passed {
    /// Arguments of the program; `--help` lists them.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<OsString>,
}

/// The program that serves `command`, if it is another than `hopper`.
#[must_use]
pub fn serving(command: &str) -> Option<&'static str> {
    TOOLS.iter().find(|(_, commands)| commands.contains(&command)).map(|(program, _)| *program)
}

/// Replaces this process with the program that serves `command`.
///
/// # Errors
/// Exit code 2 if the program is not there, with the command that builds it.
///
/// # Panics
/// If no program serves `command`.
pub fn run(command: &str, passed: &Passed) -> Result<Exit, Failure> {
    let program = serving(command).expect("a command of a tool");
    let arguments =
        std::iter::once(OsStr::new(command)).chain(passed.arguments.iter().map(OsString::as_os_str));
    exec(program, arguments)
}

/// The program and its arguments that answer `hopper help COMMAND …`, if another program serves that command.
#[must_use]
pub fn help(mut words: impl Iterator<Item = OsString>) -> Option<(&'static str, Vec<OsString>)> {
    words.next().filter(|word| word == "help")?;
    let words: Vec<OsString> = words.chain([OsString::from("--help")]).collect();
    Some((serving(words[0].to_str()?)?, words))
}

/// Replaces this process with `program`, which keeps its process number, standard streams and exit code.
///
/// # Errors
/// Exit code 2 if the program is not there, with the command that builds it.
pub fn exec(program: &str, arguments: impl IntoIterator<Item: AsRef<OsStr>>) -> Result<Exit, Failure> {
    let path = sibling(program)?;
    let error = Command::new(&path).args(arguments).env(CALLER, BUILD).exec();
    Err(Failure::run(format!("{} cannot be started: {error}", path.display())))
}

/// The program `name` in the folder of this one.
///
/// # Errors
/// Exit code 2 if it is not there.
pub fn sibling(name: &str) -> Result<PathBuf, Failure> {
    let path = std::env::current_exe().map_err(Failure::run)?.with_file_name(name);
    if !path.is_file() {
        return Err(Failure::usage(format!(
            "this needs the program {}, which is not there: build it with `cargo build --release -p {name}`",
            path.display()
        )));
    }
    Ok(path)
}

/// `main` of a tool: as that of `hopper`, with a warning if the two are of different builds.
pub fn main(role: &str, run: impl FnOnce() -> Result<Exit, Failure>) -> ExitCode {
    node::main(role, || {
        if let Ok(caller) = std::env::var(CALLER)
            && caller != BUILD
        {
            tracing::warn!(
                "this program is of build {BUILD}, hopper of build {caller}: `cargo build --release` builds both anew"
            );
        }
        run()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn help_of_a_command_of_another_program_is_asked_of_that_program() {
        let asked = |words: &str| help(words.split_whitespace().map(OsString::from));
        assert_eq!(
            asked("help bag info"),
            Some(("hopper-recordings", ["bag", "info", "--help"].map(OsString::from).to_vec()))
        );
        assert_eq!(
            asked("help gif"),
            Some(("hopper-figures", ["gif", "--help"].map(OsString::from).to_vec()))
        );
        for own in ["help", "help run", "bag info", ""] {
            assert_eq!(asked(own), None, "{own}");
        }
    }
}
