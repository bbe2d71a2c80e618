//! `hopper simulate`: seeds of the fault simulation, side by side on all cores.

use std::fmt::Write as _;
use std::ops::Range;
use std::str::FromStr;

use hopper::progress::Progress;
use node::{Exit, Failure, Node};
use rayon::prelude::*;
use report::Format;
use serde::Serialize;

use simulation::coverage::Coverage;
use simulation::fault::Plan;
use simulation::setup::Missions;
use simulation::violation::Violation;
use simulation::{Line, Report, Sometimes, shrink, simulate};

/// Seeds simulated before anything is looked at, for each job.
const BATCH_PER_JOB: u64 = 128;

/// Arguments of `hopper simulate`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// Seeds to simulate, the last left out.
    #[arg(long, default_value = "0..2000", value_name = "A..B")]
    seeds: Seeds,
    /// Whose missions: those of a hopper, of one to three rovers that cover ground, of a rover that helicopters scout for, of a
    /// hopper that they accompany, of two to five robots of any kind, or of a hopper whose hops land where they are meant to, on
    /// flat ground.
    #[arg(long, value_enum, default_value_t, value_name = "WHOSE")]
    missions: Whose,
    /// Seeds at once [default: one a core].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
    /// Form of the answer on standard output: text or json.
    #[arg(long, default_value_t)]
    format: Format,
}

/// Whose missions are simulated.
#[derive(Clone, Copy, Debug, Default, clap::ValueEnum)]
enum Whose {
    #[default]
    Hopper,
    Rovers,
    Scouts,
    Accompanied,
    Mixed,
    Protocol,
}

impl From<Whose> for Missions {
    fn from(whose: Whose) -> Self {
        match whose {
            Whose::Hopper => Missions::Hopper,
            Whose::Rovers => Missions::Rovers,
            Whose::Scouts => Missions::Scouts,
            Whose::Accompanied => Missions::Accompanied,
            Whose::Mixed => Missions::Mixed,
            Whose::Protocol => Missions::Protocol,
        }
    }
}

/// A range of seeds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Seeds(pub Range<u64>);

impl FromStr for Seeds {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let ends = text.split_once("..").and_then(|(from, to)| Some((from.parse().ok()?, to.parse().ok()?)));
        match ends {
            Some((from, to)) if from < to => Ok(Self(from..to)),
            _ => Err(format!("seeds are A..B with A below B, e.g. 0..2000; got {text:?}")),
        }
    }
}

/// What a range of seeds came to.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Campaign {
    /// The missions that were simulated.
    pub missions: Missions,
    /// Seeds simulated.
    pub seeds: u64,
    /// Events simulated.
    pub events: u64,
    /// Decisions executed.
    pub decisions: u64,
    /// Time that passed for the machines, seconds.
    pub virtual_s: f64,
    /// Longest time in which nothing was executed and no fault was felt, seconds.
    pub idle_s: f64,
    /// What came up, how often.
    pub coverage: Coverage,
    /// The first failure, if there is one.
    pub failure: Option<Box<Failing>>,
}

/// A seed that violates a promise, made small.
#[derive(Clone, Debug, Serialize)]
pub struct Failing {
    /// Repeats the violation, with the same flags.
    pub seed: u64,
    /// The promise broken, and what was seen.
    pub violation: Violation,
    /// Faults of the seed.
    pub faults: usize,
    /// The smallest plan of faults that still breaks the promise.
    pub plan: Plan,
    /// What happens with the faults of `plan`.
    pub trace: Vec<Line>,
}

impl Campaign {
    fn add(&mut self, report: &Report) {
        self.seeds += 1;
        self.events += report.events;
        self.decisions += report.decisions;
        self.virtual_s += report.virtual_ns as f64 / 1e9;
        self.idle_s = self.idle_s.max(report.idle_ns as f64 / 1e9);
        self.coverage.add(&report.coverage);
    }

    /// Rare events that should have come up in so many seeds, and did not.
    pub fn never(&self) -> impl Iterator<Item = &'static Sometimes> + '_ {
        self.coverage.never(self.missions, self.seeds)
    }
}

