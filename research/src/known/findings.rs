//! `hopper known findings`: repeats the paper's four experiments and checks its claims.

use std::path::PathBuf;

use ::campaign::statistics::wilson;
use hopper::files::write_into;
use hopper::stdout::print;
use node::{Exit, Failure};
use p22::execution::{self, Execution};
use p22::{Case, Claim, Experiment, Findings, KnownMap, Model, P22, Plan, figures};
use rayon::prelude::*;
use serde::Serialize;

use crate::form::{Form, heading, table};

/// Arguments of `hopper known findings`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// Journeys simulated for each policy, with every slip drawn.
    #[arg(long, default_value_t = 1000, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=execution::TRIALS_MAX))]
    trials: u64,
    /// Seed of the first journey; the following count up from it.
    #[arg(long, default_value_t = 1, value_name = "N")]
    seed: u64,
    /// Write the figures and the report in all formats into this folder.
    #[arg(long, value_name = "DIR", value_parser = node::output_path())]
    out: Option<PathBuf>,
    /// Format of the report on standard output.
    #[arg(long, default_value_t)]
    format: Form,
}

/// The findings, and how often each policy arrives when it is simulated; field names are those of the JSON.
#[derive(Clone, Debug, Serialize)]
struct Account {
    seed: u64,
    findings: Findings,
    /// In the order of the cases.
    executions: Vec<Execution>,
}

/// Prints the report.
///
/// # Errors
/// Exit code 2 if the folder cannot be created, 1 if it cannot be written.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let findings = Findings::new(&P22);
    let executions = findings
        .cases
        .par_iter()
        .map(|case| {
            let world = KnownMap::new(case.experiment, &P22);
            let model = Model::new(&world, &P22);
            let plan = Plan::new(&world, &model, &P22, case.weights);
            execution::execute(&world, &model, &plan.solution, args.seed, args.trials)
        })
        .collect::<Result<Vec<_>, _>>()
        .map_err(Failure::usage)?;
    let account = Account { seed: args.seed, findings, executions };
    if let Some(dir) = &args.out {
        let figures = figures(&account.findings).map_err(Failure::run)?;
        let reports =
            [("findings.txt", Form::Text), ("findings.md", Form::Markdown), ("findings.json", Form::Json)];
        let reports = reports.map(|(name, form)| account.written(form).map(|text| (name.to_owned(), text)));
        let reports = reports.into_iter().collect::<Result<Vec<_>, _>>()?;
        let figures = figures.iter().map(|figure| (format!("{}.svg", figure.name), figure.svg.as_str()));
        write_into(dir, reports.iter().map(|(name, text)| (name.clone(), text.as_str())).chain(figures))?;
    }
    print(&account.written(args.format)?)?;
    Ok(Exit::Done)
}

impl Account {
    fn written(&self, form: Form) -> Result<String, Failure> {
        if form == Form::Json {
            return Ok(serde_json::to_string(self).map_err(Failure::run)? + "\n");
        }
        let (holds, claims) = self.findings.score();
        let title = format!("Known ground: {holds} of {claims} claims of Sakamoto & Kubota 2022 hold");
        let mut text = match form {
            Form::Markdown => format!("# {title}\n\n"),
            _ => format!("{title}\n\n"),
        };
        for (n, experiment) in Experiment::ALL.into_iter().enumerate() {
            text += &heading(form, &format!("Finding {}: {experiment}", n + 1));
            text += &self.cases(form, experiment);
        }
        text += &heading(form, "Claims");
        text += &self.claims(form);
        text += &heading(form, "What does not reproduce");
        text += &self.failing(form);
        Ok(text)
    }

    fn cases(&self, form: Form, experiment: Experiment) -> String {
        let cases = self.findings.cases.iter().zip(&self.executions);
        let rows: Vec<_> = cases
            .filter(|(case, _)| case.experiment == experiment)
            .map(|(case, execution)| row(case, execution))
            .collect();
        let headings = [
            "w1",
            "w2",
            "goal",
            "path",
            "hops",
            "mean height, m",
            "mean slope",
            "on sand",
            "vertical hops",
            "arrived, %",
            "95 %",
            "left the map, %",
            "hops of a success",
        ];
        table(form, headings, &rows)
    }

    fn claims(&self, form: Form) -> String {
        let rows: Vec<_> = Experiment::ALL
            .into_iter()
            .map(|experiment| {
                let of = self.findings.claims.iter().filter(|claim| claim.experiment == experiment);
                let (ours, judged): (Vec<&Claim>, Vec<&Claim>) = of.partition(|claim| claim.by_construction);
                let holding = |claims: &[&Claim]| claims.iter().filter(|claim| claim.holds).count();
                [
                    experiment.to_string(),
                    format!("{} of {}", holding(&judged), judged.len()),
                    match ours.len() {
                        0 => "-".into(),
                        count => format!("{} of {count}", holding(&ours)),
                    },
                ]
            })
            .collect();
        table(form, ["world", "hold", "by our choice of the rocks"], &rows)
    }

    fn failing(&self, form: Form) -> String {
        let failing = self.findings.claims.iter().filter(|claim| !claim.holds);
        let rows: Vec<_> = failing
            .map(|claim| [claim.experiment.to_string(), claim.statement.clone(), claim.got.clone()])
            .collect();
        if rows.is_empty() { "Nothing.\n".into() } else { table(form, ["world", "claim", "got"], &rows) }
    }
}

fn row(case: &Case, execution: &Execution) -> [String; 13] {
    let path = &case.path;
    let arriving = |text: String| if path.arrives() { text } else { "-".into() };
    let interval = wilson(execution.successes, execution.trials);
    let ups: Vec<String> = path.ups().map(|cell| cell.to_string()).collect();
    [
        case.weights.safety.to_string(),
        case.weights.information.to_string(),
        case.weights.goal.to_string(),
        path.ending.to_string(),
        arriving(path.hops.len().to_string()),
        arriving(format!("{:.3}", path.mean_height_m)),
        arriving(format!("{:.4}", path.mean_slope)),
        arriving(path.sand_cells.to_string()),
        arriving(if ups.is_empty() { "-".into() } else { ups.join(" ") }),
        format!("{:.1}", 100.0 * execution.success()),
        format!("{:.1} to {:.1}", 100.0 * interval.low, 100.0 * interval.high),
        format!("{:.1}", 100.0 * execution.lost as f64 / execution.trials as f64),
        execution.mean_hops().map_or("-".into(), |hops| format!("{hops:.1}")),
    ]
}
