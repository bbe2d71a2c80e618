//! The clairvoyant's bounds of a campaign's worlds, each computed once.

use ::campaign::{Bound, Plan};
use contract::Account;
use scenario::ResolvedScenario;
use sha2::{Digest as _, Sha256};

/// Most cells × steps of a world whose bounds are computed; some ten seconds. Larger worlds go without.
const STATES_MAX: u64 = 50_000_000;

/// The bounds of each cell of `plan`, in order. `None` where the mission is not that of a hopper on its way to one goal,
/// alone or looked ahead for, where the world is larger than 50 million cells × steps, or where it cannot be built any more
/// because a file that it reads is gone.
pub fn bounds(plan: &Plan) -> Vec<Option<Bound>> {
    let mut known = std::collections::BTreeMap::<[u8; 32], Bound>::new();
    let bound = |cell: &::campaign::Cell| {
        let world = cell.world().ok()?;
        if world.brief.account != Account::Hopper || world.brief.visits().is_some() {
            return None;
        }
        // Of the law alone: where a hop ends between cells, what can be reached depends on more than the cell.
        if !world.dynamics.is_law() {
            return None;
        }
        let states = (world.brief.grid.cells() as u64).checked_mul(world.brief.limits.steps_max)?;
        if states > STATES_MAX {
            return None;
        }
        Some(*known.entry(key(&world)).or_insert_with(|| {
            let bounds = clairvoyant::bounds(&world.brief.leg(0), &world.terrain);
            Bound { success: bounds.success, restricted_mean_steps: bounds.restricted_mean_steps }
        }))
    };
    plan.cells.iter().map(bound).collect()
}

/// What the bounds depend on: ground, way, motion and clock; neither weights nor profile.
fn key(world: &ResolvedScenario) -> [u8; 32] {
    let leg = world.brief.leg(0);
    let mut hasher = Sha256::new();
    let way = (leg.grid, leg.start, leg.goal, leg.motion, leg.limits.steps_max);
    hasher.update(format!("{way:?}"));
    for ground in &world.terrain.cells {
        for value in [ground.gradient[0], ground.gradient[1]] {
            hasher.update(value.to_bits().to_le_bytes());
        }
        hasher.update([ground.soil as u8, u8::from(ground.passable)]);
    }
    hasher.finalize().into()
}
