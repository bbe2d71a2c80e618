//! A layer with values of seen ground as points.

use contract::{Ground, ObservedMap};
use report::Layer;
use report::layers::Scale;

use super::LIFT_CELLS;
use super::point_cloud::{Cloud, Point};
use crate::proto::foxglove::PointCloud;

/// The middle of every seen cell, with its value as a number of the layer's name.
pub(super) fn cloud(
    map: &ObservedMap,
    layer: Layer,
    scale: &Scale,
    value: fn(&Ground, u16) -> f64,
    east_m: f64,
) -> PointCloud {
    let mut cloud = Cloud::with_number(layer.definition().name, map.seen_cells());
    let side_m = map.grid.cell_size_m;
    for (index, ground) in map.cells().iter().enumerate() {
        let Some(ground) = ground else { continue };
        let cell = map.grid.cell(index);
        let along = |cells: i32| (f64::from(cells) + 0.5) * side_m;
        let z = ground.height_m + LIFT_CELLS * side_m;
        let value = value(ground, map.visits(index));
        let at = Point { x: along(cell.x) + east_m, y: along(cell.y), z };
        cloud.push_with_number(at, layer.colour(value / scale.most), value);
    }
    cloud.into_message(map.published)
}

#[cfg(test)]
mod tests {
    use super::*;
    use contract::{Grid, RobotId, RunId};
    use report::layers::Value;

    #[test]
    fn each_seen_cell_has_its_value_as_a_number_and_its_colour() {
        let grid = Grid::new(2, 1, 10.0, 1).unwrap();
        let mut map = ObservedMap::unseen(RunId(1), RobotId(0), grid);
        map.learn_visited(1, Ground { height_m: 2.0, ..Ground::FLAT }, 3);
        let value: fn(&Ground, u16) -> f64 = |_, visits| 1.0 / (1.0 + f64::from(visits));
        let scale =
            Scale { most: 1.0, ramp: &[[0; 3], [200; 3]], value: Value::Ground { of: value, words: "{}" } };
        let layer = Layer::ALL.iter().copied().find(|layer| layer.scale().is_some()).unwrap();
        let cloud = cloud(&map, layer, &scale, value, 22.0);
        assert_eq!((cloud.point_stride, cloud.data.len()), (20, 20));
        let number = |at: usize| f32::from_le_bytes(cloud.data[at..at + 4].try_into().unwrap());
        assert_eq!([number(0), number(4), number(8), number(16)], [37.0, 5.0, 2.5, 0.25]);
        assert_eq!(cloud.data[12..15], layer.colour(0.25));
        let field = cloud.fields.last().unwrap();
        assert_eq!((field.name.as_str(), field.offset), (layer.definition().name, 16));
    }
}
