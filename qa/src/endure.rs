//! `hopper endure`: a long mission, of a patrol or of several robots, whose processes are killed again and again.
//!
//! It checks that nothing grows: the memory of each process, the nodes and files of the middleware, the time a
//! decision takes. Samples are taken at equal numbers of decisions; the first tenth of them is compared with the rest, and
//! the slope of the latency is given with its 95 % interval. A mission of several robots ends as it does in lockstep.

use std::ffi::OsString;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::time::Duration;

use contract::{Decision, Name, RobotId, Role, State, Status};
use hopper::mission::OutputDir;
use hopper::mission::child::Supervised;
use hopper::stdout::print;
use hopper::tool;
use hopper_sim::Pace;
use hopper_sim::shell::MissionArgs;
use node::host::Memory;
use node::inspect::{NodeHealth, nodes};
use node::{Exit, Failure, Instance, Node, Reader};
use process::{Ports, Reader as _};
use report::{Latency, Summary, table};
use scenario::{HopperGoal, RobotRules, Scenario};
use serde::Serialize;

use crate::chaos::World;

/// Longest pause between two checks.
const PERIOD: Duration = Duration::from_millis(5);

/// How long processes may take to end after the mission, nanoseconds.
const FAREWELL_NS: u64 = 10_000_000_000;

/// A mission without a decision for this long has stalled, nanoseconds.
const STALL_NS: u64 = 120_000_000_000;

/// Growth over the first tenth of the samples that still counts as constant, bytes: the pages that an allocator keeps
/// differ from process to process.
const GROWTH_MAX_BYTES: u64 = 2 << 20;

/// Arguments of `hopper endure`.
#[derive(clap::Args, Clone, Debug)]
#[command(mut_arg("scenario", |arg| arg.help("Scenario, a patrol or one of several robots: built in or a TOML file [default: patrol]")))]
pub struct Args {
    #[command(flatten)]
    mission: MissionArgs,
    /// Hops of a patrol to fly [default: the scenario's].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1 << 32))]
    hops: Option<u64>,
    /// Decisions between two kills, of each process in turn; 0 for none.
    #[arg(long, default_value_t = 10_000, value_name = "N")]
    kill_every: u64,
    /// Samples to take.
    #[arg(long, default_value_t = 100, value_name = "N", value_parser = clap::value_parser!(u64).range(10..))]
    samples: u64,
    #[arg(long, value_name = "NAME", help = format!(
        "Algorithm of a patrol's planner: {} [default: mdp]; several robots name theirs in the scenario",
        planner::ALGORITHMS.join(", ")
    ))]
    planner: Option<Name>,
    /// Name of the instance.
    #[arg(long, env = "HOPPER_INSTANCE", default_value = "endure", value_name = "NAME")]
    instance: String,
    /// Folder for the journal [default: a new folder under out/].
    #[arg(long, value_name = "DIR", value_parser = node::output_path())]
    out: Option<PathBuf>,
    /// Format of the answer on standard output: text or json.
    #[arg(long, default_value_t)]
    format: report::Format,
}

/// Memory, middleware and latency at one decision.
#[derive(Clone, Debug, Serialize)]
pub struct Sample {
    /// The decision that was due when it was taken.
    pub decision: Decision,
    /// Memory of the processes of each role that they share with no other, bytes; `None` while one is being started.
    pub own_bytes: [Option<u64>; 4],
    /// Resident memory of the processes of each role, shared memory included, bytes.
    pub resident_bytes: [Option<u64>; 4],
    /// Nodes of the middleware whose process is alive.
    pub nodes_alive: usize,
    /// Nodes whose process is dead and which are not cleaned up yet.
    pub nodes_dead: usize,
    /// Files of the instance in shared memory.
    pub files: usize,
    /// Median of landing to commit since the last sample, microseconds.
    pub p50_us: f64,
    /// 99th percentile of landing to commit since the last sample, microseconds.
    pub p99_us: f64,
}

