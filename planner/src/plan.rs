//! What a planner is given, what it answers, and the trait that every algorithm implements.

use std::fmt;

use contract::{Action, Brief, Name, ObservedMap, PolicyCell, State};

/// Everything a decision may depend on.
#[derive(Clone, Copy, Debug)]
pub struct Situation<'a> {
    /// What was known before the mission; of a patrol, the leg that is flown: start and goal are the leg's.
    pub brief: &'a Brief,
    /// What has been seen, the present pose folded in. [`ObservedMap::changed_since`] tells what is new since
    /// the last plan.
    pub map: &'a ObservedMap,
    /// Where the mission stands, and what hopper-sim's guard has vetoed here ([`State::vetoed`]).
    pub state: &'a State,
}

/// How much work a plan may take, counted, so that a cut plan repeats.
#[derive(Clone, Copy, Debug, Default)]
pub struct Budget<'a> {
    /// Most units of the algorithm's own work (sweeps, expansions); `None` for no bound.
    pub work_max: Option<u64>,
    /// To be called as the work goes on.
    pub pulse: Pulse<'a>,
}

impl Budget<'_> {
    /// A bound on the work, and nobody to tell of it.
    #[must_use]
    pub fn of(work_max: Option<u64>) -> Self {
        Self { work_max, pulse: Pulse::default() }
    }
}

/// A sign of life out of a long plan: a planner calls [`Pulse::beat`] whenever it has done some more of its
/// work (a sweep, a few thousand expansions), at best every few milliseconds. Its process then beats, if a
/// beat is due; so a planner that works long is told from one that hangs, which calls no more.
#[derive(Clone, Copy, Default)]
pub struct Pulse<'a>(Option<&'a dyn Fn()>);

impl<'a> Pulse<'a> {
    /// Expansions, or cells, that are worth a beat.
    pub const STRIDE: u64 = 1 << 12;

    /// A pulse that calls `beat`.
    #[must_use]
    pub fn new(beat: &'a dyn Fn()) -> Self {
        Self(Some(beat))
    }

    /// Some more of the work is done.
    pub fn beat(&self) {
        if let Some(beat) = self.0 {
            beat();
        }
    }

    /// The `work`-th unit of small work is done: beats at each [`Pulse::STRIDE`]th.
    pub fn count(&self, work: u64) {
        if work.is_multiple_of(Self::STRIDE) {
            self.beat();
        }
    }
}

impl fmt::Debug for Pulse<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_some() { "Pulse" } else { "no pulse" })
    }
}

/// What kind of answer a plan is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlanStatus {
    /// The algorithm ran to its own end.
    Solved,
    /// The budget ran out; the action is the best so far.
    Cut,
    /// No chain of hops over ground not known to be impassable leads to the goal; the action is to hold.
    Infeasible,
}

/// The answer to one situation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// What to do.
    pub action: Action,
    /// What kind of answer it is.
    pub status: PlanStatus,
    /// Work done, in the algorithm's own units.
    pub work: u64,
    /// Bound |V − V*| proven for each value of the policy, in units of payoff; 0 where nothing was solved.
    pub error_bound: f64,
}

impl Plan {
    /// A plan that took no search.
    #[must_use]
    pub fn at_once(action: Action, status: PlanStatus) -> Self {
        Self { action, status, work: 0, error_bound: 0.0 }
    }
}

/// A planning algorithm.
///
/// # Law
/// The plan is a function of the situation and the budget alone, bit for bit: what a planner keeps
/// between calls may save time, never change an answer. A planner restarted with nothing decides as
/// the one that died would have. The work alone may differ, where a search is mended and the budget
/// sets no bound: then nothing but the count depends on it.
pub trait Planner: Send {
    /// The name it is asked for by, one of [`crate::ALGORITHMS`].
    fn name(&self) -> Name;

    /// Decides what to do.
    fn plan(&mut self, situation: &Situation<'_>, budget: &Budget) -> Plan;

    /// Policy behind the last plan, if the algorithm has one: cells in index order.
    fn policy(&self) -> Option<Vec<PolicyCell>> {
        None
    }
}
