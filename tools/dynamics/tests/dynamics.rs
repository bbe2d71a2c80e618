//! `hopper motion derive` and `hopper validate`, as programs see them.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::process::Command;

use serde_json::Value;

fn hopper(words: &[&str]) -> std::process::Output {
    Command::new(env!("CARGO_BIN_EXE_hopper-dynamics")).args(words).output().unwrap()
}

fn json(words: &[&str]) -> Value {
    let output = hopper(words);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// P-DERIVE: The landings of every class of soil and slope sum to 1, each within its interval, and the same seed gives the same table in
/// every form.
#[test]
fn landings_of_every_class_sum_to_one_and_files_hold_the_same_table() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("tables");
    let words = ["motion", "derive", "--preset", "mars", "--hops", "300", "--format", "json"];
    let table = json(&[&words[..], &["--out", out.to_str().unwrap()]].concat());
    let classes = table["classes"].as_array().unwrap();
    assert_eq!(classes.len(), 2 * 25 * 25);
    let number = |value: &Value| value.as_f64().unwrap();
    for class in classes {
        let landings = class["landings"].as_array().unwrap();
        assert!(landings.len() <= 12, "{class}");
        let sum: f64 = landings.iter().map(|landing| number(&landing["probability"])).sum();
        let all = sum + number(&class["far"]["probability"]);
        assert!((all - 1.0).abs() < 1e-9 || class["rolls_away"] == true, "{class}");
        for landing in landings {
            let [low, probability, high] = ["low", "probability", "high"].map(|name| number(&landing[name]));
            assert!(0.0 <= low && low <= probability && probability <= high && high <= 1.0, "{class}");
        }
    }
    assert_eq!(json(&words), table);
    let written: toml::Table =
        toml::from_str(&std::fs::read_to_string(out.join("table.toml")).unwrap()).unwrap();
    assert_eq!(written["classes"].as_array().unwrap().len(), classes.len());
    let csv = std::fs::read_to_string(out.join("table.csv")).unwrap();
    assert!(csv.lines().count() > classes.len() && csv.starts_with("soil,along_deg,across_deg,"));
    assert!(std::fs::read_to_string(out.join("figure.svg")).unwrap().contains("physics, hard"));
}

/// P-VALIDATE: The validation has at least 15 rows of at least 8 sources; every closed form holds, and what does not come out is shown.
#[test]
fn every_closed_form_holds_and_misses_are_shown() {
    let validation = json(&["validate", "--format", "json"]);
    let rows = validation["rows"].as_array().unwrap();
    let sources: std::collections::BTreeSet<&str> =
        rows.iter().map(|row| row["source"].as_str().unwrap()).collect();
    assert!(rows.len() >= 15 && sources.len() >= 8, "{} rows of {sources:?}", rows.len());
    for row in rows {
        assert!(["holds", "fails", "open"].contains(&row["verdict"].as_str().unwrap()), "{row}");
        assert!(row["source"] != "closed form" || row["verdict"] == "holds", "{row}");
    }
    assert!(rows.iter().any(|row| row["verdict"] == "fails"), "a model has limits");
}

#[test]
fn a_preset_that_is_none_is_a_usage_error() {
    let output = hopper(&["motion", "derive", "--preset", "marz"]);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(error.contains("moon, mars, phobos, ryugu, bennu") && error.contains("mars"), "{error}");
}