/// Simulates `seeds` on the threads there are, up to the first failure, which is made small. `progress` is called with
/// how many seeds are done.
pub fn sweep(missions: Missions, seeds: Range<u64>, mut progress: impl FnMut(u64)) -> Campaign {
    let mut campaign = Campaign { missions, ..Campaign::default() };
    let batch = BATCH_PER_JOB * rayon::current_num_threads() as u64;
    let mut from = seeds.start;
    while from < seeds.end {
        let to = seeds.end.min(from.saturating_add(batch));
        let numbers: Vec<u64> = (from..to).collect();
        let reports: Vec<Report> = numbers
            .into_par_iter()
            .with_max_len(8)
            .map(|seed| simulate(&Plan::of(missions, seed), false))
            .collect();
        for (seed, report) in (from..to).zip(&reports) {
            campaign.add(report);
            if let Some(violation) = &report.violation {
                campaign.failure = Some(Box::new(explain(missions, seed, violation)));
                return campaign;
            }
        }
        progress(to - seeds.start);
        from = to;
    }
    campaign
}

fn explain(missions: Missions, seed: u64, violation: &Violation) -> Failing {
    let whole = Plan::of(missions, seed);
    let plan = shrink::shrink(&whole, violation.rule, |plan| simulate(plan, false).violation);
    let Report { trace, violation: last, .. } = simulate(&plan, true);
    let violation = last.unwrap_or_else(|| violation.clone());
    Failing { seed, violation, faults: whole.faults.len(), plan, trace }
}

#[derive(Serialize)]
struct Answer<'a> {
    #[serde(flatten)]
    campaign: &'a Campaign,
    jobs: usize,
    wall_s: f64,
    events_per_s: f64,
    commit: &'static str,
    processor: String,
}

/// Runs the command: done if every promise held, failed otherwise.
///
/// # Errors
/// If standard output is closed.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let jobs =
        args.jobs.map_or_else(|| std::thread::available_parallelism().map_or(1, usize::from), usize::from);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs).build().map_err(Failure::run)?;
    let seeds = args.seeds.0.clone();
    let started = Node::now();
    let mut progress = Progress::begin("seeds", seeds.end - seeds.start, 0, started);
    let campaign =
        pool.install(|| sweep(args.missions.into(), seeds, |done| progress.show(done, Node::now())));
    progress.end();
    let wall_s = Node::now().since_ns(started) as f64 / 1e9;
    let answer = Answer {
        campaign: &campaign,
        jobs,
        wall_s,
        events_per_s: campaign.events as f64 / wall_s,
        commit: hopper::COMMIT,
        processor: node::host::processor(),
    };
    hopper::stdout::print(&match args.format {
        Format::Json => serde_json::to_string(&answer).map_err(Failure::run)? + "\n",
        Format::Text => answer.text(),
    })?;
    let never = campaign.never().next().is_some();
    Ok(if campaign.failure.is_some() || never { Exit::Failed } else { Exit::Done })
}

impl Answer<'_> {
    fn text(&self) -> String {
        let Self { campaign, jobs, wall_s, events_per_s, .. } = self;
        let Campaign { missions: _, seeds, events, decisions, virtual_s, idle_s, coverage, failure } =
            campaign;
        let mut text = String::new();
        for (group, names) in &coverage.0 {
            let counts: Vec<String> = names.iter().map(|(name, count)| format!("{name} {count}")).collect();
            let _ = writeln!(text, "{group}: {}", counts.join(", "));
        }
        let _ = writeln!(
            text,
            "{seeds} seeds, {decisions} decisions, {events} events, {virtual_s:.0} s of the machines' time in \
             {wall_s:.1} s on {jobs} {}: {events_per_s:.0} events/s",
            if *jobs == 1 { "thread" } else { "threads" }
        );
        let _ = writeln!(text, "at most {idle_s:.1} s without a decision or a fault");
        let never: Vec<String> =
            campaign.never().map(|event| format!("{} {}", event.group, event.name)).collect();
        if !never.is_empty() {
            let _ = writeln!(text, "never came up, and should have: {}", never.join(", "));
        }
        match failure {
            None => {
                let bound = 3.0 / *seeds as f64;
                let _ = writeln!(text, "no promise was broken: at 95 % in fewer than {bound:.1e} of seeds");
            }
            Some(failing) => {
                let Failing { seed, violation, faults, plan, trace } = &**failing;
                for Line { ms, text: line } in trace {
                    let _ = writeln!(text, "{ms:>12.3} ms  {line}");
                }
                let _ = writeln!(text, "seed {seed} breaks: {}", violation.rule);
                let _ = writeln!(text, "  {}", violation.detail);
                let _ = writeln!(text, "  with {} of its {faults} faults:", plan.faults.len());
                for fault in &plan.faults {
                    let _ = writeln!(
                        text,
                        "  decision {}, after {} ns: {:?}",
                        fault.decision, fault.after_ns, fault.kind
                    );
                }
            }
        }
        text
    }
}
