//! Progress of a long command on standard error: a bar on a terminal, otherwise log lines.
//!
//! Nothing is shown in the first second: most commands are over by then.

use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

use contract::MonotonicNs;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Time before anything is shown, nanoseconds.
const QUIET_NS: u64 = 1_000_000_000;

/// Pause between two lines after the first, nanoseconds.
const LINE_PERIOD_NS: u64 = 10_000_000_000;

/// Shows how much of a counted work is done.
pub struct Progress {
    /// What is counted, e.g. "trials".
    unit: &'static str,
    due: u64,
    /// What was done before this command.
    held: u64,
    began: MonotonicNs,
    /// When the next line is due.
    next: MonotonicNs,
    /// The bar; only on a terminal that can redraw a line.
    bar: Option<ProgressBar>,
}

impl Progress {
    /// Progress of work on `due` units, of which `held` are done at `now`.
    #[must_use]
    pub fn begin(unit: &'static str, due: u64, held: u64, now: MonotonicNs) -> Self {
        let bar = node::stderr_redraws().then(|| bar(unit, due, held));
        Self { unit, due, held, began: now, next: now.plus_ns(QUIET_NS), bar }
    }

    /// `done` units are done at `now`.
    pub fn show(&mut self, done: u64, now: MonotonicNs) {
        let Some(bar) = &self.bar else {
            self.line(done, now).into_iter().for_each(|line| tracing::info!("{line}"));
            return;
        };
        if now >= self.next && bar.is_hidden() {
            bar.set_draw_target(ProgressDrawTarget::stderr());
        }
        bar.set_position(done);
    }

    /// Takes the bar away.
    pub fn end(&self) {
        self.bar.iter().for_each(ProgressBar::finish_and_clear);
    }

    /// The next line, if it is time.
    fn line(&mut self, done: u64, now: MonotonicNs) -> Option<String> {
        if now < self.next {
            return None;
        }
        self.next = now.plus_ns(LINE_PERIOD_NS);
        let (due, unit, fresh) = (self.due, self.unit, done - self.held);
        let per_s = fresh as f64 / (now.since_ns(self.began) as f64 / 1e9);
        let mut line = format!("{done} of {due} {unit}, {per_s:.1} a second");
        if fresh > 0 {
            let left_s = Duration::from_secs(((due - done) as f64 / per_s) as u64);
            line += &format!(", about {} left", humantime::format_duration(left_s));
        }
        Some(line)
    }
}

/// Does `work`, whose amount is not known beforehand, and says every now and then that it is still being done.
///
/// # Panics
/// If `work` does.
pub fn while_working<T>(what: &str, work: impl FnOnce() -> T) -> T {
    let (done, is_done) = mpsc::channel::<()>();
    std::thread::scope(|scope| {
        scope.spawn(move || {
            let began = Instant::now();
            let mut pause = Duration::from_nanos(QUIET_NS);
            // Ends when the sender is dropped.
            while is_done.recv_timeout(pause) == Err(RecvTimeoutError::Timeout) {
                tracing::info!("{what}: at work for {:.0} s", began.elapsed().as_secs_f64());
                pause = Duration::from_nanos(LINE_PERIOD_NS);
            }
        });
        // Dropped when the work is done, and also when it panics.
        let _done = done;
        work()
    })
}

fn bar(unit: &str, due: u64, held: u64) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(due), ProgressDrawTarget::hidden()).with_position(held);
    let style = ProgressStyle::with_template(&format!(
        "{{wide_bar}} {{pos}} of {{len}} {unit}, {{per_sec}}, {{eta}} left"
    ));
    if let Ok(style) = style {
        bar.set_style(style);
    }
    bar
}

#[cfg(test)]
mod tests {
    use super::*;

    /// P-PROGRESS: A command that takes longer than a second says so, and again every ten seconds.
    #[test]
    fn a_line_after_a_second_and_then_every_ten_tells_how_far_and_how_long() {
        let at = |s: u64| MonotonicNs(5 + s * 1_000_000_000);
        let mut progress =
            Progress { unit: "trials", due: 3_000, held: 1_000, began: at(0), next: at(1), bar: None };
        assert_eq!(progress.line(1_000, at(0)), None);
        assert_eq!(progress.line(1_000, at(1)).unwrap(), "1000 of 3000 trials, 0.0 a second");
        assert_eq!(progress.line(1_100, at(10)), None);
        assert_eq!(
            progress.line(1_200, at(20)).unwrap(),
            "1200 of 3000 trials, 10.0 a second, about 3m left"
        );
        assert_eq!(
            progress.line(3_000, at(40)).unwrap(),
            "3000 of 3000 trials, 50.0 a second, about 0s left"
        );
    }

    #[test]
    fn what_is_worked_on_is_returned_at_once() {
        assert_eq!(while_working("nothing", || 7), 7);
    }
}
