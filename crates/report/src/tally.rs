//! The fold over executed decisions behind summary or progress.

use contract::{
    Branch, Brief, Cell, Collected, Decision, Digest, Grid, Leader, Name, Origin, Outcome, Patrol, Pose,
    Range, Record, State, Status, Term, Timing, Vetoed,
};
use serde::{Deserialize, Serialize};

use crate::{Fallbacks, Latency};

/// One executed decision, as far as a [`Record`] or the [`State`] after it tell the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Executed {
    /// The decision.
    pub decision: Decision,
    /// Who was in command.
    pub leader: Leader,
    /// Who chose the action.
    pub origin: Origin,
    /// What the guard vetoed before it.
    pub vetoed: Vetoed,
    /// What became of it.
    pub outcome: Outcome,
    /// Pose afterwards.
    pub pose: Pose,
    /// Treasures collected so far.
    pub collected: Collected,
    /// Steps afterwards, in the papers' count.
    pub steps: u64,
    /// Goals visited so far.
    pub visits: u64,
    /// Status afterwards.
    pub status: Status,
    /// Timing of the decision.
    pub timing: Timing,
    /// Digest afterwards.
    pub digest: Digest,
}

impl Executed {
    /// The decision that led to `state`; `None` at decision 0.
    #[must_use]
    pub fn before(state: &State) -> Option<Self> {
        Some(Self {
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

/// How long one planner commanded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tenure {
    /// Its algorithm.
    pub name: Name,
    /// Its term.
    pub term: Term,
    /// The first decision it commanded.
    pub from_decision: Decision,
    /// The last decision it commanded, itself included.
    pub to_decision: Decision,
}

/// What became of the hops.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Route {
    /// Landed where they were meant to.
    pub intended: u64,
    /// Did not get away.
    pub stayed: u64,
    /// Slipped to the left.
    pub left: u64,
    /// Slipped to the right.
    pub right: u64,
    /// Decisions to stand still.
    pub held: u64,
    /// Way over ground, metres.
    pub length_m: f64,
    /// Time in flight, seconds.
    pub flight_s: f64,
    /// Heights of the landings above the datum, metres; `None` before the first.
    pub height_m: Option<Range>,
}

impl Route {
    /// Hops commanded.
    #[must_use]
    pub fn hops(&self) -> u64 {
        self.intended + self.stray()
    }

    /// Hops that did not land where they were meant to.
    #[must_use]
    pub fn stray(&self) -> u64 {
        self.stayed + self.left + self.right
    }

    fn add(&mut self, executed: &Executed, grid: &Grid) {
        let outcome = &executed.outcome;
        *match outcome.branch {
            Branch::Intended => &mut self.intended,
            Branch::Stayed => &mut self.stayed,
            Branch::Left => &mut self.left,
            Branch::Right => &mut self.right,
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

/// A mission so far, in a memory that does not grow with its decisions, only with its changes of leader.
#[derive(Clone, Debug, PartialEq)]
pub struct Tally {
    /// The lattice.
    pub grid: Grid,
    /// Where the hopper started.
    pub start: Cell,
    /// Where it shall go, or on a patrol first.
    pub goal: Cell,
    /// The goals of a patrol.
    pub patrol: Option<Patrol>,
    /// The last decision folded in; `None` before the first.
    pub last: Option<Executed>,
    /// Who commanded what.
    pub planners: Vec<Tenure>,
    /// What became of the hops.
    pub route: Route,
    /// Actions that the guard vetoed.
    pub vetoes: u64,
    /// What its fallback did.
    pub fallbacks: Fallbacks,
    /// Where the time went.
    pub latency: Latency,
    /// Landing that opened the first decision, to the commit of the last, seconds.
    pub duration_s: f64,
    began: contract::MonotonicNs,
}

impl Tally {
    /// The mission of `brief` before its first decision.
    #[must_use]
    pub fn new(brief: &Brief) -> Self {
        Self {
            grid: brief.grid,
            start: brief.start,
            goal: brief.goal,
            patrol: brief.patrol,
            last: None,
            planners: Vec::new(),
            route: Route::default(),
            vetoes: 0,
            fallbacks: Fallbacks::default(),
            latency: Latency::new(brief.limits.decision_budget_ns),
            duration_s: 0.0,
            began: contract::MonotonicNs(0),
        }
    }

    /// The decision that is due: the number folded in so far.
    #[must_use]
    pub fn due(&self) -> Decision {
        self.last.map_or(Decision(0), |last| last.decision.next())
    }

    /// Steps so far, in the papers' count.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.last.map_or(0, |last| last.steps)
    }

    /// Treasures collected so far.
    #[must_use]
    pub fn treasures(&self) -> u32 {
        self.last.map_or(0, |last| last.collected.count())
    }

    /// How the mission stands.
    #[must_use]
    pub fn status(&self) -> Status {
        self.last.map_or(Status::Underway, |last| last.status)
    }

    /// Where the hopper is; outside the grid once it has left the map.
    #[must_use]
    pub fn cell(&self) -> Cell {
        self.last.map_or(self.start, |last| last.pose.cell)
    }

    /// Goals visited so far.
    #[must_use]
    pub fn visits(&self) -> u64 {
        self.last.map_or(0, |last| last.visits)
    }

    /// The goal in force.
    #[must_use]
    pub fn goal(&self) -> Cell {
        self.patrol.map_or(self.goal, |patrol| patrol.goal(self.visits()))
    }

    /// From the hopper to the goal in force, in metres as the crow flies.
    #[must_use]
    pub fn distance_to_goal_m(&self) -> f64 {
        self.cell().distance_cells(self.goal()) * self.grid.cell_size_m
    }

    /// From start to goal, in metres as the crow flies.
    #[must_use]
    pub fn start_to_goal_m(&self) -> f64 {
        self.start.distance_cells(self.goal) * self.grid.cell_size_m
    }

    /// Folds in the decision that is due.
    ///
    /// # Panics
    /// If it is another decision than [`Tally::due`]: a gap would falsify everything after it.
    pub fn fold(&mut self, executed: &Executed) {
        assert_eq!(executed.decision, self.due(), "decisions are folded in order");
        if self.last.is_none() {
            self.began = executed.timing.landed;
        }
        self.latency.record(&executed.timing, executed.steps.saturating_sub(self.steps()));
        self.route.add(executed, &self.grid);
        self.duration_s = executed.timing.committed.since_ns(self.began) as f64 / 1e9;
        let decision = executed.decision;
        self.vetoes += executed.vetoed.count();
        self.fallbacks.count(executed.origin);
        match self.planners.last_mut() {
            // A fallback leaves the command where it is.
            _ if executed.origin.is_fallback() => {}
            Some(tenure) if tenure.term == executed.leader.term => tenure.to_decision = decision,
            _ => self.planners.push(Tenure {
                name: executed.leader.planner,
                term: executed.leader.term,
                from_decision: decision,
                to_decision: decision,
            }),
        }
        self.last = Some(*executed);
    }
}
