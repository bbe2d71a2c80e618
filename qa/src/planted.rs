//! `hopper-qa planted`: bugs planted in a copy of the sources, each of which the fault simulation must find.
//!
//! Every file of `qa/planted/` is one bug: a patch whose first line says in a sentence what is wrong. Those whose name
//! begins with `rovers-` are to be found in missions of several rovers, those with `scouts-` in missions of a rover with
//! helicopters, those with `accompanied-` in missions of a hopper with helicopters, those with `mixed-` in missions of robots of all kinds, the
//! others in those of a hopper alone.
//! The tracked files are copied to `target/planted/tree`, where one patch at a time is applied, the example `seeds` of the
//! simulation is built and run, and the patch is reversed. No bug is ever in a tree that is shipped.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use node::{Exit, Failure, Node};
use report::Format;
use serde::Serialize;

use crate::simulate::Seeds;

/// Where the patches are, from the root of the repository.
const PATCHES: &str = "qa/planted";

/// How the example is built: with [`UNOPTIMISED`], a build after a patch takes some 3 s of one core instead of 16 s, and a
/// seed 16 ms instead of 3 ms.
const PROFILE: [(&str, &str); 3] = [
    ("CARGO_PROFILE_RELEASE_OPT_LEVEL", "1"),
    ("CARGO_PROFILE_RELEASE_DEBUG", "0"),
    ("CARGO_INCREMENTAL", "1"),
];

/// The crate that every bug rebuilds is not optimised.
const UNOPTIMISED: &str = "profile.release.package.simulation.opt-level=0";

/// Arguments of `hopper-qa planted`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// Seeds within which each bug must be found, the last left out.
    #[arg(long, default_value = "0..5000", value_name = "A..B")]
    seeds: Seeds,
    /// Plant these bugs only: names of files in qa/planted without `.patch`.
    #[arg(long, value_name = "NAME", num_args = 1..)]
    only: Vec<String>,
    /// Form of the answer on standard output: text or json.
    #[arg(long, default_value_t)]
    format: Format,
}

/// A bug to plant.
#[derive(Clone, Debug)]
pub struct Bug {
    /// The file name without `.patch`.
    pub name: String,
    /// What is wrong, in a sentence.
    pub description: String,
    /// The patch, with paths from the root of the repository.
    pub path: PathBuf,
}

/// Whose missions the example `seeds` simulates: those of one hopper, and of several robots.
const MISSIONS: [&str; 5] = [HOPPER, "rovers", "scouts", "accompanied", "mixed"];
const HOPPER: &str = "hopper";

/// In whose missions the bug of that name is to be found: its first word says so for several robots.
fn missions_of(name: &str) -> &'static str {
    let first = name.split('-').next();
    MISSIONS.into_iter().find(|missions| Some(*missions) == first).unwrap_or(HOPPER)
}

impl Bug {
    fn missions(&self) -> &'static str {
        missions_of(&self.name)
    }
}

/// What became of one bug.
#[derive(Clone, Debug, Serialize)]
struct Verdict {
    name: String,
    description: String,
    /// The first seed that breaks a promise; `None` if none does.
    seed: Option<u64>,
    promise: Option<String>,
    /// How it was broken; of a bug that was not found, what was printed instead.
    detail: String,
    /// Build and run, seconds.
    seconds: f64,
}

