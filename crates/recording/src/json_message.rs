//! Messages that have no schema of ours: recorded as JSON, so that a new message is in recordings before it has one.

use contract::{Message, Request, RobotId};

use crate::Channel;
use crate::channel::ROBOT;

/// A public message without a [`Channel`], encoded as JSON.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JsonMessage {
    /// Name of its service.
    pub topic: String,
    /// Its fields by name, as `hopper topic echo --format json --full` prints them.
    pub json: Vec<u8>,
}

impl JsonMessage {
    /// The encoded message; `None` if it has a channel with a schema, or a value that JSON cannot hold.
    #[must_use]
    pub fn of<M: Message>(message: &M) -> Option<Self> {
        Self::of_robot(message, ROBOT)
    }

    /// A message of `robot` as JSON, under the name of the robot's own service; `None` if it has a
    /// channel with a schema, or a value that JSON cannot hold.
    #[must_use]
    pub fn of_robot<M: Message>(message: &M, robot: RobotId) -> Option<Self> {
        Self::topic::<M>()?;
        let topic = M::SERVICE.name_of(robot);
        Some(Self { topic, json: serde_json::to_vec(message).ok()? })
    }

    /// An answer of hopper-sim as JSON, under the name of its service; `None` if it has a channel with a schema, or a value that
    /// JSON cannot hold.
    #[must_use]
    pub fn of_answer<Q: Request>(answer: &Q::Response) -> Option<Self> {
        let topic = Q::SERVICE.name_of(ROBOT);
        if Channel::of(&topic).is_some() {
            return None;
        }
        Some(Self { topic, json: serde_json::to_vec(answer).ok()? })
    }

    /// Whether `topic` is that of answers to requests of type `Q` that are recorded as JSON.
    #[must_use]
    pub fn is_topic_of_answers<Q: Request>(topic: &str) -> bool {
        Q::SERVICE.name_of(ROBOT) == topic && Channel::of(topic).is_none()
    }

    /// Whether `topic` is that of messages of type `M`, of whichever robot.
    #[must_use]
    pub fn is_topic_of<M: Message>(topic: &str) -> bool {
        Self::topic::<M>().is_some_and(|first| first == topic || M::SERVICE.robot_of(topic).is_some())
    }

    /// The topic of the messages of type `M`; `None` if they have a channel with a schema.
    #[must_use]
    pub fn topic<M: Message>() -> Option<String> {
        let topic = M::SERVICE.name_of(ROBOT);
        Channel::of(&topic).is_none().then_some(topic)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use contract::message::PublishSubscribe;
    use contract::wire::Wire;
    use contract::{MonotonicNs, Refusal, Role, State};
    use serde::Serialize;

    use super::*;
    use crate::{Recorder, Recording};

    /// What is left in a battery, joules.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    struct Battery {
        charge_j: f64,
    }

    #[repr(C)]
    #[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
    struct BatteryV1 {
        charge_j: f64,
    }

    impl Wire for BatteryV1 {
        const NAME: &'static str = "hop.Battery.v1";
    }

    impl From<&Battery> for BatteryV1 {
        fn from(battery: &Battery) -> Self {
            Self { charge_j: battery.charge_j }
        }
    }

    impl TryFrom<&BatteryV1> for Battery {
        type Error = Refusal;

        fn try_from(wire: &BatteryV1) -> Result<Self, Refusal> {
            Ok(Self { charge_j: wire.charge_j })
        }
    }

    contract::fixed_payload!(Battery => BatteryV1);

    impl Message for Battery {
        const SERVICE: PublishSubscribe = PublishSubscribe::new("hop/rN/battery", &[Role::HopperSim]);
    }

    /// P-BAG-JSON: A message without a protobuf schema is recorded as JSON under the name of its
    /// service, and kept by a recovery.
    #[test]
    fn a_message_without_a_schema_is_recorded_as_json() {
        assert_eq!(JsonMessage::topic::<State>(), None, "it has a schema");
        let mut recorder = Recorder::new(&BTreeMap::new(), MonotonicNs(0)).unwrap();
        for charge_j in [2.0, 1.5] {
            let message = JsonMessage::of(&Battery { charge_j }).unwrap();
            recorder.on_json(&message, MonotonicNs(7)).unwrap();
        }
        recorder.finish(MonotonicNs(8)).unwrap();
        let bytes = recorder.bytes();
        for bytes in [&bytes, &crate::recover(&Recording::read(&bytes).unwrap()).unwrap()] {
            let recording = Recording::read(bytes).unwrap();
            assert!(recording.is_whole(), "{:?}", recording.fault);
            let entries: Vec<_> = recording.entries().collect();
            assert!(entries.iter().all(|entry| entry.topic == "hop/r0/battery" && entry.known.is_none()));
            let texts: Vec<_> =
                entries.iter().map(|entry| std::str::from_utf8(entry.data).unwrap()).collect();
            assert_eq!(texts, [r#"{"charge_j":2.0}"#, r#"{"charge_j":1.5}"#]);
            assert_eq!(entries[1].sequence, 1);
            assert_eq!(entries[0].message().unwrap(), None, "it is none of the messages with a schema");
        }
    }
}
