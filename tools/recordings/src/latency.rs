//! `hopper latency`: reports the latency of decisions, from a recording or a running instance.

use std::path::{Path, PathBuf};
use std::time::Duration;

use contract::limits::PAST_PAGE_RECORDS;
use contract::protocol::peer_table::LISTENING_NS;
use contract::{Brief, Heartbeat, MonotonicNs, PastPage, PastRequest, PeerTable, RobotId, Role};
use follow::{Link, PastFollower};
use hopper::stdout::print;
use node::{Exit, Failure, Instance, Node};
use process::{Client as _, Patience, Ports, Reader as _, TICK_NS, accept};
use recording::last_run;
use report::decisions::{boot_began, compare, plot};
use report::{Conditions, DecisionTiming, DecisionTimings, Disturbance, Format};
use serde::Serialize;

use crate::bag::{at_fault, keep, load, open, warn_of_skipped};

/// Latency of decisions: percentiles, misses, the worst and why.
#[derive(clap::Subcommand, Clone, Debug)]
pub enum Command {
    /// Report on a recording, a running instance, or two recordings of one mission side by side.
    #[command(
        after_help = "Examples:\n  hopper latency report hard.mcap --budget 600ms --svg latency.svg\n  hopper latency report --instance hopper\n  hopper latency report --compare a.mcap b.mcap"
    )]
    Report(Args),
}

/// Arguments of `hopper latency report`.
#[derive(clap::Args, Clone, Debug)]
#[command(group(clap::ArgGroup::new("source").required(true).args(["file", "instance", "compare"])))]
pub struct Args {
    /// Recording to report on.
    #[arg(value_name = "FILE")]
    file: Option<PathBuf>,
    /// Running instance to report on, up to its last decision.
    #[arg(long, value_name = "NAME")]
    instance: Option<String>,
    /// Two recordings of one mission, decision by decision: Wilcoxon's signed-rank test.
    #[arg(long, num_args = 2, value_names = ["A", "B"], conflicts_with_all = ["hgrm", "svg", "budget"])]
    compare: Option<Vec<PathBuf>>,
    /// Budget of a decision, landing to commit; exit code 3 if one took longer. Without it the report has that of the mission.
    #[arg(long, value_parser = humantime::parse_duration, value_name = "DURATION")]
    budget: Option<Duration>,
    /// Write the percentile distribution of the totals, for HdrHistogram's plotters.
    #[arg(long, value_name = "FILE", value_parser = node::output_path())]
    hgrm: Option<PathBuf>,
    /// Draw the total of every decision.
    #[arg(long, value_name = "FILE", value_parser = node::output_file_of(&["svg"]))]
    svg: Option<PathBuf>,
    /// Give up with exit code 4 when no hopper-sim is heard for this long.
    #[arg(long, default_value = "10s", value_parser = humantime::parse_duration, value_name = "DURATION")]
    wait: Duration,
    /// Format of the report on standard output: text or json.
    #[arg(long, default_value_t)]
    format: Format,
}

/// A mission's decisions, and what they were flown under.
struct Source {
    name: String,
    account: DecisionTimings,
    brief: Brief,
    seed: Option<String>,
    conditions: Conditions,
}

/// What two missions that are compared do not have in common, and should. The names are those of the JSON.
#[derive(Debug, PartialEq, Serialize)]
struct Differs {
    what: &'static str,
    first: String,
    second: String,
}

/// Runs the command; exit code 3 if a decision missed the budget that was asked for.
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
    let budget_ns =
        args.budget.map_or(source.brief.limits.decision_budget_ns, |budget| budget.as_nanos() as u64);
    let report = source.account.report(budget_ns, source.conditions);
    if let Some(path) = &args.hgrm {
        keep(path, source.account.percentile_distribution().as_bytes())?;
        tracing::info!("wrote {}", path.display());
    }
    if let Some(path) = &args.svg {
        keep(path, plot(&source.account, budget_ns, &format!("Latency of {}", source.name)).as_bytes())?;
        tracing::info!("wrote {}", path.display());
    }
    match args.format {
        Format::Text => print(&report.to_string())?,
        Format::Json => print(&format!("{}\n", serde_json::to_string(&report).map_err(Failure::run)?))?,
    }
    Ok(if args.budget.is_some() && report.misses > 0 { Exit::Threshold } else { Exit::Done })
}

