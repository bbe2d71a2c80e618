//! How the model is read.

use serde::{Deserialize, Serialize};

use crate::spelling::did_you_mean;

/// Which reading of the model the mission follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Profile {
    /// Sakamoto & Kunii 2023 reproduced to the letter.
    #[serde(rename = "paper-2023")]
    Paper2023,
    /// The paper's world with our planners' choices.
    #[serde(rename = "hopper")]
    Hopper,
    /// The payoff of Sakamoto & Kubota 2022, the predecessor on known ground.
    #[serde(rename = "paper-2022")]
    Paper2022,
}

impl Profile {
    /// Every profile.
    pub const ALL: [Profile; 3] = [Profile::Paper2023, Profile::Hopper, Profile::Paper2022];

    /// The profile's name in scenarios and on the command line.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Profile::Paper2023 => "paper-2023",
            Profile::Hopper => "hopper",
            Profile::Paper2022 => "paper-2022",
        }
    }

    /// The code on the wire.
    #[must_use]
    pub fn code(self) -> u32 {
        match self {
            Profile::Paper2023 => 1,
            Profile::Hopper => 2,
            Profile::Paper2022 => 3,
        }
    }

    /// The profile of a wire code, if there is one.
    #[must_use]
    pub fn from_code(code: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|profile| profile.code() == code)
    }
}

impl std::fmt::Display for Profile {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.as_str())
    }
}

impl std::str::FromStr for Profile {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|profile| profile.as_str() == text).ok_or_else(|| {
            let meant = did_you_mean(text, Self::ALL.map(Profile::as_str));
            format!("a profile is paper-2023, hopper or paper-2022, got {text:?}{meant}")
        })
    }
}
