//! The solver that keeps values in step with a changing world, and decides by the cheapest method.

use super::choice::{Bounds, CANONICAL_ERROR, TIE};
use super::decision::{DecisionStatus, HopDecision, Method};
use super::dispatch::relax_in_slices;
use super::enclosure::Enclosure;
use super::goal_reachability::GoalReachability;
use super::layout::Layout;
use super::relaxation::{Limits, Relaxation};
use super::tolerance::{STAGES, VALUE_ERROR};
use super::unseen;
use crate::certificate::rounding;
use crate::simd::DOUBLE_LANES as LANES;
use crate::{Certificate, Effort, Error, GridWorld, Kind, Leaving, Site, Solver, action_values, policy};

/// Least clear levels beyond the hopper; with fewer, the frozen levels retreat.
const DEPTH: usize = 4;

/// Clear levels beyond the hopper after levels were frozen or thawed.
const CLEAR: usize = 7;

/// Levels that the hopper moves on before more levels are frozen.
const STRIDE: usize = 9;

/// Levels by which the frozen ones retreat, in turn, where the bounds leave a doubt.
const RETREATS: [usize; 2] = [8, 24];

/// What is up to date with the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Readiness {
    /// Nothing: the layout is that of another world.
    Outdated,
    /// The layout; values have to be solved for.
    LaidOut,
    /// Layout and values.
    Solved,
}

/// Holds a changing world, what is known of its values, and which nodes lead to a goal.
#[derive(Clone, Debug)]
pub struct OnlineSolver {
    world: GridWorld,
    layout: Layout,
    /// The values, as afterstate values.
    values_relaxation: Relaxation<1>,
    /// Bounds on them, valid if `is_enclosed`.
    enclosure: Enclosure,
    is_enclosed: bool,
    readiness: Readiness,
    /// Number of nodes where the hopper is lost.
    lost: usize,
    reachability: GoalReachability,
    solver: Solver,
    values: Vec<f64>,
}

impl OnlineSolver {
    /// Takes `world`, and solves it from nothing at the first decision.
    #[must_use]
    pub fn new(world: GridWorld) -> Self {
        let layout = Layout::new(&world);
        let lost = lost(&world);
        Self {
            world,
            layout,
            values_relaxation: Relaxation::default(),
            enclosure: Enclosure::default(),
            is_enclosed: false,
            readiness: Readiness::LaidOut,
            lost,
            reachability: GoalReachability::default(),
            solver: Solver::new(),
            values: Vec::new(),
        }
    }

    /// The world as it is now.
    #[must_use]
    pub fn world(&self) -> &GridWorld {
        &self.world
    }

    /// Changes one node. Nothing is solved until a decision or values are asked for.
    ///
    /// # Panics
    /// As [`GridWorld::set`].
    pub fn update(&mut self, node: usize, site: Site) {
        let old = self.world.site(node);
        if old == site {
            return;
        }
        self.world.set(node, site);
        self.reachability.changed(&self.world, node, old.kind);
        self.lost = self.lost + usize::from(site.kind == Kind::Lost) - usize::from(old.kind == Kind::Lost);
        // At a goal only the payoff counts, and where the hopper is lost nothing but that.
        let is_lost = old.kind == Kind::Lost && site.kind == Kind::Lost;
        let is_goal = old.kind == Kind::Goal && site.kind == Kind::Goal;
        if is_lost || is_goal && old.payoff == site.payoff {
            return;
        }
        if self.readiness != Readiness::Solved {
            self.readiness = Readiness::Outdated;
            return;
        }
        let centred = self.world.kind(node) == Kind::Goal || old.kind == Kind::Goal;
        let slot = match self.layout.set(node, &site) {
            Some(slot) if !centred => slot,
            _ => {
                self.readiness = Readiness::Outdated;
                return;
            }
        };
        let loss = self.world.rules().loss;
        self.layout.magnitude = self.layout.magnitude.max(4.0 * loss.abs());
        let change = |afterstates: &mut [f64]| {
            afterstates[slot.entry] = match (old.kind, site.kind) {
                (_, Kind::Lost) => loss,
                // Newly passable ground may start from any value.
                (Kind::Lost, _) => afterstates[slot.entry].max(-self.layout.magnitude),
                _ => (afterstates[slot.entry] + (site.payoff - old.payoff))
                    .clamp(-self.layout.magnitude, self.layout.magnitude),
            };
        };
        self.values_relaxation.afterstates.iter_mut().for_each(|afterstates| change(afterstates));
        self.values_relaxation.mark_around(&self.layout, slot);
        if self.is_enclosed {
            self.enclosure.bounds.afterstates.iter_mut().for_each(|afterstates| change(afterstates));
            self.enclosure.bounds.mark_around(&self.layout, slot);
        }
    }

