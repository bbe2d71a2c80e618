//! `hopper scouting`: repeats the Monte Carlo study of Folsom et al. 2021, a rover with a helicopter.

mod claims;

use ::scouting::{Arm, Outcome, RoverPlanner, Samples, Spread, Study, announce, fly, monte_carlo};
use hopper::stdout::print;
use node::{Exit, Failure};
use rayon::prelude::*;
use serde::Serialize;

use crate::form::{Form, table};
use claims::Claim;

/// Arguments of `hopper scouting`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// Worlds; all arms meet the same ones.
    #[arg(long, default_value_t = 1000, value_name = "N", value_parser = clap::value_parser!(u64).range(2..=1_000_000))]
    runs: u64,
    /// Seed of the first world; the following count up from it.
    #[arg(long, default_value_t = 1, value_name = "N")]
    seed: u64,
    /// Planner of the safe rover in all arms.
    #[arg(long, default_value_t, value_name = "PLANNER")]
    rover: Planner,
    /// Format of the report.
    #[arg(long, default_value_t)]
    format: Form,
}

/// Planners of the safe rover, by their names.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq, Default)]
#[value(rename_all = "snake_case")]
enum Planner {
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

/// What one arm came to; field names are those of the JSON.
#[derive(Clone, Debug, Serialize)]
struct Row {
    arm: Arm,
    stuck: usize,
    without_route: usize,
    median_sol: f64,
    sd_sol: f64,
    /// Against the safe rover.
    median_saving: Spread,
    mean_paired_saving: Spread,
}

/// The whole study; field names are those of the JSON.
#[derive(Clone, Debug, Serialize)]
struct Account {
    runs: u64,
    seed: u64,
    rover: RoverPlanner,
    samples: Samples,
    rows: Vec<Row>,
    claims: Vec<Claim>,
}

/// Flies the study and prints its report.
///
/// # Errors
/// Exit code 1 if the report cannot be printed.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let planner = match args.rover {
        Planner::RrtStarEtt => RoverPlanner::RrtStarEtt,
        Planner::EttExact => RoverPlanner::EttExact,
    };
    let samples = Samples::MONTE_CARLO;
    let worlds: Vec<[Outcome; Arm::ALL.len()]> = (0..args.runs)
        .into_par_iter()
        .map(|run| {
            let seed = args.seed.wrapping_add(run);
            let world = monte_carlo(seed);
            let announced = announce(&world, planner, samples, seed);
            Arm::ALL.map(|arm| fly(&world, arm, planner, samples, seed, announced.as_ref()))
        })
        .collect();
    let studies: [Study; Arm::ALL.len()] = std::array::from_fn(|arm| Study {
        outcomes: worlds.iter().map(|outcomes| outcomes[arm].clone()).collect(),
    });
    let safe = &studies[Arm::SafeRover as usize];
    let rows: Vec<Row> = Arm::ALL
        .into_iter()
        .zip(&studies)
        .map(|(arm, study)| Row {
            arm,
            stuck: study.stuck(),
            without_route: study.without_route(),
            median_sol: study.median_sol(),
            sd_sol: study.sd_sol(),
            median_saving: study.median_saving(safe),
            mean_paired_saving: study.mean_paired_saving(safe),
        })
        .collect();
    let claims = claims::judge(args.runs, &rows);
    let account = Account { runs: args.runs, seed: args.seed, rover: planner, samples, rows, claims };
    print(&account.written(args.format)?)?;
    Ok(Exit::Done)
}

impl Account {
    fn written(&self, form: Form) -> Result<String, Failure> {
        if form == Form::Json {
            return Ok(serde_json::to_string(self).map_err(Failure::run)? + "\n");
        }
        let hold = self.claims.iter().filter(|claim| claim.holds).count();
        let mut text = match form {
            Form::Markdown => "# ",
            _ => "",
        }
        .to_owned();
        text += &format!(
            "Scouting: {hold} of {} claims of Folsom et al. 2021 hold on {} worlds\n\n",
            self.claims.len(),
            self.runs
        );
        text += &table(
            form,
            ["arm", "stuck", "median, Sol", "SD, Sol", "median saving", "mean paired saving"],
            &self.rows.iter().map(Row::cells).collect::<Vec<_>>(),
        );
        text += "\n";
        text += &table(
            form,
            ["claim", "paper", "band, 100 runs", "ours", "verdict"],
            &self.claims.iter().map(Claim::cells).collect::<Vec<_>>(),
        );
        Ok(text)
    }
}

impl Row {
    fn cells(&self) -> [String; 6] {
        [
            self.arm.name().to_owned(),
            self.stuck.to_string(),
            format!("{:.3}", self.median_sol),
            format!("{:.3}", self.sd_sol),
            percent(self.median_saving),
            percent(self.mean_paired_saving),
        ]
    }
}

/// A share with its 95 % interval, in percent.
fn percent(spread: Spread) -> String {
    format!("{:.1} % ({:.1} to {:.1})", 100.0 * spread.value, 100.0 * spread.low, 100.0 * spread.high)
}
