//! What every process receives before the mission begins: the canonical scenario brief.
//!
//! It holds nothing of the truth beyond what an orbital survey would give. The seed is not in it: a
//! planner that knew the seed could foresee every slip.

use serde::{Deserialize, Serialize};

use crate::spelling::did_you_mean;
use crate::{
    Cell, Cover, Design, Grid, Mixed, MotionParameters, Name, Patrol, Reading, RobotId, RunId, Scout,
    SensorParameters, Task,
};

/// Which reading of the model the mission follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Profile {
    /// Sakamoto & Kunii 2023 reproduced to the letter.
    #[serde(rename = "paper-2023")]
    Paper2023,
    /// The paper's world with our planners' choices.
    #[serde(rename = "hopper")]
    Hopper,
}

impl Profile {
    /// Every profile.
    pub const ALL: [Profile; 2] = [Profile::Paper2023, Profile::Hopper];

    /// The profile's name in scenarios and on the command line.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Profile::Paper2023 => "paper-2023",
            Profile::Hopper => "hopper",
        }
    }

    /// The code on the wire.
    #[must_use]
    pub fn code(self) -> u32 {
        match self {
            Profile::Paper2023 => 1,
            Profile::Hopper => 2,
        }
    }

    /// The profile of a wire code, if there is one.
    #[must_use]
    pub fn from_code(code: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|profile| profile.code() == code)
    }
}

impl std::fmt::Display for Profile {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.as_str())
    }
}

impl std::str::FromStr for Profile {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|profile| profile.as_str() == text).ok_or_else(|| {
            let meant = did_you_mean(text, Self::ALL.map(Profile::as_str));
            format!("a profile is paper-2023 or hopper, got {text:?}{meant}")
        })
    }
}

/// All values from `min` to `max`, both included.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Range {
    /// Lower end; not above `max`.
    pub min: f64,
    /// Upper end, not below the lower.
    pub max: f64,
}

impl Range {
    /// Where `value` lies between the ends: 0 at the lower, 1 at the upper, beyond outside; 0 on an empty range.
    #[must_use]
    pub fn normalise(&self, value: f64) -> f64 {
        let width = self.max - self.min;
        if width > 0.0 { (value - self.min) / width } else { 0.0 }
    }
}

/// Weights of the payoff r = w1·S + w2·I + w3·D (P23 eq. 3).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Weights {
    /// w1, of safety S.
    pub safety: f64,
    /// w2, of information gain I.
    pub information: f64,
    /// w3, of the distance penalty D.
    pub distance: f64,
}

/// The remaining constants of the payoff.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Payoff {
    /// Payoff of the goal, which absorbs.
    pub goal: f64,
    /// Payoff of collecting a treasure, on top of that of landing on its cell.
    pub treasure: f64,
    /// Discount γ per period, in (0, 1).
    pub discount: f64,
    /// The soil term T on sand in S = −|∇h| − T (P23 eq. 4).
    pub sand_term: f64,
}

/// What is known of the whole map beforehand: ranges for min–max normalisation, and how many treasures there are.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Priors {
    /// Range of S = −|∇h| − T.
    pub safety: Range,
    /// Range of I = h, metres.
    pub height_m: Range,
    /// Treasures on the map, not where they lie; 0 where there are none, or their number is unknown.
    pub treasures: u32,
}

/// When the mission is over, and how long a decision may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Limits {
    /// Steps (the paper's count) after which the mission is a deadlock; a patrol has no such limit.
    pub steps_max: u64,
    /// Budget of one decision, landing to commit, nanoseconds.
    pub decision_budget_ns: u64,
}

/// What hopper-sim's guard lets pass, and how long it waits for a command it can let pass.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Guard {
    /// Largest probability, 0 to 1, with which an action may end off the map or on ground that can be seen
    /// to be impassable; 1 lets everything pass.
    pub hazard_max: f64,
    /// Time from the publication of a state to the fallback, nanoseconds; 0 for no fallback: the hopper
    /// stands still until a planner commands.
    pub deadline_ns: u64,
}

impl Guard {
    /// Vetoes nothing, and waits for ever.
    pub const OFF: Guard = Guard { hazard_max: 1.0, deadline_ns: 0 };
}

