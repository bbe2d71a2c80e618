//! Bellman's backup of a block of nodes, many lanes at a time.
//!
//! In worths W = r + V the equation of a node is W = b + d max_u Σ p W(x′), with b = r (1 + γλ) and
//! d = γ (1 − λ + λγ). With s_u, s_v the slopes towards u and v, t = max(0, slope towards the hop), and
//! O, I the worths outwards and inwards along an axis, the module's table in [`crate::world`] gives
//!
//! Σ p W = p (ahead + t (here − ahead)) + q here + s ((O + I) + slope (O − I)),
//!
//! O, I, slope being those of the other axis. Of the two hops along an axis the better is the one that leads
//! to more, whatever p. The same operations in the same order on every processor, a product and a sum fused
//! exactly where it says `mul_add`: lanes differ in nothing but how many are worked on at once.

use super::rings::LANES;

/// A number a lane.
pub(super) type Lanes = [f64; LANES];

/// What hops from one soil do, times the soil's discount d.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scattered {
    /// d p: lands ahead on the flat.
    pub ahead: f64,
    /// d s: slips to one side on the flat.
    pub sideways: f64,
    /// d q: gets stuck.
    pub stuck: f64,
    /// 1 / (1 − d q), or 0 where nothing moves.
    pub gain: f64,
}

impl Scattered {
    /// Leaves a node of base 0 as it is: the residual is 0 whatever finite worths lie around it.
    pub const STILL: Self = Self { ahead: 0.0, sideways: 0.0, stuck: 1.0, gain: 0.0 };
}

/// The same, a lane each, as the backup wants it.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct ScatteredLanes {
    ahead: Lanes,
    sideways: Lanes,
    /// d q − 1.
    stuck: Lanes,
    gain: Lanes,
    /// d p / (1 − d q)², times [`BOLD`].
    pull: Lanes,
}

/// See [`backup`]. Least work on 200 x 200 nodes among 1, 1.15, 1.25, 1.35 and 1.5.
const BOLD: f64 = 1.25;

impl ScatteredLanes {
    /// The soil of each lane.
    pub fn each(soils: [&Scattered; LANES]) -> Self {
        Self {
            ahead: soils.map(|soil| soil.ahead),
            sideways: soils.map(|soil| soil.sideways),
            stuck: soils.map(|soil| soil.stuck - 1.0),
            gain: soils.map(|soil| soil.gain),
            pull: soils.map(|soil| BOLD * (soil.ahead * (soil.gain * soil.gain))),
        }
    }
}

/// Worths of a block and around it.
pub(super) struct Around<'a> {
    pub here: &'a Lanes,
    pub in_u: &'a Lanes,
    pub in_v: &'a Lanes,
    pub out_u: &'a Lanes,
    pub out_v: &'a Lanes,
}

/// What a block's nodes are.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
pub(super) struct Ground {
    pub base: Lanes,
    pub slope_u: Lanes,
    pub slope_v: Lanes,
}

/// Residual TW − W of each lane, and the worth after a step that about satisfies its equation: as it was where
/// the residual is at most `tolerance`. A step need not be exact, for only the residual is believed.
///
/// A step moves the node's own equation by what stays where it is, d q + d p t for the best hop: it is
/// (TW − W) / (1 − d q − d p t). With g = 1 / (1 − d q) and y = g d p t that is g / (1 − y) times the residual,
/// and g (1 + [`BOLD`] y) here: right for y = 0 and 1/5, and y is seldom more where one hops uphill at all. And
/// what slips outwards lands where nodes lead inwards and follow: not this node, but the one beside it on the
/// ring. (A hop inwards along u from (u, v) slips to (u, v + 1), from where a hop inwards along u lands on
/// (u − 1, v + 1), the next lane.) So d s / (1 − d q − d p t) of that lane's step is added, as on the flat; at
/// either end of a block, of its own.
///
/// # Careful
/// Such steps may go round in circles: the neighbour may not follow, and where a worth comes down another hop
/// may take over on the way. `CAREFUL` steps cannot. A node's residual is convex in its worth, so that upwards
/// the best hop's tangent ends at or below where it is 0, and g (1 + y + y² + y³) is less; downwards the step is
/// (TW − W) / (1 − d q), which is Gauss–Seidel with what gets stuck solved for, a contraction.
#[inline(always)]
pub(super) fn backup<const CAREFUL: bool>(
    soil: &ScatteredLanes,
    ground: &Ground,
    around: &Around<'_>,
    tolerance: f64,
) -> (Lanes, Lanes) {
    let mut residual = [0.0; LANES];
    let mut step = [0.0; LANES];
    let mut follow = [0.0; LANES];
    let mut towards_v = [false; LANES];
    for lane in 0..LANES {
        let here = around.here[lane];
        let (ahead, sideways) = (soil.ahead[lane], soil.sideways[lane]);
        // What is the same whatever the hop, and W taken off.
        let stays = soil.stuck[lane].mul_add(here, ground.base[lane]);
        // Along an axis: where the better hop lands, what of it is uphill, and what slips to either side add.
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
        let gain = if !CAREFUL {
            soil.pull[lane].mul_add(uphill, soil.gain[lane])
        } else if short < 0.0 {
            soil.gain[lane]
        } else {
            let y = -soil.stuck[lane] * soil.pull[lane] * (uphill / BOLD);
            soil.gain[lane] * ((1.0 + y) * (1.0 + y * y))
        };
        residual[lane] = short;
        step[lane] = short * gain;
        follow[lane] = sideways * gain;
        towards_v[lane] = is_v;
    }
    if !CAREFUL {
        let above: Lanes = std::array::from_fn(|lane| step[(lane + 1).min(LANES - 1)]);
        let below: Lanes = std::array::from_fn(|lane| step[lane.saturating_sub(1)]);
        for lane in 0..LANES {
            let beside = if towards_v[lane] { below[lane] } else { above[lane] };
            step[lane] = follow[lane].mul_add(beside, step[lane]);
        }
    }
    let mut next = *around.here;
    for lane in 0..LANES {
        next[lane] += if residual[lane].abs() <= tolerance { 0.0 } else { step[lane] };
    }
    (residual, next)
}
