//! Progress on standard error: a bar on a terminal, a line a second elsewhere.

use contract::{MonotonicNs, RunId};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::Progress;

/// Pause between two lines of the log.
const LINE_PERIOD_NS: u64 = 1_000_000_000;

/// Pause before a line is logged again that says the same, as in a mission that is paused.
const SAME_LINE_PERIOD_NS: u64 = 60_000_000_000;

/// Marks of the bar from start to goal.
const BAR_LENGTH: u64 = 1000;

/// Redraws of the bar a second, at most.
const REDRAWS_HZ: u8 = 10;

/// Shows progress; standard output stays free for data.
#[derive(Debug, Default)]
pub struct Bar {
    /// On a terminal a bar over the share of the distance covered, else lines of the log.
    bar: Option<ProgressBar>,
    /// When the last line was logged.
    logged: Option<MonotonicNs>,
    /// The last line.
    line: String,
    /// The run whose end has been shown: it is shown once.
    ended: Option<RunId>,
}

impl Bar {
    /// A bar if standard error is a terminal that can redraw a line, the log otherwise.
    #[must_use]
    pub fn on_stderr() -> Self {
        if node::stderr_redraws() {
            Self::on(ProgressDrawTarget::stderr_with_hz(REDRAWS_HZ))
        } else {
            Self::default()
        }
    }

    /// A bar drawn to `target`.
    #[must_use]
    pub fn on(target: ProgressDrawTarget) -> Self {
        let style = ProgressStyle::with_template("{bar:16.green} {percent:>3} % {wide_msg}")
            .expect("the template is a constant")
            .progress_chars("━╸ ");
        let bar = ProgressBar::with_draw_target(Some(BAR_LENGTH), target).with_style(style);
        Self { bar: Some(bar), ..Self::default() }
    }

    /// Shows `progress` as it stands at `now`.
    pub fn show(&mut self, progress: &Progress, now: MonotonicNs) {
        if self.ended == Some(progress.run) {
            return;
        }
        let over = progress.status.is_over();
        self.ended = over.then_some(progress.run);
        if let Some(bar) = &self.bar {
            if bar.is_finished() {
                bar.reset();
            }
            bar.set_position((progress.covered() * BAR_LENGTH as f64) as u64);
            bar.set_message(progress.compact());
            return;
        }
        let past_ns = self.logged.map_or(u64::MAX, |logged| now.since_ns(logged));
        if !over && past_ns < LINE_PERIOD_NS {
            return;
        }
        let line = progress.to_string();
        if line != self.line || past_ns >= SAME_LINE_PERIOD_NS {
            self.logged = Some(now);
            tracing::info!("{line}");
            self.line = line;
        }
    }

    /// Leaves the last state of the bar standing, and the terminal clean.
    pub fn finish(&self) {
        if let Some(bar) = self.bar.as_ref().filter(|bar| !bar.is_finished()) {
            bar.abandon();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::progress::tests::progress;

    /// When each of several calls, a tenth of a second apart, has logged its last line, milliseconds.
    fn lines(display: &mut Bar, calls: std::ops::Range<u64>, progress: impl Fn(u64) -> Progress) -> Vec<u64> {
        calls
            .map(|tenth| {
                display.show(&progress(tenth), MonotonicNs(1_000_000 * (7 + 100 * tenth)));
                display.logged.unwrap().0 / 1_000_000
            })
            .collect()
    }

    #[test]
    fn away_from_a_terminal_there_is_a_line_a_second_and_one_at_the_end() {
        let mut display = Bar::default();
        let moving = |tenth| Progress { decision: contract::Decision(tenth), ..progress() };
        let shown = lines(&mut display, 0..30, moving);
        assert_eq!((shown[0], shown[9], shown[10], shown[29]), (7, 7, 1007, 2007));
        let over = |_| Progress { status: contract::Status::Goal, ..progress() };
        assert_eq!(lines(&mut display, 30..31, over), [3007]);
        assert_eq!(lines(&mut display, 90..91, over), [3007], "the end is told once");
    }

    /// P-PAUSED-LOG: A progress line that repeats the last one is logged once a minute, not each
    /// second.
    #[test]
    fn a_line_that_says_the_same_is_logged_once_a_minute() {
        let mut display = Bar::default();
        let shown = lines(&mut display, 0..1300, |_| progress());
        assert_eq!((shown[0], shown[599], shown[600], shown[1299]), (7, 7, 60_007, 120_007));
        let moved = |_| Progress { decision: contract::Decision(99), ..progress() };
        assert_eq!(lines(&mut display, 1300..1301, moved), [130_007], "what is new is logged at once");
    }

    #[test]
    fn the_bar_covers_the_way_from_start_to_goal() {
        let mut display = Bar::on(ProgressDrawTarget::hidden());
        display.show(&progress(), MonotonicNs(0));
        let bar = display.bar.as_ref().unwrap();
        assert_eq!(bar.position(), BAR_LENGTH / 2);
        assert_eq!(bar.message(), progress().compact());
        assert!(bar.message().chars().count() <= 58, "{} fits a terminal of eighty", bar.message());
        display.finish();
    }
}
