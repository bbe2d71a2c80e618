//! Builds the folder.

use std::fmt;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use flate2::Compression;
use flate2::write::GzEncoder;
use process::{Exit, Failure};

/// What the module is compiled for.
pub const TARGET: &str = "wasm32-unknown-unknown";

/// Most bytes of all files together as a server sends them, gzip.
pub const COMPRESSED_BYTES_MAX: u64 = 2_000_000;

/// Name of the module in the folder.
const MODULE: &str = "hopper.wasm";

/// What the page may load, which no server tells it here. It stands before all that is loaded.
const POLICY: &str = "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'self' \
                      'wasm-unsafe-eval'; worker-src 'self'; connect-src 'self'; style-src 'self'; img-src 'self' \
                      data:; base-uri 'none'; form-action 'none'\">";

/// The look of what the page has beyond that of the monitor.
const STYLE: &str = "<link rel=\"stylesheet\" href=\"browser.css\">";

/// A built folder.
#[derive(Clone, Copy, Debug)]
pub struct Site {
    /// Number of files.
    pub files: usize,
    /// Bytes of all files.
    pub bytes: u64,
    /// Bytes of all files, each packed with gzip.
    pub compressed_bytes: u64,
}

impl fmt::Display for Site {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { files, bytes, compressed_bytes } = self;
        write!(f, "{files} files, {bytes} bytes, {compressed_bytes} compressed")
    }
}

/// The workspace whose sources are built.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Whether this Rust compiles for [`TARGET`].
#[must_use]
pub fn has_target() -> bool {
    let mut rustc = Command::new("rustc");
    let output = rustc.current_dir(root()).args(["--print", "target-libdir", "--target", TARGET]).output();
    output.is_ok_and(|output| Path::new(String::from_utf8_lossy(&output.stdout).trim()).is_dir())
}

/// Builds the folder `out`, in place of what an earlier build put there.
///
/// # Errors
/// Exit code 2 if the target is not installed or `out` holds something else; 1 if it cannot be built or written.
pub fn build(out: &Path) -> Result<Site, Failure> {
    if !has_target() {
        let message = format!("the module needs Rust's target {TARGET}, once: rustup target add {TARGET}");
        return Err(Failure::usage(message));
    }
    let is_foreign =
        out.read_dir().is_ok_and(|mut files| files.next().is_some()) && !out.join(MODULE).exists();
    if is_foreign || out.is_file() {
        let message = format!("{} needs to be a new folder or one built before", out.display());
        return Err(Failure::usage(message));
    }
    let module = module()?;
    let unwritten = |error: std::io::Error| Failure::run(format!("{}: {error}", out.display()));
    fs::create_dir_all(out).map_err(unwritten)?;
    let mut files = page().map_err(unwritten)?;
    files.push((MODULE.into(), fs::read(&module).map_err(unwritten)?));
    let mut site = Site { files: files.len(), bytes: 0, compressed_bytes: 0 };
    for (name, contents) in files {
        let mut packed = GzEncoder::new(Vec::new(), Compression::best());
        packed.write_all(&contents).map_err(unwritten)?;
        site.bytes += contents.len() as u64;
        site.compressed_bytes += packed.finish().map_err(unwritten)?.len() as u64;
        fs::write(out.join(name), contents).map_err(unwritten)?;
    }
    Ok(site)
}

/// Compiles the module; where it is.
fn module() -> Result<PathBuf, Failure> {
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from);
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let status = Command::new(cargo)
        .current_dir(root())
        .args(["build", "--release", "--locked", "--package", "browser", "--lib", "--target", TARGET])
        .arg("--target-dir")
        .arg(&target)
        .status()
        .map_err(|error| Failure::run(format!("cargo cannot be started: {error}")))?;
    if !status.success() {
        return Err(Failure::new(Exit::Failed, "the module cannot be compiled: cargo says why above"));
    }
    Ok(target.join(TARGET).join("release/browser.wasm"))
}

/// Names and contents of the page's files.
fn page() -> std::io::Result<Vec<(String, Vec<u8>)>> {
    let mut files = Vec::new();
    let mut names = std::collections::BTreeSet::new();
    // The first has its way: what stands in for the server comes before the page of the server.
    for folder in ["crates/browser/page", "monitor/src/web/page"] {
        for entry in fs::read_dir(root().join(folder))? {
            let entry = entry?;
            let name = entry.file_name().to_string_lossy().into_owned();
            if !names.insert(name.clone()) {
                continue;
            }
            let mut contents = fs::read(entry.path())?;
            if name == "index.html" {
                let text = String::from_utf8_lossy(&contents);
                let text = text.replacen("<head>", &format!("<head>\n{POLICY}"), 1);
                contents = text.replacen("</head>", &format!("{STYLE}\n</head>"), 1).into_bytes();
            }
            files.push((name, contents));
        }
    }
    Ok(files)
}
