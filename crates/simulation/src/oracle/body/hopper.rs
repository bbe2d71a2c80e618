//! A hopper as it should be. Where a hop leads is drawn here, for its robot and decision; how it flies is asked of the engine
//! `motion`.

use contract::{
    Account, Action, Branch, Cell, Decision, Detail, Direction, Flight, Ground, Hopper, MotionModel, Origin,
    Outcome, PathPoint, RobotId, Vetoed,
};
use hopper_sim::Mission;
use motion::{Domain, Draw};
use scenario::Dynamics;

use super::Body;
use crate::oracle::Oracle;
use crate::oracle::actor::Arrival;
use crate::oracle::contact::Hopping;

impl Body for Hopper {
    fn hops(&self) -> bool {
        true
    }

    /// A hopper whose steps alone are counted has nobody to wait for.
    fn may(&self, oracle: &Oracle, _number: usize, action: Action) -> bool {
        match action {
            Action::Wait => oracle.mission.brief.account != Account::Hopper,
            _ => matches!(action, Action::Hold | Action::Hop(_)),
        }
    }

    fn is_blocked(&self, oracle: &Oracle, number: usize, action: Action) -> bool {
        let Action::Hop(direction) = action else { return false };
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
        let (Action::Hop(direction), Some(ground)) = (action, terrain.ground(from)) else {
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
        let drawn = motion::transition(&self.motion, ground, direction).branch(uniform);
        let checks = matches!(mission.dynamics, Dynamics::Collision(_));
        let collides = checks && collides(self, mission, from, direction, drawn);
        let branch = if collides { Branch::Stayed } else { drawn };
        let aim = terrain.ground(brief.grid.hop(from, direction));
        let rise_m = aim.map_or(0.0, |aim| aim.height_m - ground.height_m);
        let end = motion::landing(&brief.grid, from, direction, branch);
        let to = if oracle.is_occupied(number, end) { from } else { end };
        let flight = motion::flight(&self.motion, &brief.grid, ground.soil, rise_m);
        let outcome = Outcome { branch, from, to, flight };
        if checks {
            return of_collision(
                self,
                mission,
                direction,
                collides,
                Arrival { outcome, at: actor.at, detail: None },
            );
        }
        Arrival { outcome, at: actor.at, detail: None }
    }

    fn dangerous(&self, oracle: &Oracle, number: usize, known: &[Option<Ground>]) -> Vetoed {
        let hazard_max = oracle.mission.brief.guard.hazard_max;
        let hazard = |action: &Action| hazard(self, oracle, number, known, *action);
        let hazards = Action::ALL.into_iter().filter(|action| hazard(action) > hazard_max);
        hazards.fold(Vetoed::NONE, Vetoed::with)
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
        let is_open =
            |direction: &Direction| !vetoed.has(Action::Hop(*direction)) && is_passable(aim(direction));
        let away = |direction: &Direction| {
            let aim = aim(direction);
            (aim.x - goal.x).pow(2) + (aim.y - goal.y).pow(2)
        };
        let nearest = Direction::ALL.into_iter().filter(is_open).min_by_key(away);
        let hop = nearest.map(|direction| (Action::Hop(direction), Origin::Greedy));
        Some(hop.unwrap_or((Action::Hold, Origin::Hold)))
    }
}

/// Whether a hop stays since something is in the way of its arc, to where it aims or to where it slips.
fn collides(hopper: &Hopper, mission: &Mission, from: Cell, direction: Direction, drawn: Branch) -> bool {
    let (grid, terrain) = (&mission.brief.grid, &mission.terrain);
    let soil = terrain.ground(from).map_or(contract::Soil::Hard, |ground| ground.soil);
    let height_m = |cell| terrain.ground(cell).map(|ground| ground.height_m);
    let mut ways = vec![direction];
    ways.extend((drawn == Branch::Left).then(|| direction.left()));
    ways.extend((drawn == Branch::Right).then(|| direction.right()));
    ways.iter().any(|way| !motion::clears(&hopper.motion, grid, soil, (from, *way), height_m))
}

/// As the law has it, with the launch of the design hop, and what is told of it.
fn of_collision(
    hopper: &Hopper,
    mission: &Mission,
    direction: Direction,
    collides: bool,
    of_law: Arrival,
) -> Arrival {
    let (grid, terrain) = (&mission.brief.grid, &mission.terrain);
    let Outcome { branch, from, to, flight } = of_law.outcome;
    let soil = terrain.ground(from).map_or(contract::Soil::Hard, |ground| ground.soil);
    let launch = motion::design_launch(&hopper.motion, grid, soil);
    let flight = Flight {
        launch_speed_mps: launch.speed_mps,
        launch_angle_rad: launch.angle_rad,
        apex_height_m: launch.apex_height_m(),
        flight_time_s: launch.time_s(flight.range_m),
        ..flight
    };
    let place = |cell: Cell| {
        let ground = terrain.ground(cell).or(terrain.ground(from));
        let [x, y] = [cell.x, cell.y].map(|cells| (f64::from(cells) + 0.5) * grid.cell_size_m);
        [x, y, ground.map_or(0.0, |ground| ground.height_m)]
    };
    let leaves_mps = motion::launch_velocity_mps(&flight, direction).into();
    let detail = Detail {
        model: MotionModel::Collision,
        rest_m: place(to),
        figures: [if collides { 1.0 } else { 0.0 }, 0.0, 0.0, 0.0, 0.0, 0.0],
        path: vec![PathPoint { seconds: 0.0, at_m: place(from), leaves_mps }],
    };
    Arrival { outcome: Outcome { branch, from, to, flight }, detail: Some(detail), ..of_law }
}

/// The probability that `action` ends off the map or on ground known to be impassable, from the observed map alone: what anybody
/// could know who has seen what it has.
fn hazard(hopper: &Hopper, oracle: &Oracle, number: usize, known: &[Option<Ground>], action: Action) -> f64 {
    let (from, grid) = (oracle.turns.actors[number].cell, &oracle.mission.brief.grid);
    let known = |cell: Cell| known[grid.index(cell)?].as_ref();
    let (Action::Hop(direction), Some(ground)) = (action, known(from)) else { return 0.0 };
    let scatter = motion::transition(&hopper.motion, ground, direction);
    let ruins = |branch: &Branch| {
        let to = motion::landing(grid, from, direction, *branch);
        !grid.contains(to) || known(to).is_some_and(|ground| !ground.passable)
    };
    Branch::ALL.into_iter().filter(ruins).map(|branch| scatter.probability(branch)).sum()
}
