//! A hopper as it should be. Where a hop leads is drawn here, for its robot and decision; how it flies is asked of the engine
//! `motion`.

use contract::{
    Account, Action, Branch, Cell, Decision, Direction, Flight, Ground, Hopper, Origin, Outcome, RobotId,
    Vetoed,
};
use hopper_sim::Mission;
use motion::{Domain, Draw};
use scenario::Dynamics;

use super::Body;
use crate::oracle::Oracle;
use crate::oracle::actor::Arrival;
use crate::oracle::collision;
use crate::oracle::contact::Hopping;

impl Body for Hopper {
    fn hops(&self) -> bool {
        true
    }

    /// A hopper whose steps alone are counted has nobody to wait for.
    fn may(&self, oracle: &Oracle, _number: usize, action: Action) -> bool {
        match action {
            Action::Wait => oracle.mission.brief.account != Account::Hopper,
            Action::Up(_) => self.motion.vertical,
            _ => matches!(action, Action::Hold | Action::Hop(_)),
        }
    }

    fn is_blocked(&self, oracle: &Oracle, number: usize, action: Action) -> bool {
        let Some(direction) = action.hop() else { return false };
        let aim = oracle.mission.brief.grid.hop(oracle.turns.actors[number].cell, direction);
        oracle.is_occupied(number, aim)
    }

    /// It ends where it began if another robot is where it would end.
    fn act(&self, oracle: &Oracle, number: usize, decision: Decision, action: Action) -> Arrival {
        let actor = &oracle.turns.actors[number];
        let from = actor.cell;
        let mission = &*oracle.mission;
        let Mission { brief, terrain, seed, .. } = mission;
        if actor.fails() {
            return Arrival::stays(actor, Branch::Stranded, Flight::default());
        }
        let (Some(direction), Some(ground)) = (action.hop(), terrain.ground(from)) else {
            return Arrival::stays(actor, Branch::Held, Flight::default());
        };
        let robot = RobotId(number as u16);
        if let Dynamics::Contact(rules) = &mission.dynamics {
            let told = actor.told.as_ref();
            let hopping = Hopping { mission, rules, robot, hopper: self, decision, from, told, direction };
            let hop = hopping.hop();
            let is_taken = |cell| oracle.is_occupied(number, cell);
            let (outcome, detail) = if is_taken(hop.0.to) { hopping.displaced(hop, is_taken) } else { hop };
            return Arrival { outcome, at: actor.at, detail: Some(detail) };
        }
        let uniform = Draw::new(*seed, Domain::Motion, robot, decision).uniform();
        let is_up = matches!(action, Action::Up(_));
        let is_checked = matches!(mission.dynamics, Dynamics::Collision(_));
        let (drawn, collides) = if is_up {
            collision::vertical(self, mission, from, direction, uniform)
        } else {
            let drawn = motion::transition(&self.motion, ground, direction).branch(uniform);
            (drawn, is_checked && collision::collides(self, mission, from, direction, drawn))
        };
        let branch = if collides { Branch::Stayed } else { drawn };
        let aim = terrain.ground(brief.grid.hop(from, direction));
        let rise_m = aim.map_or(0.0, |aim| aim.height_m - ground.height_m);
        let end = motion::landing(&brief.grid, from, direction, branch);
        let to = if oracle.is_occupied(number, end) { from } else { end };
        let flight = motion::flight(&self.motion, &brief.grid, ground.soil, rise_m);
        let outcome = Outcome { branch, from, to, flight };
        let law = Arrival { outcome, at: actor.at, detail: None };
        if is_checked { collision::told(self, mission, (direction, is_up), collides, law) } else { law }
    }

    fn dangerous(&self, oracle: &Oracle, number: usize, known: &[Option<Ground>]) -> Vetoed {
        let hazard_max = oracle.mission.brief.guard.hazard_max;
        let hazard = |action: &Action| hazard(self, oracle, number, known, *action);
        let from = oracle.turns.actors[number].cell;
        let is_offered = |action: &Action| match action.hop() {
            Some(direction) => offer(self, oracle, from, known, direction) == Some(*action),
            None => true,
        };
        // Whoever has not the vertical hop is not told that it is dangerous: its command is malformed.
        let may = |action: &Action| self.may(oracle, number, *action);
        let vetoed = Action::ALL.into_iter().filter(may);
        let vetoed = vetoed.filter(|action| !is_offered(action) || hazard(action) > hazard_max);
        vetoed.fold(Vetoed::NONE, Vetoed::with)
    }

