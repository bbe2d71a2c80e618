//! An inclined plane of one soil, as wide as no hop is long.

use crate::soil::Soil;
use crate::surface::Field;

/// How far a plane extends from its middle, in lengths of a hop.
const HOPS: f64 = 32.0;

/// A plane through the middle of its ground at height 0. It is one patch: nothing is to be walked, and no arc of rolling is cut short
/// at a border.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    middle_m: f64,
    /// (∂h/∂x, ∂h/∂y).
    gradient: [f64; 2],
    soil: Soil,
}

impl Plane {
    /// A plane of 64 × 64 hops of that length, metres.
    #[must_use]
    pub fn new(hop_m: f64, gradient: [f64; 2], soil: Soil) -> Self {
        Self { middle_m: HOPS * hop_m, gradient, soil }
    }

    /// Its middle, metres along each axis.
    #[must_use]
    pub fn middle_m(&self) -> f64 {
        self.middle_m
    }
}

impl Field for Plane {
    fn size(&self) -> [usize; 2] {
        [2; 2]
    }

    fn cell_m(&self) -> f64 {
        self.middle_m
    }

    fn height_m(&self, column: usize, row: usize) -> f64 {
        let from_middle = |index: usize| if index == 0 { -0.5 * self.middle_m } else { 0.5 * self.middle_m };
        self.gradient[0] * from_middle(column) + self.gradient[1] * from_middle(row)
    }

    fn soil(&self, _column: usize, _row: usize) -> &Soil {
        &self.soil
    }
}
