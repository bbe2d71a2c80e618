//! Gravity and soils of bodies; `docs/dynamics.md` has the source of each figure.

use std::fmt;
use std::str::FromStr;

use ::contact::Soil;
#[cfg(test)]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A body with its gravity and its soils.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Preset {
    /// Earth's moon.
    Moon,
    /// Mars.
    #[default]
    Mars,
    /// The larger moon of Mars.
    Phobos,
    /// The asteroid (162173) Ryugu.
    Ryugu,
    /// The asteroid (101955) Bennu.
    Bennu,
}

/// Boulders of small bodies.
const BOULDERS: Soil = Soil { restitution: 0.12, roughness_rad: 0.2, ..Soil::HARD };

/// Loose ground of small bodies, into which a body sinks at 1e-2 g and from which it rebounds below 1e-4 g.
const REGOLITH: Soil = Soil {
    restitution: 0.1,
    restitution_gravity_mps2: 1e-3,
    rolling: 0.7,
    foot: 0.7,
    roughness_rad: 0.1,
    ..Soil::HARD
};

impl Preset {
    /// Every preset.
    pub const ALL: [Preset; 5] = [Preset::Moon, Preset::Mars, Preset::Phobos, Preset::Ryugu, Preset::Bennu];

    /// The name in scenarios and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Preset::Moon => "moon",
            Preset::Mars => "mars",
            Preset::Phobos => "phobos",
            Preset::Ryugu => "ryugu",
            Preset::Bennu => "bennu",
        }
    }

    /// Surface gravity, m/s².
    #[must_use]
    pub fn gravity_mps2(self) -> f64 {
        match self {
            Preset::Moon => 1.62,
            Preset::Mars => 3.72,
            Preset::Phobos => 4.9e-3,
            Preset::Ryugu => 1.6e-4,
            Preset::Bennu => 8.2e-5,
        }
    }

    /// Hard ground, and sand.
    #[must_use]
    pub fn soils(self) -> [Soil; 2] {
        match self {
            Preset::Moon | Preset::Mars => [Soil::HARD, Soil::SAND],
            Preset::Phobos | Preset::Ryugu | Preset::Bennu => [BOULDERS, REGOLITH],
        }
    }

    pub(crate) fn is_mars(&self) -> bool {
        *self == Preset::Mars
    }
}

impl fmt::Display for Preset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Preset {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|preset| preset.name() == text).ok_or_else(|| {
            let names = Self::ALL.map(Preset::name);
            let meant = contract::spelling::did_you_mean(text, names);
            format!("a preset is one of {}, got {text:?}{meant}", names.join(", "))
        })
    }
}
