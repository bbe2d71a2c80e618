//! What happens to a rover along its route.

use std::ops::ControlFlow;

use crate::{Point, Segment, Speed, Surface, Truth, traverse};

/// How a drive ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriveEnd {
    /// At the route's last point.
    Arrived,
    /// On the way, since the time given was used up.
    OutOfTime,
    /// At the border of a cell of true speed 0, which it entered: it will never move again.
    Stuck {
        /// The cell of speed 0.
        cell: usize,
    },
}

/// How long a drive may take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Allowance {
    /// Time used up by the drives before, in Sol.
    pub used_sol: f64,
    /// Time that those and this one may take, in Sol; infinite for no limit.
    pub limit_sol: f64,
}

impl Allowance {
    /// As long as it takes.
    pub const UNLIMITED: Self = Self { used_sol: 0.0, limit_sol: f64::INFINITY };
}

/// A drive along a route, or along its first part.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    /// How it ended.
    pub end: DriveEnd,
    /// Where the rover stands.
    pub at: Point,
    /// Time spent driving, in Sol.
    pub duration_sol: f64,
    /// Time spent driving in this drive and those before it, in Sol, added up piece by piece: two
    /// drives make the sum of one.
    pub used_sol: f64,
    /// Way driven on the ground, in metres.
    pub length_m: f64,
    /// Points of the route that it has reached after the first.
    pub reached: usize,
    /// Cells that the rover has been in, in order, and so knows; the one it is stuck in included.
    pub sensed: Vec<usize>,
}

/// Drives `route` on the true ground for as long as is allowed.
///
/// # Panics
/// If the truth has another number of cells than the surface.
#[must_use]
pub fn drive(surface: &Surface, truth: &Truth, route: &[Point], allowance: Allowance) -> Drive {
    assert_eq!(truth.speeds.len(), surface.lattice().cells(), "the truth needs a speed for each cell");
    let mut drive = Drive {
        end: DriveEnd::Arrived,
        at: route.first().copied().unwrap_or_default(),
        duration_sol: 0.0,
        used_sol: allowance.used_sol,
        length_m: 0.0,
        reached: 0,
        sensed: Vec::new(),
    };
    for pair in route.windows(2) {
        let segment = Segment { from: pair[0], to: pair[1] };
        let direction = segment.direction();
        let mut done_m = 0.0;
        let flow = traverse(surface.lattice(), segment, |cell, piece_m| {
            if drive.sensed.last() != Some(&cell) {
                drive.sensed.push(cell);
            }
            let speed = truth.speeds[cell];
            if speed == Speed::Zero {
                return ControlFlow::Break(DriveEnd::Stuck { cell });
            }
            let ground_m = piece_m * surface.stretch(cell, direction);
            let piece_sol = ground_m * speed.pace_sol_per_m();
            let share = ((allowance.limit_sol - drive.used_sol) / piece_sol).clamp(0.0, 1.0);
            drive.duration_sol += share * piece_sol;
            drive.used_sol += share * piece_sol;
            drive.length_m += share * ground_m;
            done_m += share * piece_m;
            if share < 1.0 { ControlFlow::Break(DriveEnd::OutOfTime) } else { ControlFlow::Continue(()) }
        });
        if let ControlFlow::Break(end) = flow {
            drive.end = end;
            drive.at = segment.from.towards(segment.to, done_m / segment.from.distance_m(segment.to));
            return drive;
        }
        (drive.at, drive.reached) = (segment.to, drive.reached + 1);
    }
    drive
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Lattice;
    use std::sync::Arc;

    const ROUTE: [Point; 2] = [Point::new(0.5, 0.5), Point::new(3.5, 0.5)];

    fn row(speeds: [Speed; 4]) -> (Surface, Truth) {
        (Surface::flat(Lattice::new(4, 1).unwrap()), Truth { speeds: speeds.to_vec() })
    }

    /// P-TRAVERSE.
    #[test]
    fn a_drive_takes_the_sum_of_its_true_paces() {
        let (surface, truth) = row([Speed::Fast, Speed::Slow, Speed::Medium, Speed::Fast]);
        let drive = drive(&surface, &truth, &ROUTE, Allowance::UNLIMITED);
        assert_eq!((drive.end, drive.at, drive.length_m), (DriveEnd::Arrived, ROUTE[1], 3.0));
        assert!((drive.duration_sol - (0.5 / 200.0 + 1.0 / 50.0 + 1.0 / 150.0 + 0.5 / 200.0)).abs() < 1e-15);
        assert_eq!(drive.sensed, [0, 1, 2, 3]);
        // One who knows the truth expects that very time.
        let known = truth.known(Arc::new(surface)).unwrap().expected_time(crate::Caution::default());
        assert!((known.way(&ROUTE) - drive.duration_sol).abs() < 1e-15);
    }

    #[test]
    fn a_rover_is_stuck_at_the_border_of_a_cell_of_speed_0() {
        let (surface, truth) = row([Speed::Fast, Speed::Fast, Speed::Zero, Speed::Fast]);
        let drive = drive(&surface, &truth, &ROUTE, Allowance::UNLIMITED);
        assert_eq!((drive.end, drive.at), (DriveEnd::Stuck { cell: 2 }, Point::new(2.0, 0.5)));
        assert_eq!(drive.sensed, [0, 1, 2]);
        assert!((drive.duration_sol - 1.5 / 200.0).abs() < 1e-15);
    }

    #[test]
    fn a_drive_ends_on_the_way_when_its_time_is_used_up() {
        let (surface, truth) = row([Speed::Fast, Speed::Slow, Speed::Slow, Speed::Fast]);
        let allowance = Allowance { used_sol: 0.0, limit_sol: 0.5 / 200.0 + 0.5 / 50.0 };
        let drive = drive(&surface, &truth, &ROUTE, allowance);
        assert_eq!((drive.end, drive.reached), (DriveEnd::OutOfTime, 0));
        assert!((drive.at.x_m - 1.5).abs() < 1e-12 && drive.sensed == [0, 1]);
    }

    /// P-STAGE-LEGS: A route that is driven leg by leg ends, when its time is used up, where it
    /// would end in one drive, to the last bit.
    #[test]
    fn a_route_driven_leg_by_leg_ends_where_it_ends_in_one_drive_to_the_last_bit() {
        let speeds = [Speed::Fast, Speed::Slow, Speed::Medium, Speed::Fast, Speed::Slow].repeat(20);
        let surface = Surface::flat(Lattice::new(100, 1).unwrap());
        let truth = Truth { speeds };
        let route: Vec<Point> = (0..34).map(|leg| Point::new(0.1 + 2.93 * f64::from(leg), 0.7)).collect();
        for tenths in 1..=12 {
            let limit_sol = 0.1 * f64::from(tenths);
            let whole = drive(&surface, &truth, &route, Allowance { used_sol: 0.0, limit_sol });
            let (mut used_sol, mut reached) = (0.0, 0);
            let last = route.windows(2).find_map(|leg| {
                let part = drive(&surface, &truth, leg, Allowance { used_sol, limit_sol });
                (used_sol, reached) = (part.used_sol, reached + part.reached);
                (part.end != DriveEnd::Arrived || reached + 1 == route.len()).then_some(part)
            });
            let last = last.unwrap();
            assert_eq!((last.end, last.at, reached), (whole.end, whole.at, whole.reached), "{limit_sol} Sol");
            assert_eq!(used_sol.to_bits(), whole.duration_sol.to_bits());
            assert!(whole.sensed.ends_with(&last.sensed[1..]));
        }
    }
}
