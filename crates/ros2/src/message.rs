//! The messages of ROS 2 that a mission becomes.
//!
//! Each is declared once, by [`message!`]: the fields of the struct, in their order, are the layout in CDR and the definition in
//! the bag (`ros2msg`).

mod definition;
mod diagnostics;
mod geometry;
mod grid_map;
mod header;
mod multi_array;
mod nav;
mod tf;

pub use definition::{Definitions, FieldType, Message, definition};
pub use diagnostics::{Byte, DiagnosticArray, DiagnosticStatus, KeyValue};
pub use geometry::{
    Covariance, Point, Pose, PoseStamped, PoseWithCovariance, Quaternion, Transform, TransformStamped, Twist,
    TwistWithCovariance, Vector3,
};
pub use grid_map::{GridMap, GridMapInfo};
pub use header::{Header, Time};
pub use multi_array::{Float32MultiArray, MultiArrayDimension, MultiArrayLayout};
pub use nav::{MapMetaData, OccupancyGrid, Odometry, Path};
pub use tf::TFMessage;

/// Declares a message: its struct, its name, and so its definition.
macro_rules! message {
    (
        $(#[$doc:meta])*
        $name:ident = $ros:literal $(with $constants:literal)? {
            $($(#[$field_doc:meta])* $field:ident: $type:ty,)*
        }
    ) => {
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize)]
        pub struct $name {
            $($(#[$field_doc])* pub $field: $type,)*
        }

        impl $crate::message::FieldType for $name {
            fn spelling() -> String {
                $ros.to_owned()
            }

            fn define(definitions: &mut $crate::message::Definitions) {
                let fields = [
                    $($constants.to_owned(),)?
                    $(format!("{} {}\n", <$type as $crate::message::FieldType>::spelling(), stringify!($field)),)*
                ];
                if definitions.add($ros, fields.concat()) {
                    $(<$type as $crate::message::FieldType>::define(definitions);)*
                }
            }
        }

        impl $crate::message::Message for $name {
            const NAME: &'static str = $ros;
        }
    };
}
use message;
