//! What is known of the ground, and what is true of it.

use std::sync::Arc;

use crate::{CostMap, Speed, SpeedDistribution, Surface};

/// The speeds that each cell may have. Before the mission this is the *prior*; observations make cells certain.
#[derive(Clone, Debug, PartialEq)]
pub struct Belief {
    surface: Arc<Surface>,
    cells: Vec<SpeedDistribution>,
}

/// The speed that each cell has. No planner may read it.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// In the order of the lattice's cells.
    pub speeds: Vec<Speed>,
}

/// Another number of values than of cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the ground needs speeds for each of its {need} cells, got {got}")]
pub struct BeliefError {
    /// Cells of the lattice.
    pub need: usize,
    /// Values given.
    pub got: usize,
}

/// Which cells a safe planner keeps out of. The paper gives them a large finite cost; here they are forbidden.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Caution {
    /// Forbidden from this standard deviation of the speed on, in m/Sol.
    pub sd_forbidden_m_per_sol: f64,
    /// Forbidden above this probability of getting stuck, 0 to 1. Not in the paper: (0: .25, 200: .75) has a standard deviation
    /// of 86.6 m/Sol, and strands a quarter of the rovers.
    pub stuck_max: f64,
}

impl Default for Caution {
    /// That of the paper: 90 m/Sol; and a probability of 1 % of getting stuck.
    fn default() -> Self {
        Self { sd_forbidden_m_per_sol: 90.0, stuck_max: 0.01 }
    }
}

impl Caution {
    /// Whether a safe planner may enter a cell with these speeds.
    #[must_use]
    pub fn allows(&self, cell: &SpeedDistribution) -> bool {
        cell.mean_m_per_sol() > 0.0
            && cell.sd_m_per_sol() < self.sd_forbidden_m_per_sol
            && cell.probability(Speed::Zero) <= self.stuck_max
    }

    /// Expected time for a metre in a cell with these speeds; infinite where it is forbidden.
    #[must_use]
    pub fn pace_sol_per_m(&self, cell: &SpeedDistribution) -> f64 {
        if self.allows(cell) { cell.expected_pace_sol_per_m() } else { f64::INFINITY }
    }
}

impl Belief {
    /// The belief with these speeds, in the order of the lattice's cells.
    ///
    /// # Errors
    /// If there are not as many as cells.
    pub fn new(surface: Arc<Surface>, cells: Vec<SpeedDistribution>) -> Result<Self, BeliefError> {
        let need = surface.lattice().cells();
        if cells.len() == need {
            Ok(Self { surface, cells })
        } else {
            Err(BeliefError { need, got: cells.len() })
        }
    }

    /// The shape of the ground.
    #[must_use]
    pub fn surface(&self) -> &Arc<Surface> {
        &self.surface
    }

    /// The speeds of each cell, in the order of the lattice.
    #[must_use]
    pub fn cells(&self) -> &[SpeedDistribution] {
        &self.cells
    }

    /// Replaces what is known of a cell, by observation or by an update of its probabilities.
    pub fn set(&mut self, cell: usize, speeds: SpeedDistribution) {
        self.cells[cell] = speeds;
    }

    /// Cost for the safe planners: expected time, in Sol per metre, infinite in forbidden cells.
    #[must_use]
    pub fn expected_time(&self, caution: Caution) -> CostMap {
        self.costs(|cell| caution.pace_sol_per_m(cell))
    }

    /// Cost for the naive planner: metres; infinite only where the speed is surely 0.
    #[must_use]
    pub fn distance(&self) -> CostMap {
        self.costs(|cell| if cell.mean_m_per_sol() > 0.0 { 1.0 } else { f64::INFINITY })
    }

    /// The cost of each cell. Neighbours mostly share a distribution, so a repeated one is not computed again.
    fn costs(&self, cost: impl Fn(&SpeedDistribution) -> f64) -> CostMap {
        let mut last =
            (SpeedDistribution::certain(Speed::Fast), cost(&SpeedDistribution::certain(Speed::Fast)));
        let costs = self.cells.iter().map(|cell| {
            if *cell != last.0 {
                last = (*cell, cost(cell));
            }
            last.1
        });
        CostMap::new(Arc::clone(&self.surface), costs.collect())
    }
}

impl Truth {
    /// The belief of one who knows everything.
    ///
    /// # Errors
    /// If there are not as many speeds as cells of the surface.
    pub fn known(&self, surface: Arc<Surface>) -> Result<Belief, BeliefError> {
        Belief::new(surface, self.speeds.iter().map(|speed| SpeedDistribution::certain(*speed)).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Lattice;

    #[test]
    fn a_quarter_of_stranded_rovers_is_forbidden_although_the_spread_is_small() {
        let cell = SpeedDistribution::new([0.25, 0.0, 0.0, 0.75]).unwrap();
        assert!(cell.sd_m_per_sol() < Caution::default().sd_forbidden_m_per_sol);
        assert!(!Caution::default().allows(&cell));
        let paper = Caution { stuck_max: 1.0, ..Caution::default() };
        assert!(paper.allows(&cell));
    }

    #[test]
    fn only_certain_obstacles_stop_the_naive_planner() {
        let surface = Arc::new(Surface::flat(Lattice::new(3, 1).unwrap()));
        let risky = SpeedDistribution::new([0.5, 0.0, 0.0, 0.5]).unwrap();
        let cells =
            vec![risky, SpeedDistribution::certain(Speed::Zero), SpeedDistribution::certain(Speed::Slow)];
        let belief = Belief::new(Arc::clone(&surface), cells).unwrap();
        assert_eq!(belief.distance().costs(), [1.0, f64::INFINITY, 1.0]);
        assert_eq!(belief.expected_time(Caution::default()).costs(), [f64::INFINITY, f64::INFINITY, 0.02]);
        assert_eq!(Belief::new(surface, vec![risky]).unwrap_err(), BeliefError { need: 3, got: 1 });
    }
}
