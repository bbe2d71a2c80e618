//! Log lines on standard error.

use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};

use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::fmt::format::Writer;
use tracing_subscriber::fmt::time::{FormatTime, SystemTime};
use tracing_subscriber::layer::SubscriberExt as _;
use tracing_subscriber::util::SubscriberInitExt as _;

use crate::terminal::stderr_has_colours;

/// The filter for the middleware's own lines, which are for its developers.
const MIDDLEWARE: &str = "iceoryx2_bb_loggers=error";

/// Sends log lines to standard error: `HOPPER_LOG` (a filter such as `debug` or `node=trace`), else
/// `info`, raised by `verbosity` steps to `debug`, then `trace`. Colours only on a terminal. May be called
/// more than once; the first call counts.
pub fn log_to_stderr(role: &str, verbosity: u8) {
    let level = match verbosity {
        0 => "info",
        1 => "debug",
        _ => "trace",
    };
    // Not `EnvFilter`: it would bring a regular-expression engine, and nobody filters by the values of fields.
    let filter = |text: &str| format!("{MIDDLEWARE},{text}").parse::<Targets>();
    let asked = std::env::var("HOPPER_LOG").ok().filter(|text| !text.is_empty());
    let given = asked.as_deref().map(filter);
    let refused = given.as_ref().and_then(|given| given.as_ref().err().map(ToString::to_string));
    let given = given.and_then(Result::ok).unwrap_or_else(|| filter(level).unwrap_or_default());
    let installed = tracing_subscriber::fmt()
        .compact()
        .with_max_level(LevelFilter::TRACE)
        .with_writer(writer)
        .with_ansi(stderr_has_colours())
        .with_target(false)
        // A line that cannot be written is lost; reporting that would end the process.
        .log_internal_errors(false)
        .with_timer(Stamp { role: role.to_owned() })
        .finish()
        .with(given)
        .try_init()
        .is_ok();
    if installed {
        tracing::debug!(role, pid = std::process::id(), "logging");
        if let (Some(asked), Some(error)) = (asked, refused) {
            tracing::warn!(
                "HOPPER_LOG needs a filter such as debug or node=trace, got {asked:?} ({error}): not used"
            );
        }
    }
}

/// Whether something is drawn on the terminal that log lines would go to.
static HELD_BACK: AtomicBool = AtomicBool::new(false);

/// Suppresses log lines, or allows them again, if standard error is a terminal: for a view that draws on it.
pub fn hold_log_back(held_back: bool) {
    HELD_BACK.store(held_back && std::io::stderr().is_terminal(), Ordering::Relaxed);
}

/// Whether log lines go to a file that other users can read.
#[must_use]
pub fn log_is_readable_by_others() -> bool {
    let Ok(stat) = rustix::fs::fstat(std::io::stderr()) else { return false };
    let is_file = rustix::fs::FileType::from_raw_mode(stat.st_mode) == rustix::fs::FileType::RegularFile;
    is_file && stat.st_mode & 0o044 != 0
}

fn writer() -> Box<dyn Write> {
    if HELD_BACK.load(Ordering::Relaxed) { Box::new(std::io::sink()) } else { Box::new(std::io::stderr()) }
}

/// Time and role at the head of each line: four processes may share one terminal.
struct Stamp {
    role: String,
}

impl FormatTime for Stamp {
    fn format_time(&self, writer: &mut Writer<'_>) -> std::fmt::Result {
        SystemTime.format_time(writer)?;
        write!(writer, " {:>10}", self.role)
    }
}
