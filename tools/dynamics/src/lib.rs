//! What physics says of hops: tables of landings, and figures beside what has flown.

pub mod derive;
mod drawing;
pub mod hopper_on;
pub mod landing_table;
pub mod validate;

use clap::Subcommand;
use hopper::progress::while_working;
use node::{Exit, Failure};

/// The commands of `hopper` that this package serves.
#[derive(Subcommand, Clone, Debug)]
pub enum Command {
    /// Derive what planners may believe of hops from physics.
    #[command(
        subcommand,
        after_help = derive::EXAMPLES
    )]
    Motion(MotionCommand),
    /// Compare contact dynamics with closed forms and with what has been measured and flown.
    #[command(after_help = "Examples:\n  hopper validate\n  hopper validate --format json")]
    Validate(validate::Args),
}

/// Commands of `hopper motion`.
#[derive(Subcommand, Clone, Debug)]
pub enum MotionCommand {
    /// Fly a body over planes and write where its hops end, by soil and slope.
    Derive(derive::Args),
}

/// Runs the command.
///
/// # Errors
/// Those of the command.
pub fn run(command: &Command) -> Result<Exit, Failure> {
    match command {
        Command::Motion(MotionCommand::Derive(args)) => {
            while_working("flying over planes", || derive::run(args))
        }
        Command::Validate(args) => while_working("flying what has flown", || validate::run(args)),
    }
}
