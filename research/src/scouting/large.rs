//! The case study of P21 on a stand-in for its map of Jezero (Figs 7, 16 and 17).

use ::report::picture::{Chart, Curves, FieldMap, Line, Way};
use node::{Exit, Failure};
use p21::{Arm, LARGE_SIDE, LargeMap, Outcome, Samples, Spread};
use rover::Point;
use serde::Serialize;

use super::arms::{Arms, Conditions};
use super::{FOLSOM, figures};
use crate::claims::{Claim, Verdict};
use crate::form::{Form, table};
use crate::report::{Publication, Report, number, percent};
use crate::reported::Reported;
use crate::studies::large::{AT_M, HELICOPTERS, Large};
use crate::studies::{Flown as _, FlownWorld, fly_all, plan};

/// Arguments of the study on the large map.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// Truths of the one map; the paper has 20.
    #[arg(long, default_value_t = 200, value_name = "N", value_parser = clap::value_parser!(u64).range(2..=100_000))]
    runs: u64,
    /// Seed of the first truth; the following count up from it.
    #[arg(long, default_value_t = 1, value_name = "N")]
    seed: u64,
    #[command(flatten)]
    settings: Large,
    #[command(flatten)]
    publication: Publication,
}

/// What one helicopter shows on its way; field names are those of the JSON.
#[derive(Clone, Debug, Serialize)]
struct Shown {
    arm: Arm,
    /// Mean of the spread shown after each of the metres, in thousands of m/Sol.
    thousands: Vec<Spread>,
    #[serde(skip)]
    by_run: Vec<Vec<f64>>,
}

/// The whole study; field names are those of the JSON.
#[derive(Clone, Debug, Serialize)]
pub struct Account {
    map: u64,
    good: f64,
    #[serde(flatten)]
    arms: Arms,
    metres: [f64; AT_M.len()],
    shown: Vec<Shown>,
    claims: Vec<Claim>,
    #[serde(skip)]
    settings: Large,
    /// Seeds of the truths, in the order of the endings.
    #[serde(skip)]
    seeds: Vec<u64>,
}

/// Flies the study and prints its report.
///
/// # Errors
/// Exit code 2 if the folder for the figures cannot be created, 1 if the report cannot be printed or written.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let worlds = fly_all(&plan(args.settings, args.seed, args.runs))?;
    args.publication.publish(&args.settings.report(args.seed, &worlds))
}

impl Account {
    /// What the truths come to, in a campaign of seed `seed`.
    pub fn new(settings: Large, seed: u64, worlds: &[FlownWorld<Large>]) -> Self {
        let Large { map, good, stages, rover, accuracy, clearance_m } = settings;
        let samples = Samples::LARGE;
        let runs = worlds.len() as u64;
        let conditions = Conditions { runs, seed, stages, rover, samples, accuracy, clearance_m };
        let arms = Arms::new(conditions, worlds.iter().map(|world| &world.outcomes[0].arms));
        let shown: Vec<Shown> = (0..HELICOPTERS.len()).map(|n| shown(worlds, n)).collect();
        let claims = judge(&arms, &shown);
        let seeds = worlds.iter().map(|world| world.seed).collect();
        Self { map, good, arms, metres: AT_M, shown, claims, settings, seeds }
    }
}

/// What helicopter `n` shows.
fn shown(worlds: &[FlownWorld<Large>], n: usize) -> Shown {
    let of_run = |world: &FlownWorld<Large>| world.outcomes[0].shown[n].map(|sum| sum / 1000.0).to_vec();
    let by_run: Vec<Vec<f64>> = worlds.iter().map(of_run).collect();
    let at = |n: usize| Spread::mean(&by_run.iter().map(|run| run[n]).collect::<Vec<_>>());
    Shown { arm: HELICOPTERS[n], thousands: (0..AT_M.len()).map(at).collect(), by_run }
}

