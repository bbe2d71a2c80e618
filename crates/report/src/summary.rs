//! The end of a run in one object: home of the JSON that programs may rely on.

use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;

use contract::{Brief, Cell, Digest, Profile, Record, RefusalCounts, Role, State, Status};
use serde::{Deserialize, Serialize};

use crate::ending::{Ending, commanders, counted};
use crate::{Executed, Fallbacks, LatencyReport, Route, Tally, Tenure, guarded};

/// Changes of command that the text shows, the last ones; the JSON holds all.
const TENURES_SHOWN: usize = 6;

/// Refusals that belong to the protocol: commands repeated until answered, and planners that learn that
/// they have been relieved; vetoes have a line of their own. The text leaves them out; the JSON has them.
const EVERYDAY_REFUSALS: [&str; 6] =
    ["busy", "repeated_decision", "stale_term", "not_leader", "yielding", "vetoed"];

/// One process of the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Process {
    /// Part it played.
    pub role: Role,
    /// Its operating-system process, the last one if it was restarted; 0 in lockstep.
    pub pid: u32,
    /// How often it was restarted.
    pub restarts: u64,
}

/// What a run came to.
///
/// The names down to `artifacts` are promised to programs; those after it may grow. Displayed, it is
/// the summary for a terminal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Name of the scenario.
    pub scenario: String,
    /// Seed of the run.
    pub seed: u64,
    /// Reading of the model.
    pub profile: Profile,
    /// How it ended; a run that ended before the mission did is `stopped`.
    pub outcome: Status,
    /// Steps, in the papers' count.
    pub steps: u64,
    /// Hops commanded.
    pub hops: u64,
    /// Chained digest of everything executed.
    pub digest: Digest,
    /// Who commanded what.
    pub planners: Vec<Tenure>,
    /// Where the time of a decision went.
    pub latency: LatencyReport,
    /// The processes; empty in lockstep or unless the caller knows them.
    pub processes: Vec<Process>,
    /// What was written where: name to path.
    pub artifacts: BTreeMap<String, PathBuf>,

    /// Decisions executed: hops and holds.
    pub decisions: u64,
    /// Steps after which the mission would have been a deadlock.
    pub steps_max: u64,
    /// Treasures collected.
    pub treasures: u32,
    /// Goals visited: 1 at the goal, any number on a patrol.
    pub visits: u64,
    /// Whether the mission is a patrol.
    pub is_patrol: bool,
    /// Share of the map seen, 0 to 1, if known.
    pub coverage: Option<f64>,
    /// From the hopper to the goal, metres as the crow flies.
    pub distance_to_goal_m: f64,
    /// From start to goal, metres as the crow flies.
    pub start_to_goal_m: f64,
    /// Where the hopper is.
    pub cell: Cell,
    /// Hops that did not land where they were meant to.
    pub stray_hops: u64,
    /// What became of the hops.
    pub route: Route,
    /// Actions that the guard vetoed, each once a decision.
    pub vetoes: u64,
    /// What its fallback did.
    pub fallbacks: Fallbacks,
    /// Commands refused, by reason.
    pub refusals: RefusalCounts,
    /// First landing to last commit, seconds.
    pub duration_s: f64,
}

/// Folds records to a [`Summary`] in constant memory.
#[derive(Clone, Debug)]
pub struct SummaryBuilder {
    brief: Brief,
    seed: u64,
    tally: Tally,
}

impl SummaryBuilder {
    /// A run of `brief` before its first decision.
    #[must_use]
    pub fn new(brief: &Brief, seed: u64) -> Self {
        Self { brief: *brief, seed, tally: Tally::new(brief) }
    }

    /// Folds in the next record.
    ///
    /// # Panics
    /// If it does not follow the last one: a journal is checked when it is opened.
    pub fn record(&mut self, record: &Record) {
        self.tally.fold(&Executed::from(record));
    }