    /// Changes the afterstate value of being lost.
    ///
    /// # Errors
    /// As [`GridWorld::set_loss`].
    pub fn set_loss(&mut self, loss: f64) -> Result<(), Error> {
        if loss != self.world.rules().loss {
            self.world.set_loss(loss)?;
            // The error that the canonical procedure reaches depends on it, even where no hop can be lost.
            self.layout.magnitude = self.layout.magnitude.max(4.0 * loss.abs());
            let matters = self.lost > 0 || self.world.rules().leaving == Leaving::Loses;
            if self.readiness == Readiness::Solved && matters {
                // The change is near every node of the border, and soon everywhere: all values are relaxed again.
                self.read_values();
                self.values_relaxation.begin(&self.layout, &self.world, &self.values);
                self.is_enclosed = false;
            }
        }
        Ok(())
    }

    /// Becomes another world, and forgets everything about the last one.
    pub fn replace(&mut self, world: GridWorld) {
        self.lost = lost(&world);
        self.world = world;
        self.readiness = Readiness::Outdated;
        self.reachability.forget();
    }

    /// Decides at `here` with at most about `work_max` backups.
    ///
    /// Without a bound on the work the hop depends on the world and on `here` alone. With one, it also depends on what
    /// is known already.
    pub fn act(&mut self, here: usize, work_max: Option<u64>) -> HopDecision {
        self.act_with(here, work_max, &|| ())
    }

    /// [`OnlineSolver::act`], calling `pulse` every few tens of milliseconds, for callers that must give signs of life
    /// while a large world is solved from nothing.
    pub fn act_with(&mut self, here: usize, work_max: Option<u64>, pulse: &dyn Fn()) -> HopDecision {
        let mut work = 0;
        let nothing = HopDecision {
            action: None,
            margin: 0.0,
            bound: 0.0,
            status: DecisionStatus::Solved,
            work,
            method: Method::Focused,
        };
        if self.world.kind(here) != Kind::Free {
            return nothing;
        }
        if !self.reachability.leads_to_goal(&self.world, here) {
            return HopDecision { status: DecisionStatus::Infeasible, ..nothing };
        }
        let work_max = work_max.unwrap_or(u64::MAX);
        if !self.lay_out(&mut work, work_max, pulse) {
            return self.canonical(here, work, work_max, pulse);
        }
        if let Some(decision) = self.focused(here, &mut work, work_max, pulse) {
            return decision;
        }
        let converged = self.converge(&mut work, work_max, pulse);
        let bound = if converged { self.error() } else { self.cut_error() };
        let bounds = self.bounds(here, [&self.values_relaxation.afterstates[0]; 2], bound);
        match bounds.hop() {
            Some(hop) if converged => {
                let margin = bounds.margin(hop);
                HopDecision {
                    action: Some(hop),
                    margin,
                    bound,
                    status: DecisionStatus::Solved,
                    work,
                    method: Method::Warm,
                }
            }
            _ if converged && work < work_max || self.values_relaxation.has_given_up(&self.layout.rings) => {
                if !converged {
                    self.readiness = Readiness::LaidOut;
                }
                self.canonical(here, work, work_max, pulse)
            }
            _ => {
                let centre: [f64; 4] =
                    std::array::from_fn(|hop| 0.5 * (bounds.lower[hop] + bounds.upper[hop]));
                let hop = policy::first_best(centre, TIE);
                let margin = bounds.margin(hop);
                HopDecision {
                    action: Some(hop),
                    margin,
                    bound,
                    status: DecisionStatus::Cut,
                    work,
                    method: Method::Warm,
                }
            }
        }
    }

