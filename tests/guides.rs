//! The guides of ARCHITECTURE.md, followed on an example: a message, a planner, a layer of the map, a body, a sensor, a goal and a motion
//! model are added to a copy of the tree.

#[path = "guides/check.rs"]
#[allow(dead_code, reason = "its main runs in the copy")]
mod check;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: impl AsRef<Path>) -> String {
    let path = root().join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Files that the patch of a guide touches.
fn touched(guide: &str) -> BTreeSet<String> {
    let patch = read(format!("tests/guides/{guide}.patch"));
    patch.lines().filter_map(|line| line.strip_prefix("+++ b/")).map(Into::into).collect()
}

/// Files that the numbered list of a guide names: `FILE`, or for a new one `NAME` in `FOLDER`.
fn named(guide: &str) -> BTreeSet<String> {
    let page = read("ARCHITECTURE.md");
    let heading = format!("### {guide}\n");
    let section = page.split(&heading).nth(1).unwrap_or_else(|| panic!("no guide {guide:?}"));
    let section = section.split("\n#").next().unwrap();
    let file = |line: &str| {
        let parts: Vec<&str> = line.split_once(". ")?.1.split('`').collect();
        Some(if parts[2] == " in " { format!("{}{}", parts[3], parts[1]) } else { parts[1].to_owned() })
    };
    section.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_digit())).filter_map(file).collect()
}

/// Each guide with the patch of its example, and how many files it takes.
const GUIDES: &[(&str, &str, usize)] = &[
    ("Add a message", "add-a-message", 4),
    ("Add a planner", "add-a-planner", 3),
    ("Add a layer", "add-a-layer", 2),
    ("Add a body", "add-a-body", 11),
    ("Add a goal", "add-a-goal", 7),
    ("Add a sensor", "add-a-sensor", 7),
    ("Add a motion model", "add-a-motion-model", 5),
];

/// P-GUIDES.
#[test]
fn each_guide_names_every_file_that_its_example_touches() {
    for (guide, patch, files) in GUIDES {
        let touched = touched(patch);
        assert_eq!(touched.len(), *files, "files that {guide} takes: {touched:?}");
        assert_eq!(named(guide), touched, "files of {guide}, and of its example");
    }
    let mut patches: Vec<String> = Vec::new();
    for entry in std::fs::read_dir(root().join("tests/guides")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "patch") {
            patches.push(path.file_stem().unwrap().to_string_lossy().into_owned());
        }
    }
    patches.sort();
    let mut known: Vec<&str> = GUIDES.iter().map(|(_, patch, _)| *patch).collect();
    known.sort_unstable();
    assert_eq!(patches, known, "each patch belongs to a guide");
}

/// Lines that the patch of a guide adds to or removes from `file`.
fn changed(guide: &str, file: &str) -> Vec<String> {
    let patch = read(format!("tests/guides/{guide}.patch"));
    let of_file = patch.split("diff --git ").find(|part| part.contains(&format!("+++ b/{file}\n"))).unwrap();
    let lines = of_file.lines().filter(|line| !line.starts_with("+++") && !line.starts_with("---"));
    lines.filter(|line| line.starts_with(['+', '-'])).map(Into::into).collect()
}

/// A layer is a file and a line: its example adds one line to the list, and names no display. A body, a goal or a sensor is a file and
/// a line in each crate that has to know it.
#[test]
fn what_is_added_is_one_line_in_each_list() {
    for (guide, list, line) in [
        ("add-a-layer", "crates/report/src/layers/mod.rs", "+    quality => Quality,"),
        ("add-a-body", "crates/contract/src/mission/body/mod.rs", "+        slider => Slider(Slider) = 5, "),
        ("add-a-body", "hopper-sim/src/team/body/mod.rs", "+    slider => Slider,"),
        ("add-a-body", "crates/simulation/src/oracle/body.rs", "+    slider => Slider,"),
        ("add-a-body", "crates/scenario/src/robots/mod.rs", "+    slider => Slider(SliderRules), "),
        ("add-a-goal", "crates/contract/src/mission/goal/mod.rs", "+        summit => Summit(Summit) = 5, "),
        ("add-a-goal", "hopper-sim/src/team/goal/mod.rs", "+    summit => Summit,"),
        ("add-a-goal", "crates/simulation/src/oracle/goal.rs", "+    summit => Summit,"),
        ("add-a-sensor", "crates/contract/src/mission/sensor/mod.rs", "+        sonar => Sonar(Sonar) = 6, "),
        ("add-a-sensor", "crates/simulation/src/sensor.rs", "+    sonar => Sonar,"),
        ("add-a-sensor", "crates/report/src/layers/mod.rs", "+    sonar => Sonar,"),
        ("add-a-motion-model", "hopper-sim/src/dynamics/mod.rs", "+    gust => Gust;"),
        ("add-a-motion-model", "crates/scenario/src/dynamics/mod.rs", "+    gust => Gust(GustRules), "),
    ] {
        let changed = changed(guide, list);
        assert!(changed.len() == 1 && changed[0].starts_with(line), "{list}: {changed:?}");
    }
}

