//! Output format of commands.

use std::fmt;
use std::str::FromStr;

use contract::spelling::did_you_mean;

/// Whether a command prints text for people or JSON for programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Format {
    /// Text for a terminal.
    #[default]
    Text,
    /// One JSON object, or one per line if the command reports continuously.
    Json,
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Format::Text => "text",
            Format::Json => "json",
        })
    }
}

impl FromStr for Format {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "text" => Ok(Format::Text),
            "json" => Ok(Format::Json),
            _ => {
                let meant = did_you_mean(text, ["text", "json"]);
                Err(format!("a format is text or json, got {text:?}{meant}"))
            }
        }
    }
}
