//! Foxglove's well-known messages, derived from our own for viewers that do not know Hopper.
//!
//! Only what Foxglove, Lichtblick and Rerun all draw: point clouds, transforms, log lines. Rerun draws neither grids nor
//! scene entities, so the map, the policy, the route and the robots are clouds of coloured points.
//!
//! Coordinate frame `map`: x east, y north, z up, metres. Cell (0, 0) has its south-western corner at the origin; a
//! robot's frame `rN` is in the middle of its cell, or exactly where it is if it goes from point to point.

mod arrows;
mod ground;
mod markers;
mod point_cloud;
mod speeds;
mod trail;
mod values;
mod views;

use contract::{Brief, Cell, Grid, MonotonicNs};
use prost_types::Timestamp;
use report::Layer;

pub use point_cloud::Point;
pub use trail::way;
pub use views::{ViewMessage, Views};

use crate::proto::foxglove::{Log, Pose, Quaternion, Vector3, log};

/// The frame of the ground.
pub const FRAME: &str = "map";

/// A log entry for viewers.
#[must_use]
pub fn line(level: log::Level, name: &str, message: String, now: MonotonicNs) -> Log {
    Log {
        timestamp: stamp(now),
        level: level.into(),
        message,
        name: name.into(),
        file: String::new(),
        line: 0,
    }
}

/// Layers with a scale lie this far above the ground, cells: over the heights, beneath the routes.
const LIFT_CELLS: f64 = 0.05;

/// Layers lie beside one another, so many widths of the map to the east: viewers without settings draw everything at once.
const BESIDE_WIDTHS: f64 = 1.1;

/// Of `layers` those with a scale, each with how far to the east of the map it lies, metres: 0 of the one that is shown `first`.
fn scales(layers: &[Layer], first: Layer, grid: &Grid) -> Vec<(Layer, f64)> {
    let mut beside = 0;
    let mut east_m = |layer: Layer| {
        beside += u32::from(layer != first);
        let number = if layer == first { 0 } else { beside };
        f64::from(number) * BESIDE_WIDTHS * f64::from(grid.width) * grid.cell_size_m
    };
    let scales = layers.iter().copied().filter(|layer| layer.scale().is_some());
    scales.map(|layer| (layer, east_m(layer))).collect()
}

/// The middle of a cell.
fn middle(brief: &Brief, cell: Cell, z: f64) -> Point {
    let along = |cells: i32| (f64::from(cells) + 0.5) * brief.grid.cell_size_m;
    Point { x: along(cell.x), y: along(cell.y), z }
}

fn at_origin() -> Option<Pose> {
    Some(Pose { position: Some(Vector3 { x: 0.0, y: 0.0, z: 0.0 }), orientation: unturned() })
}

fn unturned() -> Option<Quaternion> {
    Some(Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 })
}

fn stamp(moment: MonotonicNs) -> Option<Timestamp> {
    let (seconds, nanos) = (moment.0 / 1_000_000_000, moment.0 % 1_000_000_000);
    Some(Timestamp { seconds: seconds as i64, nanos: nanos as i32 })
}
