//! Missions of robots of all kinds, each with a task of its own.

use contract::{Account, Cell, Goal, Reach, RobotId, RobotSet, Sensor, Square};
use scenario::{Overrides, Scenario};

const EXPEDITION: &str = include_str!("../../scenarios/expedition.toml");

/// The message of the one error that the scenario has with `old` replaced by `new`.
fn refusal(old: &str, new: &str) -> String {
    assert!(EXPEDITION.contains(old), "{old}");
    let scenario = Scenario::parse(&EXPEDITION.replacen(old, new, 1), "test");
    match scenario.and_then(|scenario| scenario.with(&Overrides::default()).resolve()) {
        Ok(_) => panic!("{new} is accepted"),
        Err(error) => error.to_string(),
    }
}

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
    let brief = world.brief;
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

/// P-MIXED-SCENARIO: Every impossible mixed mission is refused with one error.
// Long: a row for each error.
#[test]
fn missions_of_all_kinds_that_cannot_be_are_refused_by_name() {
    let hopper = "start = [60, 62]\ngoal = [140, 66]";
    for (old, new, need) in [
        (hopper, "start = [60, 62]", "robots.goal: need a cell (x, y), got nothing for robot 2"),
        (hopper, "goal = [140, 66]", "robots.start: need a cell (x, y), got nothing for robot 2"),
        (
            hopper,
            "start = [60, 62]\ngoal = [200, 66]",
            "robots.goal: need a cell on the map, got (200, 66) of robot 2",
        ),
        (hopper, "start = [60, 62]\ngoal = [60, 62]", "robots.goal: need another cell than its start"),
        (
            hopper,
            "start = [8, 60]\ngoal = [140, 66]",
            "robots.start: need a cell of its own for each robot on the ground, got (8, 60) of robot 2 and robot 0",
        ),
        (hopper, "start = [60, 62]\ngoal = [192, 150]", "robots.goal: need a cell of its own"),
        (
            hopper,
            "start = [60, 62]\ngoal = [140, 66]\nbudget_m = 3.0",
            "need vehicle = \"helicopter\", got hopper for robot 2",
        ),
        (
            "goal = [192, 150]",
            "goal = [100, 62]",
            "robots.goal: need a cell whose true speed is above 0, got (100, 62) of robot 0",
        ),
        ("start = [10, 100]", "start = [100, 62]", "robots.start: need ground without obstacle"),
        (
            "start = [8, 60]\nspeed_mps",
            "start = [8, 60]\ngoal = [9, 9]\nspeed_mps",
            "robots.goal: need none for a helicopter",
        ),
        (
            "start = [8, 60]\nspeed_mps",
            "start = [8, 60]\nrequired = true\nspeed_mps",
            "robots.required: need false for a helicopter",
        ),
        (
            "sensor = { gain = 4.0 }",
            "sensor = { radius_min_m = 0.5 }",
            "robots.sensor.radius_min_m: need at least one hop, so that the hopper sees where it may land, got 0.5 m for robot 3",
        ),
        (
            "sensor = { gain = 4.0 }",
            "launch_angle_deg = 90.0",
            "robots.launch_angle_deg: need 0.573 to 89.381 degrees, got 90 for robot 3",
        ),
        (
            "sensor = { gain = 4.0 }",
            "sensor = { gain = -4.0 }",
            "robots.sensor.gain: need 0 to 1e6, got -4 for robot 3",
        ),
        (
            "sensor = { gain = 4.0 }",
            "sensor = { radius_max_m = 1.0, radius_min_m = 2.0 }",
            "robots.sensor.radius_max_m: need radius_min_m to 1e6 m, got 1 for robot 3",
        ),
        (
            "sensor = { gain = 4.0 }",
            "sand = { intended = 1.5, stuck = -0.5, sideways = 0.0, flights = 1 }",
            "robots.sand: need probabilities, 0 to 1, got 1.5 for robot 3",
        ),
        ("sensor = { gain = 4.0 }", "sensor = { gradient = \"measured\" }", "unknown field `gradient`"),
        (
            "sensor = { gain = 4.0 }",
            "hard = { intended = 0.9, stuck = 0.9, sideways = 0.0, flights = 1 }",
            "robots.hard: need intended + stuck + 2 x sideways = 1, got 0.9 + 0.9 + 2 x 0 = 1.8 for robot 3",
        ),
        (
            "start = [10, 100]",
            "start = [10, 100]\nsensor = { gain = 4.0 }",
            "robots: need vehicle = \"hopper\" for launch_angle_deg, hard, sand and sensor, got sensor of robot 5, a rover",
        ),
        ("speed_mps = 5.0", "speed_mps = 0.0", "robots.speed_mps: need 0.001 to 1000 m/s, got 0 for robot 1"),
        (
            "sensor = { gain = 4.0 }",
            "speed_mps = nan",
            "robots.speed_mps: need a rover or a helicopter, got NaN for robot 3, a hopper",
        ),
        (
            "speed_mps = 5.0",
            "sensor_range_cells = 9",
            "robots.sensor_range_cells: need a rover that covers ground: others see as far as their sensor, got 9 for robot 1",
        ),
        (
            "profile = \"hopper\"",
            "profile = \"hopper\"\nstart = [1, 1]\ngoal = [2, 2]",
            "brief.start, brief.goal: need neither",
        ),
        (
            "kind = \"mixed\"\npercent = 1",
            "kind = \"cover\"\npercent = 1",
            "mission.kind = \"mixed\", for either",
        ),
        ("percent = 1", "percent = 0", "mission.percent: need 1 to 100 %"),
        ("[limits]", "[[faults]]\nrobot = 6\naction = 1\n\n[limits]", "faults: need a robot of the mission"),
    ] {
        let error = refusal(old, new);
        assert!(error.contains(need), "{need}: {error}");
    }
    let hills = "[truth.terrain.obstacles]\nwidth_cells = 9\nheight_cells = 9\ncell_size_m = 1.0\npercent = 0.0\nseed = 0\n\
        [mission]\nkind = \"mixed\"\n[brief]\nprofile = \"hopper\"\n";
    let robot = |text: &str| format!("[[robots]]\nvehicle = {text}\n");
    let designs: String = (0..5)
        .map(|row| {
            robot(&format!(
                "\"hopper\"\nstart = [0, {row}]\ngoal = [5, {row}]\nsensor = {{ gain = {row}.5 }}"
            ))
        })
        .collect();
    let many: String =
        (0..17).map(|robot| format!("[[robots]]\nstart = [{}, {}]\n", robot % 9, robot / 9)).collect();
    for (robots, need) in [
        (
            robot("\"rover\"\nstart = [1, 1]\ngoal = [2, 2]"),
            "robots.goal: need none on ground without speeds",
        ),
        (
            robot("\"helicopter\"\nstart = [1, 1]"),
            "robots.required: need at least one robot that the mission needs",
        ),
        (
            robot("\"helicopter\"\nstart = [1, 1]\naccuracy = 0.9"),
            "robots.accuracy: need none on ground without speeds",
        ),
        (designs, "robots: need hoppers of at most 4 designs beside that of [robot], got more"),
        (many, "robots: need 1 to 16 of them, each with a start, got 17"),
        (String::new(), "robots: need 1 to 16 of them, each with a start, got 0"),
    ] {
        let error =
            Scenario::parse(&format!("{hills}{robots}"), "test").unwrap().resolve().unwrap_err().to_string();
        assert!(error.contains(need), "{need}: {error}");
    }
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
        [mission]\nkind = \"mixed\"\n[brief]\nprofile = \"hopper\"\n[[robots]]\nstart = [1, 1]\nspeed_mps = 0.3\n";
    assert!(Scenario::parse(ground, "test").unwrap().resolve().is_ok());
    let hopper = "[[robots]]\nvehicle = \"hopper\"\nstart = [2, 2]\ngoal = [5, 5]\n";
    let error = Scenario::parse(&(ground.to_owned() + hopper), "test").unwrap().resolve().unwrap_err();
    assert!(error.to_string().contains("hop"), "{error}");
}
