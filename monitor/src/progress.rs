//! How a mission stands, as far as anybody can see from outside.

use std::fmt;

use contract::protocol::peer_table::SILENCE_NS;
use contract::{
    Account, Brief, Decision, Member, Name, RefusalCounts, RobotId, Role, RunId, Standing, Status,
};
use report::{Fallbacks, Leadership, guard_phrase};
use serde::{Deserialize, Serialize};

/// How a mission stands. Displayed, it is one line for a log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// As in the brief.
    pub run: RunId,
    /// Name of the scenario.
    pub scenario: Name,
    /// Status of the mission in the last state.
    pub status: Status,
    /// The decision that is due.
    pub decision: Decision,
    /// Decisions that are known of but not yet taken account of; 0 once the past has answered.
    pub missing: u64,
    /// Steps so far, in the papers' count.
    pub steps: u64,
    /// Steps after which the mission is a deadlock.
    pub steps_max: u64,
    /// Goals visited so far.
    pub visits: u64,
    /// Hops after which a mission that visits its goals in turn is done; `None` in other missions.
    pub hops_max: Option<u64>,
    /// From the hopper to the goal in force, metres as the crow flies; `None` where robots have no goal in common.
    pub distance_to_goal_m: Option<f64>,
    /// From start to goal, metres as the crow flies; `None` where robots have no goal in common.
    pub start_to_goal_m: Option<f64>,
    /// Hops that did not land where they were meant to.
    pub stray_hops: u64,
    /// Treasures collected so far.
    pub treasures: u32,
    /// Actions that the guard vetoed so far, each once a decision.
    pub vetoes: u64,
    /// What its fallback did so far.
    pub fallbacks: Fallbacks,
    /// Share of the map seen, 0 to 1; `None` before the first map.
    pub coverage: Option<f64>,
    /// Where the time of decisions went.
    pub latency: Pulse,
    /// Who commanded what; the last is in force.
    pub planners: Vec<Leadership>,
    /// What the way of several robots is measured by; `None` where there is a single hopper.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub measure: Option<TeamMeasure>,
    /// All robots, in the order of their numbers; empty where there is a single hopper, and until they are published.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub robots: Vec<Member>,
    /// Roles in the order of their codes.
    pub health: Vec<Health>,
    /// Of several robots those that act and for which no planner plans, though others are planned for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unplanned: Vec<RobotId>,
    /// Malformed messages refused.
    pub refusals: RefusalCounts,
}

/// What the way of several robots is measured by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TeamMeasure {
    /// The distance of the hopper from its goal.
    Distance,
    /// The cells that rovers have covered.
    Cells,
    /// So many robots that share no measure.
    Robots(u16),
}

impl TeamMeasure {
    /// That of a mission; `None` where there is a single hopper.
    #[must_use]
    pub fn of(brief: &Brief) -> Option<Self> {
        let measure = match brief.cover() {
            _ if brief.account == Account::Hopper => TeamMeasure::Distance,
            Some(_) => TeamMeasure::Cells,
            None => TeamMeasure::Robots(brief.robots.count()),
        };
        brief.has_team().then_some(measure)
    }
}

/// Latency of decisions, landed to committed, microseconds.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Pulse {
    /// Number of durations behind the percentiles.
    pub decisions: u64,
    /// Duration of the newest, microseconds.
    pub last_us: f64,
    /// Median of all so far, microseconds.
    pub p50_us: f64,
    /// Ninety-nine of a hundred took no longer.
    pub p99_us: f64,
    /// Budget of a decision.
    pub budget_us: f64,
    /// Decisions that took longer.
    pub misses: u64,
}

/// What is heard of a role.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Health {
    /// Each role has one entry.
    pub role: Role,
    /// Processes of the role with a heartbeat that has not run out.
    pub alive: usize,
    /// Process heard last; `None` if none ever was.
    pub pid: Option<u32>,
    /// How long nobody of the role has been heard, milliseconds; since the monitor began, if nobody ever was.
    pub silent_ms: u64,
    /// How often the whole role fell silent so far.
    pub silences: u64,
    /// The longest silence of the whole role, milliseconds.
    pub longest_silence_ms: u64,
}

