//! x
/// x
pub struct ScoutValue;
/// x
pub fn scout_value() {}
