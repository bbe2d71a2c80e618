//! The output folder of a mission, readable by its owner only: scenario, provenance, journal, summary, picture.

use std::collections::{BTreeMap, VecDeque};
use std::fs::{DirBuilder, File, OpenOptions};
use std::io::{BufWriter, Write};
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use contract::{Decision, Pose, RefusalCounts, RobotId};
use hopper_sim::{History, Journal, JournalHeader};
use node::{Exit, Failure};
use perception::Observation;
use report::{Picture, Summary, SummaryBuilder};
use scenario::ResolvedScenario;
use serde::Serialize;

use super::snapshot::Snapshot;

/// The picture shows no more than this many hops, the last ones.
const ROUTE_SHOWN: usize = 2_000;

/// An output folder that holds the resolved scenario and the provenance, and belongs to one mission.
#[derive(Debug)]
pub struct OutputDir {
    dir: PathBuf,
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
    /// Opens `dir`, or a new folder under `out/` named after scenario and seed, and writes the resolved scenario and
    /// the provenance.
    ///
    /// # Errors
    /// If the folder cannot be written, or holds the journal of another mission.
    pub fn open(dir: Option<PathBuf>, world: &ResolvedScenario, seed: u64) -> Result<Self, Failure> {
        let dir = dir.unwrap_or_else(|| fresh_folder(world.brief.scenario.as_str(), seed));
        let journal_dir = dir.join("journal");
        if Journal::exists(&journal_dir) {
            // Checked before anything in the folder is overwritten.
            let history = History::open(&journal_dir).map_err(Failure::usage)?;
            JournalHeader::new(world, seed).check(history.header()).map_err(Failure::usage)?;
        }
        DirBuilder::new().recursive(true).mode(0o700).create(&dir).map_err(|error| {
            Failure::new(Exit::Usage, format!("--out {} cannot be made: {error}", dir.display()))
        })?;
        let output_dir = Self { dir };
        output_dir.write("scenario.toml", &world.resolved)?;
        let provenance = Provenance {
            version: env!("CARGO_PKG_VERSION"),
            commit: crate::COMMIT,
            processor: node::host::processor(),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            operating_system: node::host::operating_system(),
            command: std::env::args().collect(),
            scenario_hash: world.hash.iter().map(|byte| format!("{byte:02x}")).collect(),
            seed,
        };
        output_dir
            .write("provenance.json", &serde_json::to_string_pretty(&provenance).map_err(Failure::run)?)?;
        Ok(output_dir)
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

    /// A summary from the journal, if there is one: for a mission whose hopper-sim did not print its own.
    ///
    /// # Errors
    /// If the journal is damaged.
    pub fn summary_of_journal(&self) -> Result<Option<Summary>, Failure> {
        let dir = self.journal_dir();
        if !Journal::exists(&dir) {
            return Ok(None);
        }
        let history = History::open(&dir).map_err(Failure::run)?;
        let (brief, seed) = (history.header().brief, history.header().seed);
        let mut summary = SummaryBuilder::new(&brief, seed);
        let mut last = None;
        for record in history.records() {
            let record = record.map_err(Failure::run)?;
            summary.record(&record);
            last = Some(record);
        }
        let state =
            last.map(|last| last.state_after(brief.run, last.timing.committed, last.timing.committed));
        Ok(state.map(|state| summary.build(&state, &RefusalCounts::default())))
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
    pub fn illustrate(&self, world: &ResolvedScenario, summary: &mut Summary) -> Result<(), Failure> {
        let history = History::open(&self.journal_dir()).map_err(Failure::run)?;
        let run = history.header().run();
        let brief = contract::Brief { run, ..world.brief };
        // Times as in the journal, where the commit is the time at which the append was requested.
        let path = self.dir.join("timing.csv");
        let unwritten = |error: std::io::Error| {
            Failure::new(Exit::Failed, format!("{} cannot be written: {error}", path.display()))
        };
        let mut timing = BufWriter::new(create(&path).map_err(unwritten)?);
        timing.write_all(report::timing_csv_heading().as_bytes()).map_err(unwritten)?;
        let mut observation = Observation::unseen(&brief, RobotId(0));
        let height_m = world.terrain.ground(brief.start).map_or(0.0, |ground| ground.height_m);
        let mut pose = Pose { cell: brief.start, height_m };
        let mut decision = Decision(0);
        // A patrol may be longer than fits into memory or a picture.
        let mut route = VecDeque::new();
        for record in history.records() {
            let record = record.map_err(Failure::run)?;
            timing.write_all(report::timing_csv_row(&record).as_bytes()).map_err(unwritten)?;
            observation.fold(&brief, &world.terrain, pose, decision);
            (pose, decision) = (record.pose, decision.next());
            if route.len() == ROUTE_SHOWN {
                route.pop_front();
            }
            route.push_back(record);
        }
        observation.fold(&brief, &world.terrain, pose, decision);
        timing.flush().map_err(unwritten)?;
        let records = Vec::from(route);
        let planner = records.last().map_or("hold", |last| last.leader.planner.as_str());
        let snapshot = Snapshot::with(world, &brief, &records, observation.map(), planner);
        summary.coverage = Some(snapshot.map.coverage());
        let picture = Picture { outcome: summary.outcome, ..snapshot.picture(world, &brief, &records) };
        self.write("mission.svg", &picture.svg().map_err(Failure::run)?)?;
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
        create(&path).and_then(|mut file| file.write_all(text.as_bytes())).map_err(|error| {
            Failure::new(Exit::Failed, format!("{} cannot be written: {error}", path.display()))
        })
    }
}

/// A new file for its owner only, or an old one emptied.
fn create(path: &Path) -> std::io::Result<File> {
    OpenOptions::new().write(true).create(true).truncate(true).mode(0o600).open(path)
}

/// The first of `out/NAME-SEED`, `out/NAME-SEED-2`, … that does not exist.
fn fresh_folder(scenario: &str, seed: u64) -> PathBuf {
    let base = Path::new("out").join(format!("{scenario}-{seed}"));
    if !base.exists() {
        return base;
    }
    (2..)
        .map(|n| base.with_file_name(format!("{scenario}-{seed}-{n}")))
        .find(|dir| !dir.exists())
        .unwrap_or(base)
}
