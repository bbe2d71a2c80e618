//! The browser that pages are tested in, and what drives it.

use std::fs::File;
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
    std::fs::create_dir_all(&folder).unwrap();
    // Tests run side by side, and one install at a time: npm would remove what another has half unpacked.
    let lock = File::create(folder.join("lock")).unwrap();
    lock.lock().unwrap();
    let (package, stamp) = (folder.join("node_modules/playwright-core"), folder.join("installed"));
    let wanted = [PLAYWRIGHT, AXE].join(" ");
    if std::fs::read_to_string(&stamp).is_ok_and(|installed| installed == wanted) {
        return package;
    }
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
        "the page is tested through {PLAYWRIGHT}: need it in {}, or a network once for npm to put it there; got {text}",
        package.display()
    );
    std::fs::write(&stamp, wanted).unwrap();
    package
}
