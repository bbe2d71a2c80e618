//! How many bits may be sent.

use std::fmt;
use std::str::FromStr;

use telemetry::MissionTime;

/// Stretches of mission time during which the ground can be reached: so long at the beginning of each period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Passes {
    length: MissionTime,
    period: MissionTime,
}

impl Passes {
    /// Passes of `length`, one each `period`.
    #[must_use]
    pub fn new(length: MissionTime, period: MissionTime) -> Option<Self> {
        (MissionTime::default() < length && length <= period).then_some(Self { length, period })
    }

    /// Whether the ground can be reached at `time`.
    #[must_use]
    pub fn is_open(&self, time: MissionTime) -> bool {
        time.units() % self.period.units() < self.length.units()
    }

    /// Units of time in passes before `time`.
    fn open_before(&self, time: MissionTime) -> u64 {
        let (whole, rest) = (time.units() / self.period.units(), time.units() % self.period.units());
        whole * self.length.units() + rest.min(self.length.units())
    }
}

impl FromStr for Passes {
    type Err = String;

    /// Reads `10m/90m`: ten minutes at the beginning of every ninety.
    fn from_str(text: &str) -> Result<Self, String> {
        let need = || format!("passes are LENGTH/PERIOD, the length not longer, e.g. 10m/90m; got {text:?}");
        let (length, period) = text.split_once('/').ok_or_else(need)?;
        Self::new(duration(length).ok_or_else(need)?, duration(period).ok_or_else(need)?).ok_or_else(need)
    }
}

impl fmt::Display for Passes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}s/{}s", self.length.seconds(), self.period.seconds())
    }
}

/// A time such as `90s`, `10m` or `1h 30m`.
#[must_use]
pub fn duration(text: &str) -> Option<MissionTime> {
    let time = humantime::parse_duration(text).ok()?;
    (time.as_secs_f64() <= MissionTime::MAX.seconds()).then(|| MissionTime::from_seconds(time.as_secs_f64()))
}

/// Bits that may be sent: a rate while the ground can be reached.
///
/// Over any stretch between two looks at the clock no more is sent than the rate allows, and one packet or what the
/// rate allows in a second besides. What was not used is not saved up.
#[derive(Clone, Debug)]
pub struct Budget {
    /// Bits in a second of mission time; `None` for any number.
    rate: Option<u64>,
    passes: Option<Passes>,
    now: MissionTime,
    /// Bits that may be sent, in 2⁻¹⁶; below 0 by what the last packet was longer than what was left.
    credit: i128,
}

impl Budget {
    /// A budget of `rate` bits in a second of mission time while the ground can be reached; without a rate it has no end.
    #[must_use]
    pub fn new(rate: Option<u64>, passes: Option<Passes>) -> Self {
        Self { rate, passes, now: MissionTime::default(), credit: 0 }
    }

    /// The rate, bits in a second.
    #[must_use]
    pub fn rate(&self) -> Option<u64> {
        self.rate
    }

    /// It is `now`.
    pub fn advance(&mut self, now: MissionTime) {
        let before = self.now;
        self.now = self.now.max(now);
        let Some(rate) = self.rate else { return };
        let open = self.passes.map_or(self.now.units() - before.units(), |passes| {
            passes.open_before(self.now) - passes.open_before(before)
        });
        let gained = i128::from(rate) * i128::from(open);
        let most = gained.max(i128::from(rate) * i128::from(MissionTime::UNITS_PER_S));
        self.credit = (self.credit + gained).min(most);
    }

    /// Whether a packet may be sent now.
    #[must_use]
    pub fn is_open(&self) -> bool {
        let is_reached = self.passes.is_none_or(|passes| passes.is_open(self.now));
        match self.rate {
            // What a pass allowed between two looks may be sent after it: the host did not look earlier.
            Some(_) => self.credit > 0,
            None => is_reached,
        }
    }

    /// So many bits were sent.
    pub fn spend(&mut self, bits: u64) {
        if self.rate.is_some() {
            self.credit -= i128::from(bits) * i128::from(MissionTime::UNITS_PER_S);
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn passes_are_read_and_refused_with_what_was_needed() {
        let passes: Passes = "10m/90m".parse().unwrap();
        for (seconds, is_open) in
            [(0.0, true), (599.9, true), (600.0, false), (5399.9, false), (5400.0, true)]
        {
            assert_eq!(passes.is_open(MissionTime::from_seconds(seconds)), is_open, "{seconds}");
        }
        assert_eq!(
            passes.open_before(MissionTime::from_seconds(6300.0)).to_string(),
            (1200 << 16).to_string()
        );
        for wrong in
            ["", "10m", "10m/", "90m/10m", "0s/10s", "-1s/10s", "1x/10m", "NaNs/1s", "1e99d/1e99d", "€/1s"]
        {
            let error = wrong.parse::<Passes>().unwrap_err();
            assert!(error.contains("LENGTH/PERIOD"), "{wrong}: {error}");
        }
    }

    proptest! {
        /// P-LINK-BUDGET: Over any stretch of mission time no more bits are sent than the rate allows while the ground
        /// can be reached, and one packet or one second's bits besides.
        #[test]
        fn no_stretch_has_more_bits_than_the_rate_allows(
            rate in 1_u64..100_000,
            with_passes: bool,
            looks in proptest::collection::vec((0_u64..40_000_000, proptest::collection::vec(1_u64..30_000, 0..20)), 1..40),
        ) {
            let passes = with_passes.then(|| "10m/90m".parse::<Passes>().unwrap());
            let mut budget = Budget::new(Some(rate), passes);
            let (mut now, mut sent) = (0, Vec::new());
            for (gone, packets) in &looks {
                let before = MissionTime::from_units(now);
                now += gone;
                let after = MissionTime::from_units(now);
                budget.advance(after);
                let mut bits = 0;
                for packet in packets {
                    if budget.is_open() {
                        budget.spend(*packet);
                        bits += packet;
                    }
                }
                let open = passes.map_or(*gone, |passes| passes.open_before(after) - passes.open_before(before));
                sent.push((open as f64 / 65_536.0 * rate as f64, bits as f64));
            }
            for first in 0..sent.len() {
                let (mut allowed, mut bits) = (0.0, 0.0);
                for (gained, more) in &sent[first..] {
                    allowed += gained;
                    bits += more;
                    prop_assert!(bits <= allowed + rate as f64 + 30_000.0, "{bits} bits where {allowed} are allowed");
                }
            }
        }
    }
}
