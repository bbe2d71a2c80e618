//! Slow tests that continuous integration leaves out as long as their own files are those that have passed.
//!
//! A suite is a group of tests with the files that are theirs alone. `.ci/passed.tsv` holds for each the fingerprint of these files
//! when all its tests passed. With `CI=true` a suite is left out whose files still have that fingerprint; `CI_ALL=1` runs all, as does
//! the documented test command outside of CI. What was left out is noted in a file of the target folder, which `.ci/run` prints.
//! A change elsewhere that breaks a suite is found by the next run of all.

#![warn(clippy::disallowed_methods)]

use std::fmt::Write as _;
use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::process::Command;

use sha2::{Digest as _, Sha256};

/// Tests that are slow, and the files that are theirs alone.
#[derive(Clone, Copy, Debug)]
pub struct Suite {
    /// What it is called in the list of what was left out.
    pub name: &'static str,
    /// Files and folders, from the root of the repository.
    pub files: &'static [&'static str],
    /// Test programs that are built and run by a test of the root: their manifests have `test = false`.
    pub programs: &'static [&'static str],
}

impl Suite {
    /// Tests in packages that are built anyway.
    const fn new(name: &'static str, files: &'static [&'static str]) -> Self {
        Self { name, files, programs: &[] }
    }
}

/// All of them.
pub const SUITES: [Suite; 13] = [
    Suite::new("python", &["python", "tests/python.rs"]),
    Suite::new("packets in Python", &["tools/link", "crates/telemetry"]),
    Suite::new("site", &["tools/site", "crates/browser"]),
    Suite::new("page in a browser", &["monitor/src/web", "tests/web", "tests/web.rs"]),
    Suite::new("batch systems", &["tests/batch", "tests/batch.rs"]),
    Suite::new(
        "endurance",
        &["qa/src/chaos", "qa/src/chaos.rs", "qa/src/endure.rs", "qa/tests/chaos.rs", "qa/tests/endure.rs"],
    ),
    Suite::new("further seeds", &["crates/simulation", "qa/src/simulate.rs", "qa/tests/simulation.rs"]),
    Suite::new("planted bugs", &["qa/planted", "qa/src/planted", "qa/tests/planted.rs"]),
    Suite::new("guides that compile", &["tests/guides", "tests/guides.rs"]),
    Suite::new("own planner", &["templates", "tests/own_planner.rs"]),
    Suite {
        name: "research",
        files: &["research"],
        programs: &["study_campaign", "study_coverage", "study_gallery", "study_scouting", "quality"],
    },
    Suite {
        name: "pictures and manual",
        files: &["tools/figures", "tools/manual"],
        programs: &["figures", "manual"],
    },
    Suite {
        name: "schemas",
        files: &["qa/schemas", "crates/recording/proto"],
        programs: &["committed", "foxglove_messages"],
    },
];

/// The root of the repository.
fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// Where is noted what was left out, a line each.
#[must_use]
pub fn notes() -> PathBuf {
    root().join("target/left-out.txt")
}

/// Whether the tests of a suite are to be left out now; if so, it is noted.
///
/// # Panics
/// If there is no suite of that name, or its files cannot be read.
#[must_use]
pub fn is_left_out(name: &str) -> bool {
    let suite = SUITES.iter().find(|suite| suite.name == name);
    let suite = suite.unwrap_or_else(|| panic!("no suite {name:?}"));
    let is = |variable: &str, value: &str| std::env::var(variable).is_ok_and(|given| given == value);
    if !is("CI", "true") || is("CI_ALL", "1") {
        return false;
    }
    let passed = fs::read_to_string(root().join(".ci/passed.tsv")).unwrap_or_default();
    let fingerprint = fingerprint(root(), suite.files).expect("the files of a suite can be read");
    let is_passed = passed.lines().any(|line| line.split('\t').eq([name, fingerprint.as_str()]));
    if is_passed {
        let notes = fs::OpenOptions::new().create(true).append(true).open(notes());
        // One write: tests run side by side.
        let noted = notes.and_then(|mut file| file.write_all(format!("{name}\n").as_bytes()));
        noted.expect("what was left out can be noted");
    }
    is_passed
}

/// Builds and runs the test programs of a suite, in the profile and the target folder of the tests that ask for it, unless they are
/// to be left out.
///
/// # Panics
/// If there is no such suite, or one of its tests fails.
pub fn run_programs(name: &str) {
    if is_left_out(name) {
        return;
    }
    let suite = SUITES.iter().find(|suite| suite.name == name).expect("it was found before");
    let test = std::env::current_exe().expect("a test knows its program");
    let profile = test.ancestors().nth(2).expect("tests lie in a folder of the profile");
    let target = profile.parent().expect("profiles lie in the target folder");
    let mut cargo = Command::new(env!("CARGO"));
    // Of no package by name: so what is compiled already has the same features.
    cargo.args(["test", "--quiet", "--target-dir"]).arg(target);
    cargo.args(suite.programs.iter().flat_map(|program| ["--test", program]));
    cargo.args(profile.ends_with("release").then_some("--release")).current_dir(root());
    let output = cargo.output().expect("cargo can be started");
    let text = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    assert!(output.status.success(), "{}", text.concat());
}

/// What `.ci/passed.tsv` says once all suites have passed.
///
/// # Errors
/// If their files cannot be read.
pub fn passed() -> io::Result<String> {
    let line = |suite: &Suite| Ok(format!("{}\t{}\n", suite.name, fingerprint(root(), suite.files)?));
    SUITES.iter().map(line).collect()
}

/// SHA-256 over names and contents of files and folders, in the order of their names; not over what tools leave behind.
fn fingerprint(root: &Path, files: &[&str]) -> io::Result<String> {
    let mut hasher = Sha256::new();
    for file in files {
        add(root, Path::new(file), &mut hasher)?;
    }
    let mut text = String::new();
    for byte in hasher.finalize() {
        let _ = write!(text, "{byte:02x}");
    }
    Ok(text)
}

fn add(root: &Path, path: &Path, hasher: &mut Sha256) -> io::Result<()> {
    let whole = root.join(path);
    if !whole.is_dir() {
        let contents = fs::read(&whole)
            .map_err(|error| io::Error::new(error.kind(), format!("{}: {error}", path.display())))?;
        hasher.update(path.to_string_lossy().as_bytes());
        hasher.update((contents.len() as u64).to_le_bytes());
        hasher.update(contents);
        return Ok(());
    }
    let mut names = fs::read_dir(&whole)?
        .map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned()))
        .collect::<io::Result<Vec<String>>>()?;
    names.sort();
    for name in names {
        let is_left_behind =
            name.starts_with('.') || ["target", "__pycache__", "node_modules"].contains(&name.as_str());
        if !is_left_behind && !name.ends_with(".so") {
            add(root, &path.join(name), hasher)?;
        }
    }
    Ok(())
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]
mod tests {
    use super::*;

