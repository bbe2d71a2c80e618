//! The summary of a run, as JSON for programs and as text for people.

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

use contract::{
    Brief, Cell, Digest, Member, Name, Profile, Record, RefusalCounts, Robot, RobotId, Role, State, Status,
    Team,
};
use serde::{Deserialize, Serialize, Serializer};

use crate::phrases::{EndSentence, TeamEffort, counted, planners_in_order, planners_of_team};
use crate::{
    Ending, Executed, Fallbacks, LatencyReport, Leadership, RobotSummary, Route, Tally, guard_phrase,
    with_only_goal,
};

/// Number of leaderships the text shows, the last ones; the JSON has all of them.
const LEADERSHIPS_SHOWN: usize = 6;

/// Refusals that are part of normal operation: commands repeated until answered, and planners that learn they
/// no longer lead. Vetoes have a line of their own. The text omits these refusals; the JSON has them.
const EVERYDAY_REFUSALS: [&str; 7] =
    ["busy", "repeated_decision", "stale_term", "not_leader", "unknown_life", "yielding", "vetoed"];

/// One process of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Process {
    /// Role of the process.
    pub role: Role,
    /// Process id, the last one if it was restarted; 0 in lockstep.
    pub pid: u32,
    /// Times that a process was started again after a crash.
    pub restarts: u64,
}

/// The summary of a run.
///
/// Serialised, the field names down to `artifacts` are promised to programs; more may be added after them.
/// Displayed, it is text for a terminal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Name of the scenario.
    pub scenario: String,
    /// Seed of the run.
    pub seed: u64,
    /// Profile: which reading of the model was flown.
    pub profile: Profile,
    /// Final status, or `stopped`.
    pub outcome: Ending,
    /// Steps, in the papers' count.
    pub steps: u64,
    /// Number of hops commanded.
    pub hops: u64,
    /// Chained digest of everything executed.
    pub digest: Digest,
    /// Which planner commanded which decisions.
    pub planners: Vec<Leadership>,
    /// Latency of the decisions.
    pub latency: LatencyReport,
    /// The processes; empty in lockstep or if the caller does not know them.
    pub processes: Vec<Process>,
    /// Files that were written: name to path.
    #[serde(serialize_with = "paths_as_text")]
    pub artifacts: BTreeMap<String, PathBuf>,

    /// Number of decisions executed: hops and holds.
    pub decisions: u64,
    /// Steps, in the papers' count, after which the mission ends as a deadlock.
    pub steps_max: u64,
    /// Number of treasures collected.
    pub treasures: u32,
    /// Number of goals visited: at most 1 unless they are visited in turn.
    pub visits: u64,
    /// Whether a hopper visits goals in turn.
    pub is_patrol: bool,
    /// What several robots did together; `None` if a single hopper flew.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub team: Option<TeamEffort>,
    /// What became of each of several robots, in the order of their numbers; empty, and left out in JSON, where a single hopper
    /// flew.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub robots: Vec<RobotSummary>,
    /// Share of the map seen, 0 to 1; `None` if not known.
    pub coverage: Option<f64>,
    /// Straight-line distance from the last cell to the goal, metres; `None` where robots have no goal in common.
    pub distance_to_goal_m: Option<f64>,
    /// Straight-line distance from start to goal, metres; `None` where robots have no goal in common.
    pub start_to_goal_m: Option<f64>,
    /// Cell of the hopper.
    pub cell: Cell,
    /// Number of hops that did not land as intended.
    pub stray_hops: u64,
    /// Hops by outcome, length and heights of the route.
    pub route: Route,
    /// Number of actions that the guard vetoed, each counted once a decision.
    pub vetoes: u64,
    /// Actions of the guard's fallback.
    pub fallbacks: Fallbacks,
    /// Number of commands refused, by reason.
    pub refusals: RefusalCounts,
    /// Time from first landing to last commit, seconds; without what lies between two boots.
    pub duration_s: f64,
}

/// A path as JSON has it: what is not UTF-8 in it is replaced.
///
/// # Errors
/// None of its own.
pub fn path_as_text<S: Serializer>(path: &Path, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&path.to_string_lossy())
}

/// Paths as JSON has them.
fn paths_as_text<S: Serializer>(paths: &BTreeMap<String, PathBuf>, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(paths.iter().map(|(name, path)| (name, path.to_string_lossy())))
}

/// Folds records into a [`Summary`] in constant memory.
#[derive(Clone, Debug)]
pub struct SummaryBuilder {
    brief: Brief,
    seed: u64,
    tally: Tally,
    /// Decisions that were the turn of each robot, in the order of their numbers.
    actions: Vec<u64>,
}

impl SummaryBuilder {
    /// A run of `brief` without any decision yet.
    #[must_use]
    pub fn new(brief: &Brief, seed: u64) -> Self {
        let actions = vec![0; brief.robots.len()];
        Self { brief: brief.clone(), seed, tally: Tally::new(brief), actions }
    }

    /// Adds the next record.
    ///
    /// # Panics
    /// If it does not follow the last one; journals are checked when they are opened.
    pub fn record(&mut self, record: &Record) {
        self.tally.fold(&Executed::from(record));
        if let Some(actions) = self.actions.get_mut(usize::from(record.robot.0)) {
            *actions += 1;
        }
    }

