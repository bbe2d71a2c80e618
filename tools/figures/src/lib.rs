//! Figures that need more than text: animations and PDF.

#![warn(clippy::disallowed_methods)]

pub mod animation;
pub mod drawing;

use clap::Subcommand;
use hopper::progress::while_working;
use node::{Exit, Failure};

/// The commands of `hopper` that this package serves.
#[derive(Subcommand, Clone, Debug)]
pub enum Command {
    /// Write an animation of a mission, of at most 5 MB.
    #[command(
        after_help = "Examples:\n  hopper gif out/hard-1\n  hopper gif out/hard-1 --out crossing.gif --width 480"
    )]
    Gif(animation::Args),
    /// Turn a picture on standard input from SVG into PDF on standard output; `hopper` does so for files that end in .pdf.
    #[command(hide = true)]
    Pdf,
}

/// Runs the command.
///
/// # Errors
/// Those of the command.
pub fn run(command: &Command) -> Result<Exit, Failure> {
    match command {
        Command::Gif(args) => while_working("drawing the mission", || animation::run(args)),
        Command::Pdf => drawing::pdf(),
    }
}
