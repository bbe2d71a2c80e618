//! Bounds that everything keeps to, each named once.

/// Longest side of a grid in cells.
pub const GRID_SIDE_MAX: u32 = 1024;

/// Most cells of a grid.
pub const GRID_CELLS_MAX: u32 = 1 << 20;

/// Smallest edge of a cell, metres: no hopper is smaller.
pub const CELL_SIZE_MIN_M: f64 = 1.0e-3;

/// Most decisions of a run; a million-hop patrol with room to spare.
pub const DECISIONS_MAX: u64 = 1 << 32;

/// Largest height or distance that is believed, metres.
pub const LENGTH_MAX_M: f64 = 1.0e6;

/// Largest gradient that is believed, metres per metre.
pub const GRADIENT_MAX: f64 = 1.0e4;

/// Largest payoff, weight or penalty that is believed.
pub const PAYOFF_MAX: f64 = 1.0e6;

/// Most treasures of a scenario.
pub const TREASURES_MAX: usize = 16;

/// Records in one page of the past.
pub const PAST_PAGE_RECORDS: usize = 64;