    /// The summary of a run that ended in `state`, several robots as `team`, and refused commands as `refusals` counts. The
    /// caller fills in `coverage`, `processes` and `artifacts`, which records do not contain.
    #[must_use]
    pub fn build(&self, state: &State, team: Option<&Team>, refusals: &RefusalCounts) -> Summary {
        let (brief, tally) = (&self.brief, &self.tally);
        let over = [tally.status(), state.status].into_iter().find(|status| status.is_over());
        // Before the first decision only the state tells what is covered already.
        let visits = tally.last.map_or(state.visits, |last| last.visits);
        Summary {
            scenario: brief.scenario.to_string(),
            seed: self.seed,
            profile: brief.profile,
            outcome: over.map_or(Ending::Stopped, Ending::Mission),
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
            visits,
            is_patrol: brief.visits().is_some(),
            team: TeamEffort::of(brief, tally.due().0, visits),
            robots: team.map_or_else(Vec::new, |team| self.robots(team, over.unwrap_or(state.status))),
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

    /// Each robot of `team`, in a mission that stands at `status`.
    fn robots(&self, team: &Team, status: Status) -> Vec<RobotSummary> {
        let last_planner = |robot| {
            let own = self.tally.planners.iter().rev().find(|leadership| leadership.robot == robot);
            own.map_or(Name::NONE, |leadership| leadership.name)
        };
        let only = with_only_goal(&self.brief).map(|(only, _)| only);
        let members = self.brief.robots.numbered().zip(team.members.iter()).zip(&self.actions);
        let summary = |((robot, member), actions): (((RobotId, &Robot), &Member), &u64)| {
            let mission = if only == Some(robot.0) { Some(status) } else { None };
            RobotSummary::of(robot, member, last_planner(robot.0), *actions, mission)
        };
        members.map(summary).collect()
    }
}

impl Summary {
    /// How the mission ended, in one sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let &Self { outcome, hops, steps, steps_max, cell, team, .. } = self;
        // Where robots have no goal in common no sentence names a distance.
        let distance_to_goal_m = self.distance_to_goal_m.unwrap_or_default();
        let visited = self.is_patrol.then_some(self.visits);
        EndSentence { outcome, hops, steps, steps_max, cell, distance_to_goal_m, visited, team }.to_string()
    }

    /// Moves by outcome, where they led, and the time they took in the simulated world.
    fn moves(&self) -> [(&'static str, String); 2] {
        let route = &self.route;
        let strays = [("stayed", route.stayed), ("to the left", route.left), ("to the right", route.right)];
        let name = if self.team.is_none() { "hops" } else { "moves" };
        let mut moves = format!("{} as intended", route.intended);
        for (what, count) in strays.into_iter().chain([("held", route.held)]).filter(|(_, count)| *count > 0)
        {
            moves += &format!(", {count} {what}");
        }
        let mut way = match self.team {
            None => {
                format!(
                    "{:.1} m over ground, {:.1} m from start to goal",
                    route.length_m,
                    self.start_to_goal_m.unwrap_or_default()
                )
            }
            Some(_) => format!("{:.1} m of all robots, from cell to cell", route.length_m),
        };
        // Ground of uncertain speed is flat.
        let has_heights = self.team.is_none_or(|team| team.covered.is_some());
        if has_heights && let Some(heights) = route.height_m {
            way += &format!(", heights {:.2} to {:.2} m", heights.min, heights.max);
        }
        [(name, moves), ("route", way)]
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut fact = |name: &str, text: String| writeln!(f, "  {name:<10}  {text}");
        let route = &self.route;
        fact("outcome", self.sentence())?;
        let names = self.planners.iter().map(|leadership| leadership.name);
        let is_alone = self.planners.iter().all(|leadership| leadership.robot == RobotId(0));
        let planners = if is_alone { planners_in_order(names) } else { planners_of_team(names) };
        let Self { scenario, profile, seed, .. } = self;
        fact("run", format!("scenario {scenario}, planner {planners}, profile {profile}, seed {seed}"))?;
        for (name, text) in self.moves() {
            fact(name, text)?;
        }
        for robot in &self.robots {
            fact(&format!("robot {}", robot.robot), robot.to_string())?;
        }
        if self.treasures > 0 {
            fact("treasures", format!("{} collected", self.treasures))?;
        }
        if self.vetoes > 0 || self.fallbacks.total() > 0 {
            fact("guard", guard_phrase(self.vetoes, self.fallbacks))?;
        }
        if let Some(share) = self.coverage {
            fact("map", format!("{:.0} % seen", 100.0 * share))?;
        }
        fact(
            "time",
            format!(
                "{:.2} s from first landing to last commit, {:.1} s of {}",
                self.duration_s,
                route.flight_s,
                if self.team.is_none() { "flight" } else { "the robots' actions" }
            ),
        )?;
        let hidden = self.planners.len().saturating_sub(LEADERSHIPS_SHOWN);
        if hidden > 0 {
            fact("command", format!("{} before these", counted(hidden as u64, "change")))?;
        }
        for leadership in &self.planners[hidden..] {
            fact("command", leadership.to_string())?;
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
        self.artifacts.iter().try_for_each(|(name, path)| writeln!(f, "  {name:<10}  {}", path.display()))?;
        match self.artifacts.get("journal").and_then(|journal| journal.parent()) {
            Some(folder) => writeln!(f, "\nOn a page, hop by hop: hopper view {} --open", quoted(folder)),
            None => Ok(()),
        }
    }
}

/// A path as a shell takes it for one word, and a program for no flag.
fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    let text = if text.is_empty() || text.starts_with('-') { format!("./{text}") } else { text };
    let is_plain = |character: char| character.is_alphanumeric() || "/._-+,@%:=".contains(character);
    if text.chars().all(is_plain) { text } else { format!("'{}'", text.replace('\'', r"'\''")) }
}
