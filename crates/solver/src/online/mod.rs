//! Decisions while the map grows: after each landing a few nodes change, and the next hop is wanted.
//!
//! An [`Online`] session holds a world and what is known of its values. [`Online::update`] takes in a
//! changed node; [`Online::act`] decides at a node, by the cheapest way that proves its answer:
//!
//! - **focused** ([`How::Focused`]): values are brought up to date around the hopper and ahead of it, and
//!   enclosed in bounds behind;
//! - **warm** ([`How::Warm`]): all values are brought back to the certificate, from where they were;
//! - **canonical** ([`How::Canonical`]): the world is solved from nothing.
//!
//! Which of the three it was shows in the [`Decision`], and in its work, never in its hop: see [`choice`].
//!
//! # Warm
//! See `relaxation`: when nothing is marked any more, every residual |V − TV| is at most a tolerance τ, so
//! |V − V*| ≤ τ / (1 − γ), as after a full sweep. Only what a change reaches is visited. That is the cone
//! of nodes whose way leads through the change, on the far side of it as seen from the goal, and it may be
//! most of the map.
//!
//! # Focused
//! What lies behind hardly matters to the hopper: it comes back into play only through slips, each of
//! which has a small probability. What is needed is proof. Let U be *super-harmonic* (TU ≤ U) and L
//! *sub-harmonic* (TL ≥ L). T is monotone and T^n U → V*, so L ≤ V* ≤ U; if the inequalities hold only to
//! within τ, then L − τ/(1−γ) ≤ V* ≤ U + τ/(1−γ), since T(U + c) = TU + γc. So two fields are kept, and all
//! that is to be shown is one inequality a node.
//!
//! A *line* is drawn behind the hopper: a ring ℓ. Nodes on rings from ℓ on are *frozen*; nearer ones are
//! *clear*. Drawing it raises U by a reserve S on **all** frozen nodes, and lowers L by as much:
//!
//! - at a frozen node whose neighbours are frozen, T(U + S) = TU + γS ≤ U + S;
//! - at one of ring ℓ, with neighbours on the clear ring ℓ − 1, the more so, for those were not raised;
//! - clear nodes are relaxed under what ring ℓ has become, until they are at rest again.
//!
//! So U stays super-harmonic everywhere, and only ring ℓ need be touched: beyond it the reserve stands in
//! the proof, and in no memory. (Rings ℓ and ℓ + 1 are written, for these are read.) After each update the
//! clear nodes are relaxed. A change of theirs reaches ring ℓ from ring ℓ − 1 only, so there, and nowhere
//! behind, is TU ≤ U to be measured anew. As long as no cumulated change exceeds the reserve it holds; when
//! it fails, another reserve is laid on, by the same argument. When the hopper has gone on, the line is
//! drawn anew nearer to it: raising all that is frozen then, the nodes between the lines included, again
//! changes nothing that was shown.
//!
//! At the hopper, U − L is what the reserve comes to through a dozen slips in a row, and the hop values
//! under U and L give [`choice::Bounds`]. If they do not tell, the session falls back to the warm solve, and
//! that to the canonical procedure. The same if the world changes behind the line, or the hopper comes
//! close to it.
//!
//! # Rounding
//! Worths and constants stay within a magnitude M, enforced. To first order in u = 2⁻⁵³ the kernel's
//! residual carries at most 27 u M: six roundings of a product of probabilities and discount, seven of a
//! landing's worth, three for its weight, eleven in the landings beside, weighted with at most one in all,
//! nine in the sums. [`crate::certificate::rounding`] allows 32 u M, and is added to τ in every bound.

pub mod choice;
mod field;
mod kernel;
mod relaxation;
mod rings;
mod simd;
mod witness;

use crate::certificate::rounding;
use crate::{
    Certificate, Effort, Error, Hop, Kind, Leaving, Site, Solver, Status as SolveStatus, World,
    action_values, policy,
};
use choice::{Bounds, CANONICAL_ERROR, TIE};
use field::Field;
use relaxation::{Limits, Relaxation};
use rings::LANES;
use simd::relax;
use witness::{Witness, landings};

/// Bound on the error of a session's values, in units of payoff: a little below the 1e-6 that is promised.
pub const VALUE_ERROR: f64 = 0.99e-6;

