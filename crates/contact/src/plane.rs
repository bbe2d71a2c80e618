//! An inclined plane of one soil, as wide as no hop is long.

use crate::soil::Soil;
use crate::surface::Field;

/// Columns and rows of a plane.
const SIDE: usize = 64;

/// A plane through the middle of its ground at height 0.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    cell_m: f64,
    /// (∂h/∂x, ∂h/∂y).
    gradient: [f64; 2],
    soil: Soil,
}

impl Plane {
    /// A plane of 64 × 64 cells of that edge, metres.
    #[must_use]
    pub fn new(cell_m: f64, gradient: [f64; 2], soil: Soil) -> Self {
        Self { cell_m, gradient, soil }
    }

    /// Its middle, metres along each axis.
    #[must_use]
    pub fn middle_m(&self) -> f64 {
        SIDE as f64 / 2.0 * self.cell_m
    }
}

impl Field for Plane {
    fn size(&self) -> [usize; 2] {
        [SIDE; 2]
    }

    fn cell_m(&self) -> f64 {
        self.cell_m
    }

    fn height_m(&self, column: usize, row: usize) -> f64 {
        let from_middle = |index: usize| (index as f64 + 0.5 - SIDE as f64 / 2.0) * self.cell_m;
        self.gradient[0] * from_middle(column) + self.gradient[1] * from_middle(row)
    }

    fn soil(&self, _column: usize, _row: usize) -> &Soil {
        &self.soil
    }
}
