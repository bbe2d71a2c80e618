//! Why a hop: how each of the four hops from a cell may end, what its landing pays, and what it is worth under the
//! newest policy.
//!
//! Computed when somebody asks, from the observed map and the policy, so that no planner sends it and no decision waits
//! for it. The value of a hop is the right-hand side of Bellman's equation, as `planner/src/mdp/model.rs` has it; a
//! test compares the two.

use contract::map::belief::Belief;
use contract::map::payoff::LandingPayoff;
use contract::{
    Account, Action, Cell, Decision, Direction, Ground, Leg, Name, ObservedMap, Policy, PolicyCell, Profile,
    RobotId, Soil, UnseenGround, Vetoed,
};
use motion::{Transition, offers};

use super::{History, RunHistory};

/// How far the value of being lost lies below the worst payoff for ever, in units of payoff; as in the planner's model.
const LOSS: f64 = -300.0;

/// What is known about the four hops from one cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Reason {
    /// Where the hopper stood when the action was chosen.
    pub cell: Cell,
    /// Its ground; `None` if nobody has seen it, which planners assume flat.
    pub ground: Option<Ground>,
    /// The policy that the values are taken from, of the planner that decided: its name, the decision it was made for, and its
    /// action here.
    pub policy: Option<(Name, Decision, Action)>,
    /// What the guard vetoed here at the decision that is due; empty elsewhere.
    pub vetoed: Vetoed,
    /// The hops north, east, south, west.
    pub hops: [HopReason; 4],
}

/// What is known about one hop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HopReason {
    /// Where it aims.
    pub direction: Direction,
    /// How it may end.
    pub chances: Transition,
    /// Terms w1·S, w2·I and w3·D of landing as aimed, in units of payoff; `None` off the map, on ground known to be
    /// impassable, and at the goal, which has a payoff of its own.
    pub terms: Option<[f64; 3]>,
    /// Where landing as aimed ends the mission or the leg.
    pub ends: Option<Ends>,
    /// Expected discounted payoff of the hop and what follows; `None` without a policy, where the plan is another process
    /// (profile `paper-2022`, plans over seen ground alone), and while treasures are planned for, whose values depend on which are left.
    pub value: Option<f64>,
}

/// What a landing ends in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ends {
    /// The goal in force.
    AtGoal,
    /// Beyond the edge of the map.
    OffMap,
    /// Ground seen to be impassable.
    Impassable,
}

impl History {
    /// The reason for a hop from `cell` on the way that is flown when decision `at` is due; `None` outside the grid, and
    /// where the mission has no hopper.
    #[must_use]
    pub fn reason(&self, cell: Cell, at: Decision) -> Option<Reason> {
        let run = self.run.as_ref()?;
        if !run.brief.grid.contains(cell) || run.brief.account != Account::Hopper {
            return None;
        }
        let map = run.replica.map()?;
        let before = at.0.checked_sub(1).and_then(|before| run.hops.get(Decision(before)));
        let leg = run.brief.leg_of(RobotId(0), before.map_or(0, |hop| hop.visits))?;
        let planner = run.planner_of(RobotId(0), at);
        Some(Surroundings::new(run, &leg, map, planner).reason(cell, run))
    }
}

/// What the values around a cell are computed from.
struct Surroundings<'a> {
    leg: &'a Leg,
    map: &'a ObservedMap,
    belief: Belief<'a>,
    payoff: LandingPayoff<'a>,
    policy: Option<&'a Policy>,
}

impl<'a> Surroundings<'a> {
    fn new(run: &'a RunHistory, leg: &'a Leg, map: &'a ObservedMap, planner: Option<Name>) -> Self {
        let fits = |policy: &&Policy| {
            policy.cells.len() == leg.grid.cells() && planner.is_none_or(|planner| policy.planner == planner)
        };
        Self {
            leg,
            map,
            belief: Belief::new(leg, map),
            payoff: LandingPayoff::new(leg),
            policy: run.policy.1.as_ref().filter(fits),
        }
    }

