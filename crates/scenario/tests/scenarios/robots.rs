//! Missions of several robots.

use contract::Account;
use scenario::{Scenario, ScenarioCheck, load};

use crate::says;

const DRIVER: &str = "[[robots]]\nbody = \"driver\"\n";
const HELICOPTER: &str = "[[robots]]\nbody = \"helicopter\"\n";

#[test]
fn a_check_tells_what_rovers_cover_and_what_they_are() {
    let told = ScenarioCheck::of(&load("coverage").unwrap().resolve().unwrap()).to_string();
    says(&told, &["cover 100 % of the cells that can be reached, together", "robot 3", "sees 3 x 3 cells"]);
    assert!(!told.contains("hops of") && !told.contains("payoff"), "{told}");
}

/// P-SENSOR-DRAWN: A camera that errs is right as often as the scenario says; at accuracy 1 it is a
/// camera without error.
#[test]
fn a_camera_that_errs_is_right_as_often_as_the_scenario_says() {
    let world = |accuracy: &str| {
        let text = format!("[truth.terrain.passages]\nseed = 3\n[brief]\n{DRIVER}{HELICOPTER}{accuracy}\n");
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
            "[truth.terrain.passages]\nseed = 3\n[brief]\n{DRIVER}{HELICOPTER}[sampling]\n{stages}\n"
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

/// What a mission is follows from its robots.
#[test]
fn the_account_follows_from_the_robots() {
    let ground = "[truth.terrain.obstacles]\nwidth_cells = 9\nheight_cells = 9\ncell_size_m = 1\npercent = 0\nseed = 1\n\
                  [truth.mobility]\nspeeds = [0, 0, 0, 1]\n[brief]\n";
    let robot = |body: &str, row: u32| {
        format!("[[robots]]\nbody = \"{body}\"\nstart = [0, {row}]\ngoal = [8, {row}]\n")
    };
    let (hopper, driver) = (|row| robot("hopper", row), |row| robot("driver", row));
    let rover = "[[robots]]\nbody = \"rover\"\nstart = [5, 5]\n";
    let account = |robots: &[&str]| {
        let text = format!("{ground}{}", robots.concat());
        Scenario::parse(&text, "test").unwrap().account()
    };
    assert_eq!(account(&[]), Account::Hopper);
    assert_eq!(account(&[&hopper(1)]), Account::Hopper);
    assert_eq!(account(&[&hopper(1), HELICOPTER, HELICOPTER]), Account::Hopper);
    assert_eq!(account(&[HELICOPTER, &hopper(1)]), Account::ActionsWithoutWaits);
    assert_eq!(account(&[&driver(1)]), Account::Actions);
    assert_eq!(account(&[HELICOPTER, &driver(1), HELICOPTER]), Account::Actions);
    assert_eq!(account(&[&driver(1), &driver(2)]), Account::ActionsWithoutWaits);
    assert_eq!(account(&[&driver(1), &hopper(2)]), Account::ActionsWithoutWaits);
    assert_eq!(account(&[rover]), Account::ActionsWithoutWaits);
    assert_eq!(account(&[rover, HELICOPTER]), Account::ActionsWithoutWaits);
    let world = Scenario::parse(&format!("{ground}{rover}{}", driver(1)), "test").unwrap().resolve().unwrap();
    assert_eq!(world.brief.account, Account::ActionsWithoutWaits);
}

/// A field at its default is left out of the canonical text, and so of the hash.
#[test]
fn robots_that_state_defaults_are_those_that_leave_them_out() {
    let world = |robots: &str| {
        let text = include_str!("../../../../scenarios/expedition.toml");
        let head = text.split_once("[[robots]]").unwrap().0;
        Scenario::parse(&format!("{head}{robots}"), "test").unwrap().resolve().unwrap()
    };
    let plain = world(
        "[[robots]]\nbody = \"hopper\"\nstart = [60, 62]\ngoal = [140, 66]\n\
         [[robots]]\nbody = \"driver\"\n\
         [[robots]]\nbody = \"rover\"\nstart = [10, 100]\n\
         [[robots]]\nbody = \"helicopter\"\n",
    );
    let stated = world(
        "[[robots]]\nbody = \"hopper\"\nstart = [60, 62]\ngoal = [140, 66]\nheading = \"north\"\nrequired = true\n\
         launch_angle_deg = 45.0\nhard = { intended = 0.9, stuck = 0.0, sideways = 0.05, flights = 1 }\n\
         sand = { intended = 0.7, stuck = 0.1, sideways = 0.1, flights = 2 }\nsensor = { gain = 2.0, offset_m = 1.0 }\n\
         planner = \"mdp\"\n\
         [[robots]]\nbody = \"driver\"\nrequired = true\n\
         [[robots]]\nbody = \"rover\"\nstart = [10, 100]\nheading = \"north\"\nspeed_mps = 1.0\nsensor_range_cells = 1\n\
         goal = { cover = 100, mode = \"overlap\" }\n\
         [[robots]]\nbody = \"helicopter\"\nspeed_mps = 1.0\nbudget_m = 300.0\naccuracy = 1.0\n\
         [sampling]\nrover_samples = 1200\nhelicopter_samples = 600\nstages = 1\n",
    );
    assert_eq!(stated.hash, plain.hash);
    assert_eq!(stated.resolved.replace("planner = \"mdp\"\n", ""), plain.resolved);
    for left_out in ["heading", "required", "speed_mps", "\nbudget_m", "radius_m = 2", "mode", "sampling"] {
        assert!(!plain.resolved.contains(left_out), "{left_out}: {}", plain.resolved);
    }
}
