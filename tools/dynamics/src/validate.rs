//! `hopper validate`: contact dynamics beside closed forms, laboratory impacts and what has flown.
//!
//! One parameter set a body and soil, that of the presets. What does not come out is shown.

mod closed_forms;
mod flown;
mod laboratory;

use hopper::stdout::{print, print_json};
use node::{Exit, Failure};
use report::{Format, table};
use serde::Serialize;

/// Arguments of `hopper validate`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// Format of the answer on standard output: text or json.
    #[arg(long, default_value_t)]
    format: Format,
}

/// Whether a published figure comes out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Ours is what was published, or our interval of 90 % holds it.
    Holds,
    /// It is not.
    Fails,
    /// Nothing is measured yet, or the figure is a fit of a free parameter.
    Open,
}

/// A published figure beside ours.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Where it was published.
    pub source: &'static str,
    /// What it is.
    pub quantity: &'static str,
    /// What was published.
    pub published: String,
    /// What comes out here.
    pub ours: String,
    /// Whether that is the same.
    pub verdict: Verdict,
}

impl Row {
    fn new(source: &'static str, quantity: &'static str, published: impl Into<String>) -> Self {
        Self { source, quantity, published: published.into(), ours: String::new(), verdict: Verdict::Open }
    }

    /// Ours, and whether it holds.
    fn is(self, ours: impl Into<String>, holds: bool) -> Self {
        let verdict = if holds { Verdict::Holds } else { Verdict::Fails };
        Self { ours: ours.into(), verdict, ..self }
    }

    /// Ours, of which nobody can say yet whether it holds.
    fn left_open(self, ours: impl Into<String>) -> Self {
        Self { ours: ours.into(), ..self }
    }
}

/// All rows.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Validation {
    /// In the order of closed forms, laboratory, flown.
    pub rows: Vec<Row>,
}

impl Validation {
    /// Computes all rows.
    #[must_use]
    pub fn compute() -> Self {
        let rows = closed_forms::rows().into_iter().chain(laboratory::rows()).chain(flown::rows());
        Self { rows: rows.collect() }
    }
}

/// Runs the command.
///
/// # Errors
/// Exit code 1 if standard output cannot be written.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let validation = Validation::compute();
    match args.format {
        Format::Json => print_json(&validation)?,
        Format::Text => {
            let row = |row: &Row| {
                let verdict = match row.verdict {
                    Verdict::Holds => "holds",
                    Verdict::Fails => "FAILS",
                    Verdict::Open => "open",
                };
                [row.source, row.quantity, &row.published, &row.ours, verdict].map(str::to_owned)
            };
            let rows: Vec<_> = validation.rows.iter().map(row).collect();
            print(&table(["source", "quantity", "published", "ours", "verdict"], &rows))?;
        }
    }
    Ok(Exit::Done)
}

/// The value below which that share of values lies.
fn quantile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * share).round() as usize]
}

/// The central interval of 90 % of values, and whether it holds one.
fn central(values: &mut [f64], published: f64) -> ([f64; 2], bool) {
    let ends = [quantile(values, 0.05), quantile(values, 0.95)];
    (ends, (ends[0]..=ends[1]).contains(&published))
}
