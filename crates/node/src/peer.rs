//! Command-line arguments of perception, planner and monitor.

use std::time::Duration;

use process::Terms;

use crate::waiting::Joining;

/// Arguments of every process that waits for hopper-sim.
#[derive(clap::Args, Clone, Debug)]
pub struct PeerArgs {
    /// Instance to belong to; processes of different instances never meet.
    #[arg(long, env = "HOPPER_INSTANCE", default_value = "hopper", value_name = "NAME")]
    pub instance: String,
    /// Give up with exit code 4 when what is waited for does not come within this time, e.g. 30s
    /// [default: wait forever].
    #[arg(long, value_parser = humantime::parse_duration, value_name = "DURATION")]
    pub wait: Option<Duration>,
    /// Stay when the mission has ended, ready for the next.
    #[arg(long)]
    pub stay: bool,
    /// End when standard input closes: the parent holds its other end.
    #[arg(long, hide = true, env = "HOPPER_LIFELINE", hide_env = true)]
    pub lifeline: bool,
}

impl PeerArgs {
    /// How to join: a process that is in the way is waited for like any other peer.
    #[must_use]
    pub fn joining(&self) -> Joining {
        let patience = self.wait.unwrap_or(Duration::MAX);
        Joining { lifeline: self.lifeline, ..Joining::patiently(patience) }
    }

    /// How long to wait, and whether to stay.
    #[must_use]
    pub fn terms(&self) -> Terms {
        Terms { wait: self.wait, stay: self.stay }
    }
}
