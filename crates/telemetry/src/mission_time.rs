//! Time of the mission.

use std::fmt;

/// Time since the mission began, in units of 2⁻¹⁶ s.
///
/// In a packet it is a CCSDS unsegmented time code (CUC, CCSDS 301.0-B-4) without its first field: four bytes of
/// seconds and two of fractions. It ends after 136 years.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct MissionTime(u64);

impl MissionTime {
    /// How many bytes it takes in a packet.
    pub const BYTES: usize = 6;

    /// Units in a second.
    pub const UNITS_PER_S: u64 = 1 << 16;

    /// The last one.
    pub const MAX: MissionTime = MissionTime((1 << 48) - 1);

    /// Time from its number of units; the last one if there are more.
    #[must_use]
    pub fn from_units(units: u64) -> Self {
        Self(units).min(Self::MAX)
    }

    /// Time from nanoseconds, rounded down.
    #[must_use]
    pub fn from_ns(ns: u64) -> Self {
        Self::from_units((u128::from(ns) * u128::from(Self::UNITS_PER_S) / 1_000_000_000) as u64)
    }

    /// Time from seconds, rounded down; 0 from less.
    #[must_use]
    pub fn from_seconds(seconds: f64) -> Self {
        Self::from_units((seconds * Self::UNITS_PER_S as f64) as u64)
    }

    /// Units of 2⁻¹⁶ s.
    #[must_use]
    pub fn units(self) -> u64 {
        self.0
    }

    /// Seconds, exactly.
    #[must_use]
    pub fn seconds(self) -> f64 {
        self.0 as f64 / Self::UNITS_PER_S as f64
    }

    /// Nanoseconds, rounded down.
    #[must_use]
    pub fn ns(self) -> u64 {
        (u128::from(self.0) * 1_000_000_000 / u128::from(Self::UNITS_PER_S)) as u64
    }

    /// The bytes in a packet.
    #[must_use]
    pub fn to_bytes(self) -> [u8; Self::BYTES] {
        let [_, _, bytes @ ..] = self.0.to_be_bytes();
        bytes
    }

    /// The time of the bytes in a packet.
    #[must_use]
    pub fn from_bytes(bytes: [u8; Self::BYTES]) -> Self {
        let [a, b, c, d, e, f] = bytes;
        Self(u64::from_be_bytes([0, 0, a, b, c, d, e, f]))
    }
}

impl fmt::Display for MissionTime {
    /// As days, hours, minutes and seconds: `2d 03:04:05`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let seconds = self.0 / Self::UNITS_PER_S;
        let (days, hours, minutes) = (seconds / 86_400, seconds / 3600 % 24, seconds / 60 % 60);
        if days > 0 {
            write!(f, "{days}d ")?;
        }
        write!(f, "{hours:02}:{minutes:02}:{:02}", seconds % 60)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_survives_its_bytes_and_ends_without_wrapping() {
        for units in [0, 1, 65_535, 65_536, MissionTime::MAX.units()] {
            let time = MissionTime::from_units(units);
            assert_eq!(MissionTime::from_bytes(time.to_bytes()), time);
        }
        assert_eq!(MissionTime::from_units(u64::MAX), MissionTime::MAX);
        assert_eq!(MissionTime::from_seconds(f64::INFINITY), MissionTime::MAX);
        assert_eq!(MissionTime::from_seconds(-1.0), MissionTime::default());
        assert_eq!(MissionTime::from_seconds(1.5).to_bytes(), [0, 0, 0, 1, 0x80, 0]);
        assert_eq!(MissionTime::from_ns(1_500_000_000).ns(), 1_500_000_000);
        assert_eq!(MissionTime::from_seconds(183_845.0).to_string(), "2d 03:04:05");
    }
}
