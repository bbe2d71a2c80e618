//! Missions of several robots.

use scenario::{Scenario, ScenarioCheck, load};

use crate::says;

const ROVER: &str = "[[robots]]\nvehicle = \"rover\"\n";
const HELICOPTER: &str = "[[robots]]\nvehicle = \"helicopter\"\n";

#[test]
fn a_check_tells_what_rovers_cover_and_what_they_are() {
    let told = ScenarioCheck::of(&load("coverage").unwrap().resolve().unwrap()).to_string();
    says(&told, &["cover 100 % of the cells that can be reached, together", "robot 3", "sees 3 x 3 cells"]);
    assert!(!told.contains("hops of") && !told.contains("payoff"), "{told}");
}

/// P-SCOUT-SCENARIO: Every scenario of rover and helicopter that is impossible is refused with one
/// error that names the reason.
/// P-STAGES-SCENARIO.
#[test]
fn missions_with_scouts_that_cannot_be_are_refused_by_name() {
    let resolve = |terrain: &str, mission: &str, robots: &str| {
        let text = format!("[truth.terrain.{terrain}\n[mission]\n{mission}\n[brief]\n{robots}");
        Scenario::parse(&text, "scouts").unwrap().resolve().map(|world| world.planners.len())
    };
    let error = |terrain, mission, robots: &str| resolve(terrain, mission, robots).unwrap_err().to_string();
    let passages = "passages]\nseed = 3";
    let scout = "kind = \"scout\"";
    assert_eq!(resolve(passages, scout, &[ROVER, HELICOPTER].concat()).unwrap(), 2);
    assert_eq!(resolve(passages, scout, &[HELICOPTER, ROVER, HELICOPTER].concat()).unwrap(), 3);
    let with = |field: &str| format!("{ROVER}{HELICOPTER}{field}\n");
    let open = "obstacles]\nwidth_cells = 9\nheight_cells = 9\ncell_size_m = 1\npercent = 0\nseed = 1";
    let cover = "kind = \"cover\"";
    for (error, need) in [
        (error(passages, scout, ""), "robots"),
        (error(passages, scout, HELICOPTER), "one rover"),
        (error(passages, scout, &ROVER.repeat(2)), "one rover"),
        (error(passages, scout, &[ROVER, &HELICOPTER.repeat(16)].concat()), "1 to 16"),
        (error(passages, scout, &with("start = [3, 4]")), "robots.start"),
        (
            error(passages, scout, &with("budget_m = -1")),
            "robots.budget_m: need 0 to 1e6 m, got -1 for robot 1",
        ),
        (error(passages, scout, &with("view_radius_m = 0")), "got 0 for robot 1"),
        (error(passages, scout, &with("speed_mps = 0")), "robots.speed_mps"),
        (error(passages, scout, &with("accuracy = 1.01")), "got 1.01 for robot 1"),
        (
            error(passages, scout, &with(&format!("accuracy = 0.9\n{HELICOPTER}accuracy = 0.8"))),
            "the same for all",
        ),
        (error(passages, scout, &format!("{ROVER}accuracy = 0.9\n{HELICOPTER}")), "vehicle = \"helicopter\""),
        (error(passages, scout, &format!("{ROVER}budget_m = 9\n")), "vehicle = \"helicopter\""),
        (error(passages, scout, &with("[[faults]]\nrobot = 2\naction = 1")), "faults"),
        (error(passages, "kind = \"scout\"\nrover_samples = 0", ROVER), "mission.rover_samples"),
        (error(passages, "kind = \"scout\"\nstages = 0", &with("")), "mission.stages: need 1 to 64, got 0"),
        (error(passages, "kind = \"scout\"\nstages = 65", &with("")), "mission.stages: need 1 to 64, got 65"),
        (error(passages, "kind = \"scout\"\nstages = 2", ROVER), "1 without a helicopter"),
        (error(open, "kind = \"cover\"\nstages = 1", &format!("{ROVER}start = [0, 0]\n")), "scout"),
        (error(passages, "kind = \"reach\"", "start = [0, 0]\ngoal = [9, 9]"), "mission.kind"),
        (error(open, scout, ROVER), "mission.kind"),
        (error(open, cover, &format!("{ROVER}start = [0, 0]\n{HELICOPTER}")), "robots.vehicle"),
        (error(open, cover, ROVER), "robots.start"),
        (
            error(open, cover, &format!("{ROVER}start = [0, 0]\n{ROVER}start = [1, 0]\nspeed_mps = 9\n")),
            "got 9 for robot 1",
        ),
        (
            error(open, cover, &format!("{ROVER}start = [0, 0]\nsensor_range_cells = 0\n")),
            "robots.sensor_range_cells: need 1 to 64, got 0 for robot 0",
        ),
        (error(open, cover, &format!("{ROVER}start = [0, 0]\nplanner = \"\"\n")), "for robot 0"),
        (
            error(open, "kind = \"cover\"\nhelicopter_samples = 5", &format!("{ROVER}start = [0, 0]\n")),
            "scout",
        ),
    ] {
        says(&error, &[need]);
    }
}

