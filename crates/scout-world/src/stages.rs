//! Stages of a mission: all drives between two flights together take at most a Sol.

use rover::{Allowance, Drive};

/// The longest that a rover drives in a stage which is not its last, in Sol.
pub const STAGE_SOL: f64 = 1.0;

/// How much of its stage a rover has used up. A fold over its drives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StageClock {
    /// Stages that are still to come.
    left: u32,
    /// Driven in the present one, in Sol.
    used_sol: f64,
}

impl StageClock {
    /// At the beginning of the first of so many stages.
    #[must_use]
    pub fn new(stages: u32) -> Self {
        Self { left: stages.saturating_sub(1), used_sol: 0.0 }
    }

    /// How long the next drive may take; the last stage has no limit.
    #[must_use]
    pub fn allowance(&self) -> Allowance {
        if self.left == 0 {
            return Allowance::UNLIMITED;
        }
        Allowance { used_sol: self.used_sol, limit_sol: STAGE_SOL }
    }

    /// The rover has made `drive` within its allowance.
    pub fn drove(&mut self, drive: &Drive) {
        self.used_sol = drive.used_sol;
    }

    /// The next stage begins.
    pub fn begin_next(&mut self) {
        (self.left, self.used_sol) = (self.left.saturating_sub(1), 0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rover::{DriveEnd, Lattice, Point, Speed, Surface, Truth, drive};

    /// P-STAGES-HALT.
    ///
    /// 500 m at 200 m/Sol in three stages: 200, 200 and 100 m.
    #[test]
    fn all_stages_but_the_last_end_after_a_sol() {
        let surface = Surface::flat(Lattice::new(500, 1).unwrap());
        let truth = Truth { speeds: vec![Speed::Fast; 500] };
        let mut clock = StageClock::new(3);
        let mut at_m: f64 = 0.0;
        let mut ends = Vec::new();
        while at_m < 500.0 {
            let to_m = (at_m + 90.0).min(500.0);
            let leg = [Point::new(at_m, 0.5), Point::new(to_m, 0.5)];
            let drive = drive(&surface, &truth, &leg, clock.allowance());
            clock.drove(&drive);
            at_m = drive.at.x_m;
            if drive.end == DriveEnd::OutOfTime {
                ends.push(at_m);
                clock.begin_next();
            }
        }
        assert_eq!(ends.len(), 2);
        assert!((ends[0] - 200.0).abs() < 1e-9 && (ends[1] - 400.0).abs() < 1e-9, "{ends:?}");
        assert_eq!(StageClock::new(1).allowance(), Allowance::UNLIMITED);
    }
}
