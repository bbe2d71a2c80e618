//! The trait that every algorithm implements, with its input, the situation, and its answer, the plan.

use std::fmt;

use contract::{
    Account, Action, Brief, Leg, MotionTable, Name, ObservedMap, PolicyCell, Prior, Robot, RobotId, Route,
    Routes, State, Team,
};

/// Everything a decision may depend on.
#[derive(Clone, Copy, Debug)]
pub struct Situation<'a> {
    /// What was known before the mission.
    pub brief: &'a Brief,
    /// Where a hopper decides, the leg that it flies: its mission, to whoever plans for it.
    pub leg: Option<&'a Leg>,
    /// What has been seen, the present pose included. [`ObservedMap::changed_since`] gives the cells that changed since
    /// the last plan.
    pub map: &'a ObservedMap,
    /// The state of the mission, with what hopper-sim's guard has vetoed at this pose ([`State::vetoed`]). Its pose is that of the
    /// hopper that decides; where none does, it is as [`Brief::account`] says. What its digest does not tell is blank:
    /// [`State::of_its_past`].
    pub state: &'a State,
    /// All robots, the one that decides being [`Team::due`]; `None` where a hopper is alone. Who commands them is blank.
    pub team: Option<&'a Team>,
    /// The prior and the announced routes, where robots go from point to point.
    pub scouting: Option<Scouting<'a>>,
    /// Where hops end by soil and slope, if the brief has planners of hoppers believe a table in place of the four branches.
    pub table: Option<&'a MotionTable>,
}

impl<'a> Situation<'a> {
    /// What a hopper that goes alone decides by, where planners believe the four branches.
    #[must_use]
    pub fn alone(brief: &'a Brief, leg: &'a Leg, map: &'a ObservedMap, state: &'a State) -> Self {
        Self { brief, leg: Some(leg), map, state, team: None, scouting: None, table: None }
    }

    /// The leg of the hopper that decides.
    ///
    /// # Panics
    /// If another robot decides: a pilot asks no planner for a robot that it does not suit.
    #[must_use]
    pub fn leg(&self) -> &'a Leg {
        self.leg.expect("a planner of hoppers is given a hopper's leg")
    }
}

/// The leg of the hopper `robot` at `state`, which counts visits of goals only where they are those of the one hopper. Until there
/// is a map, it has none if its goal depends on what has been seen.
pub(crate) fn leg_at(brief: &Brief, map: Option<&ObservedMap>, state: &State, robot: RobotId) -> Option<Leg> {
    let visits = match brief.account {
        Account::Hopper => state.visits,
        Account::Actions | Account::ActionsWithoutWaits => 0,
    };
    match map {
        Some(map) => brief.leg_on(map.cells(), robot, visits),
        None => brief.leg_of(robot, visits),
    }
}

/// What a decision of a robot that goes from point to point may depend on beside brief, map and team.
#[derive(Clone, Copy, Debug)]
pub struct Scouting<'a> {
    /// The speeds as everyone knows them before the mission.
    pub prior: &'a Prior,
    /// The routes that robots follow: those that [`contract::Travel`] names.
    pub routes: &'a Routes,
}

/// How much work a plan may take. Work is counted, not timed, so that a plan cut short is reproducible.
#[derive(Clone, Copy, Debug, Default)]
pub struct Budget<'a> {
    /// Most units of the algorithm's own work (sweeps, expansions); `None` for no bound.
    pub work_max: Option<u64>,
    /// Called as the work goes on.
    pub pulse: Pulse<'a>,
}

impl Budget<'_> {
    /// A bound on the work, without a pulse.
    #[must_use]
    pub fn of(work_max: Option<u64>) -> Self {
        Self { work_max, pulse: Pulse::default() }
    }
}

/// A sign of life from a long plan. A planner calls [`Pulse::beat`] after each part of its work (a sweep, a few thousand
/// expansions), ideally every few milliseconds, and its process then sends a heartbeat if one is due. So a planner that
/// works long can be told from one that hangs, which stops calling.
#[derive(Clone, Copy, Default)]
pub struct Pulse<'a>(Option<&'a dyn Fn()>);

impl<'a> Pulse<'a> {
    /// Expansions, or cells, between two calls.
    pub const STRIDE: u64 = 1 << 12;

    /// A pulse that calls `beat`.
    #[must_use]
    pub fn new(beat: &'a dyn Fn()) -> Self {
        Self(Some(beat))
    }

    /// Reports that another part of the work is done.
    pub fn beat(&self) {
        if let Some(beat) = self.0 {
            beat();
        }
    }

    /// Reports that the `work`-th small unit of work is done: beats at every [`Pulse::STRIDE`]th.
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

/// Whether a plan is final.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlanStatus {
    /// The algorithm ran to its end.
    Solved,
    /// The budget ran out; the action is the best so far.
    Cut,
    /// No chain of hops over ground not known to be impassable leads to the goal; the action is to hold.
    Infeasible,
}

/// A planner's answer to one situation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// The action to command.
    pub action: Action,
    /// Whether the answer is final.
    pub status: PlanStatus,
    /// Work done, in the algorithm's own units (sweeps, backups, expansions).
    pub work: u64,
    /// Bound |V − V*| proven for each value of the policy, in units of payoff; 0 where nothing was solved.
    pub error_bound: f64,
}

impl Plan {
    /// A plan that needed no search.
    #[must_use]
    pub fn at_once(action: Action, status: PlanStatus) -> Self {
        Self { action, status, work: 0, error_bound: 0.0 }
    }
}

/// An algorithm that decides hop by hop.
///
/// # Law
/// The plan is a function of the situation and the budget alone, bit for bit. What a planner keeps between calls may
/// save time, but never changes an answer: a planner restarted with nothing decides as the one that died would have.
/// Only [`Plan::work`] may differ, where a search continues from the last one and the budget sets no bound.
pub trait Planner: Send {
    /// The name it is asked for by, one of [`crate::ALGORITHMS`], [`crate::COVER_ALGORITHMS`],
    /// [`crate::DRIVE_ALGORITHMS`], [`crate::FLY_ALGORITHMS`] or [`crate::AHEAD_ALGORITHMS`], or one of its own.
    fn name(&self) -> Name;

    /// Whether it can plan for that robot; by default for a hopper.
    fn suits(&self, robot: &Robot) -> bool {
        robot.body.hops()
    }

    /// Whether its plans may announce routes. A robot that goes from point to point is commanded by no other planner.
    fn announces(&self) -> bool {
        false
    }

    /// Decides what to do.
    fn plan(&mut self, situation: &Situation<'_>, budget: &Budget) -> Plan;

    /// The route of the last plan, if its action announces one.
    fn announced(&self) -> Option<&Route> {
        None
    }

    /// The policy behind the last plan, if the algorithm has one: cells in index order. It may take long to compute.
    fn policy(&mut self) -> Option<Vec<PolicyCell>> {
        None
    }
}

impl<P: Planner + ?Sized> Planner for Box<P> {
    fn name(&self) -> Name {
        (**self).name()
    }

    fn suits(&self, robot: &Robot) -> bool {
        (**self).suits(robot)
    }

    fn announces(&self) -> bool {
        (**self).announces()
    }

    fn plan(&mut self, situation: &Situation<'_>, budget: &Budget) -> Plan {
        (**self).plan(situation, budget)
    }

    fn announced(&self) -> Option<&Route> {
        (**self).announced()
    }

    fn policy(&mut self) -> Option<Vec<PolicyCell>> {
        (**self).policy()
    }
}
