//! `hopper known`: the predecessor paper's findings, plans and figures by the real command.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::process::Command;

use serde_json::Value;

fn hopper(words: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hopper-research"));
    command.args(words);
    command
}

fn stdout(words: &[&str]) -> String {
    let output = hopper(words).output().unwrap();
    assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// P-KNOWN-REPORT: The report of the findings matches its stored snapshot.
#[test]
fn the_report_of_the_findings_is_as_ever() {
    let report = stdout(&["known", "findings", "--trials", "200", "--format", "markdown"]);
    insta::assert_snapshot!(report);
}

#[test]
fn findings_are_the_same_in_every_form_and_leave_their_figures() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("findings");
    let words = ["known", "findings", "--trials", "50", "--format", "json", "--out", out.to_str().unwrap()];
    let printed = stdout(&words);
    let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
    assert_eq!(printed, read("findings.json"));
    let account: Value = serde_json::from_str(&printed).unwrap();
    let (cases, claims) = (&account["findings"]["cases"], &account["findings"]["claims"]);
    assert_eq!(cases.as_array().unwrap().len(), 11 + 12 + 11 + 1);
    assert_eq!(account["executions"].as_array().unwrap().len(), 35);
    let judged: Vec<&Value> =
        claims.as_array().unwrap().iter().filter(|claim| claim["by_construction"] == false).collect();
    let holding = judged.iter().filter(|claim| claim["holds"] == true).count();
    let title = format!("Known ground: {holding} of {} claims", judged.len());
    assert!(read("findings.txt").starts_with(&title), "{title}");
    assert!(read("findings.md").starts_with(&format!("# {title}")), "{title}");
    for figure in ["hard", "heterogeneous", "sandy", "rocks", "means"] {
        assert!(read(&format!("{figure}.svg")).ends_with("</svg>\n"), "{figure}");
    }
}

/// P-NO-LINK.
#[test]
fn links_in_place_of_figures_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let precious = dir.path().join("precious");
    std::fs::write(&precious, "theirs").unwrap();
    std::os::unix::fs::symlink(&precious, dir.path().join("plan.svg")).unwrap();
    let output = hopper(&["known", "plan", "rocks", "--out", dir.path().to_str().unwrap()]).output().unwrap();
    let told = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(told.contains("plan.svg needs to be a file, got a symbolic link"), "{told}");
    assert_eq!(std::fs::read_to_string(&precious).unwrap(), "theirs");
}

/// P-KNOWN-PLAN: A plan on known ground gives path, policy, values and a picture.
#[test]
fn a_plan_tells_path_policy_and_values() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().to_str().unwrap();
    let plan: Value =
        serde_json::from_str(&stdout(&["known", "plan", "rocks", "--format", "json", "--out", out])).unwrap();
    assert_eq!(plan["arrives"], true);
    assert_eq!(plan["policy"].as_array().unwrap().len(), 14 * 14);
    assert_eq!(plan["values"].as_array().unwrap().len(), 14 * 14);
    // (9, 11): the vertical hop that the paper reports.
    assert_eq!(plan["policy"][11 * 14 + 9]["up"], "east");
    let cells = plan["path"]["cells"].as_array().unwrap();
    assert_eq!(cells.len(), plan["path"]["hops"].as_array().unwrap().len() + 1);
    assert_eq!(cells.last().unwrap(), &serde_json::json!({"x": 13, "y": 13}));
    assert!(dir.path().join("plan.svg").exists() && dir.path().join("plan.json").exists());

    let text = stdout(&["known", "plan", "heterogeneous", "--w1", "1"]);
    assert!(text.contains("no path, it leaves the map"), "{text}");
    let text = stdout(&["known", "plan", "heterogeneous", "--w1", "1", "--goal", "50"]);
    assert!(text.contains("the path arrives after 36 hops"), "{text}");
}

/// P-KNOWN-SEARCH.
#[test]
fn a_small_search_is_the_same_on_one_thread_and_on_two() {
    let words =
        ["known", "search", "--samples", "6", "--climbs", "0", "--high-climbs", "0", "--format", "json"];
    let search = |jobs: &str| stdout(&[&words[..], &["--jobs", jobs]].concat());
    let one = search("1");
    assert_eq!(one, search("2"));
    let found: Value = serde_json::from_str(&one).unwrap();
    assert_eq!(found["chosen"]["holds"], 67);
    assert!(found["judged"].as_u64().unwrap() > 50);
}

#[test]
fn bad_weights_worlds_and_folders_are_usage_errors() {
    let file = tempfile::NamedTempFile::new().unwrap();
    let taken = file.path().join("below");
    for (words, need) in [
        (vec!["known", "plan", "moon"], "experiment: need hard, heterogeneous, sandy or rocks"),
        (vec!["known", "plan", "hard", "--w1", "1.5"], "weight of safety: need 0 to 1, got 1.5"),
        (vec!["known", "plan", "hard", "--w1", "-1"], "weight of safety: need 0 to 1, got -1"),
        (vec!["known", "plan", "hard", "--goal", "nan"], "payoff of the goal: need a number above 0"),
        (vec!["known", "plan", "hard", "--out", taken.to_str().unwrap()], "cannot be made"),
        (vec!["known", "findings", "--trials", "0"], "0 is not in 1.."),
        (vec!["known", "search", "--samples", "0"], "0 is not in 1.."),
        (vec!["known"], "Usage: hopper known"),
    ] {
        let output = hopper(&words).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{words:?}: {said}");
        assert!(said.contains(need), "{words:?} needs {need:?}, got {said}");
        assert!(output.stdout.is_empty(), "{words:?}");
    }
}
