//! Why a hop: how each of the four hops from a cell may end, what its landing pays, and what it is worth under the
//! newest policy.
//!
//! Computed when somebody asks, from the observed map and the policy, so that no planner sends it and no decision waits
//! for it. The value of a hop is the right-hand side of Bellman's equation, as `planner/src/mdp/model.rs` has it; a
//! test compares the two.

use std::cell::OnceCell;

use contract::map::belief::Belief;
use contract::map::payoff::LandingPayoff;
use contract::{
    Account, Action, Cell, Decision, Direction, Ground, Leg, MotionRow, MotionTable, Name, ObservedMap,
    Policy, PolicyCell, Profile, RobotId, Soil, UnseenGround, Vetoed,
};
use motion::{Transition, offers, slope_classes, table_landing};

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
    /// How it may end, as planners of the mission believe.
    pub chances: Chances,
    /// Terms w1·S, w2·I and w3·D of landing as aimed, in units of payoff; `None` off the map, on ground known to be
    /// impassable, and at the goal, which has a payoff of its own.
    pub terms: Option<[f64; 3]>,
    /// Where landing as aimed ends the mission or the leg.
    pub ends: Option<Ends>,
    /// Expected discounted payoff of the hop and what follows; `None` without a policy, where the plan is another process
    /// (profile `paper-2022`, plans over seen ground alone), and while treasures are planned for, whose values depend on which are left.
    pub value: Option<f64>,
}

/// How a hop may end: probabilities that add up to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Chances {
    /// On the cell it is aimed at.
    pub aimed: f64,
    /// On the cell of departure.
    pub stayed: f64,
    /// One hop to the left of the cell of departure.
    pub left: f64,
    /// One hop to the right of the cell of departure.
    pub right: f64,
    /// On another cell, as only a motion table has it.
    pub elsewhere: f64,
    /// Nowhere, as only a motion table has it: the hopper rolls away.
    pub lost: f64,
}

impl From<Transition> for Chances {
    fn from(Transition { intended, stayed, left, right }: Transition) -> Self {
        Self { aimed: intended, stayed, left, right, ..Self::default() }
    }
}

impl From<&MotionRow> for Chances {
    fn from(row: &MotionRow) -> Self {
        let mut chances = Self::default();
        for landing in row.landings() {
            let place = match (landing.forward, landing.left) {
                (1, 0) => &mut chances.aimed,
                (0, 0) => &mut chances.stayed,
                (0, 1) => &mut chances.left,
                (0, -1) => &mut chances.right,
                _ => &mut chances.elsewhere,
            };
            *place += landing.probability;
        }
        let Self { aimed, stayed, left, right, elsewhere, .. } = chances;
        // Probabilities may add up to a little more than 1.
        Self { lost: (1.0 - (aimed + stayed + left + right + elsewhere)).max(0.0), ..chances }
    }
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
    /// The reason for a hop from `cell` on the way that is flown when decision `at` is due; `None` outside the grid, where the
    /// mission has no hopper, and until the motion table is known that its planners believe.
    #[must_use]
    pub fn reason(&self, cell: Cell, at: Decision) -> Option<Reason> {
        let run = self.run.as_ref()?;
        if !run.brief.grid.contains(cell) || run.brief.account != Account::Hopper {
            return None;
        }
        let map = run.replica.map()?;
        let before = at.0.checked_sub(1).and_then(|before| run.hops.get(Decision(before)));
        let leg = run.brief.leg_of(RobotId(0), before.map_or(0, |hop| hop.visits))?;
        // Of the decision that is due it is the one in command, if there is one yet.
        let in_command = run.state.filter(|state| state.leader.term.0 > 0).map(|state| state.leader.planner);
        let planner = run.planner_of(RobotId(0), at).or(in_command);
        if run.table.is_missing() {
            return None;
        }
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
    /// Where planners of the mission believe hops to end; `None` where it is by the law.
    table: Option<&'a MotionTable>,
    /// What being lost is worth, once it was needed: it takes a look at every cell.
    loss: OnceCell<f64>,
}

/// How the four hops from a cell may end, in the order of [`Direction::ALL`].
enum Endings<'a> {
    Law([Transition; 4]),
    Table([&'a MotionRow; 4]),
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
            table: run.table.table(),
            loss: OnceCell::new(),
        }
    }

