//! Phrases that reports share.

use std::fmt;

use contract::{Cell, Name, Status};

use crate::Ending;

/// How a mission ended. Displayed, it is one sentence.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EndSentence {
    pub outcome: Ending,
    pub hops: u64,
    pub steps: u64,
    pub steps_max: u64,
    pub cell: Cell,
    pub distance_to_goal_m: f64,
    /// Goals visited; `None` unless the mission is a patrol.
    pub patrolled: Option<u64>,
}

impl fmt::Display for EndSentence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { hops, steps, steps_max, cell, distance_to_goal_m: short_m, .. } = self;
        let mut spent = format!("{}, {steps} of {steps_max} steps", counted(*hops, "hop"));
        if self.outcome == Ending::Mission(Status::Deadlock) {
            // The last hop may end beyond the limit: it costs two steps or three.
            spent = format!("{}, {steps} steps, limit {steps_max}", counted(*hops, "hop"));
        }
        if let Some(visits) = self.patrolled {
            spent = format!("{}, {}, {steps} steps", counted(visits, "visit"), counted(*hops, "hop"));
        }
        let status = match self.outcome {
            Ending::Mission(status) => status,
            Ending::Stopped => {
                return write!(f, "Stopped at {cell}, {short_m:.1} m short of the goal: {spent}.");
            }
        };
        match status {
            Status::Goal if self.patrolled.is_some() => write!(f, "Patrol flown to {cell}: {spent}."),
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
