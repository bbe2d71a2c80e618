//! Log lines on standard error.

use std::io::IsTerminal;

use tracing_subscriber::EnvFilter;
use tracing_subscriber::fmt::format::Writer;
use tracing_subscriber::fmt::time::{FormatTime, SystemTime};

/// Where the middleware's own lines come from; they are for its developers.
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
    let default = || EnvFilter::new(format!("{level},{MIDDLEWARE}"));
    let filter = match std::env::var("HOPPER_LOG") {
        Ok(text) if !text.is_empty() => {
            EnvFilter::try_new(format!("{MIDDLEWARE},{text}")).unwrap_or_else(|_| default())
        }
        _ => default(),
    };
    let installed = tracing_subscriber::fmt()
        .compact()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal())
        .with_target(false)
        .with_timer(Stamp { role: role.to_owned() })
        .try_init()
        .is_ok();
    if installed {
        tracing::debug!(role, pid = std::process::id(), "logging");
    }
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
