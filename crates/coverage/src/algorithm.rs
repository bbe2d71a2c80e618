//! The planners by name.

use std::fmt;
use std::str::FromStr;

use contract::Direction;
use serde::{Deserialize, Serialize};

use crate::Situation;
use crate::frontier::Frontier;
use crate::rule::{Pattern, Rule};

/// A planner for coverage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Algorithm {
    /// P19's spiral.
    Spiral,
    /// The spiral that prefers cells beside obstacles.
    SpiralCircumnavigation,
    /// P19's sweep there and back.
    Boustrophedon,
    /// The sweep that prefers cells beside obstacles.
    BoustrophedonCircumnavigation,
    /// Ours: see [`crate::frontier`].
    CoverFrontier,
}

impl Algorithm {
    /// All planners, those of the paper first.
    pub const ALL: [Algorithm; 5] = [
        Algorithm::Spiral,
        Algorithm::SpiralCircumnavigation,
        Algorithm::Boustrophedon,
        Algorithm::BoustrophedonCircumnavigation,
        Algorithm::CoverFrontier,
    ];

    /// The name by which a planner is asked for.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Algorithm::Spiral => "spiral",
            Algorithm::SpiralCircumnavigation => "spiral_circumnavigation",
            Algorithm::Boustrophedon => "boustrophedon",
            Algorithm::BoustrophedonCircumnavigation => "boustrophedon_circumnavigation",
            Algorithm::CoverFrontier => "cover_frontier",
        }
    }
}

impl fmt::Display for Algorithm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// No planner has this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a coverage planner is one of {}, got {got:?}", Algorithm::ALL.map(Algorithm::name).join(", "))]
pub struct UnknownAlgorithm {
    /// The name asked for.
    pub got: String,
}

impl FromStr for Algorithm {
    type Err = UnknownAlgorithm;

    fn from_str(text: &str) -> Result<Self, UnknownAlgorithm> {
        let named = Self::ALL.into_iter().find(|algorithm| algorithm.name() == text);
        named.ok_or_else(|| UnknownAlgorithm { got: text.to_owned() })
    }
}

/// A planner with its working memory.
#[derive(Clone, Debug)]
pub enum Planner {
    /// The rule of P19 needs none.
    Rule(Rule),
    /// Ours searches the map.
    Frontier(Frontier),
}

impl Planner {
    /// A planner with empty memory.
    #[must_use]
    pub fn new(algorithm: Algorithm) -> Self {
        let (pattern, circumnavigation) = match algorithm {
            Algorithm::Spiral => (Pattern::Spiral, false),
            Algorithm::SpiralCircumnavigation => (Pattern::Spiral, true),
            Algorithm::Boustrophedon => (Pattern::Boustrophedon, false),
            Algorithm::BoustrophedonCircumnavigation => (Pattern::Boustrophedon, true),
            Algorithm::CoverFrontier => return Planner::Frontier(Frontier::default()),
        };
        Planner::Rule(Rule { pattern, circumnavigation })
    }

    /// The next step of the rover that decides; `None` to stay. The memory never changes the answer.
    #[must_use]
    pub fn decide(&mut self, situation: &Situation<'_>) -> Option<Direction> {
        match self {
            Planner::Rule(rule) => rule.decide(situation),
            Planner::Frontier(frontier) => frontier.decide(situation),
        }
    }
}
