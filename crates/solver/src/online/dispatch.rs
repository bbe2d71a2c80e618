//! The relaxation, compiled for the instruction sets of the processor.
//!
//! The same Rust is compiled three times, for ever wider registers. Nothing is reordered, and a product and a sum are
//! fused only where the kernel says so, so the three give the same bits. Unlike the cold solver's kernels
//! ([`crate::simd`]) this one needs fused operations; a processor without them computes the same bits in software,
//! slowly.

use super::layout::Layout;
use super::relaxation::{Limits, Relaxation};

/// Visits of a block between two pulses: some tens of milliseconds.
const SLICE: u64 = 1 << 20;

/// Relaxes ([`Relaxation::relax`]) in slices, with a pulse after each, until it converges, the visits run out, or it gives
/// up. Returns the visits.
pub(super) fn relax_in_slices<const FIELDS: usize>(
    relaxation: &mut Relaxation<FIELDS>,
    layout: &Layout,
    limits: &Limits,
    pulse: &dyn Fn(),
) -> u64 {
    let mut visits = 0;
    while !relaxation.is_converged(&layout.rings, limits.frozen_from)
        && visits < limits.visits_max
        && !relaxation.has_given_up(&layout.rings)
    {
        let visits_max = (limits.visits_max - visits).min(SLICE);
        visits += relax(relaxation, layout, &Limits { visits_max, ..*limits });
        pulse();
    }
    visits
}

/// [`Relaxation::relax`] with the widest registers there are, with safeguarded steps where they are needed.
fn relax<const FIELDS: usize>(relaxation: &mut Relaxation<FIELDS>, layout: &Layout, limits: &Limits) -> u64 {
    let visits = relax_widest::<FIELDS, false>(relaxation, layout, limits);
    if !relaxation.needs_safeguard(&layout.rings) {
        return visits;
    }
    let visits_max = limits.visits_max.saturating_sub(visits);
    visits + relax_widest::<FIELDS, true>(relaxation, layout, &Limits { visits_max, ..*limits })
}

fn relax_widest<const FIELDS: usize, const SAFEGUARDED: bool>(
    relaxation: &mut Relaxation<FIELDS>,
    layout: &Layout,
    limits: &Limits,
) -> u64 {
    #[cfg(target_arch = "x86_64")]
    {
        if has_avx2()
            && is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("avx512dq")
        {
            // SAFETY: the processor has what the function is compiled for.
            return unsafe { relax_avx512::<FIELDS, SAFEGUARDED>(relaxation, layout, limits) };
        }
        if has_avx2() {
            // SAFETY: the processor has what the function is compiled for.
            return unsafe { relax_avx2::<FIELDS, SAFEGUARDED>(relaxation, layout, limits) };
        }
    }
    relaxation.relax::<SAFEGUARDED>(layout, limits)
}

/// Whether the processor has all that [`relax_avx2`] is compiled for.
#[cfg(target_arch = "x86_64")]
fn has_avx2() -> bool {
    is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("fma")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("bmi2")
        && is_x86_feature_detected!("popcnt")
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx2,fma,bmi1,bmi2,popcnt")]
fn relax_avx512<const FIELDS: usize, const SAFEGUARDED: bool>(
    relaxation: &mut Relaxation<FIELDS>,
    layout: &Layout,
    limits: &Limits,
) -> u64 {
    relaxation.relax::<SAFEGUARDED>(layout, limits)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt")]
fn relax_avx2<const FIELDS: usize, const SAFEGUARDED: bool>(
    relaxation: &mut Relaxation<FIELDS>,
    layout: &Layout,
    limits: &Limits,
) -> u64 {
    relaxation.relax::<SAFEGUARDED>(layout, limits)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::Fixture;

    /// P-LANES: Vectors of any width give the same bits.
    #[test]
    fn every_width_of_registers_gives_the_same_bits() {
        // From that level on, the rings of the last are of several rows.
        for (fixture, level) in
            [(Fixture::plain(37, 3), 0), (Fixture::trap(21, 4), 0), (Fixture::plain(560, 5), 515)]
        {
            let world = fixture.world().expect("a size in range");
            let layout = Layout::new(&world);
            let limits =
                Limits { tolerance: 1e-8, finest: 1e-8, frozen_from: usize::MAX, visits_max: 20_000 };
            let solved = |careful: bool, relax: &dyn Fn(&mut Relaxation<2>) -> u64| {
                let mut relaxation = Relaxation::<2>::default();
                for (afterstates, value) in relaxation.afterstates.iter_mut().zip([-300.0, 50.0]) {
                    layout.fill(&world, &vec![value; world.nodes()], afterstates);
                }
                relaxation.clear(&layout.rings);
                (level..layout.rings.levels).for_each(|level| relaxation.mark_level(&layout.rings, level));
                if careful {
                    relaxation.exhaust_fast_steps(&layout.rings);
                }
                let visits = relax(&mut relaxation);
                let bits = |afterstates: &Vec<f64>| {
                    afterstates.iter().map(|value| value.to_bits()).collect::<Vec<_>>()
                };
                (visits, bits(&relaxation.afterstates[0]), bits(&relaxation.afterstates[1]))
            };
            let bold = solved(false, &|relaxation| relaxation.relax::<false>(&layout, &limits));
            let careful = solved(true, &|relaxation| relaxation.relax::<true>(&layout, &limits));
            assert!(bold.0 > 0 && careful.0 > 0 && bold.1 != careful.1);
            assert!(
                bold == solved(false, &|relaxation| relax_widest::<2, false>(relaxation, &layout, &limits))
            );
            assert!(
                careful == solved(true, &|relaxation| relax_widest::<2, true>(relaxation, &layout, &limits))
            );
            #[cfg(target_arch = "x86_64")]
            if has_avx2() {
                // SAFETY: the processor has what the function is compiled for.
                let of = |relaxation: &mut Relaxation<2>| unsafe {
                    relax_avx2::<2, false>(relaxation, &layout, &limits)
                };
                assert!(bold == solved(false, &of));
                // SAFETY: as above.
                let of = |relaxation: &mut Relaxation<2>| unsafe {
                    relax_avx2::<2, true>(relaxation, &layout, &limits)
                };
                assert!(careful == solved(true, &of));
            }
        }
    }
}
