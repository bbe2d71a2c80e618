//! A motion table that planners believe: read from a file, served to them, planned with.

use std::fmt::Write as _;

use crate::harness::{Mission, json, stderr};
use serde_json::Value;

/// Hills whose hops are followed by physics; planners believe `table.toml`.
const HILLS: &str = r#"
[truth.terrain.gaussians]
width_cells = 12
height_cells = 12
cell_size_m = 1.0
sigma_m = 1.5
amplitude_m = 0.5
raised_m = [[5, 5], [3, 8]]
[truth.sand]
rectangles = [{ x = [6, 8], y = [2, 6] }]
[truth.dynamics]
model = "contact"
[brief]
profile = "hopper"
start = [1, 1]
goal = [10, 10]
"#;

/// The key that gives planners the table.
const BELIEVED: &str = "[brief.motion]\ntable = \"table.toml\"\n";

/// The law of P23 on level ground as a table that knows no slope: forward, to the left, and the probability, on hard ground and on sand.
const LAW: [&[(i32, i32, f64)]; 2] =
    [&[(1, 0, 0.9), (0, 1, 0.05), (0, -1, 0.05)], &[(1, 0, 0.7), (0, 0, 0.1), (0, 1, 0.1), (0, -1, 0.1)]];

/// What physics gives on gentle ground, in round numbers.
const PHYSICS: [&[(i32, i32, f64)]; 2] = [
    &[(1, 0, 0.95), (0, 0, 0.01), (1, 1, 0.01), (1, -1, 0.01), (2, 0, 0.02)],
    &[(1, 0, 0.94), (0, 0, 0.04), (1, 1, 0.01), (1, -1, 0.01)],
];

/// A table in which each class of a soil has these landings.
fn table(soils: [&[(i32, i32, f64)]; 2]) -> String {
    let mut text = "hop_m = 1.0\n".to_owned();
    for (soil, landings) in ["hard", "sand"].into_iter().zip(soils) {
        let landing = |(forward, left, probability): &(i32, i32, f64)| {
            format!("{{ offset = [{forward}, {left}], probability = {probability} }}")
        };
        let landings = landings.iter().map(landing).collect::<Vec<_>>().join(", ");
        let bins = || (-12..=12).map(|bin| 2.5 * f64::from(bin));
        for (along, across) in bins().flat_map(|along| bins().map(move |across| (along, across))) {
            let slopes = format!("along_deg = {along}\nacross_deg = {across}");
            let _ = write!(text, "[[classes]]\nsoil = \"{soil}\"\n{slopes}\nlandings = [{landings}]\n");
        }
    }
    text
}

/// A folder with scenario and table.
fn folder(name: &str, scenario: &str, table: &str) -> Mission {
    let mission = Mission::new(name);
    std::fs::write(mission.path("hills.toml"), scenario).unwrap();
    std::fs::write(mission.path("table.toml"), table).unwrap();
    mission
}

/// The actions of a mission flown in lockstep into `out`.
fn actions(mission: &Mission, out: &str) -> Vec<Value> {
    let words = ["run", "--lockstep", "--scenario", "hills.toml", "--seed", "5", "--out", out];
    let output = mission.hopper(&words).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    actions_in(mission, out)
}

/// The actions in the journal of a mission that was flown into `out`.
fn actions_in(mission: &Mission, out: &str) -> Vec<Value> {
    let journal = format!("{out}/journal");
    let output = mission.hopper(&["journal", "show", &journal, "--format", "json"]).output().unwrap();
    let records = json(&output)["records"].as_array().unwrap().clone();
    records.iter().map(|record| record["action"].clone()).collect()
}

