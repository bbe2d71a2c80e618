//! `hopper-qa fuzz-missions`: random missions of all kinds, flown in lockstep, with simulated faults, and by real processes that
//! are killed.
//!
//! A seed gives a mission: ground, obstacles, sand, robots with their sensors, speeds, starts and goals, limits, planners. Each
//! is flown in lockstep twice and with a fresh planner at every decision, and its journal is resumed. It is simulated with the
//! faults of its seed, unless it is one of several robots whose cells are not a metre: the simulation's checker computes no such
//! flights. Some are flown by real processes, one of which is killed. A mission that breaks a promise is made small.

pub mod draft;
pub mod smaller;
pub mod trial;

use std::fmt::Write as _;
use std::path::PathBuf;

use contract::Role;
use hopper::progress::Progress;
use hopper::stdout::print;
use hopper::tool;
use node::{Exit, Failure, Node, ShutdownSignal};
use rayon::prelude::*;
use report::Format;
use scenario::Scenario;
use serde::Serialize;
use simulation::chance::Chance;

use crate::chaos::World;
use crate::chaos::mission::fly;
use crate::chaos::plan::Plan;
use crate::simulate::Seeds;
pub use draft::{Draft, Kind};
use trial::Broken;

/// Arguments of `hopper-qa fuzz-missions`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// Seeds of the missions, the last left out.
    #[arg(long, default_value = "0..60", value_name = "A..B")]
    seeds: Seeds,
    /// Kind of all missions [default: each kind in turn].
    #[arg(long, value_enum, value_name = "KIND")]
    kind: Option<Kind>,
    /// Missions that are flown by real processes too, the first ones; a process of each is killed.
    #[arg(long, default_value_t = 6, value_name = "N")]
    live: u64,
    /// Fly this scenario in place of a random one, with the first of the seeds: one that was written by an earlier run.
    #[arg(long, value_name = "FILE", requires = "kind")]
    scenario: Option<PathBuf>,
    /// Planner of a hopper that is alone, with --scenario.
    #[arg(long, default_value = "mdp", value_name = "NAME", requires = "scenario")]
    planner: String,
    /// Folder for the scenario of a mission that breaks a promise.
    #[arg(long, default_value = "out", value_name = "DIR")]
    out: PathBuf,
    /// Form of the answer on standard output: text or json.
    #[arg(long, default_value_t)]
    format: Format,
}

/// A mission in which a promise did not hold.
#[derive(Clone, Debug, Serialize)]
pub struct Failing {
    /// Seed of the mission.
    pub seed: u64,
    /// What it is about.
    pub kind: Kind,
    /// The promise, and what was found instead.
    #[serde(flatten)]
    pub broken: Broken,
    /// The smallest scenario found in which it does not hold.
    pub scenario: String,
    /// File that holds it.
    pub file: Option<PathBuf>,
    /// Command that repeats it.
    pub again: String,
}

/// The answer; field names are those of the JSON.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Answer {
    /// Missions that were flown in lockstep.
    pub missions: u64,
    /// Missions among them that were also flown with simulated faults.
    pub simulated: u64,
    /// Seeds whose drafts were none that can be flown.
    pub unflyable: u64,
    /// Missions that were flown by real processes.
    pub live: u64,
    /// Decisions of all missions, each counted once.
    pub decisions: u64,
    /// The first mission that broke a promise.
    pub failure: Option<Failing>,
    /// Time it took, seconds.
    pub wall_s: f64,
}

/// Runs the command: done if every promise held, failed otherwise.
///
/// # Errors
/// If a scenario cannot be read or written, or a process not be started.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let started = Node::now();
    let shutdown = ShutdownSignal::new()?;
    let mut answer = Answer::default();
    let drafts = drafts(args)?;
    let (mut done, mut progress) = (0, Progress::begin("drafts", drafts.len() as u64, 0, started));
    for batch in drafts.chunks(16) {
        let checked: Vec<_> = batch
            .par_iter()
            .map(|(_, draft)| draft.as_ref().map(|draft| (draft, trial::check(draft))))
            .collect();
        for checked in checked {
            done += 1;
            progress.show(done, Node::now());
            let Some((draft, checked)) = checked else {
                answer.unflyable += 1;
                continue;
            };
            answer.missions += 1;
            match checked {
                Ok(checked) => {
                    answer.decisions += checked.flown.records.len() as u64;
                    answer.simulated += u64::from(checked.simulated);
                }
                Err(broken) => {
                    let smallest = smaller::shrink(draft, &broken.promise, |draft| trial::check(draft).err());
                    let broken = trial::check(&smallest).err().unwrap_or(broken);
                    answer.failure = Some(failing(&smallest, broken, args)?);
                }
            }
            if answer.failure.is_some() {
                break;
            }
        }
        if answer.failure.is_some() || shutdown.wait(std::time::Duration::ZERO) {
            break;
        }
    }
    progress.end();
    if answer.failure.is_none() {
        fly_live(args, &drafts, &mut answer, &shutdown)?;
    }
    answer.wall_s = Node::now().since_ns(started) as f64 / 1e9;
    print(&match args.format {
        Format::Json => serde_json::to_string(&answer).map_err(Failure::run)? + "\n",
        Format::Text => answer.text(),
    })?;
    Ok(if answer.failure.is_some() { Exit::Failed } else { Exit::Done })
}

