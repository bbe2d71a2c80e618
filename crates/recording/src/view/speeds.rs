//! Expected speeds of uncertain ground as points, and their spread beside them.

use contract::{MonotonicNs, ObservedMap, PriorCell, Robot};
use report::Layer;
use report::layers::{Scale, Value};
use speed_layer::{SpeedEstimate, SpeedLayer};

use super::LIFT_CELLS;
use super::point_cloud::{Cloud, Point};
use crate::proto::foxglove::PointCloud;

/// The prior as it is drawn.
#[derive(Debug)]
pub(super) struct Speeds {
    layer: SpeedLayer,
    /// Height of each cell, metres.
    heights_m: Vec<f64>,
    /// What is drawn of it.
    shown: Vec<Shown>,
}

/// A layer that shows speeds.
#[derive(Clone, Copy, Debug)]
struct Shown {
    layer: Layer,
    scale: Scale,
    of: fn([f64; 2]) -> f64,
    /// How far to the east of the map it lies.
    east_m: f64,
}

impl Shown {
    fn value(&self, estimate: SpeedEstimate) -> f64 {
        (self.of)(estimate.mean_and_sd_m_per_sol())
    }
}

impl Speeds {
    /// What those of `scales` show that are of speeds, of a whole prior, with the cameras of `robots`.
    pub fn new(prior: &[PriorCell], robots: &[Robot], scales: &[(Layer, f64)]) -> Self {
        let heights_m = prior.iter().map(|cell| cell.height_m).collect();
        let shown = scales.iter().filter_map(|&(layer, east_m)| {
            let scale = layer.scale()?;
            let Value::Speed { of, .. } = scale.value else { return None };
            Some(Shown { layer, scale, of, east_m })
        });
        Self { layer: SpeedLayer::new(prior, robots), heights_m, shown: shown.collect() }
    }

    /// A cloud a layer: the middle of every cell, with what every layer shows of it in whole units, and `seen` 0 or 1.
    pub fn clouds(&self, map: &ObservedMap, moment: MonotonicNs) -> Vec<(Layer, PointCloud)> {
        self.shown.iter().map(|shown| (shown.layer, self.cloud(map, shown, moment))).collect()
    }

    fn cloud(&self, map: &ObservedMap, drawn: &Shown, moment: MonotonicNs) -> PointCloud {
        let names: Vec<&str> = self.shown.iter().map(|shown| shown.layer.definition().name).collect();
        let mut cloud = Cloud::with([&names[..], &["seen"]].concat(), self.heights_m.len());
        let side_m = map.grid.cell_size_m;
        let mut bytes = Vec::new();
        for (index, (seen, height_m)) in map.cells().iter().zip(&self.heights_m).enumerate() {
            let Some(estimate) = self.layer.estimate_seen(index, seen.as_ref()) else { continue };
            let cell = map.grid.cell(index);
            let along = |cells: i32| (f64::from(cells) + 0.5) * side_m;
            let z = height_m + LIFT_CELLS * side_m;
            let at = Point { x: along(cell.x) + drawn.east_m, y: along(cell.y), z };
            let whole = |shown: &Shown| shown.value(estimate).round().clamp(0.0, 255.0) as u8;
            bytes.clear();
            bytes.extend(self.shown.iter().map(whole));
            bytes.push(u8::from(seen.is_some()));
            let shade = drawn.layer.colour(drawn.value(estimate) / drawn.scale.most);
            cloud.push_with(at, shade, &bytes);
        }
        cloud.into_message(moment)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use contract::{DriveSpeed, Grid, Ground, RobotId, RunId, SpeedPrior};
    use report::colour;

    /// P-VIEWERS-SPEED: Recordings show every cell of uncertain ground with its expected speed, and
    /// the spread beside the map.
    #[test]
    fn expected_speeds_lie_on_the_ground_and_their_spread_beside_it() {
        let grid = Grid::new(2, 1, 10.0, 1).unwrap();
        let speeds = SpeedPrior::new([0.5, 0.0, 0.0, 0.5]).unwrap();
        let prior = [PriorCell { speeds, height_m: 1.0 }; 2];
        let mut map = ObservedMap::unseen(RunId(1), RobotId(0), grid);
        map.learn(1, Ground { speed: Some(DriveSpeed::Medium), ..Ground::FLAT });
        let scales = crate::view::scales(Layer::ALL, Layer::Speed, &grid);
        let clouds = Speeds::new(&prior, &[], &scales).clouds(&map, MonotonicNs(0));
        let expected = [
            (Layer::Speed, 0.0, &colour::SPEEDS[..], [0.5, 0.75]),
            (Layer::Spread, 22.0, &colour::SPREADS[..], [1.0, 0.0]),
        ];
        assert_eq!(clouds.len(), expected.len());
        for ((layer, cloud), (quantity, east_m, ramp, shares)) in clouds.into_iter().zip(expected) {
            assert_eq!(layer, quantity);
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
