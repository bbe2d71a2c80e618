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
    /// Names of what each point has beside place and colour.
    extra: Vec<&'static str>,
    /// Whether these are 32-bit floats; bytes otherwise.
    is_float: bool,
    data: Vec<u8>,
}

impl Cloud {
    /// A cloud whose points have the bytes `extra` beside place and colour.
    pub fn with(extra: impl Into<Vec<&'static str>>, points: usize) -> Self {
        let extra = extra.into();
        let data = Vec::with_capacity(points * (POINT_BYTES as usize + extra.len()));
        Self { extra, is_float: false, data }
    }

    /// A cloud whose points have the number `extra` beside place and colour.
    pub fn with_number(extra: &'static str, points: usize) -> Self {
        let data = Vec::with_capacity(points * (POINT_BYTES as usize + size_of::<f32>()));
        Self { extra: vec![extra], is_float: true, data }
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
    pub fn push_with(&mut self, at: Point, colour: [u8; 3], extra: impl AsRef<[u8]>) {
        debug_assert_eq!(extra.as_ref().len(), self.extra_bytes());
        self.push(at, colour);
        self.data.extend_from_slice(extra.as_ref());
    }

    /// Adds a point with the number that the cloud has.
    pub fn push_with_number(&mut self, at: Point, colour: [u8; 3], number: f64) {
        self.push_with(at, colour, (number as f32).to_le_bytes());
    }

    /// Bytes of a point after place and colour.
    fn extra_bytes(&self) -> usize {
        self.extra.len() * if self.is_float { size_of::<f32>() } else { 1 }
    }

    /// The message, with `moment` as its timestamp.
    pub fn into_message(self, moment: MonotonicNs) -> PointCloud {
        let field = |name: &str, offset: u32, kind: NumericType| PackedElementField {
            name: name.into(),
            offset,
            r#type: kind.into(),
        };
        let places = ["x", "y", "z"].into_iter().zip([0, 4, 8]);
        let bytes = ["red", "green", "blue", "alpha"].into_iter().zip(12..);
        let extra_kind = if self.is_float { NumericType::Float32 } else { NumericType::Uint8 };
        let extra = self.extra.iter().zip(POINT_BYTES..);
        let mut fields: Vec<_> =
            places.map(|(name, offset)| field(name, offset, NumericType::Float32)).collect();
        fields.extend(bytes.map(|(name, offset)| field(name, offset, NumericType::Uint8)));
        fields.extend(extra.map(|(name, offset)| field(name, offset, extra_kind)));
        PointCloud {
            timestamp: stamp(moment),
            frame_id: FRAME.into(),
            pose: at_origin(),
            point_stride: POINT_BYTES + self.extra_bytes() as u32,
            fields,
            data: self.data,
        }
    }
}