/// The missions with their seeds; none for a seed whose drafts cannot be flown.
fn drafts(args: &Args) -> Result<Vec<(u64, Option<Draft>)>, Failure> {
    if let (Some(file), Some(kind)) = (&args.scenario, args.kind) {
        let text = scenario::text::read(file, scenario::text::TEXT_BYTES_MAX).map_err(Failure::usage)?;
        let scenario = Scenario::parse(&text, &file.display().to_string()).map_err(Failure::usage)?;
        scenario.clone().resolve().map_err(Failure::usage)?;
        planner::algorithm(&args.planner).map_err(Failure::usage)?;
        let planner = args.planner.parse().map_err(Failure::usage)?;
        let seed = args.seeds.0.start;
        return Ok(vec![(seed, Some(Draft { kind, seed, scenario, planner }))]);
    }
    let seeds = args.seeds.0.clone();
    Ok(seeds.map(|seed| (seed, Draft::of(args.kind.unwrap_or_else(|| Kind::of(seed)), seed))).collect())
}

/// Flies the first missions by real processes, one of which is killed now and then.
fn fly_live(
    args: &Args,
    drafts: &[(u64, Option<Draft>)],
    answer: &mut Answer,
    shutdown: &ShutdownSignal,
) -> Result<(), Failure> {
    if args.live == 0 {
        return Ok(());
    }
    let hopper = tool::sibling("hopper")?;
    let flyable = drafts.iter().filter_map(|(_, draft)| draft.as_ref());
    for draft in flyable.take(args.live as usize) {
        let alone = matches!(draft.kind, Kind::Hopper | Kind::Patrol).then_some(draft.planner);
        let world = World::of(draft.world().expect("a draft can be flown"), alone)?;
        let undisturbed = world.fly(draft.seed)?;
        let victim = Role::ALL[Chance::new(draft.seed, "victim").below(3) as usize];
        let last = undisturbed.decisions.saturating_sub(1).max(1);
        let plan = Plan::of(draft.seed, victim, world.seats().len(), (1, last));
        let folder = tempfile::Builder::new().prefix("hopper-fuzz-").tempdir().map_err(Failure::run)?;
        let flight = fly(&hopper, &plan, &world, folder.path(), undisturbed, shutdown)?;
        answer.live += 1;
        if let Some(broken) = flight.broken {
            let kept = folder.keep();
            let detail = format!(
                "{}\n  faults {:?}\n  journal and logs: {}",
                broken.detail,
                plan.faults,
                kept.display()
            );
            let broken = Broken { promise: broken.promise.into(), detail };
            answer.failure = Some(failing(draft, broken, args)?);
            return Ok(());
        }
    }
    Ok(())
}

/// Writes the scenario down.
fn failing(draft: &Draft, broken: Broken, args: &Args) -> Result<Failing, Failure> {
    let Draft { kind, seed, planner, .. } = draft;
    let scenario = draft.world().map(|world| world.resolved).unwrap_or_default();
    let file = args.out.join(format!("fuzz-{seed}.toml"));
    std::fs::create_dir_all(&args.out).map_err(Failure::run)?;
    std::fs::write(&file, &scenario).map_err(Failure::run)?;
    let kind_name = clap::ValueEnum::to_possible_value(kind).map(|value| value.get_name().to_owned());
    let again = format!(
        "hopper-qa fuzz-missions --kind {} --seeds {seed}..{} --planner {planner} --live {} --scenario {}",
        kind_name.unwrap_or_default(),
        seed + 1,
        args.live.min(1),
        file.display()
    );
    Ok(Failing { seed: *seed, kind: *kind, broken, scenario, file: Some(file), again })
}

impl Answer {
    fn text(&self) -> String {
        let mut text = String::new();
        let Self { missions, simulated, unflyable, live, decisions, failure, wall_s } = self;
        let _ = writeln!(
            text,
            "{missions} missions with {decisions} decisions in lockstep, {simulated} of them with simulated faults, {live} by \
             real processes, in {wall_s:.1} s"
        );
        if *unflyable > 0 {
            let _ = writeln!(text, "{unflyable} seeds without a mission that can be flown");
        }
        match failure {
            None => {
                let _ = writeln!(text, "no promise was broken");
            }
            Some(Failing { seed, broken, scenario, again, .. }) => {
                let _ =
                    writeln!(text, "{scenario}\nseed {seed} breaks: {}\n  {}", broken.promise, broken.detail);
                let _ = writeln!(text, "again: {again}");
            }
        }
        text
    }
}
