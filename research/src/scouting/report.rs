//! What the reports of all studies share.

use std::path::PathBuf;

use ::scouting::Spread;
use hopper::stdout::print;
use node::{Exit, Failure};
use serde::Serialize;

use super::claims::{Claim, Verdict};
use crate::form::{Form, table, write_out};

/// Where a report goes.
#[derive(clap::Args, Clone, Debug)]
pub struct Publication {
    /// Write the figures and the report in all formats into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Format of the report.
    #[arg(long, default_value_t)]
    format: Form,
}

/// A study whose report can be written in each format.
pub trait Report: Serialize {
    /// What the files are called.
    const NAME: &'static str;

    /// What was studied, on how much.
    fn title(&self) -> String;

    /// Results, each table followed by an empty line.
    fn tables(&self, form: Form) -> String;

    /// Which claims of the paper hold.
    fn claims(&self) -> &[Claim];

    /// File names and SVG documents.
    fn figures(&self) -> Vec<(String, String)>;
}

fn in_form(report: &impl Report, form: Form) -> Result<String, Failure> {
    match form {
        Form::Json => Ok(serde_json::to_string(report).map_err(Failure::run)? + "\n"),
        Form::Text | Form::Markdown => Ok(written(report, form)),
    }
}

/// The report for people.
fn written(report: &impl Report, form: Form) -> String {
    let mark = if form == Form::Markdown { "# " } else { "" };
    let claims = report.claims();
    let hold = claims.iter().filter(|claim| claim.verdict == Verdict::Holds).count();
    let (title, all) = (report.title(), claims.len());
    let rows: Vec<_> = claims.iter().map(Claim::cells).collect();
    format!("{mark}{title}: {hold} of {all} claims of Folsom et al. 2021 hold\n\n")
        + &report.tables(form)
        + &table(form, ["claim", "paper", "holds if", "ours", "verdict"], &rows)
}

impl Publication {
    /// Prints a report, and writes it in all formats with its figures into the folder, if there is to be one.
    ///
    /// # Errors
    /// Exit code 2 if the folder cannot be created, 1 if something cannot be printed or written.
    pub fn publish<R: Report>(&self, report: &R) -> Result<Exit, Failure> {
        if let Some(dir) = &self.out {
            let mut files = report.figures();
            for (end, form) in [("txt", Form::Text), ("md", Form::Markdown), ("json", Form::Json)] {
                files.push((format!("{}.{end}", R::NAME), in_form(report, form)?));
            }
            write_out(dir, files.iter().map(|(name, text)| (name.clone(), text.as_str())))?;
        }
        print(&in_form(report, self.format)?)?;
        Ok(Exit::Done)
    }
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
