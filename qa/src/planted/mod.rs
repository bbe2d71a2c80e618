//! `hopper-qa planted`: bugs planted in a copy of the sources, each of which the fault simulation must find.
//!
//! The files of `qa/planted/` list the bugs, those of a hopper's missions in `hopper.toml`, those of the missions of several
//! robots each in a file of their own. A bug says what it breaks, and changes in one or more functions some text, `old`, which
//! occurs once in its file, to another, `new`.
//! The tracked files are copied to `target/planted/tree`, with all bugs in them, and the example `seeds` of the simulation is
//! built there once. Each of its runs is told by an environment variable which bug to switch on. No bug and no switch is
//! ever in a tree that is shipped.

mod list;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use node::{Exit, Failure, Node};
use rayon::prelude::*;
use report::Format;
use serde::Serialize;

use crate::simulate::Seeds;
use list::{MISSIONS, SWITCH};

pub use list::{Bug, bugs, plant};

/// Threads of one run of the example.
const THREADS_PER_RUN: usize = 2;

/// Arguments of `hopper-qa planted`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// Seeds within which each bug must be found, the last left out.
    #[arg(long, default_value = "0..5000", value_name = "A..B")]
    seeds: Seeds,
    /// Plant these bugs only: names in the files of qa/planted.
    #[arg(long, value_name = "NAME", num_args = 1..)]
    only: Vec<String>,
    /// Form of the answer on standard output: text or json.
    #[arg(long, default_value_t)]
    format: Format,
}

/// What became of one bug.
#[derive(Clone, Debug, Serialize)]
struct Verdict {
    name: String,
    description: String,
    missions: &'static str,
    /// The first seed that breaks a promise; `None` if none does.
    seed: Option<u64>,
    promise: Option<String>,
    /// How it was broken; of a bug that was not found, what was printed instead.
    detail: String,
    /// The run, seconds.
    seconds: f64,
}

/// What is printed in JSON.
#[derive(Serialize)]
struct Answer<'a> {
    bugs: &'a [Verdict],
    found: usize,
    build_seconds: f64,
    seconds: f64,
}

/// What the example `seeds` came to.
enum Seen {
    /// A seed broke a promise: seed, promise, detail.
    Broken(u64, String, String),
    /// No seed did; what was printed.
    Unbroken(String),
}

/// Runs the command: done if every bug is found.
///
/// # Errors
/// If git or cargo is missing, a name is unknown, an edit does not fit the sources, or no bug is switched on and a promise is
/// broken.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let root = root()?;
    let all = bugs(&root)?;
    let chosen = chosen(&all, &args.only)?;
    let started = Node::now();
    let scratch = Scratch::prepare(&root, &plant(&root, &all)?)?;
    scratch.build()?;
    let build_seconds = seconds_since(started);
    let at_once =
        std::thread::available_parallelism().map_or(1, |cores| cores.get().div_ceil(THREADS_PER_RUN));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(at_once).build().map_err(Failure::run)?;
    let verdicts = pool.install(|| {
        let verdicts = chosen.par_iter().map(|bug| {
            let verdict = scratch.try_bug(bug, &args.seeds)?;
            if args.format == Format::Text {
                hopper::stdout::print(&verdict.line())?;
            }
            Ok(verdict)
        });
        verdicts.collect::<Result<Vec<_>, Failure>>()
    })?;
    scratch.try_without_bugs(&verdicts)?;
    let found = verdicts.iter().filter(|verdict| verdict.seed.is_some()).count();
    let answer = Answer { bugs: &verdicts, found, build_seconds, seconds: seconds_since(started) };
    match args.format {
        Format::Json => hopper::stdout::print_json(&answer)?,
        Format::Text => hopper::stdout::print(&answer.summary())?,
    }
    Ok(if found == verdicts.len() { Exit::Done } else { Exit::Failed })
}

/// The root of the repository around the current folder.
fn root() -> Result<PathBuf, Failure> {
    let folder = std::env::current_dir().map_err(Failure::run)?;
    let output = output(git(&folder).args(["rev-parse", "--show-toplevel"]), "git")?;
    if !output.status.success() {
        return Err(Failure::usage(format!(
            "{} is in no git repository: run this in a clone of hopper, whose tracked files are copied",
            folder.display()
        )));
    }
    Ok(PathBuf::from(String::from_utf8_lossy(&output.stdout).trim_end()))
}

