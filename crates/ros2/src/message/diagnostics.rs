//! `diagnostic_msgs`.

use serde::Serialize;

use super::{FieldType, Header, message};

/// A `byte` of ROS.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Byte(pub u8);

impl FieldType for Byte {
    fn spelling() -> String {
        "byte".to_owned()
    }
}

message! {
    /// A figure, by name.
    KeyValue = "diagnostic_msgs/KeyValue" {
        /// The name.
        key: String,
        /// The figure.
        value: String,
    }
}

message! {
    /// How a component does.
    DiagnosticStatus = "diagnostic_msgs/DiagnosticStatus" with "byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\n" {
        /// One of [`DiagnosticStatus::OK`], [`DiagnosticStatus::WARN`] and [`DiagnosticStatus::ERROR`].
        level: Byte,
        /// The component.
        name: String,
        /// In a few words.
        message: String,
        /// The machine.
        hardware_id: String,
        /// In figures.
        values: Vec<KeyValue>,
    }
}

impl DiagnosticStatus {
    /// All is well.
    pub const OK: Byte = Byte(0);
    /// Something is to be looked at.
    pub const WARN: Byte = Byte(1);
    /// Something has failed.
    pub const ERROR: Byte = Byte(2);
}

message! {
    /// How several components do.
    DiagnosticArray = "diagnostic_msgs/DiagnosticArray" {
        /// The moment.
        header: Header,
        /// One for each component.
        status: Vec<DiagnosticStatus>,
    }
}
