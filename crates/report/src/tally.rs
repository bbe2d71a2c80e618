//! Folds executed decisions for summaries and progress reports.

use std::fmt;

use contract::{
    Account, Branch, Brief, Cell, Collected, Decision, Digest, Goal, Grid, Leader, Name, Origin, Outcome,
    Pose, Range, Record, RobotId, State, Status, Term, Timing, Vetoed,
};
use serde::{Deserialize, Serialize};

use crate::flown_time::FlownTime;
use crate::{Fallbacks, Latency, with_only_goal};

/// One executed decision: the fields that both its [`Record`] and the [`State`] after it contain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Executed {
    /// Robot that took it.
    pub robot: RobotId,
    /// Number of the decision, from 0.
    pub decision: Decision,
    /// The planner in command of the records counted.
    pub leader: Leader,
    /// Who chose the action: a planner or the guard's fallback.
    pub origin: Origin,
    /// Actions that the guard vetoed before it.
    pub vetoed: Vetoed,
    /// Where the hop led, and by which branch.
    pub outcome: Outcome,
    /// Pose after the decision.
    pub pose: Pose,
    /// Treasures collected up to and including it.
    pub collected: Collected,
    /// Steps after the decision, in the papers' count.
    pub steps: u64,
    /// Goals visited up to and including it.
    pub visits: u64,
    /// Status after the decision.
    pub status: Status,
    /// When each stage ended.
    pub timing: Timing,
    /// Digest of the mission after the decision.
    pub digest: Digest,
}

impl Executed {
    /// The decision that led to `state`; `None` at decision 0.
    #[must_use]
    pub fn before(state: &State) -> Option<Self> {
        Some(Self {
            robot: state.robot,
            decision: Decision(state.decision.0.checked_sub(1)?),
            leader: state.leader,
            origin: state.last_origin,
            vetoed: state.last_vetoed,
            outcome: state.last?,
            pose: state.pose,
            collected: state.collected,
            steps: state.steps,
            visits: state.visits,
            status: state.status,
            timing: state.last_timing,
            digest: state.digest,
        })
    }
}

impl From<&Record> for Executed {
    fn from(record: &Record) -> Self {
        Self {
            robot: record.robot,
            decision: record.decision,
            leader: record.leader,
            origin: record.origin,
            vetoed: record.vetoed,
            outcome: record.outcome,
            pose: record.pose,
            collected: record.collected,
            steps: record.steps,
            visits: record.visits,
            status: record.status,
            timing: record.timing,
            digest: record.digest,
        }
    }
}

/// The decisions commanded by one planner in one term; those of other robots between them are not counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Leadership {
    /// Name of the algorithm.
    pub name: Name,
    /// Term in which it commanded.
    pub term: Term,
    /// First decision it commanded.
    pub from_decision: Decision,
    /// Last decision it commanded.
    pub to_decision: Decision,
    /// The robot; terms are counted for each. Left out in JSON for robot 0.
    #[serde(default, skip_serializing_if = "is_first")]
    pub robot: RobotId,
}

fn is_first(robot: &RobotId) -> bool {
    *robot == RobotId(0)
}

impl fmt::Display for Leadership {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, term, from_decision, to_decision, robot } = self;
        if *robot != RobotId(0) {
            write!(f, "robot {robot}: ")?;
        }
        write!(f, "{name}, term {term}, decisions {from_decision} to {to_decision}")
    }
}

impl Leadership {
    /// Takes note that `leader` commanded `decision` of `robot`, which comes after those of `leaderships`: the last of that
    /// robot goes on, or another begins.
    pub fn note(leaderships: &mut Vec<Self>, leader: &Leader, robot: RobotId, decision: Decision) {
        match leaderships.iter_mut().rev().find(|last| last.robot == robot) {
            Some(last) if (last.name, last.term) == (leader.planner, leader.term) => {
                last.to_decision = decision;
            }
            _ => leaderships.push(Self {
                name: leader.planner,
                term: leader.term,
                from_decision: decision,
                to_decision: decision,
                robot,
            }),
        }
    }
}

/// Hops by outcome, with length and heights of the route.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Route {
    /// Hops that landed as intended.
    pub intended: u64,
    /// Hops that stayed in their cell.
    pub stayed: u64,
    /// Hops that slipped to the left.
    pub left: u64,
    /// Hops that slipped to the right.
    pub right: u64,
    /// Hops that ended on another cell, or did not come to rest; none under the law of the papers.
    #[serde(default, skip_serializing_if = "is_none")]
    pub elsewhere: u64,
    /// Decisions in which the robot stayed, whoever chose that.
    pub held: u64,
    /// Length over ground, metres.
    pub length_m: f64,
    /// Time in flight, seconds.
    pub flight_s: f64,
    /// Range of the heights of the landings above the datum, metres; `None` before the first.
    pub height_m: Option<Range>,
}

impl Route {
    /// Number of hops commanded.
    #[must_use]
    pub fn hops(&self) -> u64 {
        self.intended + self.stray()
    }

    /// Number of hops that did not land as intended.
    #[must_use]
    pub fn stray(&self) -> u64 {
        self.stayed + self.left + self.right + self.elsewhere
    }

