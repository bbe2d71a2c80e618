//! `hopper campaign` for campaigns that name a study: the same folders, shards and merging as those of missions.

use std::path::{Path, PathBuf};

use ::campaign::{Manifest, Study, StudyFile, StudyPlan, StudyRow, TrialPlan as _, TrialRow as _, markdown};
use ::report::{Format, table};
use hopper::commands::campaign::report::{Form as Asked, csv_text};
use hopper::commands::campaign::store::{self, Times};
use hopper::commands::campaign::trials::{self, Flight};
use hopper::commands::campaign::{Command, fly, merge, report, rerun, run_args};
use hopper::files::{write_into, write_picture};
use hopper::stdout::print;
use node::{Exit, Failure, Node};
use serde_json::Value;

use crate::claims::Claim;
use crate::form::Form;
use crate::report::{Report as _, in_form, results};
use crate::reported::Reported;
use crate::studies::coverage::Coverage;
use crate::studies::large::Large;
use crate::studies::monte_carlo::MonteCarlo;
use crate::studies::single::Single;
use crate::studies::{Flown, FlownWorld, version};

/// The studies that this program can fly.
const STUDIES: [&str; 4] = [MonteCarlo::NAME, Large::NAME, Single::NAME, Coverage::NAME];

/// Runs the command, whatever the campaign is of.
///
/// # Errors
/// Exit code 2 for a wrong campaign, folder or flag; 1 if files cannot be written.
pub fn run(command: &Command) -> Result<Exit, Failure> {
    match command.study()?.as_deref() {
        None => hopper::commands::campaign::run(command),
        Some(MonteCarlo::NAME) => of_study::<MonteCarlo>(command),
        Some(Large::NAME) => of_study::<Large>(command),
        Some(Single::NAME) => of_study::<Single>(command),
        Some(Coverage::NAME) => of_study::<Coverage>(command),
        Some(other) => {
            Err(Failure::usage(format!("study: need one of {}, got {other:?}", STUDIES.join(", "))))
        }
    }
}

fn of_study<S: Reported>(command: &Command) -> Result<Exit, Failure> {
    match command {
        Command::List(_) => hopper::commands::campaign::run(command),
        Command::Run(args) => fly_study::<S>(args),
        Command::Merge(args) => merge::shards::<StudyPlan<S>>(args),
        Command::Report(args) => report_study::<S>(args),
        Command::Rerun(args) => rerun_study::<S>(args),
    }
}

/// Flies the trials of a study.
struct Trials<S: Flown> {
    plan: StudyPlan<S>,
    ground: S::Ground,
}

impl<S: Flown> Flight for Trials<S> {
    type Plan = StudyPlan<S>;

    fn fly(&self, number: u64) -> Result<(StudyRow<S>, Times), Failure> {
        let trial = self.plan.trial(number).expect("a trial of the plan");
        let started = Node::now();
        let outcome = self.plan.settings.fly(&self.ground, trial.case, trial.seed)?;
        let episode_s = Node::now().since_ns(started) as f64 / 1e9;
        Ok((StudyRow::new(&self.plan, &trial, outcome), Times { episode_s, ..Times::unknown(number) }))
    }
}

fn fly_study<S: Flown>(args: &run_args::Args) -> Result<Exit, Failure> {
    let (text, origin) = (fly::text(&args.file)?, args.file.display().to_string());
    let file = StudyFile::<S>::parse(&text, &origin).map_err(|error| fly::refused(&args.file, &error))?;
    let plan = file.plan(&version());
    trials::run(args, plan.clone(), Trials { ground: plan.settings.ground(), plan })
}

/// Flies one trial again, compares its row, and draws it.
fn rerun_study<S: Reported>(args: &rerun::Args) -> Result<Exit, Failure> {
    let manifest: Manifest<StudyPlan<S>> = store::manifest(&args.dir)?;
    let row = store::row(&args.dir, &manifest, args.trial)?;
    let plan = &manifest.plan;
    let trial = plan.trial(row.trial).expect("a row was checked against the plan");
    let ground = plan.settings.ground();
    let again = StudyRow::new(plan, &trial, plan.settings.fly(&ground, trial.case, trial.seed)?);
    let mut files = plan.settings.pictures(&ground, trial.case, trial.seed)?;
    files.push(("row.json".into(), again.line()));
    let default = || PathBuf::from("out").join(format!("{}-trial-{}", plan.name, trial.number));
    let out = args.out.clone().unwrap_or_else(default);
    write_into(&out, files)?;
    print(&match args.format {
        Format::Json => again.line(),
        Format::Text => written(&again)? + &format!("Row and pictures are in {}.\n", out.display()),
    })?;
    if again == row {
        return Ok(Exit::Done);
    }
    Err(Failure::run(format!(
        "trial {}: need its row, {}, got {}: this program (version {}) is not the one that flew it (version {})",
        row.trial,
        row.line().trim_end(),
        again.line().trim_end(),
        version(),
        row.version
    )))
}

