//! Coloured points as a `foxglove.PointCloud`, which every viewer draws without settings.

use contract::MonotonicNs;

use super::{FRAME, at_origin, stamp};
use crate::proto::foxglove::{PackedElementField, PointCloud, packed_element_field::NumericType};

/// Bytes of a point before what is particular to a cloud: three coordinates, four of colour.
const POINT_BYTES: u32 = 16;

/// A place in the frame `map`, metres.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Point {
    /// East.
    pub x: f64,
    /// North.
    pub y: f64,
    /// Up.
    pub z: f64,
}

/// Points that are collected for one message.
#[derive(Clone, Debug, Default)]
pub(super) struct Cloud {
    /// Names of what each point has besides place and colour, a byte each.
    extra: &'static [&'static str],
    data: Vec<u8>,
}

impl Cloud {
    /// A cloud whose points have the bytes `extra` beside place and colour.
    pub fn with(extra: &'static [&'static str], points: usize) -> Self {
        Self { extra, data: Vec::with_capacity(points * (POINT_BYTES as usize + extra.len())) }
    }

    /// Adds a point without extra bytes.
    pub fn push(&mut self, at: Point, colour: [u8; 3]) {
        for metres in [at.x, at.y, at.z] {
            self.data.extend_from_slice(&(metres as f32).to_le_bytes());
        }
        self.data.extend_from_slice(&colour);
        self.data.push(u8::MAX);
    }

    /// Adds a point with as many extra bytes as the cloud has.
    pub fn push_with<const N: usize>(&mut self, at: Point, colour: [u8; 3], extra: [u8; N]) {
        debug_assert_eq!(N, self.extra.len());
        self.push(at, colour);
        self.data.extend_from_slice(&extra);
    }

    /// The message, with `moment` as its timestamp.
    pub fn into_message(self, moment: MonotonicNs) -> PointCloud {
        let field = |name: &str, offset: u32, kind: NumericType| PackedElementField {
            name: name.into(),
            offset,
            r#type: kind.into(),
        };
        let places = ["x", "y", "z"].into_iter().zip([0, 4, 8]);
        let bytes = ["red", "green", "blue", "alpha"].into_iter().chain(self.extra.iter().copied());
        let mut fields: Vec<_> =
            places.map(|(name, offset)| field(name, offset, NumericType::Float32)).collect();
        fields.extend(bytes.zip(12..).map(|(name, offset)| field(name, offset, NumericType::Uint8)));
        PointCloud {
            timestamp: stamp(moment),
            frame_id: FRAME.into(),
            pose: at_origin(),
            point_stride: POINT_BYTES + self.extra.len() as u32,
            fields,
            data: self.data,
        }
    }
}