fn side_by_side(first: &Path, second: &Path, format: Format) -> Result<Exit, Failure> {
    let [first, second] = [recorded(first)?, recorded(second)?];
    let differs = differences(&first, &second)?;
    let comparison = compare(&first.account, &second.account);
    match format {
        Format::Text => {
            let mut text = format!(
                "first: {}\n{}\n\nsecond: {}\n{}\n\n{comparison}",
                first.name, first.conditions, second.name, second.conditions
            );
            for Differs { what, first, second } in differs {
                text += &format!(
                    "Warning: the {what} of the first is {first}, of the second {second}: their decisions are not \
                     the same, and the test says little.\n"
                );
            }
            print(&text)?;
        }
        Format::Json => {
            let value = serde_json::json!({
                "first": { "name": first.name, "conditions": first.conditions },
                "second": { "name": second.name, "conditions": second.conditions },
                "differs": differs,
                "test": "wilcoxon signed-rank, two-sided, normal approximation",
                "comparison": comparison,
            });
            print(&format!("{value}\n"))?;
        }
    }
    Ok(Exit::Done)
}

/// What should be the same of both and is not.
///
/// # Errors
/// Exit code 2 if they are of different scenarios: then decision *n* of the one is nothing to that of the other.
fn differences(first: &Source, second: &Source) -> Result<Vec<Differs>, Failure> {
    let scenario = |source: &Source| {
        let hash: String = source.brief.scenario_hash[..6].iter().map(|byte| format!("{byte:02x}")).collect();
        format!("{} ({hash}) of {}", source.brief.scenario, source.name)
    };
    if first.brief.scenario_hash != second.brief.scenario_hash {
        return Err(Failure::usage(format!(
            "--compare needs two recordings of one scenario, got {} and {}",
            scenario(first),
            scenario(second)
        )));
    }
    let seed = |source: &Source| source.seed.clone().unwrap_or_else(|| "not known".into());
    let planners = |source: &Source| {
        let mut names: Vec<_> =
            source.account.decisions().iter().map(|step| step.leader.planner.to_string()).collect();
        names.dedup();
        if names.is_empty() { "none".into() } else { names.join(", then ") }
    };
    let pairs = [("seed", seed(first), seed(second)), ("planner", planners(first), planners(second))];
    let differs = pairs.into_iter().map(|(what, first, second)| Differs { what, first, second });
    Ok(differs.filter(|differs| differs.first != differs.second).collect())
}

fn recorded(path: &Path) -> Result<Source, Failure> {
    let bytes = load(path)?;
    let recording = open(path, &bytes)?;
    let flown = last_run(&recording).map_err(|error| at_fault(path, &error))?;
    warn_of_skipped(path, &flown.skipped);
    let metadata = recording.metadata_of(Some(flown.brief.run), flown.state.map(|state| state.digest));
    let of_recorder = |key| metadata.recorder(key).map(str::to_owned);
    let of_mission = |key| metadata.mission(key).map(str::to_owned);
    let hosts = flown.machine_loads.len() as f64;
    let busy = || flown.machine_loads.iter().map(|host| host.busy);
    let most = |values: &mut dyn Iterator<Item = f64>| values.reduce(f64::max);
    let executed = flown.state.map_or(0, |state| state.decision.0).max(flown.decisions.len() as u64);
    let conditions = Conditions {
        clock: of_recorder("clock").unwrap_or_else(|| "not known".into()),
        pace: of_mission("pace"),
        processor: of_recorder("processor"),
        cores: flown.machine_loads.first().map(|host| host.cores),
        busy_mean: (hosts > 0.0).then(|| busy().sum::<f64>() / hosts),
        busy_max: most(&mut busy()),
        load_max: most(&mut flown.machine_loads.iter().map(|host| host.load_1min)),
        missing: executed - flown.decisions.len() as u64,
        ..Conditions::default()
    };
    Ok(Source {
        name: path.display().to_string(),
        account: DecisionTimings::new(flown.decisions, flown.disturbances),
        brief: flown.brief,
        seed: of_mission("seed"),
        conditions,
    })
}