/// Memory of one role over the run.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Growth {
    /// Role of the processes measured.
    pub role: Role,
    /// Largest own memory in the first tenth of the samples, bytes.
    pub first_tenth_max_bytes: u64,
    /// Largest own memory in the other samples, bytes.
    pub rest_max_bytes: u64,
    /// Largest resident memory, shared memory included, bytes.
    pub resident_max_bytes: u64,
    /// Whether the rest exceeds the first tenth by no more than `GROWTH_MAX_BYTES`.
    pub constant: bool,
}

/// Slope of the least-squares line through the samples.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Slope {
    /// Increase, microseconds per 100,000 hops.
    pub us_per_100k_hops: f64,
    /// Half of its 95 % interval, microseconds per 100,000 hops.
    pub half_width_us: f64,
}

/// The answer; field names are those of the JSON.
#[derive(Clone, Debug, Serialize)]
pub struct Answer {
    /// Status in which the mission ended.
    pub outcome: report::Ending,
    /// Decisions that were executed.
    pub decisions: u64,
    /// Goals visited on the patrol.
    pub visits: u64,
    /// Processes killed by this command.
    pub kills: u64,
    /// Time the whole run took, seconds.
    pub wall_s: f64,
    /// Memory by role, in the order of [`Role::ALL`].
    pub memory: Vec<Growth>,
    /// Nodes left after all processes had ended.
    pub leaked_nodes: usize,
    /// Files left in shared memory after all processes had ended.
    pub leaked_files: usize,
    /// Largest number of nodes in a sample, dead ones included.
    pub nodes_max: usize,
    /// Largest number of files in a sample.
    pub files_max: usize,
    /// Slope of the median of landing to commit; `None` with fewer than three samples.
    pub p50: Option<Slope>,
    /// Slope of its 99th percentile.
    pub p99: Option<Slope>,
    /// Digest of the last decision.
    pub digest: String,
    /// Whether outcome and digest are those of lockstep; `None` of a patrol, which is too long to be flown twice.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub as_lockstep: Option<bool>,
    /// All samples in order.
    pub samples: Vec<Sample>,
}

/// The processes of the run.
struct Processes {
    node: Node,
    instance: Instance,
    states: Reader<State>,
    /// hopper-sim, perception, the planners, monitor.
    children: Vec<Supervised>,
    kills: u64,
}

/// Runs the command: done if the patrol was flown, or the mission of several robots ended as in lockstep, nothing leaked and
/// memory is constant; exit code 3 if only memory grew.
///
/// # Errors
/// If the scenario is neither a patrol nor one of several robots, the output folder holds a mission, or the processes cannot run.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let mut mission = args.mission.clone();
    mission.scenario.get_or_insert_with(|| "patrol".into());
    let mut scenario = mission.scenario()?;
    let is_patrol = hops_of_patrol(&mut scenario).is_some();
    if !is_patrol && scenario.robots.is_empty() {
        let need = "a long run needs a patrol, brief.goals, or several robots, [[robots]]";
        return Err(Failure::new(Exit::Usage, need));
    }
    if let Some(hops) = args.hops {
        match hops_of_patrol(&mut scenario) {
            Some(hops_max) => *hops_max = hops,
            None => return Err(Failure::new(Exit::Usage, "--hops needs a patrol: brief.goals")),
        }
    }
    let world = scenario.resolve().map_err(Failure::usage)?;
    let flown = World::of(world.clone(), args.planner)?;
    let lockstep = if is_patrol { None } else { Some(flown.fly(mission.seed())?) };
    let decisions = match (world.brief.visits(), lockstep) {
        (Some(visits), _) => visits.hops_max,
        (None, lockstep) => lockstep.map_or(0, |undisturbed| undisturbed.decisions),
    };
    let (output_dir, journal) = OutputDir::open(args.out.clone(), &world, mission.seed())?;
    output_dir.describe(&world, mission.seed())?;
    drop(journal);
    let started = Node::now();
    let mut processes = Processes::start(args, &flown, mission.seed(), mission.pace, &output_dir)?;
    let samples = processes.watch(args, decisions)?;
    let summary = processes.end()?;
    let (instance, kills) = (processes.instance.clone(), processes.kills);
    drop(processes);
    let leaked_nodes = if instance.exists() { nodes(&instance)?.len() } else { 0 };
    let leaked_files = instance.files().len() + usize::from(instance.exists());
    let _ = instance.clean()?;
    let answer = Answer {
        outcome: summary.outcome,
        decisions: summary.decisions,
        visits: summary.visits,
        kills,
        wall_s: Node::now().since_ns(started) as f64 / 1e9,
        memory: growth(&samples),
        leaked_nodes,
        leaked_files,
        nodes_max: samples.iter().map(|one| one.nodes_alive + one.nodes_dead).max().unwrap_or(0),
        files_max: samples.iter().map(|one| one.files).max().unwrap_or(0),
        p50: slope(samples.iter().map(|one| (one.decision.0 as f64, one.p50_us))),
        p99: slope(samples.iter().map(|one| (one.decision.0 as f64, one.p99_us))),
        digest: summary.digest.to_string(),
        as_lockstep: lockstep.map(|need| {
            (summary.digest, summary.outcome) == (need.digest, report::Ending::Mission(need.outcome))
        }),
        samples,
    };
    print(&match args.format {
        report::Format::Json => serde_json::to_string(&answer).map_err(Failure::run)? + "\n",
        report::Format::Text => answer.text(),
    })?;
    Ok(answer.exit())
}

