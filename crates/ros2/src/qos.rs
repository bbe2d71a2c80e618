//! How a topic was offered, which `ros2 bag play` offers it by.

/// Infinite, as ROS 2 spells it.
const FOREVER: &str = "\n    sec: 9223372036\n    nsec: 854775807";

/// Quality of service of a topic. Every topic is reliable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Qos {
    /// Whoever comes late gets the last message.
    Latched,
    /// Whoever comes late gets the next message.
    Volatile,
}

impl Qos {
    /// The list of profiles in YAML, with the numbers of `rmw/types.h`: every release of ROS 2 from Humble on reads them.
    #[must_use]
    pub fn profiles(self) -> String {
        let (depth, durability) = match self {
            Qos::Latched => (1, 1),
            Qos::Volatile => (10, 2),
        };
        format!(
            "- history: 1\n  depth: {depth}\n  reliability: 1\n  durability: {durability}\n  deadline:{FOREVER}\n  lifespan:{FOREVER}\n  liveliness: 1\n  liveliness_lease_duration:{FOREVER}\n  avoid_ros_namespace_conventions: false"
        )
    }
}