    /// Converges all values to the certificate and returns the work, in backups of a node.
    pub fn converge_all(&mut self) -> u64 {
        let mut work = 0;
        if self.lay_out(&mut work, u64::MAX, &|| ()) {
            self.converge(&mut work, u64::MAX, &|| ());
        }
        work
    }

    /// All values, row-major, converged to the certificate.
    pub fn values(&mut self) -> (&[f64], Certificate) {
        let converged = self.lay_out(&mut 0, u64::MAX, &|| ()) && self.converge(&mut 0, u64::MAX, &|| ());
        let certificate = if converged {
            let residual = self.tolerance() + rounding(self.layout.magnitude);
            self.read_values();
            Certificate { residual, error_bound: residual / (1.0 - self.world.rules().discount) }
        } else {
            let solution =
                self.solver.solve(&self.world, &Effort { error_max: VALUE_ERROR, ..Effort::default() });
            self.values.clear();
            self.values.extend_from_slice(self.solver.values());
            solution.certificate
        };
        (&self.values, certificate)
    }

    /// Copies the values out, row-major.
    fn read_values(&mut self) {
        let Self { world, layout, values_relaxation, values, .. } = self;
        values.clear();
        values.extend((0..world.nodes()).map(|node| match world.kind(node) {
            Kind::Free => {
                let slot = layout.rings.slot(node).expect("a free node has a slot");
                values_relaxation.afterstates[0][slot.entry] - world.payoff(node)
            }
            Kind::Goal => 0.0,
            Kind::Lost => world.rules().loss,
        }));
    }

    /// Whether bounds can be proven on this world at all, and narrow enough to be of use: there is a goal
    /// at the centre of the layout, rounding is small against [`CANONICAL_ERROR`], and the soils sum to 1.
    fn is_provable(&self) -> bool {
        let exact = |soil: &crate::Soil| {
            (soil.intended + soil.stuck + 2.0 * soil.sideways - 1.0).abs() <= 4.0 * f64::EPSILON
        };
        let rules = self.world.rules();
        let rounded = 4.0 * rounding(self.layout.magnitude) / (1.0 - rules.discount);
        self.layout.centred && rounded <= CANONICAL_ERROR && rules.soils.iter().all(exact)
    }

    /// Residual to converge to. It does not depend on the magnitude of the values, as long as anything is provable, so
    /// that what converged before remains so.
    fn tolerance(&self) -> f64 {
        (VALUE_ERROR - 0.5 * CANONICAL_ERROR) * (1.0 - self.world.rules().discount)
    }

    /// Bound on the error of converged values.
    fn error(&self) -> f64 {
        (self.tolerance() + rounding(self.layout.magnitude)) / (1.0 - self.world.rules().discount)
    }

    /// Bound on the error of values that have not converged.
    fn cut_error(&self) -> f64 {
        let residual = self
            .values_relaxation
            .worst(&self.layout, 0..usize::MAX, |[residual]| residual.abs())
            .max(self.tolerance());
        (residual + rounding(self.layout.magnitude)) / (1.0 - self.world.rules().discount)
    }

    /// Lays the world out and solves it from nothing, unless that is done. False if bounds cannot be proven on it.
    fn lay_out(&mut self, work: &mut u64, work_max: u64, pulse: &dyn Fn()) -> bool {
        if self.readiness == Readiness::Solved {
            return self.is_provable();
        }
        if self.readiness == Readiness::Outdated {
            self.layout = Layout::new(&self.world);
            self.readiness = Readiness::LaidOut;
        }
        if !self.is_provable() {
            return false;
        }
        if !self.converge_unseen(work, work_max, pulse) {
            self.solve_all(work, work_max, pulse);
        }
        self.is_enclosed = false;
        self.readiness = Readiness::Solved;
        true
    }

