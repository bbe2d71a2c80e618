//! Expected speeds of uncertain ground as points, and their spread beside them.

use contract::{MonotonicNs, ObservedMap, PriorCell, Robot};
use report::picture::colour;
use speed_layer::{SPEED_MAX_M_PER_SOL, SPREAD_MAX_M_PER_SOL, SpeedEstimate, SpeedLayer};

use super::point_cloud::{Cloud, Point};
use crate::proto::foxglove::PointCloud;

/// The expected speeds lie this far above the ground, cells: over the heights, beneath the routes.
const LIFT_CELLS: f64 = 0.05;

/// The spread lies beside the map, so many widths of the map to the east: viewers without settings draw everything at once.
const BESIDE_WIDTHS: f64 = 1.1;

/// The prior as it is drawn.
#[derive(Debug)]
pub(super) struct Speeds {
    layer: SpeedLayer,
    /// Height of each cell, metres.
    heights_m: Vec<f64>,
}

/// Which of the two clouds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Quantity {
    Speed,
    Spread,
}

impl Speeds {
    /// The layer of a whole prior, with the cameras of `robots`.
    pub fn new(prior: &[PriorCell], robots: &[Robot]) -> Self {
        let heights_m = prior.iter().map(|cell| cell.height_m).collect();
        Self { layer: SpeedLayer::new(prior, robots), heights_m }
    }

    /// The middle of every cell, with `speed` and `spread` in whole m/Sol, and `seen` 0 or 1.
    pub fn cloud(&self, map: &ObservedMap, quantity: Quantity, moment: MonotonicNs) -> PointCloud {
        let mut cloud = Cloud::with(&["speed", "spread", "seen"], self.heights_m.len());
        let side_m = map.grid.cell_size_m;
        let east_m = match quantity {
            Quantity::Speed => 0.0,
            Quantity::Spread => BESIDE_WIDTHS * f64::from(map.grid.width) * side_m,
        };
        for (index, (seen, height_m)) in map.cells().iter().zip(&self.heights_m).enumerate() {
            let Some(estimate) = self.layer.estimate_seen(index, seen.as_ref()) else { continue };
            let cell = map.grid.cell(index);
            let along = |cells: i32| (f64::from(cells) + 0.5) * side_m;
            let z = height_m + LIFT_CELLS * side_m;
            let at = Point { x: along(cell.x) + east_m, y: along(cell.y), z };
            let whole = |m_per_sol: f64| m_per_sol.round().clamp(0.0, 255.0) as u8;
            let bytes =
                [whole(estimate.mean_m_per_sol), whole(estimate.sd_m_per_sol), u8::from(seen.is_some())];
            cloud.push_with(at, quantity.shade(estimate), bytes);
        }
        cloud.into_message(moment)
    }
}

impl Quantity {
    fn shade(self, estimate: SpeedEstimate) -> [u8; 3] {
        match self {
            Self::Speed => colour::ramp(&colour::SPEEDS, estimate.mean_m_per_sol / SPEED_MAX_M_PER_SOL),
            Self::Spread => colour::ramp(&colour::SPREADS, estimate.sd_m_per_sol / SPREAD_MAX_M_PER_SOL),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use contract::{DriveSpeed, Grid, Ground, RobotId, RunId, SpeedPrior};

    /// P-VIEWERS-SPEED: Recordings show every cell of uncertain ground with its expected speed, and
    /// the spread beside the map.
    #[test]
    fn expected_speeds_lie_on_the_ground_and_their_spread_beside_it() {
        let grid = Grid::new(2, 1, 10.0, 1).unwrap();
        let speeds = SpeedPrior::new([0.5, 0.0, 0.0, 0.5]).unwrap();
        let prior = [PriorCell { speeds, height_m: 1.0 }; 2];
        let mut map = ObservedMap::unseen(RunId(1), RobotId(0), grid);
        map.learn(1, Ground { speed: Some(DriveSpeed::Medium), ..Ground::FLAT });
        let drawn = Speeds::new(&prior, &[]);
        for (quantity, east_m, ramp, shares) in [
            (Quantity::Speed, 0.0, &colour::SPEEDS[..], [0.5, 0.75]),
            (Quantity::Spread, 22.0, &colour::SPREADS[..], [1.0, 0.0]),
        ] {
            let cloud = drawn.cloud(&map, quantity, MonotonicNs(0));
            let names: Vec<&str> = cloud.fields.iter().map(|field| field.name.as_str()).collect();
            assert_eq!(names[7..], ["speed", "spread", "seen"]);
            let points: Vec<&[u8]> = cloud.data.chunks(cloud.point_stride as usize).collect();
            let known = [[100, 100, 0], [150, 0, 1]];
            for (n, point) in points.iter().enumerate() {
                let metres = |at: usize| f32::from_le_bytes(point[at..at + 4].try_into().unwrap());
                assert_eq!([metres(0), metres(4), metres(8)], [5.0 + 10.0 * n as f32 + east_m, 5.0, 1.5]);
                assert_eq!(point[12..15], colour::ramp(ramp, shares[n]), "{quantity:?} of cell {n}");
                assert_eq!(point[16..], known[n]);
            }
            assert_eq!(points.len(), 2);
        }
    }
}
