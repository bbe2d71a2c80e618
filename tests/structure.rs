//! The invariants of ARCHITECTURE.md, stated as absences: what cargo resolves, and what only the sources can tell.

#[path = "structure/functions.rs"]
mod functions;
#[path = "structure/imports.rs"]
mod imports;
#[path = "structure/promises.rs"]
mod promises;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: impl AsRef<Path>) -> String {
    let path = root().join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Folders of all sources, tests included.
const EVERYWHERE: [&str; 12] = [
    "src",
    "tests",
    "bench",
    "benches",
    "crates",
    "hopper-sim",
    "perception",
    "planner",
    "monitor",
    "tools",
    "research",
    "qa",
];

/// Folders of all packages of the workspace, from its manifest.
fn packages() -> Vec<String> {
    let manifest = read("Cargo.toml");
    let members = manifest.split("members = [").nth(1).unwrap().split(']').next().unwrap();
    members.split('"').skip(1).step_by(2).map(Into::into).collect()
}

/// The manifests of all packages.
pub fn manifests() -> impl Iterator<Item = String> {
    packages().into_iter().map(|package| read(format!("{package}/Cargo.toml")))
}

/// Every Rust file below `folder`, tests and benches included.
fn sources(folder: impl AsRef<Path>) -> Vec<PathBuf> {
    let folder = root().join(folder);
    let mut folders = vec![folder.clone()];
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
    assert!(!files.is_empty(), "{} holds no sources", folder.display());
    files
}

/// Code lines of a file, comments left out.
fn code(path: &Path) -> String {
    read(path).lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

/// The direct dependents of a crate, tests and benches included.
fn dependents(crate_name: &str) -> BTreeSet<String> {
    let arguments = ["--workspace", "--edges", "normal,build,dev", "--depth", "1", "--invert", crate_name];
    let mut names = cargo_tree(&arguments);
    assert!(names.remove(crate_name), "nothing depends on {crate_name}");
    names
}

/// All crates that are linked into `package`, itself included.
fn linked(package: &str, features: &[&str]) -> BTreeSet<String> {
    cargo_tree(&[&["--package", package, "--edges", "normal"], features].concat())
}

/// The crates that `cargo tree` prints.
fn cargo_tree(arguments: &[&str]) -> BTreeSet<String> {
    let output = Command::new(env!("CARGO"))
        .current_dir(root())
        .args(["tree", "--locked", "--offline", "--prefix", "none", "--format", "{p}"])
        .args(arguments)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines()
        .filter_map(|line| line.split(' ').next())
        .filter(|name| !name.is_empty())
        .map(Into::into)
        .collect()
}

/// Whether `stranger`, which has to be the name of a package, is not among `known`.
fn is_absent(known: &BTreeSet<String>, stranger: &str) -> bool {
    let exists = read("Cargo.lock").lines().any(|line| line == format!("name = \"{stranger}\""));
    assert!(exists, "no package has the name {stranger}");
    !known.contains(stranger)
}

fn set(names: &[&str]) -> BTreeSet<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

/// P-YARDSTICK: Only lockstep and the regret of campaigns use the clairvoyant.
///
/// What reads the truth to plan or to judge is used where the truth is at hand anyway.
#[test]
fn only_lockstep_and_the_regret_of_campaigns_use_the_clairvoyant() {
    assert_eq!(dependents("hopper-clairvoyant"), set(&["hopper", "hopper-lockstep"]));
    // Within one package only the sources can tell.
    let allowed = root().join("src/commands/campaign/regret.rs");
    for file in sources("src") {
        let uses = code(&file).contains("clairvoyant::");
        assert!(!uses || file == allowed, "{} uses the clairvoyant", file.display());
    }
}

/// P-NO-TRUTH: The planner never depends on the truth.
#[test]
fn the_planner_never_depends_on_truth() {
    let known = linked("hopper-planner", &["--all-features"]);
    for stranger in
        ["hopper-sim", "hopper-perception", "hopper-terrain", "hopper-scenario", "hopper-scout-world"]
    {
        assert!(is_absent(&known, stranger), "planner depends on {stranger}");
    }
    for file in sources("planner/src") {
        assert!(!code(&file).to_lowercase().contains("truth"), "{} names truth", file.display());
    }
    // Whoever asks for the truth has to name it.
    let request = "impl Request for TruthRequest";
    let declared = code(&root().join("crates/contract/src/wire/truth.rs"));
    assert!(declared.contains(request), "the truth is asked for otherwise");
}

/// P-MYOPIC: A planner for coverage decides from what the rovers of its team have sensed, and
/// cannot depend on other ground.
///
/// A planner for coverage gets what the rovers have sensed; the crate that it is in cannot name the
/// ground.
#[test]
fn planners_for_coverage_never_depend_on_the_true_ground() {
    let known = linked("hopper-coverage", &["--all-features"]);
    for stranger in
        ["hopper-coverage-world", "hopper-sim", "hopper-perception", "hopper-terrain", "hopper-scenario"]
    {
        assert!(is_absent(&known, stranger), "coverage depends on {stranger}");
    }
    for file in sources("crates/coverage/src") {
        let code = code(&file);
        assert!(
            !code.contains("coverage_world") && !code.contains("World"),
            "{} names the ground",
            file.display()
        );
    }
}

/// P-NO-PAPER: The library `campaign` names no paper and depends on nothing in `research/`.
#[test]
fn campaign_knows_no_paper() {
    // What `cargo metadata` says of every dependency, those of tests included.
    let arguments = ["--package", "campaign", "--edges", "normal,build,dev"];
    let known = cargo_tree(&arguments);
    for stranger in ["p19", "p21", "p22", "p23", "hopper-research"] {
        assert!(is_absent(&known, stranger), "campaign depends on {stranger}");
    }
    for file in sources("crates/campaign") {
        let text = read(&file).to_lowercase();
        for name in ["paper", "p19", "p21", "p22", "p23"] {
            assert!(!text.contains(name), "{} names {name}", file.display());
        }
    }
    // Every package in `research/` but the commands is a paper's.
    let packages = packages();
    let papers = packages.iter().filter_map(|package| package.strip_prefix("research/"));
    assert_eq!(papers.collect::<Vec<_>>(), ["p19", "p21", "p22", "p23"]);
}

/// P-LAYERS: Page, terminal, pictures and recordings go through one list of map layers and name no
/// layer; each has a name of its own.
#[test]
fn no_display_names_a_layer() {
    for folder in ["monitor", "crates/report/src/picture", "crates/recording/src", "crates/browser", "src"] {
        for file in sources(folder) {
            if file.components().any(|part| part.as_os_str() == "tests") {
                continue;
            }
            let code = code(&file);
            let code = code.split("#[cfg(test)]").next().unwrap();
            for layer in report::Layer::ALL {
                let name = format!("Layer::{layer:?}");
                assert!(!code.contains(&name), "{} names {name}", file.display());
            }
        }
    }
}

#[test]
fn perception_and_hopper_sim_never_depend_on_each_other_or_on_the_planner() {
    for (package, strangers) in [
        ("hopper-perception", ["hopper-sim", "hopper-planner", "hopper-motion"]),
        ("hopper-sim", ["hopper-perception", "hopper-planner", "monitor"]),
    ] {
        let known = linked(package, &["--all-features"]);
        for stranger in strangers {
            assert!(is_absent(&known, stranger), "{package} depends on {stranger}");
        }
    }
}

/// P-ONE-SHELL: Only `crates/node` uses iceoryx2.
#[test]
fn only_node_uses_iceoryx2() {
    assert_eq!(dependents("iceoryx2"), set(&["hopper-node"]));
}

/// Packages that are not engines: they run processes, threads, or commands on a machine.
const HOSTS: [&str; 17] = [
    ".",
    "bench",
    "bench/impacts",
    "crates/node",
    "monitor/foxglove",
    "monitor/terminal",
    "python",
    "qa",
    "qa/hostile",
    "research",
    "tools/dynamics",
    "tools/figures",
    "tools/link",
    "tools/manual",
    "tools/recordings",
    "tools/site",
    "tools/view",
];

/// P-ENGINES: Engines use no clock, no port, no thread (except the solver's second) and no
/// unordered map.
///
/// Clippy refuses clocks, threads and sockets where an engine opts in, and unordered maps
/// everywhere; see clippy.toml. An engine links nothing that has them.
#[test]
fn engines_own_no_clock_no_port_no_thread_and_no_unordered_map() {
    let mut waived = BTreeSet::new();
    for package in packages() {
        assert!(
            read(format!("{package}/Cargo.toml")).contains("[lints]\nworkspace = true"),
            "{package} lints itself"
        );
        if HOSTS.contains(&package.as_str()) {
            continue;
        }
        let lints = read(format!("{package}/src/lib.rs")).contains("#![warn(clippy::disallowed_methods)]");
        assert!(lints, "{package} needs #![warn(clippy::disallowed_methods)] in lib.rs");
        for file in sources(format!("{package}/src")) {
            if code(&file).contains("allow(clippy::disallowed") {
                waived.insert(file.strip_prefix(root()).unwrap().to_string_lossy().into_owned());
            }
        }
    }
    // The page's sockets; the solver's second thread, for whoever asks for it: the values are the same without.
    assert_eq!(waived, set(&["crates/solver/src/cold/sweep.rs", "monitor/src/web/mod.rs"]));
    // The simulation links every engine but the others.
    for package in
        ["simulation", "campaign", "p19", "p22", "p23", "hopper-coverage-world", "hopper-scout-world"]
    {
        let known = linked(package, &["--no-default-features"]);
        for stranger in [
            "hopper-node",
            "iceoryx2",
            "clap",
            "httparse",
            "indicatif",
            "rayon",
            "signal-hook",
            "tracing-subscriber",
        ] {
            assert!(is_absent(&known, stranger), "{package} links {stranger}");
        }
    }
}

#[test]
fn only_one_module_knows_bincode() {
    assert_eq!(dependents("bincode"), set(&["hopper-sim"]));
    for file in sources("hopper-sim") {
        // The test forges records with checksums that are right.
        let knows = ["hopper-sim/src/journal/codec.rs", "hopper-sim/tests/engine/tampered.rs"];
        assert!(
            knows.iter().any(|known| file.ends_with(known)) || !code(&file).contains("bincode::"),
            "{}",
            file.display()
        );
    }
}

/// `cargo test` builds the program of a package only for integration tests of that package: without one, tests
/// of other packages would run a program that is not there.
#[test]
fn every_program_is_built_by_the_documented_test_command() {
    let is_tool = |package: &String| {
        let manifest = read(format!("{package}/Cargo.toml"));
        manifest.contains("name = \"hopper-") && root().join(package).join("src/main.rs").exists()
    };
    let programs: Vec<String> = packages().into_iter().filter(is_tool).collect();
    assert!(programs.len() > 5, "{programs:?}");
    for package in programs {
        let tests = root().join(&package).join("tests");
        let is_target = |file: &PathBuf| {
            let folder = file.parent().expect("it lies in a folder");
            folder == tests || folder.parent() == Some(&tests) && file.ends_with("main.rs")
        };
        let any = tests.is_dir() && sources(&tests).iter().any(is_target);
        assert!(any, "{package} has a program, but no integration test");
    }
}

#[test]
fn what_the_default_mission_does_not_need_is_not_built_for_it() {
    let built = linked("hopper", &[]);
    for stranger in [
        "hopper-dynamics",
        "hopper-figures",
        "hopper-link",
        "hopper-recordings",
        "hopper-manual",
        "hopper-research",
        "hopper-qa",
        "hopper-view",
        "foxglove",
        "foxglove-server",
        "link",
        "p19",
        "p21",
        "p22",
        "hostile",
        "mcap",
        "ratatui",
        "cdr-encoding",
        "recorder",
        "recording",
        "ros2",
        "simulation",
        "spacepackets",
        "telemetry",
        "terminal",
        "tungstenite",
    ] {
        assert!(is_absent(&built, stranger), "hopper builds {stranger}");
    }
}

/// P-SUPPLY-CHAIN: CI checks licences, sources and known vulnerabilities of every dependency with
/// `cargo deny` where its database is available, and says so where it is not. Each advisory that is
/// waived has a reason and a date.
#[test]
fn ci_checks_the_dependencies_and_every_waiver_has_a_reason() {
    assert!(
        read(".ci/run").contains("\n.ci/deny\n") && read(".ci/deny").contains("check"),
        "CI runs .ci/deny"
    );
    let config = read("deny.toml");
    let waivers = config.split("ignore = [").nth(1).unwrap().split("\n]").next().unwrap();
    let mut reason = String::new();
    let mut waived = 0;
    for line in waivers.lines().map(str::trim) {
        if let Some(comment) = line.strip_prefix('#') {
            // A comment after an advisory is about the next one.
            if reason.ends_with('\n') {
                reason.clear();
            }
            reason += comment;
        } else if line.contains("RUSTSEC-") {
            assert!(reason.contains("Waived 20") && reason.contains("look again"), "{line} {reason:?}");
            waived += 1;
            reason = reason.trim_end().to_owned() + "\n";
        }
    }
    assert!(waived > 0, "{config}");
}

/// A new body changes its files in `oracle/`, and nothing of what checks the protocol.
#[test]
fn the_checker_names_no_body() {
    let mut files = sources("crates/simulation/src/checker");
    files.extend(["checker.rs", "model.rs"].map(|file| root().join("crates/simulation/src").join(file)));
    let words =
        ["hopper", "rover", "driver", "helicopter", "scouts", "robots::", "body::", "goal::", "account::"];
    for file in files {
        let text = read(&file).to_lowercase();
        // The process hopper-sim is named after a body.
        let text = text.replace("hopper-sim", "").replace("hopper_sim", "").replace("hoppersim", "");
        let named = words.iter().find(|word| text.contains(**word));
        assert!(named.is_none(), "{} names {named:?}", file.display());
    }
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

/// P-REGISTERED: Every message and request is in the list from which build id, memory budget,
/// `hopper topic`, simulation and recording follow.
///
/// What is not in the list is neither checked at start nor budgeted, simulated or shown by `hopper
/// topic`.
#[test]
fn every_message_is_in_the_list_that_everything_follows_from() {
    let declared = |declaration: &str| -> BTreeSet<String> {
        let files = sources("crates/contract/src/wire");
        let texts = files.iter().map(|path| code(path)).collect::<Vec<_>>().join("\n");
        let after = texts.split(declaration).skip(1).map(|rest| rest.split(" {").next().unwrap().trim());
        after.map(Into::into).collect()
    };
    let list = read("crates/contract/src/wire/mod.rs");
    let listed = |call: &str| -> BTreeSet<String> {
        list.split(call).skip(1).map(|rest| rest.split(">()").next().unwrap().into()).collect()
    };
    for (declaration, call) in
        [("\nimpl Message for ", "visitor.message::<"), ("\nimpl Request for ", "visitor.request::<")]
    {
        let declared = declared(declaration);
        assert!(declared.len() >= 3, "{declared:?}");
        assert_eq!(declared, listed(call), "declared in crates/contract/src/wire, and a line in `visit`");
    }
}

/// A file of tests that nothing declares would never be run.
#[test]
fn every_file_of_tests_is_a_program_or_part_of_one() {
    let mut parts = 0;
    for package in packages() {
        let manifest = read(format!("{package}/Cargo.toml"));
        let tests = root().join(&package).join("tests");
        if !manifest.contains("\nautotests = false\n") || !tests.is_dir() {
            continue;
        }
        let main = std::fs::read_to_string(tests.join("main.rs")).unwrap_or_default();
        for file in sources(&tests).iter().filter(|file| file.parent() == Some(&tests)) {
            let name = file.file_stem().unwrap().to_str().unwrap();
            let is_part = main.lines().any(|line| line == format!("mod {name};"));
            let is_program = manifest.contains(&format!("path = \"tests/{name}.rs\""));
            assert!(is_part || is_program, "{} is run by no program", file.display());
            parts += usize::from(is_part);
        }
    }
    assert!(parts > 60, "{parts} files of tests are parts of a program");
}
