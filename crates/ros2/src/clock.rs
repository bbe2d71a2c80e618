//! Turns times of a recording into times of ROS.

use contract::MonotonicNs;
use recording::RunMetadata;

use crate::message::{Header, Time};

/// Nanoseconds of a second.
const SECOND_NS: i128 = 1_000_000_000;

/// What lies between the monotonic clock of a recording and the calendar.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Clock {
    /// What is added to a time of the recording, nanoseconds; 0 where the recording does not say, or says it of several runs.
    pub offset_ns: i128,
}

impl Clock {
    /// The clock of a run, from when its recorder started by both clocks.
    #[must_use]
    pub fn of(metadata: &RunMetadata<'_>) -> Self {
        let started_ns =
            metadata.recorder("started_ns").and_then(|text| text.parse::<u64>().ok()).map(i128::from);
        let unix_ns = metadata.recorder("started_unix_s").and_then(nanoseconds);
        match (unix_ns, started_ns) {
            (Some(unix_ns), Some(started_ns)) => Self { offset_ns: unix_ns - started_ns },
            _ => Self::default(),
        }
    }

    /// Nanoseconds since the beginning of 1970, within what a time of ROS can hold.
    #[must_use]
    pub fn ns(&self, moment: MonotonicNs) -> u64 {
        let latest_ns = i128::from(i32::MAX) * SECOND_NS + SECOND_NS - 1;
        (i128::from(moment.0).saturating_add(self.offset_ns)).clamp(0, latest_ns) as u64
    }

    /// The same as a time of ROS.
    #[must_use]
    pub fn time(&self, moment: MonotonicNs) -> Time {
        let ns = i128::from(self.ns(moment));
        Time { sec: (ns / SECOND_NS) as i32, nanosec: (ns % SECOND_NS) as u32 }
    }

    /// The header of a message in `frame`.
    #[must_use]
    pub fn header(&self, moment: MonotonicNs, frame: &str) -> Header {
        Header { stamp: self.time(moment), frame_id: frame.to_owned() }
    }
}

/// Nanoseconds of a decimal number of seconds, digit by digit: a float has too few digits for them.
fn nanoseconds(text: &str) -> Option<i128> {
    let (whole, rest) = text.split_once('.').unwrap_or((text, ""));
    let is_number = |digits: &str| digits.bytes().all(|byte| byte.is_ascii_digit());
    if whole.is_empty() || whole.len() > 12 || rest.len() > 9 || !is_number(whole) || !is_number(rest) {
        return None;
    }
    let rest = format!("{rest:0<9}");
    Some(whole.parse::<i128>().ok()? * SECOND_NS + rest.parse::<i128>().ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn calendar_times_are_read_to_the_digit() {
        assert_eq!(nanoseconds("1764217299.123456"), Some(1_764_217_299_123_456_000));
        assert_eq!(nanoseconds("5"), Some(5_000_000_000));
        for text in ["", ".5", "-1.0", "1e9", "1.0000000001", "1.2.3", "9999999999999", "١.0"] {
            assert_eq!(nanoseconds(text), None, "{text}");
        }
    }

    #[test]
    fn a_time_that_ros_cannot_hold_is_the_nearest_that_it_can() {
        let clock = Clock { offset_ns: -5 };
        assert_eq!(clock.time(MonotonicNs(3)), Time { sec: 0, nanosec: 0 });
        assert_eq!(clock.time(MonotonicNs(2_000_000_007)), Time { sec: 2, nanosec: 2 });
        assert_eq!(clock.time(MonotonicNs(u64::MAX)), Time { sec: i32::MAX, nanosec: 999_999_999 });
    }
}
