//! The study as text, Markdown or JSON.

use node::Failure;
use serde::Serialize;

use super::case::Row;
use super::claims::{self, Claim, Verdict};
use super::study::{Ours, Sharing, Study};
use crate::form::{Form, heading, table};

/// A study with the verdicts on the paper's claims; field names are those of the JSON.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    #[serde(flatten)]
    study: Study,
    claims: Vec<Claim>,
}

impl Report {
    /// Judges the claims.
    pub fn new(study: Study) -> Self {
        Self { claims: claims::all(&study), study }
    }

    /// The report.
    ///
    /// # Errors
    /// None in practice: JSON of numbers and names.
    pub fn written(&self, form: Form) -> Result<String, Failure> {
        if form == Form::Json {
            return Ok(serde_json::to_string(self).map_err(Failure::run)? + "\n");
        }
        let holds = self.claims.iter().filter(|claim| claim.verdict == Verdict::Holds).count();
        let title = format!(
            "Coverage: {holds} of {} claims of Laîné & Yoshida 2019 hold ({} worlds a case, seed {})",
            self.claims.len(),
            self.study.sampling.runs,
            self.study.sampling.seed
        );
        let mut text = if form == Form::Markdown { format!("# {title}\n\n") } else { format!("{title}\n\n") };
        text += &heading(form, "Path ratio of one rover, 20 × 20 cells (Fig. 6)");
        text += &single(form, &self.study.single);
        text += &heading(form, "Path ratio of teams at 95 %, spiral (Fig. 8)");
        text += &sharing(form, &self.study.sharing);
        text += &heading(form, "Path ratio of cover_frontier beside spiral");
        text += &ours(form, &self.study.ours);
        text += &heading(form, "Claims");
        text += &self.claims(form);
        Ok(text)
    }

    fn claims(&self, form: Form) -> String {
        let rows: Vec<_> = self
            .claims
            .iter()
            .map(|claim| {
                let holds = match claim.verdict {
                    Verdict::Holds => "yes",
                    Verdict::Fails => "no",
                    Verdict::Open => "open",
                };
                [claim.source, &claim.statement, &claim.got, holds, claim.criterion].map(str::to_owned)
            })
            .collect();
        table(form, ["figure", "the paper", "ours (95 %)", "holds", "holds if"], &rows)
    }
}

fn single(form: Form, rows: &[Row]) -> String {
    let rows: Vec<_> = rows
        .iter()
        .map(|row| {
            [
                row.case.algorithm.to_string(),
                format!("{} %", row.percent),
                row.mean.written(3),
                format!("{:.3}", row.sd),
            ]
        })
        .collect();
    table(form, ["planner", "covered", "path ratio (95 %)", "sd"], &rows)
}

fn sharing(form: Form, sharing: &[Sharing]) -> String {
    let rows: Vec<_> = sharing
        .iter()
        .map(|Sharing { overlap, voronoi }| {
            [
                format!("{0} × {0}", overlap.case.ground.side),
                overlap.case.rovers.to_string(),
                overlap.mean.written(4),
                format!("{:.4}", overlap.sd),
                voronoi.mean.written(4),
                format!("{:.4}", voronoi.sd),
                format!("{:.2}", voronoi.mean.value / overlap.mean.value),
            ]
        })
        .collect();
    table(form, ["cells", "rovers", "overlap (95 %)", "sd", "Voronoi (95 %)", "sd", "times"], &rows)
}

fn ours(form: Form, ours: &[Ours]) -> String {
    let rows: Vec<_> = ours
        .iter()
        .map(|Ours { spiral, ours, saving, bound }| {
            let ground = ours.case.ground;
            [
                format!("{0} × {0}, {1} %", ground.side, ground.obstacle_percent),
                ours.case.rovers.to_string(),
                format!("{} %", ours.percent),
                spiral.mean.written(4),
                ours.mean.written(4),
                saving.written(4),
                format!("{bound:.4}"),
            ]
        })
        .collect();
    let headings = [
        "cells, obstacles",
        "rovers",
        "covered",
        "spiral (95 %)",
        "cover_frontier (95 %)",
        "saving (95 %)",
        "bound",
    ];
    table(form, headings, &rows)
}
