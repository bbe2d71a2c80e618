//! Six robots of all kinds, each with a task and a planner process of its own, fly as lockstep does.

use std::collections::BTreeSet;

use contract::{Cell, Member, Route, Standing, Status};
use serde_json::Value;

use crate::harness::{Mission, json, leaders, lockstep, stderr};

const SCENARIO: [&str; 2] = ["--scenario", "expedition"];

const PLANNERS: [&str; 6] = ["rrt_star_ett", "scout_value", "mdp", "astar", "scout_ahead", "cover_frontier"];

/// The numbers in column `robot` of a table, each once.
fn numbers_of_robots(csv: &str) -> Vec<u64> {
    let mut rows = csv.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let headings = rows.next().unwrap();
    let column = headings.iter().position(|heading| *heading == "robot").unwrap();
    let numbers: BTreeSet<u64> = rows.map(|row| row[column].parse().unwrap()).collect();
    numbers.into_iter().collect()
}

/// The recording has every route that the records of `robot` announce, under the robot's own name. Returns whether it has routes.
fn assert_routes_recorded(robot: u64, exported: &impl Fn(&[&str]) -> String) -> bool {
    let rows = |topic: &str| -> Vec<Value> {
        let text = exported(&["--topic", topic, "--format", "json"]);
        text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    };
    let records = rows("hop/past").into_iter().filter(|record| record["robot"] == robot);
    let announced: BTreeSet<String> =
        records.filter_map(|record| Some(record["action"].get("announce")?.to_string())).collect();
    if !announced.is_empty() {
        let routes = rows(&format!("hop/r{robot}/route"));
        assert!(routes.iter().all(|announcement| announcement["robot"] == robot));
        let recorded: BTreeSet<String> = routes
            .into_iter()
            .map(|announcement| serde_json::from_value::<Route>(announcement["route"].clone()).unwrap())
            .map(|route| serde_json::to_string(&route.id()).unwrap())
            .collect();
        assert!(announced.is_subset(&recorded), "robot {robot} announced {announced:?}, not {recorded:?}");
    }
    !announced.is_empty()
}

/// The commands in the recording are those of the robot that their topic names. How many there are depends on how fast the
/// recorder is, and of a robot that was done before it listened there are none. Returns how many robots have commands.
fn robots_with_commands(info: &Value, exported: &impl Fn(&[&str]) -> String) -> usize {
    let topics = info["topics"].as_array().unwrap().iter().map(|topic| topic["topic"].as_str().unwrap());
    let of_robot = |topic: &str| -> Option<u64> {
        topic.strip_prefix("hop/r")?.strip_suffix("/command").map(|robot| robot.parse().unwrap())
    };
    let mut robots = 0;
    for (topic, robot) in topics.filter_map(|topic| Some((topic, of_robot(topic)?))) {
        let text = exported(&["--topic", topic, "--format", "json"]);
        let commands: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        assert!(!commands.is_empty() && commands.iter().all(|command| command["robot"] == robot), "{topic}");
        robots += 1;
    }
    robots
}