/// After how many hops a patrol ends; `None` if the scenario is none.
fn hops_of_patrol(scenario: &mut Scenario) -> Option<&mut u64> {
    if let Some(RobotRules::Hopper(rules)) = scenario.robots.first_mut()
        && let Some(HopperGoal::Visit(visits)) = &mut rules.goal
    {
        return Some(&mut visits.hops_max);
    }
    if scenario.brief.goals.is_empty() { None } else { Some(&mut scenario.brief.hops_max) }
}

impl Processes {
    fn start(
        args: &Args,
        world: &World,
        seed: u64,
        pace: Pace,
        output_dir: &OutputDir,
    ) -> Result<Self, Failure> {
        let instance = Instance::new(&args.instance)?;
        let _ = instance.clean()?;
        let mut node = Node::visit(&instance)?;
        let states = node.reader(RobotId(0), false)?;
        let words = |words: &[&str]| -> Vec<OsString> {
            words.iter().copied().chain(["--instance", &args.instance]).map(OsString::from).collect()
        };
        let (scenario, journal) = (output_dir.dir().join("scenario.toml"), output_dir.journal_dir());
        let mut sim = words(&["sim", "--format", "json", "--linger", "10s"]);
        sim.extend(["--seed".into(), seed.to_string().into(), "--pace".into(), pace.to_string().into()]);
        sim.extend(["--scenario".into(), scenario.into_os_string()]);
        sim.extend(["--journal".into(), journal.into_os_string()]);
        let hopper = tool::sibling("hopper")?;
        let mut children = vec![
            Supervised::start(&hopper, Role::HopperSim, sim)?,
            Supervised::start(&hopper, Role::Perception, words(&["perception"]))?,
        ];
        for seat in world.seats() {
            let robots: Vec<String> = seat.robots.iter().map(|robot| robot.to_string()).collect();
            let planner =
                words(&["planner", "--algorithm", seat.planner.as_str(), "--robot", &robots.join(",")]);
            children.push(Supervised::start(&hopper, Role::Planner, planner)?);
        }
        children.push(Supervised::start(&hopper, Role::Monitor, words(&["monitor"]))?);
        Ok(Self { node, instance, states, children, kills: 0 })
    }

