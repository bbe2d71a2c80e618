//! Which vector instructions the kernels are compiled for, chosen at run time.
//!
//! Every kernel is one piece of plain Rust over chunks of a fixed number of lanes, compiled once for each
//! instruction set. Rust never fuses a multiplication with an addition, and sums are kept lane by lane in
//! the same order everywhere, so all paths give the same bits; the chunk is 16 lanes even where the
//! registers are narrower.

/// An instruction set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Simd {
    /// What every processor of the target has.
    Portable,
    /// 256-bit vectors.
    Avx2,
    /// 512-bit vectors.
    Avx512,
}

impl Simd {
    /// The widest that this processor has.
    #[must_use]
    pub fn detect() -> Self {
        [Self::Avx512, Self::Avx2].into_iter().find(|simd| simd.is_available()).unwrap_or(Self::Portable)
    }

    /// Whether this processor has it.
    #[must_use]
    pub fn is_available(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        return match self {
            Self::Portable => true,
            Self::Avx2 => is_x86_feature_detected!("avx2"),
            Self::Avx512 => {
                is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512vl")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx512bw")
            }
        };
        #[cfg(not(target_arch = "x86_64"))]
        return self == Self::Portable;
    }

    /// This one if the processor has it, otherwise the widest it has.
    #[must_use]
    pub fn or_available(self) -> Self {
        if self.is_available() { self } else { Self::detect() }
    }
}

impl Default for Simd {
    fn default() -> Self {
        Self::detect()
    }
}

/// Compiles a kernel for every instruction set: `name(simd, arguments)` runs `body(arguments)`.
macro_rules! dispatch {
    ($(#[$doc:meta])* $vis:vis fn $name:ident($($arg:ident: $type:ty),* $(,)?) $(-> $out:ty)? = $body:path) => {
        $(#[$doc])*
        #[allow(clippy::too_many_arguments, reason = "a kernel takes its planes one by one")]
        $vis fn $name(simd: crate::simd::Simd, $($arg: $type),*) $(-> $out)? {
            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2")]
                #[allow(clippy::too_many_arguments, reason = "as above")]
                fn avx2($($arg: $type),*) $(-> $out)? {
                    $body($($arg),*)
                }
                #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw")]
                #[allow(clippy::too_many_arguments, reason = "as above")]
                fn avx512($($arg: $type),*) $(-> $out)? {
                    $body($($arg),*)
                }
                match simd {
                    crate::simd::Simd::Portable => {}
                    // SAFETY: the kernels are safe Rust; the only condition of the call is that the processor
                    // has the instructions, and `or_available` gave no set without asking it.
                    crate::simd::Simd::Avx2 => return unsafe { avx2($($arg),*) },
                    // SAFETY: as above.
                    crate::simd::Simd::Avx512 => return unsafe { avx512($($arg),*) },
                }
            }
            let _ = simd;
            $body($($arg),*)
        }
    };
}
pub(crate) use dispatch;
