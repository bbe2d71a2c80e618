//! What a step of a rover that covers ground comes to, as it should, by code that shares nothing with the product's.

use contract::{Action, Body, Branch, Cell, Direction, Flight, Outcome, Robot, Rover};
use hopper_sim::Mission;

use crate::covered::index;

/// The cell to which a step leads.
pub(crate) fn beside(cell: Cell, action: Action) -> Cell {
    match action {
        Action::Step(Direction::North) => Cell::new(cell.x, cell.y + 1),
        Action::Step(Direction::East) => Cell::new(cell.x + 1, cell.y),
        Action::Step(Direction::South) => Cell::new(cell.x, cell.y - 1),
        Action::Step(Direction::West) => Cell::new(cell.x - 1, cell.y),
        _ => cell,
    }
}

/// What `action` of a rover on `from` comes to, which fails at it if `fails`.
pub(crate) fn outcome(
    mission: &Mission,
    robot: &Robot,
    from: Cell,
    action: Action,
    fails: bool,
) -> Option<Outcome> {
    let still = Flight { flight_time_s: 1.0, flights: 1, ..Flight::default() };
    if fails {
        return Some(Outcome { branch: Branch::Stranded, from, to: from, flight: still });
    }
    let Action::Step(_) = action else {
        return Some(Outcome { branch: Branch::Held, from, to: from, flight: still });
    };
    let to = beside(from, action);
    let range_m = mission.brief.grid.cell_size_m;
    let rise_m = height_m(mission, to) - height_m(mission, from);
    let Body::Rover(Rover { speed_mps }) = robot.body else { return None };
    let flight_time_s = libm::hypot(range_m, rise_m) / speed_mps;
    let flight = Flight { range_m, rise_m, flight_time_s, flights: 1, ..Flight::default() };
    Some(Outcome { branch: Branch::Intended, from, to, flight })
}

fn height_m(mission: &Mission, cell: Cell) -> f64 {
    mission.terrain.cells[index(mission, cell)].height_m
}
