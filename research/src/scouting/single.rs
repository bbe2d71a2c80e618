//! The single-agent study of P21: information gathered on the way across a small grid (Figs 5, 14 and 15).

use ::report::picture::{Chart, Curves, FieldMap, Line, Way};
use node::{Exit, Failure};
use p21::{CellType, Choice, GRID_SIDE, SingleGrid, Spread};
use serde::Serialize;

use super::FOLSOM;
use crate::claims::{Claim, Verdict};
use crate::form::{Form, table};
use crate::report::{Publication, Report, cells_of, headings_of, number, percent};
use crate::reported::Reported;
use crate::studies::single::{Single, Trip, Trips};
use crate::studies::{Flown as _, FlownWorld, fly_all, plan};

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
    settings: Single,
    #[command(flatten)]
    publication: Publication,
}

/// What is known on the way, after each cell of a path: worked out again from grid and path.
struct Progress {
    /// Share of all information.
    information: Vec<f64>,
    /// True time.
    times: Vec<f64>,
}

impl Progress {
    fn new(grid: &SingleGrid, trip: &Trip) -> Self {
        let path = trip.cells().expect("a path that was checked");
        let times = (1..=path.len()).map(|cells| grid.time(&path[..cells], CellType::true_time));
        Self { information: grid.information(&path), times: times.collect() }
    }

    /// What is known after `cells` cells.
    fn after(&self, cells: usize) -> f64 {
        self.information[cells.min(self.information.len()) - 1]
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
    /// Share of all information that the first five cells of the path gain, less than half of the
    /// shortest path.
    early: Spread,
    /// Types of cells that it visits.
    types: Spread,
    /// How much longer it takes than the path of least expected time: as expected, and in truth.
    more_expected: Spread,
    more_true: Spread,
    /// How much sooner than the path of least expected time a second agent arrives, which knows what the first has seen.
    follower_saving: Spread,
}

/// The path of greatest utility if the error of eq. 9 is adapted on the way; field names are those of the JSON.
#[derive(Clone, Copy, Debug, Serialize)]
struct Adapting {
    /// Share of the grids in which it is another path.
    differs: Spread,
    /// Share of all information that it gains.
    information: Spread,
    /// How much longer it takes in truth than the path of least expected time.
    more_true: Spread,
}

impl Adapting {
    fn new(seeds: &[u64], paths: &[Vec<usize>], trips: &[Trips]) -> Self {
        let (utility, fastest) = (Choice::Utility as usize, Choice::ExpectedTime as usize);
        let of_grid = |(seed, trips): (&u64, &Trips)| {
            let grid = SingleGrid::random(*seed);
            let path = grid.best_adapting(paths);
            let information = grid.information(path);
            let time = grid.time(path, CellType::true_time);
            [
                f64::from(trips.choices[utility].cells().expect("a path that was checked") != path),
                information[information.len() - 1],
                time / trips.choices[fastest].true_time - 1.0,
            ]
        };
        let grids: Vec<[f64; 3]> = seeds.iter().zip(trips).map(of_grid).collect();
        let [differs, information, more_true] =
            [0, 1, 2].map(|n| Spread::mean(&grids.iter().map(|grid| grid[n]).collect::<Vec<_>>()));
        Self { differs, information, more_true }
    }

    fn written(&self) -> String {
        let Self { differs, information, more_true } = self;
        format!(
            "with ε halved at each further cell of a type: another path in {} of the grids, share of information {}, more true \
             time {}\n\n",
            percent(*differs),
            number(*information, 2),
            percent(*more_true)
        )
    }
}

/// The whole study; field names are those of the JSON.
#[derive(Clone, Debug, Serialize)]
pub struct Account {
    runs: u64,
    seed: u64,
    paths: usize,
    rows: Vec<Row>,
    adapting: Adapting,
    claims: Vec<Claim>,
    #[serde(skip)]
    trips: Vec<Trips>,
    /// Seeds of the grids, in the order of the trips.
    #[serde(skip)]
    seeds: Vec<u64>,
}

/// Weighs every path of every grid, and prints the report.
///
/// # Errors
/// Exit code 2 if the folder for the figures cannot be created, 1 if the report cannot be printed or written.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let worlds = fly_all(&plan(args.settings, args.seed, args.runs))?;
    args.publication.publish(&args.settings.report(args.seed, &worlds))
}

