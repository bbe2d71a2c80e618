//! Looking into a mission from outside: its topics, its processes, and what the dead left behind.

use crate::harness::{Mission, Process, eventually, hopper, json, lockstep, stderr};
use contract::Role;
use node::{Instance, Node};
use serde_json::Value;

/// `hopper topic WORDS` at the mission.
fn topic(mission: &Mission, words: &[&str]) -> std::process::Command {
    let mut command = mission.hopper(&["topic"]);
    command.args(words).args(["--instance", &mission.name, "--format", "json", "--wait", "60s"]);
    command
}

/// What a finished command wrote, a JSON object a line; it must have ended well.
fn objects(mut command: std::process::Command) -> Vec<Value> {
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{command:?}: {}", stderr(&output));
    lines(std::str::from_utf8(&output.stdout).unwrap())
}

fn lines(text: &str) -> Vec<Value> {
    let parsed = text.lines().map(|line| {
        let value: Value = serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {line}"));
        assert!(value.is_object(), "{line}");
        value
    });
    parsed.collect()
}

/// A slow mission with all its processes, whose first hop has landed: sim, perception, planner, monitor.
fn underway(mission: &Mission) -> Vec<Process> {
    let mut processes = vec![mission.start_slow_sim("1")];
    processes.extend(mission.start_peers());
    // The second is committed once the first has landed.
    mission.await_decisions(2);
    processes
}

/// P-TOPIC-LIST: `topic list` names every topic with its type, its quality of service and its
/// processes.
#[test]
fn every_topic_is_listed_with_its_counts() {
    let mission = Mission::new("list");
    let _processes = underway(&mission);
    let services = objects(topic(&mission, &["list"]));
    for (name, kind, processes) in [
        ("truth/terrain", "hop.TruthRequest.v1", 2),
        ("hop/brief", "hop.Brief.v10", 4),
        ("hop/state", "hop.State.v4", 4),
        ("hop/map", "hop.MapPatch.v2", 3),
        ("hop/snapshot", "hop.MapRequest.v1", 2),
        ("hop/r0/command", "hop.Command.v3", 2),
        ("hop/r0/policy", "hop.PolicyHeader.v1", 1),
        ("hop/control", "hop.Control.v1", 2),
        ("hop/tempo", "hop.Tempo.v1", 1),
        ("hop/heartbeat", "hop.Heartbeat.v2", 4),
        ("hop/past", "hop.PastRequest.v1", 3),
    ] {
        let found = services.iter().find(|service| {
            service["name"] == name && service["kind"].as_str().is_some_and(|got| got.starts_with(kind))
        });
        let found = found.unwrap_or_else(|| panic!("{name} of {kind} is not in {services:?}"));
        assert_eq!(found["nodes"], processes, "{found}");
    }
    let output = mission.hopper(&["topic", "list", "--instance", &mission.name]).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(text.contains("hop/state") && text.contains("processes"), "{text}");
}

/// P-TOPIC-ECHO: `topic echo` prints every topic as typed messages, one object per line, as many as
/// `--count` says.
#[test]
fn every_topic_is_echoed_typed_one_object_a_line() {
    let mission = Mission::new("echo");
    let processes = underway(&mission);
    for (name, fields) in [
        ("brief", &["run", "scenario", "profile", "grid", "weights", "account", "robots"][..]),
        ("truth", &["run", "grid", "cell_count"]),
        (
            "state",
            &["run", "decision", "steps", "status", "leader", "pose", "digest", "landed", "last_timing"],
        ),
        ("map", &["run", "through", "sequence", "before", "after", "grid", "seen_cells", "cell_count"]),
        ("command", &["run", "decision", "term", "action", "observation", "planner", "incarnation", "cut"]),
        ("heartbeat", &["role", "pid", "version", "incarnation", "counter", "decision", "status"]),
        ("policy", &["run", "decision", "planner", "error_bound", "cell_count"]),
        ("tempo", &["run", "pace", "paused", "heeds"]),
    ] {
        let messages = objects(topic(&mission, &["echo", name, "--count", "1"]));
        assert_eq!(messages.len(), 1, "{name}");
        for field in fields {
            assert!(messages[0].get(field).is_some(), "{name} has no {field}: {}", messages[0]);
        }
        assert!(messages[0].get("cells").is_none(), "{name} is summed up");
    }
    let states = objects(topic(&mission, &["echo", "hop/state", "--count", "3"]));
    assert_eq!(states.len(), 3);
    assert_eq!(states[0]["leader"]["pid"], processes[2].pid(), "the planner commands");
    let full = objects(topic(&mission, &["echo", "map", "--count", "1", "--full"]));
    let cells = full[0]["cells"].as_array().unwrap();
    assert_eq!(cells.len() as u64, full[0]["cell_count"].as_u64().unwrap());
    assert!((1..=400).contains(&full[0]["seen_cells"].as_u64().unwrap()), "{}", full[0]);
    let truth = objects(topic(&mission, &["echo", "truth", "--count", "1", "--full"]));
    assert_eq!(truth[0]["cells"].as_array().unwrap().len(), 400);
    assert!(objects(topic(&mission, &["echo", "state", "--count", "0"])).is_empty());
    let mut text = mission.hopper(&["topic", "echo", "state", "--count", "2", "--instance", &mission.name]);
    let output = text.output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(text.lines().filter(|line| line.contains("pose.cell.x=")).count(), 2, "{text}");
}

