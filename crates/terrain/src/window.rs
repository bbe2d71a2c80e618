//! A rectangular part of a raster.

/// A rectangle of cells, counted from the south-western corner of the raster, x east and y north.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// First column, from the west.
    pub x: u32,
    /// First row, from the south.
    pub y: u32,
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
}

impl Window {
    /// The whole of a raster of `width` × `height`.
    #[must_use]
    pub fn all(width: u32, height: u32) -> Self {
        Self { x: 0, y: 0, width, height }
    }

    /// Number of cells: `width` × `height`.
    #[must_use]
    pub fn cells(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// Whether it has cells and lies within a raster of `width` × `height`.
    #[must_use]
    pub fn is_within(self, width: u32, height: u32) -> bool {
        let fits = |start: u32, length: u32, side: u32| {
            length > 0 && start.checked_add(length).is_some_and(|end| end <= side)
        };
        fits(self.x, self.width, width) && fits(self.y, self.height, height)
    }
}
