//! The ground: heights at the centres of cells, bilinear between them.

use nalgebra::Vector3;

use crate::soil::Soil;

/// Heights at the centres of square cells, metres, with the soil of each cell.
pub trait Field {
    /// Columns and rows; at least two of each.
    fn size(&self) -> [usize; 2];

    /// Edge of a cell, metres, above 0.
    fn cell_m(&self) -> f64;

    /// Height of a centre, metres; finite.
    fn height_m(&self, column: usize, row: usize) -> f64;

    /// The soil of a cell.
    fn soil(&self, column: usize, row: usize) -> &Soil;
}

/// Ground made of a field: bilinear between four centres. The outer patches extend to the edges of the outermost cells; beyond is no
/// ground. Positions are (east, north, up), metres from the south-western corner of cell (0, 0).
#[derive(Clone, Debug)]
pub struct Surface<F> {
    field: F,
}

/// A patch between four centres: (column, row) of its lower left centre.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Patch {
    pub column: usize,
    pub row: usize,
}

/// Heights of a patch as a + b u + c v + d u v, with u and v in metres from its lower left centre.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bilinear {
    x0: f64,
    y0: f64,
    a: f64,
    b: f64,
    c: f64,
    pub d: f64,
}

impl<F: Field> Surface<F> {
    /// The ground of a field.
    ///
    /// # Panics
    /// If it has fewer than two columns or rows, or cells without an edge.
    #[must_use]
    pub fn new(field: F) -> Self {
        let ([width, height], cell_m) = (field.size(), field.cell_m());
        assert!(width >= 2 && height >= 2, "a surface needs two columns and rows, got {width} × {height}");
        assert!(cell_m > 0.0, "a cell needs an edge above 0, got {cell_m} m");
        Self { field }
    }

    /// Edge of a cell, metres.
    #[must_use]
    #[inline]
    pub fn cell_m(&self) -> f64 {
        self.field.cell_m()
    }

    /// Height at (x, y), metres; outside that of the patch extended.
    #[must_use]
    pub fn height_m(&self, x: f64, y: f64) -> f64 {
        self.bilinear(self.patch(x, y)).height_m(x, y)
    }

    /// The upward unit normal at (x, y).
    #[must_use]
    #[inline]
    pub fn normal(&self, x: f64, y: f64) -> Vector3<f64> {
        self.bilinear(self.patch(x, y)).normal(x, y)
    }

    /// The soil at (x, y): that of the nearest centre.
    #[must_use]
    #[inline]
    pub fn soil(&self, x: f64, y: f64) -> &Soil {
        let [width, height] = self.field.size();
        let at = |metres: f64, count: usize| ((metres / self.cell_m()).max(0.0) as usize).min(count - 1);
        self.field.soil(at(x, width), at(y, height))
    }

    /// The patch at (x, y); outside the outermost one on that side.
    #[inline]
    pub(crate) fn patch(&self, x: f64, y: f64) -> Patch {
        let [width, height] = self.field.size();
        let at =
            |metres: f64, count: usize| ((metres / self.cell_m() - 0.5).max(0.0) as usize).min(count - 2);
        Patch { column: at(x, width), row: at(y, height) }
    }

    /// Western and eastern border of a patch, metres.
    #[inline]
    pub(crate) fn columns(&self, patch: Patch) -> [f64; 2] {
        self.borders(patch.column, self.field.size()[0])
    }

    /// Southern and northern border of a patch, metres.
    #[inline]
    pub(crate) fn rows(&self, patch: Patch) -> [f64; 2] {
        self.borders(patch.row, self.field.size()[1])
    }

    #[inline]
    fn borders(&self, index: usize, count: usize) -> [f64; 2] {
        let cell_m = self.cell_m();
        let low = if index == 0 { 0.0 } else { (index as f64 + 0.5) * cell_m };
        let high =
            if index + 2 == count { count as f64 * cell_m } else { ((index + 1) as f64 + 0.5) * cell_m };
        [low, high]
    }

    /// The patch beside one, so many columns and rows on; `None` off the ground.
    #[inline]
    pub(crate) fn beside(&self, patch: Patch, columns: i32, rows: i32) -> Option<Patch> {
        let [width, height] = self.field.size();
        let step = |index: usize, by: i32, count: usize| {
            index.checked_add_signed(by as isize).filter(|index| *index + 2 <= count)
        };
        Some(Patch { column: step(patch.column, columns, width)?, row: step(patch.row, rows, height)? })
    }

    #[inline]
    pub(crate) fn bilinear(&self, patch: Patch) -> Bilinear {
        let Patch { column, row } = patch;
        let at = |column: usize, row: usize| self.field.height_m(column, row);
        let (sw, se) = (at(column, row), at(column + 1, row));
        let (nw, ne) = (at(column, row + 1), at(column + 1, row + 1));
        let cell = self.cell_m();
        Bilinear {
            x0: (column as f64 + 0.5) * cell,
            y0: (row as f64 + 0.5) * cell,
            a: sw,
            b: (se - sw) / cell,
            c: (nw - sw) / cell,
            d: (ne - nw - se + sw) / (cell * cell),
        }
    }
}

impl Bilinear {
    #[inline]
    pub fn height_m(&self, x: f64, y: f64) -> f64 {
        let (u, v) = (x - self.x0, y - self.y0);
        self.a + self.b * u + self.c * v + self.d * u * v
    }

    /// (∂h/∂x, ∂h/∂y).
    #[inline]
    pub fn gradient(&self, x: f64, y: f64) -> [f64; 2] {
        let (u, v) = (x - self.x0, y - self.y0);
        [self.b + self.d * v, self.c + self.d * u]
    }

    /// Height along a straight way as h + first s + second s², with s in metres along a heading.
    #[inline]
    pub fn along(&self, from: Vector3<f64>, heading: Vector3<f64>) -> [f64; 2] {
        let [east, north] = self.gradient(from.x, from.y);
        [east * heading.x + north * heading.y, self.d * heading.x * heading.y]
    }

    #[inline]
    pub fn normal(&self, x: f64, y: f64) -> Vector3<f64> {
        let [east, north] = self.gradient(x, y);
        let long = Vector3::new(-east, -north, 1.0);
        long / libm::sqrt(long.norm_squared())
    }
}
