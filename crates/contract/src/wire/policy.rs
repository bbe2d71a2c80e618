//! Header and cell of `hop/rN/policy`.

use crate::Role;
use crate::slice_payload;

use super::cells_at_most;
use super::declaration::wire;
use crate::codec::{ACTION, COUNTED, FINITE, NAME, ROBOT, RUN, float};
use crate::limits::GRID_CELLS_MAX;
use crate::message::{Capacity, Message, PublishSubscribe};
use crate::{Decision, Name, Policy, PolicyCell};

wire! {
    /// What the policy was made for; the payload is its cells.
    pub struct PolicyHeaderV1 = "hop.PolicyHeader.v1", 72 bytes, refused as "policy" {
        /// Run it belongs to.
        run: [u64; 2] = RUN,
        /// Decision it was made for.
        decision: u64 = COUNTED,
        /// Bound |V − V*| that its planner proves for each value, in units of payoff; 0 for planners without values.
        error_bound: f64 = float(0.0, f64::INFINITY),
        /// Robot it was made for.
        robot: u32 = ROBOT,
        reserved: u32,
        /// Algorithm of the planner.
        planner: [u8; Name::BYTES] = NAME,
    }
    of Policy { run, robot, decision: Decision(decision), planner, error_bound, cells }
    from_wire(wire) {
        cells_at_most("policy.cells", GRID_CELLS_MAX as usize, cells)?;
        let cells = cells.iter().map(PolicyCell::try_from).collect::<Result<_, _>>()?;
    }
    /// The policy of a copied message.
    ///
    /// # Errors
    /// If a value is not finite, the error bound none, or an action unknown.
    pub fn policy_from_wire(cells: &[PolicyCellV1]);
}

wire! {
    /// Action and value at one cell.
    pub struct PolicyCellV1 = "hop.PolicyCell.v1", 16 bytes, refused as "policy" {
        /// Value, in units of payoff.
        value: f64 = FINITE,
        /// Best action; a route is announced by a command alone.
        action: u32 = ACTION,
        reserved: u32,
    }
    of PolicyCell { action, value }
}

slice_payload!(Policy => PolicyHeaderV1, PolicyCellV1, cells, policy_from_wire);

/// Written while somebody reads it: hopper-sim for its fallback, a page, a recording.
impl Message for Policy {
    const SERVICE: PublishSubscribe = PublishSubscribe {
        max_publishers: 8,
        expected_publishers: 2,
        max_subscribers: 3,
        history: 0,
        capacity: Capacity::Grid,
        ..PublishSubscribe::new("hop/rN/policy", &[Role::Planner])
    };
}
