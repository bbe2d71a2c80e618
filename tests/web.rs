//! The monitor's page: in a real browser, and before those who mean no good.

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::chromium::{chromium, playwright};
use crate::harness::{self, Mission, PATIENCE, Process, eventually, json, lockstep};
use contract::{Message as _, Policy};
use node::Node;
use process::Ports;
use rustix::process::Signal;

const ROBOT: contract::RobotId = contract::RobotId(0);

/// A slow mission of `hopper run` with a page and leave to control it; and the page's address, key included.
fn page_of(mission: &Mission, words: &[&str]) -> (Process, String) {
    let name = mission.name.as_str();
    let mut command = mission.hopper(&["run", "--instance", name, "--out", ".", "--format", "json"]);
    command.args(["--web", "127.0.0.1:0"]).args(words);
    let run = Process::spawn("run", command, &mission.path(""));
    run.await_log("page at ");
    let log = run.log();
    let rest = log.split("page at ").nth(1).unwrap();
    let url = rest.split_whitespace().next().unwrap().to_owned();
    (run, url)
}

/// The page of `hopper view WHAT`, and its address.
fn past_page_of(mission: &Mission, what: &str) -> (Process, String) {
    let command = mission.hopper(&["view", what, "--web", "127.0.0.1:0"]);
    let view = Process::spawn("view", command, &mission.path(""));
    view.await_log("page at ");
    let log = view.log();
    let url = log.split("page at ").nth(1).unwrap().split_whitespace().next().unwrap().to_owned();
    (view, url)
}

/// Where the screenshots go.
fn shots() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("page");
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn assert_is_there(folder: &Path, shots: &[&str]) {
    for shot in shots {
        assert!(folder.join(format!("{shot}.png")).metadata().unwrap().len() > 10_000, "{shot}");
    }
}

/// P-WEB-BROWSER: In a real browser a mission is paused, stepped, sped up, handed over, hidden,
/// reviewed and watched to its goal. The console stays clean, no other server is contacted, and
/// nothing overflows a narrow window.
/// P-CONTROL.
// Long: one mission goes through everything in turn.
#[test]
fn a_mission_is_watched_and_controlled_in_a_real_browser() {
    if suites::is_left_out("page in a browser") {
        return;
    }
    let (chromium, playwright, shots) = (chromium(), playwright(), shots());
    let mission = Mission::new("browser");
    let (mut run, url) = page_of(&mission, &["--control", "--seed", "5", "--pace", "0.5"]);
    // Whoever comes first is in command: the stand-by comes when the other is.
    run.await_log("mdp term 1");
    let standby = mission.start("planner", &["--algorithm", "greedy"]);
    standby.await_log("joined");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/web/drive.mjs");
    let mut drive = Command::new("node");
    let seen = json(&drive.arg(script).arg(playwright).arg(chromium).arg(&url).arg(&shots).output().unwrap());
    assert_eq!(seen["failure"], serde_json::Value::Null, "{seen}\n{}", run.log());
    assert_eq!(seen["errors"], serde_json::json!([]), "the console is clean");
    assert_eq!(seen["elsewhere"], serde_json::json!([]), "nothing is asked of anybody else");
    assert_eq!(seen["violations"], serde_json::json!([]), "axe-core finds nothing");
    let why = seen["why"][0].as_str().unwrap();
    assert!(
        why.contains("the next best") || why.contains("worth the same") || why.contains("worth"),
        "{why}"
    );
    assert_eq!(seen["why"][1], 4, "four hops");
    let space = seen["space"].as_str().unwrap();
    let numbers: Vec<u64> =
        space.split(|c: char| !c.is_ascii_digit()).filter_map(|word| word.parse().ok()).collect();
    assert!(numbers[0] <= 20 && numbers[1] <= 1_500_000, "{space}");
    assert_eq!((&seen["flat"], &seen["help"]), (&true.into(), &false.into()), "3 and Escape go back: {seen}");
    assert_eq!(seen["events"], true, "events are above the fold at 1280 x 800");
    assert_eq!(seen["small"], serde_json::json!([]), "targets of 44 px on a phone");
    assert!(seen["footer"].as_f64().unwrap() <= 0.125, "{seen}");
    assert_eq!(seen["scenario"], "hard");
    assert_eq!(
        seen["stepped"].as_u64().unwrap(),
        seen["paused"].as_u64().unwrap() + 2,
        "two steps, two landings"
    );
    assert_eq!(seen["streams"], serde_json::json!([2, 0, 2]), "seen, hidden, seen again");
    assert!(seen["bound"].as_str().unwrap().parse::<f64>().unwrap() > 0.0, "a certificate: {seen}");
    assert_eq!(seen["standby"], "stands by");
    let answer = seen["answer"].as_str().unwrap();
    assert!(answer.starts_with("greedy takes command; the mission is paused"), "{answer}");
    assert_eq!(seen["leaders"], serde_json::json!(["greedy", "mdp"]), "the swap is seen");
    let rule = seen["rule"].as_str().unwrap();
    assert!(
        rule.starts_with("greedy looks one hop ahead"),
        "the reason is that of the planner that decided: {rule}"
    );
    assert!(seen["leader"].as_str().unwrap().starts_with("greedy"), "{seen}");
    assert!(seen["colours"].as_u64().unwrap() > 20, "the map is drawn: {seen}");
    assert_eq!(seen["overflow"], 0, "nothing sticks out of a narrow window");
    let states = ["paused", "cell", "values", "space", "swapped", "back", "goal-light", "narrow"];
    assert_is_there(&shots, &states);
    assert_eq!(seen["reloaded"], seen["end"], "after the mission a reload shows how it ended");
    assert_eq!(
        seen["peers"],
        serde_json::json!(["finished"]),
        "no process that ended with the mission is silent"
    );
    run.signal(Signal::INT);
    // How the mission ends depends on the hop at which it was handed over: the page and the exit code agree with it.
    let code = run.code();
    let summary = run.json();
    let outcome = summary["outcome"].as_str().unwrap();
    assert_eq!(code == 0, outcome == "goal", "{}", run.log());
    assert_eq!(seen["hops"], summary["decisions"], "{summary}");
    assert!(seen["end"].as_str().unwrap().contains(outcome), "{seen}");
    // P-CONTROL in the large: what was paused, stepped and hurried has the digest of the same planners undisturbed.
    let again = lockstep(&["--planners-from", mission.journal().to_str().unwrap()]);
    assert_eq!(again["digest"], summary["digest"]);
}

