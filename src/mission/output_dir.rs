//! The output folder of a mission, readable by its owner only: scenario, provenance, journal, summary, picture.
//!
//! One command at a time has the folder, by a lock on the folder itself, and nothing is written into it before its
//! journal is held: a command that is refused leaves the mission that is under way there as it is.

use std::collections::{BTreeMap, VecDeque};
use std::fs::{DirBuilder, File, TryLockError};
use std::io::{BufWriter, ErrorKind, Write};
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};

use contract::{RefusalCounts, RunId};
use hopper_sim::private_file::{self, FileError};
use hopper_sim::shell::open_journal;
use hopper_sim::{Journal, JournalHeader, JournalReader};
use node::{Exit, Failure};
use report::{Picture, PictureStyle, Summary, SummaryBuilder};
use scenario::ResolvedScenario;
use serde::Serialize;

use super::robots::Robots;
use super::sensed::Sensed;
use super::snapshot::Snapshot;

/// Files that are written into the folder, beside the journal.
const FILES: [&str; 5] = ["scenario.toml", "provenance.json", "timing.csv", "mission.svg", "summary.json"];

/// The picture shows no more than this many hops, the last ones.
pub(super) const ROUTE_SHOWN: usize = 2_000;

/// An output folder that belongs to one mission, for as long as this lives.
#[derive(Debug)]
pub struct OutputDir {
    dir: PathBuf,
    /// The run of the journal in it.
    run: RunId,
    /// Whether this began the journal.
    began: bool,
    /// The files of [`FILES`] that did not exist when this took the folder.
    absent: Vec<&'static str>,
    /// Folders that this has made, the innermost first.
    made: Vec<PathBuf>,
    /// The folder, locked.
    lock: File,
}

impl Drop for OutputDir {
    fn drop(&mut self) {
        // Closing it would not do: a child that has not come to its exec yet holds the very same open folder.
        let _ = self.lock.unlock();
    }
}

/// What reproduces the results: program, machine, command line, scenario and seed.
#[derive(Serialize)]
struct Provenance<'a> {
    version: &'a str,
    commit: &'a str,
    processor: String,
    cores: usize,
    operating_system: String,
    command: Vec<String>,
    scenario_hash: String,
    seed: u64,
}

impl OutputDir {
    /// Takes `dir`, or a new folder under `out/` named after scenario and seed, and the journal in it, which is begun
    /// if there is none. Nothing else is written: see [`OutputDir::describe`].
    ///
    /// # Errors
    /// If the folder is another user's or cannot be written; if it is in use, holds the journal of another mission, or a
    /// scenario that no mission wrote, and then it is left as it was.
    pub fn open(
        dir: Option<PathBuf>,
        world: &ResolvedScenario,
        seed: u64,
    ) -> Result<(Self, Journal), Failure> {
        let (dir, made) = match dir {
            Some(dir) => {
                let made = missing_folders(&dir);
                (dir, made)
            }
            None => fresh_folder(world.brief.scenario.as_str(), seed)?,
        };
        let opened = Self::open_in(dir, &made, world, seed);
        if opened.is_err() {
            remove_empty(&made);
        }
        opened
    }

    fn open_in(
        dir: PathBuf,
        made: &[PathBuf],
        world: &ResolvedScenario,
        seed: u64,
    ) -> Result<(Self, Journal), Failure> {
        private_file::create_folder(&dir).map_err(|error| match error {
            FileError::Io { source, .. } => cannot_be_made(&dir, &source),
            other => Failure::usage(other),
        })?;
        let lock = lock(&dir)?;
        // What is written at the end only is refused at the start too.
        for name in FILES {
            private_file::check_file(&dir.join(name)).map_err(Failure::usage)?;
        }
        let journal_dir = dir.join("journal");
        let is_absent = |name: &&str| dir.join(name).symlink_metadata().is_err();
        let absent: Vec<_> = FILES.into_iter().filter(is_absent).collect();
        let began = !Journal::exists(&journal_dir);
        // A mission writes both files: a scenario alone is the user's.
        if began && !absent.contains(&"scenario.toml") && absent.contains(&"provenance.json") {
            return Err(Failure::usage(format!(
                "an output folder needs to be new or one of an earlier run, got {} with a scenario.toml of yours, which \
                 would be replaced: name another folder",
                dir.display()
            )));
        }
        let journal = open_journal(&journal_dir, world, seed, false)?;
        let run = journal.header().run();
        Ok((Self { dir, run, began, absent, made: made.to_vec(), lock }, journal))
    }