/// What is printed in JSON.
#[derive(Serialize)]
struct Answer<'a> {
    bugs: &'a [Verdict],
    found: usize,
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
/// If git or cargo is missing, a name is unknown, a patch does not apply, or the sources without a bug break a promise.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let root = root()?;
    let bugs = chosen(bugs(&root)?, &args.only)?;
    let started = Node::now();
    let scratch = Scratch::prepare(&root)?;
    let stale: Vec<&str> = bugs
        .iter()
        .filter(|bug| scratch.patch(&["--check"], bug).is_err())
        .map(|bug| bug.name.as_str())
        .collect();
    if !stale.is_empty() {
        let files: Vec<String> = stale.iter().map(|name| format!("{PATCHES}/{name}.patch")).collect();
        return Err(Failure::run(format!(
            "these patches no longer apply to the sources, make them anew: {}",
            files.join(", ")
        )));
    }
    let mut verdicts = Vec::new();
    for bug in &bugs {
        let verdict = scratch.try_bug(bug, &args.seeds)?;
        if args.format == Format::Text {
            hopper::stdout::print(&verdict.line())?;
        }
        verdicts.push(verdict);
    }
    scratch.try_unpatched(&verdicts)?;
    let found = verdicts.iter().filter(|verdict| verdict.seed.is_some()).count();
    let answer = Answer { bugs: &verdicts, found, seconds: seconds_since(started) };
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

/// Every bug of the repository at `root`, by name.
///
/// # Errors
/// If there is none, or a patch does not begin with a line that describes it.
pub fn bugs(root: &Path) -> Result<Vec<Bug>, Failure> {
    let folder = root.join(PATCHES);
    let entries = fs::read_dir(&folder)
        .map_err(|error| Failure::usage(format!("no planted bugs in {}: {error}", folder.display())))?;
    let mut bugs = Vec::new();
    for entry in entries {
        let path = entry.map_err(Failure::run)?.path();
        let name = path.file_stem().and_then(OsStr::to_str).map(str::to_owned);
        let Some(name) = name.filter(|_| path.extension() == Some(OsStr::new("patch"))) else { continue };
        let text = fs::read_to_string(&path).map_err(Failure::run)?;
        let description = text.lines().next().unwrap_or_default().to_owned();
        if description.is_empty() || description.starts_with("diff ") || description.starts_with("---") {
            let message = format!("{}: the first line must say in a sentence what is wrong", path.display());
            return Err(Failure::usage(message));
        }
        bugs.push(Bug { name, description, path });
    }
    bugs.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(bugs)
}

