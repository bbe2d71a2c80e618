//! What the figures of all studies share.

use rover::{Belief, SpeedDistribution};

/// The standard deviation of each cell's speed; no number where the rover surely gets stuck.
pub fn spread(belief: &Belief) -> Vec<f64> {
    let sd = |cell: &SpeedDistribution| {
        if cell.mean_m_per_sol() > 0.0 { cell.sd_m_per_sol() } else { f64::NAN }
    };
    belief.cells().iter().map(sd).collect()
}
