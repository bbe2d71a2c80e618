//! Figures that need more than text: animations and PDF.

#![warn(clippy::disallowed_methods)]

pub mod animation;
pub mod drawing;

use clap::Subcommand;
use hopper::commands::journal::DrawArgs;
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
    /// Draw a mission as PDF.
    #[command(subcommand, hide = true)]
    Journal(Journal),
}

/// What `hopper journal` passes on.
#[derive(Subcommand, Clone, Debug)]
pub enum Journal {
    /// Draw the mission again, at any hop, for screen or paper.
    Draw(DrawArgs),
}

/// Runs the command.
///
/// # Errors
/// Those of the command.
pub fn run(command: &Command) -> Result<Exit, Failure> {
    match command {
        Command::Gif(args) => while_working("drawing the mission", || animation::run(args)),
        Command::Journal(Journal::Draw(args)) => while_working("drawing the mission", || drawing::run(args)),
    }
}
