//! What the studies share that fly every arm on the same worlds.

use ::report::picture::{BoxOf, Boxes};
use p21::{Arm, ArmEndings, Ending, Samples, Spread};
use serde::Serialize;

use crate::form::{Form, table};
use crate::report::{cells_of, headings_of, number, percent};
use crate::studies::{Planner, is_0};

/// What all missions of a study were flown with; field names are those of the JSON.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Conditions {
    pub runs: u64,
    pub seed: u64,
    /// Flights at most.
    pub stages: u32,
    pub rover: Planner,
    pub samples: Samples,
    /// Nothing where the helicopter does not err.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<f64>,
    /// How far `ett_exact` keeps from forbidden cells where it can, metres.
    #[serde(skip_serializing_if = "is_0")]
    pub clearance_m: f64,
}

/// What all arms came to; field names are those of the JSON.
#[derive(Clone, Debug, Serialize)]
pub struct Arms {
    #[serde(flatten)]
    pub conditions: Conditions,
    pub rows: Vec<Row>,
    ours_against_theirs: Comparison,
    #[serde(skip)]
    pub endings: [ArmEndings; Arm::ALL.len()],
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

    /// What a title adds where routes keep a distance from forbidden cells.
    pub fn of_clearance(&self) -> String {
        let clear = |clearance_m: f64| format!(", {clearance_m} m clear of forbidden cells");
        if self.clearance_m > 0.0 { clear(self.clearance_m) } else { String::new() }
    }
}

impl Arms {
    /// What the worlds come to, each with the endings of all arms.
    pub fn new<'a>(
        conditions: Conditions,
        worlds: impl Iterator<Item = &'a [Ending; Arm::ALL.len()]> + Clone,
    ) -> Self {
        let endings = ArmEndings::of_arms(worlds);
        Self { conditions, rows: rows(&endings), ours_against_theirs: Comparison::new(&endings), endings }
    }

    /// What an arm came to.
    pub fn row(&self, arm: Arm) -> &Row {
        &self.rows[arm as usize]
    }

    /// How the missions of an arm ended, in the order of the worlds.
    pub fn endings(&self, arm: Arm) -> &[Ending] {
        &self.endings[arm as usize].endings
    }

    /// The arms as records.
    pub fn records(&self) -> Vec<Vec<String>> {
        let spreads = ["median_saving", "mean_paired_saving", "regret_sol", "regret_closed"];
        let headings = ["arm", "runs", "stuck", "without_route", "median_sol", "sd_sol"].map(String::from);
        let record = |row: &Row| {
            let Row { arm, stuck, without_route, median_sol, sd_sol, .. } = row;
            let of_safe = [row.median_saving, row.mean_paired_saving, row.regret_sol, row.regret_closed];
            let own = [arm.key().to_owned(), self.conditions.runs.to_string(), stuck.to_string()];
            let own = own.into_iter().chain([without_route.to_string()]);
            let own = own.chain([median_sol.to_string(), sd_sol.to_string()]);
            own.chain(of_safe.into_iter().flat_map(cells_of)).collect()
        };
        let headings = headings.into_iter().chain(spreads.into_iter().flat_map(headings_of)).collect();
        std::iter::once(headings).chain(self.rows.iter().map(record)).collect()
    }

    /// The table of all arms, and ours beside the paper's.
    pub fn written(&self, form: Form) -> String {
        table_of_arms(form, &self.rows) + "\n" + &self.ours_against_theirs.written()
    }

    /// Box plot of the travel times of those that arrived, one box an arm.
    pub fn boxes(&self, title: &str, caption: String) -> String {
        boxes(title, caption, &self.endings)
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
    /// Saving of the median time against the safe rover.
    pub median_saving: Spread,
    pub mean_paired_saving: Spread,
    /// Time beyond that of the rover that knows the truth, where both arrive.
    pub regret_sol: Spread,
    /// Share of the safe rover's regret that is gone.
    pub regret_closed: Spread,
}

fn rows(arms: &[ArmEndings; Arm::ALL.len()]) -> Vec<Row> {
    let (safe, knowing) = (&arms[Arm::SafeRover as usize], &arms[Arm::Clairvoyant as usize]);
    let row = |(arm, endings): (Arm, &ArmEndings)| Row {
        arm,
        stuck: endings.stuck(),
        without_route: endings.without_route(),
        median_sol: endings.median_sol(),
        sd_sol: endings.sd_sol(),
        median_saving: endings.median_saving(safe),
        mean_paired_saving: endings.mean_paired_saving(safe),
        regret_sol: endings.regret_sol(knowing),
        regret_closed: endings.regret_closed(safe, knowing),
    };
    Arm::ALL.into_iter().zip(arms).map(row).collect()
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

fn boxes(title: &str, caption: String, arms: &[ArmEndings; Arm::ALL.len()]) -> String {
    let name = |arm: Arm| match arm {
        Arm::NaiveRover => vec!["naive rover".into()],
        Arm::SafeRover => vec!["safe rover".into()],
        Arm::ScoutRoute => vec!["with naive".into(), "helicopter".into()],
        Arm::InformationTheoretic => vec!["with information-".into(), "theoretic h.".into()],
        Arm::ScoutValue => vec!["with scout_value".into()],
        Arm::Clairvoyant => vec!["knowing".into(), "the truth".into()],
    };
    let boxes = Arm::ALL.into_iter().zip(arms);
    Boxes {
        title: title.into(),
        caption,
        quantity: "true travel time [Sol]".into(),
        boxes: boxes.map(|(arm, endings)| BoxOf { name: name(arm), values: endings.times_sol() }).collect(),
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
    fn new(arms: &[ArmEndings; Arm::ALL.len()]) -> Self {
        let [ours, theirs] = [Arm::ScoutValue, Arm::InformationTheoretic].map(|arm| &arms[arm as usize]);
        let pairs = ours.endings.iter().zip(&theirs.endings);
        let times = pairs.filter_map(|(ours, theirs)| Some((ours.travel_sol?, theirs.travel_sol?)));
        let (mut sooner, mut later) = (0, 0);
        for (ours, theirs) in times {
            sooner += usize::from(ours < theirs);
            later += usize::from(ours > theirs);
        }
        let more_saved = ours.more_saved(theirs, &arms[Arm::SafeRover as usize]);
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