    /// Solves the world from nothing, and starts the relaxation from the values.
    fn solve_all(&mut self, work: &mut u64, work_max: u64, pulse: &dyn Fn()) {
        let nodes = self.world.nodes() as u64;
        let sweeps_max = (work_max.saturating_sub(*work) / nodes).max(1);
        let effort = Effort { error_max: VALUE_ERROR, sweeps_max };
        let solution = self.solver.solve_with(&self.world, &effort, pulse);
        *work += solution.sweeps * nodes;
        let Self { layout, values_relaxation, world, solver, .. } = self;
        values_relaxation.begin(layout, world, solver.values());
    }

    /// Converges the values of a mostly flat world from below; whether that was done ([`unseen`]).
    fn converge_unseen(&mut self, work: &mut u64, work_max: u64, pulse: &dyn Fn()) -> bool {
        let Some(value) = unseen::start_value(&self.world, &self.layout) else { return false };
        self.values.clear();
        self.values.resize(self.world.nodes(), value);
        self.values_relaxation.begin(&self.layout, &self.world, &self.values);
        let sweeps = unseen::SWEEPS_MAX * self.world.nodes() as u64;
        self.converge(work, work_max.min(work.saturating_add(sweeps)), pulse)
    }

    /// Converges all values; whether the work sufficed.
    fn converge(&mut self, work: &mut u64, work_max: u64, pulse: &dyn Fn()) -> bool {
        let limits = self.limits(1.0, *work, work_max);
        *work += LANES as u64 * relax_in_slices(&mut self.values_relaxation, &self.layout, &limits, pulse);
        self.values_relaxation.is_converged(&self.layout.rings, usize::MAX)
    }

    fn limits(&self, stage: f64, work: u64, work_max: u64) -> Limits {
        let finest = self.tolerance();
        Limits {
            tolerance: stage * finest,
            finest,
            frozen_from: usize::MAX,
            visits_max: work_max.saturating_sub(work) / LANES as u64,
        }
    }

    /// Decides by bounds around the hopper, if they are close enough.
    fn focused(
        &mut self,
        here: usize,
        work: &mut u64,
        work_max: u64,
        pulse: &dyn Fn(),
    ) -> Option<HopDecision> {
        let level = self.layout.rings.level(here)?;
        if !self.is_enclosed {
            let worthwhile = level + CLEAR + STRIDE < self.layout.rings.levels;
            (worthwhile && self.converge(work, work_max, pulse)).then_some(())?;
            self.enclosure.start(&self.layout, &self.values_relaxation);
            self.is_enclosed = true;
        }
        if self.enclosure.frozen_from() < level + DEPTH {
            self.enclosure.thaw_to(&self.layout, level + CLEAR);
        } else if self.enclosure.frozen_from() > level + CLEAR + STRIDE {
            self.enclosure.freeze_from(&self.layout, level + CLEAR);
        }
        for stage in STAGES {
            if let Some(decision) = self.enclosed(here, stage, work, work_max, pulse) {
                return Some(decision);
            }
        }
        for retreat in RETREATS {
            self.enclosure.thaw_to(&self.layout, level + retreat + CLEAR);
            if let Some(decision) = self.enclosed(here, 1.0, work, work_max, pulse) {
                return Some(decision);
            }
        }
        self.is_enclosed = false;
        None
    }

    /// Decides by bounds converged at the tolerance of a stage, if they are close enough.
    fn enclosed(
        &mut self,
        here: usize,
        stage: f64,
        work: &mut u64,
        work_max: u64,
        pulse: &dyn Fn(),
    ) -> Option<HopDecision> {
        let limits = self.limits(stage, *work, work_max);
        let Self { enclosure, layout, .. } = self;
        let mut visits = 0;
        let converged = enclosure.converge(layout, &limits, &mut |bounds, limits| {
            let visits_max = limits.visits_max.saturating_sub(visits);
            visits += 2 * relax_in_slices(bounds, layout, &Limits { visits_max, ..*limits }, pulse);
        });
        *work += LANES as u64 * visits;
        converged.then_some(())?;
        let error = (limits.tolerance + rounding(self.layout.magnitude)) / (1.0 - self.layout.discount);
        let bounds =
            self.bounds(here, self.enclosure.bounds.afterstates.each_ref().map(Vec::as_slice), error);
        let hop = bounds.hop()?;
        Some(HopDecision {
            action: Some(hop),
            margin: bounds.margin(hop),
            bound: bounds.width(),
            status: DecisionStatus::Solved,
            work: *work,
            method: Method::Focused,
        })
    }

