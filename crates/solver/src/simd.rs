//! The vector instructions that kernels are compiled for, chosen at run time.
//!
//! Every kernel is plain Rust over chunks of a fixed number of lanes, compiled once for each instruction set. Rust
//! never fuses a multiplication with an addition on its own, and sums are kept lane by lane in the same order
//! everywhere, so all instruction sets give the same bits. The chunk is as wide as the widest register, even where
//! the registers are narrower.

/// Lanes of a chunk in single precision: a register of 512 bits.
pub(crate) const SINGLE_LANES: usize = 16;

/// Lanes of a chunk in double precision: a register of 512 bits.
pub(crate) const DOUBLE_LANES: usize = SINGLE_LANES / 2;

/// An instruction set that kernels are compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Simd {
    /// The instructions that every processor of the target has.
    Portable,
    /// 256-bit vectors (`avx2`).
    Avx2,
    /// 512-bit vectors (`avx512f`, `vl`, `dq` and `bw`).
    Avx512,
}

impl Simd {
    /// The widest set that this processor has.
    #[must_use]
    pub fn detect() -> Self {
        [Self::Avx512, Self::Avx2].into_iter().find(|simd| simd.is_available()).unwrap_or(Self::Portable)
    }

    /// Whether this processor has all instructions of the set.
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

    /// This set if the processor has it, otherwise the widest it has.
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
                    // has the instructions, which `or_available` and `detect` checked.
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
