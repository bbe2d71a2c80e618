//! The Markov decision process of a map under a reading.
//!
//! Every cell has the hops that are possible there, each with its four landings and the four terms of its expected
//! payoff r = w1·S + w2·I + P + G: normalised safety and information; sand and distance; the goal.

use contract::{Branch, Direction, MotionParameters, Range, Soil};
use motion::{Launch, Transition, collision_m, vertical_transition};
use serde::Serialize;

use crate::{Edge, GoalPayoff, HalfHops, KnownMap, PayoffCell, Reading, SandPayoff, Weights};

/// Surface gravity of Mars in the paper, m/s².
const GRAVITY_MPS2: f64 = 3.72;
/// Launch angle of a hop, radians: 45°.
const FLAT_RAD: f64 = std::f64::consts::FRAC_PI_4;
/// Launch angle of a vertical hop, radians: 80°.
const STEEP_RAD: f64 = 80.0 * std::f64::consts::PI / 180.0;
/// Slope at which a hop no longer makes way, radians: 30°.
const SLOPE_LIMIT_RAD: f64 = std::f64::consts::FRAC_PI_6;
/// Payoff P of a cell of sand.
const SAND_PAYOFF: f64 = -0.5;

/// A possible action of the hopper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Hop {
    /// A hop at 45°.
    Forward(Direction),
    /// The vertical hop at 80°, where the one at 45° would collide.
    Up(Direction),
}

impl Hop {
    /// Direction of the intended landing.
    #[must_use]
    pub fn direction(self) -> Direction {
        match self {
            Hop::Forward(direction) | Hop::Up(direction) => direction,
        }
    }

    /// Whether it is a vertical hop.
    #[must_use]
    pub fn is_up(self) -> bool {
        matches!(self, Hop::Up(_))
    }
}

/// One possible hop of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// Direction and kind of the hop.
    pub hop: Hop,
    /// Probabilities of its branches, with slope and rise taken into account.
    pub scatter: Transition,
    /// Terms of the expected payoff: factors of w1, of w2, of 1, and of the goal's payoff.
    pub terms: [f64; 4],
}

/// Where a branch of a hop ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landing {
    /// Probability of the branch, discounted once more if the hop takes two periods.
    pub factor: f64,
    /// Index of the cell; the number of cells stands for the end of the trial beyond the edge.
    pub index: usize,
}

/// The branches of a hop, in the order that draws select them.
pub(crate) const BRANCHES: [Branch; 4] = [Branch::Intended, Branch::Stayed, Branch::Left, Branch::Right];

/// The Markov decision process of one map.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Every possible hop, cell by cell in index order, each in the order north, east, south, west.
    pub choices: Vec<Choice>,
    /// The landings of each choice: intended, stayed, left, right.
    pub landings: Vec<[Landing; 4]>,
    /// Discount γ of one period.
    pub discount: f64,
    /// Index of the goal if the trial ends there with a fixed value; `None` if it is a cell like any other.
    pub pinned_goal: Option<usize>,
    /// Index of the first choice of each cell, and the number of choices at the end.
    first: Vec<usize>,
    goal_payoff: GoalPayoff,
}

/// A hop that passed the collision check, before payoffs are normalised.
struct Offer {
    hop: Hop,
    scatter: Transition,
    /// |Δh| of a vertical hop, metres, which replaces the slope in S; `None` for other hops.
    climb_m: Option<f64>,
    /// Index of the end of each branch; the number of cells stands for beyond the edge.
    ends: [usize; 4],
}

