//! The single-agent study of P21: information gathered on the way across a small grid (Figs 5, 14 and 15).

use ::report::picture::{Chart, Curves, FieldMap, Line, Way};
use ::scouting::{CellType, Choice, GRID_SIDE, SingleGrid, Spread, simple_paths};
use node::{Exit, Failure};
use rayon::prelude::*;
use serde::Serialize;

use super::claims::{Claim, Verdict};
use super::report::{Publication, Report, number, percent};
use crate::form::{Form, table};

/// Arguments of the single-agent study.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// Random grids.
    #[arg(long, default_value_t = 400, value_name = "N", value_parser = clap::value_parser!(u64).range(2..=1_000_000))]
    runs: u64,
    /// Seed of the first grid; the following count up from it.
    #[arg(long, default_value_t = 1, value_name = "N")]
    seed: u64,
    #[command(flatten)]
    publication: Publication,
}

/// What one path of one grid came to.
#[derive(Clone, Debug)]
struct Trip {
    /// Share of all information after each cell.
    information: Vec<f64>,
    /// True time after each cell.
    times: Vec<f64>,
    expected: f64,
    /// Types of cells seen.
    types: usize,
    /// True time of a second agent that knows what this one has seen.
    follower: f64,
}

impl Trip {
    fn new(grid: &SingleGrid, paths: &[Vec<usize>], choice: Choice) -> Self {
        let path = grid.best(paths, choice);
        let known = grid.known(path);
        let times = (1..=path.len()).map(|cells| grid.time(&path[..cells], CellType::true_time));
        Self {
            information: grid.information(path),
            times: times.collect(),
            expected: grid.time(path, CellType::expected),
            types: known.iter().filter(|known| **known).count(),
            follower: grid.time(grid.follower(paths, &known), CellType::true_time),
        }
    }

    fn share(&self) -> f64 {
        self.information[self.information.len() - 1]
    }

    /// What is known after `cells` cells.
    fn after(&self, cells: usize) -> f64 {
        self.information[cells.min(self.information.len()) - 1]
    }

    fn time(&self) -> f64 {
        self.times[self.times.len() - 1]
    }

    /// What is known at a true time.
    fn at(&self, time: f64) -> f64 {
        let cells = self.times.partition_point(|done| *done <= time);
        if cells == 0 { 0.0 } else { self.after(cells) }
    }
}

/// What one way of choosing came to; field names are those of the JSON.
#[derive(Clone, Debug, Serialize)]
struct Row {
    choice: Choice,
    /// Share of all information that the path gains.
    information: Spread,
    /// The same of its first five cells, less than half of the shortest path.
    early: Spread,
    /// Types of cells that it visits.
    types: Spread,
    /// How much longer it takes than the path of least expected time: as expected, and in truth.
    more_expected: Spread,
    more_true: Spread,
    /// How much sooner than the path of least expected time a second agent arrives, which knows what the first has seen.
    follower_saving: Spread,
}

/// Cells whose information counts as early.
const EARLY: usize = 5;

/// The whole study; field names are those of the JSON.
#[derive(Clone, Debug, Serialize)]
struct Account {
    runs: u64,
    seed: u64,
    paths: usize,
    rows: Vec<Row>,
    claims: Vec<Claim>,
    #[serde(skip)]
    trips: Vec<[Trip; 3]>,
}

/// Weighs every path of every grid, and prints the report.
///
/// # Errors
/// Exit code 2 if the folder for the figures cannot be created, 1 if the report cannot be printed or written.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let paths = simple_paths();
    let trips: Vec<[Trip; 3]> = (0..args.runs)
        .into_par_iter()
        .map(|run| {
            let grid = SingleGrid::random(args.seed.wrapping_add(run));
            Choice::ALL.map(|choice| Trip::new(&grid, &paths, choice))
        })
        .collect();
    let rows: Vec<Row> = Choice::ALL.into_iter().map(|choice| row(&trips, choice)).collect();
    let claims = judge(&trips, &rows);
    let account = Account { runs: args.runs, seed: args.seed, paths: paths.len(), rows, claims, trips };
    args.publication.publish(&account)
}

/// The mean over all grids of what `measure` finds in a grid's trips.
fn mean(trips: &[[Trip; 3]], measure: impl Fn(&[Trip; 3]) -> f64) -> Spread {
    Spread::mean(&trips.iter().map(measure).collect::<Vec<_>>())
}

fn row(trips: &[[Trip; 3]], choice: Choice) -> Row {
    let (own, fastest) = (choice as usize, Choice::ExpectedTime as usize);
    Row {
        choice,
        information: mean(trips, |trips| trips[own].share()),
        early: mean(trips, |trips| trips[own].after(EARLY)),
        types: mean(trips, |trips| trips[own].types as f64),
        more_expected: mean(trips, |trips| trips[own].expected / trips[fastest].expected - 1.0),
        more_true: mean(trips, |trips| trips[own].time() / trips[fastest].time() - 1.0),
        follower_saving: mean(trips, |trips| 1.0 - trips[own].follower / trips[fastest].time()),
    }
}

