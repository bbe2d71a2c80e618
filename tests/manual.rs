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
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let text = told(&["completions", shell]);
        for command in commands() {
            assert!(text.contains(&command), "{shell} does not know {command}");
        }
    }
    for command in commands() {
        assert!(page.contains(&command), "the manual does not know {command}");
        assert!(dir.path().join(format!("hopper-{command}.1")).exists(), "{command} has no page");
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
    let mut bash = Command::new("bash");
    bash.args(["-c", &script])
        .current_dir(mission.path(""))
        .env("PATH", path)
        .env("HOPPER_INSTANCE", &mission.name);
    let output = bash.output().unwrap();
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{told}\n{}", stderr(&output));
    for promised in ["out/hard-1/mission.svg", "out/swap/hops.journal", "out/again/summary.json"] {
        assert!(mission.path(promised).exists(), "{promised} is missing: {told}\n{}", stderr(&output));
    }
    assert!(stderr(&output).contains("page at http://127.0.0.1:"), "{}", stderr(&output));
    assert!(stderr(&output).contains("is repeated, digest"), "{}", stderr(&output));
}