/// The bugs named in `only`, or all if that is empty.
fn chosen(bugs: Vec<Bug>, only: &[String]) -> Result<Vec<Bug>, Failure> {
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
    Ok(bugs.into_iter().filter(|bug| only.is_empty() || only.contains(&bug.name)).collect())
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

/// A copy of the tracked files, to be patched and built.
struct Scratch {
    /// Holds the copy, its build and the lock.
    folder: PathBuf,
    tree: PathBuf,
    /// Held until the end, so that nobody else patches this copy.
    _lock: File,
}

impl Scratch {
    /// Brings the copy of the repository at `root` up to date. Files that have not changed keep their time, so that
    /// cargo does not build them again.
    fn prepare(root: &Path) -> Result<Self, Failure> {
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
                copy_if_changed(&root.join(name), &tree.join(name))?;
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

    /// `git apply` with `options` in the copy.
    fn patch(&self, options: &[&str], bug: &Bug) -> Result<(), Failure> {
        let mut git = git(&self.tree);
        // The copy lies within a repository, of which it is no part.
        git.env("GIT_CEILING_DIRECTORIES", &self.folder);
        let output = output(git.arg("apply").args(options).arg(&bug.path), "git")?;
        if output.status.success() {
            return Ok(());
        }
        let reason = String::from_utf8_lossy(&output.stderr).trim_end().to_owned();
        Err(Failure::run(format!("{} does not apply: {reason}", bug.path.display())))
    }

    /// Plants the bug, simulates, and takes the bug out again.
    fn try_bug(&self, bug: &Bug, seeds: &Seeds) -> Result<Verdict, Failure> {
        let started = Node::now();
        self.patch(&[], bug)?;
        let seen = self.simulate(bug.missions(), seeds).map_err(|failure| Failure {
            message: format!("{}: {}", bug.path.display(), failure.message),
            ..failure
        });
        self.patch(&["--reverse"], bug)?;
        let (seed, promise, detail) = match seen? {
            Seen::Broken(seed, promise, detail) => (Some(seed), Some(promise), detail),
            Seen::Unbroken(detail) => (None, None, detail),
        };
        let (name, description) = (bug.name.clone(), bug.description.clone());
        Ok(Verdict { name, description, seed, promise, detail, seconds: seconds_since(started) })
    }

    /// Makes sure that it was the bugs that were found: without them the same seeds break no promise.
    fn try_unpatched(&self, verdicts: &[Verdict]) -> Result<(), Failure> {
        for missions in MISSIONS {
            let of_these = verdicts.iter().filter(|verdict| missions_of(&verdict.name) == missions);
            let Some(last) = of_these.filter_map(|verdict| verdict.seed).max() else { continue };
            if let Seen::Broken(seed, promise, detail) = self.simulate(missions, &Seeds(0..last + 1))? {
                return Err(Failure::run(format!(
                    "seed {seed} of {missions} breaks a promise without any planted bug, so the bugs prove nothing: \
                     {promise}: {detail}"
                )));
            }
        }
        Ok(())
    }

    /// Builds the example `seeds` and runs it.
    fn simulate(&self, missions: &str, seeds: &Seeds) -> Result<Seen, Failure> {
        let target = self.folder.join("target");
        let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        cargo.args(["build", "--quiet", "--release", "-p", "simulation", "--example", "seeds"]);
        cargo.args(["--config", UNOPTIMISED]).envs(PROFILE);
        cargo.current_dir(&self.tree).env("CARGO_TARGET_DIR", &target);
        let built = output(&mut cargo, "cargo")?;
        if !built.status.success() {
            let errors = String::from_utf8_lossy(&built.stderr);
            let first = errors.lines().position(|line| line.starts_with("error")).unwrap_or(0);
            let lines: Vec<&str> = errors.lines().skip(first).take(12).collect();
            return Err(Failure::run(format!("it does not build:\n{}", lines.join("\n"))));
        }
        let Seeds(range) = seeds;
        let mut example = Command::new(target.join("release").join("examples").join("seeds"));
        example.arg(format!("{}..{}", range.start, range.end)).arg(missions);
        let ran = output(&mut example, "the example `seeds`")?;
        let text = String::from_utf8_lossy(&ran.stdout);
        let last = text.lines().last().unwrap_or_default();
        match (ran.status.code(), broken(last)) {
            // 3: no promise was broken, but something rare never came up.
            (Some(0 | 3), _) => Ok(Seen::Unbroken(last.to_owned())),
            (Some(1), Some((seed, promise, detail))) => Ok(Seen::Broken(seed, promise.into(), detail.into())),
            (code, _) => Err(Failure::run(format!("the example `seeds` ended with {code:?}: {last}"))),
        }
    }
}

/// Seed, promise and detail of a line `seed N breaks: PROMISE: DETAIL`.
fn broken(line: &str) -> Option<(u64, &str, &str)> {
    let (seed, rest) = line.strip_prefix("seed ")?.split_once(" breaks: ")?;
    let (promise, detail) = rest.split_once(": ").unwrap_or((rest, ""));
    Some((seed.parse().ok()?, promise, detail))
}

fn copy_if_changed(from: &Path, to: &Path) -> Result<(), Failure> {
    let bytes = fs::read(from).map_err(Failure::run)?;
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
        let Self { name, description, seed, promise, detail, seconds } = self;
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
        let Self { bugs, found, seconds } = self;
        let mut text = format!("{found} of {} planted bugs found in {seconds:.0} s", bugs.len());
        if let Some(last) = bugs.iter().filter(|bug| bug.seed.is_some()).max_by_key(|bug| bug.seed) {
            let _ = write!(text, "; the latest, {}, at seed {}", last.name, last.seed.unwrap_or_default());
        }
        text + "\n"
    }
}
