//! What displays show is what planners count with.

// Helpers of tests are not recognised as tests.
#![allow(clippy::unwrap_used)]

use contract::{
    Body, Camera, Cell, Direction, DriveSpeed, ErringCamera, Goal, Helicopter, LookAhead, Placement, Robot,
    Sensor, SpeedPrior, Waypoint,
};
use speed_layer::{SPREAD_MAX_M_PER_SOL, SpeedEstimate, SpeedLayer};

fn helicopter(sensor: Sensor) -> Robot {
    Robot {
        body: Body::Helicopter(Helicopter { speed_mps: 5.0, budget_m: 300.0 }),
        sensor,
        start: Placement { cell: Cell::new(0, 0), heading: Direction::North },
        start_at: Waypoint::default(),
        goal: Goal::LookAhead(LookAhead {}),
        required: false,
    }
}

fn priors() -> Vec<SpeedPrior> {
    let risky = SpeedPrior::new([0.5, 0.0, 0.0, 0.5]).unwrap();
    let sure = SpeedPrior::new([0.0, 0.0, 0.0, 1.0]).unwrap();
    vec![risky, risky, sure, risky]
}

/// P-SPEED-LAYER: Displays show the expected speed and spread that planners count with, under the
/// prior, a reading and a sight.
#[test]
fn the_layer_is_what_planners_count_with() {
    let accuracy = 0.8;
    let robots = [helicopter(Sensor::ErringCamera(ErringCamera { radius_m: 25.0, accuracy }))];
    let layer = SpeedLayer::of_speeds(priors().iter(), &robots);
    assert_eq!((layer.rows().len(), layer.codes()), (2, &[0, 0, 1, 0][..]), "one row a distribution");
    let unseen = layer.estimate(1, None, None).unwrap();
    assert_eq!((unseen.mean_m_per_sol, unseen.sd_m_per_sol), (100.0, SPREAD_MAX_M_PER_SOL));
    // By Bayes' rule over the two speeds that are possible: .8 against .2 / 3.
    let fast = 0.8 / (0.8 + 0.2 / 3.0);
    let read = layer.estimate(3, None, Some(DriveSpeed::Fast)).unwrap();
    assert!((read.mean_m_per_sol - 200.0 * fast).abs() < 1e-9, "{read:?}");
    assert!((read.sd_m_per_sol - 200.0 * (fast * (1.0 - fast)).sqrt()).abs() < 1e-9, "{read:?}");
    // What the reading says cannot be, the prior stands.
    assert_eq!(layer.estimate(2, None, Some(DriveSpeed::Slow)), layer.estimate(2, None, None));
    let seen = layer.estimate(3, Some(DriveSpeed::Slow), Some(DriveSpeed::Fast)).unwrap();
    assert_eq!(seen, SpeedEstimate { mean_m_per_sol: 50.0, sd_m_per_sol: 0.0 });
    assert_eq!(layer.estimate(4, None, None), None);
}

#[test]
fn without_a_camera_that_errs_readings_say_nothing() {
    let robots = [helicopter(Sensor::Camera(Camera { radius_m: 25.0 }))];
    let layer = SpeedLayer::of_speeds(priors().iter(), &robots);
    assert!(layer.rows().iter().all(|row| row.read == [row.unseen; 4]));
}
