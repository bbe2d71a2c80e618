//! Tells the program a hash of the sources that decide the rows of studies.

use std::path::{Path, PathBuf};

#[path = "../build/sources.rs"]
mod hash;

/// What only studies use. What missions use too is in the version of the package `hopper`.
const SOURCES: [&str; 4] =
    ["research/p19/src", "research/p21/src", "research/src/studies", "research/src/studies.rs"];

fn main() {
    println!(
        "cargo::rustc-env=RESEARCH_SOURCES={}",
        hash::hash(Path::new(".."), &SOURCES.map(PathBuf::from), 6)
    );
}