impl Model {
    /// The model of `map` under `reading`.
    #[must_use]
    pub fn new(map: &KnownMap, reading: &Reading) -> Self {
        let goal = map.grid.index(map.goal).expect("a goal on the map");
        let pinned_goal = (reading.goal_payoff != GoalPayoff::EveryPeriod).then_some(goal);
        let offers: Vec<Vec<Offer>> = (0..map.grid.cells())
            .map(|index| if pinned_goal == Some(index) { Vec::new() } else { offers(map, reading, index) })
            .collect();
        let payoffs = Payoffs::new(map, reading, goal, pinned_goal, &offers);
        let mut model = Self {
            choices: Vec::new(),
            landings: Vec::new(),
            discount: reading.discount,
            pinned_goal,
            first: Vec::with_capacity(offers.len() + 1),
            goal_payoff: reading.goal_payoff,
        };
        for (index, offers) in offers.iter().enumerate() {
            model.first.push(model.choices.len());
            let hop = map.hop(map.ground[index].soil);
            let twice = hop.motion.flights > 1 && reading.half_hops == HalfHops::TwoPeriods;
            for offer in offers {
                let mut terms = payoffs.of(index, offer);
                if twice {
                    let stay = payoffs.standing(index);
                    terms = std::array::from_fn(|n| stay[n] + reading.discount * terms[n]);
                }
                let discount = if twice { reading.discount } else { 1.0 };
                model.choices.push(Choice { hop: offer.hop, scatter: offer.scatter, terms });
                model.landings.push(std::array::from_fn(|n| Landing {
                    factor: discount * offer.scatter.probability(BRANCHES[n]),
                    index: offer.ends[n],
                }));
            }
        }
        model.first.push(model.choices.len());
        model
    }

    /// Number of cells of the map.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.first.len() - 1
    }

    /// Range of the choices of a cell in [`Model::choices`].
    #[must_use]
    pub fn choices_of(&self, cell: usize) -> std::ops::Range<usize> {
        self.first[cell]..self.first[cell + 1]
    }

    /// Expected payoff of every choice under `weights`.
    #[must_use]
    pub fn payoffs(&self, weights: &Weights) -> Vec<f64> {
        let factors = [weights.safety, weights.information, 1.0, weights.goal];
        let payoff =
            |choice: &Choice| choice.terms.iter().zip(factors).map(|(term, factor)| term * factor).sum();
        self.choices.iter().map(payoff).collect()
    }

    /// Value of a goal where the trial ends; 0 if it does not end there.
    #[must_use]
    pub fn goal_value(&self, weights: &Weights) -> f64 {
        match self.goal_payoff {
            GoalPayoff::Once => weights.goal,
            GoalPayoff::ForEver => self.discount * weights.goal / (1.0 - self.discount),
            GoalPayoff::EveryPeriod => 0.0,
        }
    }
}

/// The possible hops of a cell: at 45° if the flight is free of collisions, else the vertical hop if it clears the
/// step.
fn offers(map: &KnownMap, reading: &Reading, index: usize) -> Vec<Offer> {
    let from = map.grid.cell(index);
    let ground = &map.ground[index];
    let hop = map.hop(ground.soil);
    let scatters = motion::transitions(&parameters(map), ground);
    let launch = Launch::reaching(hop.flight_m, FLAT_RAD, GRAVITY_MPS2);
    let clear = |direction| collision_m(&launch, &map.profile(from, direction, hop.cells)).is_none();
    let end = |direction: Direction, cells: u32| map.grid.index(KnownMap::beyond(from, direction, cells));
    let outside = match reading.edge {
        Edge::Ends => map.grid.cells(),
        Edge::Dropped | Edge::Stays => index,
    };
    // A slip that would collide stays in the cell.
    let aside = |direction| match clear(direction) {
        true => end(direction, hop.slip_cells).unwrap_or(outside),
        false => index,
    };
    let offer = |direction: Direction| {
        let target = end(direction, hop.cells);
        if target.is_none() && reading.edge == Edge::Dropped {
            return None;
        }
        let ends = [target.unwrap_or(outside), index, aside(direction.left()), aside(direction.right())];
        if clear(direction) {
            let scatter = scatters[direction as usize];
            return Some(Offer { hop: Hop::Forward(direction), scatter, climb_m: None, ends });
        }
        let rise_m = map.ground[target?].height_m - ground.height_m;
        let steep = launch.at(STEEP_RAD);
        if collision_m(&steep, &map.profile(from, direction, hop.cells)).is_some() {
            return None;
        }
        let scatter = vertical_transition(&hop.motion, rise_m, steep.apex_height_m())?;
        Some(Offer { hop: Hop::Up(direction), scatter, climb_m: Some(rise_m.abs()), ends })
    };
    Direction::ALL.into_iter().filter_map(offer).collect()
}

