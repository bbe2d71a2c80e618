//! `[truth.mobility]`: ground of one's own for a rover with a helicopter.

use std::fs;
use std::path::Path;

use contract::{Body, DriveSpeed, Goal, Waypoint};
use scenario::ResolvedScenario;

const ROBOTS: &str = "[[robots]]\nbody = \"driver\"\n[[robots]]\nbody = \"helicopter\"\nspeed_mps = 5.0\n";

/// An ESRI ASCII grid of 6 x 4 cells of a metre, whose values `value` gives by column and row from the south-west.
fn grid(dir: &Path, name: &str, west_m: f64, value: impl Fn(usize, usize) -> String) {
    let rows: Vec<String> = (0..4)
        .rev()
        .map(|row| (0..6).map(|column| value(column, row)).collect::<Vec<_>>().join(" "))
        .collect();
    let head =
        format!("ncols 6\nnrows 4\nxllcorner {west_m}\nyllcorner 2000\ncellsize 1\nNODATA_value -9999\n");
    fs::write(dir.join(name), head + &rows.join("\n") + "\n").unwrap();
}

/// A ramp of half a metre a metre in the east, level in the west, with a cell without height.
fn model(dir: &Path) {
    grid(dir, "dem.asc", 1000.0, |column, row| match (column, row) {
        (2, 3) => "-9999".into(),
        (column, _) => (0.5 * column.saturating_sub(2) as f64).to_string(),
    });
}

fn resolved(dir: &Path, mobility: &str, ends: &str) -> Result<ResolvedScenario, String> {
    let text = format!(
        "[truth.terrain.elevation_file]\nfile = \"dem.asc\"\n[truth.mobility]\n{mobility}\n\
         [brief]\nprofile = \"hopper\"\n{ends}\n{ROBOTS}"
    );
    fs::write(dir.join("own.toml"), text).unwrap();
    let scenario =
        scenario::load(dir.join("own.toml").to_str().unwrap()).map_err(|error| error.to_string())?;
    scenario.resolve().map_err(|error| error.to_string())
}

const ENDS: &str = "start = [0, 0]\ngoal = [1, 3]";

/// P-MOBILITY-OWN: On ground of the user's own, terrain classes, slopes and rock abundance give the
/// prior of the speeds, and the truth is possible under it.
#[test]
fn classes_slopes_and_rocks_give_the_prior_and_a_truth_that_is_possible_under_it() {
    let dir = tempfile::tempdir().unwrap();
    model(dir.path());
    grid(dir.path(), "sand.asc", 1000.0, |_, row| if row == 1 { "0.4".into() } else { "0".into() });
    grid(dir.path(), "firm.asc", 1000.0, |_, row| if row == 1 { "0.6".into() } else { "1".into() });
    let mobility =
        "rock_abundance = 0.05\nclasses = { smooth_regolith = \"firm.asc\", deep_sand = \"sand.asc\" }";
    let truths: Vec<_> = (0..20)
        .map(|seed| resolved(dir.path(), &format!("seed = {seed}\n{mobility}"), ENDS).unwrap())
        .collect();
    let world = &truths[0];
    let prior = |x: usize, y: usize| world.terrain.prior[y * 6 + x].probabilities();
    assert_eq!(prior(0, 0), [0.0, 0.0, 0.0, 1.0]);
    assert_eq!(prior(0, 1), [0.4, 0.0, 0.0, 0.6]);
    assert_eq!(prior(4, 0), [1.0, 0.0, 0.0, 0.0], "27 degrees are too steep");
    assert_eq!(prior(2, 3), [1.0, 0.0, 0.0, 0.0], "there is no height");
    let rover = &world.brief.robots[0];
    let (Body::Driver(_), Goal::Reach(goal)) = (rover.body, rover.goal) else { panic!("a rover drives") };
    assert_eq!(rover.start_at, Waypoint { x_m: 0.5, y_m: 0.5 });
    assert_eq!((goal.at, goal.radius_m), (Waypoint { x_m: 1.5, y_m: 3.5 }, 3.0));
    let mut sand = 0;
    for world in &truths {
        let speed = |x: usize, y: usize| world.terrain.cells[y * 6 + x].speed.unwrap();
        assert_eq!((speed(0, 0), speed(2, 3)), (DriveSpeed::Fast, DriveSpeed::Zero));
        assert_eq!(speed(0, 1), speed(1, 1), "cells of which the same is known are of one class");
        sand += usize::from(speed(0, 1) == DriveSpeed::Zero);
        for (ground, prior) in world.terrain.cells.iter().zip(&world.terrain.prior) {
            assert!(prior.probability(ground.speed.unwrap()) > 0.0);
        }
    }
    assert!((3..=14).contains(&sand), "{sand} of 20 are of sand");
    let seeds: Vec<_> = truths.iter().map(|world| world.brief.sampling.unwrap().seed).collect();
    assert!(seeds[1] > 1 << 32 && seeds[1] != seeds[2], "the planners' seed tells nothing of the truth's");
}

#[test]
fn speeds_certain_classes_and_a_given_truth_are_read() {
    let dir = tempfile::tempdir().unwrap();
    model(dir.path());
    grid(dir.path(), "half.asc", 1000.0, |_, _| "0.5".into());
    grid(dir.path(), "truth.asc", 1000.0, |column, _| if column == 5 { "50".into() } else { "200".into() });
    let mobility = "speeds = [0.0, \"half.asc\", 0, 0.5]\ntrue_speed_file = \"truth.asc\"";
    let world = resolved(dir.path(), mobility, ENDS).unwrap();
    assert_eq!(world.terrain.prior[5].probabilities(), [0.0, 0.5, 0.0, 0.5]);
    assert_eq!(world.terrain.cells[5].speed, Some(DriveSpeed::Slow));
    grid(dir.path(), "class.asc", 1000.0, |column, _| if column == 0 { "0".into() } else { "4".into() });
    let world = resolved(dir.path(), "class_file = \"class.asc\"", ENDS).unwrap();
    let speeds: Vec<_> = world.terrain.cells[..3].iter().map(|ground| ground.speed.unwrap()).collect();
    assert_eq!(speeds, [DriveSpeed::Fast, DriveSpeed::Medium, DriveSpeed::Medium], "rough outcrop is slower");
}
