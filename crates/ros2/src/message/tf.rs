//! `tf2_msgs`.

use super::{TransformStamped, message};

message! {
    /// Where frames lie.
    TFMessage = "tf2_msgs/TFMessage" {
        /// One for each frame.
        transforms: Vec<TransformStamped>,
    }
}
