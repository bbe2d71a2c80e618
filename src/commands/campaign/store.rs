//! The folder of a campaign: its plan, its rows as JSON lines and CSV, its times.
//!
//! | file | holds |
//! | --- | --- |
//! | `campaign.json` | the plan and the shard: all that decides the rows |
//! | `trials.jsonl` | one row a trial with its checksum, in order of trial; equal however they were flown |
//! | `trials.csv` | the same rows as a table, made anew on resuming |
//! | `times.csv` | wall-clock times of each trial; of that machine and that day |
//! | `run.json` | how the last run of this folder went |

use std::fs::{File, TryLockError};
use std::io::{self, BufRead, BufReader, BufWriter, ErrorKind, Seek, SeekFrom, Write};
use std::marker::PhantomData;
use std::path::{Path, PathBuf};

pub use ::campaign::Manifest;
use ::campaign::manifest::MANIFEST_BYTES_MAX;
use ::campaign::{Plan, Rows as Lines, TrialPlan, TrialRow, study};
use hopper_sim::private_file::{self, FileError};
use node::{Exit, Failure};
use serde::{Deserialize, Serialize};

/// Version of this program: the release, and after the `+` a hash of the sources that decide rows, so that
/// a changed planner is never taken for the one that flew the first half of a campaign.
pub const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "+", env!("HOPPER_SOURCES"));

const PLAN: &str = "campaign.json";
const ROWS: &str = "trials.jsonl";
const TABLE: &str = "trials.csv";
const TIMES: &str = "times.csv";
const RUN: &str = "run.json";

const TIMES_HEADINGS: &str = "trial,planning_s,episode_s\n";

/// Wall-clock times of one trial.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Times {
    /// Number of the trial in the plan.
    pub trial: u64,
    /// Time spent planning, seconds; not a number where it is not known, and in studies, which do not measure it.
    pub planning_s: f64,
    /// The whole episode, seconds.
    pub episode_s: f64,
}

impl Times {
    /// Times of a trial for which none are known.
    #[must_use]
    pub fn unknown(trial: u64) -> Self {
        Self { trial, planning_s: f64::NAN, episode_s: f64::NAN }
    }
}

/// The folder being written.
#[derive(Debug)]
pub struct Store<P = Plan> {
    plan: PhantomData<P>,
    dir: PathBuf,
    rows: BufWriter<File>,
    table: BufWriter<File>,
    times: BufWriter<File>,
    done: u64,
}

impl<P: TrialPlan> Store<P> {
    /// Opens `dir` for `manifest`: a new folder, or with `resume` one that holds the first of its rows.
    ///
    /// # Errors
    /// Exit code 2 if the folder holds another campaign, or trials and `resume` is not asked for.
    pub fn open(dir: &Path, manifest: &Manifest<P>, resume: bool) -> Result<Self, Failure> {
        std::fs::create_dir_all(dir)
            .map_err(|error| Failure::usage(format!("--out {} cannot be made: {error}", dir.display())))?;
        let rows = file(dir, ROWS)?;
        match rows.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(Failure::usage(format!("{} is in use by another campaign", dir.display())));
            }
            Err(TryLockError::Error(error)) => return Err(failed(&dir.join(ROWS), &error)),
        }
        if dir.join(PLAN).exists() {
            let held: Manifest<P> = self::manifest(dir)?;
            if held != *manifest {
                return Err(Failure::usage(difference(dir, manifest, &held)));
            }
        } else {
            write(dir, PLAN, &manifest.text())?;
        }
        let (table, times) = (file(dir, TABLE)?, file(dir, TIMES)?);
        let at = |name: &str| {
            let path = dir.join(name);
            move |error: io::Error| failed(&path, &error)
        };
        let held = whole_lines(&rows).map_err(at(ROWS))?;
        if held > 0 && !resume {
            return Err(Failure::usage(format!(
                "{} holds {held} trials: go on with --resume, or name another folder with --out",
                dir.display()
            )));
        }
        // A killed run may have written more to one file than to another.
        let done = held.min(whole_lines(&times).map_err(at(TIMES))?.saturating_sub(1));
        cut(&rows, done).map_err(at(ROWS))?;
        begin(&times, done, TIMES_HEADINGS).map_err(at(TIMES))?;
        // The table says what the rows say, and only they have checksums: it is made anew.
        begin(&table, 0, &(P::Row::headings().join(",") + "\n")).map_err(at(TABLE))?;
        let mut table = BufWriter::new(table);
        each_row(dir, manifest, |row| record(&mut table, &row).map_err(at(TABLE)))?;
        let (rows, times) = (BufWriter::new(rows), BufWriter::new(times));
        Ok(Self { plan: PhantomData, dir: dir.into(), rows, table, times, done })
    }

    /// Trials of the shard that the folder holds already.
    #[must_use]
    pub fn done(&self) -> u64 {
        self.done
    }

    /// Appends the next row.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn append(&mut self, row: &P::Row, times: &Times) -> Result<(), Failure> {
        let dir = &self.dir;
        let at = |name: &'static str| move |error: io::Error| failed(&dir.join(name), &error);
        self.rows.write_all(row.line().as_bytes()).map_err(at(ROWS))?;
        record(&mut self.table, row).map_err(at(TABLE))?;
        record(&mut self.times, times).map_err(at(TIMES))?;
        self.done += 1;
        Ok(())
    }

    /// Hands what was appended to the operating system, so that the death of this process loses nothing.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn flush(&mut self) -> Result<(), Failure> {
        for (name, file) in [(ROWS, &mut self.rows), (TABLE, &mut self.table), (TIMES, &mut self.times)] {
            file.flush().map_err(|error| failed(&self.dir.join(name), &error))?;
        }
        Ok(())
    }

    /// Writes down how the run went.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn keep(&self, run: &impl Serialize) -> Result<(), Failure> {
        write(&self.dir, RUN, &json(run)?)
    }
}