    /// How the hops from a cell with that ground may end.
    fn endings(&self, cell: Cell, ground: &Ground) -> Endings<'a> {
        if let Some(table) = self.table {
            let classes = slope_classes(&self.leg.grid, (cell, ground), |cell| self.map.ground(cell));
            return Endings::Table(classes.map(|class| &table.rows()[class]));
        }
        let height_m = |cell| self.map.ground(cell).map(|ground| ground.height_m);
        let offers = offers(&self.leg.motion, &self.leg.grid, (cell, ground), height_m);
        // A hop that is not offered stays.
        let stays = Transition { intended: 0.0, stayed: 1.0, left: 0.0, right: 0.0 };
        Endings::Law(offers.map(|offer| offer.map_or(stays, |offer| offer.scatter())))
    }

    fn reason(&self, cell: Cell, run: &RunHistory) -> Reason {
        let is_here = run.state.as_ref().filter(|state| state.pose.cell == cell);
        let ground = self.belief.ground(cell);
        let endings = self.endings(cell, ground);
        let chances = match &endings {
            Endings::Law(chances) => chances.map(Chances::from),
            Endings::Table(rows) => rows.map(Chances::from),
        };
        let values = self.values(cell, ground, &endings);
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
    fn values(&self, cell: Cell, ground: &Ground, endings: &Endings<'_>) -> Option<[f64; 4]> {
        let has_treasures = self.leg.priors.treasures > 0 || !self.map.treasures().is_empty();
        // In profile paper-2022 a period pays for the cell that it begins on; over seen ground alone, unseen cells end the plan.
        let is_other =
            self.leg.profile == Profile::Paper2022 || self.leg.reading.unseen != UnseenGround::Flat;
        if has_treasures || is_other || self.ends(cell).is_some() {
            return None;
        }
        let here = self.payoff.of(cell, ground) + self.at(cell)?.value;
        let mut values = [0.0; 4];
        for (value, direction) in values.iter_mut().zip(Direction::ALL) {
            let next = match endings {
                Endings::Law(chances) => {
                    self.next_by_law(cell, here, direction, &chances[direction as usize])?
                }
                Endings::Table(rows) => {
                    self.next_by_table(cell, here, direction, rows[direction as usize])?
                }
            };
            *value = match ground.soil {
                Soil::Hard => self.leg.payoff.discount * next,
                // Of the two periods of a hop from sand the first is spent on the cell of departure.
                Soil::Sand => {
                    let discount = self.leg.payoff.discount;
                    discount * (self.payoff.of(cell, ground) + discount * next)
                }
            };
        }
        Some(values)
    }

    /// What is expected of where a hop may end under the law.
    fn next_by_law(&self, cell: Cell, here: f64, direction: Direction, chances: &Transition) -> Option<f64> {
        let at = |towards| self.afterstate(self.leg.grid.hop(cell, towards), here);
        let Transition { intended, stayed, left, right } = chances;
        Some(
            intended * at(direction)?
                + stayed * here
                + left * at(direction.left())?
                + right * at(direction.right())?,
        )
    }

    /// What is expected of where a hop may end by a row of the table; what that leaves of 1 is lost.
    fn next_by_table(&self, cell: Cell, here: f64, direction: Direction, row: &MotionRow) -> Option<f64> {
        let mut next = Chances::from(row).lost * self.loss();
        for landing in row.landings() {
            let to = table_landing(&self.leg.grid, cell, direction, landing);
            next += landing.probability * if to == cell { here } else { self.afterstate(to, here)? };
        }
        Some(next)
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
        *self.loss.get_or_init(|| {
            if let Some(leaving) = self.leg.reading.leaving {
                return leaving;
            }
            let grid = &self.leg.grid;
            let nodes = grid.iter().filter(|&cell| grid.on_same_lattice(cell, self.leg.goal));
            let grounds =
                nodes.map(|cell| (cell, self.belief.ground(cell))).filter(|(_, ground)| ground.passable);
            let worst = grounds.map(|(cell, ground)| self.payoff.of(cell, ground)).fold(0.0, f64::min);
            LOSS + worst / (1.0 - self.leg.payoff.discount)
        })
    }
}
