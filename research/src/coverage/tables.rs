//! The study as tables of text or Markdown, and as records.

use node::Failure;
use p19::stop_rule::{self, StopRule};
use p19::{Account, Ours, PLANNERS, Row, Sharing, row};
use rayon::prelude::*;
use serde::Serialize;

use super::{claims, figures};
use crate::claims::Claim;
use crate::form::{Form, heading, table};
use crate::report;
use crate::studies::FlownWorld;
use crate::studies::coverage::Coverage;

/// A study with the verdicts on the paper's claims; field names are those of the JSON.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    #[serde(flatten)]
    account: Account,
    /// The paper's rule to stop beside ours.
    stop_rule: Vec<StopRule>,
    claims: Vec<Claim>,
}

impl Report {
    /// What the worlds of a campaign of seed `seed` come to, and what that says of the claims.
    pub fn new(seed: u64, worlds: &[FlownWorld<Coverage>]) -> Self {
        let worlds: Vec<_> = worlds.iter().map(|world| (world.seed, world.outcomes.as_slice())).collect();
        let account = Account::new(seed, &worlds);
        Self { claims: claims::all(&account), stop_rule: by_the_papers_rule(&account), account }
    }
}

impl report::Report for Report {
    const NAME: &'static str = "coverage";
    const PAPER: &'static str = "Laîné & Yoshida 2019";

    fn title(&self) -> String {
        let sampling = self.account.sampling;
        format!("Coverage, {} worlds a case, seed {}", sampling.runs, sampling.seed)
    }

    fn tables(&self, form: Form) -> String {
        let Account { single: fig_6, sharing: fig_8, ours: beside, .. } = &self.account;
        [
            ("Path ratio of one rover, 20 × 20 cells (Fig. 6)", single(form, fig_6)),
            ("Path ratio of teams at 95 %, spiral (Fig. 8)", sharing(form, fig_8)),
            ("Path ratio of one rover by the paper's rule to stop", stopped(form, &self.stop_rule)),
            ("Path ratio of cover_frontier beside spiral", ours(form, beside)),
        ]
        .map(|(words, table)| heading(form, words) + &table)
        .concat()
    }

    fn records(&self) -> Vec<Vec<String>> {
        let headings = [
            "side",
            "obstacle_percent",
            "planner",
            "mode",
            "rovers",
            "percent",
            "runs",
            "path_ratio",
            "path_ratio_low",
            "path_ratio_high",
            "path_ratio_sd",
        ];
        let Account { single, small, pairs, sharing, ours, .. } = &self.account;
        let rows = single.iter().chain(small).chain(pairs.iter().flatten());
        let rows = rows.chain(sharing.iter().flat_map(|both| [&both.overlap, &both.voronoi]));
        let rows = rows.chain(ours.iter().flat_map(|both| [&both.spiral, &both.ours]));
        std::iter::once(headings.map(String::from).into()).chain(rows.map(record)).collect()
    }

    fn claims(&self) -> &[Claim] {
        &self.claims
    }

    fn figures(&self) -> Result<Vec<(String, String)>, Failure> {
        figures::all(&self.account)
    }
}

fn record(row: &Row) -> Vec<String> {
    let Row { case, percent, mean, sd, ratios } = row;
    vec![
        case.ground.side.to_string(),
        case.ground.obstacle_percent.to_string(),
        case.algorithm.to_string(),
        case.mode_name().into(),
        case.rovers.to_string(),
        percent.to_string(),
        ratios.len().to_string(),
        mean.value.to_string(),
        mean.low.to_string(),
        mean.high.to_string(),
        sd.to_string(),
    ]
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

/// Flies the paper's planners again by its rule to stop.
fn by_the_papers_rule(account: &Account) -> Vec<StopRule> {
    let on_world = |seed: &u64| {
        PLANNERS.map(|algorithm| stop_rule::steps(algorithm, *seed).expect("it has ended by our rule"))
    };
    let flown: Vec<_> = account.seeds.par_iter().map(on_world).collect();
    let ours = |algorithm, percent| row(&account.single, algorithm, percent).ratios.clone();
    stop_rule::compared(&flown, ours)
}

fn stopped(form: Form, rows: &[StopRule]) -> String {
    let rows: Vec<_> = rows
        .iter()
        .map(|row| {
            [
                row.algorithm.to_string(),
                format!("{} %", row.percent),
                format!("{} of {}", row.runs - row.stopped, row.runs),
                row.mean.written(3),
                row.longer.written(4),
            ]
        })
        .collect();
    let headings = ["planner", "covered", "never stops in", "path ratio (95 %)", "more than by ours"];
    table(form, headings, &rows)
}

fn sharing(form: Form, sharing: &[Sharing]) -> String {
    let rows: Vec<_> = sharing
        .iter()
        .map(|both| {
            let Sharing { overlap, voronoi } = both;
            [
                format!("{0} × {0}", overlap.case.ground.side),
                overlap.case.rovers.to_string(),
                overlap.mean.written(4),
                format!("{:.4}", overlap.sd),
                voronoi.mean.written(4),
                format!("{:.4}", voronoi.sd),
                format!("{:.2}", voronoi.mean.value / overlap.mean.value),
                both.voronoi_as_short().times(100.0).written(1),
            ]
        })
        .collect();
    let headings = [
        "cells",
        "rovers",
        "overlap (95 %)",
        "sd",
        "Voronoi (95 %)",
        "sd",
        "times",
        "% of worlds with Voronoi as short",
    ];
    table(form, headings, &rows)
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
