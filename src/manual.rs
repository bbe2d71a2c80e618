//! What the command line says of itself: completions for shells, manual pages.

use std::io::Write;
use std::path::PathBuf;

use clap_complete::Shell;
use node::{Exit, Failure};

/// Arguments of `hopper completions`.
#[derive(clap::Args, Clone, Debug)]
#[command(after_help = "Examples:
  hopper completions bash > ~/.local/share/bash-completion/completions/hopper
  hopper completions zsh > ~/.zfunc/_hopper
  hopper completions fish > ~/.config/fish/completions/hopper.fish")]
pub struct Completions {
    /// The shell.
    shell: Shell,
}

/// Arguments of `hopper man`.
#[derive(clap::Args, Clone, Debug)]
#[command(after_help = "Examples:
  hopper man | man -l -
  hopper man --out ~/.local/share/man/man1")]
pub struct Man {
    /// Write the page of every command to this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Prints the completions of `command` for a shell.
///
/// # Errors
/// If standard output is closed.
pub fn completions(args: &Completions, mut command: clap::Command) -> Result<Exit, Failure> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut command, "hopper", &mut text);
    print(&text)
}

/// Prints the manual page of `command`, or writes those of all its commands.
///
/// # Errors
/// If the folder cannot be written, or standard output is closed.
pub fn man(args: &Man, command: clap::Command) -> Result<Exit, Failure> {
    let Some(dir) = &args.out else {
        let mut text = Vec::new();
        clap_mangen::Man::new(command).render(&mut text)?;
        return print(&text);
    };
    let written = std::fs::create_dir_all(dir).and_then(|()| clap_mangen::generate_to(command, dir));
    written.map(|()| Exit::Done).map_err(|error| {
        Failure::new(Exit::Usage, format!("--out {} cannot be written: {error}", dir.display()))
    })
}

/// Whoever reads no further has what they wanted.
fn print(text: &[u8]) -> Result<Exit, Failure> {
    match std::io::stdout().write_all(text) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(Failure::run(error)),
        _ => Ok(Exit::Done),
    }
}