/// Rings between the hopper and the line, beyond those that its sensor reaches.
const DEPTH: usize = 7;

/// The line is drawn anew when the hopper has gone on by so many rings.
const STRIDE: usize = 10;

/// On fewer nodes than these, bringing all values to rest takes no longer than two bounds.
const NODES_MIN: usize = 8_000;

/// Rings it may then go back before the line is too near.
const GAP: usize = 4;

/// First reserve, in units of payoff; it doubles whenever it does not last.
const RESERVE: f64 = 1.0;

/// Reserves laid on for one decision, at most.
const RESERVES_MAX: usize = 4;

/// How a decision was proven.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum How {
    /// By bounds around the hopper.
    Focused,
    /// By values brought back to the certificate everywhere.
    Warm,
    /// By a solve from nothing.
    Canonical,
}

/// What kind of answer a decision is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The canonical hop.
    Solved,
    /// The budget ran out: the best hop so far.
    Cut,
    /// No chain of hops leads from here to a goal: there is no hop to take.
    Infeasible,
}

/// The answer to "where to?".
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// The hop; `None` at a goal, where lost, and where no goal can be reached.
    pub action: Option<Hop>,
    /// By how much it is certainly better than any other, in units of payoff. Negative if another may be
    /// better by as much: at most [`choice::TIE`] where solved, but for the width of the bounds.
    pub margin: f64,
    /// Bound on the error of the values decided by, in units of payoff.
    pub bound: f64,
    /// What kind of answer it is.
    pub status: Status,
    /// Work done, in backups of a node.
    pub work: u64,
    /// How it was proven.
    pub how: How,
}

/// A session.
#[derive(Clone, Debug)]
pub struct Online {
    world: World,
    field: Field,
    /// The values' worths, while there is no line.
    values_at: Relaxation<1>,
    /// While there is a line, a super-harmonic field and a sub-harmonic one.
    bounds_at: Relaxation<2>,
    line: Option<Line>,
    /// Whether values, field and world belong together.
    laid_out: bool,
    /// Nodes where the hopper is lost.
    lost: usize,
    witness: Witness,
    solver: Solver,
    values: Vec<f64>,
}

/// Where the frozen nodes begin.
#[derive(Clone, Copy, Debug)]
struct Line {
    level: usize,
    /// The reserve to lay on next.
    reserve: f64,
    /// Whether what was shown behind it no longer holds.
    broken: bool,
    /// Level of the farthest node updated since the last decision.
    updated: usize,
    /// How far behind the hopper updates have come of late, in eighths of a ring.
    reach: usize,
}

impl Online {
    /// A session on `world`, solved from nothing at the first decision.
    #[must_use]
    pub fn new(world: World) -> Self {
        let field = Field::new(&world);
        let lost = lost(&world);
        Self {
            world,
            field,
            values_at: Relaxation::default(),
            bounds_at: Relaxation::default(),
            line: None,
            laid_out: false,
            lost,
            witness: Witness::default(),
            solver: Solver::new(),
            values: Vec::new(),
        }
    }

    /// The world as it is now.
    #[must_use]
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Changes one node. Nothing is solved until a decision or values are asked for.
    ///
    /// # Panics
    /// As [`World::set`].
    pub fn update(&mut self, node: usize, site: Site) {
        let old = self.world.site(node);
        if old == site {
            return;
        }
        let before = (old.kind, landings(&self.world, node));
        self.world.set(node, site);
        self.witness.changed(node, before, (site.kind, landings(&self.world, node)));
        self.lost = self.lost + usize::from(site.kind == Kind::Lost) - usize::from(old.kind == Kind::Lost);
        if !self.laid_out {
            return;
        }
        let centred = self.world.kind(node) == Kind::Goal || old.kind == Kind::Goal;
        let Some(seat) = self.field.set(node, &site).filter(|_| !centred) else {
            self.laid_out = false;
            return;
        };
        let level = self.field.rings.level(node).expect("a node with a seat has a level");
        let loss = self.world.rules().loss;
        self.field.magnitude = self.field.magnitude.max(4.0 * loss.abs());
        let change = |worths: &mut [f64]| {
            worths[seat.place] = match (old.kind, site.kind) {
                (_, Kind::Lost) => loss,
                // Ground where there was none: whatever, to begin with.
                (Kind::Lost, _) => worths[seat.place].max(-self.field.magnitude),
                _ => worths[seat.place] + (site.payoff - old.payoff),
            };
        };
        match &mut self.line {
            None => {
                self.values_at.worths.iter_mut().for_each(|worths| change(worths));
                self.values_at.touch(&self.field, seat, level);
            }
            Some(line) => {
                self.bounds_at.worths.iter_mut().for_each(|worths| change(worths));
                self.bounds_at.touch(&self.field, seat, level);
                line.broken |= level + 2 > line.level;
                line.updated = line.updated.max(level);
            }
        }
    }

