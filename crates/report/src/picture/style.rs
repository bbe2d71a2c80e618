//! What a picture is drawn for.

use contract::spelling::did_you_mean;

/// How a mission is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum PictureStyle {
    /// With title, legend, and the policy over unseen ground too.
    #[default]
    Screen,
    /// For a column of a paper: no title, arrows only where the ground was seen, sand hatched, every tenth hop numbered.
    Paper,
}

impl std::fmt::Display for PictureStyle {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(match self {
            PictureStyle::Screen => "screen",
            PictureStyle::Paper => "paper",
        })
    }
}

impl std::str::FromStr for PictureStyle {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "screen" => Ok(PictureStyle::Screen),
            "paper" => Ok(PictureStyle::Paper),
            _ => {
                let meant = did_you_mean(text, ["screen", "paper"]);
                Err(format!("a picture is drawn for screen or paper, got {text:?}{meant}"))
            }
        }
    }
}
