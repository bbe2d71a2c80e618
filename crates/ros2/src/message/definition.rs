//! What a message's definition is made of.

use serde::Serialize;

/// Between the definition of a message and those that it uses.
const SEPARATOR: &str = "================================================================================\n";

/// A message of ROS 2.
pub trait Message: FieldType {
    /// Package and name, such as `nav_msgs/Path`.
    const NAME: &'static str;

    /// The name of its type, such as `nav_msgs/msg/Path`.
    #[must_use]
    fn type_name() -> String {
        Self::NAME.replacen('/', "/msg/", 1)
    }
}

/// What a field of a message can hold.
pub trait FieldType: Serialize {
    /// Its type as definitions spell it, such as `float64[36]`.
    #[must_use]
    fn spelling() -> String;

    /// Adds the definitions of the messages in it.
    fn define(_definitions: &mut Definitions) {}
}

/// Names and fields of messages, each once, in the order of their use.
#[derive(Clone, Debug, Default)]
pub struct Definitions(Vec<(&'static str, String)>);

impl Definitions {
    /// Adds a message; whether it is new.
    pub fn add(&mut self, name: &'static str, fields: String) -> bool {
        let is_new = self.0.iter().all(|(known, _)| *known != name);
        if is_new {
            self.0.push((name, fields));
        }
        is_new
    }
}

/// The definition of a message followed by those of all messages in it, as `ros2msg` in MCAP has them.
#[must_use]
pub fn definition<M: Message>() -> String {
    let mut definitions = Definitions::default();
    M::define(&mut definitions);
    let mut text = String::new();
    for (name, fields) in definitions.0 {
        if !text.is_empty() {
            text += &format!("{SEPARATOR}MSG: {name}\n");
        }
        text += &fields;
    }
    text
}

macro_rules! primitives {
    ($($type:ty = $spelling:literal,)*) => {
        $(impl FieldType for $type {
            fn spelling() -> String {
                $spelling.to_owned()
            }
        })*
    };
}

primitives! {
    i8 = "int8",
    u8 = "uint8",
    u16 = "uint16",
    i32 = "int32",
    u32 = "uint32",
    f32 = "float32",
    f64 = "float64",
    String = "string",
}

impl<T: FieldType> FieldType for Vec<T> {
    fn spelling() -> String {
        T::spelling() + "[]"
    }

    fn define(definitions: &mut Definitions) {
        T::define(definitions);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::Path;

    #[test]
    fn a_definition_has_every_message_once() {
        assert_eq!(Path::type_name(), "nav_msgs/msg/Path");
        let expected = "std_msgs/Header header\ngeometry_msgs/PoseStamped[] poses\n\
            MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n\
            MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n\
            MSG: geometry_msgs/PoseStamped\nstd_msgs/Header header\ngeometry_msgs/Pose pose\n\
            MSG: geometry_msgs/Pose\ngeometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n\
            MSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n\
            MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n";
        assert_eq!(definition::<Path>().replace(SEPARATOR, ""), expected);
        assert_eq!(SEPARATOR.len(), 81);
    }
}
