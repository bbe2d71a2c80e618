//! How many steps the missions of the paper's tables take, as a figure.

use std::path::Path;

use ::campaign::{Campaign, Report, TrialPlan as _};
use hopper::commands::campaign::fly::fly;
use hopper::commands::campaign::store::VERSION;
use node::Failure;
use rayon::prelude::*;

use super::Figure;

/// The scenario with a step limit of its own, and so an axis of its own.
const LARGE: &str = "large";
/// The paper's tables at the paper's repetitions.
const TABLES: &str = include_str!("../../../campaigns/p23-tables.toml");

/// The distribution of steps in every cell of the tables on maps of 20 × 20 cells.
///
/// # Errors
/// If a mission cannot be flown.
pub fn small() -> Result<Figure, Failure> {
    figure("steps", "Steps of the paper's tables", "3 to 11 and 15 to 17", |scenario| scenario != LARGE)
}

/// The distribution of steps on the large map.
///
/// # Errors
/// If a mission cannot be flown.
pub fn large() -> Result<Figure, Failure> {
    figure("steps-large", "Steps on the large map", "12 to 14", |scenario| scenario == LARGE)
}

fn figure(name: &str, title: &str, tables: &str, wanted: impl Fn(&str) -> bool) -> Result<Figure, Failure> {
    let mut campaign = Campaign::parse(TABLES, "campaigns/p23-tables.toml").map_err(Failure::usage)?;
    campaign.scenarios.retain(|scenario| wanted(scenario));
    let plan = campaign.plan(Path::new(""), VERSION).map_err(Failure::usage)?;
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
        name: name.into(),
        title: title.into(),
        text: format!(
            "{} missions of `campaigns/p23-tables.toml`, {} a cell: behind every mean of Tables {tables} of \
             Sakamoto & Kunii 2023 stands a distribution, and failures stay in the denominator. \
             `hopper campaign report DIR --format svg` draws the same of any campaign.",
            plan.trials(),
            plan.repetitions
        ),
        svg: report.distribution_svg(p23::tables::STEPS_AXIS),
    })
}