    /// Changes what being lost is worth.
    ///
    /// # Errors
    /// As [`World::set_loss`].
    pub fn set_loss(&mut self, loss: f64) -> Result<(), Error> {
        if loss != self.world.rules().loss {
            self.world.set_loss(loss)?;
            let matters = self.lost > 0 || self.world.rules().leaving == Leaving::Loses;
            self.laid_out &= !matters;
        }
        Ok(())
    }

    /// Becomes another world. What was known is forgotten.
    pub fn replace(&mut self, world: World) {
        self.lost = lost(&world);
        self.world = world;
        self.laid_out = false;
        self.witness.forget();
    }

    /// Decides at `here` with at most about `work_max` backups.
    ///
    /// Without a bound on the work the hop depends on the world and on `here` alone. With one, a session
    /// that knows more gets further.
    pub fn act(&mut self, here: usize, work_max: Option<u64>) -> Decision {
        let mut work = 0;
        let nothing = Decision {
            action: None,
            margin: 0.0,
            bound: 0.0,
            status: Status::Solved,
            work,
            how: How::Focused,
        };
        if self.world.kind(here) != Kind::Free {
            return nothing;
        }
        if !self.witness.leads_to_goal(&self.world, here) {
            return Decision { status: Status::Infeasible, ..nothing };
        }
        let work_max = work_max.unwrap_or(u64::MAX);
        if !self.lay_out(&mut work, work_max) {
            return self.canonical(here, work, work_max);
        }
        if let Some(decision) = self.focused(here, &mut work, work_max) {
            return decision;
        }
        let rested = self.settle(&mut work, work_max);
        let bound = if rested { self.error() } else { self.cut_error() };
        let bounds = self.bounds(here, [&self.values_at.worths[0]; 2], bound);
        match bounds.hop() {
            Some(hop) if rested => {
                let margin = bounds.margin(hop);
                Decision { action: Some(hop), margin, bound, status: Status::Solved, work, how: How::Warm }
            }
            None if rested && work < work_max => self.canonical(here, work, work_max),
            _ => {
                let centre: [f64; 4] =
                    std::array::from_fn(|hop| 0.5 * (bounds.lower[hop] + bounds.upper[hop]));
                let hop = policy::first_best(centre, TIE);
                let margin = bounds.margin(hop);
                Decision { action: Some(hop), margin, bound, status: Status::Cut, work, how: How::Warm }
            }
        }
    }

    /// Brings all values to the certificate; the work, in backups of a node.
    pub fn rest(&mut self) -> u64 {
        let mut work = 0;
        if self.lay_out(&mut work, u64::MAX) {
            self.settle(&mut work, u64::MAX);
        }
        work
    }

    /// All values, row-major, brought to the certificate first.
    pub fn values(&mut self) -> (&[f64], Certificate) {
        let mut certificate = None;
        if self.lay_out(&mut 0, u64::MAX) {
            self.settle(&mut 0, u64::MAX);
            let discount = self.world.rules().discount;
            let residual = self.tolerance() + rounding(self.field.magnitude);
            certificate = Some(Certificate { residual, error_bound: residual / (1.0 - discount) });
            self.values.clear();
            self.values.extend((0..self.world.nodes()).map(|node| match self.world.kind(node) {
                Kind::Free => {
                    let seat = self.field.rings.seat(node).expect("a free node has a seat");
                    self.values_at.worths[0][seat.place] - self.world.payoff(node)
                }
                Kind::Goal => 0.0,
                Kind::Lost => self.world.rules().loss,
            }));
        } else {
            let solution = self.solver.solve(&self.world, &Effort::default());
            self.values.clear();
            self.values.extend_from_slice(self.solver.values());
            certificate = certificate.or(Some(solution.certificate));
        }
        (&self.values, certificate.expect("one of the two"))
    }

