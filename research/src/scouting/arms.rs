//! What the studies share that fly every arm on the same worlds.

use ::report::picture::{BoxOf, Boxes};
use ::scouting::{Arm, Outcome, RoverPlanner, Samples, Sensor, Setup, Spread, Study, World, announce, fly};
use rayon::prelude::*;
use serde::Serialize;

use super::report::{number, percent};
use crate::form::{Form, table};

/// Planners of the safe rover, by their names.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq, Default)]
#[value(rename_all = "snake_case")]
pub enum Planner {
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

impl From<Planner> for RoverPlanner {
    fn from(planner: Planner) -> Self {
        match planner {
            Planner::RrtStarEtt => RoverPlanner::RrtStarEtt,
            Planner::EttExact => RoverPlanner::EttExact,
        }
    }
}

/// Who drives and what the helicopter sees with, in all arms.
#[derive(clap::Args, Clone, Copy, Debug)]
pub struct Team {
    /// Planner of the safe rover in all arms.
    #[arg(long, default_value_t, value_name = "PLANNER")]
    rover: Planner,
    /// Probability that the helicopter reads a cell's speed right; the others are equally likely [default: 1].
    #[arg(long, value_name = "P", value_parser = probability)]
    accuracy: Option<f64>,
    /// Flights at most, each before a drive of a Sol; the last drive is as long as it takes.
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=20))]
    stages: u32,
}

/// A number from 0 to 1.
pub fn probability(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|error| format!("{error}"))?;
    if (0.0..=1.0).contains(&number) { Ok(number) } else { Err("a probability needs 0 to 1".into()) }
}

/// What all missions of a study were flown with; field names are those of the JSON.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Conditions {
    pub runs: u64,
    pub seed: u64,
    /// Flights at most.
    pub stages: u32,
    rover: RoverPlanner,
    samples: Samples,
    /// Nothing where the helicopter does not err.
    #[serde(skip_serializing_if = "Option::is_none")]
    accuracy: Option<f64>,
}

/// What all arms came to; field names are those of the JSON.
#[derive(Clone, Debug, Serialize)]
pub struct Arms {
    #[serde(flatten)]
    pub conditions: Conditions,
    pub rows: Vec<Row>,
    ours_against_theirs: Comparison,
    #[serde(skip)]
    pub studies: [Study; Arm::ALL.len()],
}

impl Team {
    /// Flies all arms on `runs` worlds, those of `seed` and the following.
    pub fn fly(
        self,
        (runs, seed): (u64, u64),
        samples: Samples,
        world: impl Fn(u64) -> World + Sync,
    ) -> Arms {
        let sensor = self.accuracy.map(|p| Sensor::with_accuracy(p).expect("a probability"));
        let stages = self.stages;
        let setup = Setup { stages, ..Setup::new(self.rover.into(), samples) };
        let worlds: Vec<[Outcome; Arm::ALL.len()]> = (0..runs)
            .into_par_iter()
            .map(|run| {
                let seed = seed.wrapping_add(run);
                let world = world(seed);
                let setup = Setup { sensor: sensor.map(|sensor| (sensor, seed)), ..setup };
                let announced = announce(&world, &setup, seed);
                Arm::ALL.map(|arm| fly(&world, arm, &setup, seed, announced.as_ref()))
            })
            .collect();
        let studies = Study::of_arms(&worlds);
        let rover = setup.planner;
        Arms {
            conditions: Conditions { runs, seed, stages, rover, samples, accuracy: self.accuracy },
            rows: rows(&studies),
            ours_against_theirs: Comparison::new(&studies),
            studies,
        }
    }
}

impl Conditions {
    /// What a title says of the stages.
    pub fn of_stages(&self) -> String {
        match self.stages {
            1 => "one stage".into(),
            stages => format!("up to {stages} stages"),
        }
    }

    /// What a title adds where the helicopter errs.
    pub fn of_sensor(&self) -> String {
        let right = |accuracy: f64| format!(", {} % of the helicopter's readings right", 100.0 * accuracy);
        self.accuracy.map_or(String::new(), right)
    }
}

impl Arms {
    /// What an arm came to.
    pub fn row(&self, arm: Arm) -> &Row {
        &self.rows[arm as usize]
    }

    /// What became of the missions of an arm, in the order of the worlds.
    pub fn outcomes(&self, arm: Arm) -> &[Outcome] {
        &self.studies[arm as usize].outcomes
    }

    /// The table of all arms, and ours beside the paper's.
    pub fn written(&self, form: Form) -> String {
        table_of_arms(form, &self.rows) + "\n" + &self.ours_against_theirs.written()
    }

    /// Box plot of the travel times of those that arrived, one box an arm.
    pub fn boxes(&self, title: &str, caption: String) -> String {
        boxes(title, caption, &self.studies)
    }
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

fn rows(studies: &[Study; Arm::ALL.len()]) -> Vec<Row> {
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

fn table_of_arms(form: Form, rows: &[Row]) -> String {
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

fn boxes(title: &str, caption: String, studies: &[Study; Arm::ALL.len()]) -> String {
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
pub struct Comparison {
    /// How much more of the safe rover's time is saved.
    pub more_saved: Spread,
    /// Worlds in which the rover arrives sooner.
    pub sooner: usize,
    /// Worlds in which it arrives later.
    pub later: usize,
}

impl Comparison {
    fn new(studies: &[Study; Arm::ALL.len()]) -> Self {
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
    fn written(&self) -> String {
        format!(
            "scout_value saves {} more of the safe rover's time than the information-theoretic helicopter; \
             the rover arrives sooner in {} worlds, later in {}\n\n",
            percent(self.more_saved),
            self.sooner,
            self.later
        )
    }
}
