//! Foxglove's well-known messages, derived from our own for viewers that do not know Hopper.
//!
//! Coordinate frame `map`: x east, y north, z up, metres. Cell (0, 0) has its south-western corner at the origin; a
//! pose is in the middle of its cell.

use contract::{Brief, Cell, Flight, MonotonicNs, ObservedMap, Soil, State};
use prost_types::Timestamp;

use crate::proto::foxglove::{
    Color, Grid, KeyValuePair, LinePrimitive, Log, PackedElementField, Point3, Pose, PoseInFrame, Quaternion,
    SceneEntity, SceneUpdate, SpherePrimitive, TextPrimitive, Vector2, Vector3, line_primitive, log,
    packed_element_field::NumericType,
};

const FRAME: &str = "map";

/// Bytes of a cell of the grid: height, soil, seen, passable, treasure.
const STRIDE: usize = 8;

/// Number of segments of the arc of a hop.
const ARC_POINTS: u32 = 12;

/// The observed map: `height` in metres, `soil` 1 hard or 2 sand, `seen`, `passable` and `treasure` 0 or 1.
#[must_use]
pub fn grid(map: &ObservedMap) -> Grid {
    let field = |name: &str, offset, kind: NumericType| PackedElementField {
        name: name.into(),
        offset,
        r#type: kind.into(),
    };
    let mut data = Vec::with_capacity(STRIDE * map.cells().len());
    for cell in map.cells() {
        let height_m = cell.map_or(f32::NAN, |ground| ground.height_m as f32);
        data.extend_from_slice(&height_m.to_le_bytes());
        let soil = cell.map_or(0, |ground| if ground.soil == Soil::Hard { 1 } else { 2 });
        data.extend_from_slice(&[
            soil,
            u8::from(cell.is_some()),
            cell.map_or(0, |g| u8::from(g.passable)),
            0,
        ]);
    }
    for treasure in map.treasures() {
        if let Some(index) = map.grid.index(*treasure) {
            data[STRIDE * index + STRIDE - 1] = 1;
        }
    }
    Grid {
        timestamp: stamp(map.published),
        frame_id: FRAME.into(),
        pose: pose(Point3 { x: 0.0, y: 0.0, z: 0.0 }),
        column_count: map.grid.width,
        cell_size: Some(Vector2 { x: map.grid.cell_size_m, y: map.grid.cell_size_m }),
        row_stride: map.grid.width * STRIDE as u32,
        cell_stride: STRIDE as u32,
        fields: vec![
            field("height", 0, NumericType::Float32),
            field("soil", 4, NumericType::Uint8),
            field("seen", 5, NumericType::Uint8),
            field("passable", 6, NumericType::Uint8),
            field("treasure", 7, NumericType::Uint8),
        ],
        data,
    }
}

/// Position of the hopper.
#[must_use]
pub fn pose_of(brief: &Brief, state: &State) -> PoseInFrame {
    PoseInFrame {
        timestamp: stamp(state.published),
        frame_id: FRAME.into(),
        pose: pose(middle(brief, state.pose.cell, state.pose.height_m)),
    }
}

