//! A hop is a flight: what travels with the state against closed form, and the pace of real time.

use crate::harness::{Mission, Process, eventually, json, stderr};
use serde_json::Value;

/// Surface gravity of Mars, m/s².
const GRAVITY_MPS2: f64 = 3.72;

/// A plane of 1 m cells, hops that always land, and a belt of sand that every way crosses.
const FLAT: &str = r#"
[truth.terrain.elevation_file]
file = "flat.asc"
[truth.sand]
rectangles = [{ x = [4, 4], y = [0, 8] }]
[brief]
profile = "hopper"
start = [2, 4]
goal = [6, 4]
[robot]
gravity_mps2 = 3.72
hard = { intended = 1.0, stuck = 0.0, sideways = 0.0, flights = 1 }
sand = { intended = 1.0, stuck = 0.0, sideways = 0.0, flights = 2 }
"#;

/// Writes the flat scenario into the mission's folder.
fn flat(mission: &Mission) {
    let header = "ncols 9\nnrows 9\nxllcorner 500\nyllcorner 500\ncellsize 1\n";
    std::fs::write(mission.path("flat.asc"), header.to_owned() + &"7 7 7 7 7 7 7 7 7\n".repeat(9)).unwrap();
    std::fs::write(mission.path("flat.toml"), FLAT).unwrap();
}

/// The records of the mission's journal.
fn records(mission: &Mission) -> Vec<Value> {
    let output = mission.hopper(&["journal", "show", "journal", "--format", "json"]).output().unwrap();
    json(&output)["records"].as_array().unwrap().clone()
}

/// Flies `words` in lockstep into the mission's journal; the records.
fn flown(mission: &Mission, words: &[&str]) -> Vec<Value> {
    let output = mission.hopper(&["run", "--lockstep", "--out", "."]).args(words).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    records(mission)
}

fn number(value: &Value, field: &str) -> f64 {
    value[field].as_f64().unwrap_or_else(|| panic!("{field} is a number in {value}"))
}

#[track_caller]
fn close(got: f64, need: f64) {
    assert!((got - need).abs() <= 1e-9 * need.abs().max(1.0), "need {need}, got {got}");
}

/// Nanoseconds that a hop is in the air.
fn airborne_ns(flight: &Value) -> u64 {
    (number(flight, "flight_time_s") * number(flight, "flights") * 1e9).round() as u64
}

/// P-FLIGHT: The flight in the state has the speed, angle, apex and time of the closed form.
///
/// The paper's hop on the flat: 1 m far at 45°, 0.25 m high; half of both twice from sand.
#[test]
fn a_hop_on_the_flat_has_the_papers_apex_speed_and_time() {
    let mission = Mission::new("flat");
    flat(&mission);
    let records = flown(&mission, &["--scenario", "flat.toml"]);
    let mut flights = [0, 0];
    for record in &records {
        let flight = &record["outcome"]["flight"];
        let count = number(flight, "flights");
        let range_m = 1.0 / count;
        close(number(flight, "range_m"), range_m);
        close(number(flight, "rise_m"), 0.0);
        close(number(flight, "launch_angle_rad"), std::f64::consts::FRAC_PI_4);
        close(number(flight, "apex_height_m"), range_m / 4.0);
        close(number(flight, "launch_speed_mps"), (GRAVITY_MPS2 * range_m).sqrt());
        close(number(flight, "flight_time_s"), (2.0 * range_m / GRAVITY_MPS2).sqrt());
        flights[count as usize - 1] += 1;
    }
    assert!(flights[0] >= 2 && flights[1] >= 1, "hops from hard ground and from sand: {flights:?}");
}

/// P-FLIGHT. Over the paper's hills every arc is the parabola from launch to the landing aimed at.
#[test]
fn every_hop_of_a_mission_is_a_parabola_to_the_landing_aimed_at() {
    for scenario in ["hard", "sandy"] {
        let mission = Mission::new("parabola");
        let records = flown(&mission, &["--scenario", scenario, "--seed", "5"]);
        assert!(records.len() > 20, "{} records", records.len());
        let mut intended = 0;
        for pair in records.windows(2) {
            let (from, record) = (&pair[0]["pose"], &pair[1]);
            let flight = &record["outcome"]["flight"];
            let [speed, angle, range_m, rise_m, apex_m, time_s, count] = [
                "launch_speed_mps",
                "launch_angle_rad",
                "range_m",
                "rise_m",
                "apex_height_m",
                "flight_time_s",
                "flights",
            ]
            .map(|field| number(flight, field));
            close(range_m * count, 1.0);
            // A hop is launched at where it is meant to land; some go astray.
            if record["outcome"]["branch"] == "intended" {
                close(rise_m * count, number(&record["pose"], "height_m") - number(from, "height_m"));
                intended += 1;
            }
            close(range_m, speed * angle.cos() * time_s);
            close(rise_m, speed * angle.sin() * time_s - GRAVITY_MPS2 * time_s * time_s / 2.0);
            close(apex_m, (speed * angle.sin()).powi(2) / (2.0 * GRAVITY_MPS2));
        }
        assert!(intended > 10, "{intended} hops landed where they were meant to");
    }
}

/// P-REAL-PACE: At `--pace real` the next state waits for the landing.
#[test]
fn in_real_time_the_next_state_waits_for_the_landing() {
    let mission = Mission::new("real");
    flat(&mission);
    let mut sim = mission.start("sim", &["--scenario", "flat.toml", "--pace", "real"]);
    let mut words = mission.hopper(&["topic", "echo", "state", "--format", "json", "--wait", "60s"]);
    words.args(["--instance", &mission.name]);
    let mut echo = Process::spawn("echo", words, &mission.path(""));
    let services = ["topic", "list", "--format", "json", "--instance", &mission.name];
    eventually("the echo to look on", || {
        let output = mission.hopper(&services).output().unwrap();
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let mut services = text.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
        services.any(|service| service["name"] == "hop/state" && service["nodes"] == 2)
    });
    let _peers = mission.start_peers();
    assert_eq!((sim.code(), echo.code()), (0, 0), "{}\n{}", sim.log(), echo.log());

    let moment = |value: &Value, field: &str| value[field].as_u64().unwrap();
    let text = echo.out();
    let states = text.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    let landed: Vec<Value> = states.filter(|state| !state["last"].is_null()).collect();
    assert!(!landed.is_empty(), "{text}");
    for state in &landed {
        let committed = moment(&state["last_timing"], "committed");
        let flight = &state["last"]["flight"];
        assert_eq!(moment(state, "landed") - committed, airborne_ns(flight), "{state}");
        assert!(moment(state, "published") >= moment(state, "landed"), "{state}");
    }
    let records = records(&mission);
    for pair in records.windows(2) {
        let [committed, landed] = [(0, "committed"), (1, "landed")]
            .map(|(index, field): (usize, &str)| moment(&pair[index]["timing"], field));
        assert!(landed - committed >= airborne_ns(&pair[0]["outcome"]["flight"]), "{pair:?}");
        assert!(moment(&pair[1]["timing"], "accepted") >= landed, "no command is taken in the air");
    }
    assert!(records.len() >= 4);
}
