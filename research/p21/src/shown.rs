//! What a flight shows, metre by metre.

use helicopter::{Camera, swaths, within_budget};
use rover::{Belief, Point};

/// Sum of the standard deviations of the speeds of all cells seen after each of `at_m` metres of a flight, in m/Sol: the reduction
/// of the spread by a sensor that does not err (P21, Fig. 16).
#[must_use]
pub fn spread_shown(prior: &Belief, flight: &[Point], at_m: &[f64]) -> Vec<f64> {
    let lattice = prior.surface().lattice();
    let mut seen = vec![false; lattice.cells()];
    let mut sum = 0.0;
    let mut shown = |at_m: &f64| {
        for swath in swaths(lattice, &within_budget(flight, *at_m), Camera::default().radius_m()) {
            for cell in swath.cells(lattice) {
                if !std::mem::replace(&mut seen[cell], true) {
                    sum += prior.cells()[cell].sd_m_per_sol();
                }
            }
        }
        sum
    };
    at_m.iter().map(&mut shown).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rover::{Lattice, SpeedDistribution, Surface};
    use std::sync::Arc;

    #[test]
    fn a_cell_counts_when_it_is_first_seen_and_only_once() {
        let even = SpeedDistribution::new([0.5, 0.0, 0.0, 0.5]).unwrap();
        let lattice = Lattice::new(300, 1).unwrap();
        let prior = Belief::new(Arc::new(Surface::flat(lattice)), vec![even; 300]).unwrap();
        let flight = [Point::new(100.5, 0.5), Point::new(200.5, 0.5), Point::new(100.5, 0.5)];
        // 25 m to each side, then 10 and 90 cells more, then nothing new.
        let shown = spread_shown(&prior, &flight, &[0.0, 10.0, 100.0, 200.0]);
        assert_eq!(shown, [5100.0, 6100.0, 15_100.0, 15_100.0]);
    }
}
