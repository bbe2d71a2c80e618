//! What a mission amounts to, told to people, programs or the eye.
//!
//! [`Tally`] folds executed decisions in constant memory; [`Latency`] inside it says where the time
//! of a decision went. [`Summary`] is the tally as JSON for programs (its field names are a promise)
//! or, displayed, as text for a terminal. [`Picture`] draws ground, policy, route in the manner of
//! the papers' figures. [`timetable_row`] tells where the time of a decision went. [`table()`] formats every
//! text table of the project.
//!
//! No I/O, no clock: everything is computed from what is handed in.

mod ending;
pub mod error;
pub mod fallbacks;
pub mod format;
pub mod latency;
pub mod picture;
pub mod steps;
pub mod summary;
pub mod table;
pub mod tally;
pub mod timetable;

pub use error::ReportError;
pub use fallbacks::{Fallbacks, guarded};
pub use format::Format;
pub use latency::{Latency, LatencyReport, PerStep, Percentiles};
pub use picture::{Picture, Plate, View};
pub use steps::{Cause, Conditions, Happening, Step, StepAccount, StepReport};
pub use summary::{Process, Summary, SummaryBuilder};
pub use table::table;
pub use tally::{Executed, Route, Tally, Tenure};
pub use timetable::{timetable_heading, timetable_row};
