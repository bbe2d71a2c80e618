//! The claims of the paper's Monte Carlo study, each judged.

use ::campaign::statistics::wilson;
use ::scouting::{Arm, Spread};
use serde::Serialize;

use super::{Row, percent};

/// A claim beside what came out; field names are those of the JSON.
#[derive(Clone, Debug, Serialize)]
pub struct Claim {
    claim: String,
    paper: String,
    /// Where the number of a faithful repetition of 100 runs would lie; empty for claims without a number.
    band: String,
    ours: String,
    /// Whether our number lies in the band, or the statement is true of our runs.
    pub holds: bool,
}

impl Claim {
    /// The cells of its row.
    pub fn cells(&self) -> [String; 5] {
        let verdict = if self.holds { "holds" } else { "does not hold" };
        [&self.claim, &self.paper, &self.band, &self.ours, verdict].map(ToString::to_string)
    }
}

fn claim(claim: &str, paper: &str, band: &str, ours: String, holds: bool) -> Claim {
    Claim { claim: claim.into(), paper: paper.into(), band: band.into(), ours, holds }
}

/// Judges each claim by the rows of all arms.
pub fn judge(runs: u64, rows: &[Row]) -> Vec<Claim> {
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
    vec![
        claim(
            "the naive rover gets stuck",
            "21 %",
            "13 to 29 %",
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
            "4 to 16 %",
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
            "",
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
