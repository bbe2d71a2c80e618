//! Writes valid input for every fuzz target: `cargo run -p hostile --example corpus -- FOLDER` makes FOLDER/TARGET/seed-N.

#![allow(clippy::unwrap_used, reason = "a tool for developers")]

use std::path::PathBuf;

fn main() {
    let folder = PathBuf::from(std::env::args().nth(1).expect("need a folder"));
    for target in hostile::TARGETS {
        let folder = folder.join(target.name);
        std::fs::create_dir_all(&folder).unwrap();
        for (number, bytes) in (target.seeds)().iter().enumerate() {
            std::fs::write(folder.join(format!("seed-{number}")), bytes).unwrap();
        }
    }
}
