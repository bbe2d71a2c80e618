//! Encodes messages as ROS 2 stores them: plain CDR, little-endian, behind the four bytes that say so.

use byteorder::LittleEndian;

use crate::Ros2Error;
use crate::message::Message;

/// Representation identifier `CDR_LE` and no options (RTPS 2.5, 10.5). Alignment counts from behind it.
const HEADER: [u8; 4] = [0x00, 0x01, 0x00, 0x00];

/// The bytes of a message.
///
/// # Errors
/// If a sequence or a text has more than 2³² − 1 elements.
pub fn encode<M: Message>(message: &M) -> Result<Vec<u8>, Ros2Error> {
    let mut bytes = HEADER.to_vec();
    cdr_encoding::to_writer::<M, LittleEndian, _>(&mut bytes, message)
        .map_err(|cause| Ros2Error::Encode { name: M::NAME, cause })?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::{Header, Pose, PoseStamped, Time};

    /// The layout by hand, from the rules of CDR (XTYPES 1.3, 7.4.1): each number on a multiple of its size, texts with their
    /// length and a zero.
    #[test]
    fn numbers_are_aligned_behind_the_header_and_texts_end_in_zero() {
        let header = Header { stamp: Time { sec: 1, nanosec: 2 }, frame_id: "map".into() };
        let message = PoseStamped { header, pose: Pose::at([1.0, -2.0, 0.5], 0.0) };
        let bytes = encode(&message).unwrap();
        let mut expected = vec![0, 1, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 4, 0, 0, 0];
        expected.extend(b"map\0");
        // Sixteen bytes behind the header: no padding before the first number of eight bytes.
        for number in [1.0_f64, -2.0, 0.5, 0.0, 0.0, 0.0, 1.0] {
            expected.extend(number.to_le_bytes());
        }
        assert_eq!(bytes, expected);
    }

    #[test]
    fn a_longer_text_is_followed_by_padding() {
        let header = Header { stamp: Time { sec: 0, nanosec: 0 }, frame_id: "maps".into() };
        let bytes = encode(&PoseStamped { header, pose: Pose::at([7.0, 0.0, 0.0], 0.0) }).unwrap();
        assert_eq!(bytes[16..28], [b'm', b'a', b'p', b's', 0, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(bytes[28..36], 7.0_f64.to_le_bytes());
    }
}
