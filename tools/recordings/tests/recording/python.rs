//! Python with what reads recordings, in virtual environments.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use super::harness::{json, stderr};

/// The interpreter of the virtual environment NAME in the target folder, with what `requirements-NAME.txt` says; else why it
/// could not be installed within `limit`.
pub fn environment(name: &str, limit: Duration) -> Result<PathBuf, String> {
    let requirements = folder().join(format!("requirements-{name}.txt"));
    let venv = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-venv"));
    let (interpreter, stamp) = (venv.join("bin/python"), venv.join("requirements.txt"));
    let wanted = std::fs::read_to_string(&requirements).unwrap();
    if std::fs::read_to_string(&stamp).is_ok_and(|installed| installed == wanted) {
        return Ok(interpreter);
    }
    let log = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-venv.log"));
    let end = Instant::now() + limit;
    let mut make = Command::new("python3");
    run(make.args(["-m", "venv", "--clear"]).arg(&venv), &log, end)?;
    let mut install = Command::new(&interpreter);
    install.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-input"]);
    // Wheels alone: pip runs nothing that could outlive it.
    install.args(["--only-binary", ":all:", "--retries", "1", "--timeout", "20", "-r"]).arg(&requirements);
    run(&mut install, &log, end)?;
    std::fs::write(&stamp, wanted).unwrap();
    Ok(interpreter)
}

/// Runs the command, at the latest until `end`.
fn run(command: &mut Command, log: &Path, end: Instant) -> Result<(), String> {
    let file = std::fs::File::create(log).unwrap();
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(file);
    let mut child = command.spawn().map_err(|error| format!("{command:?}: {error}"))?;
    loop {
        match child.try_wait().unwrap() {
            Some(status) if status.success() => return Ok(()),
            Some(status) => {
                let text = std::fs::read_to_string(log).unwrap_or_default();
                return Err(format!("{command:?}: {status}: {}", text.trim()));
            }
            None if Instant::now() >= end => {
                child.kill().unwrap();
                child.wait().unwrap();
                return Err(format!("{command:?}: not done in time"));
            }
            None => std::thread::sleep(Duration::from_millis(100)),
        }
    }
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/recording")
}

/// What a script of this folder prints of a recording.
pub fn read(python: &Path, script: &str, recording: &Path) -> Value {
    let output = Command::new(python).arg(folder().join(script)).arg(recording).output().unwrap();
    assert!(output.status.success(), "{script} reads no recording: {}", stderr(&output));
    json(&output)
}
