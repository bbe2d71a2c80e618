//! `grid_map_msgs`.

use super::{Float32MultiArray, Header, Pose, message};

message! {
    /// The lattice of a grid map.
    GridMapInfo = "grid_map_msgs/GridMapInfo" {
        /// Edge of a cell, metres.
        resolution: f64,
        /// Metres in x.
        length_x: f64,
        /// Metres in y.
        length_y: f64,
        /// The middle of the map.
        pose: Pose,
    }
}

message! {
    /// Layers of numbers over a lattice.
    GridMap = "grid_map_msgs/GridMap" {
        /// Moment and frame.
        header: Header,
        /// The lattice.
        info: GridMapInfo,
        /// Names of the layers.
        layers: Vec<String>,
        /// Layers without which a cell is not valid.
        basic_layers: Vec<String>,
        /// The numbers of each layer.
        data: Vec<Float32MultiArray>,
        /// Row at which the buffer begins.
        outer_start_index: u16,
        /// Column at which the buffer begins.
        inner_start_index: u16,
    }
}
