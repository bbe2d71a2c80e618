//! Why there is no mission.

use std::path::PathBuf;

use contract::name::NameError;
use contract::{Cell, Refusal};
use terrain::TerrainError;

use crate::BUILT_IN;

/// What was needed, what was got, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum ScenarioError {
    /// Neither a scenario of the house nor a file.
    #[error("need a scenario's file or one of {}, got {got:?}", names())]
    Unknown {
        /// The selector.
        got: String,
    },
    /// The file cannot be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// More text than any scenario has.
    #[error("{}: need at most {bytes_max} bytes, got more; name the text of a scenario or a campaign", path.display())]
    TooLong {
        /// The file.
        path: PathBuf,
        /// Most bytes.
        bytes_max: u64,
    },
    /// Not a scenario; the message has line and column.
    #[error("{origin}: {message}")]
    Toml {
        /// Where the text comes from.
        origin: String,
        /// What is wrong, and where.
        message: String,
    },
    /// A name that is none.
    #[error("brief.name: {0}; set brief.name")]
    Name(#[from] NameError),
    /// A file that the scenario names is not there.
    #[error(
        "{field}: need the file {}, found none; put it there, name yours in the scenario{}",
        path.display(), if field.ends_with("mask_file") { "" } else { ", or point to it with --dem FILE" }
    )]
    FileMissing {
        /// The field that names it.
        field: &'static str,
        /// Where it was looked for.
        path: PathBuf,
    },
    /// `--dem` on generated ground.
    #[error("--dem needs a scenario with truth.terrain.elevation_file, got one whose terrain is generated")]
    DemUnused,
    /// Two crops.
    #[error("truth.terrain.elevation_file: need crop_cells or crop_m, got both; keep one")]
    TwoCrops,
    /// Something is wrong with the terrain.
    #[error(transparent)]
    Terrain(#[from] TerrainError),
    /// A field out of its range.
    #[error("{field}: need {need}, got {got}")]
    Value {
        /// The field.
        field: &'static str,
        /// Its range.
        need: &'static str,
        /// Its value.
        got: String,
    },
    /// A cell beyond the edge.
    #[error("brief.{which}: need a cell within (0, 0) to {last}, got {got}")]
    OffMap {
        /// `start` or `goal`.
        which: &'static str,
        /// The north-eastern cell.
        last: Cell,
        /// The cell.
        got: Cell,
    },
    /// A cell that cannot be stood on.
    #[error(
        "brief.{which}: need passable ground, got {got}, which {why}; choose a cell nearby, such as {nearby}"
    )]
    Impassable {
        /// `start` or `goal`.
        which: &'static str,
        /// The cell.
        got: Cell,
        /// Has no height, or is too steep.
        why: String,
        /// The nearest passable cell on the hop lattice, or a word on there being none.
        nearby: String,
    },
    /// A goal between the landing places.
    #[error(
        "brief.goal: need whole hops of {hop_cells} cells from the start {start}, got {goal}; \
         choose a goal whose columns and rows differ from the start's by multiples of {hop_cells}"
    )]
    OffLattice {
        /// Cells a hop.
        hop_cells: u32,
        /// Start.
        start: Cell,
        /// Goal.
        goal: Cell,
    },
    /// A value that the brief cannot carry.
    #[error("the resolved {0}")]
    Brief(Refusal),
}

fn names() -> String {
    BUILT_IN.map(|(name, _)| name).join(", ")
}
