//! Reports on missions: summaries, latency statistics, text tables, pictures.
//!
//! [`Tally`] folds executed decisions in constant memory, with their [`Latency`]. [`Summary`] is the tally as
//! JSON for programs (its field names are promised) or, displayed, as text for a terminal.
//! [`DecisionTimings`] keeps the timing of every decision, to name the longest and their causes;
//! [`timing_csv_row`] writes it as CSV. [`Picture`] draws terrain, policy and route in the style of the papers'
//! figures. [`table()`] formats every text table of the project.
//!
//! No I/O, no clock: everything is computed from the arguments.

#![warn(clippy::disallowed_methods)]

pub mod colour;
pub mod decisions;
pub mod ending;
pub mod error;
pub mod fallbacks;
mod flown_time;
pub mod format;
mod goals;
mod histogram;
pub mod latency;
pub mod layers;
mod phrases;
pub mod picture;
pub mod robot_summary;
pub mod summary;
pub mod table;
pub mod tally;
pub mod timing_csv;
pub mod way;

pub use decisions::{Cause, Conditions, DecisionReport, DecisionTiming, DecisionTimings, Disturbance};
pub use ending::Ending;
pub use error::ReportError;
pub use fallbacks::{Fallbacks, guard_phrase};
pub use format::Format;
pub use goals::with_only_goal;
pub use latency::{Latency, LatencyReport, PerStep, Percentiles};
pub use layers::Layer;
pub use phrases::TeamEffort;
pub use picture::{Picture, PictureGrid, PictureStyle, TitledPicture};
pub use robot_summary::RobotSummary;
pub use summary::{Process, Summary, SummaryBuilder, path_as_text};
pub use table::table;
pub use tally::{Executed, Leadership, Route, Tally};
pub use timing_csv::{timing_csv_heading, timing_csv_row};
