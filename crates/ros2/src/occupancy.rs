//! The map as `nav_msgs/OccupancyGrid`: where a robot can land.

use contract::{Ground, MonotonicNs, ObservedMap};

use crate::Clock;
use crate::message::{MapMetaData, OccupancyGrid, Pose};
use crate::pose::MAP;

/// Ground that has not been seen.
const UNKNOWN: i8 = -1;
/// Passable ground.
const FREE: i8 = 0;
/// Ground that is not.
const OCCUPIED: i8 = 100;

/// The whole lattice, from cell (0, 0) on; `loaded` is when the mission began.
pub(crate) fn grid(map: &ObservedMap, loaded: MonotonicNs, clock: &Clock) -> OccupancyGrid {
    let value = |cell: &Option<Ground>| match cell {
        None => UNKNOWN,
        Some(ground) if ground.passable => FREE,
        Some(_) => OCCUPIED,
    };
    OccupancyGrid {
        header: clock.header(map.published, MAP),
        info: MapMetaData {
            map_load_time: clock.time(loaded),
            resolution: map.grid.cell_size_m as f32,
            width: map.grid.width,
            height: map.grid.height,
            origin: Pose::at([0.0; 3], 0.0),
        },
        data: map.cells().iter().map(value).collect(),
    }
}
