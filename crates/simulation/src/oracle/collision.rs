//! A hop by the law of P23 whose arc is checked against the ground, and what is told of it.

use contract::{
    Branch, Cell, Detail, Direction, Flight, Grid, Ground, Hopper, MotionModel, Outcome, PathPoint, Soil,
};
use hopper_sim::Mission;

use super::actor::Arrival;

/// Whether a hop stays since something is in the way of its arc, to where it aims or to where it slips.
pub(super) fn collides(
    hopper: &Hopper,
    mission: &Mission,
    from: Cell,
    direction: Direction,
    drawn: Branch,
) -> bool {
    let (grid, terrain) = (&mission.brief.grid, &mission.terrain);
    let soil = terrain.ground(from).map_or(Soil::Hard, |ground| ground.soil);
    let height_m = |cell| terrain.ground(cell).map(|ground| ground.height_m);
    let mut ways = vec![direction];
    ways.extend((drawn == Branch::Left).then(|| direction.left()));
    ways.extend((drawn == Branch::Right).then(|| direction.right()));
    ways.iter().any(|way| !motion::clears(&hopper.motion, grid, soil, (from, *way), height_m))
}

/// The hop that a hopper with the vertical hop has towards a direction on known ground: whether it is the vertical one, and how far that
/// rises, metres; `None` where it has none. Nothing is in the way of ground that is not known.
pub(super) fn offered(
    hopper: &Hopper,
    grid: &Grid,
    (from, ground): (Cell, &Ground),
    direction: Direction,
    height_m: impl Fn(Cell) -> Option<f64>,
) -> Option<(bool, f64)> {
    if !hopper.motion.vertical
        || motion::clears(&hopper.motion, grid, ground.soil, (from, direction), &height_m)
    {
        return Some((false, 0.0));
    }
    let rise_m = height_m(grid.hop(from, direction))? - height_m(from)?;
    let apex_m = apex_m(hopper, grid, ground.soil);
    let to = grid.hop(from, direction);
    let mut on_the_way = from;
    for _ in 1..grid.hop_cells {
        on_the_way.x += (to.x - from.x).signum();
        on_the_way.y += (to.y - from.y).signum();
        if height_m(on_the_way).is_some_and(|top_m| top_m - height_m(from).unwrap_or(top_m) >= apex_m) {
            return None;
        }
    }
    (rise_m < apex_m && rise_m > -apex_m).then_some((true, rise_m))
}

/// Apex of the vertical hop: v² sin² 80° / 2g with the v² = g d / sin 2η of the design hop, d the length of one of its flights.
fn apex_m(hopper: &Hopper, grid: &Grid, soil: Soil) -> f64 {
    let law = &hopper.motion;
    let flights = if soil == Soil::Sand { law.sand.flights } else { law.hard.flights };
    let (flight_m, sine) = (grid.hop_distance_m() / f64::from(flights), libm::sin(80_f64.to_radians()));
    flight_m / libm::sin(2.0 * law.launch_angle_rad) * sine * sine / 2.0
}

/// The probability that a vertical hop which rises so far ends in a branch, before slips are checked: with f the share of its apex that it
/// rises or drops, p (1 − f) as aimed, s (1 − f) to either side, and otherwise it stays.
pub(super) fn vertical_share(hopper: &Hopper, grid: &Grid, soil: Soil, rise_m: f64, branch: Branch) -> f64 {
    let law = if soil == Soil::Sand { &hopper.motion.sand } else { &hopper.motion.hard };
    let works = 1.0 - rise_m.abs() / apex_m(hopper, grid, soil);
    match branch {
        Branch::Intended => law.intended * works,
        Branch::Left | Branch::Right => law.sideways * works,
        Branch::Stayed => 1.0 - works + law.stuck * works,
        _ => 0.0,
    }
}

/// A vertical hop on the true ground: the branch drawn, and whether it stays since its slip would collide, or since it is not offered.
pub(super) fn vertical(
    hopper: &Hopper,
    mission: &Mission,
    from: Cell,
    direction: Direction,
    uniform: f64,
) -> (Branch, bool) {
    let (grid, terrain) = (&mission.brief.grid, &mission.terrain);
    let height_m = |cell| terrain.ground(cell).map(|ground| ground.height_m);
    let Some(ground) = terrain.ground(from) else { return (Branch::Stayed, true) };
    let Some((true, rise_m)) = offered(hopper, grid, (from, ground), direction, height_m) else {
        return (Branch::Stayed, true);
    };
    let mut left = uniform;
    let drawn = [Branch::Intended, Branch::Stayed, Branch::Left, Branch::Right].into_iter().find(|branch| {
        left -= vertical_share(hopper, grid, ground.soil, rise_m, *branch);
        left < 0.0 || *branch == Branch::Right
    });
    let drawn = drawn.unwrap_or(Branch::Right);
    let aside = match drawn {
        Branch::Left => Some(direction.left()),
        Branch::Right => Some(direction.right()),
        _ => None,
    };
    let clears = |way| motion::clears(&hopper.motion, grid, ground.soil, (from, way), height_m);
    (drawn, aside.is_some_and(|way| !clears(way)))
}

/// As the law has it, with the launch of the design hop or, of a vertical hop, one as fast, and what is told of it.
pub(super) fn told(
    hopper: &Hopper,
    mission: &Mission,
    (direction, is_up): (Direction, bool),
    collides: bool,
    law: Arrival,
) -> Arrival {
    let (grid, terrain) = (&mission.brief.grid, &mission.terrain);
    let Outcome { from, flight, .. } = law.outcome;
    let soil = terrain.ground(from).map_or(Soil::Hard, |ground| ground.soil);
    let flight = if is_up {
        motion::vertical_flight(&hopper.motion, grid, soil, flight.rise_m)
    } else {
        let launch = motion::design_launch(&hopper.motion, grid, soil);
        Flight {
            launch_speed_mps: launch.speed_mps,
            launch_angle_rad: launch.angle_rad,
            apex_height_m: launch.apex_height_m(),
            flight_time_s: launch.time_s(flight.range_m),
            ..flight
        }
    };
    detailed(mission, direction, collides, Arrival { outcome: Outcome { flight, ..law.outcome }, ..law })
}

/// The arrival with what is told of it.
fn detailed(mission: &Mission, direction: Direction, collides: bool, law: Arrival) -> Arrival {
    let (grid, terrain) = (&mission.brief.grid, &mission.terrain);
    let Outcome { from, to, flight, .. } = law.outcome;
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
    Arrival { detail: Some(detail), ..law }
}
