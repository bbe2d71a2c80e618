//! `geometry_msgs`.

use serde::ser::{Serialize, SerializeTuple, Serializer};

use super::{FieldType, Header, message};

message! {
    /// A place, metres.
    #[derive(Copy)]
    Point = "geometry_msgs/Point" {
        /// East.
        x: f64,
        /// North.
        y: f64,
        /// Up.
        z: f64,
    }
}

message! {
    /// A vector.
    #[derive(Copy)]
    Vector3 = "geometry_msgs/Vector3" {
        /// First component.
        x: f64,
        /// Second component.
        y: f64,
        /// Third component.
        z: f64,
    }
}

impl Vector3 {
    /// No length.
    pub const ZERO: Self = Self { x: 0.0, y: 0.0, z: 0.0 };
}

message! {
    /// A rotation.
    #[derive(Copy)]
    Quaternion = "geometry_msgs/Quaternion" {
        /// Of the imaginary part.
        x: f64,
        /// Of the imaginary part.
        y: f64,
        /// Of the imaginary part.
        z: f64,
        /// The real part.
        w: f64,
    }
}

impl Quaternion {
    /// A turn about the vertical, radians counter-clockwise from east.
    #[must_use]
    pub fn of_yaw(yaw_rad: f64) -> Self {
        let half_rad = yaw_rad / 2.0;
        Self { x: 0.0, y: 0.0, z: libm::sin(half_rad), w: libm::cos(half_rad) }
    }
}

message! {
    /// Place and direction.
    #[derive(Copy)]
    Pose = "geometry_msgs/Pose" {
        /// The place.
        position: Point,
        /// The direction.
        orientation: Quaternion,
    }
}

impl Pose {
    /// At a place (east, north, up) in metres, turned about the vertical.
    #[must_use]
    pub fn at([x, y, z]: [f64; 3], yaw_rad: f64) -> Self {
        Self { position: Point { x, y, z }, orientation: Quaternion::of_yaw(yaw_rad) }
    }
}

message! {
    /// A pose at a moment.
    PoseStamped = "geometry_msgs/PoseStamped" {
        /// Moment and frame.
        header: Header,
        /// The pose.
        pose: Pose,
    }
}

/// A covariance matrix of six quantities, row by row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Covariance(pub [f64; 36]);

impl Covariance {
    /// That of what is known exactly.
    pub const ZERO: Self = Self([0.0; 36]);
}

impl Serialize for Covariance {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut array = serializer.serialize_tuple(self.0.len())?;
        self.0.iter().try_for_each(|value| array.serialize_element(value))?;
        array.end()
    }
}

impl FieldType for Covariance {
    fn spelling() -> String {
        "float64[36]".to_owned()
    }
}

message! {
    /// A pose, and how well it is known.
    PoseWithCovariance = "geometry_msgs/PoseWithCovariance" {
        /// The pose.
        pose: Pose,
        /// Of x, y, z and the rotations about them.
        covariance: Covariance,
    }
}

message! {
    /// A velocity.
    #[derive(Copy)]
    Twist = "geometry_msgs/Twist" {
        /// Metres per second.
        linear: Vector3,
        /// Radians per second.
        angular: Vector3,
    }
}

message! {
    /// A velocity, and how well it is known.
    TwistWithCovariance = "geometry_msgs/TwistWithCovariance" {
        /// The velocity.
        twist: Twist,
        /// Of x, y, z and the rotations about them.
        covariance: Covariance,
    }
}

message! {
    /// Where a frame lies in another.
    #[derive(Copy)]
    Transform = "geometry_msgs/Transform" {
        /// Metres.
        translation: Vector3,
        /// The rotation.
        rotation: Quaternion,
    }
}

message! {
    /// Where a frame lies in another at a moment.
    TransformStamped = "geometry_msgs/TransformStamped" {
        /// Moment and outer frame.
        header: Header,
        /// The frame that lies in it.
        child_frame_id: String,
        /// Where it lies.
        transform: Transform,
    }
}