/// The tracked files below `folders`, copied to `copy`. A file keeps its time if it has not changed, so that Cargo
/// compiles only what has.
fn copy_tree(copy: &Path) {
    let mut folders = vec![PathBuf::new()];
    while let Some(folder) = folders.pop() {
        std::fs::create_dir_all(copy.join(&folder)).unwrap();
        remove_strangers(&copy.join(&folder), &root().join(&folder));
        for entry in std::fs::read_dir(root().join(&folder)).unwrap().map(|entry| entry.unwrap()) {
            let path = folder.join(entry.file_name());
            let skipped = ["target", "out", ".git", "fuzz", ".venv", "node_modules"];
            if skipped.iter().any(|name| path.ends_with(name)) {
                continue;
            }
            if entry.file_type().unwrap().is_symlink() {
                link(&entry.path(), &copy.join(&path));
            } else if entry.file_type().unwrap().is_dir() {
                folders.push(path);
            } else {
                let bytes = std::fs::read(entry.path()).unwrap();
                write(&copy.join(&path), &bytes);
            }
        }
    }
}

/// Copies a link that leads into the tree; others are somebody's own.
fn link(original: &Path, copy: &Path) {
    let target = std::fs::read_link(original).unwrap();
    if target.is_relative() && !copy.is_symlink() {
        std::os::unix::fs::symlink(target, copy).unwrap();
    }
}

/// Removes files from a folder of the copy that its original no longer has.
fn remove_strangers(copy: &Path, original: &Path) {
    for entry in std::fs::read_dir(copy).unwrap().map(|entry| entry.unwrap()) {
        if entry.file_type().unwrap().is_file() && !original.join(entry.file_name()).exists() {
            std::fs::remove_file(entry.path()).unwrap();
        }
    }
}

fn write(path: &Path, bytes: &[u8]) {
    if std::fs::read(path).ok().as_deref() != Some(bytes) {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
}

/// Standard output of a command that succeeds.
fn run(command: &mut Command) -> String {
    let output = command.stdin(Stdio::null()).output().unwrap();
    let why = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}: {why}");
    String::from_utf8(output.stdout).unwrap()
}

const MANIFEST: &str = r#"
[package]
name = "guides"
version = "0.0.0"
edition.workspace = true

[dev-dependencies]
contract.workspace = true
hopper-sim.workspace = true
lockstep.workspace = true
monitor.workspace = true
node.workspace = true
report.workspace = true
recording.workspace = true
scenario.workspace = true
serde_json.workspace = true
simulation.workspace = true
"#;

/// The manifest with profiles that optimise nothing of the tree, which takes longer than what is compiled here runs. The
/// dependencies are those that are compiled already.
fn unoptimised(manifest: &str) -> String {
    let section = "[profile.dev.package]\n";
    assert!(manifest.contains(section), "Cargo.toml needs {section:?}");
    let lock = read("Cargo.lock");
    let ours = lock.split("[[package]]").skip(1).filter(|package| !package.contains("\nsource = "));
    let names: BTreeSet<&str> = ours.map(|package| package.split('"').nth(1).unwrap()).collect();
    let lines: String = names.iter().map(|name| format!("{name} = {{ opt-level = 0 }}\n")).collect();
    let is_level_of_ours =
        |line: &str| line.split_once(" = { opt-level = ").is_some_and(|(name, _)| names.contains(name));
    let kept = manifest.lines().filter(|line| !is_level_of_ours(line));
    let kept: String = kept.flat_map(|line| [line, "\n"]).collect();
    kept.replacen(section, &(section.to_owned() + &lines), 1)
}