    /// The summary of the mission of `world` and `seed` that `dir` holds, if it has ended and all its files are there. Nothing
    /// in the folder is changed.
    #[must_use]
    pub fn ended(dir: &Path, world: &ResolvedScenario, seed: u64) -> Option<Summary> {
        let journal_dir = dir.join("journal");
        if !Journal::exists(&journal_dir) || !FILES.iter().all(|name| dir.join(name).is_file()) {
            return None;
        }
        let journal = JournalReader::open(&journal_dir).ok()?;
        JournalHeader::new(world, seed).check(journal.header()).ok()?;
        let text = std::fs::read_to_string(dir.join("summary.json")).ok()?;
        let summary: Summary = serde_json::from_str(&text).ok()?;
        let flown = hopper_sim::verify(&journal_dir).ok()?;
        let is_of_journal = flown.is_sound()
            && flown.outcome.is_over()
            && summary.outcome == flown.outcome
            && (summary.decisions, summary.digest) == (flown.decisions, flown.digest);
        is_of_journal.then_some(summary)
    }

    /// Removes the journal if this began it and nothing was flown, with the files that this wrote, and the folder if this made
    /// it: a mission that was refused leaves nothing behind.
    pub fn withdraw(&self) {
        let dir = self.journal_dir();
        // Held while it is removed, and let go of if it is not what was begun here.
        let Some(journal) = self.began.then(|| Journal::open(&dir, false).ok()).flatten() else { return };
        if journal.is_empty() && journal.header().run() == self.run {
            for file in [hopper_sim::journal::FILE_NAME, hopper_sim::journal::LOCK_NAME] {
                let _ = std::fs::remove_file(dir.join(file));
            }
            let _ = std::fs::remove_dir(&dir);
            for file in &self.absent {
                let _ = std::fs::remove_file(self.dir.join(file));
            }
            remove_empty(&self.made);
        }
    }

    /// Writes the resolved scenario and the provenance, while the journal is held.
    ///
    /// # Errors
    /// If the folder cannot be written.
    pub fn describe(&self, world: &ResolvedScenario, seed: u64) -> Result<(), Failure> {
        self.write("scenario.toml", &world.resolved)?;
        let provenance = Provenance {
            version: env!("CARGO_PKG_VERSION"),
            commit: crate::COMMIT,
            processor: node::host::processor(),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            operating_system: node::host::operating_system(),
            command: std::env::args_os().map(|word| word.to_string_lossy().into_owned()).collect(),
            scenario_hash: world.hash.iter().map(|byte| format!("{byte:02x}")).collect(),
            seed,
        };
        self.write("provenance.json", &serde_json::to_string_pretty(&provenance).map_err(Failure::run)?)
    }

    /// The run of its journal.
    #[must_use]
    pub fn run(&self) -> RunId {
        self.run
    }

    /// Path as given on the command line, or `out/SCENARIO-SEED`.
    #[must_use]
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// The resolved scenario, a TOML file.
    #[must_use]
    pub fn scenario(&self) -> PathBuf {
        self.dir.join("scenario.toml")
    }

    /// Folder of the journal.
    #[must_use]
    pub fn journal_dir(&self) -> PathBuf {
        self.dir.join("journal")
    }

