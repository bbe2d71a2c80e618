//! Phrases that reports share.

use std::fmt;

use contract::{Account, Brief, Cell, Name, Robot, Status};
use serde::{Deserialize, Serialize};

use crate::{Ending, with_only_goal};

/// How a mission ended. Displayed, it is one sentence.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EndSentence {
    pub outcome: Ending,
    pub hops: u64,
    pub steps: u64,
    pub steps_max: u64,
    pub cell: Cell,
    pub distance_to_goal_m: f64,
    /// Goals visited; `None` unless they are visited in turn.
    pub visited: Option<u64>,
    /// What several robots were to do; `None` for a single hopper.
    pub team: Option<TeamEffort>,
}

/// What several robots did together.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TeamEffort {
    /// At least 1; with more, sentences speak of moves rather than of hops.
    pub robots: u16,
    /// Decisions of all robots.
    pub actions: u64,
    /// Cells visited; `None` unless ground was to be covered.
    pub covered: Option<u64>,
    /// Whether robots had goals of their own, and not one in common.
    pub is_mixed: bool,
}

impl TeamEffort {
    /// The effort of a team after so many decisions and visits; `None` if a single hopper flies.
    pub(crate) fn of(brief: &Brief, actions: u64, visits: u64) -> Option<Self> {
        if brief.account == Account::Hopper {
            return None;
        }
        let covered = brief.cover().map(|_| visits);
        let covers = |robot: &Robot| robot.goal.cover().is_some() || robot.goal.looks_ahead();
        let is_of_rover = with_only_goal(brief).is_some_and(|(_, robot)| robot.body.drives());
        let is_mixed = !is_of_rover && !brief.robots.iter().all(covers);
        Some(Self { robots: brief.robots.count(), actions, covered, is_mixed })
    }

    /// How a mission of several robots ended.
    fn fmt(self, sentence: &EndSentence, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { robots, actions, covered, is_mixed } = self;
        let EndSentence { outcome, steps, steps_max, cell, .. } = sentence;
        let how = match (outcome, covered) {
            (Ending::Stopped, _) => "Stopped".to_owned(),
            (Ending::Mission(Status::Goal), _) if is_mixed => {
                "All tasks that the mission needs are done".to_owned()
            }
            (Ending::Mission(Status::Lost | Status::LeftMap), _) if is_mixed => {
                "A robot is lost that the mission needs".to_owned()
            }
            (Ending::Mission(Status::Goal), Some(cells)) => format!("Covered, {}", counted(cells, "cell")),
            (Ending::Mission(Status::Goal), None) => format!("The rover is at the goal, {cell}"),
            (Ending::Mission(Status::Deadlock), _) => "Out of actions".to_owned(),
            (Ending::Mission(Status::Lost | Status::LeftMap), Some(_)) => "No robot can go on".to_owned(),
            (Ending::Mission(Status::Lost | Status::LeftMap), None) => "The rover is stuck".to_owned(),
            (Ending::Mission(Status::Underway), _) => "Under way".to_owned(),
        };
        let (actions, robots) = (counted(actions, "action"), counted(robots.into(), "robot"));
        write!(f, "{how}: {actions} of {robots}, at most {steps} of {steps_max} each.")
    }
}

impl fmt::Display for EndSentence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(team) = self.team {
            return team.fmt(self, f);
        }
        let Self { hops, steps, steps_max, cell, distance_to_goal_m: short_m, .. } = self;
        let mut spent = format!("{}, {steps} of {steps_max} steps", counted(*hops, "hop"));
        if self.outcome == Ending::Mission(Status::Deadlock) {
            // The last hop may end beyond the limit: it costs two steps or three.
            spent = format!("{}, {steps} steps, limit {steps_max}", counted(*hops, "hop"));
        }
        if let Some(visits) = self.visited {
            spent = format!("{}, {}, {steps} steps", counted(visits, "visit"), counted(*hops, "hop"));
        }
        let status = match self.outcome {
            Ending::Mission(status) => status,
            Ending::Stopped => {
                return write!(f, "Stopped at {cell}, {short_m:.1} m short of the goal: {spent}.");
            }
        };
        match status {
            Status::Goal if self.visited.is_some() => write!(f, "Patrol flown to {cell}: {spent}."),
            Status::Goal => write!(f, "Goal reached at {cell}: {spent}."),
            Status::Deadlock => {
                write!(f, "Out of steps at {cell}, {short_m:.1} m short of the goal: {spent}.")
            }
            Status::LeftMap => write!(f, "Left the map at {cell}: {spent}."),
            Status::Lost => write!(f, "Lost on impassable ground at {cell}: {spent}."),
            Status::Underway => write!(f, "Under way at {cell}, {short_m:.1} m to go: {spent}."),
        }
    }
}

/// "1 hop", "2 hops".
pub(crate) fn counted(count: u64, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// The planners that commanded several robots, each once: "rrt_star_ett, rrt_star_it".
pub(crate) fn planners_of_team(names: impl Iterator<Item = Name>) -> String {
    let mut each: Vec<Name> = Vec::new();
    for name in names.filter(|name| *name != Name::NONE) {
        if !each.contains(&name) {
            each.push(name);
        }
    }
    if each.is_empty() { "none".into() } else { each.iter().map(Name::as_str).collect::<Vec<_>>().join(", ") }
}

/// The planners that commanded, in order: "mdp then greedy".
pub(crate) fn planners_in_order(names: impl Iterator<Item = Name>) -> String {
    let mut order: Vec<Name> = Vec::new();
    for name in names.filter(|name| *name != Name::NONE) {
        if order.last() != Some(&name) {
            order.push(name);
        }
    }
    match order.as_slice() {
        [] => "none".into(),
        [first, .., last] if order.len() > 3 => {
            format!("{first} and {} others, last {last}", order.len() - 2)
        }
        order => order.iter().map(Name::as_str).collect::<Vec<_>>().join(" then "),
    }
}