/// P-GUIDES: A message, a planner, a layer of the map, a body, a goal, a sensor and a motion model that
/// are added by the guides of ARCHITECTURE.md, in the files they name and no others, work: the message has port,
/// memory budget, simulation and recording, the planner flies, page, picture and recording show the
/// layer, the body reaches its goal and a hopper the new one, what the sensor reports of cells is
/// on the map, in messages and on a layer, and what the motion model tells of hops is journalled.
// Long: a line for each claim.
#[test]
fn what_is_added_by_the_guides_works() {
    if suites::is_left_out("guides that compile") {
        return;
    }
    // Its own target folder would compile all dependencies again.
    let test = std::env::current_exe().unwrap();
    let profile = test.ancestors().nth(2).unwrap();
    let target = profile.parent().unwrap();
    let copy = target.join("guides");
    copy_tree(&copy);
    for (_, patch, _) in GUIDES {
        // New files may be left from the last run.
        for file in touched(patch).iter().filter(|file| !root().join(file).exists()) {
            let _ = std::fs::remove_file(copy.join(file));
        }
        let file = root().join("tests/guides").join(patch).with_extension("patch");
        // Git would otherwise look for the files in the repository around the copy.
        let mut git = Command::new("git");
        run(git.arg("apply").arg(&file).current_dir(&copy).env("GIT_CEILING_DIRECTORIES", target));
    }
    write(&copy.join("guides/Cargo.toml"), MANIFEST.as_bytes());
    write(&copy.join("guides/src/lib.rs"), b"");
    write(&copy.join("guides/examples/guides.rs"), read("tests/guides/check.rs").as_bytes());
    // Of the members and of those that are built where no package is named, as the tests were: so what is compiled already
    // has the same features.
    let manifest = read("Cargo.toml").replace("members = [\n", "members = [\n    \"guides\",\n");
    write(&copy.join("Cargo.toml"), unoptimised(&manifest).as_bytes());

    let mut cargo = Command::new(env!("CARGO"));
    cargo
        .args(["run", "--quiet", "--offline", "--example", "guides", "--target-dir"])
        .arg(target)
        .current_dir(&copy);
    let told = run(&mut cargo);
    let list = |what: &str| -> BTreeSet<String> {
        let line = told.lines().find_map(|line| line.strip_prefix(what));
        line.unwrap_or_else(|| panic!("no {what}: {told}")).split_whitespace().map(Into::into).collect()
    };
    let (hard, coverage) = (check::built_in("hard").brief, check::built_in("coverage").brief);
    let added = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
    for (what, without, names) in [
        ("registered ", check::registered(), added(&["hop/r0/battery"])),
        ("budgeted ", check::budgeted(), added(&["hop/r0/battery"])),
        ("simulated ", check::simulated(), added(&["battery"])),
        ("recorded as JSON ", check::recorded_as_json(), added(&["hop/r0/battery"])),
        ("map layers ", check::layers(&hard), added(&["quality"])),
        ("layers in the picture ", check::layers_in_the_picture(&hard), added(&["quality"])),
        ("layers on the page ", check::layers_on_the_page(&hard), added(&["quality"])),
        ("layers recorded ", check::layers_recorded(), added(&["view/quality", "view/sonar"])),
        ("sonar layers ", check::layers(&coverage), added(&["quality", "sonar"])),
        (
            "sonar layers in the picture ",
            check::layers_in_the_picture(&coverage),
            added(&["quality", "sonar"]),
        ),
        ("sonar layers on the page ", check::layers_on_the_page(&coverage), added(&["quality", "sonar"])),
    ] {
        let mut expected: BTreeSet<String> = without.into_iter().collect();
        for name in names {
            assert!(expected.insert(name.clone()), "{what}{name} in the tree itself");
        }
        assert_eq!(list(what), expected, "{what}");
    }
    let without = check::flown("beeline");
    assert!(without.unwrap_err().contains("beeline"), "it flies in the tree itself");
    assert_eq!(list("flown "), BTreeSet::from(["goal".to_owned()]), "{told}");
    assert!(check::slid().unwrap_err().contains("slider"), "it slides in the tree itself");
    assert_eq!(list("slid "), BTreeSet::from(["goal".to_owned()]), "{told}");
    assert!(check::climbed().unwrap_err().contains("summit"), "the tree itself has the goal");
    assert!(told.contains("climbed goal, higher neighbours: 0"), "{told}");
    assert!(check::sensing(6, 3.0).unwrap_err().contains("robot.sensor"), "it is in the tree itself");
    assert!(check::blown().unwrap_err().contains("gust"), "it blows in the tree itself");
    assert!(told.contains("blown goal, a gust for each hop: true, journalled: true"), "{told}");
    // Each cell was at most a metre from a rover at some time.
    for line in ["sonar flown goal", "sonar reported 170 to 255", "sonar share 1"] {
        assert!(told.lines().any(|told| told == line), "{line}: {told}");
    }
}
