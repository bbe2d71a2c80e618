//! What is made for viewers, read by the messages of Foxglove's own crate.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use contract::MonotonicNs;
use foxglove::messages::{FrameTransforms, Log, PointCloud, packed_element_field::NumericType};
use prost::Message as _;
use recording::{Channel, Topic, Transcript};

/// P-VIEWERS-SCHEMAS: What is made for viewers is read back by the messages of Foxglove's own
/// crate.
#[test]
fn what_is_made_for_viewers_is_what_foxglove_reads() {
    let mut transcript = Transcript::default();
    for message in hostile::recording::messages() {
        transcript.on(message, MonotonicNs(1_000));
    }
    transcript.finish(MonotonicNs(2_000));
    let (mut clouds, mut transforms, mut lines) = (0, 0, 0);
    for message in transcript.take() {
        match message.topic {
            Topic::Known(
                Channel::ViewLayer(_) | Channel::ViewPlan | Channel::ViewRoute | Channel::ViewRobots,
            ) => {
                let cloud = PointCloud::decode(message.data.as_slice()).unwrap();
                assert_eq!(cloud.frame_id, "map");
                assert_eq!(cloud.data.len() % cloud.point_stride as usize, 0);
                let width = |kind: i32| if kind == NumericType::Float32 as i32 { 4 } else { 1 };
                let bytes: u32 = cloud.fields.iter().map(|field| width(field.r#type)).sum();
                assert_eq!(bytes, cloud.point_stride, "{:?}", cloud.fields);
                let names: Vec<&str> = cloud.fields.iter().map(|field| field.name.as_str()).collect();
                assert_eq!(names[..7], ["x", "y", "z", "red", "green", "blue", "alpha"]);
                clouds += 1;
            }
            Topic::Known(Channel::ViewTransforms) => {
                let message = FrameTransforms::decode(message.data.as_slice()).unwrap();
                let transform = &message.transforms[0];
                assert_eq!(
                    (transform.parent_frame_id.as_str(), transform.child_frame_id.as_str()),
                    ("map", "r0")
                );
                transforms += 1;
            }
            Topic::Known(Channel::ViewLog) => {
                assert!(!Log::decode(message.data.as_slice()).unwrap().message.is_empty());
                lines += 1;
            }
            _ => {}
        }
    }
    assert!(clouds >= 3 && transforms >= 2 && lines >= 2, "{clouds} {transforms} {lines}");
}
