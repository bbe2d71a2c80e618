//! Readings of the paper: an answer to every question that it leaves open.

use serde::Serialize;

/// How high the hills are: P22 eq. 7 with σ = 2 m.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum HillHeight {
    /// 1 / (2π √|Σ|) m = 0.040 m, as printed.
    Printed,
    /// 1 / 2π m = 0.159 m, eq. 7 without its determinant, as P23's tables want it.
    WithoutDeterminant,
    /// 1 m, the hopper's own scale: slopes up to the paper's limit of 30°.
    Metre,
}

impl HillHeight {
    /// Height of a hill on its own, metres.
    #[must_use]
    pub fn amplitude_m(self) -> f64 {
        use std::f64::consts::TAU;
        match self {
            HillHeight::Printed => 1.0 / (4.0 * TAU),
            HillHeight::WithoutDeterminant => 1.0 / TAU,
            HillHeight::Metre => 1.0,
        }
    }
}

/// The cell that determines the payoff of a hop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PayoffCell {
    /// The cell the hop leaves: r(x, u), as in eqs. 1, 2 and 5.
    Departure,
    /// The cell the hop reaches: r(x′), as in P23.
    Arrival,
}

/// The interval that a min–max normalisation maps to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Span {
    /// [0, 1].
    Gain,
    /// [−1, 0].
    Cost,
    /// [−1, 1].
    Both,
}

impl Span {
    /// The value of `share`, 0 at the lower end and 1 at the upper.
    #[must_use]
    pub fn at(self, share: f64) -> f64 {
        match self {
            Span::Gain => share,
            Span::Cost => share - 1.0,
            Span::Both => 2.0 * share - 1.0,
        }
    }
}

/// Which term the payoff of sand, −0.5, belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SandPayoff {
    /// Into P(x, u), after the weights, as eq. 3 has it.
    OnTop,
    /// Into S before it is normalised, as P23 has it.
    InSafety,
    /// Into P(x, u) with the sign reversed.
    OnTopReversed,
}

/// How often the goal's payoff is received.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum GoalPayoff {
    /// Once, and the trial ends: V(goal) = payoff.
    Once,
    /// In every period at the goal, which is a cell like any other (eq. 2 taken literally).
    EveryPeriod,
    /// In every period, and the goal is never left: V(goal) = γ payoff / (1 − γ).
    ForEver,
}

/// What happens to hops that would leave the map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Edge {
    /// A hop aimed outside is impossible; a slip outside stays in the cell.
    Dropped,
    /// Every hop outside stays in the cell.
    Stays,
    /// Every hop outside ends the trial without payoff.
    Ends,
}

/// Periods taken by a hop of two half hops on sand (heterogeneous ground, 0.5 m each).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum HalfHops {
    /// One period like any other.
    OnePeriod,
    /// Two periods, the first of them in the cell it leaves.
    TwoPeriods,
}

/// Cells spanned by a hop of 2.0 m from hard ground on the sandy map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LongHops {
    /// Two cells ahead; a slip leads two cells aside.
    TwoCells,
    /// Two cells ahead; a slip leads one cell aside.
    TwoCellsSlippingOne,
    /// One cell ahead: the length matters only in the collision check.
    OneCell,
}

/// One answer to every question that the paper leaves open.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Reading {
    /// Height of a single hill.
    pub hill_height: HillHeight,
    /// Which three of Table 2's eight are hollows, counted from 1; the caption gives their number only.
    pub hollows: [u8; 3],
    /// The sandy map's sand lies below this share of a hill's height ("most of this terrain").
    pub sand_level: f64,
    /// Cell that determines the payoff.
    pub payoff_at: PayoffCell,
    /// Interval that safety S is normalised to.
    pub safety_span: Span,
    /// Interval that information I is normalised to.
    pub information_span: Span,
    /// Term that the payoff of sand belongs to.
    pub sand_payoff: SandPayoff,
    /// How often the goal's payoff is received.
    pub goal_payoff: GoalPayoff,
    /// Weight of P23's distance penalty D; 0 is eq. 3 as printed.
    pub distance_weight: f64,
    /// What happens at the edge of the map.
    pub edge: Edge,
    /// Periods of two half hops on sand.
    pub half_hops: HalfHops,
    /// Cells spanned by hops of 2.0 m.
    pub long_hops: LongHops,
    /// Discount γ of eq. 2, above 0 and below 1.
    pub discount: f64,
    /// Algorithm 1 stops once no value changes by more than this in a sweep.
    pub tolerance: f64,
}

