//! `hopper campaign report`: statistics of the rows of a folder.

use std::fmt;
use std::path::{Path, PathBuf};

use ::campaign::Report;
use node::{Exit, Failure};
use p23::{Comparison, PaperReport, ReadingScores};
use serde::Serialize;

use super::regret::bounds;
use super::store::{self, Manifest};
use crate::files::{write_into, write_picture};
use crate::stdout::print;

/// Arguments of `hopper campaign report`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// Folder of a campaign, finished or not.
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// Compare with published numbers; paper: that of the campaign's cells, Sakamoto & Kunii 2023, or of its study.
    #[arg(long, value_name = "WHAT")]
    pub against: Option<Against>,
    /// Compare every cell with the cell of the same scenario, planner and weights in another campaign's folder.
    /// Prints a table and a verdict on each cell of the MDP.
    #[arg(long, value_name = "DIR", conflicts_with = "against")]
    pub beside: Option<PathBuf>,
    /// Score the readings of the paper's open points that the campaign compares by how likely they make the paper's
    /// numbers.
    #[arg(long, conflicts_with_all = ["against", "beside"])]
    pub readings: bool,
    /// Exit with code 3 if a verdict is not accepted.
    #[arg(long, requires = "beside")]
    accept: bool,
    /// Format of the report on standard output.
    #[arg(long, default_value_t)]
    pub format: Form,
    /// Also write the report in all formats into this folder; of a study, with its figures.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["beside", "readings"], value_parser = node::output_path())]
    pub out: Option<PathBuf>,
    /// Also write the picture of --format svg to this file: SVG, or PDF if it ends in .pdf; an old one is replaced.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["beside", "readings"], value_parser = node::output_file_of(&["svg", "pdf"]))]
    pub picture: Option<PathBuf>,
}

/// Published numbers to compare with.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Against {
    /// The paper whose experiment the campaign repeats.
    Paper,
}

/// Format of a report.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Form {
    /// Markdown tables.
    #[default]
    #[value(alias = "markdown")]
    Md,
    /// One record a cell; of a study against the paper, one a claim.
    Csv,
    /// One JSON object.
    Json,
    /// A picture: the distribution of steps in each cell; of a study, its first figure.
    Svg,
}

impl fmt::Display for Form {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Form::Md => "md",
            Form::Csv => "csv",
            Form::Json => "json",
            Form::Svg => "svg",
        })
    }
}

/// Prints the report.
///
/// # Errors
/// Exit code 2 if a folder holds no campaign, a row is damaged, or the format does not go with the other flags.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let (manifest, report) = fold(&args.dir)?;
    let results = report.results(&bounds(&manifest.plan));
    if let Some(dir) = &args.beside {
        let (_, other) = fold(dir)?;
        let others = other.results(&[]);
        let comparison = Comparison::new(&results, &others);
        print(&match args.format {
            Form::Md => comparison.markdown(),
            Form::Json => serde_json::to_string(&comparison).map_err(Failure::run)? + "\n",
            Form::Csv | Form::Svg => {
                return Err(Failure::usage(format!(
                    "--beside needs --format md or json, got {}",
                    args.format
                )));
            }
        })?;
        return Ok(if args.accept && !comparison.accepted() { Exit::Threshold } else { Exit::Done });
    }
    if args.readings {
        let need = "--readings needs a campaign with [[readings]] of scenarios, planners and weights that the paper has";
        let scores = ReadingScores::new(&results).ok_or_else(|| Failure::usage(need))?;
        print(&match args.format {
            Form::Md => scores.markdown(),
            Form::Json => serde_json::to_string(&scores).map_err(Failure::run)? + "\n",
            Form::Csv | Form::Svg => {
                let got = args.format;
                return Err(Failure::usage(format!("--readings needs --format md or json, got {got}")));
            }
        })?;
        return Ok(Exit::Done);
    }
    let findings = match args.against {
        Some(Against::Paper) => PaperReport::against_paper(&results),
        None => PaperReport::alone(&results),
    };
    let text = |form: Form| {
        Ok::<_, Failure>(match form {
            Form::Md => findings.markdown() + &Speed::of(&args.dir, &manifest).markdown(),
            Form::Json => serde_json::to_string(&findings).map_err(Failure::run)? + "\n",
            Form::Svg => report.distribution_svg(p23::tables::STEPS_AXIS),
            Form::Csv => csv_text(findings.records())?,
        })
    };
    if let Some(dir) = &args.out {
        let file = |form: Form| Ok((format!("report.{form}"), text(form)?));
        let forms = [Form::Md, Form::Csv, Form::Json, Form::Svg];
        write_into(dir, forms.into_iter().map(file).collect::<Result<Vec<(String, String)>, Failure>>()?)?;
    }
    if let Some(file) = &args.picture {
        write_picture(file, &text(Form::Svg)?)?;
    }
    print(&text(args.format)?)?;
    Ok(Exit::Done)
}

