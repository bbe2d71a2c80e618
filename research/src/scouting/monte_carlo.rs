//! The Monte Carlo simulation of P21: four scenarios on random passages, and ours beside them (Figs 12 and 13).

use ::campaign::statistics::wilson;
use ::report::picture::{FieldMap, Way};
use node::{Exit, Failure};
use p21::{Arm, Samples, Spread, monte_carlo};
use serde::Serialize;

use super::arms::{Arms, Conditions, Row};
use super::{FOLSOM, figures};
use crate::claims::{Claim, Verdict};
use crate::form::Form;
use crate::report::{Publication, Report, percent};
use crate::reported::Reported;
use crate::studies::monte_carlo::MonteCarlo;
use crate::studies::{FlownWorld, fly_all, plan};

/// Arguments of the Monte Carlo study.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// Worlds; all arms meet the same ones.
    #[arg(long, default_value_t = 1000, value_name = "N", value_parser = clap::value_parser!(u64).range(2..=1_000_000))]
    runs: u64,
    /// Seed of the first world; the following count up from it.
    #[arg(long, default_value_t = 1, value_name = "N")]
    seed: u64,
    #[command(flatten)]
    settings: MonteCarlo,
    #[command(flatten)]
    publication: Publication,
}

/// The whole study; field names are those of the JSON.
#[derive(Clone, Debug, Serialize)]
pub struct Account {
    #[serde(flatten)]
    arms: Arms,
    claims: Vec<Claim>,
    #[serde(skip)]
    settings: MonteCarlo,
    /// Seed of the first world.
    #[serde(skip)]
    first: u64,
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
    /// What the worlds come to, in a campaign of seed `seed`.
    pub fn new(settings: MonteCarlo, seed: u64, worlds: &[FlownWorld<MonteCarlo>]) -> Self {
        let MonteCarlo { rover, accuracy, stages, clearance_m } = settings;
        let samples = Samples::MONTE_CARLO;
        let runs = worlds.len() as u64;
        let conditions = Conditions { runs, seed, stages, rover, samples, accuracy, clearance_m };
        let arms = Arms::new(conditions, worlds.iter().map(|world| &world.outcomes[0].arms));
        let first = worlds.first().map_or(seed, |world| world.seed);
        Self { claims: judge(&arms), arms, settings, first }
    }
}

impl Report for Account {
    const NAME: &'static str = "scouting";
    const PAPER: &'static str = FOLSOM;

    fn title(&self) -> String {
        let conditions = &self.arms.conditions;
        let stages = Some(conditions).filter(|conditions| conditions.stages > 1);
        let stages = stages.map_or(String::new(), |conditions| format!(", {}", conditions.of_stages()));
        let (sensor, clearance) = (conditions.of_sensor(), conditions.of_clearance());
        format!("Scouting on {} random worlds{stages}{sensor}{clearance}", conditions.runs)
    }

    fn tables(&self, form: Form) -> String {
        self.arms.written(form)
    }

    fn records(&self) -> Vec<Vec<String>> {
        self.arms.records()
    }

    fn claims(&self) -> &[Claim] {
        &self.claims
    }

    fn figures(&self) -> Result<Vec<(String, String)>, Failure> {
        let runs = self.arms.conditions.runs;
        let caption = format!("{runs} random worlds; rovers that are stuck are left out");
        let twelve = self.arms.boxes("Travel times with and without a helicopter", caption);
        Ok(vec![("fig-12.svg".into(), twelve), ("fig-13.svg".into(), region(self.settings, self.first))])
    }
}

/// A world: how uncertain it is, and who goes where.
pub fn region(settings: MonteCarlo, seed: u64) -> String {
    let (world, outcomes) = (monte_carlo(seed), settings.outcomes(seed));
    let [safe, informed] = [Arm::SafeRover, Arm::InformationTheoretic].map(|arm| &outcomes[arm as usize]);
    let way = |name: &str, points: &[rover::Point]| Way {
        name: name.into(),
        points: points.iter().map(|at| [at.x_m, at.y_m]).collect(),
    };
    FieldMap {
        title: "The region of the Monte Carlo simulation".into(),
        caption: format!("World of seed {seed}; the discs are impassable"),
        quantity: "standard deviation of the speed [m/Sol]".into(),
        columns: world.prior.surface().lattice().width(),
        cell_m: 1.0,
        values: figures::spread(&world.prior),
        ways: vec![
            way("safe rover", &safe.route),
            way("with helicopter", &informed.route),
            way("its flight", &informed.flight),
        ],
    }
    .svg()
}