/// Whether `dir` holds all rows of `manifest`, each as it was written, and how they were flown. Nothing in it is changed.
#[must_use]
pub fn is_finished<P: TrialPlan>(dir: &Path, manifest: &Manifest<P>) -> bool {
    let due = manifest.shard.len(manifest.plan.trials());
    let lines = |name| File::open(dir.join(name)).and_then(|file| whole_lines(&file)).ok();
    let is_held = || self::manifest::<P>(dir).is_ok_and(|held| held == *manifest);
    dir.join(RUN).is_file()
        && lines(ROWS) == Some(due)
        // These two have headings.
        && [TIMES, TABLE].into_iter().all(|name| lines(name) == Some(due + 1))
        && is_held()
        && each_row(dir, manifest, |_| Ok(())).is_ok()
}

/// The manifest of `dir`.
///
/// # Errors
/// Exit code 2 if the folder is no campaign's, or its plan is not as it was written.
pub fn manifest<P: TrialPlan>(dir: &Path) -> Result<Manifest<P>, Failure> {
    let path = dir.join(PLAN);
    let text = scenario::text::read(&path, MANIFEST_BYTES_MAX).map_err(Failure::usage)?;
    Manifest::parse(&text).map_err(|error| Failure::usage(format!("{}: {error}", path.display())))
}

/// The study whose campaign `dir` holds; none if it holds another campaign, or nothing that can be read.
#[must_use]
pub fn study(dir: &Path) -> Option<String> {
    study::named_in_manifest(&scenario::text::read(&dir.join(PLAN), MANIFEST_BYTES_MAX).ok()?)
}

/// Hands each row of `dir` to `tell`, in order, checked against the plan. Returns how many there are.
///
/// # Errors
/// If a row is damaged, out of order or of another campaign.
pub fn each_row<P: TrialPlan>(
    dir: &Path,
    manifest: &Manifest<P>,
    mut tell: impl FnMut(P::Row) -> Result<(), Failure>,
) -> Result<u64, Failure> {
    let mut rows = Rows::open(dir, manifest)?;
    while let Some(row) = rows.next()? {
        tell(row)?;
    }
    Ok(rows.lines.count())
}

/// The rows of a folder, one after another.
#[derive(Debug)]
pub struct Rows<'a, P = Plan> {
    path: PathBuf,
    lines: Lines<'a, BufReader<File>, P>,
}

impl<'a, P: TrialPlan> Rows<'a, P> {
    /// Opens the rows of `dir`.
    ///
    /// # Errors
    /// If there are none.
    pub fn open(dir: &Path, manifest: &'a Manifest<P>) -> Result<Self, Failure> {
        let path = dir.join(ROWS);
        let file = File::open(&path).map_err(|error| failed(&path, &error))?;
        Ok(Self { path, lines: Lines::new(manifest, BufReader::new(file)) })
    }

    /// The next row; `None` at the end, where a torn line counts as none.
    ///
    /// # Errors
    /// If it is damaged, out of order or of another campaign.
    #[allow(clippy::should_implement_trait, reason = "it fails")]
    pub fn next(&mut self) -> Result<Option<P::Row>, Failure> {
        self.lines.next().map_err(|error| Failure::usage(format!("{}: {error}", self.path.display())))
    }
}

/// Row `trial` of `dir`.
///
/// # Errors
/// Exit code 2 if the folder does not hold it.
pub fn row<P: TrialPlan>(dir: &Path, manifest: &Manifest<P>, trial: u64) -> Result<P::Row, Failure> {
    let mut rows = Rows::open(dir, manifest)?;
    while let Some(row) = rows.next()? {
        if row.trial() == trial {
            return Ok(row);
        }
    }
    Err(Failure::usage(format!(
        "--trial: need a trial that {} holds (shard {} of 0 to {}), got {trial}",
        dir.display(),
        manifest.shard,
        manifest.plan.trials().saturating_sub(1),
    )))
}

