//! The square metres that a map consists of.

/// A position on the map: x grows eastwards, y northwards, (0, 0) is the south-western corner of cell 0.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Point {
    /// Eastwards, 0 to the width of the lattice.
    pub x_m: f64,
    /// Northwards, 0 to the height of the lattice.
    pub y_m: f64,
}

impl Point {
    /// The position `x_m` east and `y_m` north of the origin.
    #[must_use]
    pub const fn new(x_m: f64, y_m: f64) -> Self {
        Self { x_m, y_m }
    }

    /// Straight distance on the plane.
    #[must_use]
    #[inline]
    pub fn distance_m(self, other: Self) -> f64 {
        let (dx, dy) = (other.x_m - self.x_m, other.y_m - self.y_m);
        (dx * dx + dy * dy).sqrt()
    }

    /// The point at `share` (0 to 1) of the straight way to `other`.
    #[must_use]
    #[inline]
    pub fn towards(self, other: Self, share: f64) -> Self {
        Self::new(self.x_m + share * (other.x_m - self.x_m), self.y_m + share * (other.y_m - self.y_m))
    }
}

/// Cells of one square metre, numbered row by row from the south-western corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lattice {
    width: usize,
    height: usize,
}

/// Why a [`Lattice`] cannot be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a lattice needs sides of 1 to {} cells, got {width} x {height}", Lattice::SIDE_MAX)]
pub struct LatticeError {
    /// Columns asked for.
    pub width: usize,
    /// Rows asked for.
    pub height: usize,
}

impl Lattice {
    /// The longest side, in cells: cell numbers fit into 32 bits with room to spare.
    pub const SIDE_MAX: usize = 1 << 14;

    /// A lattice of `width` columns and `height` rows.
    ///
    /// # Errors
    /// If a side is 0 or above [`Lattice::SIDE_MAX`].
    pub fn new(width: usize, height: usize) -> Result<Self, LatticeError> {
        let sides = 1..=Self::SIDE_MAX;
        if sides.contains(&width) && sides.contains(&height) {
            Ok(Self { width, height })
        } else {
            Err(LatticeError { width, height })
        }
    }

    /// Columns.
    #[must_use]
    pub fn width(self) -> usize {
        self.width
    }

    /// Rows.
    #[must_use]
    pub fn height(self) -> usize {
        self.height
    }

    /// Cells in all.
    #[must_use]
    pub fn cells(self) -> usize {
        self.width * self.height
    }

    /// The cell that holds `point`; the outermost one for points beyond the border.
    #[must_use]
    #[inline]
    pub fn cell(self, point: Point) -> usize {
        // `as` saturates, so what is west or south of the map counts as 0.
        let column = (point.x_m as usize).min(self.width - 1);
        let row = (point.y_m as usize).min(self.height - 1);
        row * self.width + column
    }

    /// The middle of a cell.
    #[must_use]
    #[inline]
    pub fn centre(self, cell: usize) -> Point {
        Point::new((cell % self.width) as f64 + 0.5, (cell / self.width) as f64 + 0.5)
    }

    /// Whether `point` lies on the map, its border included.
    #[must_use]
    pub fn contains(self, point: Point) -> bool {
        (0.0..=self.width as f64).contains(&point.x_m) && (0.0..=self.height as f64).contains(&point.y_m)
    }
}
