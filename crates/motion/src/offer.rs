//! Which hop a hopper has towards each direction, and how it may end: planners ask it of seen ground, the guard of what the sensor
//! sees, and the dynamics of the true ground.
//!
//! Without the vertical hop it is the hop at the launch angle, whatever stands in the way. With it (P22 section "Vertical hopping") it
//! is that hop where its arc clears the ground ([`clears`]), else the vertical one where the rise is below its apex, else none. A slip
//! whose arc does not clear the ground ends where it began.

use contract::{Action, Branch, Cell, Direction, Flight, Grid, Ground, MotionParameters};

use crate::{
    Launch, Transition, clears, design_launch, soil_motion, transition, transitions, vertical_transition,
};

/// Launch angle of the vertical hop, degrees.
pub const VERTICAL_DEG: f64 = 80.0;

/// The same, radians.
pub const VERTICAL_RAD: f64 = VERTICAL_DEG * std::f64::consts::PI / 180.0;

/// A hop that is available from a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Offer {
    /// The hop.
    pub action: Action,
    /// What is drawn, before slips are checked.
    pub drawn: Transition,
    /// Whether a slip to the left and one to the right would collide, and so stay.
    pub collides: [bool; 2],
    /// Height of the target above the departure, metres; of vertical hops alone.
    pub climb_m: Option<f64>,
}

impl Offer {
    /// The probabilities of its ends: slips that would collide stay.
    #[must_use]
    pub fn scatter(&self) -> Transition {
        let Transition { intended, stayed, left, right } = self.drawn;
        let [left_stays, right_stays] = self.collides;
        let (stays_left, left) = if left_stays { (left, 0.0) } else { (0.0, left) };
        let (stays_right, right) = if right_stays { (right, 0.0) } else { (0.0, right) };
        Transition { intended, stayed: stayed + stays_left + stays_right, left, right }
    }

    /// Where it ends by a number that is uniform in [0, 1), and whether it stays since its slip would collide.
    #[must_use]
    pub fn branch(&self, uniform: f64) -> (Branch, bool) {
        let drawn = self.drawn.branch(uniform);
        let collides = match drawn {
            Branch::Left => self.collides[0],
            Branch::Right => self.collides[1],
            _ => false,
        };
        (if collides { Branch::Stayed } else { drawn }, collides)
    }
}

/// The launch of a vertical hop: as fast as the design hop, since the springs hold the same energy.
#[must_use]
pub fn vertical_launch(parameters: &MotionParameters, grid: &Grid, soil: contract::Soil) -> Launch {
    design_launch(parameters, grid, soil).at(VERTICAL_RAD)
}

/// The flight of a vertical hop that rises `rise_m`. It comes down a third of the way to its cell; that it drifts there is the paper's
/// assumption.
#[must_use]
pub fn vertical_flight(
    parameters: &MotionParameters,
    grid: &Grid,
    soil: contract::Soil,
    rise_m: f64,
) -> Flight {
    let launch = vertical_launch(parameters, grid, soil);
    let range_m = launch.landing_distance_m(rise_m).unwrap_or_else(|| launch.apex_distance_m());
    Flight {
        launch_speed_mps: launch.speed_mps,
        launch_angle_rad: launch.angle_rad,
        range_m,
        rise_m,
        apex_height_m: launch.apex_height_m(),
        flight_time_s: launch.time_s(range_m),
        flights: 1,
    }
}

/// The hop towards each direction from a cell with that ground, in the order of [`Direction::ALL`]; `None` where there is none. Ground of
/// unknown height blocks no arc.
#[must_use]
pub fn offers(
    parameters: &MotionParameters,
    grid: &Grid,
    from: (Cell, &Ground),
    height_m: impl Fn(Cell) -> Option<f64>,
) -> [Option<Offer>; 4] {
    if !parameters.vertical {
        let drawn = transitions(parameters, from.1);
        return Direction::ALL.map(|direction| {
            let (action, drawn) = (Action::Hop(direction), drawn[direction as usize]);
            Some(Offer { action, drawn, collides: [false; 2], climb_m: None })
        });
    }
    let checks = Checks::new(parameters, grid, from, &height_m);
    Direction::ALL.map(|towards| checks.hop(towards).or_else(|| checks.up(towards)))
}

/// `action` from a cell with that ground, with its arcs checked; `None` if it is no hop or has no way to where it aims.
#[must_use]
pub fn checked(
    parameters: &MotionParameters,
    grid: &Grid,
    from: (Cell, &Ground),
    action: Action,
    height_m: impl Fn(Cell) -> Option<f64>,
) -> Option<Offer> {
    let checks = Checks::new(parameters, grid, from, &height_m);
    match action {
        Action::Hop(direction) => checks.hop(direction),
        Action::Up(direction) => checks.up(direction),
        _ => None,
    }
}

/// The hops from a cell, by what stands around it.
struct Checks<'a, H> {
    parameters: &'a MotionParameters,
    grid: &'a Grid,
    from: Cell,
    ground: &'a Ground,
    height_m: &'a H,
    /// Whether the arc towards each direction clears the ground.
    clear: [bool; 4],
}