    /// Bounds on the hop values, from fields that are super- and sub-harmonic to within `error` (1 − γ).
    fn bounds(&self, here: usize, [upper, lower]: [&[f64]; 2], error: f64) -> Bounds {
        let slack = error + rounding(self.layout.magnitude);
        Bounds {
            lower: self.hop_values(here, lower).map(|value| value - slack),
            upper: self.hop_values(here, upper).map(|value| value + slack),
        }
    }

    /// Bellman's right-hand sides at a node, by the definition.
    fn hop_values(&self, here: usize, afterstates: &[f64]) -> [f64; 4] {
        let rules = self.world.rules();
        let afterstate = |node: usize| match self.world.kind(node) {
            Kind::Free => afterstates[self.layout.rings.slot(node).expect("a free node has a slot").entry],
            Kind::Goal => self.world.payoff(node),
            Kind::Lost => rules.loss,
        };
        crate::bellman::hop_values(&self.world, here, afterstate)
    }

    /// Decides by a solve from nothing.
    fn canonical(&mut self, here: usize, mut work: u64, work_max: u64, pulse: &dyn Fn()) -> HopDecision {
        let nodes = self.world.nodes() as u64;
        let sweeps_max =
            if work_max == u64::MAX { u64::MAX } else { (work_max.saturating_sub(work) / nodes).max(1) };
        let effort = Effort { error_max: CANONICAL_ERROR, sweeps_max };
        let solution = self.solver.solve_with(&self.world, &effort, pulse);
        work += solution.sweeps * nodes;
        let values = action_values(&self.world, self.solver.values(), here);
        let hop = policy::first_best(values, TIE);
        let bound = solution.certificate.error_bound;
        let bounds = Bounds { lower: values.map(|q| q - bound), upper: values.map(|q| q + bound) };
        let status =
            if solution.status.is_converged() { DecisionStatus::Solved } else { DecisionStatus::Cut };
        assert!(
            status == DecisionStatus::Cut || bound <= CANONICAL_ERROR || !self.is_provable(),
            "the canonical procedure needs an error of at most {CANONICAL_ERROR:e}, got {bound:e}"
        );
        HopDecision {
            action: Some(hop),
            margin: bounds.margin(hop),
            bound,
            status,
            work,
            method: Method::Canonical,
        }
    }
}