/// The reading of P22: the one that reproduces most of the paper's claims among those searched.
///
/// Found by `hopper known search`; `docs/known-terrain.md` explains how, and what does not reproduce.
pub const P22: Reading = Reading {
    hill_height: HillHeight::Metre,
    hollows: [6, 7, 8],
    sand_level: 0.2,
    payoff_at: PayoffCell::Departure,
    safety_span: Span::Cost,
    information_span: Span::Gain,
    sand_payoff: SandPayoff::OnTop,
    goal_payoff: GoalPayoff::EveryPeriod,
    distance_weight: 0.0,
    edge: Edge::Ends,
    half_hops: HalfHops::TwoPeriods,
    long_hops: LongHops::TwoCells,
    discount: 0.95,
    tolerance: 1e-2,
};

/// A question that the paper leaves open, with the answers to try.
#[derive(Clone, Debug)]
pub struct Question {
    /// Name of the field of [`Reading`].
    pub field: &'static str,
    /// One reading for each answer, equal to the original in all other fields.
    pub answers: Vec<Reading>,
}

impl Reading {
    /// Every question, with each answer substituted in this reading.
    #[must_use]
    pub fn questions(&self) -> Vec<Question> {
        let base = *self;
        macro_rules! question {
            ($field:ident, $answers:expr) => {
                Question {
                    field: stringify!($field),
                    answers: $answers.into_iter().map(|$field| Reading { $field, ..base }).collect(),
                }
            };
        }
        vec![
            question!(hill_height, [HillHeight::Printed, HillHeight::WithoutDeterminant, HillHeight::Metre]),
            question!(hollows, threes_of_eight()),
            question!(sand_level, [0.2, 0.4, 0.6, 0.8]),
            question!(payoff_at, [PayoffCell::Departure, PayoffCell::Arrival]),
            question!(safety_span, [Span::Gain, Span::Cost, Span::Both]),
            question!(information_span, [Span::Gain, Span::Cost, Span::Both]),
            question!(sand_payoff, [SandPayoff::OnTop, SandPayoff::InSafety, SandPayoff::OnTopReversed]),
            question!(goal_payoff, [GoalPayoff::Once, GoalPayoff::EveryPeriod, GoalPayoff::ForEver]),
            question!(distance_weight, [0.0, 1.0]),
            question!(edge, [Edge::Dropped, Edge::Stays, Edge::Ends]),
            question!(half_hops, [HalfHops::OnePeriod, HalfHops::TwoPeriods]),
            question!(long_hops, [LongHops::TwoCells, LongHops::TwoCellsSlippingOne, LongHops::OneCell]),
            question!(discount, [0.8, 0.85, 0.9, 0.91, 0.92, 0.93, 0.94, 0.95, 0.96, 0.97, 0.98, 0.99]),
            question!(tolerance, [1e-6, 1e-3, 1e-2, 1e-1, 1.0]),
        ]
    }
}

/// The 56 ways to choose three of Table 2's eight, the last three first.
fn threes_of_eight() -> Vec<[u8; 3]> {
    let mut threes = Vec::new();
    for first in (1..=6).rev() {
        for second in (first + 1..=7).rev() {
            for third in (second + 1..=8).rev() {
                threes.push([first, second, third]);
            }
        }
    }
    threes
}