    /// A summary from the journal: for a mission whose hopper-sim did not print its own. `None` if nothing was
    /// executed, or the journal is no longer that of this run with the `published` decisions of it.
    ///
    /// # Errors
    /// If the journal is damaged.
    pub fn summary_of_journal(&self, published: u64) -> Result<Option<Summary>, Failure> {
        let dir = self.journal_dir();
        if !Journal::exists(&dir) {
            return Ok(None);
        }
        let history = JournalReader::open(&dir).map_err(Failure::run)?;
        if history.header().run() != self.run {
            return Ok(None);
        }
        let (brief, seed) = (history.header().brief.clone(), history.header().seed);
        let mut summary = SummaryBuilder::new(&brief, seed);
        let mut robots = Robots::of_journal(&history)?;
        let mut last = None;
        let mut read = history.records();
        while let Some(record) = read.next().transpose().map_err(Failure::run)? {
            summary.record(&record);
            robots.iter_mut().for_each(|robots| robots.record(&record, read.routes()));
            last = Some(record);
        }
        let last = last.filter(|last| last.decision.next().0 >= published);
        let state =
            last.map(|last| last.state_after(brief.run, last.timing.committed, last.timing.committed));
        Ok(state.map(|state| {
            let team = robots.map(|robots| robots.team(&state));
            summary.build(&state, team.as_ref(), &RefusalCounts::default())
        }))
    }

    /// `failure` with the way to resume the mission, if there is a journal to resume from.
    #[must_use]
    pub fn with_resumption(&self, failure: Failure) -> Failure {
        if failure.exit != Exit::Failed || !Journal::exists(&self.journal_dir()) {
            return failure;
        }
        let message = format!(
            "{}: the mission is stopped; the same command with --out {} resumes it",
            failure.message,
            self.dir.display()
        );
        Failure { message, ..failure }
    }

    /// Draws the mission and writes its timing from the journal; adds coverage and artifacts to the summary.
    ///
    /// # Errors
    /// If the journal cannot be read or the picture not be written.
    pub fn illustrate(
        &self,
        world: &ResolvedScenario,
        summary: &mut Summary,
        style: PictureStyle,
    ) -> Result<(), Failure> {
        let history = JournalReader::open(&self.journal_dir()).map_err(Failure::run)?;
        let (need, got) = (self.run, history.header().run());
        if need != got {
            let message =
                format!("{} needs run {need}, got {got}: it was replaced", self.journal_dir().display());
            return Err(Failure::new(Exit::Failed, message));
        }
        let brief = contract::Brief { run: need, ..world.brief.clone() };
        let path = self.dir.join("timing.csv");
        let unwritten = |error: std::io::Error| {
            Failure::new(Exit::Failed, format!("{} cannot be written: {error}", path.display()))
        };
        let mut timing = BufWriter::new(create(&path)?);
        timing.write_all(report::timing_csv_heading().as_bytes()).map_err(unwritten)?;
        let mut sensed = Sensed::new(world, &brief, history.header().seed);
        // Visits in turn may be longer than fits into memory or a picture.
        let (mut route, mut details) = (VecDeque::new(), VecDeque::new());
        let mut read = history.records();
        while let Some(record) = read.next().transpose().map_err(Failure::run)? {
            timing.write_all(report::timing_csv_row(&record).as_bytes()).map_err(unwritten)?;
            sensed.record(&record, read.routes());
            if route.len() == ROUTE_SHOWN {
                route.pop_front();
            }
            details.extend(read.detail().map(|detail| (record.decision, detail.clone())));
            route.push_back(record);
            let first = route.front().map_or(record.decision, |first| first.decision);
            while details.front().is_some_and(|(decision, _)| *decision < first) {
                details.pop_front();
            }
        }
        timing.flush().map_err(unwritten)?;
        let (records, details) = (Vec::from(route), Vec::from(details));
        let planner = records.last().map_or("hold", |last| last.leader.planner.as_str());
        let snapshot = Snapshot::with(world, &brief, &sensed, read.routes(), planner);
        summary.coverage = Some(snapshot.map.coverage());
        let drawn = snapshot.picture(world, &brief, &records, &details);
        let picture = Picture { outcome: summary.outcome, ..drawn };
        self.write("mission.svg", &picture.svg_in(style).map_err(Failure::run)?)?;
        summary.artifacts = self.artifacts();
        Ok(())
    }

