//! The law of P23, after the arc was checked against the true ground (P22, section III).
//!
//! A hop that does not clear the ground to its target stays. So does one that is drawn to slip and does not clear the ground to where it slips: without
//! this second check slips would pass walls. A vertical hop takes no check on its way to its target but the rise, of which it is offered.

use contract::{Action, Branch, Detail, Flight, MotionModel as Model, Outcome, PathPoint};
use motion::{Domain, Draw};
use scenario::CollisionRules;

use super::{Hop, Landing, MotionModel, height_m, middle_m};
use crate::Mission;

/// The law with collisions.
#[derive(Debug)]
pub struct Collision;

impl Collision {
    /// Its parameters are those of the body.
    pub fn new(_: &Mission, _: &CollisionRules) -> Self {
        Self
    }
}

impl MotionModel for Collision {
    /// # Panics
    /// If it departs outside of the terrain, as only in a mission that is over.
    fn hop(&self, hop: &Hop<'_>) -> Landing {
        let Hop { mission, robot, body, decision, from, direction, .. } = *hop;
        let (grid, terrain, law) = (&mission.brief.grid, &mission.terrain, &body.motion);
        let ground = terrain.ground(from).expect("a mission underway stands on its terrain");
        let height = |cell| terrain.ground(cell).map(|ground| ground.height_m);
        let uniform = Draw::new(mission.seed, Domain::Motion, robot, decision).uniform();
        let action = if hop.is_up { Action::Up(direction) } else { Action::Hop(direction) };
        let offer = motion::checked(law, grid, (from, ground), action, height);
        let (branch, collides) = offer.map_or((Branch::Stayed, true), |offer| offer.branch(uniform));
        let rise_m = height_m(terrain, grid.hop(from, direction), from) - ground.height_m;
        if hop.is_up {
            return landing(hop, branch, collides, motion::vertical_flight(law, grid, ground.soil, rise_m));
        }
        let launch = motion::design_launch(law, grid, ground.soil);
        let flights = motion::soil_motion(law, ground.soil).flights;
        let range_m = grid.hop_distance_m() / f64::from(flights);
        let flight = Flight {
            launch_speed_mps: launch.speed_mps,
            launch_angle_rad: launch.angle_rad,
            range_m,
            rise_m: rise_m / f64::from(flights),
            apex_height_m: launch.apex_height_m(),
            flight_time_s: launch.time_s(range_m),
            flights,
        };
        landing(hop, branch, collides, flight)
    }
}

/// A hop with that end, and whether it stays since it collides.
fn landing(hop: &Hop<'_>, branch: Branch, collides: bool, flight: Flight) -> Landing {
    let Hop { mission, from, direction, .. } = *hop;
    let to = motion::landing(&mission.brief.grid, from, direction, branch);
    let at = |cell| middle_m(mission, cell, from);
    let leaves = motion::launch_velocity_mps(&flight, direction);
    let path = vec![PathPoint { seconds: 0.0, at_m: at(from), leaves_mps: leaves.into() }];
    let figures = [f64::from(u8::from(collides)), 0.0, 0.0, 0.0, 0.0, 0.0];
    let detail = Detail { model: Model::Collision, rest_m: at(to), figures, path };
    Landing { outcome: Outcome { branch, from, to, flight }, detail: Some(detail) }
}