/// The times of a folder, one after another, as far as they go.
///
/// # Errors
/// If there are none.
pub fn times(dir: &Path) -> Result<impl Iterator<Item = Times> + use<>, Failure> {
    let path = dir.join(TIMES);
    let reader = csv::Reader::from_path(&path).map_err(|error| failed(&path, &error.into()))?;
    Ok(reader.into_deserialize().map_while(Result::ok))
}

fn difference<P: TrialPlan>(dir: &Path, need: &Manifest<P>, held: &Manifest<P>) -> String {
    let fields = |manifest: &Manifest<P>| {
        let of = manifest.plan.identity();
        [
            ("shard", manifest.shard.to_string()),
            ("name", of.name.into()),
            ("seed", of.seed.to_string()),
            ("repetitions", of.repetitions.to_string()),
            ("version", of.version.into()),
            ("plan", of.hash.into()),
        ]
    };
    let mut pairs = fields(need).into_iter().zip(fields(held));
    let odd = pairs.find(|(need, held)| need != held);
    let ((field, need), (_, held)) =
        odd.unwrap_or((("cells", "this grid".into()), ("cells", "another".into())));
    format!(
        "{} holds another campaign: {field}: need {need}, got {held}; name another folder with --out",
        dir.display()
    )
}

fn file(dir: &Path, name: &str) -> Result<File, Failure> {
    private_file::open_shared(&dir.join(name)).map_err(refused)
}

fn whole_lines(file: &File) -> io::Result<u64> {
    Ok(lines_and_bytes(file, u64::MAX)?.0)
}

/// Lines up to `lines_max` that are ended, and the bytes they take.
fn lines_and_bytes(mut file: &File, lines_max: u64) -> io::Result<(u64, u64)> {
    file.seek(SeekFrom::Start(0))?;
    let mut reader = BufReader::with_capacity(1 << 16, file);
    let (mut lines, mut bytes, mut read) = (0, 0, 0);
    while lines < lines_max {
        let buffer = reader.fill_buf()?;
        if buffer.is_empty() {
            break;
        }
        let ends = buffer.iter().zip(1..).filter(|(byte, _)| **byte == b'\n').map(|(_, end)| end);
        for end in ends.take(usize::try_from(lines_max - lines).unwrap_or(usize::MAX)) {
            lines += 1;
            bytes = read + end;
        }
        let length = buffer.len();
        read += length as u64;
        reader.consume(length);
    }
    Ok((lines, bytes))
}

/// Keeps the first `lines` and leaves the file ready to be appended to.
fn cut(mut file: &File, lines: u64) -> io::Result<()> {
    let (_, bytes) = lines_and_bytes(file, lines)?;
    file.set_len(bytes)?;
    file.seek(SeekFrom::End(0))?;
    Ok(())
}

/// Keeps the headings and the first `lines` after them.
fn begin(mut file: &File, lines: u64, headings: &str) -> io::Result<()> {
    if lines > 0 {
        return cut(file, lines + 1);
    }
    cut(file, 0)?;
    file.write_all(headings.as_bytes())
}

fn record(out: &mut impl Write, value: &impl Serialize) -> io::Result<()> {
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(out);
    writer.serialize(value)?;
    writer.flush()
}

/// The cells of `row` in `trials.csv`.
///
/// # Errors
/// None in practice: numbers and text.
pub fn record_of(row: &impl Serialize) -> Result<Vec<String>, Failure> {
    let mut line = Vec::new();
    record(&mut line, row).map_err(Failure::run)?;
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(line.as_slice());
    let cells = reader.records().next().transpose().map_err(Failure::run)?.unwrap_or_default();
    Ok(cells.iter().map(String::from).collect())
}

fn json(value: &impl Serialize) -> Result<String, Failure> {
    Ok(serde_json::to_string_pretty(value).map_err(Failure::run)? + "\n")
}

/// Writes a file whole or not at all.
fn write(dir: &Path, name: &str, text: &str) -> Result<(), Failure> {
    let (path, fresh) = (dir.join(name), dir.join(format!("{name}.new")));
    private_file::write_shared(&fresh, text).map_err(refused)?;
    std::fs::rename(&fresh, &path).map_err(|error| failed(&path, &error))
}

fn refused(error: FileError) -> Failure {
    match &error {
        FileError::Io { path, source, .. } => failed(path, source),
        _ => Failure::usage(error),
    }
}

fn failed(path: &Path, error: &std::io::Error) -> Failure {
    let exit = if error.kind() == ErrorKind::NotFound { Exit::Usage } else { Exit::Failed };
    Failure::new(exit, format!("{}: {error}", path.display()))
}
