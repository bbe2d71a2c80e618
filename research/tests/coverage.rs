//! `hopper coverage` on few worlds: what must come out of them too, and what is refused.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::process::{Command, Output};

use serde_json::Value;

fn coverage(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hopper-research")).arg("coverage").args(arguments).output().unwrap()
}

#[test]
fn a_study_of_few_worlds_has_every_claim_with_a_verdict_and_the_figures() {
    let dir = tempfile::tempdir().unwrap();
    let output = coverage(&["--runs", "100", "--format", "json", "--out", dir.path().to_str().unwrap()]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let study: Value = serde_json::from_slice(&output.stdout).unwrap();
    let claims = study["claims"].as_array().unwrap();
    assert!(claims.len() >= 15, "{} claims", claims.len());
    for claim in claims {
        assert!(["holds", "fails", "open"].contains(&claim["verdict"].as_str().unwrap()), "{claim}");
    }
    let verdict = |words: &str| {
        let claim = claims.iter().find(|claim| claim["claim"].as_str().unwrap().contains(words));
        claim.unwrap()["verdict"].as_str().unwrap().to_owned()
    };
    assert_eq!(verdict("overlap is shorter than Voronoi"), "holds");
    assert_eq!(verdict("spiral is shorter than boustrophedon"), "holds");
    for row in study["ours"].as_array().unwrap() {
        assert!(row["saving"]["low"].as_f64().unwrap() > 0.0, "{row}");
        assert!(
            row["bound"].as_f64().unwrap() <= row["ours"]["mean"]["value"].as_f64().unwrap() + 1e-9,
            "{row}"
        );
    }
    let json = std::fs::read(dir.path().join("coverage.json")).unwrap();
    assert_eq!(json, output.stdout);
    for name in ["coverage.txt", "coverage.md", "fig-6.svg", "fig-7.svg", "fig-8.svg"] {
        assert!(dir.path().join(name).is_file(), "{name}");
    }
}

#[test]
fn too_few_runs_for_an_interval_are_refused() {
    let output = coverage(&["--runs", "99"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("100"));
}
