//! `hopper doctor`: shows what runs, what is missing or left over, and what to do next; removes leftovers.

use std::fmt::Write as _;

use contract::{RobotId, Role};
use node::inspect::{Memory, MissionReport, NodeHealth, ProcessReport, Report, inspect};
use node::{Cleaned, Exit, Failure, Instance, Removal, free_bytes};
use report::{Format, table};
use serde::Serialize;

use crate::stdout::print;

/// The instance of commands that name none.
const DEFAULT_INSTANCE: &str = "hopper";

/// Arguments of `hopper doctor`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    /// Inspect this instance only [default: every instance of this user].
    #[arg(long, env = "HOPPER_INSTANCE", value_name = "NAME")]
    instance: Option<String>,
    /// First remove what instances without a live process have left behind, and files of other users in their place.
    #[arg(long)]
    clean: bool,
    /// Format of the answer on standard output: text or json.
    #[arg(long, default_value_t)]
    format: Format,
}

/// The answer; field names are those of the JSON.
#[derive(Serialize)]
struct Findings {
    version: &'static str,
    free_bytes: u64,
    cleaned: Vec<Cleaning>,
    instances: Vec<Report>,
}

#[derive(Serialize)]
struct Cleaning {
    instance: String,
    outcome: Cleaned,
    /// Files of other users that bore the instance's name.
    foreign: Vec<Removal>,
}

/// Runs the command.
///
/// # Errors
/// If shared memory cannot be read, or a leftover cannot be removed.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let mut cleaned = Vec::new();
    if args.clean {
        for instance in chosen(args)? {
            let foreign = instance.remove_foreign_files()?;
            cleaned.push(Cleaning { instance: instance.name().into(), outcome: instance.clean()?, foreign });
        }
    }
    let instances = chosen(args)?.iter().map(inspect).collect::<Result<_, _>>()?;
    let findings =
        Findings { version: env!("CARGO_PKG_VERSION"), free_bytes: free_bytes()?, cleaned, instances };
    let text = match args.format {
        Format::Text => findings.text(),
        Format::Json => serde_json::to_string(&findings).map_err(Failure::run)? + "\n",
    };
    print(&text)?;
    Ok(Exit::Done)
}

/// The instance asked for, or all of this user's, and the default one if another user has put files in its place.
fn chosen(args: &Args) -> Result<Vec<Instance>, Failure> {
    if let Some(name) = &args.instance {
        return Ok(vec![Instance::new(name)?]);
    }
    let mut instances = Instance::all()?;
    let default = Instance::new(DEFAULT_INSTANCE)?;
    if !instances.contains(&default) && !default.foreign_files()?.is_empty() {
        instances.push(default);
    }
    Ok(instances)
}

impl Findings {
    fn text(&self) -> String {
        let mut text =
            format!("hopper {}, {} of shared memory free\n", self.version, megabytes(self.free_bytes));
        for Cleaning { instance, outcome, foreign } in &self.cleaned {
            for Removal { file, refused } in foreign {
                let _ = match refused {
                    None => writeln!(text, "removed {file} that kept everybody out of {instance}"),
                    Some(why) => {
                        writeln!(text, "cannot remove {file} that keeps everybody out of {instance}: {why}")
                    }
                };
            }
            let done = match outcome {
                Cleaned::Nothing => "nothing to remove".to_owned(),
                Cleaned::Alive => "alive, left alone".to_owned(),
                Cleaned::Removed { files, bytes } => format!("removed {files} files, {}", megabytes(*bytes)),
            };
            let _ = writeln!(text, "cleaned {instance}: {done}");
        }
        if self.instances.is_empty() {
            text.push_str("nothing runs, and nothing is left over\n  → start `hopper run`\n");
        }
        for instance in &self.instances {
            text.push('\n');
            text.push_str(&instance_text(instance));
        }
        text
    }
}

fn instance_text(report: &Report) -> String {
    let health = match (report.alive, report.leftovers.len()) {
        (true, _) => "alive".to_owned(),
        (false, 0) => "not there".to_owned(),
        (false, count) => format!("left over, {count} files"),
    };
    let mut text = format!("instance {}: {health}\n", report.instance);
    if let Some(mission) = &report.mission {
        text.push_str(&mission_text(mission));
    }
    if !report.processes.is_empty() {
        let rows: Vec<_> = report
            .processes
            .iter()
            .map(|process| {
                [
                    process.role.to_string(),
                    process.pid.to_string(),
                    process.version.to_string(),
                    format!("{}{}", process.planner, if process.leads { " (leads)" } else { "" }),
                    robots(process),
                    process.decision.to_string(),
                    process.status.to_string(),
                    format!("{} ms", process.age_ms),
                ]
            })
            .collect();
        text.push_str(&indented(&table(
            ["role", "pid", "version", "planner", "robots", "decision", "status", "last beat"],
            &rows,
        )));
    }
    for node in report.nodes.iter().filter(|node| node.health != NodeHealth::Alive) {
        let pid = node.pid.map_or_else(|| "unknown".into(), |pid| pid.to_string());
        let health = if node.health == NodeHealth::Dead { "dead" } else { "inaccessible" };
        let _ = writeln!(text, "  {health} {} (process {pid}, {})", node.name, node.executable);
    }
    let Memory { used_bytes, need_bytes, .. } = report.memory;
    let need = need_bytes
        .map_or_else(String::new, |bytes| format!(" of {} that the mission needs", megabytes(bytes)));
    let _ = writeln!(text, "  shared memory: {} used{need}", megabytes(used_bytes));
    for advice in &report.advice {
        let _ = writeln!(text, "  → {advice}");
    }
    text
}

/// The robots that a planner plans for.
fn robots(process: &ProcessReport) -> String {
    let numbers: Vec<String> = process.robots.iter().map(RobotId::to_string).collect();
    match process.role {
        Role::Planner if numbers.is_empty() => "none".to_owned(),
        Role::Planner => numbers.join(" "),
        _ => String::new(),
    }
}

fn mission_text(mission: &MissionReport) -> String {
    let [width, height] = mission.grid;
    let mut text = format!(
        "  mission {} ({}), {width} x {height} cells, run {}\n",
        mission.scenario, mission.profile, mission.run
    );
    if let Some(progress) = &mission.progress {
        let leader = match progress.leader.pid {
            0 => "nobody commands yet".to_owned(),
            pid => format!(
                "{} (process {pid}) commands in term {}",
                progress.leader.planner, progress.leader.term
            ),
        };
        let (decision, steps, status) = (progress.decision, progress.steps, progress.status);
        let _ = writeln!(text, "  {status} at decision {decision}, {steps} steps; {leader}");
    }
    text
}

fn indented(text: &str) -> String {
    text.lines().map(|line| format!("  {line}\n")).collect()
}

fn megabytes(bytes: u64) -> String {
    format!("{:.2} MB", bytes as f64 / 1e6)
}
