//! The page without a server, in Node and in a real browser.

#![allow(clippy::print_stdout, reason = "what a test could not do is said")]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "../../../tests/harness/chromium.rs"]
mod chromium;

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::{Arc, OnceLock};

use browser::{Outcome, Request};
use chromium::{chromium, playwright};
use hopper_site::{TARGET, differences, has_target, missions};
use serde_json::Value;

/// Seeds in Node; `hopper-site check` takes any number.
const NODE_SEEDS: u64 = 40;

/// Seeds in Chromium.
const CHROMIUM_SEEDS: u64 = 8;

fn hopper_site(words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hopper-site")).args(words).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// The built folder; `None`, and a line that says so, where the target cannot be installed.
fn site() -> Option<PathBuf> {
    static SITE: OnceLock<Option<PathBuf>> = OnceLock::new();
    SITE.get_or_init(|| {
        if !has_target() {
            let added = Command::new("rustup").args(["target", "add", TARGET]).status();
            if !added.is_ok_and(|status| status.success()) {
                println!("not tested: the page without a server needs the target {TARGET}, which cannot be installed here");
                return None;
            }
        }
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("site");
        let built = hopper_site(&["build", &folder.to_string_lossy()]);
        assert_eq!(built.status.code(), Some(0), "{}", text(&built.stderr));
        println!("{}", text(&built.stdout));
        Some(folder)
    })
    .clone()
}

/// P-BROWSER-DIGEST: As WebAssembly, missions of hoppers under every motion model, with a planner that takes
/// over, of rovers that cover ground, and of rover and helicopter end with the digest, the map and the steps of the native
/// program, bit for bit.
#[test]
fn missions_as_web_assembly_end_as_on_this_machine() {
    if suites::is_left_out("site") {
        return;
    }
    let Some(site) = site() else { return };
    let mut missions = missions(NODE_SEEDS);
    missions.extend([
        r#"{"scenario":"coverage","seed":1}"#.to_owned(),
        r#"{"scenario":"coverage-8","seed":2}"#.to_owned(),
        r#"{"scenario":"hard","seed":5,"planners":[{"from":0,"planner":"mdp"},{"from":9,"planner":"greedy"}]}"#.to_owned(),
    ]);
    assert_eq!(differences(&site, &missions).unwrap(), Vec::<String>::new());
}

/// P-BROWSER-PAGE: In a real browser, below any path, the page without a server flies what its link
/// says; a click swaps the planner, the link of what was flown repeats it, and a dropped elevation
/// model becomes the ground.
#[test]
fn the_page_flies_missions_without_a_server() {
    if suites::is_left_out("site") {
        return;
    }
    let Some(site) = site() else { return };
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("site-page");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("model.asc"), model()).unwrap();
    let missions = missions(CHROMIUM_SEEDS);
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/drive.mjs");
    let mut node = Command::new("node")
        .arg(script)
        .args([playwright(), chromium(), site, folder.clone()])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap_or_else(|error| panic!("the page's test needs node on PATH, got: {error}"));
    std::io::Write::write_all(&mut node.stdin.take().unwrap(), missions.join("\n").as_bytes()).unwrap();
    let output = node.wait_with_output().unwrap();
    let seen: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(seen["failure"], Value::Null, "{seen}");
    assert_eq!(seen["errors"], serde_json::json!([]), "the console is clean");
    assert_eq!(seen["elsewhere"], serde_json::json!([]), "nothing is asked of anybody else");
    assert_eq!(seen["violations"], serde_json::json!([]), "axe-core finds nothing");
    let linked = &seen["linked"];
    assert_eq!((&linked["scenario"], &linked["profile"]), (&"hard".into(), &"paper-2023".into()));
    assert_eq!(linked["hop"], 6, "the mission waits at the hop of the link");
    assert_eq!(linked["leaders"], serde_json::json!(["greedy", "mdp"]));
    assert_eq!(linked["from"], serde_json::json!(["4", "0"]));
    assert_eq!(seen["peers"], serde_json::json!(["finished"]), "nobody fell silent");
    let link = seen["link"].as_str().unwrap();
    assert!(
        link.starts_with("#scenario=hard&seed=3&profile=paper-2023&planner=mdp,greedy@4,astar@"),
        "{link}"
    );
    assert_eq!((&seen["again"], &seen["hops"][1]), (&seen["end"], &seen["hops"][0]), "{seen}");
    let outcomes = seen["outcomes"].as_array().unwrap();
    assert_eq!(outcomes.len(), missions.len());
    for (mission, outcome) in missions.iter().zip(outcomes) {
        let request: Request = serde_json::from_str(mission).unwrap();
        let got: Outcome = serde_json::from_str(outcome.as_str().unwrap()).unwrap();
        assert_eq!(got, browser::fly(&request, &Arc::from([])).unwrap(), "{mission} in Chromium");
    }
}

/// A smooth elevation model of 160 x 110 cells of 4.98 m.
fn model() -> String {
    let (width, height) = (160, 110);
    let mut text = format!("ncols {width}\nnrows {height}\nxllcorner 0\nyllcorner 0\ncellsize 4.98\n");
    for y in 0..height {
        let row: Vec<String> = (0..width).map(|x| ((x * 7 % 40 + y * 5 % 30) / 16).to_string()).collect();
        text += &(row.join(" ") + "\n");
    }
    text
}

/// P-BROWSER-GROUND: An elevation model held in memory gives the same mission as its file.
#[test]
fn an_elevation_model_at_hand_makes_the_mission_of_its_file() {
    if suites::is_left_out("site") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.asc");
    std::fs::write(&path, model()).unwrap();
    let world = scenario::fitted(&path).unwrap().scenario.resolve().unwrap();
    let request: Request = serde_json::from_str(r#"{"dem":"model.asc","seed":1}"#).unwrap();
    let outcome = browser::fly(&request, &model().into_bytes().into()).unwrap();
    let hash: String = world.hash.iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(outcome.scenario_hash, hash);
    assert_eq!(outcome.status, "goal");
}

#[test]
fn what_cannot_be_flown_is_one_sentence() {
    if suites::is_left_out("site") {
        return;
    }
    for (request, need) in [
        (r#"{}"#, "a scenario or an elevation model"),
        (r#"{"scenario":"moon"}"#, "needs to be one of hard"),
        (r#"{"scenario":"hard","profile":"mine"}"#, "profile"),
        (r#"{"scenario":"hard","planners":[{"from":0,"planner":"oracle"}]}"#, "oracle"),
        (r#"{"scenario":"hard","planners":[{"from":3,"planner":"mdp"}]}"#, "the first from 0 on"),
        (r#"{"scenario":"hard","planners":[{"from":0,"planner":"cover_frontier"}]}"#, "another planner"),
        (r#"{"scenario":"coverage","planners":[{"from":0,"planner":"mdp"}]}"#, "another planner"),
        (r#"{"dem":"noise.tif"}"#, "GeoTIFF"),
    ] {
        let request: Request = serde_json::from_str(request).unwrap();
        let error = browser::fly(&request, &Arc::from([])).unwrap_err();
        assert!(error.contains(need) && !error.contains('\n'), "{request:?}: {error}");
    }
}

#[test]
fn a_folder_with_other_files_is_left_as_it_is() {
    if suites::is_left_out("site") {
        return;
    }
    if !has_target() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("mine.txt"), "mine").unwrap();
    let refused = hopper_site(&["build", &folder.path().to_string_lossy()]);
    assert_eq!(refused.status.code(), Some(2), "{}", text(&refused.stderr));
    assert!(text(&refused.stderr).contains("a new folder or one built before"), "{}", text(&refused.stderr));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}
