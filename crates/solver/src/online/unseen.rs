//! First values on a map of which hardly anything has been seen.
//!
//! Where the ground is alike nearly everywhere, so is the best hop: towards the goal. Then passes outwards from ring to
//! ring ([`super::relaxation`]) settle each ring for good, or in a few passes where a strip beyond the goal takes part,
//! in all sectors at once and in the nearest caches: a dozen or two of sweeps in all, where the cold solver takes
//! hundreds if the goal lies well inside the map. On rough ground detours make outer rings decide about inner ones, and
//! the cold solver is faster by far. So this is tried where most ground is flat, and given up after
//! [`SWEEPS_MAX`] sweeps.

use super::layout::Layout;
use crate::GridWorld;
use crate::extent::Extent;
use crate::simd::Simd;

/// On fewer nodes the cold solver is as fast.
const NODES_MIN: usize = 8_000;

/// Sweeps after which the attempt ends. They take little time compared to a solve that needs as many more.
pub(super) const SWEEPS_MAX: u64 = 32;

/// The value to start every node of `world` from, a lower bound on all; `None` where the relaxation would not pay.
pub(super) fn start_value(world: &GridWorld, layout: &Layout) -> Option<f64> {
    if world.nodes() < NODES_MIN || !is_mostly_flat(world) {
        return None;
    }
    let extent = Extent::of(Simd::detect(), world);
    Some(extent.value_min(world.rules()).max(-layout.magnitude))
}

/// Whether three quarters of the nodes have no slope.
fn is_mostly_flat(world: &GridWorld) -> bool {
    let [east, north] = world.slopes();
    let flat = east.iter().zip(north).filter(|slopes| *slopes == (&0.0, &0.0)).count();
    4 * flat >= 3 * world.nodes()
}
