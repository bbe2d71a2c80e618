//! Standard deviation of the speed of a driving rover, under what was observed.

use super::{Definition, Look, Scale, Value};
use crate::colour;

pub(super) const LAYER: Definition = Definition {
    name: "spread",
    menu: "spread of speed",
    title: "spread of speed",
    heading: "Spread of the speed at the end",
    quantity: "standard deviation of speed (m/Sol)",
    unit: "m/Sol",
    legend: "m/Sol standard deviation",
    look: Look::Scale(Scale {
        most: 100.0,
        ramp: &colour::SPREADS,
        value: Value::Speed { of: |[_, spread]| spread, words: "± {} m/Sol" },
    }),
    exists: |brief| brief.sampling.is_some(),
    is_first: |_| false,
};
