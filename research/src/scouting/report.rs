//! What the reports of all studies share.

use std::path::Path;

use ::scouting::{RoverPlanner, Spread};
use hopper::stdout::print;
use node::Failure;
use serde::Serialize;

use super::claims::{Claim, Verdict};
use crate::form::{Form, table, write_out};

/// Planners of the safe rover, by their names.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq, Default)]
#[value(rename_all = "snake_case")]
pub enum Planner {
    /// That of the paper.
    #[default]
    RrtStarEtt,
    /// Ours.
    EttExact,
}

impl std::fmt::Display for Planner {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(match self {
            Planner::RrtStarEtt => "rrt_star_ett",
            Planner::EttExact => "ett_exact",
        })
    }
}

impl From<Planner> for RoverPlanner {
    fn from(planner: Planner) -> Self {
        match planner {
            Planner::RrtStarEtt => RoverPlanner::RrtStarEtt,
            Planner::EttExact => RoverPlanner::EttExact,
        }
    }
}

/// A study whose report can be written in each format.
pub trait Report: Serialize {
    /// What the files are called.
    const NAME: &'static str;

    /// The report for people: text or Markdown.
    fn written(&self, form: Form) -> String;

    /// File names and SVG documents.
    fn figures(&self) -> Vec<(String, String)>;
}

fn in_form(report: &impl Report, form: Form) -> Result<String, Failure> {
    match form {
        Form::Json => Ok(serde_json::to_string(report).map_err(Failure::run)? + "\n"),
        Form::Text | Form::Markdown => Ok(report.written(form)),
    }
}

/// Prints a report, and writes it in all formats with its figures into `out`.
///
/// # Errors
/// Exit code 2 if the folder cannot be created, 1 if something cannot be printed or written.
pub fn publish<R: Report>(report: &R, form: Form, out: Option<&Path>) -> Result<(), Failure> {
    if let Some(dir) = out {
        let mut files = report.figures();
        for (end, form) in [("txt", Form::Text), ("md", Form::Markdown), ("json", Form::Json)] {
            files.push((format!("{}.{end}", R::NAME), in_form(report, form)?));
        }
        write_out(dir, files.iter().map(|(name, text)| (name.clone(), text.as_str())))?;
    }
    print(&in_form(report, form)?)
}

/// The title of a report.
pub fn title(form: Form, study: &str, claims: &[Claim]) -> String {
    let mark = if form == Form::Markdown { "# " } else { "" };
    let hold = claims.iter().filter(|claim| claim.verdict == Verdict::Holds).count();
    format!("{mark}{study}: {hold} of {} claims of Folsom et al. 2021 hold\n\n", claims.len())
}

/// The table of claims.
pub fn claims(form: Form, claims: &[Claim]) -> String {
    let rows: Vec<_> = claims.iter().map(Claim::cells).collect();
    table(form, ["claim", "paper", "holds if", "ours", "verdict"], &rows)
}

/// A share with its 95 % interval, in percent.
pub fn percent(spread: Spread) -> String {
    format!("{:.1} % ({:.1} to {:.1})", 100.0 * spread.value, 100.0 * spread.low, 100.0 * spread.high)
}

/// A number with its 95 % interval.
pub fn number(spread: Spread, decimals: usize) -> String {
    let Spread { value, low, high } = spread;
    format!("{value:.decimals$} ({low:.decimals$} to {high:.decimals$})")
}
