//! Writes the fingerprints of all suites to standard output: `.ci/run` keeps them once all have passed.

#![allow(clippy::print_stdout, reason = "it is what the program is for")]

fn main() -> std::io::Result<()> {
    print!("{}", suites::passed()?);
    Ok(())
}
