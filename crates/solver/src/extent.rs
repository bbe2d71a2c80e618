//! The range of a world's payoffs, and the bounds on its values that follow.

use crate::grid_world::Class;
use crate::simd::{DOUBLE_LANES, Simd, dispatch};
use crate::{GridWorld, Kind, Leaving, Rules};

/// The range of a world's payoffs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Extent {
    /// Largest |r| of free ground; 0 if there is none.
    pub free_max: f64,
    /// Largest |r| of a goal; 0 if there is none.
    pub goal_max: f64,
    /// The least payoff of nodes where the hopper is not lost, at most 0.
    pub worst: f64,
    /// Whether the hopper is lost at some node.
    pub any_lost: bool,
    /// The goal that pays most; the last among equals.
    pub best_goal: Option<usize>,
}

impl Extent {
    /// Scans all nodes of `world`.
    pub fn of(simd: Simd, world: &GridWorld) -> Self {
        let (payoffs, classes) = world.payoffs();
        let mut extent = Self { free_max: 0.0, goal_max: 0.0, worst: 0.0, any_lost: false, best_goal: None };
        let mut best = f64::NEG_INFINITY;
        for start in (0..payoffs.len()).step_by(SPAN) {
            let end = payoffs.len().min(start + SPAN);
            let (free_max, worst, kinds) = span(simd, &payoffs[start..end], &classes[start..end]);
            extent.free_max = extent.free_max.max(free_max);
            extent.worst = extent.worst.min(worst);
            extent.any_lost |= kinds.is_lost();
            if !kinds.is_goal() {
                continue;
            }
            for node in (start..end).filter(|&node| classes[node].kind() == Kind::Goal) {
                extent.goal_max = extent.goal_max.max(payoffs[node].abs());
                if payoffs[node] >= best {
                    (best, extent.best_goal) = (payoffs[node], Some(node));
                }
            }
        }
        extent
    }

    /// The largest |r + V*| possible under `rules`.
    pub fn afterstate_max(&self, rules: &Rules) -> f64 {
        (self.free_max / (1.0 - rules.discount)).max(self.goal_max).max(rules.loss.abs())
    }

    /// A lower bound on the value of any free node under `rules`.
    pub fn value_min(&self, rules: &Rules) -> f64 {
        let worst_forever = self.worst / (1.0 - rules.discount);
        let may_lose = rules.leaving == Leaving::Loses || self.any_lost;
        if may_lose { worst_forever.min(rules.loss) } else { worst_forever }
    }
}

impl GridWorld {
    /// The largest |r + V*| possible, the loss included: the largest payoff for ever, or a goal's, or the loss.
    #[must_use]
    pub fn afterstate_max(&self) -> f64 {
        Extent::of(Simd::detect(), self).afterstate_max(self.rules())
    }
}

/// Nodes per call of the kernel.
const SPAN: usize = 512;
/// Lanes of a chunk: two registers, so that the comparisons of one do not wait for the other's.
const LANES: usize = 2 * DOUBLE_LANES;

dispatch! {
    /// Largest |r| of free ground, least r where the hopper is not lost (at most 0), and the union of all classes.
    fn span(payoffs: &[f64], classes: &[Class]) -> (f64, f64, Class) = span_lanes
}

#[inline(always)]
fn span_lanes(payoffs: &[f64], classes: &[Class]) -> (f64, f64, Class) {
    let mut kinds = Class::NONE;
    for class in classes {
        kinds = kinds.or(*class);
    }
    let [mut free_max, mut worst] = [[0.0_f64; LANES]; 2];
    let (payoff_chunks, class_chunks) = (payoffs.chunks_exact(LANES), classes.chunks_exact(LANES));
    let rest = payoff_chunks.remainder().iter().zip(class_chunks.remainder());
    for (payoffs, classes) in payoff_chunks.zip(class_chunks) {
        for lane in 0..LANES {
            let size = if classes[lane].is_free() { payoffs[lane].abs() } else { 0.0 };
            free_max[lane] = if size > free_max[lane] { size } else { free_max[lane] };
            let payoff = if classes[lane].is_lost() { 0.0 } else { payoffs[lane] };
            worst[lane] = if payoff < worst[lane] { payoff } else { worst[lane] };
        }
    }
    for (payoff, class) in rest {
        free_max[0] = if class.is_free() { free_max[0].max(payoff.abs()) } else { free_max[0] };
        worst[0] = if class.is_lost() { worst[0] } else { worst[0].min(*payoff) };
    }
    (free_max.into_iter().fold(0.0, f64::max), worst.into_iter().fold(0.0, f64::min), kinds)
}
