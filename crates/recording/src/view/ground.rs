//! The seen cells as points: heights as in the pictures, sand greyer, impassable ground dark.

use contract::{Ground, ObservedMap, Soil};
use report::colour;

use super::point_cloud::{Cloud, Point};
use crate::proto::foxglove::PointCloud;

/// Share of the sand's colour where there is sand.
const SAND_SHARE: f64 = 0.5;

/// The middle of every seen cell, with `soil` 1 hard or 2 sand, `passable` and `treasure` 0 or 1.
pub(super) fn ground(map: &ObservedMap) -> PointCloud {
    let seen = || map.cells().iter().enumerate().filter_map(|(index, cell)| Some((index, (*cell)?)));
    let heights = seen().map(|(_, ground)| ground.height_m);
    let (lowest, highest) =
        heights.fold((f64::MAX, f64::MIN), |(low, high), height| (low.min(height), high.max(height)));
    let range_m = if highest > lowest { highest - lowest } else { 1.0 };
    let mut treasures: Vec<_> = map.treasures().iter().filter_map(|cell| map.grid.index(*cell)).collect();
    treasures.sort_unstable();
    let mut cloud = Cloud::with(["soil", "passable", "treasure"], seen().count());
    for (index, ground) in seen() {
        let cell = map.grid.cell(index);
        let along = |cells: i32| (f64::from(cells) + 0.5) * map.grid.cell_size_m;
        let soil = if ground.soil == Soil::Hard { 1 } else { 2 };
        let has_treasure = treasures.binary_search(&index).is_ok();
        let shade = if has_treasure {
            colour::rgb(colour::TREASURE)
        } else {
            shade(&ground, (ground.height_m - lowest) / range_m)
        };
        let at = Point { x: along(cell.x), y: along(cell.y), z: ground.height_m };
        cloud.push_with(at, shade, [soil, u8::from(ground.passable), u8::from(has_treasure)]);
    }
    cloud.into_message(map.published)
}

/// Colour of ground at `share` of the heights seen.
fn shade(ground: &Ground, share: f64) -> [u8; 3] {
    if !ground.passable {
        return colour::rgb(colour::BLOCKED);
    }
    let height = colour::height_rgb(share);
    if ground.soil == Soil::Hard {
        return height;
    }
    let sand = colour::rgb(colour::SAND);
    let mixed = |at: usize| {
        let (height, sand) = (f64::from(height[at]), f64::from(sand[at]));
        (height + SAND_SHARE * (sand - height)).round() as u8
    };
    [mixed(0), mixed(1), mixed(2)]
}
