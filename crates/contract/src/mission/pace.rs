//! How fast the mission's time passes: when a committed hop lands.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::MonotonicNs;

/// Fastest pace that can be asked for, landings a second.
pub const HERTZ_MAX: f64 = 1.0e6;

/// Slowest pace that can be asked for, landings a second.
pub const HERTZ_MIN: f64 = 1.0e-3;

/// Greatest multiple of real time that can be asked for.
pub const TIMES_MAX: f64 = 1.0e9;

/// Least multiple of real time that can be asked for.
pub const TIMES_MIN: f64 = 1.0e-3;

/// A hop that is committed and about to fly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Launch {
    /// When the hop before landed.
    pub last_landed: MonotonicNs,
    /// When this hop was committed.
    pub committed: MonotonicNs,
    /// Simulated time that it takes, seconds.
    pub lasts_s: f64,
}

/// When a committed hop lands.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Pace {
    /// At once.
    Max,
    /// After its flight, flown in real time.
    Real,
    /// After its flight, in so many times real time, [`TIMES_MIN`] to [`TIMES_MAX`].
    Times(f64),
    /// One period after the landing before, [`HERTZ_MIN`] to [`HERTZ_MAX`] landings a second.
    Hertz(f64),
}

impl Pace {
    /// The moment at which a hop lands: never before its commit.
    #[must_use]
    pub fn landing(self, launch: &Launch) -> MonotonicNs {
        let Launch { last_landed, committed, lasts_s } = *launch;
        match self {
            Pace::Max => committed,
            Pace::Real => committed.plus_ns(ns(lasts_s)),
            Pace::Times(times) => committed.plus_ns(ns(lasts_s / times)),
            Pace::Hertz(hertz) => last_landed.plus_ns(ns(1.0 / hertz)).max(committed),
        }
    }
}

/// Seconds in whole nanoseconds; the cast saturates, and takes NaN for 0.
fn ns(seconds: f64) -> u64 {
    (seconds * 1.0e9).round() as u64
}

impl FromStr for Pace {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "max" => Ok(Pace::Max),
            "real" => Ok(Pace::Real),
            _ => match text.strip_suffix('x') {
                Some(times) => within(times, TIMES_MIN, TIMES_MAX).map(Pace::Times),
                None => within(text, HERTZ_MIN, HERTZ_MAX).map(Pace::Hertz),
            }
            .ok_or_else(|| {
                format!(
                    "a pace is max, real, {TIMES_MIN}x to {TIMES_MAX}x real time, or {HERTZ_MIN} to {HERTZ_MAX} hops a \
                     second; got {text:?}"
                )
            }),
        }
    }
}

fn within(text: &str, min: f64, max: f64) -> Option<f64> {
    text.parse().ok().filter(|number| (min..=max).contains(number))
}

impl fmt::Display for Pace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Pace::Max => f.pad("max"),
            Pace::Real => f.pad("real"),
            Pace::Times(times) => f.pad(&format!("{times}x")),
            Pace::Hertz(hertz) => hertz.fmt(f),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lands(pace: Pace, last_landed_ns: u64, committed_ns: u64, lasts_s: f64) -> u64 {
        let (last_landed, committed) = (MonotonicNs(last_landed_ns), MonotonicNs(committed_ns));
        pace.landing(&Launch { last_landed, committed, lasts_s }).0
    }

    fn landing_ns(pace: Pace, last_landed_ns: u64, committed_ns: u64) -> u64 {
        lands(pace, last_landed_ns, committed_ns, 0.5)
    }

    #[test]
    fn at_max_a_hop_lands_as_it_is_committed() {
        assert_eq!(landing_ns(Pace::Max, 3, 10), 10);
    }

    #[test]
    fn in_real_time_a_hop_takes_its_time_or_a_multiple_and_a_held_one_none() {
        assert_eq!(landing_ns(Pace::Real, 0, 10), 500_000_010);
        assert_eq!(landing_ns(Pace::Times(2.0), 0, 10), 250_000_010);
        assert_eq!(lands(Pace::Times(3600.0), 0, 10, 88_775.0), 24_659_722_232);
        assert_eq!(lands(Pace::Real, 0, 10, 0.0), 10);
    }

    #[test]
    fn at_a_rate_landings_keep_their_period_and_a_late_commit_is_not_made_up_for() {
        assert_eq!(landing_ns(Pace::Hertz(4.0), 1_000, 2_000), 250_001_000);
        assert_eq!(landing_ns(Pace::Hertz(4.0), 1_000, 900_000_000), 900_000_000);
    }

    #[test]
    fn time_without_end_saturates() {
        assert_eq!(lands(Pace::Real, 0, 5, f64::INFINITY), u64::MAX);
        assert_eq!(lands(Pace::Times(TIMES_MIN), 0, 5, f64::INFINITY), u64::MAX);
        assert_eq!(landing_ns(Pace::Hertz(HERTZ_MIN), u64::MAX, 5), u64::MAX);
    }

    #[test]
    fn a_pace_is_read_from_its_name_and_nonsense_is_refused() {
        for pace in [Pace::Max, Pace::Real, Pace::Times(3600.0), Pace::Times(0.5), Pace::Hertz(2.5)] {
            assert_eq!(pace.to_string().parse(), Ok(pace));
        }
        for nonsense in
            ["", "fast", "0", "-1", "NaN", "inf", "1e9", "10hz", "x", "0x", "1e10x", "-2x", "infx"]
        {
            assert!(nonsense.parse::<Pace>().is_err(), "{nonsense:?}");
        }
    }
}