/// A row, a line for each number and text of it.
fn written<S: Study>(row: &StudyRow<S>) -> Result<String, Failure> {
    let record = store::record_of(row)?;
    let lines = StudyRow::<S>::headings().into_iter().zip(record).map(|(name, value)| [name, value]);
    Ok(table(["field", "value"], &lines.collect::<Vec<_>>()))
}

fn report_study<S: Reported>(args: &report::Args) -> Result<Exit, Failure> {
    if args.beside.is_some() || args.readings {
        let study = S::NAME;
        return Err(Failure::usage(format!(
            "--beside and --readings need campaigns of missions, got one of the study {study}"
        )));
    }
    let manifest: Manifest<StudyPlan<S>> = store::manifest(&args.dir)?;
    let worlds = worlds(&args.dir, &manifest)?;
    let account = manifest.plan.settings.report(manifest.plan.seed, &worlds);
    let against = args.against.is_some();
    let text = |form: Asked| -> Result<String, Failure> {
        Ok(match form {
            Asked::Md if against => in_form(&account, Form::Markdown)? + "\n" + &speed(&args.dir)?,
            Asked::Md => results(&account, Form::Markdown) + &speed(&args.dir)?,
            Asked::Json if against => in_form(&account, Form::Json)?,
            Asked::Json => without_claims(&in_form(&account, Form::Json)?)?,
            Asked::Csv if against => csv_text(records(account.claims()))?,
            Asked::Csv => csv_text(account.records())?,
            Asked::Svg => account.figures()?.remove(0).1,
        })
    };
    if let Some(dir) = &args.out {
        let mut files = account.figures()?;
        for form in [Asked::Md, Asked::Csv, Asked::Json] {
            files.push((format!("report.{form}"), text(form)?));
        }
        write_into(dir, files)?;
    }
    if let Some(file) = &args.picture {
        write_picture(file, &text(Asked::Svg)?)?;
    }
    print(&text(args.format)?)?;
    Ok(Exit::Done)
}

/// The claims as records, the headings first.
fn records(claims: &[Claim]) -> Vec<Vec<String>> {
    let headings = Claim::HEADINGS.map(|heading| heading.replace(' ', "_"));
    std::iter::once(headings.into()).chain(claims.iter().map(|claim| claim.cells().into())).collect()
}

fn without_claims(json: &str) -> Result<String, Failure> {
    let mut value: Value = serde_json::from_str(json).map_err(Failure::run)?;
    if let Some(object) = value.as_object_mut() {
        object.remove("claims");
    }
    Ok(value.to_string() + "\n")
}

/// The worlds on which every case is in the folder, in the order of their numbers.
fn worlds<S: Flown>(dir: &Path, manifest: &Manifest<StudyPlan<S>>) -> Result<Vec<FlownWorld<S>>, Failure> {
    let cases = S::cases().len();
    let (mut worlds, mut world, mut of) = (Vec::new(), Vec::new(), None);
    let rows = store::each_row(dir, manifest, |row| {
        if of.replace(row.repetition) != Some(row.repetition) {
            world = Vec::with_capacity(cases);
        }
        world.push(row.outcome);
        if world.len() == cases {
            worlds.push(FlownWorld { seed: row.seed, outcomes: std::mem::take(&mut world) });
        }
        Ok(())
    })?;
    if worlds.len() as u64 >= S::WORLDS_MIN {
        return Ok(worlds);
    }
    Err(Failure::usage(format!(
        "{}: need at least {} worlds with all of their {cases} cases, got {} in {rows} of {} rows (shard {}): finish the \
         campaign with --resume, or merge its shards",
        dir.display(),
        S::WORLDS_MIN,
        worlds.len(),
        manifest.shard.len(manifest.plan.trials()),
        manifest.shard
    )))
}

/// How long the trials took; nothing if the folder has no times.
fn speed(dir: &Path) -> Result<String, Failure> {
    let (mut trials, mut sum_s) = (0_u64, 0.0);
    for times in store::times(dir)?.filter(|times| times.episode_s.is_finite()) {
        trials += 1;
        sum_s += times.episode_s;
    }
    if trials == 0 {
        return Ok(String::new());
    }
    let row = [trials.to_string(), format!("{sum_s:.1}"), format!("{:.3}", 1e3 * sum_s / trials as f64)];
    Ok(format!(
        "## Times (not reproducible)\n\nOf one thread on the machine that flew the trials.\n\n{}",
        markdown::table(["trials", "all, s", "mean, ms"], &[row])
    ))
}