    /// Kills and samples until the mission ends.
    fn watch(&mut self, args: &Args, decisions: u64) -> Result<Vec<Sample>, Failure> {
        let every = (decisions / args.samples).max(1);
        let (mut due, mut moved) = (Decision(0), Node::now());
        let mut latency = Latency::new(u64::MAX);
        let mut samples = Vec::new();
        let mut victims = (0..self.children.len()).cycle();
        loop {
            self.node.sleep(PERIOD);
            if self.node.stop_requested() {
                return Err(Failure::new(Exit::Interrupted, "interrupted"));
            }
            let mut status = Status::Underway;
            for state in self.states.drain().into_iter().flatten() {
                // States that are published again, and those from before a kill, count once.
                if state.decision > due {
                    (due, moved) = (state.decision, Node::now());
                    latency.record(&state.last_timing, 0);
                }
                status = state.status;
            }
            if status.is_over() {
                return Ok(samples);
            }
            for child in &mut self.children {
                if let Some(ended) = child.ended()? {
                    return Err(Failure::run(format!("{} ended by itself: {ended}", child.role)));
                }
            }
            // A sample without a decision would have a latency of zero.
            if latency.decisions() > 0 && due.0 >= every * (samples.len() as u64 + 1) {
                samples.push(self.sample(due, &latency)?);
                latency = Latency::new(u64::MAX);
            }
            if args.kill_every > 0 && due.0 >= args.kill_every * (self.kills + 1) {
                let victim = victims.next().expect("a cycle has no end");
                tracing::info!("decision {due}: killing {}", self.children[victim].role);
                self.kill(victim)?;
            }
            if Node::now().since_ns(moved) > STALL_NS {
                return Err(Failure::run(format!("the mission stalls at decision {due}")));
            }
        }
    }

    fn kill(&mut self, victim: usize) -> Result<(), Failure> {
        let child = &mut self.children[victim];
        child.kill();
        while child.ended()?.is_none() {
            std::thread::sleep(Duration::from_millis(1));
        }
        self.kills += 1;
        child.restart()
    }

    fn sample(&self, decision: Decision, latency: &Latency) -> Result<Sample, Failure> {
        let nodes = nodes(&self.instance)?;
        let alive = nodes.iter().filter(|node| node.health == NodeHealth::Alive).count();
        let memory = |role: Role, of: &dyn Fn(Memory) -> u64| {
            let of_role = self.children.iter().filter(|child| child.role == role);
            of_role.map(|child| node::host::memory(child.pid()).map(of)).sum()
        };
        let total = latency.total();
        Ok(Sample {
            decision,
            own_bytes: Role::ALL.map(|role| memory(role, &|memory| memory.own_bytes)),
            resident_bytes: Role::ALL.map(|role| memory(role, &|memory| memory.resident_bytes)),
            nodes_alive: alive,
            nodes_dead: nodes.len() - alive,
            files: self.instance.files().len(),
            p50_us: total.p50_us,
            p99_us: total.p99_us,
        })
    }

    /// Waits for all processes to end; returns the summary of hopper-sim.
    fn end(&mut self) -> Result<Summary, Failure> {
        let deadline = Node::now().plus_ns(FAREWELL_NS);
        for child in &mut self.children {
            while child.ended()?.is_none() && Node::now() < deadline {
                std::thread::sleep(Duration::from_millis(5));
            }
            if child.ended()?.is_none() {
                return Err(Failure::run(format!("{} does not end after the mission", child.role)));
            }
        }
        serde_json::from_str(&self.children[0].output()).map_err(Failure::run)
    }
}

/// Compares the first tenth of the samples with the rest, role by role.
fn growth(samples: &[Sample]) -> Vec<Growth> {
    let (first, rest) = samples.split_at((samples.len() / 10).max(1).min(samples.len()));
    let most = |samples: &[Sample], of: &dyn Fn(&Sample) -> Option<u64>| {
        samples.iter().filter_map(of).max().unwrap_or(0)
    };
    let role = |(index, &role): (usize, &Role)| {
        let own = |sample: &Sample| sample.own_bytes[index];
        let (before, after) = (most(first, &own), most(rest, &own));
        let resident_max_bytes = most(samples, &|sample| sample.resident_bytes[index]);
        let constant = after <= before + GROWTH_MAX_BYTES;
        Growth { role, first_tenth_max_bytes: before, rest_max_bytes: after, resident_max_bytes, constant }
    };
    Role::ALL.iter().enumerate().map(role).collect()
}