impl Progress {
    /// Share of the way from start to goal that is covered, 0 to 1; if goals are visited in turn, the share of the hops. A detour does
    /// not go below 0.
    #[must_use]
    pub fn covered(&self) -> f64 {
        if let Some(hops_max) = self.hops_max {
            return (self.decision.0 as f64 / hops_max as f64).min(1.0);
        }
        match self.distance_to_goal_m.zip(self.start_to_goal_m) {
            Some((rest_m, whole_m)) if whole_m > 0.0 => (1.0 - rest_m / whole_m).max(0.0),
            _ => 1.0,
        }
    }

    /// The essentials in some fifty columns, for a terminal of eighty.
    #[must_use]
    pub fn compact(&self) -> String {
        let Self { decision, visits, .. } = self;
        let distance_to_goal_m = self.distance_m();
        let mut text = match self.measure {
            None => format!("hop {decision} · {distance_to_goal_m:.1} m"),
            Some(TeamMeasure::Distance) => format!("decision {decision} · {distance_to_goal_m:.1} m"),
            Some(TeamMeasure::Cells) => format!("decision {decision} · {visits} cells"),
            Some(TeamMeasure::Robots(count)) => format!("decision {decision} · {count} robots"),
        };
        if let Some(coverage) = self.coverage {
            text += &format!(" · {:.0} % seen", 100.0 * coverage);
        }
        if self.treasures > 0 {
            text += &format!(" · {} ★", self.treasures);
        }
        if self.latency.decisions > 0 {
            text += &format!(" · {}", duration(self.latency.last_us));
        }
        if let Some(Leadership { name, term, .. }) = self.leader() {
            text += &format!(" · {name} t{term}");
        }
        if self.fallbacks.total() > 0 {
            text += &format!(" · {} fallen back", self.fallbacks.total());
        }
        if self.latency.misses > 0 {
            text += &format!(" · {} missed", self.latency.misses);
        }
        text
    }

    /// Whose turn at the command it is.
    #[must_use]
    pub fn leader(&self) -> Option<&Leadership> {
        self.planners.last()
    }

    /// Changes of command so far; the first command is none.
    #[must_use]
    pub fn changes_of_leader(&self) -> usize {
        self.planners.len().saturating_sub(1)
    }
}

impl fmt::Display for Progress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.status.is_over() {
            write!(f, "{}: ", self.status)?;
        }
        let Self { decision, steps, steps_max, .. } = self;
        let distance_to_goal_m = self.distance_m();
        match (self.hops_max, self.measure) {
            (None, Some(measure)) => {
                write!(f, "decision {decision}, step {steps}/{steps_max}, ")?;
                match measure {
                    TeamMeasure::Distance => write!(f, "{distance_to_goal_m:.1} m to go")?,
                    TeamMeasure::Cells => write!(f, "{} cells covered", self.visits)?,
                    TeamMeasure::Robots(count) => write!(f, "{count} robots")?,
                }
                self.write_robots(f)?;
            }
            (None, None) => {
                write!(f, "hop {decision}, step {steps}/{steps_max}, {distance_to_goal_m:.1} m to go")?;
            }
            (Some(hops_max), _) => write!(
                f,
                "hop {decision}/{hops_max}, {} goals visited, {distance_to_goal_m:.1} m to the next",
                self.visits
            )?,
        }
        if let Some(coverage) = self.coverage {
            write!(f, ", {:.0} % seen", 100.0 * coverage)?;
        }
        if self.treasures > 0 {
            write!(f, ", {} treasure{}", self.treasures, if self.treasures == 1 { "" } else { "s" })?;
        }
        let Pulse { decisions, last_us, p50_us, p99_us, misses, .. } = self.latency;
        if decisions > 0 {
            let [last, p50, p99] = [last_us, p50_us, p99_us].map(duration);
            write!(f, ", latency {last} (p50 {p50}, p99 {p99}), {misses} missed")?;
        }
        if let Some(Leadership { name, term, .. }) = self.leader() {
            write!(f, ", {name} term {term}")?;
        }
        if self.vetoes > 0 || self.fallbacks.total() > 0 {
            write!(f, ", {}", guard_phrase(self.vetoes, self.fallbacks))?;
        }
        if self.missing > 0 {
            write!(f, ", {} decisions to catch up", self.missing)?;
        }
        // At the end everybody leaves.
        let missed = |health: &&Health| health.alive == 0 && !self.status.is_over();
        for Health { role, pid, silent_ms, .. } in self.health.iter().filter(missed) {
            match pid {
                Some(_) => write!(f, ", {role} silent for {:.1} s", *silent_ms as f64 / 1e3)?,
                // Whoever has just begun to listen has heard nobody yet.
                None if *silent_ms * 1_000_000 < SILENCE_NS => {}
                None => write!(f, ", no {role}")?,
            }
        }
        if !self.unplanned.is_empty() && !self.status.is_over() {
            let numbers: Vec<String> = self.unplanned.iter().map(RobotId::to_string).collect();
            write!(f, ", no planner of {}", numbers.join(" "))?;
        }
        let refused: u64 = self.refusals.0.values().sum();
        if refused > 0 {
            write!(f, ", {refused} refused")?;
        }
        Ok(())
    }
}

