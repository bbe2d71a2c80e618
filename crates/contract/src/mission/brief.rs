//! What every process receives before the mission begins: the canonical scenario brief.
//!
//! It holds nothing of the truth beyond what an orbital survey would give. The seed is not in it: a
//! planner that knew the seed could foresee every slip.

use serde::{Deserialize, Serialize};

use crate::{
    Account, Cell, Cover, Goal, Grid, Name, Profile, Range, Reading, Robots, RunId, Sampling, Visit,
};

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
    /// Steps (the paper's count) after which the mission is a deadlock; visits in turn have no such limit.
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Brief {
    /// The run it belongs to.
    pub run: RunId,
    /// Name of the scenario.
    pub scenario: Name,
    /// SHA-256 over the resolved scenario and its terrain.
    pub scenario_hash: [u8; 32],
    /// Reading of the model.
    pub profile: Profile,
    /// Lattice of the mission; every cell of the message lies on it.
    pub grid: Grid,
    /// Absolute elevation of height 0, metres.
    pub datum_m: f64,
    /// How safety, information and distance are weighed.
    pub weights: Weights,
    /// What a period, the goal and a treasure are worth.
    pub payoff: Payoff,
    /// What an orbiter has measured of the whole map beforehand.
    pub priors: Priors,
    /// Steps of the mission, and time for a decision.
    pub limits: Limits,
    /// The guard in hopper-sim.
    pub guard: Guard,
    /// How the paper's open points are read.
    pub reading: Reading,
    /// What states of the mission tell, and what its limit counts.
    pub account: Account,
    /// What planners of routes are given, where robots drive over uncertain ground.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sampling: Option<Sampling>,
    /// Who flies: each robot's body, sensor, start and goal. A hopper alone is a team of one.
    pub robots: Robots,
}

impl Brief {
    /// Whether states come with a [`crate::Team`]: always but for a hopper that is alone.
    #[must_use]
    pub fn has_team(&self) -> bool {
        self.account != Account::Hopper || self.robots.count() > 1
    }

    /// Whether robots announce routes.
    #[must_use]
    pub fn has_routes(&self) -> bool {
        self.robots.iter().any(|robot| robot.body.along_route().is_some())
    }

    /// Fingerprint of the motion table that planners of hoppers believe; 0 where they believe the four branches.
    #[must_use]
    pub fn motion_table(&self) -> u64 {
        let tables = self.robots.iter().filter_map(|robot| Some(robot.as_hopper()?.0.table));
        tables.max().unwrap_or_default()
    }

    /// How much ground rovers shall cover, if any shall.
    #[must_use]
    pub fn cover(&self) -> Option<Cover> {
        self.robots.iter().find_map(|robot| robot.goal.cover())
    }

    /// The goal of robot 0 after so many visits, if it is one cell after another.
    #[must_use]
    pub fn goal_after(&self, visits: u64) -> Option<Cell> {
        self.robots[0].goal.cell(&self.grid, visits)
    }

    /// Whether landing on `cell` is the next visit of robot 0 after so many: a goal that is not in force does not count.
    #[must_use]
    pub fn is_visit(&self, visits: u64, cell: Cell) -> bool {
        self.goal_after(visits) == Some(cell)
    }

    /// The goals that a hopper visits in turn, if that is the mission.
    #[must_use]
    pub fn visits(&self) -> Option<&Visit> {
        match &self.robots[0].goal {
            Goal::Visit(visit) if self.account == Account::Hopper => Some(visit),
            _ => None,
        }
    }
}
