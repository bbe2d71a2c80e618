//! The planner knows the brief and the observed map, never the ground itself.

use std::fs;
use std::path::{Path, PathBuf};

fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files.extend(sources(&path));
        } else {
            files.push(path);
        }
    }
    files
}

#[test]
fn the_planner_depends_on_no_crate_that_knows_the_ground() {
    let manifest = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml")).unwrap();
    // Its tests may know more; what it is built from may not.
    let built_from = manifest.split("\n[").find(|section| section.starts_with("dependencies]")).unwrap();
    let names = built_from.lines().filter_map(|line| line.split(['.', '=', ' ']).next());
    for name in names {
        assert!(!["hopper-sim", "perception", "terrain", "scenario"].contains(&name), "depends on {name}");
    }
}

#[test]
fn the_planners_sources_never_name_the_truth() {
    let files = sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"));
    assert!(files.len() > 10);
    for file in files {
        let text = fs::read_to_string(&file).unwrap().to_lowercase();
        let mut words = text.split(|c: char| !c.is_alphabetic());
        assert!(!words.any(|word| word == "truth"), "{} names it", file.display());
    }
}
