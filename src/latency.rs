//! `hopper latency`: where the time of decisions went, from a recording or a running instance.

use std::path::{Path, PathBuf};
use std::time::Duration;

use contract::limits::ASK_AGAIN_NS;
use contract::{Brief, Decision, MonotonicNs, PastRequest, RobotId, Role, Roster};
use node::peer::{Patience, TICK, accept};
use node::{Exit, Failure, Instance, Node};
use recording::steps;
use report::steps::{compare, plot};
use report::{Conditions, Format, Step, StepAccount};

use crate::bag::{at_fault, keep, load, open, print};

/// Latency of decisions: percentiles, misses, the worst and why.
#[derive(clap::Subcommand, Clone, Debug)]
pub enum Command {
    /// Report on a recording, a running instance, or two recordings of one mission side by side.
    Report(Args),
}

/// Arguments of `hopper latency report`.
#[derive(clap::Args, Clone, Debug)]
#[command(group(clap::ArgGroup::new("source").required(true).args(["file", "instance", "compare"])))]
pub struct Args {
    /// The recording.
    #[arg(value_name = "FILE")]
    file: Option<PathBuf>,
    /// A running instance, as far as it has come.
    #[arg(long, value_name = "NAME")]
    instance: Option<String>,
    /// Two recordings of one mission, decision by decision: Wilcoxon's signed-rank test.
    #[arg(long, num_args = 2, value_names = ["A", "B"], conflicts_with_all = ["hgrm", "svg", "budget"])]
    compare: Option<Vec<PathBuf>>,
    /// Budget of a decision, landing to commit; exit code 3 if one took longer [default: the mission's].
    #[arg(long, value_parser = humantime::parse_duration, value_name = "DURATION")]
    budget: Option<Duration>,
    /// Write the totals as a percentile distribution that HdrHistogram's plotters read.
    #[arg(long, value_name = "FILE")]
    hgrm: Option<PathBuf>,
    /// Draw the total of every decision.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Give up with exit code 4 when no hopper-sim is heard for this long.
    #[arg(long, default_value = "10s", value_parser = humantime::parse_duration, value_name = "DURATION")]
    wait: Duration,
    /// Form of the report on standard output: text or json.
    #[arg(long, default_value_t)]
    format: Format,
}

/// A mission's decisions, and what they were flown under.
struct Source {
    name: String,
    account: StepAccount,
    budget_ns: u64,
    conditions: Conditions,
}

/// Runs the command; exit code 3 if a decision missed its budget.
///
/// # Errors
/// If a recording cannot be read, an instance not be heard, or a file not be written.
pub fn run(command: &Command) -> Result<Exit, Failure> {
    let Command::Report(args) = command;
    if let Some([first, second]) = args.compare.as_deref() {
        return side_by_side(first, second, args.format);
    }
    let source = match (&args.file, &args.instance) {
        (Some(file), _) => recorded(file)?,
        (None, Some(name)) => match living(name, args.wait)? {
            Some(source) => source,
            None => return Ok(Exit::Interrupted),
        },
        (None, None) => unreachable!("one of the sources is required"),
    };
    let budget_ns = args.budget.map_or(source.budget_ns, |budget| budget.as_nanos() as u64);
    let report = source.account.report(budget_ns, source.conditions);
    if let Some(path) = &args.hgrm {
        keep(path, source.account.percentile_distribution().as_bytes())?;
    }
    if let Some(path) = &args.svg {
        keep(path, plot(&source.account, budget_ns, &format!("Latency of {}", source.name)).as_bytes())?;
    }
    match args.format {
        Format::Text => print(&report.to_string())?,
        Format::Json => print(&format!("{}\n", serde_json::to_string(&report).map_err(Failure::run)?))?,
    }
    Ok(if report.misses > 0 { Exit::Threshold } else { Exit::Done })
}