/// P-TABLE-LIVE: A mission whose planners believe a motion table, and of which planner and hopper-sim are killed in flight, ends with the
/// digest of lockstep; planners that would believe the law are refused.
#[test]
fn a_mission_by_table_is_flown_live_under_kills() {
    let mission = folder("table", &format!("{HILLS}{BELIEVED}"), &table(PHYSICS));
    let words = ["--scenario", "hills.toml", "--seed", "5"];
    let mut sim = mission.start_sim_until(4, &words);
    let _perception = mission.start("perception", &[]);
    let _monitor = mission.start("monitor", &[]);
    let greedy = mission.start("planner", &["--algorithm", "greedy"]);
    greedy.await_log("needs one of the planners mdp, hold, got greedy");
    let mut planner = mission.start("planner", &[]);
    assert_eq!(sim.code(), -1, "{}", sim.log());
    planner.kill();
    let _planner = mission.start("planner", &[]);
    let mut sim = mission.start("sim", &words);
    assert_eq!(sim.code(), 0, "{}", sim.log());
    let digest = sim.json()["digest"].clone();
    assert_eq!(mission.verified()["digest"], digest);
    mission.assert_as_lockstep("journal");
}

/// P-TABLE-LAW: The law is the table with four landings: on level ground `mdp` takes the same hops by either.
#[test]
fn by_the_law_as_a_table_the_same_hops_are_taken() {
    let level = HILLS.replace("amplitude_m = 0.5", "amplitude_m = 0.0").replace("\"contact\"", "\"law\"");
    let law = folder("law", &level, "");
    let by_table = folder("law-table", &format!("{level}{BELIEVED}"), &table(LAW));
    let need = actions(&law, "out");
    assert!(need.len() > 10);
    assert_eq!(actions(&by_table, "out"), need);
}

/// P-TABLE-FLAG: `--table` is the same mission as the scenario's key, and a scenario without a hopper refuses it by name.
#[test]
fn a_table_may_be_given_on_the_command_line() {
    let written = folder("table-key", &format!("{HILLS}{BELIEVED}"), &table(PHYSICS));
    let given = folder("table-flag", HILLS, &table(PHYSICS));
    let words = ["run", "--lockstep", "--scenario", "hills.toml", "--seed", "5", "--table", "table.toml"];
    let flown = given.hopper(&[&words[..], &["--out", "flag"]].concat()).output().unwrap();
    assert_eq!(flown.status.code(), Some(0), "{}", stderr(&flown));
    assert_eq!(actions_in(&given, "flag"), actions(&written, "key"));
    let hash = |mission: &Mission, words: &[&str]| {
        let words = [&["scenario", "check", "hills.toml", "--format", "json"], words].concat();
        json(&mission.hopper(&words).output().unwrap())["hash"].clone()
    };
    let need = hash(&written, &[]);
    assert!(need.is_string(), "{need}");
    assert_eq!(hash(&given, &["--table", "table.toml"]), need);
    assert_ne!(hash(&given, &[]), need);

    let refused = given.hopper(&["scenario", "check", "coverage", "--table", "table.toml"]).output().unwrap();
    assert_eq!(refused.status.code(), Some(2));
    assert!(stderr(&refused).contains("brief.motion.table"), "{}", stderr(&refused));
    let missing = given.hopper(&["scenario", "check", "hard", "--table", "none.toml"]).output().unwrap();
    assert_eq!(missing.status.code(), Some(2));
    assert!(stderr(&missing).contains("none.toml"), "{}", stderr(&missing));
}

/// P-TABLE-CONTENTS: Another table is another mission: a journal is not resumed with it.
#[test]
fn a_journal_is_of_its_table() {
    let mission = folder("other-table", &format!("{HILLS}{BELIEVED}"), &table(PHYSICS));
    assert!(!actions(&mission, "out").is_empty());
    std::fs::write(mission.path("table.toml"), table(LAW)).unwrap();
    let verify = ["journal", "verify", "out/journal", "--against-lockstep"];
    let output = mission.hopper(&verify).output().unwrap();
    assert_ne!(output.status.code(), Some(0));
    assert!(stderr(&output).contains("its files have other contents than they had"), "{}", stderr(&output));
}
