//! The models by which a simulated hop may end, and the figures that each tells of it.

use serde::{Deserialize, Serialize};

use crate::spelling::did_you_mean;

/// Most figures of a model.
pub const FIGURES: usize = 6;

/// Declares the models, one line each: its code, its name in scenarios, and what its figures are called, with their units.
macro_rules! motion_models {
    ($($(#[doc = $about:literal])+ $model:ident = $code:literal, $name:literal, $figures:expr;)+) => {
        /// A motion model: where a hop ends, and by which way.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum MotionModel {
            $($(#[doc = $about])+ $model,)+
        }

        impl MotionModel {
            /// Every model.
            pub const ALL: &[MotionModel] = &[$(Self::$model),+];

            /// The code on the wire.
            #[must_use]
            pub fn code(self) -> u32 {
                match self {
                    $(Self::$model => $code,)+
                }
            }

            /// The name in scenarios.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$model => $name,)+
                }
            }

            /// What its figures are called, in their order, units last; at most [`FIGURES`].
            #[must_use]
            pub fn figures(self) -> &'static [&'static str] {
                match self {
                    $(Self::$model => { const { &$figures } })+
                }
            }
        }

        $(const _: () = assert!($figures.len() <= FIGURES);)+
    };
}

motion_models! {
    /// The four branches of P23: nothing is told beyond the outcome.
    Law = 1, "law", [""; 0];
    /// The law, if the arc clears the ground (P22).
    Collision = 2, "collision", ["collided"];
    /// A body that flies, hits, bounces and rolls until it rests.
    Contact = 3, "contact", ["end", "impacts", "rolled_m", "seconds", "energy_j_per_kg", "displaced"];
}

impl MotionModel {
    /// The model of a wire code, if there is one.
    #[must_use]
    pub fn from_code(code: u32) -> Option<Self> {
        Self::ALL.iter().copied().find(|model| model.code() == code)
    }
}

impl std::str::FromStr for MotionModel {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL.iter().copied().find(|model| model.name() == text).ok_or_else(|| {
            let names: Vec<&str> = Self::ALL.iter().map(|model| model.name()).collect();
            let meant = did_you_mean(text, names.iter().copied());
            format!("a motion model is one of {}, got {text:?}{meant}", names.join(", "))
        })
    }
}

impl std::fmt::Display for MotionModel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}
