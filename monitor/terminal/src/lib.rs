//! The mission on a terminal, down to eighty columns by twenty-four rows.
//!
//! [`picture`] lays out the history, `map` and `side` draw its two halves: no terminal in them. [`shell`] has the terminal.

mod layer;
mod legend;
mod map;
mod moment;
pub mod picture;
pub mod scrollback;
pub mod shell;
mod side;
mod style;
mod view_settings;

pub use picture::draw;
pub use shell::Terminal;
pub use view_settings::ViewSettings;

use node::Failure;

/// Takes the terminal over, for [`monitor::shell::Extensions`].
///
/// # Errors
/// If standard output is no terminal.
pub fn open(control: bool) -> Result<Box<dyn monitor::Screen>, Failure> {
    Ok(Box::new(Terminal::open(control)?))
}