/// The bugs named in `only`, or all if that is empty.
fn chosen<'a>(bugs: &'a [Bug], only: &[String]) -> Result<Vec<&'a Bug>, Failure> {
    let unknown: Vec<&str> =
        only.iter().filter(|name| bugs.iter().all(|bug| bug.name != **name)).map(String::as_str).collect();
    if !unknown.is_empty() {
        let names: Vec<&str> = bugs.iter().map(|bug| bug.name.as_str()).collect();
        return Err(Failure::usage(format!(
            "no planted bug is called {}; there are: {}",
            unknown.join(" or "),
            names.join(", ")
        )));
    }
    Ok(bugs.iter().filter(|bug| only.is_empty() || only.contains(&bug.name)).collect())
}

/// git in `folder`, whatever repository the environment names.
fn git(folder: &Path) -> Command {
    let mut git = Command::new("git");
    git.current_dir(folder);
    for variable in ["GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE", "GIT_PREFIX"] {
        git.env_remove(variable);
    }
    git
}

/// Runs `command`; `program` is how an error calls it.
fn output(command: &mut Command, program: &str) -> Result<Output, Failure> {
    command.output().map_err(|error| {
        Failure::usage(if error.kind() == ErrorKind::NotFound {
            format!("planting bugs needs {program}, which was not found: install it or add it to PATH")
        } else {
            format!("{program} cannot be run: {error}")
        })
    })
}

/// A copy of the tracked files with all bugs in it, to be built.
struct Scratch {
    /// Holds the copy, its build and the lock.
    folder: PathBuf,
    tree: PathBuf,
    /// Held until the end, so that nobody else changes this copy.
    _lock: File,
}

impl Scratch {
    /// Brings the copy of the repository at `root` up to date, with the text of `planted` in place of those files. Files that
    /// have not changed keep their time, so that cargo does not build them again.
    fn prepare(root: &Path, planted: &BTreeMap<String, String>) -> Result<Self, Failure> {
        let folder = root.join("target").join("planted");
        let tree = folder.join("tree");
        fs::create_dir_all(&tree).map_err(Failure::run)?;
        let lock = File::create(folder.join("lock")).map_err(Failure::run)?;
        lock.try_lock().map_err(|_| {
            Failure::new(Exit::Peer, format!("another run plants bugs in {}: wait for it", folder.display()))
        })?;
        let listed = output(git(root).args(["ls-files", "-z"]), "git")?;
        let listed = String::from_utf8_lossy(&listed.stdout).into_owned();
        let mut tracked = BTreeSet::new();
        for name in listed.split('\0').filter(|name| !name.is_empty()) {
            // What is deleted but still tracked is left out.
            if root.join(name).is_file() {
                let bytes = match planted.get(name) {
                    Some(text) => text.clone().into_bytes(),
                    None => fs::read(root.join(name)).map_err(Failure::run)?,
                };
                write_if_changed(&bytes, &tree.join(name))?;
                tracked.insert(tree.join(name));
            } else if let Ok(target) = fs::read_link(root.join(name)) {
                // A link to a folder.
                if !tree.join(name).is_symlink() {
                    std::os::unix::fs::symlink(target, tree.join(name)).map_err(Failure::run)?;
                }
                tracked.insert(tree.join(name));
            }
        }
        remove_others(&tree, &tracked)?;
        Ok(Self { folder, tree, _lock: lock })
    }

    /// Builds the example `seeds`.
    fn build(&self) -> Result<(), Failure> {
        let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        cargo.args(["build", "--quiet", "-p", "simulation", "--example", "seeds"]);
        // Where the tests are built its crates would take the place of theirs, since Cargo tells trees apart by nothing.
        cargo.current_dir(&self.tree).env("CARGO_TARGET_DIR", self.folder.join("target"));
        let built = output(&mut cargo, "cargo")?;
        if built.status.success() {
            return Ok(());
        }
        let errors = String::from_utf8_lossy(&built.stderr);
        let first = errors.lines().position(|line| line.starts_with("error")).unwrap_or(0);
        let lines: Vec<&str> = errors.lines().skip(first).take(12).collect();
        Err(Failure::run(format!(
            "{}: with all bugs in it, it does not build:\n{}",
            self.tree.display(),
            lines.join("\n")
        )))
    }

    /// Simulates with the bug switched on.
    fn try_bug(&self, bug: &Bug, seeds: &Seeds) -> Result<Verdict, Failure> {
        let started = Node::now();
        let (seed, promise, detail) = match self.simulate(bug.missions, Some(bug), seeds)? {
            Seen::Broken(seed, promise, detail) => (Some(seed), Some(promise), detail),
            Seen::Unbroken(detail) => (None, None, detail),
        };
        let Bug { name, description, missions, .. } = bug.clone();
        Ok(Verdict { name, description, missions, seed, promise, detail, seconds: seconds_since(started) })
    }

