//! The elevation-dependent sensor of a hopper.

use serde::{Deserialize, Serialize};

use super::{SensorKind, View};
use crate::Grid;
use crate::block::Block;
use crate::codec::{DISTANCE, LENGTH, float};
use crate::mission::kind::Kind;

/// Where the observed map takes its gradients from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GradientSource {
    /// The sensor measures the true slope of each seen cell.
    #[default]
    Measured,
    /// Differences of heights over seen cells only.
    SeenDifferences,
}

/// The elevation-dependent sensor: radius = gain · (h + offset), clamped (P23 section IV).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SensorParameters {
    /// Metres of radius per metre of height; 2 in P23.
    pub gain: f64,
    /// Height added before the gain, metres; 1 in P23.
    pub offset_m: f64,
    /// Smallest radius, metres; at least one hop, so that the neighbours are always seen.
    pub radius_min_m: f64,
    /// Largest radius, metres.
    pub radius_max_m: f64,
    /// Where gradients come from: the same for all hoppers of a mission.
    pub gradient: GradientSource,
}

impl SensorParameters {
    /// Sensing radius in metres at `height_m` above the datum, clamped to the sensor's range.
    #[must_use]
    pub fn radius_m(&self, height_m: f64) -> f64 {
        (self.gain * (height_m + self.offset_m)).clamp(self.radius_min_m, self.radius_max_m)
    }

    /// How far it sees from `height_m` above the datum, in cells of `grid`: the sensing radius, and one hop at
    /// least, whatever the rounding. Three cells of 0.7 m divided by 0.7 m are a little less than three.
    #[must_use]
    pub fn reach_cells(&self, grid: &Grid, height_m: f64) -> f64 {
        (self.radius_m(height_m) / grid.cell_size_m).max(f64::from(grid.hop_cells))
    }
}

impl Kind for SensorParameters {
    const NAME: &'static str = "disc";

    fn parameters(&mut self, block: &mut Block<'_>) {
        block.float("gain", "Metres of radius per metre of height.", float(0.0, 1.0e6), &mut self.gain);
        block.float("offset_m", "Height added before the gain, metres.", LENGTH, &mut self.offset_m);
        block.float("radius_min_m", "Smallest radius, metres.", DISTANCE, &mut self.radius_min_m);
        block.float(
            "radius_max_m",
            "Largest radius, metres; not below the smallest.",
            DISTANCE,
            &mut self.radius_max_m,
        );
        let (least, most) = (self.radius_min_m, self.radius_max_m);
        block.check("radius_max_m", least <= most, &format!("at least radius_min_m, {least}"), most);
        let all = [GradientSource::Measured, GradientSource::SeenDifferences];
        block.choice("gradient", "0 measured, 1 from differences of seen heights.", &all, &mut self.gradient);
    }
}

impl SensorKind for SensorParameters {
    fn in_words(&self) -> Option<String> {
        Some("a disc that grows with its height".into())
    }

    fn around(&self, grid: &Grid, height_m: f64) -> Option<View> {
        Some(View::disc(self.reach_cells(grid, height_m)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Cell, Direction};

    fn sensor() -> SensorParameters {
        SensorParameters {
            gain: 2.0,
            offset_m: 1.0,
            radius_min_m: 1.0,
            radius_max_m: 12.0,
            gradient: GradientSource::Measured,
        }
    }

    #[test]
    fn the_radius_grows_by_two_metres_a_metre_and_is_clamped() {
        assert_eq!(sensor().radius_m(0.0), 2.0);
        assert_eq!(sensor().radius_m(1.5), 5.0);
        assert_eq!(sensor().radius_m(-4139.0), 1.0);
        assert_eq!(sensor().radius_m(4139.0), 12.0);
    }

    /// P-GUARD-REACH.
    #[test]
    fn every_landing_of_every_hop_lies_in_the_smallest_disc_whatever_the_rounding() {
        for hop_cells in 1..=12 {
            for cell_size_m in (1..=40).map(|step| f64::from(step) / 20.0) {
                let side = 2 * hop_cells + 1;
                let grid = Grid::new(side, side, cell_size_m, hop_cells).unwrap();
                let cell = Cell::new(hop_cells as i32, hop_cells as i32);
                let hop_m = grid.hop_distance_m();
                let least =
                    SensorParameters { gain: 0.0, radius_min_m: hop_m, radius_max_m: hop_m, ..sensor() };
                let seen: Vec<Cell> = least.around(&grid, 0.0).unwrap().cells(grid, cell).collect();
                for landing in Direction::ALL.map(|direction| grid.hop(cell, direction)) {
                    assert!(seen.contains(&landing), "{landing}: {hop_cells} cells of {cell_size_m} m");
                }
            }
        }
    }
}
