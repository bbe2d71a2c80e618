//! Tells the binary which commit it was built from, with a hash of the sources that decide a campaign's rows.

use std::path::{Path, PathBuf};
use std::process::Command;

#[path = "build/sources.rs"]
mod hash;

/// What a mission in lockstep consists of, except for the libraries in `crates`.
const SOURCES: [&str; 4] = ["Cargo.lock", "hopper-sim/src", "perception/src", "planner/src"];

/// Libraries that no row of a campaign depends on.
const ASIDE: [&str; 4] = ["node", "recording", "report", "simulation"];

fn main() {
    let git = |arguments: &[&str]| {
        let output = Command::new("git").args(arguments).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    // Where they are depends on the work tree; a path that is not there would mean building anew each time.
    let watched = ["HEAD", "logs/HEAD"].map(|file| git(&["rev-parse", "--git-path", file]));
    for file in watched.into_iter().flatten().filter(|file| Path::new(file).exists()) {
        println!("cargo::rerun-if-changed={file}");
    }
    let commit = git(&["rev-parse", "--short=12", "HEAD"]).unwrap_or_else(|| "unknown".into());
    let dirty =
        git(&["status", "--porcelain", "--untracked-files=no"]).is_some_and(|changes| !changes.is_empty());
    println!("cargo::rustc-env=HOPPER_COMMIT={commit}{}", if dirty { "-dirty" } else { "" });
    println!("cargo::rustc-env=HOPPER_SOURCES={}", sources());
}

/// What decides the rows of a campaign of missions.
fn sources() -> String {
    let libraries = std::fs::read_dir("crates").into_iter().flatten().flatten();
    let libraries = libraries.filter(|entry| !ASIDE.iter().any(|aside| entry.file_name() == *aside));
    let libraries = libraries.map(|entry| entry.path().join("src")).flat_map(of_library);
    let all: Vec<PathBuf> = SOURCES.map(PathBuf::from).into_iter().chain(libraries).collect();
    hash::hash(Path::new(""), &all, 6)
}

/// The sources of a library; of `crates/vehicle`, those of the libraries in it.
fn of_library(source: PathBuf) -> Vec<PathBuf> {
    let folder = source.parent().unwrap_or(Path::new(""));
    if source.exists() {
        return vec![source];
    }
    let parts = std::fs::read_dir(folder).into_iter().flatten().flatten();
    parts.map(|part| part.path().join("src")).collect()
}
