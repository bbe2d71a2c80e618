//! What the command line says of itself, and whether it is so.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod harness;

use std::path::Path;
use std::process::Command;

use harness::{Mission, hopper, stderr};

/// Standard output of `hopper WORDS`, which must end well.
fn told(words: &[&str]) -> String {
    let output = hopper(words).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{words:?}: {}", stderr(&output));
    String::from_utf8(output.stdout).unwrap()
}

/// The commands that `hopper --help` lists.
fn commands() -> Vec<String> {
    let help = told(&["--help"]);
    let list = help.split("Commands:\n").nth(1).unwrap().split("\n\n").next().unwrap();
    let names = list.lines().filter_map(|line| line.strip_prefix("  ")?.split_whitespace().next());
    let names: Vec<String> = names.filter(|name| *name != "help").map(Into::into).collect();
    assert!(names.len() > 10, "{names:?}");
    names
}

/// P-HELP: every command's help has examples, each of that very command.
#[test]
fn every_command_is_helped_with_examples() {
    for command in commands() {
        let help = told(&[&command, "--help"]);
        let examples =
            help.split("Examples:\n").nth(1).unwrap_or_else(|| panic!("{command} has no examples"));
        assert!(examples.contains(&format!("hopper {command}")), "{command}: {examples}");
    }
}

/// P-MANUAL: completions and manual pages know every command.
#[test]
fn completions_and_manual_pages_know_every_command() {
    let page = told(&["man"]);
    let dir = tempfile::tempdir().unwrap();
    told(&["man", "--out", &dir.path().to_string_lossy()]);
    /// What a shell's completions say of a command.
    type Form = fn(&str) -> String;
    let forms: [(&str, Form); 5] = [
        ("bash", |command| format!("hopper,{command})\n")),
        ("zsh", |command| format!("\n'{command}:")),
        ("fish", |command| format!("-n \"__fish_hopper_needs_command\" -f -a \"{command}\" ")),
        ("elvish", |command| format!("&'hopper;{command}'= {{")),
        ("powershell", |command| format!("'hopper;{command}' {{")),
    ];
    for (shell, form) in forms {
        let text = told(&["completions", shell]);
        for command in commands() {
            assert!(text.contains(&form(&command)), "{shell} does not know {command}");
        }
        assert!(!text.contains(&form("no-such")), "{shell} knows anything");
    }
    for command in commands() {
        // A hyphen of a manual page is written as \-.
        assert!(page.contains(&format!("\nhopper\\-{command}(1)\n")), "the manual does not know {command}");
        let own = std::fs::read_to_string(dir.path().join(format!("hopper-{command}.1"))).unwrap();
        assert!(own.contains(&format!("\n.TH hopper-{command} 1")), "{command}: {own}");
    }
}

/// P-TUTORIAL: every command of the tutorial does what it says, in order.
#[test]
fn every_command_of_the_tutorial_runs() {
    let text = include_str!("../docs/tutorial.md");
    let blocks: Vec<&str> =
        text.split("```sh\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect();
    assert!(blocks.len() >= 5, "{} blocks", blocks.len());
    let mission = Mission::new("tutorial");
    let tools = mission.path("tools");
    std::fs::create_dir(&tools).unwrap();
    let binary = Path::new(env!("CARGO_BIN_EXE_hopper"));
    std::os::unix::fs::symlink(binary, tools.join("hopper")).unwrap();
    // What is built already is not built again.
    let cargo = "#!/bin/sh\n[ \"$1 $2\" = 'run --release' ] || exit 9\nshift 2\n[ \"$1\" != -- ] || shift\nexec hopper \"$@\"\n";
    std::fs::write(tools.join("cargo"), cargo).unwrap();
    std::fs::set_permissions(tools.join("cargo"), std::os::unix::fs::PermissionsExt::from_mode(0o755))
        .unwrap();
    let path = format!("{}:{}", tools.display(), std::env::var("PATH").unwrap());
    let script =
        format!("set -euo pipefail\ntrap 'kill $(jobs -p) 2>/dev/null || true' EXIT\n{}", blocks.join("\n"));
    // A planner that comes after the mission waits for the next, and the tutorial for it: no longer than this.
    let mut bash = Command::new("timeout");
    bash.args(["--kill-after=10", "120", "bash", "-c", &script])
        .current_dir(mission.path(""))
        .env("PATH", path)
        .env("HOPPER_INSTANCE", &mission.name);
    let output = bash.output().unwrap();
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_ne!(output.status.code(), Some(124), "not over in 120 s: {told}\n{}", stderr(&output));
    assert!(output.status.success(), "{told}\n{}", stderr(&output));
    for promised in ["out/hard-1/mission.svg", "out/swap/hops.journal", "out/again/summary.json"] {
        assert!(mission.path(promised).exists(), "{promised} is missing: {told}\n{}", stderr(&output));
    }
    // By the summary of the mission with the swap, and by that of its repetition.
    let both = "scenario hard, planner mdp then greedy, profile hopper, seed 7";
    assert_eq!(told.matches(both).count(), 2, "{told}");
    assert!(stderr(&output).contains("page at http://127.0.0.1:"), "{}", stderr(&output));
    assert!(stderr(&output).contains("is repeated, digest"), "{}", stderr(&output));
}
