//! Draws the paper's figures from the computed plans.

use report::ReportError;
use report::picture::{Aim, Chart, Curves, Line, Panel, Panels};

use crate::{Experiment, Findings, KnownMap, Model, Plan, Reading, Weights};

/// A figure as an SVG document.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// File name without extension.
    pub name: &'static str,
    /// The picture as an SVG document.
    pub svg: String,
}

/// One figure for each experiment, with policy, path and terrain for all weights side by side, and one with mean
/// height and mean slope against w1.
///
/// # Errors
/// Never for the paper's maps: their layers cover their grids.
pub fn figures(findings: &Findings) -> Result<Vec<Figure>, ReportError> {
    let mut figures = Vec::new();
    for (experiment, name) in [
        (Experiment::Hard, "hard"),
        (Experiment::Heterogeneous, "heterogeneous"),
        (Experiment::Sandy, "sandy"),
        (Experiment::Rocks, "rocks"),
    ] {
        figures.push(Figure { name, svg: experiment_svg(findings, experiment)? });
    }
    figures.push(Figure { name: "means", svg: means(findings).svg() });
    Ok(figures)
}

/// One plan as an SVG document.
///
/// # Errors
/// Never for a plan of this map: its layers cover its grid.
pub fn figure(map: &KnownMap, model: &Model, plan: &Plan) -> Result<String, ReportError> {
    let panels = Panels {
        title: title(map.experiment).into(),
        caption: format!(
            "w1 = {}, w2 = {}, goal {}",
            plan.weights.safety, plan.weights.information, plan.weights.goal
        ),
        columns: 1,
        side: 640.0,
        panels: vec![panel(map, model, plan)],
    };
    panels.svg()
}

fn experiment_svg(findings: &Findings, experiment: Experiment) -> Result<String, ReportError> {
    let reading: &Reading = &findings.reading;
    let map = KnownMap::new(experiment, reading);
    let model = Model::new(&map, reading);
    let cases = findings.cases.iter().filter(|case| case.experiment == experiment);
    let plans: Vec<Plan> = cases.map(|case| Plan::new(&map, &model, reading, case.weights)).collect();
    let single = plans.len() == 1;
    let panels = Panels {
        title: title(experiment).into(),
        caption: "The policy's hop in every cell, and where its intended moves lead; x east, y north, metres"
            .into(),
        columns: if single { 1 } else { 4 },
        side: if single { 560.0 } else { 300.0 },
        panels: plans.iter().map(|plan| panel(&map, &model, plan)).collect(),
    };
    panels.svg()
}

fn title(experiment: Experiment) -> &'static str {
    match experiment {
        Experiment::Hard => "Known hard ground",
        Experiment::Heterogeneous => "Known heterogeneous ground",
        Experiment::Sandy => "Known sandy ground",
        Experiment::Rocks => "A plain with a tall rock (1.0 m) and a low one (0.25 m)",
    }
}

fn panel<'a>(map: &'a KnownMap, model: &Model, plan: &'a Plan) -> Panel<'a> {
    let aim = |choice: usize| {
        let hop = model.choices[choice].hop;
        Aim { direction: hop.direction(), up: hop.is_up() }
    };
    let goal = match plan.weights.goal == Weights::GOAL {
        true => String::new(),
        false => format!(", goal {}", plan.weights.goal),
    };
    let outcome = if plan.path.arrives() { "" } else { ": no path" };
    Panel {
        title: format!("w = ({}, {}){goal}{outcome}", plan.weights.safety, plan.weights.information),
        grid: map.grid,
        ground: &map.ground,
        policy: plan.solution.policy.iter().map(|choice| choice.map(aim)).collect(),
        path: &plan.path.cells,
        arrives: plan.path.arrives(),
        start: map.start,
        goal: map.goal,
    }
}

fn means(findings: &Findings) -> Curves {
    let grounds = [Experiment::Hard, Experiment::Heterogeneous, Experiment::Sandy];
    let chart = |quantity: &str, value: &dyn Fn(&crate::Path) -> f64| Chart {
        quantity: quantity.into(),
        lines: grounds
            .iter()
            .map(|&experiment| Line {
                name: experiment.to_string(),
                values: findings
                    .of(experiment)
                    .map(|case| case.path.arrives().then(|| value(&case.path)))
                    .collect(),
            })
            .collect(),
    };
    Curves {
        title: "Mean height and mean slope along the path".into(),
        caption: "Where there is no path there is no point".into(),
        axis: "w1, the weight of safety; w2 = 1 − w1".into(),
        at: Weights::eleven().map(|weights| weights.safety).collect(),
        charts: vec![
            chart("mean height (m)", &|path| path.mean_height_m),
            chart("mean slope (m/m)", &|path| path.mean_slope),
        ],
    }
}
