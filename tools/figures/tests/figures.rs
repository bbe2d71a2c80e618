//! A real mission as PDF and as animation.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "../../../tests/harness/mod.rs"]
mod harness;

use harness::{Mission, stderr};

const CAMPAIGN: &str =
    "name = \"mine\"\nseed = 7\nrepetitions = 2\nscenarios = [\"hard\"]\nplanners = [\"greedy\"]\n";

/// P-FIGURES: `hopper journal draw` and `hopper campaign report` write a picture as PDF and `hopper gif` a mission as an
/// animation of at most 5 MB.
#[test]
fn a_mission_is_written_as_pdf_and_as_animation() {
    let mission = Mission::new("figures");
    let succeed = |words: &[&str]| {
        let output = mission.hopper(words).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{words:?}: {}", stderr(&output));
    };
    succeed(&["run", "--lockstep", "--out", ".", "--seed", "31"]);
    succeed(&["journal", "draw", ".", "--picture", "paper", "--out", "paper.pdf"]);
    assert!(std::fs::read(mission.path("paper.pdf")).unwrap().starts_with(b"%PDF-"));
    std::fs::write(mission.path("mine.toml"), CAMPAIGN).unwrap();
    succeed(&["campaign", "run", "mine.toml"]);
    succeed(&["campaign", "report", "out/mine", "--picture", "cells.pdf"]);
    assert!(std::fs::read(mission.path("cells.pdf")).unwrap().starts_with(b"%PDF-"));
    succeed(&["gif", ".", "--out", "mission.gif", "--width", "240"]);
    let gif = std::fs::read(mission.path("mission.gif")).unwrap();
    assert!(gif.starts_with(b"GIF89a") && gif.len() <= 5_000_000, "{} bytes", gif.len());
}
