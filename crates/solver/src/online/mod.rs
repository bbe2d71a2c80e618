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
//! What it begins with are the values of the whole world, by the general solver or, on a map of which hardly
//! anything has been seen, by the relaxation itself: see `unseen`.
//!
//! Which of the three it was shows in the [`Decision`], and in its work, never in its hop: see [`choice`].
//!
//! # Warm
//! See `relaxation`: when nothing is marked any more, every residual |V − TV| is at most a tolerance τ, so
//! |V − V*| ≤ τ / (1 − γ), as after a full sweep. Only what a change reaches is visited. That is the cone
//! of nodes whose way leads through the change, on the far side of it as seen from the goal, and it may be
//! most of the map. Should rest be too far off, the canonical procedure decides, and the session begins anew.
//!
//! # Focused
//! What lies behind hardly matters to the hopper: it comes back into play only through slips, each of
//! which has a small probability. What is needed is proof. Let U be *super-harmonic* (TU ≤ U) and L
//! *sub-harmonic* (TL ≥ L). T is monotone and T^n U → V*, so L ≤ V* ≤ U; if the inequalities hold only to
//! within τ, then L − τ/(1−γ) ≤ V* ≤ U + τ/(1−γ), since T(U + c) = TU + γc. So two fields are kept, and all
//! that is to be shown is one inequality a node.
//!
//! A *line* is drawn behind the hopper: a level ℓ of rings. Nodes on levels from ℓ on are *frozen*; nearer ones are
//! *clear*. Drawing it raises U by a reserve S on **all** frozen nodes, and lowers L by as much:
//!
//! - at a frozen node whose neighbours are frozen, T(U + S) = TU + γS ≤ U + S;
//! - at one of level ℓ, with neighbours on the clear level ℓ − 1, the more so, for those were not raised;
//! - clear nodes are relaxed under what level ℓ has become, until they are at rest again.
//!
//! So U stays super-harmonic everywhere, and only level ℓ need be touched: beyond it the reserve stands in
//! the proof, and level by level in a table; it is written where it is read. What the first line leaves
//! over, (1 − γ) S a node, is room: for frozen nodes that were at rest at no more than a coarse tolerance
//! when the line was drawn, and for news among them. A frozen node whose ground or neighbours have changed
//! is measured, and nothing is solved there; where TU ≤ U fails, another reserve is laid on by the same
//! argument, or, if that would have to be large, the line goes out behind the news. (A large reserve is
//! worse than none: to hop back into it would seem worth more than to go on.) A line that goes out takes
//! nothing from the proof: what thaws keeps its reserve until it is relaxed. When the hopper has gone on,
//! the line is drawn anew nearer to it: raising all that is frozen then, the nodes between the lines
//! included, again changes nothing that was shown.
//!
//! At the hopper, U − L is what the reserve comes to through some slips in a row, and the hop values under U
//! and L give [`choice::Bounds`]. They need be no closer than tells the hops apart: the clear nodes come to
//! rest at a coarse tolerance first, and at finer ones, [`STAGES`], only while the bounds leave a doubt. If
//! the finest leaves one, the line goes out, and then the session falls back to the warm solve, and that to
//! the canonical procedure.
//!
//! # Rounding
//! Worths and constants stay within a magnitude M, enforced. To first order in u = 2⁻⁵³ the kernel's
//! residual carries at most 24 u M: six from the products of probabilities and discount, one from d q − 1,
//! three from the base, three from where a hop lands, three from the slips beside, weighted with at most one
//! half, and two, three and three from the sums of base and what stays, of these and the slips, and of all.
//! Where a soil's landings sum to 1 only to within rounding, the kernel's slips differ from those that were given:
//! eight more at the very most. [`crate::certificate::rounding`] allows 32 u M, and is added to τ in every bound.

mod blocks;
pub mod choice;
mod decision;
mod enclosure;
mod field;
mod kernel;
mod patterns;
mod relaxation;
mod rings;
mod simd;
mod unseen;
mod witness;

use crate::certificate::rounding;
use crate::{
    Certificate, Effort, Error, Kind, Leaving, Site, Solver, Status as SolveStatus, World, action_values,
    policy,
};
use choice::{Bounds, CANONICAL_ERROR, TIE};
pub use decision::{Decision, How, Status};
use enclosure::Enclosure;
use field::Field;
use relaxation::{Limits, Relaxation};
use rings::LANES;
use simd::relax;
use witness::Witness;

/// Bound on the error of a session's values, in units of payoff: a little below the 1e-6 that is promised.
pub const VALUE_ERROR: f64 = 0.99e-6;

/// Levels between the hopper and the line, at least.
const DEPTH: usize = 4;

/// Levels between them when the line is drawn.
const DRAWN: usize = 7;

/// The line is drawn anew when the hopper has gone on by so many levels.
const STRIDE: usize = 9;