    /// Makes sure that it was the bugs that were found: without them the same seeds break no promise.
    fn try_without_bugs(&self, verdicts: &[Verdict]) -> Result<(), Failure> {
        for missions in MISSIONS {
            let of_these = verdicts.iter().filter(|verdict| verdict.missions == missions);
            let Some(last) = of_these.filter_map(|verdict| verdict.seed).max() else { continue };
            if let Seen::Broken(seed, promise, detail) = self.simulate(missions, None, &Seeds(0..last + 1))? {
                return Err(Failure::run(format!(
                    "seed {seed} of {missions} breaks a promise without any planted bug, so the bugs prove nothing: \
                     {promise}: {detail}"
                )));
            }
        }
        Ok(())
    }

    /// Runs the example `seeds`, with one bug switched on or none.
    fn simulate(&self, missions: &str, bug: Option<&Bug>, seeds: &Seeds) -> Result<Seen, Failure> {
        let Seeds(range) = seeds;
        let mut example = Command::new(self.folder.join("target/debug/examples/seeds"));
        example.arg(format!("{}..{}", range.start, range.end)).arg(missions).env_remove(SWITCH);
        if let Some(bug) = bug {
            example.env(SWITCH, &bug.name);
        }
        let ran = output(&mut example, "the example `seeds`")?;
        let text = String::from_utf8_lossy(&ran.stdout);
        let last = text.lines().last().unwrap_or_default();
        // What a panic says may go on in further lines.
        match (ran.status.code(), text.lines().rev().find_map(broken)) {
            // 3: no promise was broken, but something rare never came up.
            (Some(0 | 3), _) => Ok(Seen::Unbroken(last.to_owned())),
            (Some(1), Some((seed, promise, detail))) => Ok(Seen::Broken(seed, promise.into(), detail.into())),
            (code, _) => {
                let planted = bug.map_or("no bug", |bug| &bug.name);
                Err(Failure::run(format!("{planted}: the example `seeds` ended with {code:?}: {last}")))
            }
        }
    }
}

/// Seed, promise and detail of a line `seed N breaks: PROMISE: DETAIL`.
fn broken(line: &str) -> Option<(u64, &str, &str)> {
    let (seed, rest) = line.strip_prefix("seed ")?.split_once(" breaks: ")?;
    let (promise, detail) = rest.split_once(": ").unwrap_or((rest, ""));
    Some((seed.parse().ok()?, promise, detail))
}

fn write_if_changed(bytes: &[u8], to: &Path) -> Result<(), Failure> {
    if fs::read(to).is_ok_and(|held| held == bytes) {
        return Ok(());
    }
    if let Some(folder) = to.parent() {
        fs::create_dir_all(folder).map_err(Failure::run)?;
    }
    fs::write(to, bytes).map_err(Failure::run)
}

/// Removes every file below `folder` that is not in `kept`.
fn remove_others(folder: &Path, kept: &BTreeSet<PathBuf>) -> Result<(), Failure> {
    for entry in fs::read_dir(folder).map_err(Failure::run)? {
        let entry = entry.map_err(Failure::run)?;
        let path = entry.path();
        if entry.file_type().map_err(Failure::run)?.is_dir() {
            remove_others(&path, kept)?;
        } else if !kept.contains(&path) {
            fs::remove_file(&path).map_err(Failure::run)?;
        }
    }
    Ok(())
}

fn seconds_since(started: contract::MonotonicNs) -> f64 {
    Node::now().since_ns(started) as f64 / 1e9
}

impl Verdict {
    fn line(&self) -> String {
        let Self { name, description, seed, promise, detail, seconds, .. } = self;
        match (seed, promise) {
            (Some(seed), Some(promise)) => {
                format!("{name:<32} found at seed {seed:>4}, {seconds:5.1} s: {promise}\n")
            }
            _ => format!("{name:<32} NOT FOUND, {seconds:5.1} s: {description} ({detail})\n"),
        }
    }
}

impl Answer<'_> {
    fn summary(&self) -> String {
        let Self { bugs, found, build_seconds, seconds } = self;
        let mut text = format!(
            "{found} of {} planted bugs found in {seconds:.0} s, {build_seconds:.0} s of which was the build",
            bugs.len()
        );
        if let Some(last) = bugs.iter().filter(|bug| bug.seed.is_some()).max_by_key(|bug| bug.seed) {
            let _ = write!(text, "; the latest, {}, at seed {}", last.name, last.seed.unwrap_or_default());
        }
        text + "\n"
    }
}
