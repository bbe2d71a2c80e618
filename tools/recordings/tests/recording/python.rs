//! Python with what reads recordings, in a virtual environment.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use serde_json::Value;

use super::harness::{json, stderr};

/// The interpreter of a virtual environment in the target folder, with what `requirements.txt` says. The tests of this
/// package share it.
fn python() -> &'static Path {
    static PYTHON: OnceLock<PathBuf> = OnceLock::new();
    PYTHON.get_or_init(|| {
        let requirements = folder().join("requirements.txt");
        let venv = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mcap-venv");
        let (interpreter, stamp) = (venv.join("bin/python"), venv.join("requirements.txt"));
        let wanted = std::fs::read_to_string(&requirements).unwrap();
        if std::fs::read_to_string(&stamp).is_ok_and(|installed| installed == wanted) {
            return interpreter;
        }
        let does = |command: &mut Command, what: &str| {
            let output =
                command.output().unwrap_or_else(|error| panic!("{what} needs python3 with venv: {error}"));
            assert!(
                output.status.success(),
                "{what} failed; this test reads recordings with mcap and rerun-sdk and needs PyPI once:\n{}",
                stderr(&output)
            );
        };
        let mut make = Command::new("python3");
        does(make.args(["-m", "venv", "--clear"]).arg(&venv), "making a virtual environment");
        let pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r"];
        let mut install = Command::new(&interpreter);
        does(install.args(pip).arg(&requirements), "installing mcap and rerun-sdk from PyPI");
        std::fs::write(&stamp, wanted).unwrap();
        interpreter
    })
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/recording")
}

/// What a script of this folder prints of a recording.
pub fn read(script: &str, recording: &Path) -> Value {
    let output = Command::new(python()).arg(folder().join(script)).arg(recording).output().unwrap();
    assert!(output.status.success(), "{script} reads no recording: {}", stderr(&output));
    json(&output)
}
