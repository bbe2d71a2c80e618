//! Where robots are, as `nav_msgs/Odometry` and `tf2_msgs/TFMessage`.

use contract::{MonotonicNs, RobotId};

use crate::message::{
    Covariance, Odometry, Pose, PoseWithCovariance, Quaternion, TFMessage, Transform, TransformStamped,
    Twist, TwistWithCovariance, Vector3,
};
use crate::{Clock, Landing};

/// The frame of the ground.
pub(crate) const MAP: &str = "map";

/// A topic or a frame of a robot.
pub(crate) fn of_robot(robot: RobotId, name: &str) -> String {
    format!("robot_{robot}/{name}")
}

/// A robot at rest. Its covariance is zero: a mission knows where its robots are.
pub(crate) fn odometry(robot: RobotId, pose: Pose, moment: MonotonicNs, clock: &Clock) -> Odometry {
    let still = Twist { linear: Vector3::ZERO, angular: Vector3::ZERO };
    Odometry {
        header: clock.header(moment, &of_robot(robot, "odom")),
        child_frame_id: of_robot(robot, "base_link"),
        pose: PoseWithCovariance { pose, covariance: Covariance::ZERO },
        twist: TwistWithCovariance { twist: still, covariance: Covariance::ZERO },
    }
}

/// Where all robots are in their odometry's frames.
pub(crate) fn transforms(landing: &Landing, clock: &Clock) -> TFMessage {
    let transform = |(robot, pose): (RobotId, &Pose)| {
        let translation = Vector3 { x: pose.position.x, y: pose.position.y, z: pose.position.z };
        TransformStamped {
            header: clock.header(landing.moment, &of_robot(robot, "odom")),
            child_frame_id: of_robot(robot, "base_link"),
            transform: Transform { translation, rotation: pose.orientation },
        }
    };
    TFMessage { transforms: (0..).map(RobotId).zip(&landing.poses).map(transform).collect() }
}

/// The frames of the odometries of so many robots, which lie in the map unmoved.
pub(crate) fn static_transforms(robots: u16, moment: MonotonicNs, clock: &Clock) -> TFMessage {
    let transform = |robot| TransformStamped {
        header: clock.header(moment, MAP),
        child_frame_id: of_robot(robot, "odom"),
        transform: Transform { translation: Vector3::ZERO, rotation: Quaternion::of_yaw(0.0) },
    };
    TFMessage { transforms: (0..robots).map(RobotId).map(transform).collect() }
}
