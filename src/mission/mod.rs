//! One mission from start to end: its processes, its output folder, its picture.

pub mod child;
pub mod comparison;
pub mod flown;
pub mod launch;
pub mod output_dir;
pub mod planner_command;
pub mod robots;
pub mod run;
pub mod sensed;
pub mod snapshot;
pub mod supervisor;

pub use flown::Flown;
pub use output_dir::OutputDir;
pub use robots::Robots;
pub use sensed::Sensed;
pub use snapshot::Snapshot;
