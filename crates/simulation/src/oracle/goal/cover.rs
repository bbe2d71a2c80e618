//! Ground that robots cover together: all of them have reached it once it is covered, which `oracle/covering.rs` says.

use contract::Cover;

use super::Goal;

impl Goal for Cover {}