fn parameters(map: &KnownMap) -> MotionParameters {
    MotionParameters {
        hard: map.hard.motion,
        sand: map.sand.motion,
        slope_limit_rad: SLOPE_LIMIT_RAD,
        launch_angle_rad: FLAT_RAD,
        gravity_mps2: GRAVITY_MPS2,
        vertical: false,
        table: 0,
    }
}

/// Computes the terms of the payoff.
struct Payoffs<'a> {
    map: &'a KnownMap,
    reading: &'a Reading,
    goal: usize,
    pinned: bool,
    safety: Range,
    information: Range,
}

impl<'a> Payoffs<'a> {
    fn new(
        map: &'a KnownMap,
        reading: &'a Reading,
        goal: usize,
        pinned_goal: Option<usize>,
        offers: &[Vec<Offer>],
    ) -> Self {
        let nothing = Range { min: 0.0, max: 0.0 };
        let mut payoffs =
            Self { map, reading, goal, pinned: pinned_goal.is_some(), safety: nothing, information: nothing };
        let slopes = (0..map.ground.len()).map(|index| payoffs.raw_safety(index, None));
        let climbs = offers.iter().enumerate().flat_map(|(index, offers)| {
            offers.iter().filter_map(move |offer| offer.climb_m.map(|climb_m| (index, climb_m)))
        });
        let climbs = climbs.map(|(index, climb_m)| payoffs.raw_safety(index, Some(climb_m)));
        let safety = range(slopes.chain(climbs));
        let information = range(map.ground.iter().map(|ground| ground.height_m));
        payoffs.safety = safety;
        payoffs.information = information;
        payoffs
    }

    /// S before it is normalised: −|∇h|, or −Δh of a vertical hop (eqs. 5 and 10).
    fn raw_safety(&self, index: usize, climb_m: Option<f64>) -> f64 {
        let ground = &self.map.ground[index];
        let on_sand = ground.soil == Soil::Sand && self.reading.sand_payoff == SandPayoff::InSafety;
        -climb_m.unwrap_or_else(|| ground.steepness()) + if on_sand { SAND_PAYOFF } else { 0.0 }
    }

    /// The terms of one period in cell `index`; `climb_m` is |Δh| of a vertical hop.
    fn terms(&self, index: usize, climb_m: Option<f64>) -> [f64; 4] {
        let ground = &self.map.ground[index];
        let safety = self.reading.safety_span.at(self.safety.normalise(self.raw_safety(index, climb_m)));
        let information = self.reading.information_span.at(self.information.normalise(ground.height_m));
        let sand = match (ground.soil, self.reading.sand_payoff) {
            (Soil::Sand, SandPayoff::OnTop) => SAND_PAYOFF,
            (Soil::Sand, SandPayoff::OnTopReversed) => -SAND_PAYOFF,
            _ => 0.0,
        };
        let cell = self.map.grid.cell(index);
        let distance = -cell.distance_cells(self.map.goal) / self.map.start.distance_cells(self.map.goal);
        let goal = if index == self.goal { 1.0 } else { 0.0 };
        [safety, information, sand + self.reading.distance_weight * distance, goal]
    }

    fn standing(&self, index: usize) -> [f64; 4] {
        self.terms(index, None)
    }

    fn of(&self, index: usize, offer: &Offer) -> [f64; 4] {
        if self.reading.payoff_at == PayoffCell::Departure {
            return self.terms(index, offer.climb_m);
        }
        let mut sum = [0.0; 4];
        for (branch, end) in BRANCHES.into_iter().zip(offer.ends) {
            // Nothing pays beyond the edge; a goal that ends the trial pays through its value.
            if end < self.map.ground.len() && !(self.pinned && end == self.goal) {
                let terms = self.terms(end, offer.climb_m);
                let probability = offer.scatter.probability(branch);
                sum = std::array::from_fn(|n| sum[n] + probability * terms[n]);
            }
        }
        sum
    }
}

fn range(values: impl Iterator<Item = f64>) -> Range {
    values.fold(Range { min: f64::INFINITY, max: f64::NEG_INFINITY }, |range, value| Range {
        min: range.min.min(value),
        max: range.max.max(value),
    })
}