    /// Whether bounds can be proven on this world at all, and narrow enough to be of use: there is a goal
    /// around which the field lies, rounding is small against [`CANONICAL_ERROR`], and the soils sum to 1.
    fn provable(&self) -> bool {
        let exact = |soil: &crate::Soil| {
            (soil.intended + soil.stuck + 2.0 * soil.sideways - 1.0).abs() <= 4.0 * f64::EPSILON
        };
        let rules = self.world.rules();
        let rounded = 4.0 * rounding(self.field.magnitude) / (1.0 - rules.discount);
        self.field.centred && rounded <= CANONICAL_ERROR && rules.soils.iter().all(exact)
    }

    /// Residual to come to rest at.
    fn tolerance(&self) -> f64 {
        VALUE_ERROR * (1.0 - self.world.rules().discount) - 2.0 * rounding(self.field.magnitude)
    }

    /// Error of values at rest.
    fn error(&self) -> f64 {
        (self.tolerance() + rounding(self.field.magnitude)) / (1.0 - self.world.rules().discount)
    }

    /// Error of values that are not.
    fn cut_error(&self) -> f64 {
        let residual = self
            .values_at
            .worst(&self.field, 0..usize::MAX, |[residual]| residual.abs())
            .max(self.tolerance());
        (residual + rounding(self.field.magnitude)) / (1.0 - self.world.rules().discount)
    }

    /// Lays the world out and solves it from nothing, unless that is done; whether bounds can be proven.
    fn lay_out(&mut self, work: &mut u64, work_max: u64) -> bool {
        if self.laid_out {
            return self.provable();
        }
        self.field = Field::new(&self.world);
        if !self.provable() {
            return false;
        }
        let nodes = self.world.nodes() as u64;
        let effort = Effort { error_max: VALUE_ERROR, sweeps_max: (work_max / nodes).max(1) };
        let solution = self.solver.solve(&self.world, &effort);
        *work += solution.sweeps * nodes;
        self.field.worths(&self.world, self.solver.values(), &mut self.values_at.worths[0]);
        self.values_at.clear(&self.field.rings);
        for level in 0..self.field.rings.levels {
            self.values_at.touch_level(&self.field.rings, level);
        }
        self.line = None;
        self.laid_out = true;
        true
    }

    /// Brings all values to rest, the line given up; whether the work sufficed.
    fn settle(&mut self, work: &mut u64, work_max: u64) -> bool {
        if let Some(line) = self.line.take() {
            self.values_at.take_over(&self.bounds_at);
            for level in line.level..self.field.rings.levels {
                self.values_at.touch_level(&self.field.rings, level);
            }
        }
        let limits = self.limits(usize::MAX, *work, work_max);
        *work += LANES as u64 * relax(&mut self.values_at, &self.field, &limits);
        self.values_at.at_rest(usize::MAX)
    }

    fn limits(&self, frozen_from: usize, work: u64, work_max: u64) -> Limits {
        Limits {
            tolerance: self.tolerance(),
            frozen_from,
            visits_max: work_max.saturating_sub(work) / LANES as u64,
        }
    }

    /// Decides by bounds around the hopper, if they tell.
    fn focused(&mut self, here: usize, work: &mut u64, work_max: u64) -> Option<Decision> {
        let level = self.field.rings.level(here)?;
        let mut line = match self.line {
            Some(line) => (!line.broken).then_some(line)?,
            None => {
                let worthwhile =
                    self.world.nodes() >= NODES_MIN && level + DEPTH + STRIDE < self.field.rings.levels;
                (worthwhile && self.settle(work, work_max)).then_some(())?;
                self.bounds_at.take_over(&self.values_at);
                Line { level: usize::MAX, reserve: RESERVE, broken: false, updated: 0, reach: 0 }
            }
        };
        line.reach = line.reach.saturating_sub(1).max(8 * line.updated.saturating_sub(level));
        line.updated = 0;
        let nearest = level + line.reach.div_ceil(8) + DEPTH;
        (line.level >= nearest).then_some(())?;
        for _ in 0..RESERVES_MAX {
            self.line = Some(line);
            self.clear(&line, work, work_max).then_some(())?;
            let short = self.reserve_short(&line);
            if short > self.tolerance() {
                line.reserve = (2.0 * line.reserve).max(4.0 * short);
            } else if line.level > nearest + STRIDE {
                line.level = nearest + GAP;
            } else {
                let bounds =
                    self.bounds(here, self.bounds_at.worths.each_ref().map(Vec::as_slice), self.error());
                let hop = bounds.hop()?;
                return Some(Decision {
                    action: Some(hop),
                    margin: bounds.margin(hop),
                    bound: bounds.width(),
                    status: Status::Solved,
                    work: *work,
                    how: How::Focused,
                });
            }
            self.lay_reserve(&line);
        }
        None
    }