    /// The summary of a run that ended in `state`, with `refusals` of commands on the way. What the
    /// fold cannot know, `coverage`, `processes`, `artifacts`, is the caller's to fill in.
    #[must_use]
    pub fn build(&self, state: &State, refusals: &RefusalCounts) -> Summary {
        let (brief, tally) = (&self.brief, &self.tally);
        let over = [tally.status(), state.status].into_iter().find(|status| status.is_over());
        Summary {
            scenario: brief.scenario.to_string(),
            seed: self.seed,
            profile: brief.profile,
            outcome: over.unwrap_or(Status::Stopped),
            steps: tally.steps(),
            hops: tally.route.hops(),
            digest: tally.last.map_or(state.digest, |last| last.digest),
            planners: tally.planners.clone(),
            latency: tally.latency.report(),
            processes: Vec::new(),
            artifacts: BTreeMap::new(),
            decisions: tally.due().0,
            steps_max: brief.limits.steps_max,
            treasures: tally.treasures(),
            visits: tally.visits(),
            is_patrol: brief.patrol.is_some(),
            coverage: None,
            distance_to_goal_m: tally.distance_to_goal_m(),
            start_to_goal_m: tally.start_to_goal_m(),
            cell: tally.cell(),
            stray_hops: tally.route.stray(),
            route: tally.route,
            vetoes: tally.vetoes,
            fallbacks: tally.fallbacks,
            refusals: refusals.clone(),
            duration_s: tally.duration_s,
        }
    }
}

impl Summary {
    /// How it ended, in a sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let &Self { outcome, hops, steps, steps_max, cell, distance_to_goal_m, .. } = self;
        let patrolled = self.is_patrol.then_some(self.visits);
        Ending { outcome, hops, steps, steps_max, cell, distance_to_goal_m, patrolled }.to_string()
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut fact = |name: &str, text: String| writeln!(f, "  {name:<10}  {text}");
        let route = &self.route;
        fact("outcome", self.sentence())?;
        let planners = commanders(self.planners.iter().map(|tenure| tenure.name));
        let Self { scenario, profile, seed, .. } = self;
        fact("run", format!("scenario {scenario}, planner {planners}, profile {profile}, seed {seed}"))?;
        let mut hops = format!("{} as intended", route.intended);
        let strays = [("stayed", route.stayed), ("to the left", route.left), ("to the right", route.right)];
        for (what, count) in strays.into_iter().chain([("held", route.held)]).filter(|(_, count)| *count > 0)
        {
            hops += &format!(", {count} {what}");
        }
        fact("hops", hops)?;
        let mut way =
            format!("{:.1} m over ground, {:.1} m from start to goal", route.length_m, self.start_to_goal_m);
        if let Some(heights) = route.height_m {
            way += &format!(", heights {:.2} to {:.2} m", heights.min, heights.max);
        }
        fact("route", way)?;
        if self.treasures > 0 {
            fact("treasures", format!("{} collected", self.treasures))?;
        }
        if self.vetoes > 0 || self.fallbacks.total() > 0 {
            fact("guard", guarded(self.vetoes, self.fallbacks))?;
        }
        if let Some(share) = self.coverage {
            fact("map", format!("{:.0} % seen", 100.0 * share))?;
        }
        fact(
            "time",
            format!(
                "{:.2} s from first landing to last commit, {:.1} s of flight",
                self.duration_s, route.flight_s
            ),
        )?;
        let hidden = self.planners.len().saturating_sub(TENURES_SHOWN);
        if hidden > 0 {
            fact("command", format!("{} before these", counted(hidden as u64, "change")))?;
        }
        for tenure in &self.planners[hidden..] {
            let Tenure { name, term, from_decision, to_decision } = tenure;
            fact("command", format!("{name}, term {term}, decisions {from_decision} to {to_decision}"))?;
        }
        if !self.processes.is_empty() {
            let processes = self.processes.iter().map(|Process { role, pid, restarts }| match restarts {
                0 => format!("{role} {pid}"),
                _ => format!("{role} {pid} ({})", counted(*restarts, "restart")),
            });
            fact("processes", processes.collect::<Vec<_>>().join(", "))?;
        }
        let odd = self.refusals.0.iter().filter(|(reason, _)| !EVERYDAY_REFUSALS.contains(&reason.as_str()));
        let odd: Vec<String> = odd.map(|(reason, count)| format!("{count} {reason}")).collect();
        if !odd.is_empty() {
            fact("refused", odd.join(", "))?;
        }
        fact("digest", self.digest.to_string())?;
        write!(f, "\n{}", self.latency)?;
        if !self.artifacts.is_empty() {
            writeln!(f)?;
        }
        self.artifacts.iter().try_for_each(|(name, path)| writeln!(f, "  {name:<10}  {}", path.display()))
    }
}
