//! What is published, as libraries, can be: names, descriptions, READMEs, and dependencies that are published too.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

/// Libraries that users may depend on: docs/libraries.md lists them. The other published packages are there because these need them.
const LIBRARIES: [&str; 8] = [
    "hopper-contract",
    "hopper-lockstep",
    "hopper-motion",
    "hopper-planner",
    "hopper-scatter",
    "hopper-scenario",
    "hopper-solver",
    "hopper-terrain",
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The packages of the workspace as cargo sees them.
fn packages() -> Vec<Value> {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["metadata", "--no-deps", "--offline", "--locked", "--format-version", "1"]);
    let output = cargo.current_dir(root()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    metadata["packages"].as_array().unwrap().clone()
}

fn name(package: &Value) -> &str {
    package["name"].as_str().unwrap()
}

fn folder(package: &Value) -> PathBuf {
    Path::new(package["manifest_path"].as_str().unwrap()).parent().unwrap().into()
}

fn published() -> Vec<Value> {
    packages().into_iter().filter(|package| package["publish"].is_null()).collect()
}

/// P-LIBRARIES: Every published package has a name, description, README and keywords fit for a
/// registry, and depends on published ones only; every library for users has an example, a doctest,
/// and a row in docs/libraries.md.
#[test]
fn every_published_package_is_described_and_depends_on_published_ones() {
    let published = published();
    let names: BTreeSet<&str> = published.iter().map(name).collect();
    for package in &published {
        let name = name(package);
        assert!(name.starts_with("hopper-"), "{name}");
        for field in ["description", "license", "rust_version"] {
            assert!(package[field].is_string(), "{name} has no {field}");
        }
        // The registry's limits.
        assert!((1..=5).contains(&package["keywords"].as_array().unwrap().len()), "{name}");
        assert!(
            package["keywords"].as_array().unwrap().iter().all(|word| word.as_str().unwrap().len() <= 20)
        );
        let readme = std::fs::read_to_string(folder(package).join("README.md")).unwrap();
        assert!(readme.starts_with(&format!("# {name}\n")), "{name}: {readme}");
        for dependency in package["dependencies"].as_array().unwrap() {
            let needed = dependency["name"].as_str().unwrap();
            // Without a version a dependency of tests is left out of what is published.
            let stays = dependency["kind"] != "dev" || dependency["req"] != "*";
            if dependency["path"].is_string() && stays {
                assert!(names.contains(needed), "{name} needs {needed}, which is not published");
                assert_ne!(dependency["req"], "*", "{name} needs a version of {needed}");
            }
        }
    }
}

/// P-LIBRARIES. These are the libraries that a user starts from.
#[test]
fn every_library_has_an_example_and_a_doctest_and_is_listed() {
    let published = published();
    let page = std::fs::read_to_string(root().join("docs/libraries.md")).unwrap();
    for library in LIBRARIES {
        let package = published.iter().find(|package| name(package) == library).expect("it is published");
        let targets = package["targets"].as_array().unwrap();
        let is = |target: &Value, kind: &str| target["kind"].as_array().unwrap().contains(&kind.into());
        assert!(targets.iter().any(|target| is(target, "example")), "{library} has no example");
        let lib = targets.iter().find(|target| is(target, "lib")).unwrap();
        let source = std::fs::read_to_string(lib["src_path"].as_str().unwrap()).unwrap();
        assert!(source.contains("//! ```"), "{library} has no doctest at its root");
        let row = format!("| `{library}` | `{}` |", lib["name"].as_str().unwrap());
        assert!(page.contains(&row), "docs/libraries.md needs {row}");
    }
    let listed = page.lines().filter(|line| line.starts_with("| `hopper-")).count();
    assert_eq!(listed, LIBRARIES.len(), "docs/libraries.md lists {listed}");
}
