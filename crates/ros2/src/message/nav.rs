//! `nav_msgs`.

use super::{Header, Pose, PoseStamped, PoseWithCovariance, Time, TwistWithCovariance, message};

message! {
    /// The lattice of a map.
    MapMetaData = "nav_msgs/MapMetaData" {
        /// When the map was loaded.
        map_load_time: Time,
        /// Edge of a cell, metres.
        resolution: f32,
        /// Cells in x.
        width: u32,
        /// Cells in y.
        height: u32,
        /// The corner of cell (0, 0).
        origin: Pose,
    }
}

message! {
    /// Which cells can be entered.
    OccupancyGrid = "nav_msgs/OccupancyGrid" {
        /// Moment and frame.
        header: Header,
        /// The lattice.
        info: MapMetaData,
        /// Row by row from cell (0, 0), x first: 0 free to 100 occupied, −1 unknown.
        data: Vec<i8>,
    }
}

message! {
    /// A way from pose to pose.
    Path = "nav_msgs/Path" {
        /// Moment and frame.
        header: Header,
        /// The poses.
        poses: Vec<PoseStamped>,
    }
}

message! {
    /// Where a robot is, and how it moves.
    Odometry = "nav_msgs/Odometry" {
        /// Moment, and the frame of the pose.
        header: Header,
        /// The frame of the twist.
        child_frame_id: String,
        /// The pose.
        pose: PoseWithCovariance,
        /// The velocity.
        twist: TwistWithCovariance,
    }
}
