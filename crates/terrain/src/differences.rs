//! Finite differences over cells of which some are unknown.

use contract::Cell;

/// Gradient at `cell`, metres per metre, from the heights of known neighbours: along each axis a central
/// difference if both neighbours are known, a one-sided one if only one is, zero if neither is or the cell
/// itself is unknown.
#[must_use]
pub fn differences(cell: Cell, spacing_m: f64, known_m: impl Fn(Cell) -> Option<f64>) -> [f64; 2] {
    let Some(here) = known_m(cell) else { return [0.0; 2] };
    let height = |dx: i32, dy: i32| known_m(Cell::new(cell.x + dx, cell.y + dy));
    let slope = |ahead: Option<f64>, behind: Option<f64>| match (ahead, behind) {
        (Some(ahead), Some(behind)) => (ahead - behind) / (2.0 * spacing_m),
        (Some(ahead), None) => (ahead - here) / spacing_m,
        (None, Some(behind)) => (here - behind) / spacing_m,
        (None, None) => 0.0,
    };
    [slope(height(1, 0), height(-1, 0)), slope(height(0, 1), height(0, -1))]
}