/// P-TOPIC-DETAILS: `topic echo details` prints what the motion model told of each hop from now on, as `journal show` has it.
#[test]
fn details_of_hops_are_echoed_as_the_journal_has_them() {
    let mission = Mission::new("echo-details");
    let mut processes = vec![mission.start("sim", &["--seed", "1", "--pace", "2", "--dynamics", "contact"])];
    processes.extend(mission.start_peers());
    let echoed = objects(topic(&mission, &["echo", "hop/details", "--count", "3"]));
    let shown = json(&mission.hopper(&["journal", "show", "journal", "--format", "json"]).output().unwrap());
    assert_eq!(echoed.len(), 3);
    for page in &echoed {
        let decision = page["decision"].as_u64().unwrap() as usize;
        assert_eq!(page["detail"], shown["records"][decision]["detail"], "{page}");
        assert!(!page["detail"]["path"].as_array().unwrap().is_empty(), "{page}");
    }
}

/// P-TOPIC-POLICY: A reader of the policy topic gets the policy behind the decision that is due.
#[test]
fn a_listener_gets_the_policy_behind_the_present_decision() {
    let mission = Mission::new("policy");
    let _processes = underway(&mission);
    for _ in 0..2 {
        let before = mission.decisions();
        // The first to be told may be one that was kept since somebody listened last.
        let policy = objects(topic(&mission, &["echo", "policy", "--count", "2", "--full"])).remove(1);
        let after = mission.decisions();
        // The decision whose hop is in the air counts among those of the journal.
        let decision = policy["decision"].as_u64().unwrap() + 1;
        assert!((before..=after + 1).contains(&decision), "{before} to {after}, got {decision}");
        assert_eq!((&policy["planner"], &policy["cell_count"]), (&"mdp".into(), &400.into()));
        let cells = policy["cells"].as_array().unwrap();
        assert!(cells.len() == 400 && cells.iter().any(|cell| cell["action"] != "hold"), "{policy}");
        // Nobody listens for a while.
        mission.await_decisions(after + 2);
    }
}

/// P-TOPIC-HZ: `topic hz` measures the rate of a topic.
#[test]
fn the_rate_of_a_topic_is_measured() {
    let mission = Mission::new("rate");
    let _processes = underway(&mission);
    let rates = objects(topic(&mission, &["hz", "heartbeat", "--count", "2"]));
    assert_eq!(rates.len(), 2);
    for rate in &rates {
        assert_eq!(rate["topic"], "hop/heartbeat");
        assert!(rate["hz"].as_f64().unwrap() > 0.0 && rate["messages"].as_u64().unwrap() > 0, "{rate}");
        assert!(rate["gap_max_ms"].is_number(), "{rate}");
    }
}

/// P-TOPIC-REFUSE: An unknown topic is a usage error; an instance that does not appear is a missing
/// peer.
#[test]
fn unknown_topics_and_absent_instances_are_refused() {
    let mission = Mission::new("absent");
    for verb in ["echo", "hz"] {
        let output = hopper(&["topic", verb, "nonsense"]).output().unwrap();
        let text = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(text.contains("nonsense") && text.contains("heartbeat"), "{text}");
    }
    let absent = |words: &[&str]| {
        let mut command = mission.hopper(&["topic"]);
        let output = command.args(words).args(["--instance", &mission.name]).output().unwrap();
        let text = stderr(&output);
        assert_eq!(output.status.code(), Some(4), "{words:?}: {text}");
        assert!(text.contains("hopper-sim") && output.stdout.is_empty(), "{words:?}: {text}");
    };
    absent(&["list", "--wait", "200ms"]);
    absent(&["echo", "state", "--wait", "200ms"]);
    absent(&["hz", "state", "--wait", "200ms"]);
    // An instance without its hopper-sim does not count.
    let planner = mission.start("planner", &[]);
    planner.await_log("joined");
    absent(&["echo", "state", "--wait", "200ms"]);
}