/// Sends bytes and reads what comes; empty if the connection just ends.
fn ask(address: &str, bytes: &[u8]) -> String {
    let mut stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    // Who is refused early may find the door closed.
    let _ = stream.write_all(bytes);
    let mut answer = Vec::new();
    match stream.read_to_end(&mut answer) {
        Err(error) if !matches!(error.kind(), ErrorKind::ConnectionReset) => panic!("{error}"),
        _ => String::from_utf8_lossy(&answer).into_owned(),
    }
}

fn get(address: &str, path: &str, host: &str) -> String {
    ask(address, format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n").as_bytes())
}

fn post(address: &str, headers: &str, body: &str) -> String {
    let head = format!(
        "POST /control HTTP/1.1\r\nHost: {address}\r\nContent-Length: {}\r\n{headers}\r\n",
        body.len()
    );
    ask(address, [head.as_bytes(), body.as_bytes()].concat().as_slice())
}

/// P-WEB-HOSTILE: A hostile host, path, method, head or payload gets nothing from the page, and the
/// mission is not affected.
/// P-WEB-REFUSALS.
#[test]
fn a_hostile_request_gets_nothing_and_moves_nothing() {
    let mission = Mission::new("hostile");
    let (mut run, url) = page_of(&mission, &["--web-exit", "--control", "--seed", "6", "--pace", "1"]);
    let (address, key) = url.strip_prefix("http://").unwrap().split_once("/#key=").unwrap();
    mission.await_decisions(2);
    let page = get(address, "/", address);
    assert!(page.starts_with("HTTP/1.1 200 ") && page.contains("default-src 'none'"), "{page}");

    for (what, answer) in [
        ("a name bound to this address", get(address, "/", "evil.example")),
        ("a name that only looks like this machine", get(address, "/", "127.0.0.1.evil.example")),
        ("no host", ask(address, b"GET / HTTP/1.1\r\n\r\n")),
        ("a path above", get(address, "/../Cargo.toml", address)),
        ("a path beyond", get(address, "/etc/passwd", address)),
        ("a NUL in the path", get(address, "/\0", address)),
        ("another method", ask(address, format!("DELETE / HTTP/1.1\r\nHost: {address}\r\n\r\n").as_bytes())),
        ("no HTTP", ask(address, b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03\r\n\r\n")),
        ("a head without end", ask(address, &[b'x'; 100_000])),
        (
            "a header without end",
            ask(
                address,
                format!("GET / HTTP/1.1\r\nHost: {address}\r\nX: {}", "y".repeat(70_000)).as_bytes(),
            ),
        ),
        (
            "a body on a GET",
            ask(
                address,
                format!("GET / HTTP/1.1\r\nHost: {address}\r\nContent-Length: 9\r\n\r\n").as_bytes(),
            ),
        ),
    ] {
        assert!(answer.is_empty() || answer.starts_with("HTTP/1.1 4"), "{what}: {answer}");
        assert!(!answer.contains("<!doctype") && !answer.contains("members"), "{what}: {answer}");
    }
    let pause = r#"{"order":"pause"}"#;
    let ours =
        format!("Origin: http://{address}\r\nContent-Type: application/json\r\nX-Hopper-Key: {key}\r\n");
    for (what, headers, body) in [
        ("no origin", ours.replace("Origin", "X"), pause),
        ("another's page", ours.replace(&format!("http://{address}"), "http://evil.example"), pause),
        ("no key", ours.replace("X-Hopper-Key", "X"), pause),
        ("a guess", ours.replace(key, &"0".repeat(32)), pause),
        ("a form", ours.replace("application/json", "text/plain"), pause),
        ("no order", ours.clone(), "{}"),
        ("a pace beyond", ours.clone(), r#"{"order":"pace","pace":"1e300"}"#),
        ("a planner nobody is", ours.clone(), r#"{"order":"hand_over","life":"00000000000000ff"}"#),
        ("too much", ours.clone(), &"x".repeat(100_000)),
    ] {
        let answer = post(address, &headers, body);
        assert!(answer.is_empty() || answer.starts_with("HTTP/1.1 4"), "{what}: {answer}");
    }
    // Whoever opens and says nothing, or listens and never reads, takes nothing from the others.
    let idle: Vec<TcpStream> = (0..20).map(|_| TcpStream::connect(address).unwrap()).collect();
    let mut deaf = TcpStream::connect(address).unwrap();
    write!(deaf, "GET /events HTTP/1.1\r\nHost: {address}\r\n\r\n").unwrap();
    assert!(get(address, "/page.css", address).starts_with("HTTP/1.1 200 "));
    let accepted = post(address, &ours, r#"{"order":"pace","pace":"max"}"#);
    assert!(accepted.starts_with("HTTP/1.1 202 "), "the very page, with its key: {accepted}");
    assert_eq!(run.code(), 0, "{}", run.log());
    drop((idle, deaf));
    assert_eq!(run.json()["digest"], lockstep(&["--seed", "6"])["digest"]);
    // Whoever started it is told once of each kind of refusal, and what to do.
    let log = run.log();
    for told in ["--web-host evil.example", "orders need the key", "got one from \"http://evil.example\""] {
        assert_eq!(log.matches(told).count(), 1, "{told}: {log}");
    }
}

/// P-WEB-LEAVE: Without `--control` the page refuses every order, and a hopper-sim without it obeys
/// none.
#[test]
fn without_leave_every_order_is_refused() {
    let mission = Mission::new("leave");
    let (mut run, url) = page_of(&mission, &["--web-exit", "--seed", "7", "--pace", "1"]);
    let address = url.strip_prefix("http://").unwrap().trim_end_matches('/');
    assert!(!url.contains("key"), "{url}");
    let headers =
        format!("Origin: http://{address}\r\nContent-Type: application/json\r\nX-Hopper-Key: x\r\n");
    for order in [r#"{"order":"pause"}"#, r#"{"order":"step"}"#, r#"{"order":"pace","pace":"max"}"#] {
        let answer = post(address, &headers, order);
        assert!(answer.starts_with("HTTP/1.1 403 "), "{answer}");
    }
    // A monitor that may, beside a hopper-sim that may not.
    let monitor = mission.start("monitor", &["--web", "127.0.0.1:0", "--control"]);
    monitor.await_log("page at ");
    let log = monitor.log();
    let url = log.split("page at http://").nth(1).unwrap().split_whitespace().next().unwrap();
    let (address, key) = url.split_once("/#key=").unwrap();
    let headers =
        format!("Origin: http://{address}\r\nContent-Type: application/json\r\nX-Hopper-Key: {key}\r\n");
    eventually("the pacing to be known", || {
        let answer = post(address, &headers, r#"{"order":"pause"}"#);
        assert!(answer.starts_with("HTTP/1.1 409 "), "{answer}");
        assert!(
            ["has not reported yet", "started with --control"].iter().any(|why| answer.contains(why)),
            "{answer}"
        );
        answer.contains("hopper-sim started with --control")
    });
    run.signal(Signal::TERM);
    assert_eq!(run.code(), 130, "{}", run.log());
}

/// P-WEB-BEHIND: A page that fell behind what the monitor keeps finds its hops by their numbers.
#[test]
fn a_page_that_fell_behind_finds_its_hops_by_their_numbers() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut node = Command::new("node");
    let output = node
        .arg(root.join("tests/web/account.mjs"))
        .arg(root.join("monitor/src/web/page/history.js"))
        .output()
        .unwrap_or_else(|error| panic!("the page's test needs node on PATH, got: {error}"));
    assert!(output.status.success(), "{}", harness::stderr(&output));
}

/// P-WEB-PLACE: A page for which no slot is left to read policies works without them, and shows
/// them once a slot is free.
#[test]
fn a_page_without_a_place_to_read_policies_goes_on_and_has_them_later() {
    if suites::is_left_out("page in a browser") {
        return;
    }
    let mission = Mission::new("place");
    let slow = mission.start_slow_sim("8");
    let mut crew =
        ["perception", "planner"].map(|role| mission.start(role, &[])).into_iter().collect::<Vec<_>>();
    mission.await_decisions(1);
    let instance = mission.instance();
    let mut visitor = Node::visit(&instance).unwrap();
    let places = Policy::SERVICE.max_subscribers;
    let readers: Vec<_> = (0..places).map(|_| visitor.reader::<Policy>(ROBOT, false).unwrap()).collect();
    let monitor = mission.start("monitor", &["--web", "127.0.0.1:0", "--web-exit"]);
    monitor.await_log("page at ");
    let log = monitor.log();
    let address = log.split("page at http://").nth(1).unwrap().split_whitespace().next().unwrap();
    let address = address.trim_end_matches('/');
    let mut policies = TcpStream::connect(address).unwrap();
    policies.set_read_timeout(Some(PATIENCE)).unwrap();
    write!(policies, "GET /policy HTTP/1.1\r\nHost: {address}\r\n\r\n").unwrap();
    monitor.await_log("no policy is shown until");
    drop(readers);
    let (mut text, mut piece) = (String::new(), [0; 4096]);
    while !text.contains("event: policy") {
        let count = policies.read(&mut piece).unwrap();
        assert!(count > 0, "the stream ended: {text}\n{}", monitor.log());
        text += &String::from_utf8_lossy(&piece[..count]);
    }
    drop((policies, visitor));
    crew.push(monitor);
    let mut sim = mission.hurry(slow, "8");
    assert_eq!(sim.code(), 0, "{}", sim.log());
    for process in &mut crew {
        assert_eq!(process.code(), 0, "{}", process.log());
    }
}

/// P-WEB-SPACE: In the view of the ground in space, 821 × 821 cells take at most 20 draw calls and
/// 1.5 million triangles a frame.
///
/// 821 x 821 cells in space take at most 20 draw calls and 1.5 million triangles a frame. What the
/// script of a frame takes is printed, not asserted: docs/measurements.md has the figures.
/// `HOPPER_FRAMES` says how many frames.
#[test]
fn a_large_map_in_space_takes_few_draw_calls_and_triangles() {
    if suites::is_left_out("page in a browser") {
        return;
    }
    let (chromium, playwright, shots) = (chromium(), playwright(), shots());
    let mission = Mission::new("space");
    let flown = mission.fly(&["--lockstep", "--scenario", "vast", "--planner", "greedy"]);
    assert!(mission.path("out/journal").exists(), "{}", harness::stderr(&flown));
    let (view, url) = past_page_of(&mission, "out");
    let frames = std::env::var("HOPPER_FRAMES").unwrap_or_else(|_| "3".into());
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/web/space.mjs");
    let mut measure = Command::new("node");
    measure.arg(script).arg(playwright).arg(chromium).arg(url).arg(frames).arg(&shots);
    let seen = json(&measure.output().unwrap());
    assert_eq!(seen["failure"], serde_json::Value::Null, "{seen}\n{}", view.log());
    assert_eq!(seen["errors"], serde_json::json!([]), "the console is clean");
    assert_eq!(seen["violations"], serde_json::json!([]), "axe-core finds nothing");
    assert_is_there(&shots, &["large", "large-space"]);
    println!("{seen}");
    let drawn = seen["drawn"].as_str().unwrap();
    let numbers: Vec<u64> =
        drawn.split(|c: char| !c.is_ascii_digit()).filter_map(|word| word.parse().ok()).collect();
    assert!(numbers[0] <= 20 && numbers[1] > 1_300_000 && numbers[1] <= 1_500_000, "{drawn}");
}

/// P-WEB-TEAM: The page shows each of several robots with its colour, place and turn; axe-core
/// finds nothing, and nothing overflows a narrow window.
#[test]
fn several_robots_are_shown_on_the_page() {
    if suites::is_left_out("page in a browser") {
        return;
    }
    let (chromium, playwright, shots) = (chromium(), playwright(), shots());
    let mission = Mission::new("team-page");
    let flown = mission.fly(&["--lockstep", "--scenario", "coverage"]);
    assert!(mission.path("out/journal").exists(), "{}", harness::stderr(&flown));
    let (view, url) = past_page_of(&mission, "out");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/web/team.mjs");
    let mut look = Command::new("node");
    let seen = json(&look.arg(script).arg(playwright).arg(chromium).arg(url).arg(&shots).output().unwrap());
    assert_eq!(seen["failure"], serde_json::Value::Null, "{seen}\n{}", view.log());
    assert_eq!(seen["errors"], serde_json::json!([]), "the console is clean");
    assert_eq!(seen["violations"], serde_json::json!([]), "axe-core finds nothing");
    let places = seen["robots"].as_array().unwrap();
    assert_eq!((places.len(), &seen["badges"]), (4, &4.into()), "{seen}");
    assert!(places.iter().all(|place| place.as_str().unwrap().starts_with('(')), "{seen}");
    let why = seen["why"].as_str().unwrap();
    assert!(
        why.starts_with("Robot ") && why.contains(", a rover, "),
        "the panel tells what a rover did: {why}"
    );
    assert_eq!(seen["overflow"], 0, "nothing sticks out of a narrow window");
    assert_is_there(&shots, &["team"]);
}

/// P-WEB-STATES: On desktops and on phones held either way nothing of the page is clipped, the map is in sight above the
/// timeline, and axe-core finds nothing: one robot and several, in 2D and in 3D, on a large map, and of an interrupted mission.
///
/// The legend names what is drawn, the list says what each robot is and how far its goal is, and the reason names the rule
/// of the planner that decided.
// Long: one browser looks at every state, and a line or two for each claim.
#[test]
fn the_page_holds_in_every_state() {
    if suites::is_left_out("page in a browser") {
        return;
    }
    let (chromium, playwright, shots) = (chromium(), playwright(), shots());
    let flights: [(&str, &[&str]); 6] = [
        ("hopper", &["--scenario", "hard", "--seed", "3"]),
        ("expedition", &["--scenario", "expedition"]),
        ("large", &["--scenario", "vast", "--planner", "greedy"]),
        ("coverage", &["--scenario", "coverage"]),
        ("rover", &["--scenario", "rover-helicopter", "--seed", "3"]),
        ("scout", &["--scenario", "hopper-scout"]),
    ];
    let mut missions = Vec::new();
    for (name, words) in flights {
        let mission = Mission::new(&format!("state-{name}"));
        let flown = mission.fly(&[&["--lockstep"], words].concat());
        assert!(mission.path("out/journal").exists(), "{name}: {}", harness::stderr(&flown));
        missions.push((name, "out", mission));
    }
    let interrupted = Mission::new("state-interrupted");
    let (mut run, _) = page_of(&interrupted, &["--seed", "8", "--pace", "2"]);
    run.await_hop(2);
    run.signal(Signal::INT);
    assert_eq!(run.code(), 130, "{}", run.log());
    missions.push(("interrupted", ".", interrupted));
    let views: Vec<_> = missions
        .iter()
        .map(|(name, what, mission)| {
            let (view, url) = past_page_of(mission, what);
            (view, format!("{name}={url}"))
        })
        .collect();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/web/states.mjs");
    let mut look = Command::new("node");
    look.arg(script).arg(playwright).arg(chromium).arg(&shots).args(views.iter().map(|(_, word)| word));
    let seen = json(&look.output().unwrap());
    assert_eq!(seen["failure"], serde_json::Value::Null, "{seen}");
    assert_eq!(seen["errors"], serde_json::json!([]), "the console is clean");
    assert_eq!(seen["violations"], serde_json::json!([]), "axe-core finds nothing");
    let states = seen["states"].as_object().unwrap();
    let texts = |state: &str, what: &str| -> Vec<String> {
        let texts = states[state][what].as_array().unwrap();
        texts.iter().map(|text| text.as_str().unwrap().to_owned()).collect()
    };
    for (name, state) in states {
        assert_eq!(state["overflow"], 0, "{name}: nothing sticks out of the window");
        assert_eq!(state["clipped"], serde_json::json!([]), "{name}");
        assert!(state["map"].as_f64().unwrap() > 0.95, "{name}: the map is in sight: {}", state["map"]);
        assert!(!state["text"].as_str().unwrap().contains("−0.00"), "{name}");
        assert!(state["header"].as_f64().unwrap() < 150.0, "{name}: {}", state["header"]);
        let why = &texts(name, "why")[0];
        assert!(why.len() > 1, "{name}: {why}");
    }
    let named = |state: &str, key: &str| texts(state, "legend").iter().any(|text| text.contains(key));
    for key in ["start", "goal", "hopper", "sensing range", "landed astray", "contours every"] {
        assert!(named("light", key), "{key}: {}", states["light"]["legend"]);
    }
    assert!(!named("space-one", "sensing range") && named("space-one", "route"), "{}", states["space-one"]);
    assert!(named("coverage", "obstacle") && named("large-map", "stuck"), "{}", states["coverage"]["legend"]);
    assert!(named("expedition", "in the robot's colour"), "{}", states["expedition"]["legend"]);
    // What each robot is and how far its own goal is; whose the figures are.
    let bodies = ["driver", "helicopter", "hopper", "hopper", "helicopter", "rover"];
    assert_eq!(texts("expedition", "shapes"), bodies);
    let robots = texts("expedition", "robots");
    assert!(robots[0].starts_with("0 rover rrt_star_ett") && robots[0].contains('★'), "{robots:?}");
    assert!(robots[1].starts_with("1 helicopter") && !robots[1].contains('★'), "{robots:?}");
    assert!(
        texts("hopper-helicopter", "figures")[0].starts_with("hops0"),
        "of robot 0: {}",
        states["hopper-helicopter"]
    );
    assert!(
        states["expedition"]["clock"].as_str().unwrap().ends_with("Sols"),
        "{}",
        states["expedition"]["clock"]
    );
    // By the planner that decided, of whatever robot; in space the panel follows.
    assert!(
        texts("large-map", "why")[1].starts_with("greedy looks one hop ahead"),
        "{}",
        states["large-map"]["why"]
    );
    assert!(texts("coverage", "why")[1].starts_with("cover_frontier"), "{}", states["coverage"]["why"]);
    assert_eq!(states["large-map-back"]["number"], "hop 9");
    assert_eq!(states["large-map"]["height"], states["large-map-back"]["height"], "the panel keeps its size");
    assert_eq!(states["interrupted"]["status"], "interrupted");
    for name in states.keys() {
        assert_is_there(&shots, &[&format!("state-{name}")]);
    }
}

/// P-WEB-LAYERS: Over uncertain ground the page shows the expected speed first; spread, visits and
/// heights are a key away, with scale and unit. A live mission at full speed, its journal and its
/// recording show the same.
#[test]
fn uncertain_ground_is_shown_by_its_expected_speed_and_its_spread() {
    if suites::is_left_out("page in a browser") {
        return;
    }
    let (chromium, playwright, shots) = (chromium(), playwright(), shots());
    let mut mission = Mission::new("layers-page");
    let words = ["--scenario", "rover-helicopter", "--seed", "3", "--record", "whole.mcap"];
    let (mut run, live) = page_of(&mission, &words);
    run.await_log("the page stays at ");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/web/layers.mjs");
    let look = |url: &str, name: &str| {
        let mut look = Command::new("node");
        look.arg(&script).arg(&playwright).arg(&chromium).arg(url).arg(&shots).arg(name);
        json(&look.output().unwrap())
    };
    let live = look(&live, "layers-live");
    assert_eq!(live["failure"], serde_json::Value::Null, "{live}\n{}", run.log());
    run.signal(Signal::INT);
    assert_eq!(run.code(), 0, "{}", run.log());
    for (past, name) in [("journal", "layers-journal"), ("whole.mcap", "layers-recording")] {
        let (_view, url) = past_page_of(&mission, past);
        let seen = look(&url, name);
        assert_eq!(seen["failure"], serde_json::Value::Null, "{seen}");
        for what in ["layers", "share", "legends", "colours", "readout"] {
            assert_eq!(seen[what], live[what], "{past}: {what}");
        }
        assert_shows_discs(&seen["before"], past);
    }
    let seen = &live;
    assert_eq!(seen["failure"], serde_json::Value::Null, "{seen}\n{}", run.log());
    assert_eq!(seen["errors"], serde_json::json!([]), "the console is clean");
    assert_eq!(seen["violations"], serde_json::json!([]), "axe-core finds nothing");
    let layers = serde_json::json!(["heights", "visits", "expected speed", "spread of speed"]);
    assert_eq!(
        (&seen["layers"], &seen["first"], &seen["around"]),
        (&layers, &"speed".into(), &"speed".into())
    );
    assert_ne!(seen["share"], "0 %", "what was seen is on the page, however quick the mission was");
    assert_eq!(seen["chosen"], "spread", "the arrow keys choose too");
    assert_eq!(seen["legends"]["speed"], "0 200 m/Sol expected");
    assert_eq!(seen["legends"]["spread"], "0 100 m/Sol standard deviation");
    assert_shows_discs(&seen["colours"]["speed"], "seen");
    assert_shows_discs(&seen["before"], "expected");
    assert_ne!(seen["colours"]["speed"], seen["colours"]["ground"]);
    assert!(seen["readout"].as_str().unwrap().contains("m/Sol"), "{seen}");
    assert_eq!(seen["overflow"], 0, "nothing sticks out of a narrow window");
    assert_is_there(&shots, &["layers-live-speed", "layers-live-spread", "layers-live-before"]);
    mission.assert_nothing_left();
}

/// The discs are impassable, the open ground has 200 m/Sol: dark and pale, whether they were seen or are only expected, which the
/// hatching of unseen ground may cross.
fn assert_shows_discs(colours: &serde_json::Value, when: &str) {
    let lightness = |colour: &serde_json::Value| {
        colour.as_array().unwrap().iter().map(|part| part.as_f64().unwrap()).sum::<f64>() / 3.0
    };
    let [a, b, c, d] = [0, 1, 2, 3].map(|place| lightness(&colours[place]));
    assert!(a < 110.0 && b < 110.0 && c > 150.0 && d > 150.0, "{when}: {colours}");
}

/// The PATH of a desktop whose browser writes the address that it is given to a file, and that file.
fn fake_browser(mission: &Mission) -> (std::ffi::OsString, PathBuf) {
    let tools = mission.path("tools");
    std::fs::create_dir_all(&tools).unwrap();
    let opened = mission.path("opened");
    let script = format!("#!/bin/sh\necho \"$1\" > '{0}.part' && mv '{0}.part' '{0}'\n", opened.display());
    for program in ["xdg-open", "open"] {
        let path = tools.join(program);
        std::fs::write(&path, &script).unwrap();
        std::fs::set_permissions(&path, std::os::unix::fs::PermissionsExt::from_mode(0o755)).unwrap();
    }
    let others = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths(std::iter::once(tools).chain(std::env::split_paths(&others))).unwrap();
    (path, opened)
}

/// P-WEB-OPEN: `--open` gives the browser an address with a key in a file that only its owner can
/// read, and no argument of a process contains the key.
/// P-VIEW-INTERRUPTED: `hopper view` of a mission without an outcome says that it was interrupted,
/// in log and page.
#[test]
fn the_key_is_in_no_argument_and_in_no_file_of_others() {
    use std::os::unix::fs::PermissionsExt as _;
    let mission = Mission::new("open");
    let (path, opened) = fake_browser(&mission);
    let mut command =
        mission.hopper(&["run", "--instance", &mission.name, "--out", "out", "--format", "json"]);
    command.args(["--web", "127.0.0.1:0", "--open", "--control", "--seed", "8", "--pace", "0.5"]);
    command.args(["--record", "whole.mcap"]).env("PATH", path);
    let mut run = Process::spawn("run", command, &mission.path(""));
    run.await_log("page at ");
    eventually("the browser to be opened", || opened.exists());
    let log = run.log();
    let url = log.split("page at ").nth(1).unwrap().split_whitespace().next().unwrap();
    let key = url.split_once("#key=").unwrap().1;
    run.await_hop(1);

    let given = std::fs::read_to_string(&opened).unwrap();
    let file = Path::new(given.trim_end());
    assert!(!given.contains(key), "{given}");
    assert_eq!(file.metadata().unwrap().permissions().mode() & 0o777, 0o600, "{given}");
    assert!(std::fs::read_to_string(file).unwrap().contains(url), "it goes on to the page");
    for process in std::fs::read_dir("/proc").unwrap() {
        let line = std::fs::read(process.unwrap().path().join("cmdline")).unwrap_or_default();
        assert!(!String::from_utf8_lossy(&line).contains(key), "{}", String::from_utf8_lossy(&line));
    }
    run.signal(Signal::INT);
    assert_eq!(run.code(), 130, "{}", run.log());
    assert!(!file.exists(), "it is removed with the page");
    let mut folders = vec![mission.path("")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            // The log is where the operator finds the address.
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_none_or(|kind| kind != "err") {
                let bytes = std::fs::read(&path).unwrap();
                let has_key = bytes.windows(key.len()).any(|window| window == key.as_bytes());
                assert!(!has_key, "{}", path.display());
            }
        }
    }
    assert!(run.log().contains("other users can read this log"), "{}", run.log());

    // Of what was interrupted the page says so, and it names no flag that `hopper view` lacks.
    let (mut view, url) = past_page_of(&mission, "out");
    let told = told(url.trim_start_matches("http://").trim_end_matches('/'));
    assert!(told.2.last().unwrap().contains("\"interrupted\":true"), "{:?}", told.2.last());
    view.await_log("the page stays at ");
    let log = view.log();
    assert!(log.contains("interrupted") && !log.contains("--web-exit"), "{log}");
    view.signal(Signal::INT);
    assert_eq!(view.code(), 0, "{log}");
}

/// P-WEB-STAYS: The page of `hopper run` outlives the mission with its whole history, until Ctrl-C,
/// and leaves the instance to the next mission. `hopper view` shows the same page for a journal, an
/// output directory or a recording.
#[test]
fn the_page_outlives_the_mission_and_a_past_one_has_the_same() {
    let mission = Mission::new("stays");
    let (path, opened) = fake_browser(&mission);
    let mut command = mission.hopper(&["run", "--instance", &mission.name, "--out", ".", "--format", "json"]);
    command.args(["--web", "127.0.0.1:0", "--open", "--seed", "8", "--record", "whole.mcap"]);
    command.env("PATH", path);
    let mut run = Process::spawn("run", command, &mission.path(""));
    run.await_log("the page stays at ");
    eventually("the browser to be opened", || opened.exists());
    let log = run.log();
    let address = log.split("page at http://").nth(1).unwrap().split_whitespace().next().unwrap();
    let address = address.trim_end_matches('/');
    let live = told(address);
    let decisions: usize = rows(&live.0);
    assert!(live.2.last().unwrap().contains("\"status\":\"goal\""), "{:?}", live.2.last());
    eventually("the instance to be free for the next mission", || !mission.instance().is_alive().unwrap());
    run.signal(Signal::INT);
    assert_eq!(run.code(), 0, "{}", run.log());
    assert_eq!(run.json()["decisions"], decisions);
    assert_eq!(
        std::fs::read_to_string(opened).unwrap().trim_end().trim_end_matches('/'),
        format!("http://{address}")
    );

    for past in [".", "journal", "whole.mcap"] {
        let (mut view, url) = past_page_of(&mission, past);
        let again = told(url.trim_start_matches("http://").trim_end_matches('/'));
        assert_eq!(rows(&again.0), decisions, "{past}");
        assert!(again.2.last().unwrap().contains("\"status\":\"goal\""), "{past}");
        // At full speed the monitor may leave before the last patches have come; what it has is the same.
        let (live, again) = (cells(&live.1), cells(&again.1));
        assert!(!live.is_empty() && live.iter().all(|(cell, seen)| again.get(cell) == Some(seen)), "{past}");
        view.signal(Signal::INT);
        assert_eq!(view.code(), 0, "{past}: {}", view.log());
    }
    let nothing = mission.hopper(&["view", "nowhere"]).output().unwrap();
    assert_eq!(nothing.status.code(), Some(2), "{}", harness::stderr(&nothing));
}

/// P-WEB-DETAILS: Where hops are followed by physics, the page gets the launch, every impact that is told and the exact rest position of
/// each hop, to the bit as `hopper journal show` has them: live, from the journal and from a recording.
#[test]
fn the_page_gets_every_impact_to_the_bit_as_the_journal_has_it() {
    let mission = Mission::new("details");
    let words = ["--dynamics", "contact", "--seed", "8", "--record", "whole.mcap"];
    let (mut run, url) = page_of(&mission, &words);
    run.await_log("the page stays at ");
    let address = |url: &str| url.trim_start_matches("http://").split('/').next().unwrap().to_owned();
    let live = details(&address(&url));
    run.signal(Signal::INT);
    run.code();
    let shown = json(&mission.hopper(&["journal", "show", "journal", "--format", "json"]).output().unwrap());
    let records = shown["records"].as_array().unwrap();
    let journal: Vec<_> = records
        .iter()
        .map(|record| (record["decision"].as_u64().unwrap(), record["detail"].clone()))
        .collect();
    let impacts = |(_, detail): &(u64, serde_json::Value)| detail["path"].as_array().unwrap().len();
    assert!(!journal.is_empty() && journal.iter().map(impacts).max() > Some(2), "some hops bounce: {shown}");
    assert_eq!(live, journal);
    for past in [".", "journal", "whole.mcap"] {
        let (_view, url) = past_page_of(&mission, past);
        assert_eq!(details(&address(&url)), journal, "{past}");
    }
    let export = ["bag", "export", "whole.mcap", "--topic", "hop/details", "--format", "json"];
    let exported = mission.hopper(&export).output().unwrap();
    let lines = String::from_utf8(exported.stdout).unwrap();
    let rows = lines.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap());
    let rows: Vec<_> = rows.map(|row| (row["decision"].as_u64().unwrap(), row["detail"].clone())).collect();
    assert_eq!(rows, journal, "{}", String::from_utf8_lossy(&exported.stderr));
}

/// P-WEB-WAYS: The page shows the real way of a hop that physics follows: flights, impacts, what it rolled, and in the panel how it was
/// launched and how it ended. A step shows it in flight for as long as it took. Under the law nothing of it is shown.
#[test]
fn the_real_way_of_a_hop_is_shown_in_a_real_browser() {
    if suites::is_left_out("page in a browser") {
        return;
    }
    let (chromium, playwright, shots) = (chromium(), playwright(), shots());
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/web/way.mjs");
    let look = |dynamics: &str| {
        let mission = Mission::new("ways");
        mission.fly(&["--lockstep", "--seed", "8", "--dynamics", dynamics]);
        let shown = json(&mission.hopper(&["journal", "show", "out", "--format", "json"]).output().unwrap());
        let (view, url) = past_page_of(&mission, "out");
        let mut look = Command::new("node");
        look.arg(&script).arg(&playwright).arg(&chromium).arg(url).arg(&shots).arg(dynamics);
        let seen = json(&look.output().unwrap());
        assert_eq!(seen["failure"], serde_json::Value::Null, "{dynamics}: {seen}\n{}", view.log());
        assert_eq!(seen["errors"], serde_json::json!([]), "{dynamics}: the console is clean");
        assert_eq!(seen["violations"], serde_json::json!([]), "{dynamics}: axe-core finds nothing");
        assert_eq!(seen["overflow"], 0, "{dynamics}: nothing sticks out of a narrow window");
        (shown, seen)
    };
    let (_, law) = look("law");
    assert_eq!(law["legend"], serde_json::json!([["rolled", false], ["impact", false]]), "{law}");
    assert_eq!((&law["rolled"], &law["readouts"]), (&0.into(), &serde_json::json!([])), "{law}");
    assert!(law["hops"].as_array().unwrap().iter().all(|hop| hop["facts"].is_null()), "{law}");
    let (shown, contact) = look("contact");
    assert_eq!(contact["legend"], serde_json::json!([["rolled", true], ["impact", true]]));
    assert!(contact["rolled"].as_u64().unwrap() > 20, "{contact}");
    for (n, hop) in contact["hops"].as_array().unwrap().iter().enumerate() {
        let figures = &shown["records"][n]["detail"]["figures"];
        let facts = &hop["facts"];
        assert_eq!(facts["impacts"], format!("{}", figures[1]).trim_end_matches(".0"), "{hop}");
        assert_eq!(facts["rolled"], format!("{:.2}m", figures[2].as_f64().unwrap()), "{hop}");
    }
    // As long as it took: the readout names the time of the hop, and no time lapse.
    let took = shown["records"][0]["detail"]["figures"][3].as_f64().unwrap();
    let readouts = contact["readouts"].as_array().unwrap();
    let needle = format!(" of {took:.1} s");
    assert!(readouts.iter().any(|text| text.as_str().unwrap().contains(&needle)), "{needle}: {contact}");
    assert!(readouts.iter().all(|text| !text.as_str().unwrap().contains('×')), "{contact}");
    assert_is_there(&shots, &["contact-map", "contact-near", "contact-space", "contact-space-near"]);
}

/// What the page at `address` tells of hops that physics followed: decision and detail.
fn details(address: &str) -> Vec<(u64, serde_json::Value)> {
    let frames = frames_of(address).into_iter().filter(|(event, _)| event == "details");
    let frames = frames.map(|(_, data)| serde_json::from_str::<serde_json::Value>(&data).unwrap());
    let rows = frames.flat_map(|frame| frame["rows"].as_array().unwrap().clone());
    rows.map(|row| (row["decision"].as_u64().unwrap(), row["detail"].clone())).collect()
}

/// Data of the frames with hops, of those with cells, and of the status, as a page at `address` tells them.
fn told(address: &str) -> (Vec<String>, Vec<String>, Vec<String>) {
    let frames = frames_of(address);
    let of = |event: &str| {
        let frames = frames.iter().filter(|(name, _)| name == event);
        frames.map(|(_, data)| data.clone()).collect::<Vec<String>>()
    };
    (of("hops"), of("cells"), of("status"))
}

/// The frames of a page at `address` up to the first status, each with its event and data.
fn frames_of(address: &str) -> Vec<(String, String)> {
    let mut stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    write!(stream, "GET /events HTTP/1.1\r\nHost: {address}\r\n\r\n").unwrap();
    let (mut text, mut piece) = (String::new(), vec![0; 65536]);
    while !text.split_once("event: status").is_some_and(|(_, rest)| rest.contains("\n\n")) {
        let count = stream.read(&mut piece).unwrap();
        assert!(count > 0, "the stream ended: {text}");
        text += &String::from_utf8_lossy(&piece[..count]);
    }
    // The last frame may be cut.
    let whole = text.rsplit_once("\n\n").unwrap().0;
    let frame = |frame: &str| {
        let (event, data) = frame.split_once("event: ")?.1.split_once("\ndata: ")?;
        Some((event.to_owned(), data.to_owned()))
    };
    whole.split("\n\n").filter_map(frame).collect()
}

/// Rows of the frames with hops.
fn rows(frames: &[String]) -> usize {
    let frames = frames.iter().map(|frame| serde_json::from_str::<serde_json::Value>(frame).unwrap());
    frames.map(|frame| frame["rows"].as_array().unwrap().len()).sum()
}

/// Cells of the frames with cells: index, height and soil, first sight.
fn cells(frames: &[String]) -> std::collections::BTreeMap<i64, (i64, i64)> {
    let mut cells = std::collections::BTreeMap::new();
    for frame in frames {
        let frame: serde_json::Value = serde_json::from_str(frame).unwrap();
        let list = |name: &str| -> Vec<i64> {
            frame[name].as_array().unwrap().iter().map(|number| number.as_i64().unwrap()).collect()
        };
        let (mut index, mut date) = (0, 0);
        for ((step, ground), at) in list("i").into_iter().zip(list("h")).zip(list("at")) {
            (index, date) = (index + step, date + at);
            cells.insert(index, (ground, date));
        }
    }
    cells
}

/// P-WEB-ADDRESS: An address that the page cannot use is a usage error that says so.
#[test]
fn an_address_that_cannot_be_had_is_a_usage_error() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let mission = Mission::new("taken");
    for (words, need) in [
        (vec!["--web", address.as_str()], "port 0 for any free one"),
        (vec!["--web", "nowhere"], "an address is e.g."),
        (vec!["--web", "127.0.0.1:99999"], "an address is e.g."),
        (vec!["--control"], "--web"),
    ] {
        let mut monitor = mission.start("monitor", &words);
        assert_eq!(monitor.code(), 2, "{words:?}: {}", monitor.log());
        assert!(monitor.log().contains(need), "{words:?}: {}", monitor.log());
    }
}
