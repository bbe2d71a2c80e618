//! Errors of drawing pictures.

/// Why a picture cannot be drawn.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ReportError {
    /// A layer of the picture does not cover the grid.
    #[error("the picture's {layer} needs {need} cells, one for each of the grid, got {got}")]
    Cells {
        /// Which layer: "terrain", "ground", "map" or "policy".
        layer: &'static str,
        /// Number of cells of the grid.
        need: usize,
        /// Number of cells of the layer.
        got: usize,
    },
}
