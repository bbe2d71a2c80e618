//! The shape of the ground: each cell is a tilted plane.

use crate::{Lattice, Point, Segment};

/// The slope of each cell. A way is as long as it is on the tilted planes, so lengths add up exactly wherever a segment is cut.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    lattice: Lattice,
    /// Rise per metre, east and north; empty on flat ground.
    gradients: Vec<[f64; 2]>,
}

/// Why heights make no [`Surface`].
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SurfaceError {
    /// Another number of heights than of cells.
    #[error("the ground needs a height for each of its {need} cells, got {got}")]
    Heights {
        /// Cells of the lattice.
        need: usize,
        /// Heights given.
        got: usize,
    },
    /// A height that is no number.
    #[error("the height of cell {cell} needs to be a finite number, got {got}")]
    Height {
        /// The cell.
        cell: usize,
        /// The height given, in metres.
        got: f64,
    },
}

impl Surface {
    /// Level ground.
    #[must_use]
    pub fn flat(lattice: Lattice) -> Self {
        Self { lattice, gradients: Vec::new() }
    }

    /// Ground with these heights at the middles of its cells; gradients are central differences, one-sided at the border. If
    /// all heights are equal it is level ground.
    ///
    /// # Errors
    /// If there are not as many heights as cells, or one of them is not finite.
    pub fn from_heights(lattice: Lattice, heights_m: &[f64]) -> Result<Self, SurfaceError> {
        if heights_m.len() != lattice.cells() {
            return Err(SurfaceError::Heights { need: lattice.cells(), got: heights_m.len() });
        }
        if let Some(cell) = heights_m.iter().position(|height_m| !height_m.is_finite()) {
            return Err(SurfaceError::Height { cell, got: heights_m[cell] });
        }
        if heights_m.windows(2).all(|pair| pair[0] == pair[1]) {
            return Ok(Self::flat(lattice));
        }
        let (width, height) = (lattice.width(), lattice.height());
        let slope = |at: usize, size: usize, height_m: &dyn Fn(usize) -> f64| {
            let (low, high) = (at.saturating_sub(1), (at + 1).min(size - 1));
            if low == high { 0.0 } else { (height_m(high) - height_m(low)) / (high - low) as f64 }
        };
        let gradient = |cell: usize| {
            let (column, row) = (cell % width, cell / width);
            [
                slope(column, width, &|column| heights_m[row * width + column]),
                slope(row, height, &|row| heights_m[row * width + column]),
            ]
        };
        Ok(Self { lattice, gradients: (0..lattice.cells()).map(gradient).collect() })
    }

    /// The cells of the ground.
    #[must_use]
    pub fn lattice(&self) -> Lattice {
        self.lattice
    }

    /// Whether all lengths are those on the plane.
    #[must_use]
    pub fn is_flat(&self) -> bool {
        self.gradients.is_empty()
    }

    /// The slope of a cell in degrees, steepest direction.
    #[must_use]
    pub fn slope_deg(&self, cell: usize) -> f64 {
        self.gradients.get(cell).map_or(0.0, |[east, north]| {
            // atan(√(e² + n²)).
            libm::atan((east * east + north * north).sqrt()).to_degrees()
        })
    }

    /// Metres on the ground for a metre on the plane in a unit direction; at least 1.
    #[must_use]
    #[inline]
    pub fn stretch(&self, cell: usize, direction: Point) -> f64 {
        match self.gradients.get(cell) {
            None => 1.0,
            Some([east, north]) => {
                let rise = east * direction.x_m + north * direction.y_m;
                (1.0 + rise * rise).sqrt()
            }
        }
    }

    /// The greatest [`Surface::stretch`] of any cell in any direction.
    #[must_use]
    pub fn stretch_max(&self) -> f64 {
        let steepest = self.gradients.iter().map(|[east, north]| east * east + north * north);
        (1.0 + steepest.fold(0.0, f64::max)).sqrt()
    }
}

impl Segment {
    /// The unit vector from begin to end; (0, 0) if they are one point.
    #[must_use]
    pub fn direction(self) -> Point {
        let length_m = self.from.distance_m(self.to);
        if length_m == 0.0 {
            return Point::new(0.0, 0.0);
        }
        Point::new((self.to.x_m - self.from.x_m) / length_m, (self.to.y_m - self.from.y_m) / length_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_of_three_in_four_is_a_quarter_longer_than_on_the_plane() {
        let lattice = Lattice::new(4, 3).unwrap();
        let heights_m: Vec<f64> = (0..12).map(|cell| (cell % 4) as f64 * 0.75).collect();
        let ramp = Surface::from_heights(lattice, &heights_m).unwrap();
        for cell in 0..12 {
            assert_eq!(ramp.stretch(cell, Point::new(1.0, 0.0)), 1.25);
            assert_eq!(ramp.stretch(cell, Point::new(0.0, 1.0)), 1.0);
            assert!((ramp.slope_deg(cell) - 36.87).abs() < 0.01);
        }
        assert!(Surface::from_heights(lattice, &heights_m[1..]).is_err());
    }
}