    #[test]
    fn the_files_of_every_suite_are_there_and_each_has_its_own_fingerprint() {
        let passed = passed().unwrap();
        let mut prints: Vec<&str> = passed.lines().map(|line| line.split('\t').nth(1).unwrap()).collect();
        prints.sort_unstable();
        prints.dedup();
        assert_eq!(prints.len(), SUITES.len());
    }

    #[test]
    fn a_fingerprint_changes_with_a_name_or_a_byte_and_not_with_what_tools_leave_behind() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        fs::create_dir_all(root.join("suite/inner")).unwrap();
        fs::write(root.join("suite/inner/a"), "one").unwrap();
        let print = || fingerprint(root, &["suite"]).unwrap();
        let first = print();
        fs::create_dir_all(root.join("suite/__pycache__")).unwrap();
        fs::write(root.join("suite/__pycache__/b"), "two").unwrap();
        assert_eq!(print(), first);
        fs::write(root.join("suite/inner/a"), "onE").unwrap();
        assert_ne!(print(), first);
        fs::write(root.join("suite/inner/a"), "one").unwrap();
        assert_eq!(print(), first);
        fs::rename(root.join("suite/inner/a"), root.join("suite/inner/c")).unwrap();
        assert_ne!(print(), first);
        assert!(fingerprint(root, &["nowhere"]).is_err());
    }
}
