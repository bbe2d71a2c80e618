//! Bounds that everything keeps to, each named once.

/// Longest side of a grid in cells.
pub const GRID_SIDE_MAX: u32 = 1024;

/// Most cells of a grid.
pub const GRID_CELLS_MAX: u32 = 1 << 20;

/// Smallest edge of a cell, metres: no hopper is smaller.
pub const CELL_SIZE_MIN_M: f64 = 1.0e-3;

/// Most decisions of a run: millions of hops, with room to spare.
pub const DECISIONS_MAX: u64 = 1 << 32;

/// Most steps of a run, in the paper's count of at most three a hop.
pub const STEPS_MAX: u64 = 3 * DECISIONS_MAX;

/// Longest budget of a decision, nanoseconds: 31 years.
pub const BUDGET_MAX_NS: u64 = 1_000_000_000_000_000_000;

/// Processes that are remembered at once; newcomers beyond are not heard until others fall silent.
pub const PEERS_MAX: usize = 64;

/// Largest height or distance that is believed, metres.
pub const LENGTH_MAX_M: f64 = 1.0e6;

/// Largest gradient that is believed, metres per metre.
pub const GRADIENT_MAX: f64 = 1.0e4;

/// Largest payoff, weight or penalty that is believed.
pub const PAYOFF_MAX: f64 = 1.0e6;

/// Most points of a route that a robot announces.
pub const ROUTE_POINTS_MAX: usize = 256;

/// Farthest that a camera sees to each side of its way, metres.
pub const CAMERA_RADIUS_MAX_M: f64 = 1000.0;

/// Longest straight leg of a route, metres: at the slowest speed it is driven within the longest time that an outcome may
/// have.
pub const LEG_MAX_M: f64 = 500.0;

/// Most samples of a planner that draws random ones.
pub const SAMPLES_MAX: u32 = 1_000_000;

/// Most robots of a mission.
pub const ROBOTS_MAX: usize = 16;

/// Most treasures of a scenario.
pub const TREASURES_MAX: usize = 16;

/// Most goals that a hopper visits in turn.
pub const GOALS_MAX: usize = 16;

/// Records in one page of the past.
pub const PAST_PAGE_RECORDS: usize = 64;

/// Most points of the way of a hop that are told.
pub const DETAIL_POINTS_MAX: usize = 48;

/// Cells in one patch of the observed map.
pub const MAP_PATCH_CELLS: usize = 1024;

/// Cells in one page of a snapshot of the observed map.
pub const MAP_PAGE_CELLS: usize = 2048;

/// Cells that one page of a snapshot looks over at most, seen or not: what it takes perception from its work.
pub const MAP_PAGE_SPAN: usize = 1 << 16;

/// Cells in one page of the truth.
pub const TRUTH_PAGE_CELLS: usize = 2048;

/// Cells in one page of the prior.
pub const PRIOR_PAGE_CELLS: usize = 1024;

/// Rows in one page of the motion table: few, since every mission has shared memory for its pages.
pub const TABLE_PAGE_ROWS: usize = 16;

/// Most patches of a run.
pub const PATCHES_MAX: u64 = 1 << 44;

/// Patches that a reader buffers while it catches up.
pub const PATCHES_BUFFERED: usize = 64;

/// Whoever asks for something and has no answer asks again after this long, nanoseconds, and no earlier:
/// asking again gives up the answer that may be on its way.
pub const ASK_AGAIN_NS: u64 = 10_000_000;

/// Changes of cells that a map remembers at least, once there were so many.
pub const CHANGES_KEPT: usize = 1 << 16;

/// Landings that changed the map after which it still tells what changed since.
pub const MARKS_KEPT: usize = 1024;

/// Most processes, live or not yet cleaned up, on one service.
pub const NODES_MAX: usize = 32;
