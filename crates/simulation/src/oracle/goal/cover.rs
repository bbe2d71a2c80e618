//! Ground that robots cover together; `oracle/covering.rs` says how much they have.

use contract::Cover;

use super::Goal;

impl Goal for Cover {
    fn cover(&self) -> Option<Cover> {
        Some(*self)
    }
}