/// The entities of a state: the goal of the current leg, the hopper, and the hop that led here.
#[must_use]
pub fn scene(brief: &Brief, state: &State) -> SceneUpdate {
    let here = middle(brief, state.pose.cell, state.pose.height_m);
    let goal = brief.goal_after(state.visits);
    let size = brief.grid.cell_size_m;
    let mut goal_entity = entity(state, "goal");
    let above = Point3 { z: here.z + size, ..middle(brief, goal, 0.0) };
    goal_entity.texts.push(TextPrimitive {
        pose: pose(above),
        billboard: true,
        font_size: size,
        scale_invariant: false,
        color: colour(0.0, 0.55, 0.2),
        text: "goal".into(),
    });
    let mut hopper = entity(state, "hopper");
    hopper.spheres.push(SpherePrimitive {
        pose: pose(here),
        size: Some(Vector3 { x: size / 2.0, y: size / 2.0, z: size / 2.0 }),
        color: colour(0.85, 0.2, 0.1),
    });
    hopper.metadata = [
        ("decision", state.decision.to_string()),
        ("planner", state.leader.planner.to_string()),
        ("term", state.leader.term.to_string()),
        ("status", state.status.to_string()),
    ]
    .map(|(key, value)| KeyValuePair { key: key.into(), value })
    .into();
    let mut entities = vec![goal_entity, hopper];
    if let Some(last) = state.last.filter(|last| last.from != last.to) {
        let mut hop = entity(state, &format!("hop {}", state.decision.0.saturating_sub(1)));
        let to = middle(brief, last.to, state.pose.height_m);
        let from = middle(brief, last.from, state.pose.height_m - last.flight.rise_m);
        hop.lines.push(LinePrimitive {
            r#type: line_primitive::Type::LineStrip.into(),
            pose: pose(Point3 { x: 0.0, y: 0.0, z: 0.0 }),
            thickness: size / 10.0,
            scale_invariant: false,
            points: arc(from, to, &last.flight),
            color: colour(0.1, 0.35, 0.8),
            colors: Vec::new(),
            indices: Vec::new(),
        });
        entities.push(hop);
    }
    SceneUpdate { deletions: Vec::new(), entities }
}

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

/// Points on the parabola from launch to landing with the apex of the flight.
fn arc(from: Point3, to: Point3, flight: &Flight) -> Vec<Point3> {
    let rise_m = to.z - from.z;
    let apex_m = flight.apex_height_m.max(rise_m).max(0.0);
    // z(s) = b s − (b − rise) s² over s in 0 to 1 has its apex b² / 4 (b − rise); solved for b.
    let b = 2.0 * (apex_m + (apex_m * (apex_m - rise_m)).max(0.0).sqrt());
    let point = |n: u32| {
        let s = f64::from(n) / f64::from(ARC_POINTS);
        let z = from.z + b * s - (b - rise_m) * s * s;
        Point3 { x: from.x + (to.x - from.x) * s, y: from.y + (to.y - from.y) * s, z }
    };
    (0..=ARC_POINTS).map(point).collect()
}

fn entity(state: &State, id: &str) -> SceneEntity {
    SceneEntity {
        timestamp: stamp(state.published),
        frame_id: FRAME.into(),
        id: id.into(),
        ..SceneEntity::default()
    }
}

fn middle(brief: &Brief, cell: Cell, z: f64) -> Point3 {
    let along = |cells: i32| (f64::from(cells) + 0.5) * brief.grid.cell_size_m;
    Point3 { x: along(cell.x), y: along(cell.y), z }
}

fn pose(at: Point3) -> Option<Pose> {
    let position = Some(Vector3 { x: at.x, y: at.y, z: at.z });
    Some(Pose { position, orientation: Some(Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }) })
}

fn colour(r: f64, g: f64, b: f64) -> Option<Color> {
    Some(Color { r, g, b, a: 1.0 })
}

fn stamp(moment: MonotonicNs) -> Option<Timestamp> {
    let (seconds, nanos) = (moment.0 / 1_000_000_000, moment.0 % 1_000_000_000);
    Some(Timestamp { seconds: seconds as i64, nanos: nanos as i32 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arc_goes_from_launch_to_landing_over_the_apex() {
        let from = Point3 { x: 0.5, y: 0.5, z: 1.0 };
        for (rise_m, apex_height_m) in [(0.0, 0.25), (0.3, 0.5), (-0.4, 0.1)] {
            let to = Point3 { x: 1.5, y: 0.5, z: 1.0 + rise_m };
            let points = arc(from, to, &Flight { apex_height_m, ..Flight::default() });
            assert_eq!(points[0], from);
            let end = points[points.len() - 1];
            assert!((end.z - to.z).abs() < 1e-12 && end.x == to.x, "{end:?}");
            let highest = points.iter().fold(f64::MIN, |most, point| most.max(point.z)) - from.z;
            assert!(highest <= apex_height_m + 1e-12 && highest > 0.8 * apex_height_m, "{highest}");
        }
    }
}
