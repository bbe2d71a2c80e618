//! The formats in which the studies answer.

use std::fmt;

/// Format of an answer.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Form {
    /// Text for a terminal.
    #[default]
    Text,
    /// One JSON object.
    Json,
    /// A Markdown document.
    Markdown,
}

impl fmt::Display for Form {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Form::Text => "text",
            Form::Json => "json",
            Form::Markdown => "markdown",
        })
    }
}

/// A table in the format asked for.
pub fn table<const COLUMNS: usize>(
    form: Form,
    headings: [&str; COLUMNS],
    rows: &[[String; COLUMNS]],
) -> String {
    match form {
        Form::Markdown => ::campaign::markdown::table(headings, rows),
        Form::Text | Form::Json => report::table(headings, rows) + "\n",
    }
}

/// A heading in the format asked for.
pub fn heading(form: Form, words: &str) -> String {
    match form {
        Form::Markdown => format!("## {words}\n\n"),
        Form::Text | Form::Json => format!("{words}\n"),
    }
}