impl Progress {
    /// The distance to the goal as texts show it; they do so only where robots have a goal in common.
    fn distance_m(&self) -> f64 {
        self.distance_to_goal_m.unwrap_or_default()
    }

    /// The numbers of the robots of each standing.
    fn write_robots(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for standing in Standing::ALL {
            let numbered = self.robots.iter().enumerate();
            let of_standing = numbered.filter(|(_, member)| member.standing == standing);
            let numbers: Vec<String> = of_standing.map(|(number, _)| number.to_string()).collect();
            if !numbers.is_empty() {
                let noun = if numbers.len() == 1 { "robot" } else { "robots" };
                write!(f, ", {noun} {} {standing}", numbers.join(" "))?;
            }
        }
        Ok(())
    }
}

/// A duration in the unit that suits it.
fn duration(us: f64) -> String {
    match us {
        us if us < 1e3 => format!("{us:.0} µs"),
        us if us < 1e6 => format!("{:.1} ms", us / 1e3),
        us => format!("{:.2} s", us / 1e6),
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use contract::Term;

    pub(crate) fn progress() -> Progress {
        let name = |text: &str| text.parse().unwrap();
        let health =
            |role| Health { role, alive: 1, pid: Some(7), silent_ms: 3, silences: 0, longest_silence_ms: 0 };
        Progress {
            run: RunId(1),
            scenario: name("hard"),
            status: Status::Underway,
            decision: Decision(17),
            missing: 0,
            steps: 34,
            steps_max: 150,
            visits: 0,
            hops_max: None,
            distance_to_goal_m: Some(12.04),
            start_to_goal_m: Some(24.08),
            stray_hops: 2,
            treasures: 0,
            vetoes: 0,
            fallbacks: Fallbacks::default(),
            coverage: Some(0.614),
            latency: Pulse {
                decisions: 17,
                last_us: 431.2,
                p50_us: 1_420.0,
                p99_us: 2_000_000.0,
                budget_us: 6e5,
                misses: 1,
            },
            planners: vec![Leadership {
                name: name("mdp"),
                term: Term(1),
                from_decision: Decision(0),
                to_decision: Decision(16),
                robot: contract::RobotId(0),
            }],
            measure: None,
            robots: Vec::new(),
            health: Role::ALL.map(health).into(),
            unplanned: Vec::new(),
            refusals: RefusalCounts::default(),
        }
    }

    #[test]
    fn a_line_tells_how_the_mission_stands() {
        let mut progress = progress();
        assert_eq!(
            progress.to_string(),
            "hop 17, step 34/150, 12.0 m to go, 61 % seen, latency 431 µs (p50 1.4 ms, p99 2.00 s), 1 missed, \
             mdp term 1"
        );
        assert_eq!(progress.covered(), 0.5);
        assert_eq!(progress.changes_of_leader(), 0);
        progress.health[1].alive = 0;
        progress.health[1].silent_ms = 1300;
        // Who has listened for less than a second misses nobody yet.
        progress.health[2] = Health { alive: 0, pid: None, silent_ms: 900, ..progress.health[2] };
        assert!(!progress.to_string().contains("no planner"));
        progress.health[2].silent_ms = 1000;
        progress.missing = 3;
        progress.vetoes = 2;
        progress.fallbacks.greedy = 1;
        assert!(progress.to_string().ends_with(
            "term 1, 2 vetoes, 1 fallback (1 greedy), 3 decisions to catch up, perception silent for 1.3 s, \
                     no planner"
        ));
        progress.health[2].alive = 1;
        progress.unplanned = vec![RobotId(1), RobotId(3)];
        assert!(progress.to_string().ends_with("perception silent for 1.3 s, no planner of 1 3"));
    }

    #[test]
    fn progress_survives_its_json() {
        let progress = progress();
        let json = serde_json::to_string(&progress).unwrap();
        assert_eq!(serde_json::from_str::<Progress>(&json).unwrap(), progress);
    }
}
