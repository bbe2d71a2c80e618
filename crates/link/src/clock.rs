//! Time of the mission, from its decisions.

use contract::{Decision, MonotonicNs};
use telemetry::MissionTime;

/// Most of mission time in a nanosecond of the host's, in units: 10 kHz of decisions of 12 days each.
const PACE_MAX: f64 = 1e9;

/// Tells mission time. A decision takes `step` of it: observing, planning and hopping together. Until the next decision
/// comes, it goes on at the pace of the last ones, also while nothing moves; it never goes back.
#[derive(Clone, Debug)]
pub struct MissionClock {
    step_units: f64,
    /// The last decision, when it came, and mission time then, units.
    last: Option<(Decision, MonotonicNs, f64)>,
    /// The last decision of another moment, from which the pace is measured.
    anchor: Option<(Decision, MonotonicNs)>,
    /// Units of mission time in a nanosecond.
    pace: f64,
    told: MissionTime,
}

impl MissionClock {
    /// A clock at 0. Until there were two decisions it goes as the host's.
    #[must_use]
    pub fn new(step: MissionTime) -> Self {
        let pace = MissionTime::UNITS_PER_S as f64 / 1e9;
        let step_units = step.units() as f64;
        Self { step_units, last: None, anchor: None, pace, told: MissionTime::default() }
    }

    /// The state of `decision` came at `now`. One that comes again, or an earlier one, changes nothing.
    pub fn decision(&mut self, decision: Decision, now: MonotonicNs) {
        let Some((before, _, units)) = self.last else {
            self.last = Some((decision, now, self.step_units * decision.0 as f64));
            self.anchor = Some((decision, now));
            return;
        };
        let Some(steps) = decision.0.checked_sub(before.0).filter(|steps| *steps > 0) else { return };
        let least = units + self.step_units * steps as f64;
        let gone = self.units(now);
        self.last = Some((decision, now, least.max(gone)));
        // Several decisions that came at one look tell of no pace by themselves.
        if let Some((from, since)) = self.anchor
            && now > since
        {
            let steps = decision.0.saturating_sub(from.0) as f64;
            self.pace = (self.step_units * steps / now.since_ns(since) as f64).min(PACE_MAX);
            self.anchor = Some((decision, now));
        }
    }

    /// Mission time at `now`.
    pub fn at(&mut self, now: MonotonicNs) -> MissionTime {
        self.told = self.told.max(MissionTime::from_units(self.units(now) as u64));
        self.told
    }

    fn units(&self, now: MonotonicNs) -> f64 {
        match self.last {
            Some((_, since, units)) => units + self.pace * now.since_ns(since) as f64,
            None => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: u64 = 1_000_000_000;

    fn seconds(clock: &mut MissionClock, now: u64) -> f64 {
        clock.at(MonotonicNs(now)).seconds()
    }

    #[test]
    fn a_decision_takes_its_step_at_any_pace_and_time_goes_on_while_nothing_moves() {
        for interval in [S, S / 10_000] {
            let mut clock = MissionClock::new(MissionTime::from_seconds(60.0));
            for decision in 0..=10 {
                clock.decision(Decision(decision), MonotonicNs(decision * interval));
            }
            assert_eq!(seconds(&mut clock, 10 * interval), 600.0);
            assert!((seconds(&mut clock, 10 * interval + interval / 2) - 630.0).abs() < 0.01);
            // Held for four intervals: the next decision adds nothing that has not gone by.
            assert!((seconds(&mut clock, 14 * interval) - 840.0).abs() < 0.01);
            clock.decision(Decision(11), MonotonicNs(14 * interval));
            assert!((seconds(&mut clock, 14 * interval) - 840.0).abs() < 0.01);
        }
    }

    #[test]
    fn mission_time_never_goes_back() {
        let mut clock = MissionClock::new(MissionTime::from_seconds(60.0));
        clock.decision(Decision(5), MonotonicNs(S));
        let before = seconds(&mut clock, 3 * S);
        clock.decision(Decision(2), MonotonicNs(4 * S));
        assert!(seconds(&mut clock, 2 * S) >= before);
    }
}