/// Flat ground, sure hops, three of them from the goal.
const SHORT: &str = r"
[truth.terrain.gaussians]
width_cells = 9
height_cells = 9
cell_size_m = 1.0
sigma_m = 2.0
amplitude_m = 0.01
raised_m = [[4, 4]]
[brief]
start = [2, 4]
goal = [5, 4]
[robot]
hard = { intended = 1.0, stuck = 0.0, sideways = 0.0, flights = 1 }
";

/// P-TOPIC-END: The `topic` commands end with the mission.
#[test]
fn an_echo_ends_with_the_mission() {
    let mission = Mission::new("ending");
    std::fs::write(mission.path("short.toml"), SHORT).unwrap();
    let mut sim = mission.start("sim", &["--scenario", "short.toml", "--pace", "1"]);
    let mut echo = Process::spawn("echo", topic(&mission, &["echo", "state"]), &mission.path(""));
    eventually("the echo to look on", || {
        let services = objects(topic(&mission, &["list"]));
        let mut states = services.iter().filter(|service| service["name"] == "hop/state");
        states.any(|service| service["nodes"] == 2)
    });
    let _peers = mission.start_peers();
    assert_eq!(sim.code(), 0, "{}", sim.log());
    assert_eq!(echo.code(), 0, "{}", echo.log());
    let told = lines(&echo.out());
    let last = told.last().unwrap();
    assert_eq!((&last["status"], &last["digest"]), (&"goal".into(), &sim.json()["digest"]));
}

/// `hopper doctor --instance … WORDS --format json`.
fn doctor(mission: &Mission, words: &[&str]) -> Value {
    let mut command = mission.hopper(&["doctor", "--instance", &mission.name, "--format", "json"]);
    let output = command.args(words).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    json(&output)
}

