//! Header and cell of `hop/rN/policy`.

use bytemuck::{Pod, Zeroable};

use crate::Role;
use crate::slice_payload;

use super::{
    Wire, at_most, counted, float, name_from_wire, robot_from_wire, run_from_wire, run_to_wire, tag,
};
use crate::limits::GRID_CELLS_MAX;
use crate::message::{Capacity, Message, PublishSubscribe};
use crate::{Action, Decision, Name, Policy, PolicyCell, Refusal};

/// What the policy was made for.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct PolicyHeaderV1 {
    pub run: [u64; 2],
    /// Decision it was made for.
    pub decision: u64,
    /// Bound |V − V*| that its planner proves for each value, in units of payoff.
    pub error_bound: f64,
    pub robot: u32,
    pub reserved: u32,
    /// Algorithm, zero-padded ASCII.
    pub planner: [u8; Name::BYTES],
}

/// Action and value at one cell.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct PolicyCellV1 {
    /// Value, in units of payoff.
    pub value: f64,
    /// [`Action::code`].
    pub action: u32,
    pub reserved: u32,
}

const _: () = assert!(size_of::<PolicyHeaderV1>() == 72);
const _: () = assert!(size_of::<PolicyCellV1>() == 16);

impl Wire for PolicyHeaderV1 {
    const NAME: &'static str = "hop.PolicyHeader.v1";
}

impl Wire for PolicyCellV1 {
    const NAME: &'static str = "hop.PolicyCell.v1";
}

impl From<&Policy> for PolicyHeaderV1 {
    fn from(policy: &Policy) -> Self {
        Self {
            run: run_to_wire(policy.run),
            decision: policy.decision.0,
            error_bound: policy.error_bound,
            robot: u32::from(policy.robot.0),
            reserved: 0,
            planner: policy.planner.bytes(),
        }
    }
}

impl From<&PolicyCell> for PolicyCellV1 {
    fn from(cell: &PolicyCell) -> Self {
        Self { value: cell.value, action: cell.action.code(), reserved: 0 }
    }
}

/// The policy of a copied message.
///
/// # Errors
/// If a value is not finite, the error bound none, or an action unknown.
pub fn policy_from_wire(header: &PolicyHeaderV1, cells: &[PolicyCellV1]) -> Result<Policy, Refusal> {
    at_most("policy.cells", GRID_CELLS_MAX as usize, cells)?;
    let cell = |wire: &PolicyCellV1| {
        if !wire.value.is_finite() {
            return Err(Refusal::malformed("policy.value", "a finite value", wire.value));
        }
        Ok(PolicyCell { action: tag("policy.action", wire.action, Action::from_code)?, value: wire.value })
    };
    Ok(Policy {
        run: run_from_wire(header.run),
        robot: robot_from_wire(header.robot)?,
        decision: Decision(counted("policy.decision", header.decision)?),
        planner: name_from_wire("policy.planner", header.planner)?,
        error_bound: float("policy.error_bound", header.error_bound, 0.0, f64::INFINITY)?,
        cells: cells.iter().map(cell).collect::<Result<_, _>>()?,
    })
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
