//! The Monte Carlo simulation of P21: four scenarios on random passages, and ours beside them (Figs 12 and 13).

use std::path::PathBuf;

use ::campaign::statistics::wilson;
use ::report::picture::{BoxOf, Boxes, FieldMap, Way};
use ::scouting::{Arm, Outcome, RoverPlanner, Samples, Setup, Spread, Study, announce, fly, monte_carlo};
use node::{Exit, Failure};
use rayon::prelude::*;
use serde::Serialize;

use super::claims::{Claim, Verdict};
use super::report::{Planner, Report, claims, number, percent, publish, title};
use crate::form::{Form, table};

/// Arguments of the Monte Carlo study.
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
    /// Write the figures and the report in all formats into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Format of the report.
    #[arg(long, default_value_t)]
    format: Form,
}

/// What one arm came to; field names are those of the JSON.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    pub arm: Arm,
    pub stuck: usize,
    pub without_route: usize,
    pub median_sol: f64,
    pub sd_sol: f64,
    /// Against the safe rover.
    pub median_saving: Spread,
    pub mean_paired_saving: Spread,
    /// Time beyond that of the rover that knows the truth, where both arrive.
    pub regret_sol: Spread,
    /// Share of the safe rover's regret that is gone.
    pub regret_closed: Spread,
}

/// The rows of all arms.
pub fn rows(studies: &[Study; Arm::ALL.len()]) -> Vec<Row> {
    let (safe, knowing) = (&studies[Arm::SafeRover as usize], &studies[Arm::Clairvoyant as usize]);
    let row = |(arm, study): (Arm, &Study)| Row {
        arm,
        stuck: study.stuck(),
        without_route: study.without_route(),
        median_sol: study.median_sol(),
        sd_sol: study.sd_sol(),
        median_saving: study.median_saving(safe),
        mean_paired_saving: study.mean_paired_saving(safe),
        regret_sol: study.regret_sol(knowing),
        regret_closed: study.regret_closed(safe, knowing),
    };
    Arm::ALL.into_iter().zip(studies).map(row).collect()
}

/// The table of all arms.
pub fn table_of_arms(form: Form, rows: &[Row]) -> String {
    let cells = |row: &Row| {
        let against = row.arm != Arm::SafeRover;
        let empty_or = |text: String| if against { text } else { String::new() };
        let closed = against && row.arm != Arm::Clairvoyant;
        [
            row.arm.name().to_owned(),
            row.stuck.to_string(),
            format!("{:.3}", row.median_sol),
            format!("{:.3}", row.sd_sol),
            empty_or(percent(row.median_saving)),
            empty_or(percent(row.mean_paired_saving)),
            if row.arm == Arm::Clairvoyant { String::new() } else { number(row.regret_sol, 3) },
            if closed { percent(row.regret_closed) } else { String::new() },
        ]
    };
    let headings = [
        "arm",
        "stuck",
        "median, Sol",
        "SD, Sol",
        "median saving",
        "mean paired saving",
        "regret, Sol",
        "regret closed",
    ];
    table(form, headings, &rows.iter().map(cells).collect::<Vec<_>>())
}

/// Box plot of the travel times of those that arrived, one box an arm.
pub fn boxes(title: &str, caption: String, studies: &[Study; Arm::ALL.len()]) -> String {
    let name = |arm: Arm| match arm {
        Arm::NaiveRover => vec!["naive rover".into()],
        Arm::SafeRover => vec!["safe rover".into()],
        Arm::ScoutRoute => vec!["with naive".into(), "helicopter".into()],
        Arm::InformationTheoretic => vec!["with information-".into(), "theoretic h.".into()],
        Arm::ScoutValue => vec!["with scout_value".into()],
        Arm::Clairvoyant => vec!["knowing".into(), "the truth".into()],
    };
    let boxes = Arm::ALL.into_iter().zip(studies);
    Boxes {
        title: title.into(),
        caption,
        quantity: "true travel time [Sol]".into(),
        boxes: boxes.map(|(arm, study)| BoxOf { name: name(arm), values: study.times_sol() }).collect(),
    }
    .svg()
}

/// `scout_value` beside the information-theoretic helicopter, world by world.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Duel {
    /// How much more of the safe rover's time is saved.
    pub more_saved: Spread,
    /// Worlds in which the rover arrives sooner.
    pub sooner: usize,
    /// Worlds in which it arrives later.
    pub later: usize,
}

impl Duel {
    /// The comparison of two arms of a study.
    pub fn new(studies: &[Study; Arm::ALL.len()]) -> Self {
        let [ours, theirs] = [Arm::ScoutValue, Arm::InformationTheoretic].map(|arm| &studies[arm as usize]);
        let pairs = ours.outcomes.iter().zip(&theirs.outcomes);
        let times = pairs.filter_map(|(ours, theirs)| Some((ours.travel_sol?, theirs.travel_sol?)));
        let (mut sooner, mut later) = (0, 0);
        for (ours, theirs) in times {
            sooner += usize::from(ours < theirs);
            later += usize::from(ours > theirs);
        }
        let more_saved = ours.more_saved(theirs, &studies[Arm::SafeRover as usize]);
        Self { more_saved, sooner, later }
    }

    /// In words.
    pub fn written(&self) -> String {
        format!(
            "scout_value saves {} more of the safe rover's time than the information-theoretic helicopter; \
             the rover arrives sooner in {} worlds, later in {}\n\n",
            percent(self.more_saved),
            self.sooner,
            self.later
        )
    }
}

/// The whole study; field names are those of the JSON.
#[derive(Clone, Debug, Serialize)]
struct Account {
    runs: u64,
    seed: u64,
    rover: RoverPlanner,
    samples: Samples,
    rows: Vec<Row>,
    ours_against_theirs: Duel,
    claims: Vec<Claim>,
    #[serde(skip)]
    studies: [Study; Arm::ALL.len()],
}