    /// The hop that nothing speaks against and whose aim is nearest to its goal, of equals the first of north, east, south and west;
    /// the hopper that the mission is about may follow a policy.
    fn fallback(
        &self,
        oracle: &Oracle,
        number: usize,
        known: &[Option<Ground>],
        vetoed: Vetoed,
    ) -> Option<(Action, Origin)> {
        if oracle.mission.brief.account == Account::Hopper {
            return None;
        }
        let (grid, actor) = (oracle.mission.brief.grid, &oracle.turns.actors[number]);
        let (goal, at) = (actor.goal().cell(&grid, 0)?, actor.cell);
        let is_passable = |cell: Cell| {
            let index = grid.contains(cell).then(|| grid.index(cell)).flatten();
            index.is_some_and(|index| known[index].is_none_or(|ground| ground.passable))
        };
        let aim = |direction: &Direction| grid.hop(at, *direction);
        let hop = |direction: &Direction| {
            offer(self, oracle, at, known, *direction).unwrap_or(Action::Hop(*direction))
        };
        let is_open = |direction: &Direction| !vetoed.has(hop(direction)) && is_passable(aim(direction));
        let away = |direction: &Direction| {
            let aim = aim(direction);
            (aim.x - goal.x).pow(2) + (aim.y - goal.y).pow(2)
        };
        let nearest = Direction::ALL.into_iter().filter(is_open).min_by_key(away);
        let nearest = nearest.map(|direction| (hop(&direction), Origin::Greedy));
        Some(nearest.unwrap_or((Action::Hold, Origin::Hold)))
    }
}

/// The probability that `action` ends off the map or on ground known to be impassable, from the observed map alone: what anybody
/// could know who has seen what it has.
fn hazard(hopper: &Hopper, oracle: &Oracle, number: usize, known: &[Option<Ground>], action: Action) -> f64 {
    let (from, grid) = (oracle.turns.actors[number].cell, &oracle.mission.brief.grid);
    let known = |cell: Cell| known[grid.index(cell)?].as_ref();
    let (Some(direction), Some(ground)) = (action.hop(), known(from)) else { return 0.0 };
    let height_m = |cell| known(cell).map(|ground| ground.height_m);
    let offered = |direction| collision::offered(hopper, grid, (from, ground), direction, height_m);
    let scatter = motion::transition(&hopper.motion, ground, direction);
    let probability = |branch: Branch| match offered(direction) {
        Some((true, rise_m)) => collision::vertical_share(hopper, grid, ground.soil, rise_m, branch),
        _ => scatter.probability(branch),
    };
    // A slip into what is in the way stays.
    let slips = |branch: &Branch| match branch {
        Branch::Left => offered(direction.left()).is_some_and(|(is_up, _)| !is_up),
        Branch::Right => offered(direction.right()).is_some_and(|(is_up, _)| !is_up),
        _ => true,
    };
    let ruins = |branch: &Branch| {
        let to = motion::landing(grid, from, direction, *branch);
        !grid.contains(to) || known(to).is_some_and(|ground| !ground.passable)
    };
    Branch::ALL.into_iter().filter(slips).filter(ruins).map(probability).sum()
}

/// The action towards a direction that is offered from `from` on known ground, if one is.
fn offer(
    hopper: &Hopper,
    oracle: &Oracle,
    from: Cell,
    known: &[Option<Ground>],
    direction: Direction,
) -> Option<Action> {
    let grid = &oracle.mission.brief.grid;
    let known = |cell: Cell| known[grid.index(cell)?].as_ref();
    let Some(ground) = known(from) else { return Some(Action::Hop(direction)) };
    let height_m = |cell| known(cell).map(|ground| ground.height_m);
    let (is_up, _) = collision::offered(hopper, grid, (from, ground), direction, height_m)?;
    Some(if is_up { Action::Up(direction) } else { Action::Hop(direction) })
}