/// Records as CSV, the headings first.
///
/// # Errors
/// None in practice: records of one length, in memory.
pub fn csv_text(records: Vec<Vec<String>>) -> Result<String, Failure> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for record in records {
        writer.write_record(record).map_err(Failure::run)?;
    }
    String::from_utf8(writer.into_inner().map_err(Failure::run)?).map_err(Failure::run)
}

/// The rows of a folder, folded.
fn fold(dir: &Path) -> Result<(Manifest, Report), Failure> {
    let manifest = store::manifest::<::campaign::Plan>(dir)?;
    let mut report = Report::new(manifest.plan.clone());
    store::each_row(dir, &manifest, |row| {
        report.fold(&row);
        Ok(())
    })?;
    Ok((manifest, report))
}

/// Times of the cells, beside the paper's. Not reproducible: of one machine and day.
#[derive(Clone, Debug, Serialize)]
struct Speed {
    cells: Vec<CellSpeed>,
}

#[derive(Clone, Debug, Default, Serialize)]
struct CellSpeed {
    name: String,
    episodes: u64,
    planning_s: f64,
    episode_s: f64,
    paper_s: Option<f64>,
}

impl Speed {
    /// Folds the times of a folder; what has none is left out.
    fn of(dir: &Path, manifest: &Manifest) -> Self {
        let plan = &manifest.plan;
        let mut cells: Vec<CellSpeed> = plan
            .cells
            .iter()
            .map(|cell| CellSpeed {
                name: cell.to_string(),
                paper_s: p23::cell_episode_s(cell),
                ..CellSpeed::default()
            })
            .collect();
        for times in store::times(dir).into_iter().flatten().filter(|times| times.episode_s.is_finite()) {
            let cell = usize::try_from(times.trial / plan.repetitions).ok();
            let Some(cell) = cell.and_then(|cell| cells.get_mut(cell)) else { continue };
            cell.episodes += 1;
            cell.planning_s += times.planning_s;
            cell.episode_s += times.episode_s;
        }
        Self { cells }
    }

    fn markdown(&self) -> String {
        let rows = self.cells.iter().filter(|cell| cell.episodes > 0).map(|cell| {
            let (planning_s, episode_s) =
                (cell.planning_s / cell.episodes as f64, cell.episode_s / cell.episodes as f64);
            [
                cell.name.clone(),
                format!("{:.3}", 1e3 * planning_s),
                format!("{:.3}", 1e3 * episode_s),
                cell.paper_s.map_or("-".into(), |paper_s| format!("{}", 1e3 * paper_s)),
                cell.paper_s.map_or("-".into(), |paper_s| format!("{:.0}", paper_s / episode_s)),
            ]
        });
        let rows: Vec<_> = rows.collect();
        if rows.is_empty() {
            return String::new();
        }
        let headings = ["cell", "planning, ms", "episode, ms", "paper's episode, ms", "ratio"];
        format!(
            "## Times (not reproducible)\n\nMeans of one thread on the machine that flew the trials.\n\n{}",
            ::campaign::markdown::table(headings, &rows)
        )
    }
}
