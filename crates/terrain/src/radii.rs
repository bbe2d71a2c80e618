//! Distances from the centre of a body, which are no heights, and other values beyond all heights.

use contract::limits::LENGTH_MAX_M;

use crate::{Georeference, Remark, TerrainError, Window};

/// Larger values than this are no distances from the centre of a body, metres.
pub(crate) const RADIUS_MAX_M: f64 = 1e9;

/// Share of the known cells from which on values beyond all heights are such distances, and not nodata.
const SHARE_MIN: f64 = 0.05;

/// No body has heights above this that all cells could exceed, metres. Olympus Mons is 22 km high.
const HEIGHT_MAX_M: f64 = 50e3;

/// Radii differ from that of the body by less than this share of it, as bodies are no spheres.
const OFF_SPHERE: f64 = 0.2;

/// Radii in kilometres that are taken for metres differ by less than this share of it ...
const OFF_RADIUS: f64 = 0.02;

/// ... and from each other by less than this share of the side of the map: ground is never so level.
const LEVEL: f64 = 1e-3;

/// How stored values become heights, as far as a remedy depends on it.
pub(crate) struct Scaling {
    pub offset: f64,
    pub unit_m: f64,
    /// Whether stored values are heights in metres.
    pub is_plain: bool,
}

/// Refuses heights that are distances from the centre of a body. `radius_m` is that of the body, where it is stated.
pub(crate) fn refuse(
    heights_m: &[f64],
    radius_m: Option<f64>,
    place: &Georeference,
    window: Window,
    scaling: &Scaling,
) -> Result<(), TerrainError> {
    let known = || heights_m.iter().copied().filter(|height| height.is_finite());
    let beyond = || known().filter(|height| height.abs() > LENGTH_MAX_M);
    let refused = |values: &mut dyn Iterator<Item = f64>, in_kilometres: bool| {
        let (mut min_m, mut max_m) = (f64::INFINITY, f64::NEG_INFINITY);
        values.for_each(|height| (min_m, max_m) = (min_m.min(height), max_m.max(height)));
        Radii { min_m, max_m, in_kilometres }
    };
    if known().next().is_none() {
        return Ok(());
    }
    let many = refused(&mut beyond(), false);
    if beyond().count() as f64 > SHARE_MIN * known().count() as f64
        && many.min_m >= 0.0
        && many.min_m < many.max_m
    {
        return Err(many.error(radius_m, scaling));
    }
    let Some(radius_m) = radius_m else { return Ok(()) };
    let all = refused(&mut known(), false);
    if all.min_m > (1.0 - OFF_SPHERE) * radius_m && all.max_m < (1.0 + OFF_SPHERE) * radius_m {
        return Err(all.error(Some(radius_m), scaling));
    }
    let side_m = f64::from(window.width.max(window.height)) * place.cell_size_m;
    let is_near = |height: f64| (1000.0 * height - radius_m).abs() < OFF_RADIUS * radius_m;
    let range_m = all.max_m - all.min_m;
    if is_near(all.min_m) && is_near(all.max_m) && range_m > 0.0 && range_m < LEVEL * side_m {
        return Err(Radii { in_kilometres: true, ..all }.error(Some(radius_m), scaling));
    }
    Ok(())
}

/// Values beyond 1e6 m, which are no heights.
#[derive(Default)]
pub(crate) struct Beyond {
    cells: u64,
    min_m: f64,
    max_m: f64,
}

impl Beyond {
    /// Counts one; what is not finite is nodata, and no value.
    pub fn count(&mut self, height_m: f64) {
        if !height_m.is_finite() {
            return;
        }
        let (min_m, max_m) = if self.cells == 0 { (height_m, height_m) } else { (self.min_m, self.max_m) };
        *self = Self { cells: self.cells + 1, min_m: min_m.min(height_m), max_m: max_m.max(height_m) };
    }

    /// Takes the others out of `heights_m`, and warns of all.
    pub fn remove(mut self, heights_m: &mut [f64]) -> Option<Remark> {
        for height in heights_m.iter_mut().filter(|height| height.abs() > LENGTH_MAX_M) {
            self.count(*height);
            *height = f64::NAN;
        }
        let Self { cells, min_m, max_m } = self;
        if cells == 0 { None } else { Some(Remark::BeyondHeights { cells, min_m, max_m }) }
    }
}

/// Warns of heights that no ground has.
pub(crate) fn remark(heights_m: &[f64]) -> Option<Remark> {
    let lowest_m = heights_m.iter().copied().filter(|height| !height.is_nan()).reduce(f64::min)?;
    if lowest_m > HEIGHT_MAX_M { Some(Remark::MaybeRadii { lowest_m }) } else { None }
}

struct Radii {
    min_m: f64,
    max_m: f64,
    in_kilometres: bool,
}

impl Radii {
    fn error(self, radius_m: Option<f64>, scaling: &Scaling) -> TerrainError {
        let Self { min_m, max_m, in_kilometres } = self;
        let thousand = if in_kilometres { 1000.0 } else { 1.0 };
        let middle_m = thousand * (min_m + max_m) / 2.0;
        let datum_m =
            radius_m.filter(|radius_m| near(*radius_m, middle_m)).unwrap_or_else(|| datum_m(middle_m));
        let unit_m = thousand * scaling.unit_m;
        let remedy = match (scaling.is_plain, in_kilometres) {
            (true, false) => format!("gdal_calc.py -A IN.tif --calc=A-{datum_m} --outfile OUT.tif"),
            // An offset is in the unit of heights, and applies after the scale.
            (true, true) => format!("gdal_edit.py -units km -offset {} FILE", digits(-datum_m / unit_m)),
            (false, false) => {
                format!("gdal_edit.py -offset {} FILE", digits(scaling.offset - datum_m / unit_m))
            }
            (false, true) => {
                format!("gdal_edit.py -units km -offset {} FILE", digits(scaling.offset - datum_m / unit_m))
            }
        };
        TerrainError::Radii { min_m: thousand * min_m, max_m: thousand * max_m, remedy }
    }
}

/// Nine digits hide the rounding of binary fractions.
fn digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.9e}").parse().unwrap_or(value);
    (rounded + 0.0).to_string()
}

fn near(radius_m: f64, middle_m: f64) -> bool {
    (radius_m - middle_m).abs() < 0.01 * radius_m
}

/// The radius of the body whose surface lies so far from its centre, metres: that of a well-known one, or about that distance.
fn datum_m(middle_m: f64) -> f64 {
    let bodies_m = [1_737_400.0, 3_396_190.0, 2_439_400.0, 6_051_800.0, 6_371_000.0];
    let known = bodies_m.into_iter().find(|radius_m| near(*radius_m, middle_m));
    known.unwrap_or_else(|| (middle_m / 1000.0).round() * 1000.0)
}
