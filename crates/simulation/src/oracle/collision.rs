//! A hop by the law of P23 whose arc is checked against the ground, and what is told of it.

use contract::{Branch, Cell, Detail, Direction, Flight, Hopper, MotionModel, Outcome, PathPoint};
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
    let soil = terrain.ground(from).map_or(contract::Soil::Hard, |ground| ground.soil);
    let height_m = |cell| terrain.ground(cell).map(|ground| ground.height_m);
    let mut ways = vec![direction];
    ways.extend((drawn == Branch::Left).then(|| direction.left()));
    ways.extend((drawn == Branch::Right).then(|| direction.right()));
    ways.iter().any(|way| !motion::clears(&hopper.motion, grid, soil, (from, *way), height_m))
}

/// As the law has it, with the launch of the design hop, and what is told of it.
pub(super) fn told(
    hopper: &Hopper,
    mission: &Mission,
    direction: Direction,
    collides: bool,
    law: Arrival,
) -> Arrival {
    let (grid, terrain) = (&mission.brief.grid, &mission.terrain);
    let Outcome { branch, from, to, flight } = law.outcome;
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
    Arrival { outcome: Outcome { branch, from, to, flight }, detail: Some(detail), ..law }
}
