//! What the terminal on standard error can show.

use std::env;
use std::io::IsTerminal as _;

/// Whether standard error is a terminal that can redraw a line: one that is called dumb, or has no name, cannot.
#[must_use]
pub fn stderr_redraws() -> bool {
    std::io::stderr().is_terminal() && is_able(env::var_os("TERM").as_deref())
}

/// Whether standard error is a terminal that shows colours, and whose user has not switched them off
/// (<https://no-color.org>).
#[must_use]
pub fn stderr_has_colours() -> bool {
    stderr_redraws() && env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
}

fn is_able(name: Option<&std::ffi::OsStr>) -> bool {
    name.is_some_and(|name| !name.is_empty() && name != "dumb")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dumb_terminal_and_one_without_a_name_cannot_redraw() {
        for (name, able) in
            [(Some("xterm-256color"), true), (Some("dumb"), false), (Some(""), false), (None, false)]
        {
            assert_eq!(is_able(name.map(std::ffi::OsStr::new)), able, "{name:?}");
        }
    }
}
