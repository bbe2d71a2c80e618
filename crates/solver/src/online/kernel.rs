//! Bellman's backup of a block of nodes, in vector lanes.
//!
//! In afterstate values W = r + V the equation of a node is W = b + d max_u Σ p W(x′), with b = r (1 + γλ) and
//! d = γ (1 − λ + λγ). With s_u, s_v the slopes towards u and v, t = max(0, slope towards the hop), and
//! O, I the values outwards and inwards along an axis, the slope law ([`scatter`]) gives
//!
//! Σ p W = p (ahead + t (here − ahead)) + q here + s ((O + I) + slope (O − I)),
//!
//! O, I, slope being those of the other axis. Of the two hops along an axis the better is the one that leads
//! to the larger value, whatever p. Every processor performs the same operations in the same order, and fuses a product
//! and a sum exactly where the code says `mul_add`, so the width of its registers changes no bit.

use crate::simd::DOUBLE_LANES as LANES;

/// One number per lane.
pub(super) type Lanes = [f64; LANES];

/// The landings of hops from one soil on the flat, times the soil's discount d.
#[derive(Clone, Copy, Debug)]
pub(super) struct SoilCoefficients {
    /// d p: lands ahead on the flat.
    pub ahead: f64,
    /// d s: slips to one side on the flat.
    pub sideways: f64,
    /// d q: gets stuck.
    pub stuck: f64,
    /// 1 / (1 − d q), or 0 for an entry that must not change.
    pub gain: f64,
}

impl SoilCoefficients {
    /// Keeps an entry of base 0 as it is: its residual is 0 whatever finite values lie around it.
    pub const STILL: Self = Self { ahead: 0.0, sideways: 0.0, stuck: 1.0, gain: 0.0 };
}

/// The soils of a block, lane by lane, in the form that the backup uses.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct SoilLanes {
    ahead: Lanes,
    sideways: Lanes,
    /// d q − 1.
    stuck: Lanes,
    gain: Lanes,
    /// d p / (1 − d q)², times [`UPHILL_FACTOR`].
    uphill_gain: Lanes,
}

/// Factor of the first-order term in y, see [`backup`]. Chosen for the least work on 200 x 200 nodes among 1, 1.15,
/// 1.25, 1.35 and 1.5.
const UPHILL_FACTOR: f64 = 1.25;

impl SoilLanes {
    /// Collects the soil of each lane.
    pub fn each(soils: [&SoilCoefficients; LANES]) -> Self {
        Self {
            ahead: soils.map(|soil| soil.ahead),
            sideways: soils.map(|soil| soil.sideways),
            stuck: soils.map(|soil| soil.stuck - 1.0),
            gain: soils.map(|soil| soil.gain),
            uphill_gain: soils.map(|soil| UPHILL_FACTOR * (soil.ahead * (soil.gain * soil.gain))),
        }
    }
}

/// Afterstate values of a block and its neighbours.
pub(super) struct Stencil<'a> {
    pub here: &'a Lanes,
    pub in_u: &'a Lanes,
    pub in_v: &'a Lanes,
    pub out_u: &'a Lanes,
    pub out_v: &'a Lanes,
}

/// The block's own numbers: base b, and slopes towards u and v in slope limits.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
pub(super) struct NodeLanes {
    pub base: Lanes,
    pub slope_u: Lanes,
    pub slope_v: Lanes,
}

