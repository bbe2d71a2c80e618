//! `hopper motion derive`: where hops end, by soil and slope, from physics.

use contract::Soil;
use std::fmt::Write as _;
use std::path::PathBuf;

use hopper::stdout::{print, print_json};
use node::{Exit, Failure};
use report::{Format, table};
use scenario::Preset;

use crate::drawing::figure;
use crate::landing_table::{Class, LandingTable};

/// Shown below the help.
pub(crate) const EXAMPLES: &str = "Examples:\n  hopper motion derive --preset mars\n  hopper motion derive --preset ryugu --hops 5000 --out tables";

/// Arguments of `hopper motion derive`.
#[derive(clap::Args, Clone, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Body whose gravity and soils are taken: moon, mars, phobos, ryugu or bennu.
    #[arg(long, default_value_t, value_name = "BODY")]
    preset: Preset,
    /// Hops of each class of soil and slope.
    #[arg(long, default_value_t = 2000, value_name = "N", value_parser = clap::value_parser!(u64).range(100..=1_000_000))]
    hops: u64,
    /// Seed of the random numbers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Folder for table.toml, table.csv and figure.svg.
    #[arg(long, value_name = "DIR", value_parser = node::output_path())]
    out: Option<PathBuf>,
    /// Format of the answer on standard output: text or json.
    #[arg(long, default_value_t)]
    format: Format,
}

/// Runs the command.
///
/// # Errors
/// Exit code 1 if the folder or standard output cannot be written.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let derived = LandingTable::derive(args.preset, args.hops, args.seed);
    if let Some(folder) = &args.out {
        write(folder, &derived).map_err(|error| Failure::run(format!("{}: {error}", folder.display())))?;
    }
    match args.format {
        Format::Json => print_json(&derived)?,
        Format::Text => print(&text(&derived))?,
    }
    Ok(Exit::Done)
}

fn write(folder: &std::path::Path, derived: &LandingTable) -> std::io::Result<()> {
    std::fs::create_dir_all(folder)?;
    let toml = toml::to_string(derived).map_err(std::io::Error::other)?;
    std::fs::write(folder.join("table.toml"), toml)?;
    std::fs::write(folder.join("table.csv"), csv(derived))?;
    std::fs::write(folder.join("figure.svg"), figure(derived))
}

/// One line a landing, `far` as the last of its class.
fn csv(derived: &LandingTable) -> String {
    let mut text =
        String::from("soil,along_deg,across_deg,samples,forward,left,probability,low,high,rolls_away\n");
    for Class { soil, along_deg, across_deg, samples, landings, far, rolls_away } in &derived.classes {
        let class = format!("{},{along_deg},{across_deg},{samples}", soil.name());
        for landing in landings {
            let ([forward, left], probability) = (landing.offset, landing.probability);
            let (low, high) = (landing.low, landing.high);
            let _ = writeln!(text, "{class},{forward},{left},{probability},{low},{high},{rolls_away}");
        }
        if far.probability > 0.0 {
            let ([forward, left], probability) = (far.mean, far.probability);
            let _ = writeln!(text, "{class},{forward:.3},{left:.3},{probability},,,{rolls_away}");
        }
    }
    text
}

/// The classes straight up and down, and straight across.
fn text(derived: &LandingTable) -> String {
    let mut rows = Vec::new();
    for soil in Soil::ALL {
        for class in &derived.classes {
            let is_shown = class.along_deg.abs() % 5.0 == 0.0 && class.across_deg.abs() % 5.0 == 0.0;
            let is_straight = class.across_deg == 0.0 || class.along_deg == 0.0;
            if class.soil != soil || !is_shown || !is_straight {
                continue;
            }
            let share = |offset| format!("{:.3}", class.share(offset));
            let (aimed, stays) = (class.share([1, 0]), class.share([0, 0]));
            rows.push([
                soil.name().to_owned(),
                format!("{}", class.along_deg),
                format!("{}", class.across_deg),
                share([1, 0]),
                share([0, 0]),
                format!("{:.3}", 1.0 - aimed - stays),
                if class.rolls_away { "rolls away".into() } else { String::new() },
            ]);
        }
    }
    let heading = format!(
        "{}, {} m/s², hops of {} m; slopes in degrees, rising ahead and to the left\n\n",
        derived.preset, derived.gravity_mps2, derived.hop_m
    );
    heading + &table(["soil", "along", "across", "aimed", "stays", "elsewhere", ""], &rows)
}