impl Account {
    /// What the grids come to, in a campaign of seed `seed`.
    pub fn new(seed: u64, worlds: &[FlownWorld<Single>]) -> Self {
        let trips: Vec<Trips> = worlds.iter().map(|world| world.outcomes[0].clone()).collect();
        let rows: Vec<Row> = Choice::ALL.into_iter().map(|choice| row(&trips, choice)).collect();
        let paths = Single {}.ground();
        let seeds: Vec<u64> = worlds.iter().map(|world| world.seed).collect();
        let claims = judge(&trips, &rows, &most_types(&seeds, &paths));
        Self {
            runs: worlds.len() as u64,
            seed,
            paths: paths.len(),
            adapting: Adapting::new(&seeds, &paths, &trips),
            rows,
            claims,
            trips,
            seeds,
        }
    }
}

/// The most types of cells that any of all paths visits, by grid.
fn most_types(seeds: &[u64], paths: &[Vec<usize>]) -> Vec<usize> {
    let most = |seed: &u64| {
        let grid = SingleGrid::random(*seed);
        let types = |path: &Vec<usize>| grid.known(path).iter().filter(|known| **known).count();
        paths.iter().map(types).max().unwrap_or_default()
    };
    seeds.iter().map(most).collect()
}

/// The mean over all grids of what `measure` finds in a grid's trips.
fn mean(trips: &[Trips], measure: impl Fn(&[Trip; 3]) -> f64) -> Spread {
    Spread::mean(&trips.iter().map(|trips| measure(&trips.choices)).collect::<Vec<_>>())
}

fn row(trips: &[Trips], choice: Choice) -> Row {
    let (own, fastest) = (choice as usize, Choice::ExpectedTime as usize);
    Row {
        choice,
        information: mean(trips, |trips| trips[own].information),
        early: mean(trips, |trips| trips[own].early),
        types: mean(trips, |trips| trips[own].types as f64),
        more_expected: mean(trips, |trips| trips[own].expected_time / trips[fastest].expected_time - 1.0),
        more_true: mean(trips, |trips| trips[own].true_time / trips[fastest].true_time - 1.0),
        follower_saving: mean(trips, |trips| 1.0 - trips[own].follower_time / trips[fastest].true_time),
    }
}

