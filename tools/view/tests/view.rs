//! What `hopper-view` refuses before anything flies.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::process::{Command, Output};

fn view(words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hopper-view"));
    command.args(words).env_remove("HOPPER_INSTANCE").output().unwrap()
}

#[test]
fn a_terminal_view_without_a_terminal_is_a_usage_error() {
    let instance = format!("view-{}", std::process::id());
    let output = view(&["monitor", "--instance", &instance, "--tui"]);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("--tui needs a terminal"), "{text}");
}

#[test]
fn a_recording_over_a_file_that_is_there_is_a_usage_error() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("there.mcap");
    std::fs::write(&file, "precious").unwrap();
    let instance = format!("view-there-{}", std::process::id());
    let output = view(&["monitor", "--instance", &instance, "--record", file.to_str().unwrap()]);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "precious");
}