/// Flies the study and prints its report.
///
/// # Errors
/// Exit code 2 if the folder for the figures cannot be created, 1 if the report cannot be printed or written.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let setup = Setup::new(args.rover.into(), Samples::MONTE_CARLO);
    let worlds: Vec<[Outcome; Arm::ALL.len()]> = (0..args.runs)
        .into_par_iter()
        .map(|run| {
            let seed = args.seed.wrapping_add(run);
            let world = monte_carlo(seed);
            let announced = announce(&world, &setup, seed);
            Arm::ALL.map(|arm| fly(&world, arm, &setup, seed, announced.as_ref()))
        })
        .collect();
    let studies = Study::of_arms(&worlds);
    let rows = rows(&studies);
    let account = Account {
        runs: args.runs,
        seed: args.seed,
        rover: setup.planner,
        samples: setup.samples,
        claims: judge(args.runs, &rows),
        ours_against_theirs: Duel::new(&studies),
        rows,
        studies,
    };
    publish(&account, args.format, args.out.as_deref())?;
    Ok(Exit::Done)
}

impl Report for Account {
    const NAME: &'static str = "scouting";

    fn written(&self, form: Form) -> String {
        let study = format!("Scouting on {} random worlds", self.runs);
        let mut text = title(form, &study, &self.claims);
        text += &table_of_arms(form, &self.rows);
        text += "\n";
        text += &self.ours_against_theirs.written();
        text += &claims(form, &self.claims);
        text
    }

    fn figures(&self) -> Vec<(String, String)> {
        let caption = format!("{} random worlds; rovers that are stuck are left out", self.runs);
        let twelve = boxes("Travel times with and without a helicopter", caption, &self.studies);
        vec![("fig-12.svg".into(), twelve), ("fig-13.svg".into(), self.region())]
    }
}

impl Account {
    /// The first world: how uncertain it is, and who went where.
    fn region(&self) -> String {
        let world = monte_carlo(self.seed);
        let [safe, informed] =
            [Arm::SafeRover, Arm::InformationTheoretic].map(|arm| &self.studies[arm as usize].outcomes[0]);
        let way = |name: &str, points: &[rover::Point]| Way {
            name: name.into(),
            points: points.iter().map(|at| [at.x_m, at.y_m]).collect(),
        };
        FieldMap {
            title: "The region of the Monte Carlo simulation".into(),
            caption: format!("World of seed {}; the discs are impassable", self.seed),
            quantity: "standard deviation of the speed [m/Sol]".into(),
            columns: world.prior.surface().lattice().width(),
            cell_m: 1.0,
            values: super::figures::spread(&world.prior),
            ways: vec![
                way("safe rover", &safe.route),
                way("with helicopter", &informed.route),
                way("its flight", &informed.flight),
            ],
        }
        .svg()
    }
}

/// Judges each claim by the rows of all arms.
// Long: a claim after the other.
fn judge(runs: u64, rows: &[Row]) -> Vec<Claim> {
    let row = |arm: Arm| &rows[arm as usize];
    let (naive, safe) = (row(Arm::NaiveRover), row(Arm::SafeRover));
    let (along, informed) = (row(Arm::ScoutRoute), row(Arm::InformationTheoretic));
    let stuck = naive.stuck as f64 / runs as f64;
    let interval = wilson(naive.stuck as u64, runs);
    let lost = |row: &Row| row.stuck + row.without_route;
    let others = [safe, along, informed].map(lost);
    let saving = informed.median_saving;
    let slight = along.median_saving;
    let of_the_paper = [naive, safe, along, informed];
    let sds = of_the_paper.map(|row| format!("{:.3}", row.sd_sol));
    let medians = of_the_paper.map(|row| format!("{:.3}", row.median_sol));
    let others_sd = [naive, safe, along].map(|row| row.sd_sol);
    let safe_medians = [safe, along].map(|row| row.median_sol);
    let order = "naive, safe, naive helicopter, information-theoretic";
    let claim = |claim: &str, paper: &str, holds_if: &str, ours: String, holds: bool| {
        Claim::new(claim, paper, holds_if, ours, Verdict::of(holds))
    };
    vec![
        claim(
            "the naive rover gets stuck",
            "21 %",
            "13 to 29 % (of 100 runs)",
            percent(Spread { value: stuck, low: interval.low, high: interval.high }),
            (0.13..=0.29).contains(&stuck),
        ),
        claim(
            "the other three never do",
            "0",
            "0",
            others.map(|lost| lost.to_string()).join(", "),
            others == [0; 3],
        ),
        claim(
            "the information-theoretic helicopter saves median travel time",
            "about 10 %",
            "4 to 16 % (of 100 runs)",
            percent(saving),
            (0.04..=0.16).contains(&saving.value),
        ),
        claim(
            &format!("it has the lowest SD of travel time ({order}; Sol)"),
            "yes",
            "",
            sds.join(", "),
            others_sd.iter().all(|sd| informed.sd_sol < *sd),
        ),
        claim(
            "the naive helicopter gains slightly",
            "yes",
            "above 0, below that of the information-theoretic helicopter",
            percent(slight),
            slight.value > 0.0 && slight.value < saving.value,
        ),
        claim(
            "the information-theoretic helicopter has a lower median than the other two safe rovers",
            "yes",
            "",
            medians[1..].join(", "),
            safe_medians.iter().all(|median| informed.median_sol < *median),
        ),
        claim(
            &format!("it has the lowest median of all four ({order}; Sol)"),
            "yes",
            "",
            medians.join(", "),
            safe_medians.iter().chain([&naive.median_sol]).all(|median| informed.median_sol < *median),
        ),
    ]
}
