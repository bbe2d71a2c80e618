//! Progress on standard error: a bar on a terminal, a line a second elsewhere.

use std::io::IsTerminal;

use contract::MonotonicNs;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::Progress;

/// Pause between two lines of the log.
const LINE_PERIOD_NS: u64 = 1_000_000_000;

/// Marks of the bar from start to goal.
const BAR_LENGTH: u64 = 1000;

/// Redraws of the bar a second, at most.
const REDRAWS_HZ: u8 = 10;

/// Shows progress; standard output stays free for data.
#[derive(Debug)]
pub enum Display {
    /// A bar over the share of the distance covered.
    Bar(ProgressBar),
    /// Lines of the log, with the moment of the last.
    Log(Option<MonotonicNs>),
}

impl Display {
    /// A bar if standard error is a terminal, the log otherwise.
    #[must_use]
    pub fn on_stderr() -> Self {
        if std::io::stderr().is_terminal() {
            Self::bar(ProgressDrawTarget::stderr_with_hz(REDRAWS_HZ))
        } else {
            Display::Log(None)
        }
    }

    /// A bar drawn to `target`.
    #[must_use]
    pub fn bar(target: ProgressDrawTarget) -> Self {
        let style = ProgressStyle::with_template("{bar:24.green} {percent:>3} % {wide_msg}")
            .expect("the template is a constant")
            .progress_chars("━╸ ");
        Display::Bar(ProgressBar::with_draw_target(Some(BAR_LENGTH), target).with_style(style))
    }

    /// Shows `progress` as it stands at `now`.
    pub fn show(&mut self, progress: &Progress, now: MonotonicNs) {
        match self {
            Display::Bar(bar) => {
                if bar.is_finished() {
                    bar.reset();
                }
                bar.set_position((progress.covered() * BAR_LENGTH as f64) as u64);
                bar.set_message(progress.to_string());
            }
            Display::Log(last) => {
                let due = last.is_none_or(|last| now.since_ns(last) >= LINE_PERIOD_NS);
                if due || progress.status.is_over() {
                    *last = Some(now);
                    tracing::info!("{progress}");
                }
            }
        }
    }

    /// Leaves the last state of the bar standing, and the terminal clean.
    pub fn finish(&self) {
        if let Display::Bar(bar) = self {
            bar.abandon();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::progress::tests::progress;

    #[test]
    fn away_from_a_terminal_there_is_a_line_a_second_and_one_at_the_end() {
        let mut display = Display::Log(None);
        let mut progress = progress();
        let last = |display: &mut Display, progress: &Progress, ms: u64| {
            display.show(progress, MonotonicNs(1_000_000 * ms));
            let Display::Log(Some(last)) = display else { panic!("a line is due at once") };
            last.0 / 1_000_000
        };
        let lines: Vec<u64> = (0..30).map(|tenth| last(&mut display, &progress, 7 + 100 * tenth)).collect();
        assert_eq!((lines[0], lines[9], lines[10], lines[29]), (7, 7, 1007, 2007));
        progress.status = contract::Status::Goal;
        assert_eq!(last(&mut display, &progress, 2950), 2950);
    }

    #[test]
    fn the_bar_covers_the_way_from_start_to_goal() {
        let mut display = Display::bar(ProgressDrawTarget::hidden());
        display.show(&progress(), MonotonicNs(0));
        let Display::Bar(bar) = &display else { unreachable!("made as a bar") };
        assert_eq!(bar.position(), BAR_LENGTH / 2);
        assert_eq!(bar.message(), progress().to_string());
        display.finish();
    }
}