/// What the journal of a running hopper-sim tells at present; `None` if interrupted.
fn living(name: &str, wait: Duration) -> Result<Option<Source>, Failure> {
    let instance = Instance::new(name)?;
    let mut node = Node::visit(&instance)?;
    let mut briefs = node.reader::<Brief>(RobotId(0), false)?;
    let mut heartbeats = node.reader::<Heartbeat>(RobotId(0), false)?;
    let mut past = node.client::<PastRequest>(RobotId(0))?;
    let mut patience = Patience::new(Some(wait));
    let mut peer_table = PeerTable::default();
    let mut gathered = Gathered::default();
    // A process that was started again is known by its heartbeat alone.
    let all_heard = Node::now().plus_ns(LISTENING_NS);
    let flown = loop {
        let now = Node::now();
        if now >= all_heard
            && let Some(request) = gathered.ask(now)
        {
            past.request(request)?;
        }
        node.sleep(Duration::from_nanos(TICK_NS));
        if node.stop_requested() {
            return Ok(None);
        }
        for beat in heartbeats.drain().into_iter().flatten() {
            peer_table.observe(beat, Node::now());
        }
        if let Some(brief) = accept(briefs.newest()) {
            gathered.begin(brief);
        }
        if let Some(flown) = accept(past.receive()).and_then(|page| gathered.page(&page)) {
            break flown;
        }
        let lacks = gathered.brief.is_none().then_some("hopper-sim: no brief yet");
        let silent = !peer_table.has(Role::HopperSim, Node::now());
        patience.check(lacks.or(silent.then_some("hopper-sim")), &mut node)?;
    };
    let (brief, steps) = flown;
    let restarts = restarts(&steps, peer_table.live(Node::now()).map(|peer| peer.beat), node::host::started);
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
        account: DecisionTimings::new(steps, restarts),
        brief,
        seed: None,
        conditions,
    }))
}

/// The processes that were started again since the first of `steps`: of those before them nobody is left to be heard.
fn restarts(
    steps: &[DecisionTiming],
    living: impl Iterator<Item = Heartbeat>,
    started: impl Fn(u32) -> Option<MonotonicNs>,
) -> Vec<Disturbance> {
    let Some(began) = boot_began(steps) else { return Vec::new() };
    // Planners are told apart by their commands, and nothing depends on a monitor.
    let is_named = |beat: &Heartbeat| matches!(beat.role, Role::HopperSim | Role::Perception);
    let restart = |beat: Heartbeat| {
        let at = started(beat.pid)?;
        (at > began).then(|| Disturbance::restart(beat.role, at))
    };
    living.filter(is_named).filter_map(restart).collect()
}

/// The executed decisions of a run, asked for page by page.
#[derive(Default)]
struct Gathered {
    brief: Option<Brief>,
    steps: Vec<DecisionTiming>,
    past: PastFollower,
}

impl Gathered {
    /// Begins to gather the decisions of a run. A run that is announced once more, as to a
    /// newcomer, changes nothing.
    fn begin(&mut self, brief: Brief) {
        if self.brief.as_ref().is_none_or(|known| known.run != brief.run) {
            *self = Self { brief: Some(brief), ..Self::default() };
        }
    }

    /// What to ask for at `now`.
    fn ask(&mut self, now: MonotonicNs) -> Option<PastRequest> {
        self.past.ask(self.brief.as_ref()?.run, RobotId(0), now)
    }

    /// Takes a page; the last one, which is not full, gives all there is.
    fn page(&mut self, page: &PastPage) -> Option<(Brief, Vec<DecisionTiming>)> {
        let brief = self.brief.clone().filter(|brief| brief.run == page.run)?;
        let is_wanted = page.from == self.past.due();
        for record in &page.records {
            match self.past.link(record) {
                Link::Next => {
                    self.steps.push(DecisionTiming::from(record));
                    self.past.fold(record);
                }
                Link::OtherDecision => {}
                Link::Broken => return None,
                Link::PastIsLost => {
                    *self = Self { brief: Some(brief), ..Self::default() };
                    return None;
                }
            }
        }
        let is_last = is_wanted && page.records.len() < PAST_PAGE_RECORDS;
        is_last.then(|| (brief, std::mem::take(&mut self.steps)))
    }
}