fn lost(world: &GridWorld) -> usize {
    (0..world.nodes()).filter(|&node| world.kind(node) == Kind::Lost).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::{Fixture, GoalPlace, SplitMix64};

    /// P-ENCLOSED: The bounds that prove an action hold at every node of the map, at every stage of
    /// their refinement.
    #[test]
    fn the_bounds_hold_at_every_node_frozen_or_clear_and_at_every_stage() {
        let mut solver = Solver::new();
        let mut frozen = 0;
        for (seed, radius, place) in [
            (3, 5, GoalPlace::Corner),
            (4, 2, GoalPlace::Corner),
            (5, 3, GoalPlace::Inside),
            (6, 4, GoalPlace::Side),
        ] {
            let fixture = Fixture { place, ..Fixture::plain(92, seed) };
            let truth = fixture.world().expect("a size in range");
            let (width, height) = (truth.width(), truth.height());
            let mut online = OnlineSolver::new(fixture.unseen().expect("a size in range"));
            let mut draw = SplitMix64(seed);
            let mut here = fixture.start();
            for hop in 0..90 {
                let (x, y) = (here % width, here / width);
                for y in y.saturating_sub(radius)..(y + radius + 1).min(height) {
                    for x in x.saturating_sub(radius)..(x + radius + 1).min(width) {
                        online.update(y * width + x, truth.site(y * width + x));
                    }
                }
                let Some(action) = online.act(here, None).action else { break };
                if hop % 11 == 10 && online.is_enclosed {
                    frozen += usize::from(online.enclosure.frozen_from() < online.layout.rings.levels);
                    solver.solve(&online.world, &Effort { error_max: 1e-8, ..Effort::default() });
                    for stage in STAGES {
                        online.enclosed(here, stage, &mut 0, u64::MAX, &|| ());
                        let error = stage * online.tolerance() / (1.0 - online.layout.discount) + 2e-8;
                        for node in (0..width * height).filter(|&node| truth.kind(node) == Kind::Free) {
                            let afterstate = online.world.afterstate_value(solver.values(), node);
                            let [upper, lower] = online.enclosure.bounds_at(&online.layout, node);
                            assert!(
                                afterstate <= upper + error,
                                "{afterstate} under {upper}, stage {stage}, {node}"
                            );
                            assert!(
                                afterstate >= lower - error,
                                "{afterstate} over {lower}, stage {stage}, {node}"
                            );
                        }
                    }
                }
                // Sometimes in another direction, so that frozen levels have to retreat.
                let other = [action, action.left(), action.right()][(draw.uniform() * 3.3) as usize % 3];
                here = truth.neighbour(here, if hop % 5 == 0 { other } else { action }).unwrap_or(here);
            }
        }
        assert!(frozen > 6, "{frozen}");
    }

    #[test]
    fn what_is_hardly_seen_comes_to_rest_at_the_solvers_values() {
        for fixture in [Fixture::inner(120, 1), Fixture::plain(95, 2)] {
            let world = fixture.unseen().expect("a size in range");
            let mut online = OnlineSolver::new(world.clone());
            let mut work = 0;
            assert!(
                online.is_provable() && online.converge_unseen(&mut work, u64::MAX, &|| ()),
                "{fixture:?}"
            );
            assert!(work <= 24 * world.nodes() as u64, "{work} backups, {fixture:?}");
            let mut solver = Solver::new();
            solver.solve(&world, &Effort { error_max: 1e-9, ..Effort::default() });
            for node in (0..world.nodes()).filter(|&node| world.kind(node) == Kind::Free) {
                let slot = online.layout.rings.slot(node).expect("a free node has a slot");
                let afterstate = online.values_relaxation.afterstates[0][slot.entry];
                let error = (afterstate - world.afterstate_value(solver.values(), node)).abs();
                assert!(error <= VALUE_ERROR + 1e-9, "{error:e} at {node}, {fixture:?}");
            }
        }
    }

    #[test]
    fn a_labyrinth_on_flat_ground_is_left_to_the_solver_and_decided_alike() {
        let fixture = Fixture::plain(101, 1);
        let mut world = fixture.unseen().expect("a size in range");
        let site = Site { kind: Kind::Lost, payoff: 0.0, slope_east: 0.0, slope_north: 0.0, soil: 0 };
        for wall in 1..24 {
            let gap = if wall % 2 == 0 { 0 } else { 100 };
            for x in (0..101).filter(|&x| x != gap) {
                world.set(4 * wall * 101 + x, site);
            }
        }
        let mut online = OnlineSolver::new(world.clone());
        let (mut work, budget) = (0, unseen::SWEEPS_MAX * world.nodes() as u64);
        assert!(
            online.is_provable() && !online.converge_unseen(&mut work, u64::MAX, &|| ()),
            "{work} backups"
        );
        assert!(work <= budget + 1_000 * LANES as u64, "{work} backups, a budget of {budget}");
        let decision = online.act(fixture.start(), None);
        let mut solver = Solver::new();
        solver.solve(&world, &Effort { error_max: CANONICAL_ERROR, ..Effort::default() });
        let canonical = policy::hop(&world, solver.values(), fixture.start(), TIE);
        assert_eq!((decision.action, decision.status), (canonical, DecisionStatus::Solved));
    }
}