/// P-SENSOR-DRAWN: A camera that errs is right as often as the scenario says; at accuracy 1 it is a
/// camera without error.
#[test]
fn a_camera_that_errs_is_right_as_often_as_the_scenario_says() {
    let world = |accuracy: &str| {
        let text = format!(
            "[truth.terrain.passages]\nseed = 3\n[mission]\nkind = \"scout\"\n[brief]\n{ROVER}{HELICOPTER}{accuracy}\n"
        );
        Scenario::parse(&text, "camera").unwrap().resolve().unwrap()
    };
    let (plain, right, erring) = (world(""), world("accuracy = 1.0"), world("accuracy = 0.8"));
    assert_eq!(right.terrain, plain.terrain);
    assert_eq!((right.brief.robots, right.faults), (plain.brief.robots, plain.faults));
    let truths = erring.terrain.cells.iter().zip(&plain.terrain.cells);
    let hits = truths.filter(|(erring, plain)| {
        assert_eq!((erring.speed, plain.reading), (plain.speed, None));
        erring.reading.unwrap() == plain.speed.unwrap()
    });
    // 40,000 cells: five standard deviations are 1 %.
    let share = hits.count() as f64 / plain.terrain.cells.len() as f64;
    assert!((share - 0.8).abs() < 0.01, "{share}");
    assert_eq!(erring.brief.robots[1].sensor.accuracy(), Some(0.8));
}

/// P-STAGES-SCENARIO: One stage is the default, and a scenario that states it has the same hash.
/// Impossible numbers of stages are refused.
#[test]
fn a_mission_has_the_stages_of_its_scenario_and_one_by_default() {
    let world = |stages: &str| {
        let text = format!(
            "[truth.terrain.passages]\nseed = 3\n[mission]\nkind = \"scout\"\n{stages}\n[brief]\n{ROVER}{HELICOPTER}"
        );
        Scenario::parse(&text, "stages").unwrap().resolve().unwrap()
    };
    let (plain, one, three) = (world(""), world("stages = 1"), world("stages = 3"));
    let stages = |world: &scenario::ResolvedScenario| world.brief.sampling.unwrap().stages;
    assert_eq!([&plain, &one, &three].map(stages), [1, 1, 3]);
    assert_eq!((one.hash, &one.resolved), (plain.hash, &plain.resolved));
    assert_ne!(three.hash, plain.hash);
    let again = Scenario::parse(&three.resolved, "again").unwrap().resolve().unwrap();
    assert_eq!((again.hash, stages(&again)), (three.hash, 3));
    says(&ScenarioCheck::of(&three).to_string(), &["in 3 stages"]);
}

/// The seed of planners is public: it is that of no draw, and the same whatever the mission's.
#[test]
fn a_mission_with_scouts_tells_planners_a_seed_that_is_not_the_worlds() {
    let world = load("rover-helicopter").unwrap().resolve().unwrap();
    let seed = world.brief.sampling.unwrap().seed;
    assert!(seed > 1 << 32, "{seed}");
    assert_eq!(world.terrain.prior.len(), world.terrain.cells.len());
    let again = Scenario::parse(&world.resolved, "again").unwrap().resolve().unwrap();
    assert_eq!((again.hash, again.brief, again.faults), (world.hash, world.brief, world.faults));
}