fn side_by_side(first: &Path, second: &Path, format: Format) -> Result<Exit, Failure> {
    let [first, second] = [recorded(first)?, recorded(second)?];
    let comparison = compare(&first.account, &second.account);
    match format {
        Format::Text => print(&format!(
            "first: {}\n{}\n\nsecond: {}\n{}\n\n{comparison}",
            first.name, first.conditions, second.name, second.conditions
        ))?,
        Format::Json => {
            let value = serde_json::json!({
                "first": { "name": first.name, "conditions": first.conditions },
                "second": { "name": second.name, "conditions": second.conditions },
                "test": "wilcoxon signed-rank, two-sided, normal approximation",
                "comparison": comparison,
            });
            print(&format!("{value}\n"))?;
        }
    }
    Ok(Exit::Done)
}

fn recorded(path: &Path) -> Result<Source, Failure> {
    let bytes = load(path)?;
    let recording = open(path, &bytes)?;
    let flown = steps(&recording).map_err(|error| at_fault(path, &error))?;
    let told = |key| recording.told("hopper", key).map(str::to_owned);
    let hosts = flown.hosts.len() as f64;
    let busy = || flown.hosts.iter().map(|host| host.busy);
    let most = |values: &mut dyn Iterator<Item = f64>| values.reduce(f64::max);
    let executed = flown.state.map_or(0, |state| state.decision.0).max(flown.steps.len() as u64);
    let conditions = Conditions {
        clock: told("clock").unwrap_or_else(|| "not known".into()),
        pace: told("pace"),
        processor: told("processor"),
        cores: flown.hosts.first().map(|host| host.cores),
        busy_mean: (hosts > 0.0).then(|| busy().sum::<f64>() / hosts),
        busy_max: most(&mut busy()),
        load_max: most(&mut flown.hosts.iter().map(|host| host.load_1min)),
        missing: executed - flown.steps.len() as u64,
        ..Conditions::default()
    };
    Ok(Source {
        name: path.display().to_string(),
        account: StepAccount::new(flown.steps, flown.happenings),
        budget_ns: flown.brief.limits.decision_budget_ns,
        conditions,
    })
}

/// What the journal of a running hopper-sim tells at present; `None` if interrupted.
fn living(name: &str, wait: Duration) -> Result<Option<Source>, Failure> {
    let instance = Instance::new(name)?;
    let mut node = Node::visit(&instance)?;
    let mut briefs = node.brief_reader()?;
    let mut past = node.past_client()?;
    let mut patience = Patience::new(Some(wait), &instance);
    let mut roster = Roster::default();
    let (mut brief, mut asked) = (None::<Brief>, MonotonicNs(0));
    let mut all: Vec<Step> = Vec::new();
    let mut ended = false;
    while !ended {
        let now = Node::now();
        if let Some(known) = brief.filter(|_| now.since_ns(asked) >= ASK_AGAIN_NS) {
            asked = now;
            let from = Decision(all.len() as u64);
            past.request(&PastRequest { run: known.run, robot: RobotId(0), from })?;
        }
        node.wait(TICK);
        if node.stop_requested().is_some() {
            return Ok(None);
        }
        for beat in node.heartbeats().into_iter().flatten() {
            roster.observe(beat, Node::now());
        }
        if let Some(told) = accept(briefs.newest()) {
            (brief, asked) = (Some(told), MonotonicNs(0));
            all.clear();
        }
        let page = accept(past.receive()).filter(|page| brief.is_some_and(|brief| brief.run == page.run));
        if let Some(page) = page.filter(|page| page.from.0 == all.len() as u64) {
            ended = page.records.len() < contract::limits::PAST_PAGE_RECORDS;
            all.extend(page.records.iter().map(Step::from));
            asked = MonotonicNs(0);
        }
        let lacks = brief.is_none().then_some("hopper-sim: no brief yet");
        let silent = !roster.has(Role::HopperSim, Node::now());
        patience.check(lacks.or(silent.then_some("hopper-sim")), Node::now())?;
    }
    let load = node::host::load();
    let conditions = Conditions {
        clock: "CLOCK_MONOTONIC of this host; a commit is the moment at which its append was asked for"
            .into(),
        processor: Some(node::host::processor()),
        cores: Some(node::host::cores()),
        load_max: Some(load.load_1min),
        ..Conditions::default()
    };
    Ok(Some(Source {
        name: format!("instance {name}"),
        account: StepAccount::new(all, Vec::new()),
        budget_ns: brief.map_or(0, |brief| brief.limits.decision_budget_ns),
        conditions,
    }))
}