/// Judges each claim by the rows of all arms.
// Long: a claim after the other.
fn judge(arms: &Arms) -> Vec<Claim> {
    let (runs, row) = (arms.conditions.runs, |arm: Arm| arms.row(arm));
    let (naive, safe) = (row(Arm::NaiveRover), row(Arm::SafeRover));
    let (along, informed) = (row(Arm::ScoutRoute), row(Arm::InformationTheoretic));
    let stuck = naive.stuck as f64 / runs as f64;
    let interval = wilson(naive.stuck as u64, runs);
    let stuck = Spread { value: stuck, low: interval.low, high: interval.high };
    let lost = |row: &Row| row.stuck + row.without_route;
    let others = [safe, along, informed].map(lost);
    let endings = |arm: Arm| &arms.endings[arm as usize];
    let above_0 = |spread| Verdict::above(spread, 0.0);
    let best = endings(Arm::InformationTheoretic);
    let median_below = |arm: &Arm| above_0(best.median_below(endings(*arm)));
    let sd_below = |arm: &Arm| above_0(best.sd_below(endings(*arm)));
    let (safe_arms, naive_arm) = ([Arm::SafeRover, Arm::ScoutRoute], Arm::NaiveRover);
    let saving = informed.median_saving;
    let slight = along.median_saving;
    let of_the_paper = [naive, safe, along, informed];
    let sds = of_the_paper.map(|row| format!("{:.3}", row.sd_sol));
    let medians = of_the_paper.map(|row| format!("{:.3}", row.median_sol));
    let order = "naive, safe, naive helicopter, information-theoretic";
    vec![
        Claim::new(
            "the naive rover gets stuck",
            "21 %",
            "13 to 29 % (of 100 runs)",
            percent(stuck),
            Verdict::within(stuck, 0.13, 0.29),
        ),
        Claim::new(
            "the other three never do",
            "0",
            "0, of at least 100 runs",
            others.map(|lost| lost.to_string()).join(", "),
            Verdict::never(others.iter().sum(), runs, 100),
        ),
        Claim::new(
            "the information-theoretic helicopter saves median travel time",
            "about 10 %",
            "4 to 16 % (of 100 runs)",
            percent(saving),
            Verdict::within(saving, 0.04, 0.16),
        ),
        Claim::new(
            &format!("it has the lowest SD of travel time ({order}; Sol)"),
            "yes",
            "each difference to the others is below 0",
            sds.join(", "),
            Verdict::all(safe_arms.iter().chain([&naive_arm]).map(sd_below)),
        ),
        Claim::new(
            "the naive helicopter gains slightly",
            "yes",
            "above 0, below that of the information-theoretic helicopter",
            percent(slight),
            Verdict::all([above_0(slight), median_below(&Arm::ScoutRoute)]),
        ),
        Claim::new(
            "the information-theoretic helicopter has a lower median than the other two safe rovers",
            "yes",
            "both differences to the others are below 0",
            medians[1..].join(", "),
            Verdict::all(safe_arms.iter().map(median_below)),
        ),
        Claim::new(
            &format!("it has the lowest median of all four ({order}; Sol)"),
            "yes",
            "each difference to the others is below 0",
            medians.join(", "),
            Verdict::all(safe_arms.iter().chain([&naive_arm]).map(median_below)),
        ),
    ]
}

impl Reported for MonteCarlo {
    type Report = Account;

    fn pictures(&self, (): &(), _case: usize, seed: u64) -> Result<Vec<(String, String)>, Failure> {
        Ok(vec![("fig-13.svg".into(), region(*self, seed))])
    }

    fn report(&self, seed: u64, worlds: &[FlownWorld<Self>]) -> Account {
        Account::new(*self, seed, worlds)
    }
}
