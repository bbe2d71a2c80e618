//! How often robots entered each cell.

use contract::Account;

use super::{Definition, Look};

pub(super) const LAYER: Definition = Definition {
    name: "visits",
    menu: "visits",
    title: "visits",
    heading: "",
    quantity: "height above datum (m)",
    unit: "m",
    legend: "m",
    look: Look::Entries,
    exists: |brief| brief.has_team(),
    is_first: |brief| brief.sampling.is_none() && brief.account != Account::Hopper,
};
