//! How a mission reads what Sakamoto & Kunii 2023 leaves open.

use serde::{Deserialize, Serialize};

use crate::Cell;

/// Choices that the paper does not make, for profile `paper-2023`. The default is the reading of docs/model.md.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reading {
    /// What leaving the map is worth to the plan, in place of r(x′) + V(x′), in units of payoff, below 0; `None` counts
    /// it as staying. Ground known to be impassable is worth the same.
    pub leaving: Option<f64>,
    /// Norm of the distance D (P23 eq. 3).
    pub distance: DistanceNorm,
    /// Distance at which D is −1, cells, above 0; `None` for that from start to goal in the same norm.
    pub distance_scale_cells: Option<f64>,
    /// Steps that a mission counts for its first observation, before any hop.
    pub opening_steps: u64,
    /// What planner `mdp` takes unseen ground for.
    #[serde(default, skip_serializing_if = "UnseenGround::is_flat")]
    pub unseen: UnseenGround,
}

/// What planner `mdp` takes ground for that nobody has seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum UnseenGround {
    /// Flat hard ground: the plan spans the whole map.
    #[default]
    Flat,
    /// No part of the plan: a hop that lands there counts as staying.
    Stays,
    /// No part of the plan: a hop that lands there loses the hopper.
    Leaves,
    /// No part of the plan: it ends there, and the payoff of the landing, of which all but the distance is a guess, is paid for ever.
    Ends,
}

impl UnseenGround {
    #[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks with a reference")]
    fn is_flat(&self) -> bool {
        *self == Self::Flat
    }
}

impl UnseenGround {
    /// In the order of their codes.
    pub const ALL: [Self; 4] = [Self::Flat, Self::Stays, Self::Leaves, Self::Ends];
}

/// How the distance between two cells is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DistanceNorm {
    /// As the crow flies.
    #[default]
    Euclidean,
    /// Along the axes.
    Manhattan,
}

impl DistanceNorm {
    /// Distance between two cells, cells.
    #[must_use]
    pub fn cells(self, a: Cell, b: Cell) -> f64 {
        match self {
            Self::Euclidean => a.distance_cells(b),
            Self::Manhattan => {
                (f64::from(a.x) - f64::from(b.x)).abs() + (f64::from(a.y) - f64::from(b.y)).abs()
            }
        }
    }
}

impl Reading {
    /// Whether nothing is read in another way than by default.
    #[must_use]
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_in_both_norms() {
        let (a, b) = (Cell::new(1, 2), Cell::new(4, -2));
        assert_eq!(DistanceNorm::Euclidean.cells(a, b), 5.0);
        assert_eq!(DistanceNorm::Manhattan.cells(a, b), 7.0);
        assert_eq!(DistanceNorm::Manhattan.cells(Cell::new(1, 2), Cell::new(18, 18)), 33.0);
    }
}