/// What a mission asks for, resolved from its scenario. Two briefs of one run are equal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Brief {
    /// The run it belongs to.
    pub run: RunId,
    /// Name of the scenario.
    pub scenario: Name,
    /// SHA-256 over the resolved scenario and its terrain.
    pub scenario_hash: [u8; 32],
    /// Reading of the model.
    pub profile: Profile,
    /// Robots of the mission, numbered from 0. In a hopper's mission robot 0 is the hopper, and all others are helicopters.
    pub robots: u16,
    /// Lattice of the mission; every cell of the message lies on it.
    pub grid: Grid,
    /// Absolute elevation of height 0, metres.
    pub datum_m: f64,
    /// Where the hopper starts.
    pub start: Cell,
    /// Where it shall go; on a patrol, first.
    pub goal: Cell,
    /// The goals to be visited in turn, if the mission is a patrol.
    pub patrol: Option<Patrol>,
    /// How safety, information and distance are weighed.
    pub weights: Weights,
    /// What a period, the goal and a treasure are worth.
    pub payoff: Payoff,
    /// What an orbiter has measured of the whole map beforehand.
    pub priors: Priors,
    /// How far a hop goes, and how it slips and drifts by soil; [`Brief::motion_of`] has that of each hopper.
    pub motion: MotionParameters,
    /// How far a hopper sees from a height; [`Brief::sensor_of`] has that of each.
    pub sensor: SensorParameters,
    /// Steps of the mission, and time for a decision.
    pub limits: Limits,
    /// The guard in hopper-sim.
    pub guard: Guard,
    /// How the paper's open points are read.
    pub reading: Reading,
    /// What rovers shall cover, if that is the mission. Then [`crate::Team`] has the robots, and start, goal, motion,
    /// sensor and payoff, which are a hopper's, are not read.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cover: Option<Cover>,
    /// What planners of routes are given, if a rover is to reach a goal over uncertain ground. The
    /// robots, their starts and their goals are in [`crate::Team`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scout: Option<Scout>,
    /// Which robots decide the mission, if each has a task of its own. Then `cover` is what those rovers cover that have no goal,
    /// `scout` is given if a rover drives to a goal, motion and sensor are those of hoppers without a design of their own, and the
    /// payoff is that of all hoppers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mixed: Option<Mixed>,
}

impl Brief {
    /// What the mission is about.
    #[must_use]
    pub fn task(&self) -> Task {
        match (self.mixed, self.scout, self.cover, self.patrol) {
            (Some(mixed), ..) => Task::Mixed(mixed.required),
            (None, Some(scout), ..) => Task::Scout(scout),
            (None, None, Some(cover), _) => Task::Cover(cover),
            (None, None, None, _) if self.robots > 1 => Task::Accompany,
            (None, None, None, Some(_)) => Task::Patrol,
            (None, None, None, None) => Task::Reach,
        }
    }

    /// Whether the mission is a hopper's, alone or with helicopters. Start, goal, motion, sensor and payoff are read only then.
    #[must_use]
    pub fn is_of_hopper(&self) -> bool {
        self.cover.is_none() && self.scout.is_none() && self.mixed.is_none()
    }

    /// Whether the mission has a goal, or goals one after another. Robots that cover ground have none, and those of a mixed mission one
    /// each.
    #[must_use]
    pub fn has_common_goal(&self) -> bool {
        self.cover.is_none() && self.mixed.is_none()
    }

    /// Whether states come with a [`crate::Team`]: always but for a hopper that is alone.
    #[must_use]
    pub fn has_team(&self) -> bool {
        !self.is_of_hopper() || self.robots > 1
    }

    /// Whether robots announce routes.
    #[must_use]
    pub fn has_routes(&self) -> bool {
        self.mixed.is_some() || self.cover.is_none() && self.has_team()
    }

    fn design_of(&self, robot: RobotId) -> Option<&Design> {
        self.mixed.as_ref().and_then(|mixed| mixed.designs.of(robot))
    }

    /// How the hopper `robot` hops.
    #[must_use]
    pub fn motion_of(&self, robot: RobotId) -> &MotionParameters {
        self.design_of(robot).map_or(&self.motion, |design| &design.motion)
    }

    /// How far the hopper `robot` sees.
    #[must_use]
    pub fn sensor_of(&self, robot: RobotId) -> &SensorParameters {
        self.design_of(robot).map_or(&self.sensor, |design| &design.sensor)
    }

    /// The brief as it is for the hopper `robot`: with its own motion and sensor.
    #[must_use]
    pub fn for_hopper(&self, robot: RobotId) -> Brief {
        Brief { motion: *self.motion_of(robot), sensor: *self.sensor_of(robot), ..*self }
    }

    /// The brief of the leg that is flown after so many visits: from the goal visited last to the goal in
    /// force. To whoever plans, a leg is a mission like any other. Without a patrol it is the brief itself.
    #[must_use]
    pub fn leg(&self, visits: u64) -> Brief {
        let Some(patrol) = &self.patrol else { return *self };
        let start = visits.checked_sub(1).map_or(self.start, |last| patrol.goal(last));
        Brief { start, goal: patrol.goal(visits), ..*self }
    }

    /// The goal in force after so many visits: that of [`Brief::leg`].
    #[must_use]
    pub fn goal_after(&self, visits: u64) -> Cell {
        self.patrol.as_ref().map_or(self.goal, |patrol| patrol.goal(visits))
    }

    /// Whether landing on `cell` after so many visits is another: nobody visits a goal out of turn.
    #[must_use]
    pub fn is_visit(&self, visits: u64, cell: Cell) -> bool {
        cell == self.goal_after(visits)
    }
}
