//! `hopper`: the four processes of the stack and the commands around them in one executable.

use std::process::ExitCode;

fn main() -> ExitCode {
    hopper::cli::main()
}
