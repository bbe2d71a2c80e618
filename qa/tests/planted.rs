//! Planted bugs: every patch applies to the sources, and the fault simulation finds a dozen of the bugs.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::Path;
use std::process::Command;

use hopper_qa::planted::bugs;

/// The dozen of continuous integration: arbiter, journal, guard, cartographer, pilot, and seven of the work loops.
const DOZEN: [&str; 12] = [
    "stale-term-accepted",
    "append-not-synced",
    "veto-skipped",
    "rebuild-skips-a-record",
    "takeover-repeated",
    "loop-controls-not-polled",
    "loop-newest-command-only",
    "loop-newest-patch-only",
    "loop-orders-without-control",
    "loop-command-does-not-wake",
    "loop-recording-not-waited-for",
    "loop-other-build-obeyed",
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
}

fn planted(words: &[&str]) -> std::process::Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hopper-qa"));
    command.current_dir(root()).arg("planted").args(words).output().unwrap()
}

#[test]
fn every_patch_applies_to_the_sources_and_says_what_is_wrong() {
    let bugs = bugs(root()).unwrap();
    assert!(bugs.len() >= 43, "{} planted bugs", bugs.len());
    for bug in bugs {
        let check =
            Command::new("git").current_dir(root()).args(["apply", "--check"]).arg(&bug.path).output();
        let check = check.unwrap();
        assert!(check.status.success(), "{}: {}", bug.name, String::from_utf8_lossy(&check.stderr));
        assert!(bug.description.ends_with('.'), "{}: {}", bug.name, bug.description);
    }
}

/// P-PLANTED: found within 5,000 seeds, in a tree that is sound without them.
/// P-GUARD-PLANTED.
#[test]
fn a_dozen_planted_bugs_are_found() {
    let output = planted(&[&["--format", "json", "--only"], &DOZEN[..]].concat());
    let text = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{text}{}", String::from_utf8_lossy(&output.stderr));
    let answer: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(answer["found"], 12, "{answer}");
    for bug in answer["bugs"].as_array().unwrap() {
        assert!(bug["seed"].as_u64().unwrap() < 5000 && bug["promise"].is_string(), "{bug}");
    }
}

#[test]
fn an_unknown_bug_is_a_usage_error_that_lists_the_known_ones() {
    let output = planted(&["--only", "no-such-bug"]);
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("no-such-bug") && text.contains("torn-tail-kept"), "{text}");
}
