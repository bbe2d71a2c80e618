//! The relaxation compiled for the processor at hand.
//!
//! The same Rust is compiled three times, for ever wider registers. Nothing is reordered, and products are fused
//! with sums where the kernel says so and nowhere else, so the three give the same bits. A processor without fused
//! operations computes them in software, to the same bits but slowly.

use super::field::Field;
use super::relaxation::{Limits, Relaxation};

/// Relaxes ([`Relaxation::relax`]) with the widest registers there are, carefully where that is needed.
pub(super) fn relax<const FIELDS: usize>(
    relaxation: &mut Relaxation<FIELDS>,
    field: &Field,
    limits: &Limits,
) -> u64 {
    let visits = relax_with::<FIELDS, false>(relaxation, field, limits);
    if !relaxation.is_restless(&field.rings) {
        return visits;
    }
    let visits_max = limits.visits_max.saturating_sub(visits);
    visits + relax_with::<FIELDS, true>(relaxation, field, &Limits { visits_max, ..*limits })
}

fn relax_with<const FIELDS: usize, const CAREFUL: bool>(
    relaxation: &mut Relaxation<FIELDS>,
    field: &Field,
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
            return unsafe { relax_avx512::<FIELDS, CAREFUL>(relaxation, field, limits) };
        }
        if has_avx2() {
            // SAFETY: the processor has what the function is compiled for.
            return unsafe { relax_avx2::<FIELDS, CAREFUL>(relaxation, field, limits) };
        }
    }
    relaxation.relax::<CAREFUL>(field, limits)
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
fn relax_avx512<const FIELDS: usize, const CAREFUL: bool>(
    relaxation: &mut Relaxation<FIELDS>,
    field: &Field,
    limits: &Limits,
) -> u64 {
    relaxation.relax::<CAREFUL>(field, limits)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,popcnt")]
fn relax_avx2<const FIELDS: usize, const CAREFUL: bool>(
    relaxation: &mut Relaxation<FIELDS>,
    field: &Field,
    limits: &Limits,
) -> u64 {
    relaxation.relax::<CAREFUL>(field, limits)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::specimen::Specimen;

    /// P-LANES.
    #[test]
    fn every_width_of_registers_gives_the_same_bits() {
        // From that level on, the rings of the last are of several rows.
        for (specimen, level) in
            [(Specimen::plain(37, 3), 0), (Specimen::trap(21, 4), 0), (Specimen::plain(560, 5), 515)]
        {
            let world = specimen.world().expect("a size in range");
            let field = Field::new(&world);
            let limits =
                Limits { tolerance: 1e-8, finest: 1e-8, frozen_from: usize::MAX, visits_max: 20_000 };
            let solved = |careful: bool, relax: &dyn Fn(&mut Relaxation<2>) -> u64| {
                let mut relaxation = Relaxation::<2>::default();
                for (worths, value) in relaxation.worths.iter_mut().zip([-300.0, 50.0]) {
                    field.worths(&world, &vec![value; world.nodes()], worths);
                }
                relaxation.clear(&field.rings);
                (level..field.rings.levels).for_each(|level| relaxation.touch_level(&field.rings, level));
                if careful {
                    relaxation.tire(&field.rings);
                }
                let visits = relax(&mut relaxation);
                let bits = |worths: &Vec<f64>| worths.iter().map(|worth| worth.to_bits()).collect::<Vec<_>>();
                (visits, bits(&relaxation.worths[0]), bits(&relaxation.worths[1]))
            };
            let bold = solved(false, &|relaxation| relaxation.relax::<false>(&field, &limits));
            let careful = solved(true, &|relaxation| relaxation.relax::<true>(&field, &limits));
            assert!(bold.0 > 0 && careful.0 > 0 && bold.1 != careful.1);
            assert!(bold == solved(false, &|relaxation| relax_with::<2, false>(relaxation, &field, &limits)));
            assert!(
                careful == solved(true, &|relaxation| relax_with::<2, true>(relaxation, &field, &limits))
            );
            #[cfg(target_arch = "x86_64")]
            if has_avx2() {
                // SAFETY: the processor has what the function is compiled for.
                let of = |relaxation: &mut Relaxation<2>| unsafe {
                    relax_avx2::<2, false>(relaxation, &field, &limits)
                };
                assert!(bold == solved(false, &of));
                // SAFETY: as above.
                let of = |relaxation: &mut Relaxation<2>| unsafe {
                    relax_avx2::<2, true>(relaxation, &field, &limits)
                };
                assert!(careful == solved(true, &of));
            }
        }
    }
}
