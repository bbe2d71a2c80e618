//! Tells the binary which commit it was built from, with a hash of the sources that decide a campaign's rows.

use std::path::{Path, PathBuf};
use std::process::Command;

use sha2::{Digest, Sha256};

/// What a mission in lockstep consists of, except for the libraries in `crates`.
const SOURCES: [&str; 4] = ["Cargo.lock", "hopper-sim/src", "perception/src", "planner/src"];

/// Libraries that no row of a campaign depends on.
const ASIDE: [&str; 8] =
    ["coverage", "coverage-world", "node", "recording", "report", "routing", "simulation", "vehicle"];

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

/// The first twelve digits of SHA-256 over names and contents, in order of names.
fn sources() -> String {
    let mut files = Vec::new();
    let libraries = std::fs::read_dir("crates").into_iter().flatten().flatten();
    let libraries = libraries.filter(|entry| !ASIDE.iter().any(|aside| entry.file_name() == *aside));
    let sources =
        SOURCES.map(PathBuf::from).into_iter().chain(libraries.map(|entry| entry.path().join("src")));
    for source in sources {
        assert!(source.exists(), "build.rs hashes {}, which does not exist", source.display());
        println!("cargo::rerun-if-changed={}", source.display());
        list(&source, &mut files);
    }
    files.sort();
    let mut hasher = Sha256::new();
    for file in files {
        let contents = std::fs::read(&file).unwrap_or_default();
        hasher.update(file.to_string_lossy().as_bytes());
        hasher.update((contents.len() as u64).to_le_bytes());
        hasher.update(contents);
    }
    hasher.finalize()[..6].iter().map(|byte| format!("{byte:02x}")).collect()
}

fn list(path: &Path, files: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(path) else {
        files.push(path.into());
        return;
    };
    for entry in entries.flatten() {
        list(&entry.path(), files);
    }
}