    /// Writes `summary.json`.
    ///
    /// # Errors
    /// If the folder cannot be written.
    pub fn keep(&self, summary: &Summary) -> Result<(), Failure> {
        self.write("summary.json", &serde_json::to_string_pretty(summary).map_err(Failure::run)?)
    }

    fn artifacts(&self) -> BTreeMap<String, PathBuf> {
        [
            ("picture", "mission.svg"),
            ("timing", "timing.csv"),
            ("summary", "summary.json"),
            ("scenario", "scenario.toml"),
            ("provenance", "provenance.json"),
            ("journal", "journal"),
        ]
        .map(|(name, file)| (name.to_owned(), self.dir.join(file)))
        .into()
    }

    fn write(&self, file: &str, text: &str) -> Result<(), Failure> {
        let path = self.dir.join(file);
        create(&path)?.write_all(text.as_bytes()).map_err(|error| {
            Failure::new(Exit::Failed, format!("{} cannot be written: {error}", path.display()))
        })
    }
}

/// A new file for its owner only, or an old one emptied.
fn create(path: &Path) -> Result<File, Failure> {
    private_file::create(path).map_err(|error| match error {
        FileError::Io { source, .. } => {
            Failure::new(Exit::Failed, format!("{} cannot be written: {source}", path.display()))
        }
        other => Failure::usage(other),
    })
}

/// The folder, locked against every other command.
fn lock(dir: &Path) -> Result<File, Failure> {
    let folder = File::open(dir).map_err(|error| cannot_be_made(dir, &error))?;
    match folder.try_lock() {
        Ok(()) => Ok(folder),
        Err(TryLockError::WouldBlock) => {
            let holder = private_file::lock_holder(&folder);
            let holder = holder.map_or_else(|| "another process".into(), |pid| format!("process {pid}"));
            let message =
                format!("--out {} is in use by {holder}: name another folder with --out", dir.display());
            Err(Failure::new(Exit::Peer, message))
        }
        Err(TryLockError::Error(error)) => {
            Err(Failure::new(Exit::Failed, format!("--out {} cannot be locked: {error}", dir.display())))
        }
    }
}

fn cannot_be_made(dir: &Path, error: &std::io::Error) -> Failure {
    Failure::new(Exit::Usage, format!("--out {} cannot be made: {error}", dir.display()))
}

/// The folders of a path that are not there, the innermost first.
fn missing_folders(path: &Path) -> Vec<PathBuf> {
    let is_missing = |folder: &&Path| !folder.as_os_str().is_empty() && folder.symlink_metadata().is_err();
    path.ancestors().take_while(is_missing).map(Path::to_path_buf).collect()
}

/// Removes folders, the innermost first, up to one that is not empty.
fn remove_empty(folders: &[PathBuf]) {
    // One that is not empty holds something of somebody else's.
    let _ = folders.iter().try_for_each(std::fs::remove_dir);
}

/// Makes the first of `out/NAME-SEED`, `out/NAME-SEED-2`, … that does not exist; with the folders that were made.
fn fresh_folder(scenario: &str, seed: u64) -> Result<(PathBuf, Vec<PathBuf>), Failure> {
    let out = Path::new("out");
    let mut made = missing_folders(out);
    let created = DirBuilder::new().recursive(true).mode(0o700).create(out);
    created.map_err(|error| cannot_be_made(out, &error))?;
    let mut dir = out.join(format!("{scenario}-{seed}"));
    for number in 2_u64.. {
        match DirBuilder::new().mode(0o700).create(&dir) {
            Ok(()) => break,
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {
                dir = out.join(format!("{scenario}-{seed}-{number}"));
            }
            Err(error) => return Err(cannot_be_made(&dir, &error)),
        }
    }
    made.insert(0, dir.clone());
    Ok((dir, made))
}
