//! The commands of the tutorial.

use std::process::Command;

use crate::harness::{self, Mission, stderr};
use crate::tools::is_served;

/// P-TUTORIAL: Every command of docs/tutorial.md does what the page says, in order.
#[test]
fn every_command_of_the_tutorial_runs() {
    let text = include_str!("../docs/tutorial.md");
    let mut blocks: Vec<&str> =
        text.split("```sh\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect();
    assert!(blocks.len() >= 5, "{} blocks", blocks.len());
    let is_command_served = |line: &str| {
        line.strip_prefix("hopper ").is_none_or(|rest| is_served(&rest.split(' ').collect::<Vec<_>>()))
    };
    blocks.retain(|block| block.lines().all(is_command_served));
    let mission = Mission::new("tutorial");
    let tools = mission.path("tools");
    std::fs::create_dir(&tools).unwrap();
    std::os::unix::fs::symlink(harness::program("hopper"), tools.join("hopper")).unwrap();
    harness::program("hopper-recordings");
    // Nothing is built again: `cargo build --release` does nothing, `cargo run --release` only runs.
    let cargo = "#!/bin/sh\n[ \"$*\" != 'build --release' ] || exit 0\n[ \"$1 $2\" = 'run --release' ] || exit 9\n\
                 shift 2\n[ \"$1\" != -- ] || shift\nexec hopper \"$@\"\n";
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
