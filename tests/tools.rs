//! Commands that programs of their own serve: passed on to them, or refused with the way to build them.

use std::process::Command;
use std::sync::OnceLock;

use crate::harness::{hopper, program, stderr};
use hopper::tool::{TOOLS, serving};

/// Whether the program that serves a command is to be there. The programs of pictures and manual are built for their suite only,
/// since that takes longer than all others.
pub fn is_served(words: &[&str]) -> bool {
    static HAS_PICTURES: OnceLock<bool> = OnceLock::new();
    let draws = words.starts_with(&["journal", "draw"]) && words.ends_with(&["--out"]);
    let tool =
        if draws { Some("hopper-figures") } else { words.first().and_then(|command| serving(command)) };
    match tool {
        Some(tool @ ("hopper-figures" | "hopper-manual")) => {
            let has = *HAS_PICTURES.get_or_init(|| !suites::is_left_out("pictures and manual"));
            if has {
                program(tool);
            }
            has
        }
        _ => true,
    }
}

#[test]
fn a_tool_that_is_not_built_is_named_with_the_command_that_builds_it() {
    let folder = tempfile::tempdir().unwrap();
    let alone = folder.path().join("hopper");
    // By another process: a child of another test that inherited the copy's descriptor would make it busy.
    let copied = Command::new("cp").arg(program("hopper")).arg(&alone).status().unwrap();
    assert!(copied.success());
    for (tool, commands) in TOOLS {
        for command in commands {
            let output = Command::new(&alone).args([command, "--help"]).output().unwrap();
            assert_eq!(output.status.code(), Some(2), "{command}: {}", stderr(&output));
            let build = format!("cargo build --release -p {tool}");
            assert!(stderr(&output).contains(&build), "{command}: {}", stderr(&output));
            assert!(output.stdout.is_empty(), "{command}");
        }
    }
}

#[test]
fn a_tool_gets_the_arguments_and_gives_its_exit_code() {
    let output = hopper(&["known", "plan", "rocks", "--w1", "0.5"]).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(String::from_utf8_lossy(&output.stdout).starts_with("rocks ground"), "{output:?}");
    let output = hopper(&["known", "plan", "rocks", "--moon"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("Usage: hopper known plan"), "{}", stderr(&output));
    let output = hopper(&["known", "--help"]).output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert!(String::from_utf8_lossy(&output.stdout).contains("Usage: hopper known"), "{output:?}");
}

/// P-STUDY-HANDED: `hopper campaign` hands campaigns of studies to `hopper-research`, with the same
/// arguments and exit codes.
#[test]
fn a_campaign_of_a_study_is_handed_to_the_program_that_flies_it() {
    program("hopper-research");
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(
        dir.path().join("c.toml"),
        "name = \"tiny\"\nseed = 1\nrepetitions = 4\nstudy = \"p21-single\"\n",
    )
    .unwrap();
    let campaign =
        |words: &[&str]| hopper(&[&["campaign"], words].concat()).current_dir(dir.path()).output().unwrap();
    let mut merged = vec!["merge"];
    for shard in ["1/2", "2/2"] {
        let output = campaign(&["run", "c.toml", "--shard", shard, "--out", &shard[..1]]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        merged.push(&shard[..1]);
    }
    assert_eq!(campaign(&[&merged[..], &["--out", "a"]].concat()).status.code(), Some(0));
    let report = campaign(&["report", "a", "--against", "paper"]);
    let text = String::from_utf8_lossy(&report.stdout);
    assert!(text.contains("## What does not reproduce") && text.contains("cannot be had"), "{text}");
    let again = campaign(&["rerun", "a", "--trial", "2", "--out", "r", "--format", "json"]);
    let rows = std::fs::read_to_string(dir.path().join("a/trials.jsonl")).unwrap();
    assert_eq!(String::from_utf8_lossy(&again.stdout).trim_end(), rows.lines().nth(2).unwrap());
    let missing = campaign(&["rerun", "a", "--trial", "4"]);
    assert_eq!(missing.status.code(), Some(2), "{}", stderr(&missing));
}
