//! The relaxation compiled for the processor at hand.
//!
//! The same Rust is compiled three times, for ever wider registers. Nothing is fused or reordered, so the
//! three give the same bits.

use super::field::Field;
use super::relaxation::{Limits, Relaxation};

/// [`Relaxation::relax`] with the widest registers there are.
pub(super) fn relax<const FIELDS: usize>(
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
            return unsafe { relax_avx512(relaxation, field, limits) };
        }
        if has_avx2() {
            // SAFETY: the processor has what the function is compiled for.
            return unsafe { relax_avx2(relaxation, field, limits) };
        }
    }
    relaxation.relax(field, limits)
}

/// Whether the processor has all that [`relax_avx2`] is compiled for.
#[cfg(target_arch = "x86_64")]
fn has_avx2() -> bool {
    is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("bmi2")
        && is_x86_feature_detected!("popcnt")
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx2,bmi1,bmi2,popcnt")]
fn relax_avx512<const FIELDS: usize>(
    relaxation: &mut Relaxation<FIELDS>,
    field: &Field,
    limits: &Limits,
) -> u64 {
    relaxation.relax(field, limits)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,popcnt")]
fn relax_avx2<const FIELDS: usize>(
    relaxation: &mut Relaxation<FIELDS>,
    field: &Field,
    limits: &Limits,
) -> u64 {
    relaxation.relax(field, limits)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::specimen::Specimen;

    /// P-LANES.
    #[test]
    fn every_width_of_registers_gives_the_same_bits() {
        for specimen in [Specimen::plain(37, 3), Specimen::trap(21, 4)] {
            let world = specimen.world().expect("a size in range");
            let field = Field::new(&world);
            let limits =
                Limits { tolerance: 1e-8, finest: 1e-8, frozen_from: usize::MAX, visits_max: 20_000 };
            let solved = |relax: &dyn Fn(&mut Relaxation<2>) -> u64| {
                let mut relaxation = Relaxation::<2>::default();
                for (worths, value) in relaxation.worths.iter_mut().zip([-300.0, 50.0]) {
                    field.worths(&world, &vec![value; world.nodes()], worths);
                }
                relaxation.clear(&field.rings);
                (0..field.rings.levels).for_each(|level| relaxation.touch_level(&field.rings, level));
                let visits = relax(&mut relaxation);
                let bits = |worths: &Vec<f64>| worths.iter().map(|worth| worth.to_bits()).collect::<Vec<_>>();
                (visits, bits(&relaxation.worths[0]), bits(&relaxation.worths[1]))
            };
            let scalar = solved(&|relaxation| relaxation.relax(&field, &limits));
            assert!(scalar == solved(&|relaxation| relax(relaxation, &field, &limits)));
            #[cfg(target_arch = "x86_64")]
            if has_avx2() {
                // SAFETY: the processor has what the function is compiled for.
                assert!(scalar == solved(&|relaxation| unsafe { relax_avx2(relaxation, &field, &limits) }));
            }
        }
    }
}
