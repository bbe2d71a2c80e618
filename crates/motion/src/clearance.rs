//! Whether a hop of fixed speed clears the ground on its way to a cell (P22 section III, P23 section III).
//!
//! The launch speed is that of the design hop on the flat, v² = g d / sin 2η: a hop does not get faster because its target is higher. It
//! fails if its arc touches the ground before the apex, or if the target is as high as the apex or higher. A touch on the way down is
//! the landing.

use contract::{Cell, Direction, Grid, MotionParameters, Soil};

use crate::{GroundProfile, Launch, collision_m, soil_motion};

/// The launch of a flight over a distance on the flat: v² = g d / sin 2η.
#[must_use]
pub fn launch_over(parameters: &MotionParameters, distance_m: f64) -> Launch {
    let (angle_rad, gravity_mps2) = (parameters.launch_angle_rad, parameters.gravity_mps2);
    let squared = gravity_mps2 * distance_m / libm::sin(2.0 * angle_rad);
    Launch { speed_mps: squared.sqrt(), angle_rad, gravity_mps2 }
}

/// The launch of each flight of a hop from a soil: as many as the soil takes, each over a part of the distance.
#[must_use]
pub fn design_launch(parameters: &MotionParameters, grid: &Grid, soil: Soil) -> Launch {
    launch_over(parameters, grid.hop_distance_m() / f64::from(soil_motion(parameters, soil).flights))
}

/// Whether a hop from a cell towards another clears the ground, whose height in the middle of a cell `height_m` gives; between the middles it is straight.
/// Of ground without a height nothing is in the way.
#[must_use]
pub fn clears(
    parameters: &MotionParameters,
    grid: &Grid,
    soil: Soil,
    (from, direction): (Cell, Direction),
    height_m: impl Fn(Cell) -> Option<f64>,
) -> bool {
    let launch = design_launch(parameters, grid, soil);
    let flights = soil_motion(parameters, soil).flights as usize;
    let (east, north) = direction.step();
    let cells =
        (0..=grid.hop_cells as i32).map(|steps| Cell::new(from.x + east * steps, from.y + north * steps));
    let Some(heights_m) = cells.map(height_m).collect::<Option<Vec<f64>>>() else { return true };
    // As many parts of each cell as there are flights, so that every flight begins at one.
    let at = |part: usize| {
        let (cell, share) = (part / flights, (part % flights) as f64 / flights as f64);
        let next = heights_m[(cell + 1).min(heights_m.len() - 1)];
        heights_m[cell] + (next - heights_m[cell]) * share
    };
    let parts = grid.hop_cells as usize;
    (0..flights).all(|flight| {
        let heights_m: Vec<f64> = (flight * parts..=(flight + 1) * parts).map(at).collect();
        let rise_m = heights_m[parts] - heights_m[0];
        let profile = GroundProfile::sloping(&heights_m, grid.cell_size_m / flights as f64);
        rise_m < launch.apex_height_m() && collision_m(&launch, &profile).is_none()
    })
}

#[cfg(test)]
mod tests {
    use contract::SoilMotion;

    use super::*;

    fn mars() -> MotionParameters {
        let soil = |intended, stuck, sideways, flights| SoilMotion { intended, stuck, sideways, flights };
        MotionParameters {
            hard: soil(0.9, 0.0, 0.05, 1),
            sand: soil(0.7, 0.1, 0.1, 2),
            slope_limit_rad: 0.5,
            launch_angle_rad: std::f64::consts::FRAC_PI_4,
            gravity_mps2: 3.72,
            vertical: false,
            table: 0,
        }
    }

    /// P-CLEARANCE: A hop at 45° fails at a rise of a quarter of its distance, a tie included, and at whatever stands in the way of its rise.
    #[test]
    fn a_hop_at_45_degrees_fails_from_a_rise_of_a_quarter_of_its_distance() {
        let grid = Grid::new(9, 9, 1.0, 1).unwrap();
        let hop = (Cell::new(1, 1), Direction::East);
        for (rise_m, clears_hard) in [(0.0, true), (0.2499, true), (0.25, false), (1.0, false), (-1.0, true)]
        {
            let height_m = |cell: Cell| Some(if cell.x == 2 { rise_m } else { 0.0 });
            assert_eq!(clears(&mars(), &grid, Soil::Hard, hop, height_m), clears_hard, "{rise_m}");
        }
        // Half hops have half the apex, and each rises half.
        for (rise_m, clears_sand) in [(0.2499, true), (0.25, false)] {
            let height_m = |cell: Cell| Some(if cell.x == 2 { rise_m } else { 0.0 });
            assert_eq!(clears(&mars(), &grid, Soil::Sand, hop, height_m), clears_sand, "{rise_m}");
        }
        // Over four cells, a wall half way is in the way of the rise, behind the apex it is not.
        let grid = Grid::new(9, 9, 0.25, 4).unwrap();
        let wall_at = |x: i32| move |cell: Cell| Some(if cell.x == x { 0.24 } else { 0.0 });
        assert!(!clears(&mars(), &grid, Soil::Hard, hop, wall_at(2)));
        assert!(clears(&mars(), &grid, Soil::Hard, hop, wall_at(4)));
    }
}