    fn reason(&self, cell: Cell, run: &RunHistory) -> Reason {
        let is_here = run.state.as_ref().filter(|state| state.pose.cell == cell);
        let ground = self.belief.ground(cell);
        let height_m = |cell| self.map.ground(cell).map(|ground| ground.height_m);
        let offers = offers(&self.leg.motion, &self.leg.grid, (cell, ground), height_m);
        // A hop that is not offered stays.
        let stays = Transition { intended: 0.0, stayed: 1.0, left: 0.0, right: 0.0 };
        let chances = offers.map(|offer| offer.map_or(stays, |offer| offer.scatter()));
        let values = self.values(cell, ground, &chances);
        let hops = Direction::ALL.map(|direction| {
            let to = self.leg.grid.hop(cell, direction);
            let ends = self.ends(to);
            HopReason {
                direction,
                chances: chances[direction as usize],
                terms: ends.is_none().then(|| self.payoff.terms(to, self.belief.ground(to))),
                ends,
                value: values.map(|values| values[direction as usize]),
            }
        });
        Reason {
            cell,
            ground: self.map.ground(cell).copied(),
            policy: self
                .at(cell)
                .zip(self.policy)
                .map(|(at, policy)| (policy.planner, policy.decision, at.action)),
            vetoed: is_here.map_or(Vetoed::NONE, |state| state.vetoed),
            hops,
        }
    }

    /// The policy's cell, where it has one: on the lattice of the goal.
    fn at(&self, cell: Cell) -> Option<&'a PolicyCell> {
        if !self.leg.grid.on_same_lattice(cell, self.leg.goal) {
            return None;
        }
        self.policy?.cells.get(self.leg.grid.index(cell)?)
    }

    fn ends(&self, cell: Cell) -> Option<Ends> {
        if !self.leg.grid.contains(cell) {
            return Some(Ends::OffMap);
        }
        let is_impassable = !self.belief.ground(cell).passable;
        (cell == self.leg.goal).then_some(Ends::AtGoal).or_else(|| is_impassable.then_some(Ends::Impassable))
    }

    /// The values of the four hops in the order of [`Direction::ALL`].
    fn values(&self, cell: Cell, ground: &Ground, chances: &[Transition; 4]) -> Option<[f64; 4]> {
        let has_treasures = self.leg.priors.treasures > 0 || !self.map.treasures().is_empty();
        // In profile paper-2022 a period pays for the cell that it begins on; over seen ground alone, unseen cells end the plan.
        let is_other =
            self.leg.profile == Profile::Paper2022 || self.leg.reading.unseen != UnseenGround::Flat;
        if has_treasures || is_other || self.ends(cell).is_some() {
            return None;
        }
        let here = self.payoff.of(cell, ground) + self.at(cell)?.value;
        let mut around = [0.0; 4];
        for direction in Direction::ALL {
            around[direction as usize] = self.afterstate(self.leg.grid.hop(cell, direction), here)?;
        }
        let discount = self.leg.payoff.discount;
        Some(Direction::ALL.map(|direction| {
            let Transition { intended, stayed, left, right } = chances[direction as usize];
            let next = intended * around[direction as usize]
                + stayed * here
                + left * around[direction.left() as usize]
                + right * around[direction.right() as usize];
            match ground.soil {
                Soil::Hard => discount * next,
                // Of the two periods of a hop from sand the first is spent on the cell of departure.
                Soil::Sand => discount * (self.payoff.of(cell, ground) + discount * next),
            }
        }))
    }

    /// What landing on `cell` pays and is worth onward; `here` is that of staying.
    fn afterstate(&self, cell: Cell, here: f64) -> Option<f64> {
        match self.ends(cell) {
            None => Some(self.payoff.of(cell, self.belief.ground(cell)) + self.at(cell)?.value),
            Some(Ends::AtGoal) => Some(self.leg.payoff.goal),
            Some(Ends::OffMap) if self.staying_off_map() => Some(here),
            Some(Ends::OffMap | Ends::Impassable) => Some(self.loss()),
        }
    }

    /// Whether a hop off the map counts as staying, in the planner's model.
    fn staying_off_map(&self) -> bool {
        self.leg.profile == Profile::Paper2023 && self.leg.reading.leaving.is_none()
    }

    /// The afterstate value of being lost.
    fn loss(&self) -> f64 {
        if let Some(leaving) = self.leg.reading.leaving {
            return leaving;
        }
        let nodes = self.leg.grid.iter().filter(|&cell| self.leg.grid.on_same_lattice(cell, self.leg.goal));
        let grounds =
            nodes.map(|cell| (cell, self.belief.ground(cell))).filter(|(_, ground)| ground.passable);
        let worst = grounds.map(|(cell, ground)| self.payoff.of(cell, ground)).fold(0.0, f64::min);
        LOSS + worst / (1.0 - self.leg.payoff.discount)
    }
}
