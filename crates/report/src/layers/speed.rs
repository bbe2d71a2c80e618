//! Expected speed of a driving rover, under what was observed.

use super::{Definition, Look, Scale, Value};
use crate::colour;

pub(super) const LAYER: Definition = Definition {
    name: "speed",
    menu: "expected speed",
    title: "expected speed",
    heading: "Expected speed at the end",
    quantity: "expected speed (m/Sol)",
    unit: "m/Sol",
    legend: "m/Sol expected",
    look: Look::Scale(Scale {
        most: 200.0,
        ramp: &colour::SPEEDS,
        value: Value::Speed { of: |[expected, _]| expected, words: "expected {}" },
    }),
    exists: |brief| brief.sampling.is_some(),
    is_first: |brief| brief.sampling.is_some(),
};