/// Residual TW − W of each lane, and its value after a step that approximately solves its equation. Where the residual
/// is at most `tolerance`, the value stays. A step need not be exact, because only residuals enter the proof.
///
/// **Own node.** A step changes the node's own equation through the share that stays there, d q + d p t for the best
/// hop, so the exact step is (TW − W) / (1 − d q − d p t). With g = 1 / (1 − d q) and y = g d p t that is g / (1 − y)
/// times the residual. The kernel takes g (1 + [`UPHILL_FACTOR`] y), which is exact for y = 0 and y = 1/5; y is rarely
/// larger where an uphill hop is best at all.
///
/// **Next node.** Slips outwards land on nodes whose best hop leads inwards, and whose values follow: not to this node,
/// but to the one beside it on the ring. (A hop inwards along u from (u, v) slips to (u, v + 1); from there a hop
/// inwards along u lands on (u − 1, v + 1), the next lane.) So d s / (1 − d q − d p t) of that lane's step is added, as
/// on the flat; at either end of a block, of the lane's own step.
///
/// # Safeguarded steps
/// Such steps may cycle: the neighbour may not follow, and while a value falls another hop may become the best.
/// `SAFEGUARDED` steps cannot cycle. A node's residual is convex in its value, so upwards the tangent of the best hop
/// reaches 0 no later than the residual does, and g (1 + y + y² + y³) is less still. Downwards the step is
/// (TW − W) / (1 − d q), which is Gauss–Seidel with the stuck share solved for, a contraction.
#[inline(always)]
pub(super) fn backup<const SAFEGUARDED: bool>(
    soil: &SoilLanes,
    ground: &NodeLanes,
    around: &Stencil<'_>,
    tolerance: f64,
) -> (Lanes, Lanes) {
    let mut residual = [0.0; LANES];
    let mut step = [0.0; LANES];
    let mut coupling = [0.0; LANES];
    let mut towards_v = [false; LANES];
    for lane in 0..LANES {
        let here = around.here[lane];
        let (ahead, sideways) = (soil.ahead[lane], soil.sideways[lane]);
        // The terms common to all hops, less W.
        let stays = soil.stuck[lane].mul_add(here, ground.base[lane]);
        // Along an axis: the value where the better hop lands, its slope uphill, and the terms of slips to either side.
        let axis = |inwards: f64, outwards: f64, slope: f64| {
            let up = if slope > 0.0 { slope } else { 0.0 };
            let down = up - slope;
            let inwards_lands = down.mul_add(here - inwards, inwards);
            let outwards_lands = up.mul_add(here - outwards, outwards);
            let is_outwards = outwards_lands > inwards_lands;
            let lands = if is_outwards { outwards_lands } else { inwards_lands };
            let uphill = if is_outwards { up } else { down };
            let slips = sideways.mul_add(slope.mul_add(outwards - inwards, outwards + inwards), stays);
            (lands, uphill, slips)
        };
        let (lands_u, uphill_u, slips_u) = axis(around.in_u[lane], around.out_u[lane], ground.slope_u[lane]);
        let (lands_v, uphill_v, slips_v) = axis(around.in_v[lane], around.out_v[lane], ground.slope_v[lane]);
        let (hop_u, hop_v) = (ahead.mul_add(lands_u, slips_v), ahead.mul_add(lands_v, slips_u));
        let is_v = hop_v > hop_u;
        let short = if is_v { hop_v } else { hop_u };
        let uphill = if is_v { uphill_v } else { uphill_u };
        let gain = if !SAFEGUARDED {
            soil.uphill_gain[lane].mul_add(uphill, soil.gain[lane])
        } else if short < 0.0 {
            soil.gain[lane]
        } else {
            let y = -soil.stuck[lane] * soil.uphill_gain[lane] * (uphill / UPHILL_FACTOR);
            soil.gain[lane] * ((1.0 + y) * (1.0 + y * y))
        };
        residual[lane] = short;
        step[lane] = short * gain;
        coupling[lane] = sideways * gain;
        towards_v[lane] = is_v;
    }
    if !SAFEGUARDED {
        let above: Lanes = std::array::from_fn(|lane| step[(lane + 1).min(LANES - 1)]);
        let below: Lanes = std::array::from_fn(|lane| step[lane.saturating_sub(1)]);
        for lane in 0..LANES {
            let beside = if towards_v[lane] { below[lane] } else { above[lane] };
            step[lane] = coupling[lane].mul_add(beside, step[lane]);
        }
    }
    let mut next = *around.here;
    for lane in 0..LANES {
        next[lane] += if residual[lane].abs() <= tolerance { 0.0 } else { step[lane] };
    }
    (residual, next)
}