    fn add(&mut self, executed: &Executed, grid: &Grid) {
        let outcome = &executed.outcome;
        *match outcome.branch {
            Branch::Intended | Branch::Halted => &mut self.intended,
            Branch::Stayed | Branch::Stranded => &mut self.stayed,
            Branch::Left => &mut self.left,
            Branch::Right => &mut self.right,
            Branch::Elsewhere | Branch::RolledAway => &mut self.elsewhere,
            Branch::Held => &mut self.held,
        } += 1;
        self.length_m += outcome.from.distance_cells(outcome.to) * grid.cell_size_m;
        self.flight_s += outcome.flight.flight_time_s * f64::from(outcome.flight.flights);
        if grid.contains(executed.pose.cell) {
            let height_m = executed.pose.height_m;
            let range = self.height_m.get_or_insert(Range { min: height_m, max: height_m });
            *range = Range { min: range.min.min(height_m), max: range.max.max(height_m) };
        }
    }
}

fn is_none(count: &u64) -> bool {
    *count == 0
}

/// A mission so far. Memory grows with changes of leader only, not with decisions.
#[derive(Clone, Debug, PartialEq)]
pub struct Tally {
    /// Lattice of the cells.
    pub grid: Grid,
    /// Cell that robot 0 started from.
    pub start: Cell,
    /// Goal of the only robot that has one; `None` where robots have no goal in common.
    pub goal: Option<Goal>,
    /// What states tell: with [`Account::Hopper`] the route is the hopper's alone, whoever else acts.
    pub account: Account,
    /// Last decision added; `None` before the first.
    pub last: Option<Executed>,
    /// Which planner commanded which decisions.
    pub planners: Vec<Leadership>,
    /// Hops by outcome, with length and heights of the route.
    pub route: Route,
    /// Number of actions that the guard vetoed.
    pub vetoes: u64,
    /// Actions of the guard's fallback.
    pub fallbacks: Fallbacks,
    /// Latency of the decisions.
    pub latency: Latency,
    /// Time from the landing before the first decision to the commit of the last, seconds; without what lies between two boots.
    pub duration_s: f64,
    flown: FlownTime,
}

impl Tally {
    /// The mission of `brief` without any decision yet.
    #[must_use]
    pub fn new(brief: &Brief) -> Self {
        Self {
            grid: brief.grid,
            start: brief.robots[0].start.cell,
            goal: with_only_goal(brief).map(|(_, robot)| robot.goal),
            account: brief.account,
            last: None,
            planners: Vec::new(),
            route: Route::default(),
            vetoes: 0,
            fallbacks: Fallbacks::default(),
            latency: Latency::new(brief.limits.decision_budget_ns),
            duration_s: 0.0,
            flown: FlownTime::default(),
        }
    }

    /// The decision that is due: the number of decisions added so far.
    #[must_use]
    pub fn due(&self) -> Decision {
        self.last.map_or(Decision(0), |last| last.decision.next())
    }

    /// Steps so far, in the papers' count.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.last.map_or(0, |last| last.steps)
    }

    /// Number of treasures collected so far.
    #[must_use]
    pub fn treasures(&self) -> u32 {
        self.last.map_or(0, |last| last.collected.count())
    }

    /// Status after the last decision.
    #[must_use]
    pub fn status(&self) -> Status {
        self.last.map_or(Status::Underway, |last| last.status)
    }

    /// Cell of the hopper; outside the grid once it has left the map.
    #[must_use]
    pub fn cell(&self) -> Cell {
        self.last.map_or(self.start, |last| last.pose.cell)
    }

    /// Number of goals visited so far.
    #[must_use]
    pub fn visits(&self) -> u64 {
        self.last.map_or(0, |last| last.visits)
    }

    /// Straight-line distance from the last cell to the goal in force, metres; `None` where robots have no goal in common.
    #[must_use]
    pub fn distance_to_goal_m(&self) -> Option<f64> {
        self.distance_m(self.cell(), self.visits())
    }

    /// Straight-line distance from start to the first goal, metres; `None` where robots have no goal in common.
    #[must_use]
    pub fn start_to_goal_m(&self) -> Option<f64> {
        self.distance_m(self.start, 0)
    }

    /// Straight-line distance from `cell` to the goal in force after so many visits, metres; `None` where robots have no goal in
    /// common.
    #[must_use]
    pub fn distance_m(&self, cell: Cell, visits: u64) -> Option<f64> {
        let goal = self.goal?.cell(&self.grid, visits)?;
        Some(cell.distance_cells(goal) * self.grid.cell_size_m)
    }

    /// Adds the decision that is due.
    ///
    /// # Panics
    /// If it is another decision than [`Tally::due`]: a gap would falsify all that follows.
    pub fn fold(&mut self, executed: &Executed) {
        assert_eq!(executed.decision, self.due(), "decisions are folded in order");
        self.latency.record(&executed.timing, executed.steps.saturating_sub(self.steps()));
        if self.account != Account::Hopper || executed.robot == RobotId(0) {
            self.route.add(executed, &self.grid);
        }
        self.flown.add(&executed.timing);
        self.duration_s = self.flown.ns() as f64 / 1e9;
        self.vetoes += executed.vetoed.count();
        self.fallbacks.count(executed.origin);
        // A fallback does not change the leader.
        if !executed.origin.is_fallback() {
            Leadership::note(&mut self.planners, &executed.leader, executed.robot, executed.decision);
        }
        self.last = Some(*executed);
    }
}