// Long: a claim after the other.
fn judge(arms: &Arms, shown: &[Shown]) -> Vec<Claim> {
    let row = |arm: Arm| arms.row(arm);
    let (safe, along, informed) = (row(Arm::SafeRover), row(Arm::ScoutRoute), row(Arm::InformationTheoretic));
    let endings = |arm: Arm| &arms.endings[arm as usize];
    let more =
        endings(Arm::InformationTheoretic).more_saved(endings(Arm::ScoutRoute), endings(Arm::SafeRover));
    let above_0 = |spread| Verdict::above(spread, 0.0);
    let sooner = |metres: f64| {
        let n = AT_M.iter().position(|at| *at == metres).expect("one of the metres");
        let pairs = shown[1].by_run.iter().zip(&shown[0].by_run);
        Spread::mean(&pairs.map(|(informed, along)| informed[n] - along[n]).collect::<Vec<_>>())
    };
    let (half, whole) = (sooner(140.0), sooner(300.0));
    let lost = [safe, along, informed].map(|row| row.stuck + row.without_route);
    vec![
        Claim::new(
            "the travel times of Fig. 7: 2.62, 2.55 and 1.68 Sol",
            "2.62, 2.55, 1.68 Sol",
            "the paper's map is not public; beside are the medians on the stand-in",
            [safe, along, informed].map(|row| format!("{:.2}", row.median_sol)).join(", "),
            Verdict::NotToBeHad,
        ),
        Claim::new(
            "the information-theoretic helicopter saves 11.4 h a Sol in the median (Fig. 17)",
            "46 %",
            "the share depends on both ways of the map; beside is that of the stand-in",
            percent(informed.median_saving),
            Verdict::NotToBeHad,
        ),
        Claim::new(
            "with it the rover is faster than alone",
            "yes",
            "the mean paired saving is above 0",
            percent(informed.mean_paired_saving),
            above_0(informed.mean_paired_saving),
        ),
        Claim::new(
            "with it the rover is faster than with the naive helicopter",
            "yes",
            "the difference of the mean paired savings is above 0",
            percent(more),
            above_0(more),
        ),
        Claim::new(
            "the naive helicopter tends to worsen the rover's performance",
            "yes",
            "its mean paired saving is below 0",
            percent(along.mean_paired_saving),
            Verdict::below(along.mean_paired_saving, 0.0),
        ),
        Claim::new(
            "the naive helicopter tends to produce small median improvements",
            "yes",
            "its median saving is 0 to 5 %",
            percent(along.median_saving),
            Verdict::within(along.median_saving, f64::MIN_POSITIVE, 0.05),
        ),
        Claim::new(
            "none of the three rovers gets stuck",
            "yes",
            "0, of at least 20 runs",
            lost.map(|lost| lost.to_string()).join(", "),
            Verdict::never(lost.iter().sum(), arms.conditions.runs, 20),
        ),
        Claim::new(
            "the information-theoretic helicopter shows more of the spread, and sooner (Fig. 16)",
            "yes",
            "it has shown more than the naive one after 140 m and after 300 m of flight",
            format!("{} and {} thousand m/Sol", number(half, 0), number(whole, 0)),
            Verdict::all([above_0(half), above_0(whole)]),
        ),
    ]
}

impl Report for Account {
    const NAME: &'static str = "scouting-large";
    const PAPER: &'static str = FOLSOM;

    fn title(&self) -> String {
        let conditions = &self.arms.conditions;
        let stages = conditions.of_stages();
        let (runs, sensor, clear) = (conditions.runs, conditions.of_sensor(), conditions.of_clearance());
        format!(
            "Scouting on a made map of {LARGE_SIDE} × {LARGE_SIDE} cells, {runs} truths, {stages}{sensor}{clear}"
        )
    }

    fn tables(&self, form: Form) -> String {
        let cells = |shown: &Shown| {
            let at = |n: usize| number(shown.thousands[n], 0);
            [shown.arm.name().to_owned(), at(0), at(5), at(10), at(15)]
        };
        let headings = ["spread shown, 1000 m/Sol, after", "0 m", "100 m", "200 m", "300 m"];
        let shown: Vec<_> = self.shown.iter().map(cells).collect();
        self.arms.written(form) + &table(form, headings, &shown) + "\n"
    }