impl<'a, H: Fn(Cell) -> Option<f64>> Checks<'a, H> {
    fn new(
        parameters: &'a MotionParameters,
        grid: &'a Grid,
        (from, ground): (Cell, &'a Ground),
        height_m: &'a H,
    ) -> Self {
        let clear =
            Direction::ALL.map(|towards| clears(parameters, grid, ground.soil, (from, towards), height_m));
        Self { parameters, grid, from, ground, height_m, clear }
    }

    fn is_clear(&self, direction: Direction) -> bool {
        self.clear[direction as usize]
    }

    /// The hop at the launch angle.
    fn hop(&self, direction: Direction) -> Option<Offer> {
        if !self.is_clear(direction) {
            return None;
        }
        let drawn = transition(self.parameters, self.ground, direction);
        Some(Offer {
            action: Action::Hop(direction),
            drawn,
            collides: self.collides(direction),
            climb_m: None,
        })
    }

    /// The vertical hop, where the hop at the launch angle is not clear.
    fn up(&self, direction: Direction) -> Option<Offer> {
        if self.is_clear(direction) {
            return None;
        }
        let (height_m, aim) = (self.height_m, self.grid.hop(self.from, direction));
        let here_m = height_m(self.from)?;
        let rise_m = height_m(aim)? - here_m;
        let apex_m = vertical_launch(self.parameters, self.grid, self.ground.soil).apex_height_m();
        // Nothing on the way stands as high as the apex either.
        let [east, north] = [aim.x - self.from.x, aim.y - self.from.y].map(i32::signum);
        let mut between = (1..self.grid.hop_cells as i32)
            .map(|n| Cell::new(self.from.x + n * east, self.from.y + n * north));
        if between.any(|cell| height_m(cell).is_some_and(|top_m| top_m - here_m >= apex_m)) {
            return None;
        }
        let motion = soil_motion(self.parameters, self.ground.soil);
        let drawn = vertical_transition(motion, rise_m, apex_m)?;
        let collides = self.collides(direction);
        Some(Offer { action: Action::Up(direction), drawn, collides, climb_m: Some(rise_m) })
    }

    /// Whether slips to the left and to the right would collide.
    fn collides(&self, direction: Direction) -> [bool; 2] {
        [direction.left(), direction.right()].map(|aside| !self.is_clear(aside))
    }
}

#[cfg(test)]
mod tests {
    use contract::SoilMotion;

    use super::*;

    fn mars(vertical: bool) -> MotionParameters {
        let soil = |intended, stuck, sideways, flights| SoilMotion { intended, stuck, sideways, flights };
        MotionParameters {
            hard: soil(0.7, 0.0, 0.15, 1),
            sand: soil(0.5, 0.2, 0.15, 2),
            slope_limit_rad: std::f64::consts::FRAC_PI_6,
            launch_angle_rad: std::f64::consts::FRAC_PI_4,
            gravity_mps2: 3.72,
            vertical,
            table: 0,
        }
    }

    fn on(vertical: bool, height_m: impl Fn(Cell) -> f64) -> [Option<Offer>; 4] {
        let grid = Grid::new(9, 9, 1.0, 1).unwrap();
        offers(&mars(vertical), &grid, (Cell::new(4, 4), &Ground::FLAT), |cell| Some(height_m(cell)))
    }

    /// P-UP-OFFERS: Where a hop at 45° would collide, a hopper with the vertical hop has that one up to a rise of its apex, a tie excluded, and
    /// no hop from there on; a slip into what stands in the way stays.
    #[test]
    fn what_a_hop_would_run_into_is_hopped_up_to_the_apex_of_the_vertical_hop() {
        let east = |rise_m: f64| move |cell: Cell| if cell.x == 5 { rise_m } else { 0.0 };
        let apex_m = vertical_launch(&mars(true), &Grid::new(9, 9, 1.0, 1).unwrap(), contract::Soil::Hard)
            .apex_height_m();
        assert!((apex_m - 0.485).abs() < 5e-4, "as P22 prints it: {apex_m}");
        let hop = Some(Action::Hop(Direction::East));
        let up = Some(Action::Up(Direction::East));
        for (rise_m, need) in
            [(0.0, hop), (0.2499, hop), (0.25, up), (0.48, up), (apex_m, None), (1.0, None), (-1.0, hop)]
        {
            let offer = on(true, east(rise_m))[Direction::East as usize];
            assert_eq!(offer.map(|offer| offer.action), need, "{rise_m}");
            let without = on(false, east(rise_m))[Direction::East as usize];
            assert_eq!(without.map(|offer| offer.action), hop, "without it nothing is in the way");
        }
        let up = on(true, east(0.25))[Direction::East as usize].unwrap();
        assert_eq!(up.climb_m, Some(0.25));
        assert!((up.drawn.intended - 0.7 * (1.0 - 0.25 / apex_m)).abs() < 1e-12);
        assert_eq!(up.collides, [false; 2]);
        let north = on(true, east(0.25))[Direction::North as usize].unwrap();
        assert_eq!((north.action, north.collides), (Action::Hop(Direction::North), [false, true]));
        let Transition { stayed, left, right, .. } = north.scatter();
        assert!((stayed - 0.15).abs() < 1e-12 && (left - 0.15).abs() < 1e-12 && right == 0.0);
    }

    #[test]
    fn nothing_is_in_the_way_on_unseen_ground() {
        let grid = Grid::new(9, 9, 1.0, 1).unwrap();
        let seen = |cell: Cell| (cell == Cell::new(4, 4)).then_some(-5.0);
        let offers = offers(&mars(true), &grid, (Cell::new(4, 4), &Ground::FLAT), seen);
        assert_eq!(offers.map(|offer| offer.unwrap().action), Direction::ALL.map(Action::Hop));
    }
}
