//! Limits of the operating system on a process: too little is refused in words.

use std::process::{Command, Output};

use crate::harness::{self, Mission, json, lockstep, stderr};

/// Runs `script` by a shell, with the program in `$HOPPER`.
fn shell(mission: &Mission, script: &str) -> Output {
    let mut command = Command::new("sh");
    command.args(["-c", script]).current_dir(mission.path(""));
    command.env("HOPPER", harness::program("hopper")).env_remove("HOPPER_INSTANCE").output().unwrap()
}

/// P-STACK: A stack that is too small for a mission is refused at the start, with the sizes needed
/// and available.
#[test]
fn a_stack_that_is_too_small_is_refused_with_the_sizes() {
    let mission = Mission::new("stack");
    let fly = format!("$HOPPER run --instance {} --seed 82 --format json --out out", mission.name);
    for command in [&fly, "$HOPPER run --lockstep --out out", "$HOPPER sim --journal j"] {
        let output = shell(&mission, &format!("ulimit -s 512; exec {command}"));
        assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
        let told = "the stack needs at least 1048576 bytes, got 524288: raise the limit with `ulimit -s`";
        assert!(stderr(&output).contains(told), "{}", stderr(&output));
    }
    let output = shell(&mission, &format!("ulimit -s 1024; exec {fly}"));
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert_eq!(json(&output)["digest"], lockstep(&["--seed", "82"])["digest"]);
}

/// P-SPAWN. With too little address space for another thread or process, the error says what could
/// not be started.
#[test]
fn a_process_or_thread_that_cannot_be_started_is_an_error_and_no_panic() {
    let mission = Mission::new("spawn");
    for kilobytes in [22_000, 26_000, 32_000] {
        let script = format!(
            "ulimit -v {kilobytes}; exec $HOPPER run --instance {} --patience 0s --out out-{kilobytes}",
            mission.name
        );
        let told = stderr(&shell(&mission, &script));
        assert!(!told.contains("panicked"), "{kilobytes} kB: {told}");
    }
}
