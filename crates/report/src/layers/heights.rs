//! Heights, sand and impassable ground.

use super::{Definition, Look};

pub(super) const LAYER: Definition = Definition {
    name: "ground",
    menu: "heights",
    title: "ground",
    heading: "Heights",
    quantity: "height above datum (m)",
    unit: "m",
    legend: "m",
    look: Look::Relief,
    exists: |_| true,
    is_first: |_| false,
};
