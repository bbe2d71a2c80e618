//! The mission on a terminal, down to eighty columns by twenty-four rows.
//!
//! [`picture`] draws the account: no terminal in it. [`shell`] has the terminal.

pub mod picture;
pub mod shell;

pub use picture::{Knobs, draw};
pub use shell::Terminal;

use node::Failure;

/// Takes the terminal over, for [`monitor::shell::Extensions`].
///
/// # Errors
/// If standard output is no terminal.
pub fn open(control: bool) -> Result<Box<dyn monitor::Screen>, Failure> {
    Ok(Box::new(Terminal::open(control)?))
}
