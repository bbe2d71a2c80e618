//! The hop lattice: how many cells one hop spans.

use contract::limits::GRID_SIDE_MAX;

use crate::TerrainError;

/// Number of cells of `cell_size_m` spanned by a hop of `hop_distance_m`, at least 1.
///
/// # Errors
/// [`TerrainError::HopOverCell`] with the nearest cell size that divides the hop.
pub fn hop_cells(hop_distance_m: f64, cell_size_m: f64) -> Result<u32, TerrainError> {
    let ratio = hop_distance_m / cell_size_m;
    let whole = ratio.round();
    if whole >= 1.0 && whole <= f64::from(GRID_SIDE_MAX) && (ratio - whole).abs() <= 1e-9 * whole {
        Ok(whole as u32)
    } else {
        Err(TerrainError::HopOverCell {
            hop_distance_m,
            cell_size_m,
            fitting_m: fitting_hop_m(hop_distance_m, cell_size_m),
            // For a hop longer than any grid, cells as long as the hop are suggested.
            resample_m: if whole <= f64::from(GRID_SIDE_MAX) {
                hop_distance_m / whole.max(1.0)
            } else {
                hop_distance_m
            },
        })
    }
}

/// The length nearest to `hop_distance_m` that spans whole cells of `cell_size_m`, at least one; metres.
#[must_use]
pub fn fitting_hop_m(hop_distance_m: f64, cell_size_m: f64) -> f64 {
    let cells = (hop_distance_m / cell_size_m).round().clamp(1.0, f64::from(GRID_SIDE_MAX));
    let fitting_m = cells * cell_size_m;
    // Twelve digits hide the rounding of binary fractions and still span whole cells.
    format!("{fitting_m:.11e}").parse().unwrap_or(fitting_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hop_of_whole_cells_is_counted() {
        assert_eq!(hop_cells(1.0, 1.0).unwrap(), 1);
        assert_eq!(hop_cells(1.0, 0.1).unwrap(), 10);
        assert_eq!(hop_cells(4.98, 4.98).unwrap(), 1);
    }

    #[test]
    fn a_hop_of_broken_cells_is_refused_with_the_resampling_that_mends_it() {
        let text = hop_cells(12.0, 4.98).unwrap_err().to_string();
        assert!(text.contains("cell_size_m = 6"), "{text}");
        let text = hop_cells(1.0, 4.98).unwrap_err().to_string();
        assert!(text.contains("cell_size_m = 1 of the terrain, which resamples an elevation file, or robot.hop_distance_m = 4.98"), "{text}");
        let text = hop_cells(4.98, 0.0001).unwrap_err().to_string();
        assert!(text.contains("set cell_size_m = 4.98"), "{text}");
        for (hop_m, cell_m, fitting_m) in [(1.0, 0.3, 0.9), (1.0, 30.0, 30.0), (2.0, 0.996, 1.992)] {
            assert_eq!(fitting_hop_m(hop_m, cell_m), fitting_m);
            assert!(hop_cells(fitting_m, cell_m).is_ok());
        }
        assert!(hop_cells(f64::NAN, 1.0).is_err());
        assert!(hop_cells(1.0, 0.0).is_err());
    }
}
