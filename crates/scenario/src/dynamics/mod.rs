//! Section `[truth.dynamics]`: where a hop ends in truth, one file a motion model.

use contract::{Brief, Grid, MotionModel};
#[cfg(test)]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use terrain::Terrain;

use crate::ScenarioError;

mod preset;

pub use preset::Preset;

/// What can be asked of the fields of any model.
trait Rules {
    /// Checks them for hops on a lattice.
    fn check(&self, grid: &Grid) -> Result<(), ScenarioError> {
        let _ = grid;
        Ok(())
    }

    /// Checks that the hoppers of a mission on this terrain can hop at all.
    fn check_hops(&self, brief: &Brief, terrain: &Terrain) -> Result<(), ScenarioError> {
        let _ = (brief, terrain);
        Ok(())
    }
}

/// Declares the models, one line each: its module, its variant with its fields, and what it is.
macro_rules! models {
    ($($module:ident => $model:ident($rules:ident), $what:literal;)+) => {
        $(mod $module;)+
        $(pub use self::$module::*;)+

        /// Where a hop ends, by a motion model.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[cfg_attr(test, derive(JsonSchema))]
        #[serde(tag = "model", rename_all = "snake_case")]
        #[expect(clippy::large_enum_variant, reason = "one in a scenario; a box would tell every reader of it nothing")]
        pub enum Dynamics {
            $(#[doc = $what] $model($rules),)+
        }

        impl Dynamics {
            /// The model with its defaults.
            #[must_use]
            pub fn of(model: MotionModel) -> Self {
                match model {
                    $(MotionModel::$model => Self::$model($rules::default()),)+
                }
            }

            /// Which model it is.
            #[must_use]
            pub fn model(&self) -> MotionModel {
                match self {
                    $(Self::$model(_) => MotionModel::$model,)+
                }
            }

            /// Checks its fields for hops on a lattice.
            pub(crate) fn check(&self, grid: &Grid) -> Result<(), ScenarioError> {
                match self {
                    $(Self::$model(rules) => rules.check(grid),)+
                }
            }

            /// Checks that the hoppers of a mission on this terrain can hop at all.
            pub(crate) fn check_hops(&self, brief: &Brief, terrain: &Terrain) -> Result<(), ScenarioError> {
                match self {
                    $(Self::$model(rules) => rules.check_hops(brief, terrain),)+
                }
            }
        }
    };
}

models! {
    law => Law(LawRules), "One of the four branches of P23 is drawn.";
    collision => Collision(CollisionRules), "As the law has it, if the arc clears the ground; otherwise the hop stays.";
    contact => Contact(ContactRules), "The body flies, hits, bounces and rolls until it rests.";
}

impl Dynamics {
    /// Whether it is the law of the papers, which a scenario need not name.
    #[must_use]
    pub fn is_law(&self) -> bool {
        matches!(self, Self::Law(_))
    }
}

impl Default for Dynamics {
    fn default() -> Self {
        Self::Law(LawRules::default())
    }
}
