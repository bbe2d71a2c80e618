//! `hopper scouting` on few worlds: what must come out of them too, and what is refused.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

fn scouting(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hopper-research")).arg("scouting").args(arguments).output().unwrap()
}

/// The report as JSON, with its figures in `dir`.
fn study(arguments: &[&str], dir: &Path) -> Value {
    let out = ["--format", "json", "--out", dir.to_str().unwrap()];
    let output = scouting(&[arguments, &out].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let study: Value = serde_json::from_slice(&output.stdout).unwrap();
    for claim in study["claims"].as_array().unwrap() {
        let verdict = claim["verdict"].as_str().unwrap();
        assert!(["holds", "fails", "open", "not_to_be_had"].contains(&verdict), "{claim}");
        assert!(verdict != "not_to_be_had" || !claim["holds_if"].as_str().unwrap().is_empty(), "{claim}");
    }
    study
}

fn verdict(study: &Value, words: &str) -> String {
    let mut claims = study["claims"].as_array().unwrap().iter();
    let claim = claims.find(|claim| claim["claim"].as_str().unwrap().contains(words));
    claim.unwrap_or_else(|| panic!("no claim with {words}"))["verdict"].as_str().unwrap().to_owned()
}

fn row<'a>(study: &'a Value, arm: &str) -> &'a Value {
    study["rows"].as_array().unwrap().iter().find(|row| row["arm"] == arm).unwrap()
}

fn files(dir: &Path, names: &[&str]) {
    for name in names {
        let text = std::fs::read_to_string(dir.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(!name.ends_with(".svg") || text.starts_with("<svg") && !text.contains("NaN"), "{name}");
    }
}

/// P-SCOUT-REPORT: The Monte Carlo study of rover and helicopter judges every claim, leaves open
/// what its worlds do not decide, and reports the regret to full knowledge.
#[test]
fn the_monte_carlo_study_has_every_claim_with_a_verdict_the_regret_and_its_figures() {
    let dir = tempfile::tempdir().unwrap();
    let study = study(&["--runs", "40", "--seed", "10001"], dir.path());
    assert_eq!(study["claims"].as_array().unwrap().len(), 7);
    // Fewer worlds than the paper's decide little.
    for words in
        ["gets stuck", "the other three never do", "saves median travel time", "lowest median of all"]
    {
        assert_eq!(verdict(&study, words), "open", "{words}");
    }
    let text = std::fs::read_to_string(dir.path().join("scouting.txt")).unwrap();
    assert!(text.contains("open (too few runs): the naive rover gets stuck"), "{text}");
    let regret = |arm: &str| row(&study, arm)["regret_sol"]["value"].as_f64().unwrap();
    assert!(regret("safe_rover") > regret("information_theoretic"));
    assert_eq!(regret("clairvoyant"), 0.0);
    let compared = &study["ours_against_theirs"];
    assert!(compared["sooner"].as_u64().unwrap() + compared["later"].as_u64().unwrap() <= 40);
    files(dir.path(), &["scouting.txt", "scouting.md", "scouting.json", "fig-12.svg", "fig-13.svg"]);
}

/// P-SCOUT-SENSOR: A helicopter whose sensor errs (P21, eqs 13 to 16) saves the rover less, and one
/// that is always right is that of the paper.
#[test]
fn a_helicopter_that_errs_saves_less_and_one_that_reads_all_right_is_that_of_the_paper() {
    let dir = tempfile::tempdir().unwrap();
    let of =
        |accuracy: &[&str]| study(&[&["--runs", "40", "--seed", "10001"], accuracy].concat(), dir.path());
    let (paper, right, erring) = (of(&[]), of(&["--accuracy", "1"]), of(&["--accuracy", "0.6"]));
    assert_eq!(paper["rows"], right["rows"]);
    assert_eq!(erring["accuracy"], 0.6);
    let saving =
        |study: &Value| row(study, "information_theoretic")["mean_paired_saving"]["value"].as_f64().unwrap();
    assert!(saving(&erring) < saving(&paper), "{} against {}", saving(&erring), saving(&paper));
}

/// P-SINGLE-INFORMATION: In the single-agent study the utility function gains more information, and
/// gains it earlier, at the price of a longer path.
#[test]
fn an_agent_that_weighs_information_gains_more_of_it_earlier_and_pays_in_time() {
    let dir = tempfile::tempdir().unwrap();
    let study = study(&["single", "--runs", "100"], dir.path());
    assert_eq!(study["paths"], 8512);
    assert_eq!(verdict(&study, "gains more information"), "holds");
    assert_eq!(verdict(&study, "gains it earlier"), "holds");
    assert_ne!(verdict(&study, "without sacrificing"), "holds");
    files(dir.path(), &["scouting-single.md", "fig-5.svg", "fig-14.svg", "fig-15.svg"]);
}

/// P-LARGE-STUDY: On the stand-in for Jezero the information-theoretic helicopter opens the short
/// way, in one stage and in two.
#[test]
fn on_the_large_map_the_helicopter_opens_the_short_way() {
    for stages in ["1", "2"] {
        let dir = tempfile::tempdir().unwrap();
        let study = study(&["large", "--runs", "6", "--stages", stages], dir.path());
        let saving = &row(&study, "information_theoretic")["median_saving"];
        assert!(saving["value"].as_f64().unwrap() > 0.2, "{stages} stages: {saving}");
        assert_eq!(verdict(&study, "none of the three rovers gets stuck"), "open", "6 runs are too few");
        files(dir.path(), &["scouting-large.md", "fig-7.svg", "fig-16.svg", "fig-17.svg"]);
    }
}

#[test]
fn the_table_of_scalability_has_every_size_of_the_paper() {
    let dir = tempfile::tempdir().unwrap();
    let study = study(&["scale", "--rounds", "1"], dir.path());
    let cells: Vec<u64> =
        study["rows"].as_array().unwrap().iter().map(|row| row["cells"].as_u64().unwrap()).collect();
    assert_eq!(cells, [100, 225, 400, 2500, 10_000, 40_000, 674_041]);
    files(dir.path(), &["scouting-scale.md", "fig-18.svg", "fig-19.svg"]);
}

#[test]
fn what_a_study_cannot_do_is_refused() {
    for arguments in [
        &["--runs", "1"][..],
        &["large", "--good", "1.5"],
        &["large", "--stages", "0"],
        &["--accuracy", "1.01"],
        &["--runs", "10", "single"],
    ] {
        assert_eq!(scouting(arguments).status.code(), Some(2), "{arguments:?}");
    }
}
