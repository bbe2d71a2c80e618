//! Progress of a campaign: a bar on a terminal, otherwise a log line every ten seconds.

use std::io::IsTerminal as _;

use contract::MonotonicNs;
use indicatif::{ProgressBar, ProgressStyle};

/// Pause between two lines, nanoseconds.
const LINE_PERIOD_NS: u64 = 10_000_000_000;

/// Shows how many trials are done.
pub struct Progress {
    due: u64,
    /// Trials that were done before this run.
    held: u64,
    began: MonotonicNs,
    told: MonotonicNs,
    /// The bar; only on a terminal.
    bar: Option<ProgressBar>,
}

impl Progress {
    /// Of `due` trials, `held` are there at `now`.
    pub fn begin(due: u64, held: u64, now: MonotonicNs) -> Self {
        let bar = std::io::stderr().is_terminal().then(|| bar(due, held));
        Self { due, held, began: now, told: now, bar }
    }

    /// `done` trials are there at `now`.
    pub fn show(&mut self, done: u64, now: MonotonicNs) {
        match &self.bar {
            Some(bar) => bar.set_position(done),
            None => self.line(done, now).into_iter().for_each(|line| tracing::info!("{line}")),
        }
    }

    /// Takes the bar away.
    pub fn end(&self) {
        self.bar.iter().for_each(ProgressBar::finish_and_clear);
    }

    /// The next line, if it is time.
    fn line(&mut self, done: u64, now: MonotonicNs) -> Option<String> {
        if now.since_ns(self.told) < LINE_PERIOD_NS {
            return None;
        }
        self.told = now;
        let (due, flown) = (self.due, done - self.held);
        let per_s = flown as f64 / (now.since_ns(self.began) as f64 / 1e9);
        let mut line = format!("{done} of {due} trials, {per_s:.1} a second");
        if flown > 0 {
            let left_s = std::time::Duration::from_secs(((due - done) as f64 / per_s) as u64);
            line += &format!(", about {} left", humantime::format_duration(left_s));
        }
        Some(line)
    }
}

fn bar(due: u64, held: u64) -> ProgressBar {
    let bar = ProgressBar::new(due).with_position(held);
    if let Ok(style) = ProgressStyle::with_template("{wide_bar} {pos} of {len} trials, {per_sec}, {eta} left")
    {
        bar.set_style(style);
    }
    bar
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_every_ten_seconds_tells_how_far_and_how_long() {
        let at = |s: u64| MonotonicNs(5 + s * 1_000_000_000);
        let mut progress = Progress { due: 3_000, held: 1_000, began: at(0), told: at(0), bar: None };
        assert_eq!(progress.line(1_000, at(9)), None);
        assert_eq!(progress.line(1_000, at(10)).unwrap(), "1000 of 3000 trials, 0.0 a second");
        assert_eq!(progress.line(1_100, at(19)), None);
        assert_eq!(
            progress.line(1_200, at(20)).unwrap(),
            "1200 of 3000 trials, 10.0 a second, about 3m left"
        );
        assert_eq!(
            progress.line(3_000, at(40)).unwrap(),
            "3000 of 3000 trials, 50.0 a second, about 0s left"
        );
    }
}