    /// Raises what is frozen, and lowers it below.
    fn lay_reserve(&mut self, line: &Line) {
        for level in [line.level, line.level + 1] {
            self.bounds_at.raise_level(&self.field, level, [line.reserve, -line.reserve]);
        }
        self.bounds_at.pass_over(&self.field.rings, line.level);
        self.bounds_at.touch_level(&self.field.rings, line.level - 1);
    }

    /// Brings both bounds to rest on the clear nodes; whether the work sufficed.
    fn clear(&mut self, line: &Line, work: &mut u64, work_max: u64) -> bool {
        let limits = self.limits(line.level, *work, work_max);
        *work += 2 * LANES as u64 * relax(&mut self.bounds_at, &self.field, &limits);
        self.bounds_at.at_rest(line.level)
    }

    /// By how much the line's ring fails to be super- and sub-harmonic.
    fn reserve_short(&mut self, line: &Line) -> f64 {
        let ring = line.level..line.level.saturating_add(1);
        let short = self.bounds_at.worst(&self.field, ring, |[upper, lower]| upper.max(-lower));
        if short <= self.tolerance() {
            self.bounds_at.pass_over(&self.field.rings, line.level);
        }
        short
    }

    /// Bounds on the hops' worth, from fields that are super- and sub-harmonic to within `error` (1 − γ).
    fn bounds(&self, here: usize, [upper, lower]: [&[f64]; 2], error: f64) -> Bounds {
        let slack = error + rounding(self.field.magnitude);
        Bounds {
            lower: self.hop_values(here, lower).map(|value| value - slack),
            upper: self.hop_values(here, upper).map(|value| value + slack),
        }
    }

    /// Bellman's right-hand sides at a node, from the definition.
    fn hop_values(&self, here: usize, worths: &[f64]) -> [f64; 4] {
        let rules = self.world.rules();
        let worth = |node: usize| match self.world.kind(node) {
            Kind::Free => worths[self.field.rings.seat(node).expect("a free node has a seat").place],
            Kind::Goal => self.world.payoff(node),
            Kind::Lost => rules.loss,
        };
        crate::bellman::hop_values(&self.world, here, worth)
    }

    /// Decides by a solve from nothing.
    fn canonical(&mut self, here: usize, mut work: u64, work_max: u64) -> Decision {
        let nodes = self.world.nodes() as u64;
        let sweeps_max =
            if work_max == u64::MAX { u64::MAX } else { (work_max.saturating_sub(work) / nodes).max(1) };
        let effort = Effort { error_max: CANONICAL_ERROR, sweeps_max };
        let solution = self.solver.solve(&self.world, &effort);
        work += solution.sweeps * nodes;
        let values = action_values(&self.world, self.solver.values(), here);
        let hop = policy::first_best(values, TIE);
        let bound = solution.certificate.error_bound;
        let bounds = Bounds { lower: values.map(|q| q - bound), upper: values.map(|q| q + bound) };
        let status = if solution.status == SolveStatus::Solved { Status::Solved } else { Status::Cut };
        assert!(
            status == Status::Cut || bound <= CANONICAL_ERROR || !self.provable(),
            "the canonical procedure needs an error of at most {CANONICAL_ERROR:e}, got {bound:e}"
        );
        Decision { action: Some(hop), margin: bounds.margin(hop), bound, status, work, how: How::Canonical }
    }
}

fn lost(world: &World) -> usize {
    (0..world.nodes()).filter(|&node| world.kind(node) == Kind::Lost).count()
}
