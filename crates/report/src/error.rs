//! Why a report cannot be made.

/// What was needed for the report, and what was got.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ReportError {
    /// A layer of the picture does not cover the grid.
    #[error("the picture's {layer} needs {need} cells, one for each of the grid, got {got}")]
    Cells {
        /// Which layer: "terrain", "ground", "map" or "policy".
        layer: &'static str,
        /// Cells of the grid.
        need: usize,
        /// Cells of the layer.
        got: usize,
    },
}
