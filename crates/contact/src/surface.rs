//! The ground: heights at the centres of cells, bilinear between them.

use nalgebra::Vector3;

use crate::soil::Soil;

/// A height field with soils. Heights lie at the centres of square cells, metres; the outer patches extend to the edges of the
/// outermost cells. Beyond is no ground.
#[derive(Clone, Debug)]
pub struct Surface {
    width: usize,
    height: usize,
    cell_m: f64,
    heights_m: Vec<f64>,
    /// The soil of each cell, by its place in `soils`.
    kinds: Vec<u8>,
    soils: Vec<Soil>,
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
    pub x0: f64,
    pub y0: f64,
    a: f64,
    b: f64,
    c: f64,
    pub d: f64,
}

/// What is wrong with the parts of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceError {
    /// Fewer than two columns or rows.
    TooSmall,
    /// Not one height and one soil for each cell.
    Count,
    /// A height or the edge of a cell is no finite number, or the edge is not above 0.
    NotFinite,
    /// A cell has a soil that is not among the given ones.
    UnknownSoil,
}

impl Surface {
    /// A surface of `width` columns; heights and kinds of soil row by row from the south, west first.
    ///
    /// # Errors
    /// If the parts do not make a surface.
    pub fn new(
        width: usize,
        cell_m: f64,
        heights_m: Vec<f64>,
        kinds: Vec<u8>,
        soils: Vec<Soil>,
    ) -> Result<Self, SurfaceError> {
        let height = heights_m.len().checked_div(width).unwrap_or(0);
        if width < 2 || height < 2 {
            return Err(SurfaceError::TooSmall);
        }
        if width * height != heights_m.len() || kinds.len() != heights_m.len() {
            return Err(SurfaceError::Count);
        }
        if !(cell_m.is_finite() && cell_m > 0.0) || heights_m.iter().any(|height_m| !height_m.is_finite()) {
            return Err(SurfaceError::NotFinite);
        }
        if kinds.iter().any(|kind| usize::from(*kind) >= soils.len()) {
            return Err(SurfaceError::UnknownSoil);
        }
        Ok(Self { width, height, cell_m, heights_m, kinds, soils })
    }

    /// Edge of a cell, metres.
    #[must_use]
    pub fn cell_m(&self) -> f64 {
        self.cell_m
    }

    /// Extent of the ground from west to east and from south to north, metres.
    #[must_use]
    pub fn extent_m(&self) -> [f64; 2] {
        [self.width as f64 * self.cell_m, self.height as f64 * self.cell_m]
    }

    /// Whether there is ground at (x, y).
    #[must_use]
    pub fn contains(&self, x: f64, y: f64) -> bool {
        let [width, height] = self.extent_m();
        (0.0..=width).contains(&x) && (0.0..=height).contains(&y)
    }

    /// Height at (x, y), metres; outside that of the patch extended.
    #[must_use]
    pub fn height_m(&self, x: f64, y: f64) -> f64 {
        self.bilinear(self.patch(x, y)).height_m(x, y)
    }

    /// The upward unit normal at (x, y).
    #[must_use]
    pub fn normal(&self, x: f64, y: f64) -> Vector3<f64> {
        self.bilinear(self.patch(x, y)).normal(x, y)
    }

    /// The soil at (x, y): that of the nearest centre.
    #[must_use]
    pub fn soil(&self, x: f64, y: f64) -> &Soil {
        let at = |metres: f64, count: usize| ((metres / self.cell_m).max(0.0) as usize).min(count - 1);
        let index = at(y, self.height) * self.width + at(x, self.width);
        &self.soils[usize::from(self.kinds[index])]
    }

    /// The patch at (x, y); outside the outermost one on that side.
    pub(crate) fn patch(&self, x: f64, y: f64) -> Patch {
        let at = |metres: f64, count: usize| ((metres / self.cell_m - 0.5).max(0.0) as usize).min(count - 2);
        Patch { column: at(x, self.width), row: at(y, self.height) }
    }

    /// West, east, south and north border of a patch, metres.
    pub(crate) fn borders(&self, patch: Patch) -> [f64; 4] {
        let centre = |index: usize| (index as f64 + 0.5) * self.cell_m;
        let low = |index: usize| if index == 0 { 0.0 } else { centre(index) };
        let high = |index: usize, count: usize| {
            if index + 2 == count { count as f64 * self.cell_m } else { centre(index + 1) }
        };
        [low(patch.column), high(patch.column, self.width), low(patch.row), high(patch.row, self.height)]
    }

    /// The patch beside one, so many columns and rows on; `None` off the ground.
    pub(crate) fn beside(&self, patch: Patch, columns: i32, rows: i32) -> Option<Patch> {
        let step = |index: usize, by: i32, count: usize| {
            index.checked_add_signed(by as isize).filter(|index| *index + 2 <= count)
        };
        Some(Patch {
            column: step(patch.column, columns, self.width)?,
            row: step(patch.row, rows, self.height)?,
        })
    }

    pub(crate) fn bilinear(&self, patch: Patch) -> Bilinear {
        let Patch { column, row } = patch;
        let at = |column: usize, row: usize| self.heights_m[row * self.width + column];
        let (sw, se) = (at(column, row), at(column + 1, row));
        let (nw, ne) = (at(column, row + 1), at(column + 1, row + 1));
        let cell = self.cell_m;
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
    pub fn height_m(&self, x: f64, y: f64) -> f64 {
        let (u, v) = (x - self.x0, y - self.y0);
        self.a + self.b * u + self.c * v + self.d * u * v
    }

    /// (∂h/∂x, ∂h/∂y).
    pub fn gradient(&self, x: f64, y: f64) -> [f64; 2] {
        let (u, v) = (x - self.x0, y - self.y0);
        [self.b + self.d * v, self.c + self.d * u]
    }

    pub fn normal(&self, x: f64, y: f64) -> Vector3<f64> {
        let [east, north] = self.gradient(x, y);
        let long = Vector3::new(-east, -north, 1.0);
        long / libm::sqrt(long.norm_squared())
    }
}