#[cfg(test)]
mod tests {
    use contract::{Decision, Digest, Record, RunId};

    use super::*;

    fn page(run: RunId, from: u64, records: usize) -> PastPage {
        let (flown, _) = hostile::fixtures::flown();
        let digest = |decision: u64| Digest([decision as u8; 32]);
        let record = |decision: u64| Record {
            decision: Decision(decision),
            previous: digest(decision),
            digest: digest(decision + 1),
            ..flown[decision as usize % flown.len()]
        };
        let records: Vec<Record> = (from..from + records as u64).map(record).collect();
        PastPage { run, robot: RobotId(0), from: Decision(from), records }
    }

    /// P-LATENCY-ANNOUNCED: A run that is announced again costs a latency report nothing that it
    /// has gathered.
    #[test]
    fn a_run_that_is_announced_again_loses_no_page() {
        let brief = hostile::fixtures::brief();
        let mut gathered = Gathered::default();
        assert_eq!(gathered.ask(MonotonicNs(1)), None);
        gathered.begin(brief.clone());
        assert_eq!(gathered.ask(MonotonicNs(1)).unwrap().from, Decision(0));
        assert_eq!(gathered.ask(MonotonicNs(2)), None, "nobody asks twice at once");
        assert!(gathered.page(&page(brief.run, 0, PAST_PAGE_RECORDS)).is_none());
        gathered.begin(brief.clone());
        let next = PAST_PAGE_RECORDS as u64;
        assert_eq!(gathered.ask(MonotonicNs(3)).unwrap().from, Decision(next));
        assert!(gathered.page(&page(brief.run, 0, 1)).is_none(), "a page come twice is none");
        assert_eq!(gathered.page(&page(brief.run, next, 2)).unwrap().1.len(), PAST_PAGE_RECORDS + 2);

        assert!(gathered.page(&page(brief.run, 0, PAST_PAGE_RECORDS)).is_none());
        let other = Brief { run: RunId(brief.run.0 + 1), ..brief };
        gathered.begin(other.clone());
        assert_eq!(gathered.ask(MonotonicNs(4)).unwrap().from, Decision(0));
        assert!(gathered.page(&page(brief.run, 0, 1)).is_none());
        assert_eq!(gathered.page(&page(other.run, 0, 1)).unwrap().1.len(), 1);
    }

    /// P-LATENCY-SAME: Recordings of two scenarios are not compared; another seed or planner is
    /// reported.
    #[test]
    fn missions_of_two_scenarios_are_not_compared_and_other_differences_are_told() {
        let source = |brief: Brief, seed: Option<&str>, planner: &str| {
            let (records, _) = hostile::fixtures::flown();
            let mut steps: Vec<DecisionTiming> = records.iter().map(DecisionTiming::from).collect();
            for step in &mut steps {
                step.leader.planner = planner.parse().unwrap();
                step.timing.committed = MonotonicNs(u64::MAX);
            }
            Source {
                name: "a.mcap".into(),
                account: DecisionTimings::new(steps, Vec::new()),
                brief,
                seed: seed.map(str::to_owned),
                conditions: Conditions::default(),
            }
        };
        let brief = hostile::fixtures::brief();
        let first = source(brief.clone(), Some("3"), "mdp");
        assert_eq!(differences(&first, &source(brief.clone(), Some("3"), "mdp")).unwrap(), []);
        let other = differences(&first, &source(brief.clone(), None, "greedy")).unwrap();
        let told: Vec<_> = other.iter().map(|d| (d.what, d.first.as_str(), d.second.as_str())).collect();
        assert_eq!(told, [("seed", "3", "not known"), ("planner", "mdp", "greedy")]);
        let elsewhere = source(Brief { scenario_hash: [7; 32], ..brief }, Some("3"), "mdp");
        let failure = differences(&first, &elsewhere).unwrap_err();
        assert_eq!(failure.exit, Exit::Usage);
        assert!(failure.message.contains("one scenario, got") && failure.message.contains("070707070707"));
    }
}
