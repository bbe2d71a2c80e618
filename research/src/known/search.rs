//! `hopper known search`: searches for the reading of the paper that reproduces most of its claims.

use hopper::stdout::print;
use node::{Exit, Failure};
use p22::search::{self, Found, Judged, Search};
use p22::{P22, Reading};
use rayon::prelude::*;

use crate::form::{Form, heading, table};

/// Arguments of `hopper known search`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// Readings drawn at random at the start.
    #[arg(long, default_value_t = 3000, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    samples: u32,
    /// How many of the best of them to climb from, one answer at a time.
    #[arg(long, default_value_t = 30, value_name = "N")]
    climbs: u32,
    /// How many of the best summits to climb on from, two answers at a time.
    #[arg(long, default_value_t = 3, value_name = "N")]
    high_climbs: u32,
    /// Seed of the random readings.
    #[arg(long, default_value_t = 7, value_name = "N")]
    seed: u64,
    /// Number of threads [default: one per core]; it does not change the result.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=4096))]
    jobs: Option<u16>,
    /// Format of the result on standard output.
    #[arg(long, default_value_t)]
    format: Form,
}

/// Longer lists of answers are abbreviated.
const ANSWERS_SHOWN: usize = 12;

/// Searches, and prints the result.
///
/// # Errors
/// Exit code 1 if the threads cannot be started.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(args.jobs.map_or(0, usize::from))
        .build()
        .map_err(Failure::run)?;
    let search = Search {
        seed: args.seed,
        samples: args.samples as usize,
        climbs: args.climbs as usize,
        high_climbs: args.high_climbs as usize,
    };
    let found = search.run(|readings| pool.install(|| readings.par_iter().map(search::judge).collect()));
    print(&match args.format {
        Form::Json => serde_json::to_string(&found).map_err(Failure::run)? + "\n",
        form => written(form, &found),
    })?;
    Ok(Exit::Done)
}

fn written(form: Form, found: &Found) -> String {
    let Search { seed, samples, climbs, high_climbs } = found.search;
    let mut text = heading(form, &format!("{} readings judged", found.judged));
    text += &format!(
        "Seed {seed}: {samples} drawn, {climbs} climbed from, {high_climbs} of the summits climbed on from.\n\
         The reading in use holds {} of {} claims.\n\n",
        found.chosen.holds, found.chosen.claims
    );
    text += &heading(form, "Questions and answers");
    let questions = P22.questions();
    let rows: Vec<_> = questions
        .iter()
        .zip(&found.around)
        .map(|(question, around)| {
            let field = question.field;
            let with = |judged: &Judged| format!("{} ({})", answer(&judged.reading, field), judged.holds);
            let few: Vec<String> = around.iter().map(with).collect();
            let best = around.iter().filter(|judged| judged.holds >= found.chosen.holds).map(with);
            let tried = match few.len() > ANSWERS_SHOWN {
                true => format!(
                    "{} others; as good or better: {}",
                    few.len(),
                    best.collect::<Vec<_>>().join(", ")
                ),
                false => few.join(", "),
            };
            [field.to_owned(), answer(&P22, field), tried]
        })
        .collect();
    text +=
        &table(form, ["question", "in use", "answers tried (claims that hold, all else as in use)"], &rows);
    text += &heading(form, "Summits");
    let rows: Vec<_> = found
        .summits
        .iter()
        .map(|judged| {
            let answers: Vec<String> =
                questions.iter().map(|question| answer(&judged.reading, question.field)).collect();
            [format!("{} of {}", judged.holds, judged.claims), answers.join(", ")]
        })
        .collect();
    text + &table(form, ["claims", "answers, in the order of the questions"], &rows)
}

/// Value of a field of `reading`, as in its JSON.
fn answer(reading: &Reading, field: &str) -> String {
    let value = serde_json::to_value(reading).ok();
    let value = value.as_ref().and_then(|value| value.get(field));
    value.map_or_else(String::new, |value| value.to_string().replace('"', ""))
}