    fn records(&self) -> Vec<Vec<String>> {
        self.arms.records()
    }

    fn claims(&self) -> &[Claim] {
        &self.claims
    }

    fn figures(&self) -> Result<Vec<(String, String)>, Failure> {
        let caption = format!("{} truths of one made map", self.arms.conditions.runs);
        let seventeen = self.arms.boxes("Travel times on the stand-in for Jezero", caption);
        let ground = self.settings.ground();
        Ok(vec![
            ("fig-17.svg".into(), seventeen),
            ("fig-16.svg".into(), self.spread_shown()),
            ("fig-7.svg".into(), ways(self.settings, &ground, self.telling())),
        ])
    }
}

/// The map with the ways of a truth.
pub fn ways(settings: Large, ground: &LargeMap, seed: u64) -> String {
    let world = ground.world(seed);
    let outcomes = settings.outcomes(&world, seed);
    let way = |name: &str, arm: Arm, of: fn(&Outcome) -> &[Point]| Way {
        name: name.into(),
        points: of(&outcomes[arm as usize]).iter().map(|at| [at.x_m, at.y_m]).collect(),
    };
    FieldMap {
        title: "Ways on the stand-in for Jezero".into(),
        caption: format!("Truth of seed {seed}; dark is impassable"),
        quantity: "standard deviation of the speed [m/Sol]".into(),
        columns: LARGE_SIDE,
        cell_m: 1.0,
        values: figures::spread(&world.prior),
        ways: vec![
            way("rover alone", Arm::SafeRover, |outcome| &outcome.route),
            way("with naive h.", Arm::ScoutRoute, |outcome| &outcome.route),
            way("with inf.-theoretic h.", Arm::InformationTheoretic, |outcome| &outcome.route),
            way("flight of the latter", Arm::InformationTheoretic, |outcome| &outcome.flight),
        ],
    }
    .svg()
}

impl Account {
    /// The seed of the first truth in which the helicopter saves most.
    fn telling(&self) -> u64 {
        let time = |arm: Arm, run: usize| self.arms.endings(arm)[run].travel_sol;
        let saved = |run: &usize| {
            time(Arm::SafeRover, *run).unwrap_or(0.0)
                - time(Arm::InformationTheoretic, *run).unwrap_or(f64::INFINITY)
        };
        let run = (0..self.seeds.len()).max_by(|a, b| saved(a).total_cmp(&saved(b)).then(b.cmp(a)));
        run.map_or(self.arms.conditions.seed, |run| self.seeds[run])
    }

    fn spread_shown(&self) -> String {
        let line = |shown: &Shown| Line {
            name: match shown.arm {
                Arm::ScoutRoute => "naive".into(),
                Arm::InformationTheoretic => "information-theoretic".into(),
                _ => "scout_value".into(),
            },
            values: shown.thousands.iter().map(|spread| Some(spread.value)).collect(),
        };
        Curves {
            title: "Spread that the helicopters show".into(),
            caption: format!("Means of {} flights", self.arms.conditions.runs),
            axis: "flown [m]".into(),
            at: AT_M.into(),
            charts: vec![Chart {
                quantity: "Σ SD seen [1000 m/Sol]".into(),
                lines: self.shown.iter().map(line).collect(),
            }],
        }
        .svg()
    }
}

impl Reported for Large {
    type Report = Account;

    fn pictures(&self, ground: &LargeMap, _case: usize, seed: u64) -> Result<Vec<(String, String)>, Failure> {
        Ok(vec![("fig-7.svg".into(), ways(*self, ground, seed))])
    }

    fn report(&self, seed: u64, worlds: &[FlownWorld<Self>]) -> Account {
        Account::new(*self, seed, worlds)
    }
}
