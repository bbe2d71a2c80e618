//! One mission from start to end: its processes, its output folder, its picture.

pub mod child;
pub mod comparison;
pub mod output_dir;
pub mod run;
pub mod snapshot;
pub mod supervisor;

pub use output_dir::OutputDir;
pub use snapshot::Snapshot;