fn judge(trips: &[[Trip; 3]], rows: &[Row]) -> Vec<Claim> {
    let [utility, fastest, likeliest] = Choice::ALL.map(|choice| choice as usize);
    let more = |other: usize| mean(trips, |trips| trips[utility].share() - trips[other].share());
    let sooner = |other: usize| mean(trips, |trips| trips[utility].after(EARLY) - trips[other].after(EARLY));
    let most_types = mean(trips, |trips| {
        f64::from(trips[utility].types >= trips[fastest].types.max(trips[likeliest].types))
    });
    let followers = mean(trips, |trips| 1.0 - trips[utility].follower / trips[fastest].follower);
    let above_0 = |spread| Verdict::within(spread, 0.0, f64::INFINITY);
    let both = |a: Verdict, b: Verdict| if a == b { a } else { Verdict::Open };
    let pair = |a: Spread, b: Spread| format!("{} and {}", number(a, 2), number(b, 2));
    vec![
        Claim::new(
            "the path of greatest utility gains more information than the other two (Fig. 14)",
            "yes",
            "both differences in the share of all information are above 0",
            pair(more(fastest), more(likeliest)),
            both(above_0(more(fastest)), above_0(more(likeliest))),
        ),
        Claim::new(
            "it gains it earlier (Fig. 14)",
            "yes",
            "the same after five cells",
            pair(sooner(fastest), sooner(likeliest)),
            both(above_0(sooner(fastest)), above_0(sooner(likeliest))),
        ),
        Claim::new(
            "it does so without sacrificing travel time (Fig. 15)",
            "yes",
            "its true time is at most 1 % above that of the path of least expected time",
            percent(rows[utility].more_true),
            Verdict::within(rows[utility].more_true, f64::NEG_INFINITY, 0.01),
        ),
        Claim::new(
            "its true time is not substantially above the least expected time",
            "yes",
            "at most 10 %",
            percent(rows[utility].more_true),
            Verdict::within(rows[utility].more_true, f64::NEG_INFINITY, 0.1),
        ),
        Claim::new(
            "most information is gained by visiting most types of cells (Fig. 5)",
            "yes",
            "in most grids no other path visits more",
            percent(most_types),
            Verdict::within(most_types, 0.5, 1.0),
        ),
        Claim::new(
            "later agents can make use of what the first has learned",
            "yes",
            "after a first one with the utility function a second one arrives sooner than after the fastest",
            percent(followers),
            above_0(followers),
        ),
        Claim::new(
            "the numbers of Figs 5, 14 and 15",
            "figures",
            "the paper does not define its grids",
            String::new(),
            Verdict::NotToBeHad,
        ),
    ]
}

impl Report for Account {
    const NAME: &'static str = "scouting-single";

    fn title(&self) -> String {
        format!("A single agent on {} random grids, {} paths each", self.runs, self.paths)
    }

    fn tables(&self, form: Form) -> String {
        let cells = |row: &Row| {
            [
                row.choice.name().to_owned(),
                number(row.information, 2),
                number(row.early, 2),
                number(row.types, 1),
                percent(row.more_expected),
                percent(row.more_true),
                percent(row.follower_saving),
            ]
        };
        let headings = [
            "path",
            "share of information",
            "after 5 cells",
            "types seen",
            "more expected time",
            "more true time",
            "saved by a second agent",
        ];
        table(form, headings, &self.rows.iter().map(cells).collect::<Vec<_>>()) + "\n"
    }

    fn claims(&self) -> &[Claim] {
        &self.claims
    }

    fn figures(&self) -> Vec<(String, String)> {
        vec![
            ("fig-5.svg".into(), self.grid()),
            ("fig-14.svg".into(), self.over_cells()),
            ("fig-15.svg".into(), self.over_time()),
        ]
    }
}

impl Account {
    /// The first grid with its three paths.
    fn grid(&self) -> String {
        let (grid, paths) = (SingleGrid::random(self.seed), simple_paths());
        let way = |choice: Choice| {
            let at = |cell: &usize| {
                // Beside each other where they share cells.
                let aside = 0.14 * (choice as usize as f64 - 1.0);
                [(cell % GRID_SIDE) as f64 + 0.5 + aside, (cell / GRID_SIDE) as f64 + 0.5 + aside]
            };
            Way { name: short(choice).into(), points: grid.best(&paths, choice).iter().map(at).collect() }
        };
        FieldMap {
            title: "Three paths across a grid".into(),
            caption: format!("Grid of seed {}; cells of one shade are of one type", self.seed),
            quantity: "information of the cell's type".into(),
            columns: GRID_SIDE,
            cell_m: 1.0,
            values: grid.type_of.iter().map(|of| grid.types[*of].information()).collect(),
            ways: Choice::ALL.map(way).into(),
        }
        .svg()
    }

    fn curves(&self, axis: &str, at: Vec<f64>, share: impl Fn(&Trip, f64) -> f64) -> String {
        let line = |choice: Choice| Line {
            name: short(choice).into(),
            values: at
                .iter()
                .map(|at| Some(mean(&self.trips, |trips| share(&trips[choice as usize], *at)).value))
                .collect(),
        };
        let chart =
            Chart { quantity: "share of all information".into(), lines: Choice::ALL.map(line).into() };
        Curves {
            title: "Information gained on the way".into(),
            caption: format!("Means of {} random grids; the paper shows one grid", self.runs),
            axis: axis.into(),
            charts: vec![chart],
            at,
        }
        .svg()
    }

    fn over_cells(&self) -> String {
        let cells = (1..=GRID_SIDE * GRID_SIDE).map(|cells| cells as f64).collect();
        self.curves("cells visited", cells, |trip, cells| trip.after(cells as usize))
    }

    fn over_time(&self) -> String {
        let times = (0..=40).map(f64::from).collect();
        self.curves("true travel time", times, Trip::at)
    }
}

/// The names at the foot of a figure have little room.
fn short(choice: Choice) -> &'static str {
    match choice {
        Choice::Utility => "utility",
        Choice::ExpectedTime => "expected time",
        Choice::Likeliest => "max P(T)",
    }
}
