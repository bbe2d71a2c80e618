//! The mission on a terminal, down to eighty columns by twenty-four rows.
//!
//! [`picture`] draws the history: no terminal in it. [`shell`] has the terminal.

pub mod picture;
pub mod shell;

pub use picture::{KeyAction, ViewSettings, draw};
pub use shell::Terminal;
