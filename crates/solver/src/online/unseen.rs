//! First values on a map of which hardly anything has been seen.
//!
//! On ground that is alike nearly everywhere, so is the best hop: towards the goal. Then passes outwards from
//! ring to ring ([`super::relaxation`]) settle each for good, or in a few where a strip beyond the goal takes part, in
//! all sectors at once and in the nearest caches: a dozen or two of sweeps in all, where the general solver takes
//! hundreds if the goal lies well inside the map. On rough ground detours make outer rings decide about inner ones, and
//! the general solver is faster by far. So this is tried where most ground is flat, and given up after so many sweeps.

use super::rings::LANES;
use super::{Online, relax_with};
use crate::World;
use crate::extent::Extent;
use crate::simd::Simd;

/// On fewer nodes the general solver is as fast.
const NODES_MIN: usize = 8_000;

/// Sweeps after which it is given up: what they take is little beside a solve that needs as many more.
const SWEEPS_MAX: u64 = 32;

impl Online {
    /// Brings the values of a world that is mostly flat to rest from below; whether that is done.
    pub(super) fn rest_unseen(&mut self, work: &mut u64, work_max: u64, pulse: &dyn Fn()) -> bool {
        if self.world.nodes() < NODES_MIN || !is_mostly_flat(&self.world) {
            return false;
        }
        let extent = Extent::of(Simd::detect(), &self.world);
        let value = extent.value_min(self.world.rules()).max(-self.field.magnitude);
        self.values.clear();
        self.values.resize(self.world.nodes(), value);
        self.values_at.begin(&self.field, &self.world, &self.values);
        let sweeps = SWEEPS_MAX * self.world.nodes() as u64;
        let limits = self.limits(1.0, *work, work_max.min(work.saturating_add(sweeps)));
        *work += LANES as u64 * relax_with(&mut self.values_at, &self.field, &limits, pulse);
        self.values_at.at_rest(&self.field.rings, usize::MAX)
    }
}

/// Whether three quarters of the nodes have no slope.
fn is_mostly_flat(world: &World) -> bool {
    let [east, north] = world.slopes();
    let flat = east.iter().zip(north).filter(|slopes| *slopes == (&0.0, &0.0)).count();
    4 * flat >= 3 * world.nodes()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::online::choice::{CANONICAL_ERROR, TIE};
    use crate::online::{Status, VALUE_ERROR};
    use crate::specimen::Specimen;
    use crate::{Effort, Kind, Site, Solver, policy};

    #[test]
    fn what_is_hardly_seen_comes_to_rest_at_the_solvers_values() {
        for specimen in [Specimen::inner(120, 1), Specimen::plain(95, 2)] {
            let world = specimen.unseen().expect("a size in range");
            let mut online = Online::new(world.clone());
            let mut work = 0;
            assert!(online.provable() && online.rest_unseen(&mut work, u64::MAX, &|| ()), "{specimen:?}");
            assert!(work <= 24 * world.nodes() as u64, "{work} backups, {specimen:?}");
            let mut solver = Solver::new();
            solver.solve(&world, &Effort { error_max: 1e-9, ..Effort::default() });
            for node in (0..world.nodes()).filter(|&node| world.kind(node) == Kind::Free) {
                let seat = online.field.rings.seat(node).expect("a free node has a seat");
                let worth = online.values_at.worths[0][seat.place];
                let error = (worth - world.worth(solver.values(), node)).abs();
                assert!(error <= VALUE_ERROR + 1e-9, "{error:e} at {node}, {specimen:?}");
            }
        }
    }

    #[test]
    fn a_labyrinth_on_flat_ground_is_left_to_the_solver_and_decided_alike() {
        let specimen = Specimen::plain(101, 1);
        let mut world = specimen.unseen().expect("a size in range");
        let site = Site { kind: Kind::Lost, payoff: 0.0, slope_east: 0.0, slope_north: 0.0, soil: 0 };
        for wall in 1..24 {
            let gap = if wall % 2 == 0 { 0 } else { 100 };
            for x in (0..101).filter(|&x| x != gap) {
                world.set(4 * wall * 101 + x, site);
            }
        }
        let mut online = Online::new(world.clone());
        let (mut work, budget) = (0, SWEEPS_MAX * world.nodes() as u64);
        assert!(online.provable() && !online.rest_unseen(&mut work, u64::MAX, &|| ()), "{work} backups");
        assert!(work <= budget + 1_000 * LANES as u64, "{work} backups, a budget of {budget}");
        let decision = online.act(specimen.start(), None);
        let mut solver = Solver::new();
        solver.solve(&world, &Effort { error_max: CANONICAL_ERROR, ..Effort::default() });
        let canonical = policy::hop(&world, solver.values(), specimen.start(), TIE);
        assert_eq!((decision.action, decision.status), (canonical, Status::Solved));
    }
}