fn doctor_text(mission: &Mission, words: &[&str]) -> String {
    let output = mission.hopper(&["doctor", "--instance", &mission.name]).args(words).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// The doctor's findings once `claim` holds of the only instance asked about: on a busy machine a process
/// may miss the moment in which the doctor listens.
fn diagnosis(mission: &Mission, what: &str, claim: impl Fn(&Value) -> bool) -> Value {
    let mut found = Value::Null;
    eventually(what, || {
        found = doctor(mission, &[])["instances"][0].take();
        claim(&found)
    });
    found
}

fn has_advice(report: &Value, part: &str) -> bool {
    report["advice"].as_array().unwrap().iter().any(|line| line.as_str().unwrap().contains(part))
}

/// P-DOCTOR: `doctor` names every role with process and version, the leader's term, and the shared
/// memory needed and free.
#[test]
fn the_doctor_names_every_role_and_the_leader_and_the_memory() {
    let mission = Mission::new("healthy");
    let processes = underway(&mission);
    let report = diagnosis(&mission, "all four to beat", |report| {
        report["processes"].as_array().unwrap().len() == 4 && report["advice"].as_array().unwrap().is_empty()
    });
    assert_eq!((&report["alive"], &report["instance"]), (&true.into(), &mission.name.as_str().into()));
    let roles = ["hopper-sim", "perception", "planner", "monitor"];
    for ((role, process), told) in roles.iter().zip(&processes).zip(report["processes"].as_array().unwrap()) {
        assert_eq!((&told["role"], &told["pid"]), (&(*role).into(), &process.pid().into()));
        assert_eq!(told["version"], env!("CARGO_PKG_VERSION"));
        assert_eq!(told["leads"], *role == "planner");
    }
    let leader = &report["mission"]["progress"]["leader"];
    assert_eq!((&leader["term"], &leader["planner"]), (&1.into(), &"mdp".into()));
    assert_eq!(leader["pid"], processes[2].pid());
    assert_eq!(report["mission"]["scenario"], "hard");
    for bytes in ["used_bytes", "need_bytes", "free_bytes"] {
        assert!(report["memory"][bytes].as_u64().unwrap() > 0, "{bytes}");
    }
    assert!(report["leftovers"].as_array().unwrap().is_empty());
    assert!(report["nodes"].as_array().unwrap().iter().all(|node| node["health"] == "alive"));

    let mut text = String::new();
    eventually("a text that names all four", || {
        text = doctor_text(&mission, &[]);
        roles.iter().zip(&processes).all(|(role, process)| {
            text.lines().any(|line| line.contains(role) && line.contains(&process.pid().to_string()))
        })
    });
    for part in
        [env!("CARGO_PKG_VERSION"), "commands in term 1", "of shared memory free", "that the mission needs"]
    {
        assert!(text.contains(part), "{part:?} is not in {text}");
    }
}

/// P-DOCTOR-NEXT. Doctor names what is missing, and the command that fixes it.
#[test]
fn the_doctor_says_who_is_missing_and_what_to_do_next() {
    let mission = Mission::new("missing");
    let nothing = doctor(&mission, &[])["instances"][0].take();
    assert_eq!(nothing["alive"], false);
    assert!(has_advice(&nothing, &format!("start `hopper sim --instance {}`", mission.name)), "{nothing}");

    let _sim = mission.start_slow_sim("1");
    let _planner = mission.start("planner", &[]);
    let missing = |role: &str, command: &str| {
        format!("no {role} beats: start `hopper {command} --instance {}`", mission.name)
    };
    let (perception, monitor) = (missing("perception", "perception"), missing("monitor", "monitor"));
    diagnosis(&mission, "two to be missing", |report| {
        report["advice"].as_array().unwrap().len() == 2
            && has_advice(report, &perception)
            && has_advice(report, &monitor)
    });
    let text = doctor_text(&mission, &[]);
    assert!(text.contains(&format!("→ {perception}")), "{text}");

    // One that lives but does not beat, as if it hung.
    let instance = Instance::new(&mission.name).unwrap();
    let _silent = Node::join(&instance, Role::Perception).unwrap();
    let hangs = format!("perception (process {}) lives but does not beat", std::process::id());
    diagnosis(&mission, "the silent one to be told", |report| has_advice(report, &hangs));
}

/// P-DOCTOR-CLEAN: Leftovers of killed processes are reported, and removed with `--clean`.
#[test]
fn leftovers_of_the_killed_are_told_and_cleaned() {
    let mut mission = Mission::new("leftover");
    let mut processes = underway(&mission);
    let pids: Vec<u64> = processes.iter().map(|process| process.pid().into()).collect();
    processes.iter_mut().for_each(Process::kill);

    let report = doctor(&mission, &[])["instances"][0].take();
    assert_eq!(report["alive"], false);
    assert!(!report["leftovers"].as_array().unwrap().is_empty(), "{report}");
    assert!(has_advice(&report, &format!("`hopper doctor --instance {} --clean`", mission.name)), "{report}");
    let nodes = report["nodes"].as_array().unwrap();
    assert!(!nodes.is_empty() && nodes.iter().all(|node| node["health"] == "dead"), "{report}");
    assert!(nodes.iter().all(|node| pids.contains(&node["pid"].as_u64().unwrap())), "{report}");
    assert!(doctor_text(&mission, &[]).contains("left over"));

    let cleaned = doctor(&mission, &["--clean"]);
    let removed = &cleaned["cleaned"][0]["outcome"]["removed"];
    assert!(removed["files"].as_u64().unwrap() > 0 && removed["bytes"].as_u64().unwrap() > 0, "{cleaned}");
    assert!(cleaned["instances"][0]["leftovers"].as_array().unwrap().is_empty(), "{cleaned}");
    mission.assert_nothing_left();
}

/// P-DOCTOR-LIVE: `doctor --clean` touches nothing of an instance with a live process, even if
/// other processes of it are dead.
#[test]
fn cleaning_leaves_a_live_mission_alone() {
    let mission = Mission::new("live");
    let mut processes = underway(&mission);
    assert_eq!(doctor(&mission, &["--clean"])["cleaned"][0]["outcome"], "alive");
    processes[1].kill();
    assert_eq!(doctor(&mission, &["--clean"])["cleaned"][0]["outcome"], "alive");
    assert!(doctor_text(&mission, &["--clean"]).contains("alive, left alone"));
    processes[1] = mission.start("perception", &[]);
    mission.await_decisions(mission.decisions() + 2);
    let mut sim = mission.hurry(processes.remove(0), "1");
    assert_eq!(sim.code(), 0, "{}", sim.log());
    assert_eq!(sim.json()["digest"], lockstep(&["--seed", "1"])["digest"]);
    for peer in &mut processes {
        assert_eq!(peer.code(), 0, "{}", peer.log());
    }
}
