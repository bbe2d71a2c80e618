//! What a hop does at most, so that its work is bounded.

/// Impacts and arcs of rolling that launch control follows of a hop: what goes on is too far.
pub const TRIM_IMPACTS_MAX: u32 = 64;

/// See [`TRIM_IMPACTS_MAX`].
pub const TRIM_ARCS_MAX: u32 = 2_000;

/// Hops that launch control tries out for a launch.
pub const TRIM_EVALUATIONS: u32 = 12;

/// Share of the distance within which a trimmed hop ends.
pub const TRIM_TOLERANCE: f64 = 1.0e-3;

/// Impacts; reaching it is an end of its own.
pub const IMPACTS_MAX: u32 = 10_000;

/// Arcs of rolling; reaching it, the body has rolled away.
pub const ARCS_MAX: u32 = 20_000;

/// Patches of ground that are walked in flight.
pub const PATCHES_MAX: u32 = 100_000;

/// Impacts that are told one by one; the others are counted.
pub const IMPACTS_TOLD: usize = 32;

/// An arc of rolling is this part of a cell or of a hop, whichever is shorter.
pub const ARCS_A_CELL: f64 = 16.0;

/// Share of an arc below which rolling does not get on.
pub const ARC_LEAST: f64 = 1.0e-9;