/// P-MIXED-RUN: A mission of six robots of all kinds, each with a planner process, has the digest
/// of lockstep; summary, journal, timing and exports name the robot.
/// P-BAG-ROBOTS.
#[test]
fn an_expedition_flown_live_has_the_digest_of_lockstep() {
    let mut mission = Mission::new("mixed");
    let output = mission.fly(&[&SCENARIO[..], &["--record", "whole.mcap"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let summary = json(&output);
    assert_eq!(summary["digest"], lockstep(&SCENARIO)["digest"], "{}", stderr(&output));
    mission.assert_as_lockstep("out/journal");
    let picture = std::fs::read_to_string(mission.path("out/mission.svg")).unwrap();
    let read = mission.hopper(&["bag", "info", "whole.mcap", "--format", "json"]).output().unwrap();
    assert_eq!(read.status.code(), Some(0), "the recording can be read: {}", stderr(&read));
    let robots = summary["robots"].as_array().unwrap();
    let kinds = ["rover", "helicopter", "hopper", "hopper", "helicopter", "rover"];
    for ((robot, planner), kind) in robots.iter().zip(PLANNERS).zip(kinds) {
        assert_eq!((&robot["kind"], &robot["planner"]), (&kind.into(), &planner.into()), "{robot}");
        assert_eq!(robot["status"], "done", "{robot}");
    }
    assert_eq!(robots[2]["cell"], serde_json::json!({ "x": 140, "y": 66 }), "a hopper is on its goal");
    let actions: u64 = robots.iter().map(|robot| robot["actions"].as_u64().unwrap()).sum();
    assert_eq!(summary["decisions"], actions);
    let undisturbed = lockstep(&SCENARIO);
    assert_eq!(summary["robots"], undisturbed["robots"], "live and lockstep end alike");
    let exported = |words: &[&str]| {
        let output = mission.hopper(&[&["bag", "export", "whole.mcap"], words].concat()).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        String::from_utf8(output.stdout).unwrap()
    };
    assert_eq!(numbers_of_robots(&exported(&[])), [0, 1, 2, 3, 4, 5], "each decision has its robot");
    let timing = std::fs::read_to_string(mission.path("out/timing.csv")).unwrap();
    assert_eq!(numbers_of_robots(&timing), [0, 1, 2, 3, 4, 5]);
    let teams = exported(&["--topic", "hop/team"]);
    assert_eq!(numbers_of_robots(&teams), [0, 1, 2, 3, 4, 5], "a row a robot");
    assert!(teams.contains(",standing,") && teams.contains(",done,"), "{teams}");
    let with_routes: Vec<u64> = (0..6).filter(|robot| assert_routes_recorded(*robot, &exported)).collect();
    assert!([1, 4].iter().all(|helicopter| with_routes.contains(helicopter)), "{with_routes:?}");
    assert!((1..=6).contains(&robots_with_commands(&json(&read), &exported)), "{}", json(&read));
    let unknown = mission.hopper(&["bag", "export", "whole.mcap", "--topic", "hop/rovers"]).output().unwrap();
    assert_eq!(unknown.status.code(), Some(2));
    assert!(stderr(&unknown).contains("hop/team"), "the error names it: {}", stderr(&unknown));
    let shown = mission.hopper(&["journal", "show", "out"]).output().unwrap();
    let shown = String::from_utf8(shown.stdout).unwrap();
    let heading: Vec<&str> = shown.lines().next().unwrap().split_whitespace().take(2).collect();
    assert_eq!(heading, ["decision", "robot"], "{shown}");
    let first = shown.lines().filter_map(|line| line.split_whitespace().nth(1)?.parse::<u64>().ok());
    assert_eq!(first.take(6).collect::<Vec<_>>(), [0, 1, 2, 3, 4, 5], "{shown}");
    for robot in 0..6 {
        assert!(picture.contains(&format!(">{robot}</text>")), "robot {robot} is in the picture");
    }
    mission.assert_nothing_left();
}

/// P-MIXED-PAST: A past mission of several robots shows each robot with its own goal, and as done
/// or stranded where it is.
#[test]
fn a_past_mission_shows_how_each_robot_ended() {
    let flown = |scenario: &str| {
        let mission = Mission::new("mixed-past");
        let words = ["run", "--lockstep", "--scenario", scenario, "--out", "out"];
        let output = mission.hopper(&words).output().unwrap();
        assert!(output.stdout.starts_with(b"  outcome"), "{}", stderr(&output));
        let history = hopper::commands::view::history_of_journal(&mission.path("out/journal")).unwrap();
        let robots = history.progress().unwrap().robots.clone();
        assert_eq!(history.team().unwrap().members[..], robots);
        (history.brief().unwrap().clone(), robots)
    };
    let robots = |scenario: &str| flown(scenario).1;
    let standings = |robots: &[Member]| robots.iter().map(|member| member.standing).collect::<Vec<_>>();
    let (brief, expedition) = flown("expedition");
    assert_eq!(standings(&expedition), [Standing::Done; 6]);
    let goals = expedition.iter().zip(brief.robots.iter()).filter_map(|(member, robot)| {
        let at = if robot.body.hops() { member.at.cell } else { Cell::new(192, 150) };
        Some((robot.goal.cell(&brief.grid, 0)?, at))
    });
    let goals: Vec<(Cell, Cell)> = goals.collect();
    let own = [Cell::new(192, 150), Cell::new(140, 66), Cell::new(100, 150)];
    assert_eq!(goals, own.map(|goal| (goal, goal)), "each has its own, and hoppers are on it");
    assert_eq!(standings(&robots("coverage")), [Standing::Done; 4]);

    let mission = Mission::new("mixed-past-fault");
    let faults = "\n[[faults]]\nrobot = 2\naction = 5\n";
    let stranded = mission.path("stranded.toml");
    std::fs::write(&stranded, [include_str!("../scenarios/coverage.toml"), faults].concat()).unwrap();
    let [done, lost] = [Standing::Done, Standing::Stranded];
    assert_eq!(standings(&robots(stranded.to_str().unwrap())), [done, done, lost, done]);
}

/// P-MIXED-AT-ONCE: A mission whose robots have nothing to do is at its goal in its summary, in its
/// journal and when repeated.
#[test]
fn a_mission_with_nothing_to_do_is_at_its_goal_wherever_it_is_shown() {
    let mission = Mission::new("mixed-at-once");
    // The rover is within 3 m of its goal.
    let text = "[truth.terrain.obstacles]\nwidth_cells = 8\nheight_cells = 8\ncell_size_m = 1.0\npercent = 0.0\nseed = 0\n\
        [truth.mobility]\nseed = 1\nspeeds = [0.0, 0.0, 0.0, 1.0]\n[brief]\nname = \"at-once\"\nstart = [1, 1]\ngoal = [2, 1]\n\
        [[robots]]\nbody = \"driver\"\n";
    std::fs::write(mission.path("at-once.toml"), text).unwrap();
    let json = |words: &[&str]| -> Value {
        let output = mission.hopper(words).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{words:?}: {}", stderr(&output));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let run = ["run", "--lockstep", "--scenario", "at-once.toml", "--format", "json", "--out"];
    let summary = json(&[&run[..], &["out"]].concat());
    assert_eq!((&summary["outcome"], &summary["hops"]), (&"goal".into(), &0.into()));
    let shown = json(&["journal", "show", "out", "--format", "json"]);
    assert_eq!((&shown["outcome"], &shown["decisions"]), (&"goal".into(), &0.into()));
    let again = json(&[&run[..], &["again", "--planners-from", "out"]].concat());
    assert_eq!(again["digest"], summary["digest"]);
    let history = hopper::commands::view::history_of_journal(&mission.path("out/journal")).unwrap();
    assert_eq!(history.progress().unwrap().status, Status::Goal);
}

/// P-MIXED-KILL: In a mission of robots of all kinds any process may be killed and restarted, and a
/// hopper's planner swapped. An unsuited planner that is told to take over stands by. The journal
/// is that of lockstep.
#[test]
fn any_process_of_an_expedition_may_die_and_the_journal_is_that_of_lockstep() {
    let mission = Mission::new("mixed-kill");
    let sim_words = [&SCENARIO[..], &["--pace", "40"]].concat();
    let words =
        |robot: usize| ["--robot", ["0", "1", "2", "3", "4", "5"][robot], "--algorithm", PLANNERS[robot]];
    let mut sim = mission.start_sim_until(50, &sim_words);
    let mut perception = mission.start("perception", &[]);
    let mut planners: Vec<_> = (0..6).map(|robot| mission.start("planner", &words(robot))).collect();
    let mut unsuited = mission.start("planner", &["--robot", "5", "--algorithm", "mdp", "--takeover"]);
    mission.await_decisions(20);
    planners[2].kill();
    planners[2] = mission.start("planner", &words(2));
    assert_eq!(sim.code(), -1, "{}", sim.log());
    let begun = mission.start_sim_until(100, &sim_words);
    mission.await_decisions(90);
    perception.kill();
    let mut perception = mission.start("perception", &[]);
    mission.await_decisions(130);
    planners[5].kill();
    planners[5] = mission.start("planner", &words(5));
    let greedy = ["--robot", "3", "--algorithm", "greedy"];
    let (mut sim, mut greedy) = mission.hand_over(begun, &sim_words, Some(&planners[3]), &greedy);
    unsuited.await_log("robot 5 of scenario expedition needs one of the planners");
    assert_eq!(sim.code(), 0, "{}", sim.log());
    unsuited.kill();
    for process in planners.iter_mut().chain([&mut perception, &mut greedy]) {
        assert_eq!(process.code(), 0, "{}", process.log());
    }
    let verified = mission.verified();
    assert_eq!((&verified["contiguous"], &verified["duplicates"]), (&true.into(), &0.into()));
    let led = leaders(&verified);
    for (robot, term, planner) in
        [(2, 2, "mdp"), (3, 2, "greedy"), (5, 2, "cover_frontier"), (0, 1, "rrt_star_ett")]
    {
        assert!(led.contains(&(robot, term, planner.into())), "{led:?}");
    }
    mission.assert_as_lockstep("journal");
}

/// P-MIXED-CREW: Sixteen robots, each with a planner process, fly live with a stand-by planner and
/// a monitor, and the mission is that of lockstep.
#[test]
fn sixteen_robots_fly_with_a_planner_process_each() {
    let mut mission = Mission::new("sixteen");
    let ground = "[truth.terrain.obstacles]\nwidth_cells = 16\nheight_cells = 16\ncell_size_m = 1.0\npercent = 0.0\nseed = 1\n\
        [brief]\nprofile = \"hopper\"\n";
    let robot = |number: i32| {
        let (x, y) = (number % 4 * 3, number / 4 * 3);
        format!("[[robots]]\nbody = \"rover\"\nstart = [{x}, {y}]\ngoal = {{ cover = 20 }}\n")
    };
    let hopper = "[[robots]]\nbody = \"hopper\"\nstart = [15, 15]\ngoal = [12, 15]\nrequired = false\n";
    let rovers: String = (0..15).map(robot).collect();
    std::fs::write(mission.path("sixteen.toml"), [ground, &rovers, hopper].concat()).unwrap();
    let mut peers = vec![mission.start("perception", &[]), mission.start("monitor", &[])];
    let numbers: Vec<String> = (0..16).map(|number: usize| number.to_string()).collect();
    for number in &numbers {
        let algorithm = if number == "15" { "mdp" } else { "cover_frontier" };
        peers.push(mission.start("planner", &["--robot", number, "--algorithm", algorithm]));
    }
    // Two for robot 1: one of them stands by.
    peers.push(mission.start("planner", &["--robot", "1", "--algorithm", "cover_frontier"]));
    for peer in &peers {
        peer.await_log("joined instance");
    }
    let mut sim = mission.start("sim", &["--scenario", "sixteen.toml"]);
    assert_eq!(sim.code(), 0, "{}", sim.log());
    for peer in &mut peers {
        assert_eq!(peer.code(), 0, "{}", peer.log());
    }
    mission.assert_as_lockstep("journal");
    mission.assert_nothing_left();
}
