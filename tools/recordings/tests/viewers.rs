//! Recordings in other people's viewers.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "../../../tests/harness/mod.rs"]
mod harness;
#[path = "recording/python.rs"]
mod python;
#[path = "viewers/ros2_bag.rs"]
mod ros2_bag;

use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::Duration;

use harness::{Mission, json, skip, stderr};
use serde_json::Value;

/// How long rerun-sdk may take to install: it has hundreds of megabytes, and not every network brings them in time.
const PYPI: Duration = Duration::from_secs(120);

/// The interpreter that has rerun-sdk, if it can be installed; else the test of that name says that it is skipped, and why.
fn rerun_for(test: &str) -> Option<&'static Path> {
    static RERUN: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    match RERUN.get_or_init(|| python::environment("rerun", PYPI)) {
        Ok(python) => Some(python),
        Err(why) => {
            skip(test, &format!("rerun-sdk cannot be installed from PyPI: {why}"));
            None
        }
    }
}

/// Flies a mission by `hopper run --record a.mcap WORDS`: its summary, and what Rerun makes of the recording.
fn rerun_of(python: &Path, mission: &Mission, words: &[&str]) -> (Value, Value) {
    let mut command =
        mission.hopper(&["run", "--instance", &mission.name, "--format", "json", "--out", "out"]);
    let output = command.args(["--record", "a.mcap"]).args(words).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    (json(&output), python::read(python, "read_rerun.py", &mission.path("a.mcap")))
}

/// How many values of `component` the entity has.
fn values(rerun: &Value, entity: &str, component: &str) -> u64 {
    rerun["entities"][entity][component].as_u64().unwrap_or(0)
}

/// The most points that the entity ever shows, which have a colour each.
fn points<'a>(rerun: &'a Value, entity: &str) -> &'a Vec<Value> {
    let (places, colours) =
        (values(rerun, entity, "Points3D:positions"), values(rerun, entity, "Points3D:colors"));
    assert!(places > 0 && places == colours, "{entity}: {places} points, {colours} colours");
    rerun["points"][entity].as_array().unwrap()
}

fn coordinate(point: &Value, at: usize) -> f64 {
    point[at].as_f64().unwrap()
}

/// P-VIEWERS: PyPI's `rerun-sdk` shows map, policy, route, robot and log of a recording in one
/// frame. Skipped, with a note, where it cannot be installed within two minutes.
#[test]
fn rerun_draws_map_policy_route_robot_and_log_of_one_recording() {
    let test = "viewers::rerun_draws_map_policy_route_robot_and_log_of_one_recording";
    let Some(python) = rerun_for(test) else { return };
    let mission = Mission::new("viewers");
    let (summary, rerun) = rerun_of(python, &mission, &["--seed", "7", "--pace", "20", "--record-policies"]);
    let ground = points(&rerun, "/view/map");
    assert!(ground.len() > 50 && ground.len() <= 400, "{} cells", ground.len());
    assert!(ground.iter().all(|cell| (0..2).all(|at| (0.0..20.0).contains(&coordinate(cell, at)))));
    assert!(points(&rerun, "/view/plan").len().is_multiple_of(7), "arrows of seven points");
    let route = points(&rerun, "/view/route");
    let decisions = summary["decisions"].as_u64().unwrap();
    assert!(route.len() as u64 > decisions, "{} points for {decisions} decisions", route.len());
    let (first, last) = (&route[0], &route[route.len() - 1]);
    assert_eq!([coordinate(first, 0), coordinate(first, 1)], [1.5, 2.5], "the start of the hard scenario");
    let far = (coordinate(last, 0) - coordinate(first, 0)).hypot(coordinate(last, 1) - coordinate(first, 1));
    assert!(far > 10.0, "from {first} to {last}");
    assert!(points(&rerun, "/view/robots").len() > 20);
    assert_eq!(rerun["frames"], serde_json::json!(["r0"]));
    let states = values(&rerun, "/view/transforms", "Transform3D:translation");
    assert!(states > 1 && states <= decisions + 1, "{states} transforms");
    for entity in ["/view/map", "/view/plan", "/view/route", "/view/robots"] {
        assert!(values(&rerun, entity, "CoordinateFrame:frame") > 0, "{entity} has no frame");
    }
    assert!(values(&rerun, "/view/log", "TextLog:text") > 3, "{rerun}");
}

/// P-VIEWERS-TEAM: In a viewer, recordings of several robots show each of them: rovers that cover
/// ground, a rover with its helicopter.
#[test]
fn rerun_draws_each_of_several_robots() {
    let Some(python) = rerun_for("viewers::rerun_draws_each_of_several_robots") else { return };
    for (scenario, frames) in
        [("coverage", &["r0", "r1", "r2", "r3"][..]), ("rover-helicopter", &["r0", "r1"][..])]
    {
        let mission = Mission::new("team-viewers");
        let (_, rerun) = rerun_of(python, &mission, &["--scenario", scenario, "--seed", "3"]);
        assert_eq!(rerun["frames"], serde_json::json!(frames), "{scenario}");
        for entity in ["/view/map", "/view/route"] {
            assert!(points(&rerun, entity).len() > 50, "{scenario}: {entity}");
        }
        // A marker has 22 points; a rover on its way to a goal has one more marker there.
        let markers = points(&rerun, "/view/robots").len() / 22;
        assert_eq!(markers, frames.len() + usize::from(scenario == "rover-helicopter"));
        if scenario == "rover-helicopter" {
            points(&rerun, "/view/plan");
        }
        assert!(values(&rerun, "/view/log", "TextLog:text") > 3, "{rerun}");
    }
}

/// P-VIEWERS-LAYOUT: The layout for Foxglove and Lichtblick names topics that recordings have, and
/// colours that their clouds have.
#[test]
fn the_layout_names_topics_that_recordings_have() {
    use recording::Channel;
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/viewers/foxglove-layout.json");
    let layout: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let panels = &layout["configById"];
    let ground = panels["3D!ground"]["topics"].as_object().unwrap();
    let clouds = Channel::ALL.into_iter().filter(|channel| channel.schema() == "foxglove.PointCloud");
    let clouds: Vec<Channel> = clouds.collect();
    for topic in ground.keys() {
        assert!(clouds.iter().any(|cloud| cloud.name() == *topic), "{topic}");
    }
    // A layer need not be among those that are shown from the start.
    let is_layer = |cloud: &Channel| matches!(cloud, Channel::ViewLayer(_));
    for cloud in clouds.iter().filter(|cloud| !is_layer(cloud)) {
        assert!(ground.contains_key(&cloud.name()), "{}", cloud.name());
    }
    assert!(ground.values().all(|topic| topic["colorMode"] == "rgba-fields" && topic["visible"] == true));
    assert_eq!(panels["3D!ground"]["followTf"], recording::view::FRAME);
    assert_eq!(panels["RosOut!log"]["topicToRender"], Channel::ViewLog.name());
    assert_eq!(panels["RawMessages!state"]["topicPath"], Channel::State.name());
    for path in panels["Plot!steps"]["paths"].as_array().unwrap() {
        assert!(
            path["value"].as_str().unwrap().starts_with(&format!("{}.", Channel::State.name())),
            "{path}"
        );
    }
    let text = layout["layout"].to_string();
    assert!(panels.as_object().unwrap().keys().all(|panel| text.contains(panel)), "{text}");
}
