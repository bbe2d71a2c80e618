//! How many steps the missions of the paper's tables take, as a figure.

use std::path::Path;

use ::campaign::{Campaign, Report};
use node::Failure;
use rayon::prelude::*;

use super::Figure;
use crate::campaign::fly::fly;

/// The paper's tables at the paper's repetitions.
const TABLES: &str = include_str!("../../campaigns/p23-tables.toml");

/// The distribution of steps in every cell of the tables.
///
/// # Errors
/// If a mission cannot be flown.
pub fn figure() -> Result<Figure, Failure> {
    let campaign = Campaign::parse(TABLES, "campaigns/p23-tables.toml").map_err(Failure::usage)?;
    let plan = campaign.plan(Path::new(""), env!("CARGO_PKG_VERSION")).map_err(Failure::usage)?;
    let worlds =
        plan.cells.iter().map(|cell| cell.world()).collect::<Result<Vec<_>, _>>().map_err(Failure::usage)?;
    let trials: Vec<_> = (0..plan.trials()).filter_map(|number| plan.trial(number)).collect();
    let rows: Vec<_> = trials
        .par_iter()
        .map(|trial| Ok(fly(&plan, &worlds[trial.cell.number as usize], trial)?.0))
        .collect::<Result<_, Failure>>()?;
    let mut report = Report::new(plan.clone());
    rows.iter().for_each(|row| report.fold(row));
    Ok(Figure {
        name: "steps".into(),
        title: "Steps of the paper's tables".into(),
        text: format!(
            "The {} missions of `campaigns/p23-tables.toml`, {} a cell: behind every mean of Tables 3, 4, 6, 7, 9 \
             and 10 of Sakamoto & Kunii 2023 stands a distribution, and failures stay in the denominator. \
             `hopper campaign report DIR --format svg` draws the same of any campaign.",
            plan.trials(),
            plan.repetitions
        ),
        svg: report.distribution_svg(),
    })
}