/// Levels by which the line goes out where the bounds do not tell, one after the other.
const RETREATS: [usize; 2] = [8, 24];

/// Tolerances at which the bounds are asked, one after the other, in units of the one that values come to
/// rest at. Most decisions are clear at the first.
const STAGES: [f64; 5] = [1e4, 1e3, 1e2, 1e1, 1.0];

/// Visits of a block between two pulses: some tens of milliseconds.
const SLICE: u64 = 1 << 20;

/// What of a session belongs to its world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Layout {
    /// Nothing: the field is another world's.
    Stale,
    /// The field.
    Bare,
    /// Field and values.
    Full,
}

/// A session.
#[derive(Clone, Debug)]
pub struct Online {
    world: World,
    field: Field,
    /// The values' worths.
    values_at: Relaxation<1>,
    /// Bounds on them, if there are any.
    enclosure: Enclosure,
    enclosed: bool,
    layout: Layout,
    /// Nodes where the hopper is lost.
    lost: usize,
    witness: Witness,
    solver: Solver,
    values: Vec<f64>,
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
            enclosure: Enclosure::default(),
            enclosed: false,
            layout: Layout::Bare,
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
        self.world.set(node, site);
        self.witness.changed(&self.world, node, old.kind);
        self.lost = self.lost + usize::from(site.kind == Kind::Lost) - usize::from(old.kind == Kind::Lost);
        // What a goal pays is all there is to it; of where the hopper is lost, that it is.
        let is_lost = old.kind == Kind::Lost && site.kind == Kind::Lost;
        let is_goal = old.kind == Kind::Goal && site.kind == Kind::Goal;
        if is_lost || is_goal && old.payoff == site.payoff {
            return;
        }
        if self.layout != Layout::Full {
            self.layout = Layout::Stale;
            return;
        }
        let centred = self.world.kind(node) == Kind::Goal || old.kind == Kind::Goal;
        let Some(seat) = self.field.set(node, &site).filter(|_| !centred) else {
            self.layout = Layout::Stale;
            return;
        };
        let loss = self.world.rules().loss;
        self.field.magnitude = self.field.magnitude.max(4.0 * loss.abs());
        let change = |worths: &mut [f64]| {
            worths[seat.place] = match (old.kind, site.kind) {
                (_, Kind::Lost) => loss,
                // Ground where there was none: whatever, to begin with.
                (Kind::Lost, _) => worths[seat.place].max(-self.field.magnitude),
                _ => (worths[seat.place] + (site.payoff - old.payoff))
                    .clamp(-self.field.magnitude, self.field.magnitude),
            };
        };
        self.values_at.worths.iter_mut().for_each(|worths| change(worths));
        self.values_at.touch(&self.field, seat);
        if self.enclosed {
            self.enclosure.bounds.worths.iter_mut().for_each(|worths| change(worths));
            self.enclosure.bounds.touch(&self.field, seat);
        }
    }

    /// Changes what being lost is worth.
    ///
    /// # Errors
    /// As [`World::set_loss`].
    pub fn set_loss(&mut self, loss: f64) -> Result<(), Error> {
        if loss != self.world.rules().loss {
            self.world.set_loss(loss)?;
            // What the canonical procedure can do hangs on it, even where nobody can be lost.
            self.field.magnitude = self.field.magnitude.max(4.0 * loss.abs());
            let matters = self.lost > 0 || self.world.rules().leaving == Leaving::Loses;
            if self.layout == Layout::Full && matters {
                // Near every node of the rim, and soon everywhere: all is looked at, from where it is.
                self.take_out();
                self.values_at.begin(&self.field, &self.world, &self.values);
                self.enclosed = false;
            }
        }
        Ok(())
    }

    /// Becomes another world. What was known is forgotten.
    pub fn replace(&mut self, world: World) {
        self.lost = lost(&world);
        self.world = world;
        self.layout = Layout::Stale;
        self.witness.forget();
    }

    /// Decides at `here` with at most about `work_max` backups.
    ///
    /// Without a bound on the work the hop depends on the world and on `here` alone. With one, a session
    /// that knows more gets further.
    pub fn act(&mut self, here: usize, work_max: Option<u64>) -> Decision {
        self.act_with(here, work_max, &|| ())
    }

    /// [`Online::act`], calling `pulse` whenever some more of the work is done: for whoever must not fall silent
    /// for as long as a large world takes to be solved from nothing.
    pub fn act_with(&mut self, here: usize, work_max: Option<u64>, pulse: &dyn Fn()) -> Decision {
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
        if !self.lay_out(&mut work, work_max, pulse) {
            return self.canonical(here, work, work_max, pulse);
        }
        if let Some(decision) = self.focused(here, &mut work, work_max, pulse) {
            return decision;
        }
        let rested = self.settle(&mut work, work_max, pulse);
        let bound = if rested { self.error() } else { self.cut_error() };
        let bounds = self.bounds(here, [&self.values_at.worths[0]; 2], bound);
        match bounds.hop() {
            Some(hop) if rested => {
                let margin = bounds.margin(hop);
                Decision { action: Some(hop), margin, bound, status: Status::Solved, work, how: How::Warm }
            }
            _ if rested && work < work_max || self.values_at.is_stuck(&self.field.rings) => {
                if !rested {
                    self.layout = Layout::Bare;
                }
                self.canonical(here, work, work_max, pulse)
            }
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
        if self.lay_out(&mut work, u64::MAX, &|| ()) {
            self.settle(&mut work, u64::MAX, &|| ());
        }
        work
    }

    /// All values, row-major, brought to the certificate first.
    pub fn values(&mut self) -> (&[f64], Certificate) {
        let rested = self.lay_out(&mut 0, u64::MAX, &|| ()) && self.settle(&mut 0, u64::MAX, &|| ());
        let certificate = if rested {
            let residual = self.tolerance() + rounding(self.field.magnitude);
            self.take_out();
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

    /// Takes the values out, row-major.
    fn take_out(&mut self) {
        let Self { world, field, values_at, values, .. } = self;
        values.clear();
        values.extend((0..world.nodes()).map(|node| match world.kind(node) {
            Kind::Free => {
                let seat = field.rings.seat(node).expect("a free node has a seat");
                values_at.worths[0][seat.place] - world.payoff(node)
            }
            Kind::Goal => 0.0,
            Kind::Lost => world.rules().loss,
        }));
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

    /// Residual to come to rest at: the same however large worths grow, as long as anything is provable, so
    /// that what came to rest before remains so.
    fn tolerance(&self) -> f64 {
        (VALUE_ERROR - 0.5 * CANONICAL_ERROR) * (1.0 - self.world.rules().discount)
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
    fn lay_out(&mut self, work: &mut u64, work_max: u64, pulse: &dyn Fn()) -> bool {
        if self.layout == Layout::Full {
            return self.provable();
        }
        if self.layout == Layout::Stale {
            self.field = Field::new(&self.world);
            self.layout = Layout::Bare;
        }
        if !self.provable() {
            return false;
        }
        if !self.rest_unseen(work, work_max, pulse) {
            self.solve_all(work, work_max, pulse);
        }
        self.enclosed = false;
        self.layout = Layout::Full;
        true
    }

    /// Lays all values out as the solver finds them.
    fn solve_all(&mut self, work: &mut u64, work_max: u64, pulse: &dyn Fn()) {
        let nodes = self.world.nodes() as u64;
        let sweeps_max = (work_max.saturating_sub(*work) / nodes).max(1);
        let effort = Effort { error_max: VALUE_ERROR, sweeps_max };
        let solution = self.solver.solve_with(&self.world, &effort, pulse);
        *work += solution.sweeps * nodes;
        let Self { field, values_at, world, solver, .. } = self;
        values_at.begin(field, world, solver.values());
    }

    /// Brings all values to rest; whether the work sufficed.
    fn settle(&mut self, work: &mut u64, work_max: u64, pulse: &dyn Fn()) -> bool {
        let limits = self.limits(1.0, *work, work_max);
        *work += LANES as u64 * relax_with(&mut self.values_at, &self.field, &limits, pulse);
        self.values_at.at_rest(&self.field.rings, usize::MAX)
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

    /// Decides by bounds around the hopper, if they tell.
    fn focused(&mut self, here: usize, work: &mut u64, work_max: u64, pulse: &dyn Fn()) -> Option<Decision> {
        let level = self.field.rings.level(here)?;
        if !self.enclosed {
            let worthwhile = level + DRAWN + STRIDE < self.field.rings.levels;
            (worthwhile && self.settle(work, work_max, pulse)).then_some(())?;
            self.enclosure.draw(&self.field, &self.values_at);
            self.enclosed = true;
        }
        if self.enclosure.line() < level + DEPTH {
            self.enclosure.draw_out(&self.field, level + DRAWN);
        } else if self.enclosure.line() > level + DRAWN + STRIDE {
            self.enclosure.draw_in(&self.field, level + DRAWN);
        }
        for stage in STAGES {
            if let Some(decision) = self.enclosed(here, stage, work, work_max, pulse) {
                return Some(decision);
            }
        }
        for retreat in RETREATS {
            self.enclosure.draw_out(&self.field, level + retreat + DRAWN);
            if let Some(decision) = self.enclosed(here, 1.0, work, work_max, pulse) {
                return Some(decision);
            }
        }
        self.enclosed = false;
        None
    }

    /// Decides by bounds at rest at a stage's tolerance, if they tell.
    fn enclosed(
        &mut self,
        here: usize,
        stage: f64,
        work: &mut u64,
        work_max: u64,
        pulse: &dyn Fn(),
    ) -> Option<Decision> {
        let limits = self.limits(stage, *work, work_max);
        let Self { enclosure, field, .. } = self;
        let mut visits = 0;
        let rested = enclosure.rest(field, &limits, &mut |bounds, limits| {
            let visits_max = limits.visits_max.saturating_sub(visits);
            visits += 2 * relax_with(bounds, field, &Limits { visits_max, ..*limits }, pulse);
        });
        *work += LANES as u64 * visits;
        rested.then_some(())?;
        let error = (limits.tolerance + rounding(self.field.magnitude)) / (1.0 - self.field.discount);
        let bounds = self.bounds(here, self.enclosure.bounds.worths.each_ref().map(Vec::as_slice), error);
        let hop = bounds.hop()?;
        Some(Decision {
            action: Some(hop),
            margin: bounds.margin(hop),
            bound: bounds.width(),
            status: Status::Solved,
            work: *work,
            how: How::Focused,
        })
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
    fn canonical(&mut self, here: usize, mut work: u64, work_max: u64, pulse: &dyn Fn()) -> Decision {
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
        let status = if solution.status == SolveStatus::Solved { Status::Solved } else { Status::Cut };
        assert!(
            status == Status::Cut || bound <= CANONICAL_ERROR || !self.provable(),
            "the canonical procedure needs an error of at most {CANONICAL_ERROR:e}, got {bound:e}"
        );
        Decision { action: Some(hop), margin: bounds.margin(hop), bound, status, work, how: How::Canonical }
    }
}

/// [`relax`] in slices, with a pulse after each, until rest, the visits' end, or stuck; the visits.
fn relax_with<const FIELDS: usize>(
    relaxation: &mut Relaxation<FIELDS>,
    field: &Field,
    limits: &Limits,
    pulse: &dyn Fn(),
) -> u64 {
    let mut visits = 0;
    while !relaxation.at_rest(&field.rings, limits.frozen_from)
        && visits < limits.visits_max
        && !relaxation.is_stuck(&field.rings)
    {
        let visits_max = (limits.visits_max - visits).min(SLICE);
        visits += relax(relaxation, field, &Limits { visits_max, ..*limits });
        pulse();
    }
    visits
}

fn lost(world: &World) -> usize {
    (0..world.nodes()).filter(|&node| world.kind(node) == Kind::Lost).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::specimen::{Draw, Place, Specimen};

    /// P-ENCLOSED.
    #[test]
    fn the_bounds_hold_at_every_node_frozen_or_clear_and_at_every_stage() {
        let mut solver = Solver::new();
        let mut drawn = 0;
        for (seed, radius, place) in
            [(3, 5, Place::Corner), (4, 2, Place::Corner), (5, 3, Place::Inside), (6, 4, Place::Side)]
        {
            let specimen = Specimen { place, ..Specimen::plain(92, seed) };
            let truth = specimen.world().expect("a size in range");
            let (width, height) = (truth.width(), truth.height());
            let mut online = Online::new(specimen.unseen().expect("a size in range"));
            let mut draw = Draw(seed);
            let mut here = specimen.start();
            for hop in 0..90 {
                let (x, y) = (here % width, here / width);
                for y in y.saturating_sub(radius)..(y + radius + 1).min(height) {
                    for x in x.saturating_sub(radius)..(x + radius + 1).min(width) {
                        online.update(y * width + x, truth.site(y * width + x));
                    }
                }
                let Some(action) = online.act(here, None).action else { break };
                if hop % 11 == 10 && online.enclosed {
                    drawn += usize::from(online.enclosure.line() < online.field.rings.levels);
                    solver.solve(&online.world, &Effort { error_max: 1e-8, ..Effort::default() });
                    for stage in STAGES {
                        online.enclosed(here, stage, &mut 0, u64::MAX, &|| ());
                        let error = stage * online.tolerance() / (1.0 - online.field.discount) + 2e-8;
                        for node in (0..width * height).filter(|&node| truth.kind(node) == Kind::Free) {
                            let worth = online.world.worth(solver.values(), node);
                            let [upper, lower] = online.enclosure.around(&online.field, node);
                            assert!(worth <= upper + error, "{worth} under {upper}, stage {stage}, {node}");
                            assert!(worth >= lower - error, "{worth} over {lower}, stage {stage}, {node}");
                        }
                    }
                }
                // Now and then astray, so that the line has to go out.
                let astray = [action, action.left(), action.right()][(draw.uniform() * 3.3) as usize % 3];
                here = truth.neighbour(here, if hop % 5 == 0 { astray } else { action }).unwrap_or(here);
            }
        }
        assert!(drawn > 6, "{drawn}");
    }
}
