//! Missions of robots of all kinds, each with a task of its own.

use contract::{Account, Cell, Goal, Reach, RobotId, RobotSet, Sensor, Square};
use scenario::Scenario;

const EXPEDITION: &str = include_str!("../../scenarios/expedition.toml");

#[test]
fn robots_of_all_kinds_have_starts_goals_and_sensors_of_their_own() {
    let world = Scenario::parse(EXPEDITION, "test").unwrap().resolve().unwrap();
    let (robots, grid) = (&world.brief.robots, &world.brief.grid);
    let kinds: Vec<_> = robots.iter().map(|robot| robot.body.name()).collect();
    assert_eq!(kinds, ["driver", "helicopter", "hopper", "hopper", "helicopter", "rover"]);
    assert_eq!(robots[2].goal, Goal::Reach(Reach::of_cell(grid, Cell::new(140, 66))));
    assert_eq!(robots[5].sensor, Sensor::Square(Square { range_cells: 1 }));
    assert!(matches!(robots[2].sensor, Sensor::Disc(_)));
    let required = [0, 2, 3].map(RobotId).into_iter().fold(RobotSet(0), RobotSet::with);
    assert_eq!(robots.those(|robot| robot.required), required);
    assert_eq!(world.brief.account, Account::ActionsWithoutWaits);
    assert!(world.brief.sampling.is_some(), "a rover drives to a goal");
    let goals: Vec<_> = robots.iter().map(|robot| robot.goal.name()).collect();
    assert_eq!(goals, ["reach", "look_ahead", "reach", "reach", "look_ahead", "cover"]);
    // Ground that no rover can cross is ground to a hopper.
    let closed = world.terrain.cells.iter().filter(|ground| !ground.is_drivable());
    assert!(closed.clone().count() > 1000 && closed.clone().all(|ground| ground.passable));
    let again = Scenario::parse(&world.resolved, "again").unwrap().resolve().unwrap();
    assert_eq!((again.hash, &again.faults, again.brief), (world.hash, &world.faults, world.brief));
}

/// P-MIXED-DESIGN: Each hopper of a mission hops, sees and is guarded by its own law and sensor;
/// values that it leaves out are those of `[robot]`.
#[test]
fn hoppers_have_designs_of_their_own() {
    let hopper = "start = [60, 62]\ngoal = [140, 66]";
    let own = "launch_angle_deg = 60.0\nsand = { intended = 0.6, stuck = 0.2, sideways = 0.1, flights = 1 }\nsensor = { offset_m = 3.0 }";
    let text = EXPEDITION.replacen(hopper, &format!("{hopper}\n{own}"), 1);
    let world = Scenario::parse(&text, "test").unwrap().resolve().unwrap();
    let brief = &world.brief;
    let other = Scenario::parse(EXPEDITION, "test").unwrap().resolve().unwrap();
    // Without a design of its own it is the hopper of `[robot]`.
    let (common_motion, common_sensor) = other.brief.robots[2].as_hopper().unwrap();
    let (motion, sensor) = brief.robots[2].as_hopper().unwrap();
    assert_eq!((motion.launch_angle_rad, motion.hard), (60.0_f64.to_radians(), common_motion.hard));
    assert_eq!((motion.sand.stuck, motion.sand.flights), (0.2, 1));
    assert_eq!((sensor.offset_m, sensor.gain), (3.0, common_sensor.gain));
    let (motion, sensor) = brief.robots[3].as_hopper().unwrap();
    assert_eq!(sensor.gain, 4.0, "as the scenario has it");
    assert_eq!(motion, common_motion);
    let again = Scenario::parse(&world.resolved, "again").unwrap().resolve().unwrap();
    assert_eq!((again.hash, again.brief), (world.hash, world.brief));
    assert_ne!(other.hash, world.hash, "a mission of other hoppers is another mission");
}

/// Nothing limits how many hoppers of a mission have a design of their own.
#[test]
fn each_of_sixteen_hoppers_may_have_its_own_design() {
    let ground = "[truth.terrain.obstacles]\nwidth_cells = 16\nheight_cells = 16\ncell_size_m = 1\npercent = 0\nseed = 1\n\
        [brief]\nprofile = \"hopper\"\n";
    let hopper = |row: u32| {
        format!(
            "[[robots]]\nbody = \"hopper\"\nstart = [0, {row}]\ngoal = [5, {row}]\nsensor = {{ gain = {row}.5 }}\n"
        )
    };
    let hoppers: String = (0..16).map(hopper).collect();
    let world = Scenario::parse(&(ground.to_owned() + &hoppers), "test").unwrap().resolve().unwrap();
    let gains: Vec<f64> = world.brief.robots.iter().map(|robot| robot.as_hopper().unwrap().1.gain).collect();
    assert_eq!(gains, (0..16).map(|row| f64::from(row) + 0.5).collect::<Vec<_>>());
}

/// A rover on the goal of a hopper is refused if it may stay there, and only then.
#[test]
fn a_rover_that_is_done_where_a_hopper_shall_go_is_refused() {
    let hopper = |text: &str| text.replacen("goal = [140, 66]", "goal = [8, 60]", 1);
    let parsed = |text: &str| Scenario::parse(text, "test").unwrap().resolve();
    assert!(parsed(&hopper(EXPEDITION)).is_ok(), "the rover drives away");
    let stays = hopper(EXPEDITION).replacen("goal = [192, 150]", "goal = [9, 60]", 1);
    let error = parsed(&stays).unwrap_err().to_string();
    assert!(error.starts_with("robots.start: need another cell than the goal of a hopper"), "{error}");
}

/// Without hoppers the length of a hop is nobody's, and need not be one of whole cells.
#[test]
fn rovers_alone_need_no_hop_of_whole_cells() {
    let ground = "[truth.terrain.obstacles]\nwidth_cells = 9\nheight_cells = 9\ncell_size_m = 0.4\npercent = 0.0\nseed = 0\n\
        [brief]\nprofile = \"hopper\"\n[[robots]]\nbody = \"rover\"\nstart = [1, 1]\nspeed_mps = 0.3\n";
    assert!(Scenario::parse(ground, "test").unwrap().resolve().is_ok());
    let hopper = "[[robots]]\nbody = \"hopper\"\nstart = [2, 2]\ngoal = [5, 5]\n";
    let error = Scenario::parse(&(ground.to_owned() + hopper), "test").unwrap().resolve().unwrap_err();
    assert!(error.to_string().contains("hop"), "{error}");
}
