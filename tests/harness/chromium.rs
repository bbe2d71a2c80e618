//! The browser that pages are tested in, and what drives it.

use std::path::{Path, PathBuf};
use std::process::Command;

/// The last release that the page was driven with.
const PLAYWRIGHT: &str = "playwright-core@1.65.1";

/// Chromium as Debian and others call it.
pub fn chromium() -> PathBuf {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let names = ["chromium", "chromium-browser", "google-chrome-stable", "google-chrome"];
    let found = std::env::split_paths(&path)
        .flat_map(|dir| names.map(|name| dir.join(name)))
        .find(|file| file.exists());
    found.unwrap_or_else(|| {
        panic!(
            "the page is tested in a real browser: need one of {names:?} on PATH, got none; as root, and with a \
             network, once: apt-get install chromium"
        )
    })
}

/// The last release of the rules of accessibility that the page was held to.
const AXE: &str = "axe-core@4.14.1";

/// The folder of playwright-core, beside which is that of axe-core; npm fetches both into the target folder the first time.
pub fn playwright() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("browser");
    let package = folder.join("node_modules/playwright-core");
    if !package.join("package.json").exists() || !package.join("../axe-core/axe.min.js").exists() {
        std::fs::create_dir_all(&folder).unwrap();
        let mut npm = Command::new("npm");
        npm.args(["install", "--no-audit", "--no-fund", "--ignore-scripts", "--prefer-offline"])
            .args(["--fetch-retries=1", "--fetch-timeout=30000", "--prefix"])
            .arg(&folder)
            .args([PLAYWRIGHT, AXE]);
        let output = npm
            .output()
            .unwrap_or_else(|error| panic!("the page's test needs node and npm on PATH, got: {error}"));
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(
            output.status.success(),
            "the page is tested through {PLAYWRIGHT}: need it in {}, or a network once for npm to put it there; got \
             {text}",
            package.display()
        );
    }
    package
}
