//! `hopper known plan`: prints one plan as text or data, and draws it.

use std::path::PathBuf;

use contract::{Cell, Direction};
use hopper::files::write_into;
use hopper::stdout::print;
use node::{Exit, Failure};
use p22::{Experiment, Hop, KnownMap, Model, P22, Plan, Weights, figure};
use serde::Serialize;

use crate::form::{Form, heading, table};

/// Arguments of `hopper known plan`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// World to plan on: hard, heterogeneous, sandy or rocks.
    #[arg(value_name = "EXPERIMENT")]
    experiment: Experiment,
    /// Weight of safety, 0 to 1; that of information gain is the rest.
    #[arg(long, default_value_t = 0.5, value_name = "WEIGHT", allow_negative_numbers = true)]
    w1: f64,
    /// Payoff of the goal.
    #[arg(long, default_value_t = Weights::GOAL, value_name = "PAYOFF", allow_negative_numbers = true)]
    goal: f64,
    /// Write the picture and the plan as data into this folder.
    #[arg(long, value_name = "DIR", value_parser = node::output_path())]
    out: Option<PathBuf>,
    /// Format of the answer on standard output.
    #[arg(long, default_value_t)]
    format: Form,
}

/// The plan; field names are those of the JSON.
#[derive(Debug, Serialize)]
struct Account<'a> {
    experiment: Experiment,
    weights: Weights,
    arrives: bool,
    path: &'a p22::Path,
    /// Number of sweeps of value iteration.
    sweeps: u32,
    /// Whether value iteration converged.
    settled: bool,
    /// Columns of the map, by which `policy` and `values` are laid out, southernmost row first.
    width: u32,
    /// Hop of every cell; `None` where no hop is possible.
    policy: Vec<Option<Hop>>,
    /// Value of every cell, laid out as `policy`.
    values: &'a [f64],
}

/// Prints the plan.
///
/// # Errors
/// Exit code 2 for weights out of range.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let weights = Weights::new(args.w1, args.goal).map_err(Failure::usage)?;
    let world = KnownMap::new(args.experiment, &P22);
    let model = Model::new(&world, &P22);
    let plan = Plan::new(&world, &model, &P22, weights);
    let policy = plan.solution.policy.iter();
    let account = Account {
        experiment: args.experiment,
        weights,
        arrives: plan.path.arrives(),
        path: &plan.path,
        sweeps: plan.solution.sweeps,
        settled: plan.solution.settled,
        width: world.grid.width,
        policy: policy.map(|choice| choice.map(|choice| model.choices[choice].hop)).collect(),
        values: &plan.solution.values,
    };
    let json = serde_json::to_string(&account).map_err(Failure::run)? + "\n";
    if let Some(dir) = &args.out {
        let svg = figure(&world, &model, &plan).map_err(Failure::run)?;
        write_into(dir, [("plan.svg".to_owned(), svg.as_str()), ("plan.json".to_owned(), json.as_str())])?;
    }
    print(&match args.format {
        Form::Json => json,
        form => account.written(form, &world),
    })?;
    Ok(Exit::Done)
}

impl Account<'_> {
    fn written(&self, form: Form, world: &KnownMap) -> String {
        let Weights { safety, information, goal } = self.weights;
        let title = format!(
            "{} ground, w = ({safety}, {information}), goal {goal}: {} after {} hops",
            self.experiment,
            match self.arrives {
                true => "the path arrives".to_owned(),
                false => format!("no path, it {}", self.path.ending),
            },
            self.path.hops.len()
        );
        let path = self.path;
        let hops = path.hops.iter().map(|hop| match hop {
            Hop::Forward(direction) => direction.to_string(),
            Hop::Up(direction) => format!("up, {direction}"),
        });
        let rows: Vec<_> = path
            .cells
            .iter()
            .zip(hops.chain(["-".to_owned()]))
            .zip(path.heights_m.iter().zip(&path.slopes))
            .map(|((cell, hop), (height_m, slope))| {
                [
                    cell.to_string(),
                    hop,
                    format!("{height_m:.3}"),
                    format!("{slope:.4}"),
                    self.value(world, *cell),
                ]
            })
            .collect();
        let mut text = heading(form, &title);
        text += &format!("Mean height {:.3} m, mean slope {:.4}.\n\n", path.mean_height_m, path.mean_slope);
        text += &table(form, ["cell", "hop", "height, m", "slope", "value"], &rows);
        text += &heading(form, "Policy, north up: n e s w at 45°, capitals vertical");
        let map = self.map();
        text + &if form == Form::Markdown { format!("```text\n{map}```\n") } else { map }
    }

    fn value(&self, world: &KnownMap, cell: Cell) -> String {
        world.grid.index(cell).map_or("-".into(), |index| format!("{:.2}", self.values[index]))
    }

    fn map(&self) -> String {
        let letter = |hop: &Option<Hop>| match hop {
            None => '.',
            Some(hop) => {
                let small = match hop.direction() {
                    Direction::North => 'n',
                    Direction::East => 'e',
                    Direction::South => 's',
                    Direction::West => 'w',
                };
                if hop.is_up() { small.to_ascii_uppercase() } else { small }
            }
        };
        let rows = self.policy.chunks(self.width as usize).rev();
        rows.map(|row| row.iter().map(letter).collect::<String>() + "\n").collect()
    }
}
