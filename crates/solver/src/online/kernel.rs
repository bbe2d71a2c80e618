//! Bellman's backup of a block of nodes, many lanes at a time.
//!
//! In worths W = r + V the equation of a node is W = b + d max_u Σ p W(x′), with b = r (1 + γλ) and
//! d = γ (1 − λ + λγ). With s_u, s_v the slopes towards u and v, t = max(0, slope towards the hop), and
//! O, I the worths outwards and inwards along an axis, the module's table in [`crate::world`] gives
//!
//! Σ p W = p (ahead + t (here − ahead)) + q here + s ((O + I) + slope (O − I)),
//!
//! O, I, slope being those of the other axis. The same operations in the same order on every processor,
//! none of them fused: lanes differ in nothing but how many are worked on at once.

use super::rings::LANES;

/// By how much of what a node moves its outward neighbours follow it, about.
const FOLLOW: f64 = 0.99;

/// A number a lane.
pub(super) type Lanes = [f64; LANES];

/// What hops from one soil do, times the soil's discount d.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Scattered {
    /// d p: lands ahead on the flat.
    pub ahead: f64,
    /// d s: slips to one side on the flat.
    pub sideways: f64,
    /// d q: gets stuck.
    pub stuck: f64,
    /// 1 / (1 − d q), or 0 to leave the node as it is.
    pub gain: f64,
}

/// The same, a lane each.
pub(super) struct ScatteredLanes {
    pub ahead: Lanes,
    pub sideways: Lanes,
    pub stuck: Lanes,
    pub gain: Lanes,
}

impl ScatteredLanes {
    /// One soil in all lanes.
    #[inline(always)]
    pub fn uniform(soil: &Scattered) -> Self {
        Self {
            ahead: [soil.ahead; LANES],
            sideways: [soil.sideways; LANES],
            stuck: [soil.stuck; LANES],
            gain: [soil.gain; LANES],
        }
    }

    /// The soil of each lane, by its index; no soil leaves a lane's node as it is.
    #[inline(always)]
    pub fn each(soils: &[Scattered], classes: &[u8; LANES]) -> Self {
        let mut lanes = Self::uniform(&Scattered::default());
        for (index, soil) in soils.iter().enumerate() {
            for (lane, class) in classes.iter().enumerate() {
                let is = usize::from(*class) == index;
                lanes.ahead[lane] = if is { soil.ahead } else { lanes.ahead[lane] };
                lanes.sideways[lane] = if is { soil.sideways } else { lanes.sideways[lane] };
                lanes.stuck[lane] = if is { soil.stuck } else { lanes.stuck[lane] };
                lanes.gain[lane] = if is { soil.gain } else { lanes.gain[lane] };
            }
        }
        lanes
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
pub(super) struct Ground<'a> {
    pub base: &'a Lanes,
    pub slope_u: &'a Lanes,
    pub slope_v: &'a Lanes,
}

/// Residual TW − W of each lane, and about how far W has to go to satisfy its equation. Both are 0 where
/// the soil's gain is.
///
/// A step d moves the node's own equation by what stays where it is, d q + d p t for the best hop, and soon
/// by what slips outwards, since the nodes there lead inwards and follow. So the step is
/// (TW − W) / (1 − d q − d p t − slip), the quotient by its series to y³: it need not be exact, for only the
/// residual is believed.
#[inline(always)]
pub(super) fn backup(soil: &ScatteredLanes, ground: &Ground<'_>, around: &Around<'_>) -> (Lanes, Lanes) {
    let mut residual = [0.0; LANES];
    let mut step = [0.0; LANES];
    for lane in 0..LANES {
        let here = around.here[lane];
        let (in_u, out_u) = (around.in_u[lane], around.out_u[lane]);
        let (in_v, out_v) = (around.in_v[lane], around.out_v[lane]);
        let (slope_u, slope_v) = (ground.slope_u[lane], ground.slope_v[lane]);
        let (ahead, sideways) = (soil.ahead[lane], soil.sideways[lane]);
        let beside_v = sideways * ((out_u + in_u) + slope_u * (out_u - in_u));
        let beside_u = sideways * ((out_v + in_v) + slope_v * (out_v - in_v));
        let up = |slope: f64| if slope > 0.0 { slope } else { 0.0 };
        let hop = |to: f64, uphill: f64, beside: f64| ahead * (to + uphill * (here - to)) + beside;
        let (up_u, down_u) = (up(slope_u), up(-slope_u));
        let (up_v, down_v) = (up(slope_v), up(-slope_v));
        let better = |a: (f64, f64), b: (f64, f64)| {
            (if b.0 > a.0 { b.0 } else { a.0 }, if b.0 > a.0 { b.1 } else { a.1 })
        };
        // Beside each hop's worth, what comes back of a step: what stays, and what slips outwards.
        let along_u = better((hop(in_u, down_u, beside_u), down_u), (hop(out_u, up_u, beside_u), up_u));
        let along_v = better((hop(in_v, down_v, beside_v), down_v), (hop(out_v, up_v, beside_v), up_v));
        let back = |(worth, uphill): (f64, f64), slope: f64| {
            (worth, ahead * uphill + FOLLOW * (sideways * (1.0 + slope)))
        };
        let (best, back) = better(back(along_u, slope_v), back(along_v, slope_u));
        let free = if soil.gain[lane] > 0.0 { 1.0 } else { 0.0 };
        let short = free * ((ground.base[lane] + (best + soil.stuck[lane] * here)) - here);
        // 1 / (1 − y) for y up to a half, by its series.
        let y = back * soil.gain[lane];
        let series = (1.0 + y) * (1.0 + y * y);
        residual[lane] = short;
        step[lane] = short * (soil.gain[lane] * series);
    }
    (residual, step)
}