/// The least-squares line through (hops, microseconds), with the 95 % interval of its slope; `None` with
/// fewer than three points.
fn slope(points: impl Iterator<Item = (f64, f64)>) -> Option<Slope> {
    let points: Vec<(f64, f64)> = points.collect();
    let count = points.len() as f64;
    if points.len() < 3 {
        return None;
    }
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
    let (mean_x, mean_y) = (mean(&|point| point.0), mean(&|point| point.1));
    let spread: f64 = points.iter().map(|(x, _)| (x - mean_x).powi(2)).sum();
    let slope = points.iter().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum::<f64>() / spread;
    let off: f64 = points.iter().map(|(x, y)| (y - mean_y - slope * (x - mean_x)).powi(2)).sum();
    let error = (off / (count - 2.0) / spread).sqrt();
    // Student's quantile, to its second term in 1 / degrees of freedom.
    let quantile = 1.96 + 2.37 / (count - 2.0);
    Some(Slope { us_per_100k_hops: 1e5 * slope, half_width_us: 1e5 * quantile * error })
}

impl Answer {
    fn exit(&self) -> Exit {
        let lean = self.memory.iter().all(|growth| growth.constant);
        let is_flown = self.as_lockstep.unwrap_or(self.outcome == Status::Goal);
        if !is_flown || self.leaked_nodes > 0 || self.leaked_files > 0 {
            Exit::Failed
        } else if !lean {
            Exit::Threshold
        } else {
            Exit::Done
        }
    }

    fn text(&self) -> String {
        let megabytes = |bytes: u64| format!("{:.2}", bytes as f64 / f64::from(1 << 20));
        let rows: Vec<[String; 5]> = self
            .memory
            .iter()
            .map(|growth| {
                [
                    growth.role.to_string(),
                    megabytes(growth.first_tenth_max_bytes),
                    megabytes(growth.rest_max_bytes),
                    megabytes(growth.resident_max_bytes),
                    if growth.constant { "constant" } else { "GROWS" }.into(),
                ]
            })
            .collect();
        let heads = ["process", "first tenth MB", "rest MB", "with shared MB", "memory"];
        let mut text = table(heads, &rows);
        let Self { outcome, decisions, visits, kills, wall_s, leaked_nodes, leaked_files, .. } = self;
        let _ = writeln!(text);
        let _ = writeln!(
            text,
            "{decisions} decisions, {visits} visits, {kills} kills in {wall_s:.0} s: {outcome}, digest {}",
            self.digest
        );
        if self.as_lockstep == Some(false) {
            let _ = writeln!(text, "lockstep ends otherwise");
        }
        let _ = writeln!(
            text,
            "left behind: {leaked_nodes} nodes, {leaked_files} files (at most {} and {} on the way)",
            self.nodes_max, self.files_max
        );
        for (name, slope) in [("p50", &self.p50), ("p99", &self.p99)] {
            if let Some(Slope { us_per_100k_hops, half_width_us }) = slope {
                let _ = writeln!(
                    text,
                    "landing to commit, {name}: {us_per_100k_hops:+.3} ± {half_width_us:.3} µs per 100,000 hops"
                );
            }
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_of_a_line_is_its_own_and_noise_widens_the_interval() {
        let line = |noise: f64| {
            slope((0..100).map(|n| {
                let hops = 1e4 * f64::from(n);
                (hops, 50.0 + 2e-5 * hops + noise * f64::from(n % 7 - 3))
            }))
            .unwrap()
        };
        let clean = line(0.0);
        assert!((clean.us_per_100k_hops - 2.0).abs() < 1e-9 && clean.half_width_us < 1e-6, "{clean:?}");
        let noisy = line(4.0);
        assert!((noisy.us_per_100k_hops - 2.0).abs() < noisy.half_width_us, "{noisy:?}");
        assert!(noisy.half_width_us > 0.3, "{noisy:?}");
        assert_eq!(slope([(1.0, 1.0), (2.0, 2.0)].into_iter()), None);
    }
}