fn judge(trips: &[Trips], rows: &[Row], most_types: &[usize]) -> Vec<Claim> {
    let [utility, fastest, likeliest] = Choice::ALL.map(|choice| choice as usize);
    let more = |other: usize| mean(trips, |trips| trips[utility].information - trips[other].information);
    let sooner = |other: usize| mean(trips, |trips| trips[utility].early - trips[other].early);
    let visited = trips.iter().zip(most_types);
    let visited = visited.map(|(trips, most)| f64::from(trips.choices[utility].types == *most));
    let most_types = Spread::mean(&visited.collect::<Vec<_>>());
    let followers = mean(trips, |trips| 1.0 - trips[utility].follower_time / trips[fastest].follower_time);
    let above_0 = |spread| Verdict::above(spread, 0.0);
    let pair = |a: Spread, b: Spread| format!("{} and {}", number(a, 2), number(b, 2));
    vec![
        Claim::new(
            "the path of greatest utility gains more information than the other two (Fig. 14)",
            "yes",
            "both differences in the share of all information are above 0",
            pair(more(fastest), more(likeliest)),
            Verdict::all([above_0(more(fastest)), above_0(more(likeliest))]),
        ),
        Claim::new(
            "it gains it earlier (Fig. 14)",
            "yes",
            "the same after five cells",
            pair(sooner(fastest), sooner(likeliest)),
            Verdict::all([above_0(sooner(fastest)), above_0(sooner(likeliest))]),
        ),
        Claim::new(
            "it does so without sacrificing travel time (Fig. 15)",
            "yes",
            "its true time is at most 1 % above that of the path of least expected time",
            percent(rows[utility].more_true),
            Verdict::below(rows[utility].more_true, 0.01),
        ),
        Claim::new(
            "its true time is not substantially above the least expected time",
            "yes",
            "at most 10 %",
            percent(rows[utility].more_true),
            Verdict::below(rows[utility].more_true, 0.1),
        ),
        Claim::new(
            "most information is gained by visiting most types of cells (Fig. 5)",
            "yes",
            "in most grids none of all paths visits more types than the one of greatest utility",
            percent(most_types),
            Verdict::above(most_types, 0.5),
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
    const PAPER: &'static str = FOLSOM;

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
        let rows: Vec<_> = self.rows.iter().map(cells).collect();
        table(form, headings, &rows) + "\n" + &self.adapting.written()
    }

    fn records(&self) -> Vec<Vec<String>> {
        let spreads = ["information", "early", "types", "more_expected", "more_true", "follower_saving"];
        let headings = ["choice", "runs"].map(String::from).into_iter();
        let record = |row: &Row| {
            let of = [row.information, row.early, row.types, row.more_expected, row.more_true];
            let own = [row.choice.key().to_owned(), self.runs.to_string()].into_iter();
            own.chain(of.into_iter().chain([row.follower_saving]).flat_map(cells_of)).collect()
        };
        let headings = headings.chain(spreads.into_iter().flat_map(headings_of)).collect();
        std::iter::once(headings).chain(self.rows.iter().map(record)).collect()
    }

    fn claims(&self) -> &[Claim] {
        &self.claims
    }

    fn figures(&self) -> Result<Vec<(String, String)>, Failure> {
        let seed = self.seeds.first().copied().unwrap_or(self.seed);
        Ok(vec![
            ("fig-14.svg".into(), self.over_cells()),
            ("fig-15.svg".into(), self.over_time()),
            ("fig-5.svg".into(), grid_with_paths(seed, &Single {}.ground())),
        ])
    }
}

/// A grid with its three paths.
pub fn grid_with_paths(seed: u64, paths: &[Vec<usize>]) -> String {
    let grid = SingleGrid::random(seed);
    let way = |choice: Choice| {
        let at = |cell: &usize| {
            // Beside each other where they share cells.
            let aside = 0.14 * (choice as usize as f64 - 1.0);
            [(cell % GRID_SIDE) as f64 + 0.5 + aside, (cell / GRID_SIDE) as f64 + 0.5 + aside]
        };
        Way { name: short(choice).into(), points: grid.best(paths, choice).iter().map(at).collect() }
    };
    FieldMap {
        title: "Three paths across a grid".into(),
        caption: format!("Grid of seed {seed}; cells of one shade are of one type"),
        quantity: "information of the cell's type".into(),
        columns: GRID_SIDE,
        cell_m: 1.0,
        values: grid.type_of.iter().map(|of| grid.types[*of].information()).collect(),
        ways: Choice::ALL.map(way).into(),
    }
    .svg()
}

impl Account {
    fn curves(&self, axis: &str, at: Vec<f64>, share: impl Fn(&Progress, f64) -> f64) -> String {
        let line = |choice: Choice| {
            let progress = self.trips.iter().zip(&self.seeds).map(|(trips, seed)| {
                Progress::new(&SingleGrid::random(*seed), &trips.choices[choice as usize])
            });
            let progress: Vec<Progress> = progress.collect();
            let mean = |at: &f64| {
                let shares: Vec<f64> = progress.iter().map(|progress| share(progress, *at)).collect();
                Some(Spread::mean(&shares).value)
            };
            Line { name: short(choice).into(), values: at.iter().map(mean).collect() }
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
        self.curves("cells visited", cells, |progress, cells| progress.after(cells as usize))
    }

    fn over_time(&self) -> String {
        let times = (0..=40).map(f64::from).collect();
        self.curves("true travel time", times, Progress::at)
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

impl Reported for Single {
    type Report = Account;

    fn pictures(
        &self,
        paths: &Vec<Vec<usize>>,
        _case: usize,
        seed: u64,
    ) -> Result<Vec<(String, String)>, Failure> {
        Ok(vec![("fig-5.svg".into(), grid_with_paths(seed, paths))])
    }

    fn report(&self, seed: u64, worlds: &[FlownWorld<Self>]) -> Account {
        Account::new(seed, worlds)
    }
}
