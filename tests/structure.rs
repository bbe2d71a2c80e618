//! The invariants of ARCHITECTURE.md, stated as absences and read from the sources.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: impl AsRef<Path>) -> String {
    let path = root().join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Folders of all sources, tests included.
const EVERYWHERE: [&str; 10] =
    ["src", "tests", "crates", "hopper-sim", "perception", "planner", "monitor", "tools", "research", "qa"];

/// Folders of all packages of the workspace, from its manifest.
fn packages() -> Vec<String> {
    let manifest = read("Cargo.toml");
    let members = manifest.split("members = [").nth(1).unwrap().split(']').next().unwrap();
    members.split('"').skip(1).step_by(2).map(Into::into).collect()
}

/// Every Rust file below `folder`, tests and benches included.
fn sources(folder: &str) -> Vec<PathBuf> {
    let mut folders = vec![root().join(folder)];
    let mut files = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                files.push(path);
            }
        }
    }
    assert!(!files.is_empty(), "{folder} holds no sources");
    files
}

/// Code lines of a file, comments left out.
fn code(path: &Path) -> String {
    read(path).lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

/// The names under `[dependencies]` of a package.
fn dependencies(package: &str) -> BTreeSet<String> {
    let manifest = read(format!("{package}/Cargo.toml"));
    let section = manifest.split("[dependencies]").nth(1).expect("a package has dependencies");
    let section = section.split("\n[").next().unwrap_or("");
    section
        .lines()
        .filter_map(|line| line.split(['.', ' ', '=']).next())
        .filter(|name| !name.is_empty())
        .map(Into::into)
        .collect()
}

/// P-YARDSTICK: what reads the truth to plan or to judge is used where the truth is at hand anyway.
#[test]
fn only_lockstep_and_the_regret_of_campaigns_use_the_clairvoyant() {
    let allowed = ["src/lockstep.rs", "src/commands/campaign/regret.rs"].map(|path| root().join(path));
    for folder in EVERYWHERE {
        for file in sources(folder) {
            let uses = code(&file).contains("clairvoyant::");
            let own = file.starts_with(root().join("crates/clairvoyant"));
            let test = file.ends_with("structure.rs");
            assert!(
                !uses || own || test || allowed.contains(&file),
                "{} uses the clairvoyant",
                file.display()
            );
        }
    }
    for package in ["planner", "hopper-sim", "perception", "monitor", "crates/campaign", "crates/node"] {
        assert!(!dependencies(package).contains("clairvoyant"), "{package} depends on it");
    }
}

/// P-NO-TRUTH.
#[test]
fn the_planner_never_depends_on_truth() {
    let known = dependencies("planner");
    for stranger in ["hopper-sim", "perception", "terrain", "scenario"] {
        assert!(!known.contains(stranger), "planner depends on {stranger}");
    }
    for file in sources("planner/src") {
        assert!(!code(&file).to_lowercase().contains("truth"), "{} names truth", file.display());
    }
    // Whoever asks for the truth has to name it.
    let request = "impl Request for TruthRequest";
    let declared = code(&root().join("crates/contract/src/wire/truth.rs"));
    assert!(declared.contains(request), "the truth is asked for otherwise");
}

#[test]
fn perception_and_hopper_sim_never_depend_on_each_other_or_on_the_planner() {
    for (package, strangers) in [
        ("perception", ["hopper-sim", "planner", "motion"]),
        ("hopper-sim", ["perception", "planner", "monitor"]),
    ] {
        for stranger in strangers {
            assert!(!dependencies(package).contains(stranger), "{package} depends on {stranger}");
        }
    }
}

/// P-ONE-SHELL.
#[test]
fn only_node_uses_iceoryx2() {
    for package in packages() {
        assert_eq!(dependencies(&package).contains("iceoryx2"), package == "crates/node", "{package}");
    }
}

/// P-ENGINES.
#[test]
fn engines_own_no_clock_no_port_no_thread_and_no_unordered_map() {
    let engines = [
        "crates/contract/src",
        "crates/motion/src",
        "crates/campaign/src",
        "crates/clairvoyant/src",
        "research/known/src",
        "crates/recording/src",
        "crates/report/src",
        "crates/solver/src",
        "planner/src",
        "perception/src",
        "hopper-sim/src",
        "monitor/src",
        "src/simulate",
    ];
    // The solver's second thread, for whoever asks for it; the values are the same without.
    let threads =
        ["crates/solver/src/cold/sweep.rs", "crates/solver/src/cold/pair.rs"].map(|path| root().join(path));
    for file in engines.iter().flat_map(|engine| sources(engine)) {
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        let text = code(&file);
        assert!(
            !text.contains("HashMap") && !text.contains("HashSet"),
            "{} iterates in no order",
            file.display()
        );
        if ["shell.rs", "main.rs", "display.rs"].contains(&name.as_str()) {
            continue;
        }
        for stranger in ["Instant::now", "SystemTime", "Node::now", "std::thread", "std::net"] {
            let allowed = stranger == "std::thread" && threads.contains(&file);
            assert!(allowed || !text.contains(stranger), "{} uses {stranger}", file.display());
        }
    }
}

#[test]
fn only_one_module_knows_bincode() {
    for file in EVERYWHERE.iter().flat_map(|dir| sources(dir)) {
        let codec = file.ends_with("hopper-sim/src/journal/codec.rs") || file.ends_with("structure.rs");
        assert!(codec || !code(&file).contains("bincode::"), "{}", file.display());
    }
}

#[test]
fn what_the_default_mission_does_not_need_is_not_built_for_it() {
    for package in packages() {
        let tool = ["tools/", "research", "qa"].iter().any(|folder| package.starts_with(folder));
        for stranger in
            ["hopper-recordings", "hopper-manual", "hopper-research", "hopper-qa", "known", "hostile"]
        {
            assert!(tool || !dependencies(&package).contains(stranger), "{package} depends on {stranger}");
        }
    }
}

#[test]
fn every_promise_names_its_tests_and_every_test_its_promise() {
    let promises = read("PROMISES.md");
    let files: Vec<PathBuf> = EVERYWHERE.iter().flat_map(|folder| sources(folder)).collect();
    let rows: Vec<&str> = promises.lines().filter(|line| line.starts_with("| P-")).collect();
    assert!(rows.len() >= 40, "{} promises", rows.len());
    let mut promised = BTreeSet::new();
    for row in rows {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let (id, names) = (cells[1], cells[3]);
        assert!(promised.insert(id.to_owned()), "{id} is promised twice");
        let names: Vec<&str> = names.split('`').skip(1).step_by(2).collect();
        assert!(!names.is_empty(), "{id} names no test");
        for name in names {
            let (module, function) = name.split_once("::").expect("module::function");
            let found = files.iter().any(|file| {
                let path = file.to_string_lossy();
                let here = path.ends_with(&format!("/{module}.rs")) || path.contains(&format!("/{module}/"));
                here && read(file).contains(&format!("fn {function}("))
            });
            assert!(found, "{id} names {name}, which is no test");
        }
    }
    let mut named = BTreeSet::new();
    for line in files.iter().flat_map(|file| read(file).lines().map(str::to_owned).collect::<Vec<_>>()) {
        if let Some(id) = line.trim_start().strip_prefix("/// P-") {
            let end = id.find([':', '.', ' ']).unwrap_or(id.len());
            named.insert(format!("P-{}", &id[..end]));
        }
    }
    assert_eq!(promised, named, "promises and the ids that tests name");
}

#[test]
fn every_path_that_the_architecture_names_exists() {
    let text = read("ARCHITECTURE.md");
    let mut paths = 0;
    for quoted in text.split('`').skip(1).step_by(2) {
        let is_path = quoted.contains('/')
            && !quoted.contains([' ', '<', '*', '$'])
            && !quoted.starts_with("hop/")
            && !quoted.starts_with("truth/")
            && !quoted.starts_with("/dev");
        if is_path {
            assert!(root().join(quoted).exists(), "ARCHITECTURE.md names {quoted}");
            paths += 1;
        }
    }
    assert!(paths > 20, "ARCHITECTURE.md is a map of {paths} paths");
}
