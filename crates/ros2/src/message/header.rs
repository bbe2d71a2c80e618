//! `std_msgs/Header`.

use super::message;

message! {
    /// A moment since the beginning of 1970.
    #[derive(Copy, Eq, PartialOrd, Ord)]
    Time = "builtin_interfaces/Time" {
        /// Whole seconds.
        sec: i32,
        /// The rest, nanoseconds.
        nanosec: u32,
    }
}

message! {
    /// Of which moment a message is, and in which frame.
    Header = "std_msgs/Header" {
        /// The moment.
        stamp: Time,
        /// The frame.
        frame_id: String,
    }
}
