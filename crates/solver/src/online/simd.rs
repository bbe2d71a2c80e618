//! The relaxation compiled for the processor at hand.
//!
//! The same Rust is compiled three times, for ever wider registers. Nothing is fused or reordered, so the
//! three give the same bits.

use super::field::Field;
use super::relaxation::{Limits, Relaxation};

/// [`Relaxation::relax`] with the widest registers there are.
pub(super) fn relax<const FIELDS: usize>(relaxation: &mut Relaxation<FIELDS>, field: &Field, limits: &Limits) -> u64 {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("avx512dq")
        {
            // SAFETY: the processor has what the function is compiled for.
            return unsafe { relax_avx512(relaxation, field, limits) };
        }
        if is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has what the function is compiled for.
            return unsafe { relax_avx2(relaxation, field, limits) };
        }
    }
    relaxation.relax(field, limits)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx2,bmi1,bmi2")]
fn relax_avx512<const FIELDS: usize>(
    relaxation: &mut Relaxation<FIELDS>,
    field: &Field,
    limits: &Limits,
) -> u64 {
    relaxation.relax(field, limits)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2")]
fn relax_avx2<const FIELDS: usize>(
    relaxation: &mut Relaxation<FIELDS>,
    field: &Field,
    limits: &Limits,
) -> u64 {
    relaxation.relax(field, limits)
}
