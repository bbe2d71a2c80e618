//! What the reports of all studies share.

use std::path::PathBuf;

use hopper::files::write_into;
use hopper::stdout::print;
use node::{Exit, Failure};
use p21::Spread;
use serde::Serialize;

use crate::claims::{Claim, Verdict, not_borne_out};
use crate::form::{Form, heading, table};

/// Where a report goes.
#[derive(clap::Args, Clone, Debug)]
pub struct Publication {
    /// Write the figures and the report in all formats into this folder.
    #[arg(long, value_name = "DIR", value_parser = node::output_path())]
    out: Option<PathBuf>,
    /// Format of the report.
    #[arg(long, default_value_t)]
    format: Form,
}

/// A study whose report can be written in each format.
pub trait Report: Serialize {
    /// What the files are called.
    const NAME: &'static str;

    /// Whose claims are judged.
    const PAPER: &'static str;

    /// What was studied, on how much.
    fn title(&self) -> String;

    /// Results, each table followed by an empty line.
    fn tables(&self, form: Form) -> String;

    /// The results as records of numbers, the headings first.
    fn records(&self) -> Vec<Vec<String>>;

    /// Which claims of the paper hold.
    fn claims(&self) -> &[Claim];

    /// File names and SVG documents.
    ///
    /// # Errors
    /// If a mission that is drawn does not end.
    fn figures(&self) -> Result<Vec<(String, String)>, Failure>;
}

/// The report as text, Markdown or JSON.
///
/// # Errors
/// None in practice: JSON of numbers and names.
pub fn in_form(report: &impl Report, form: Form) -> Result<String, Failure> {
    match form {
        Form::Json => Ok(serde_json::to_string(report).map_err(Failure::run)? + "\n"),
        Form::Text | Form::Markdown => Ok(against_paper(report, form)),
    }
}

/// The report for people, without the paper.
pub fn results<R: Report>(report: &R, form: Form) -> String {
    let mark = if form == Form::Markdown { "# " } else { "" };
    format!("{mark}{}\n\n", report.title()) + &report.tables(form)
}

/// The report for people, with the claims of the paper.
fn against_paper<R: Report>(report: &R, form: Form) -> String {
    let mark = if form == Form::Markdown { "# " } else { "" };
    let claims = report.claims();
    let hold = claims.iter().filter(|claim| claim.verdict == Verdict::Holds).count();
    let (title, all, paper) = (report.title(), claims.len(), R::PAPER);
    let rows: Vec<_> = claims.iter().map(Claim::cells).collect();
    format!("{mark}{title}: {hold} of {all} claims of {paper} hold\n\n")
        + &report.tables(form)
        + &heading(form, &format!("Claims of {paper}"))
        + &table(form, Claim::HEADINGS, &rows)
        + &missing(claims, form)
}

/// Names the claims that do not reproduce, and those that too few runs leave open.
fn missing(claims: &[Claim], form: Form) -> String {
    let groups = not_borne_out(claims);
    if groups.is_empty() {
        return String::new();
    }
    let mut text = heading(form, "What does not reproduce, or is open");
    for (verdict, claims) in groups {
        for Claim { claim, holds_if, ours, .. } in claims {
            let why = if verdict == Verdict::NotToBeHad { holds_if } else { ours };
            text += &format!("- {}: {claim}: {why}\n", verdict.words());
        }
    }
    text
}

impl Publication {
    /// Prints a report, and writes it in all formats with its figures into the folder, if there is to be one.
    ///
    /// # Errors
    /// Exit code 2 if the folder cannot be created, 1 if something cannot be printed or written.
    pub fn publish<R: Report>(&self, report: &R) -> Result<Exit, Failure> {
        if let Some(dir) = &self.out {
            let mut files = report.figures()?;
            for (end, form) in [("txt", Form::Text), ("md", Form::Markdown), ("json", Form::Json)] {
                files.push((format!("{}.{end}", R::NAME), in_form(report, form)?));
            }
            write_into(dir, files)?;
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

/// The headings of a number with its interval.
pub fn headings_of(name: &str) -> [String; 3] {
    [name.into(), format!("{name}_low"), format!("{name}_high")]
}

/// A number with its interval as cells of a record.
pub fn cells_of(Spread { value, low, high }: Spread) -> [String; 3] {
    [value, low, high].map(|number| number.to_string())
}
