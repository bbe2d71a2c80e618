//! What the processes of a mission are started with, and what the log calls them.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::time::Duration;

use contract::{MissingPeer, Name, RobotId, RobotSet, Role};
use hopper_sim::Pace;
use monitor::shell::ViewArgs;
use node::Failure;

use super::OutputDir;
use super::child::Supervised;
use super::planner_command::PlannerCommand;

/// What the processes are started with.
#[derive(Clone, Debug)]
pub struct Launch {
    /// Instance that all four join.
    pub instance: String,
    /// Algorithm of each robot's planner, in the order of their numbers. Every robot has a process of its own.
    pub planners: Vec<Name>,
    /// The program that is each robot's planner in place of the algorithms in `planners`.
    pub planner_command: Option<PlannerCommand>,
    /// Whether the guard's fallback acts where no planner does in time.
    pub falls_back: bool,
    /// Seed of the draws; the scenario itself is read from the output folder.
    pub seed: u64,
    /// Landings a second at most, simulated by hopper-sim.
    pub pace: Pace,
    /// The page that the monitor serves, if it does, and whether hopper-sim obeys orders and the monitor gives them.
    pub view: ViewArgs,
    /// What the monitor records, if it does.
    pub recording: Option<Recording>,
    /// How long the hopper holds when a process it needs was given up, or its journal is displaced, before the mission is
    /// stopped.
    pub patience: Duration,
}

/// The recording that the monitor makes.
#[derive(Clone, Debug)]
pub struct Recording {
    /// File to write, which must not exist yet.
    pub file: PathBuf,
    /// Whether policies are recorded too.
    pub with_policies: bool,
}

impl Launch {
    pub(super) fn words(&self, words: &[&str]) -> Vec<OsString> {
        let instance = flag("--instance", &self.instance);
        words.iter().map(OsString::from).chain([instance]).collect()
    }

    pub(super) fn sim(&self, output_dir: &OutputDir) -> Vec<OsString> {
        let mut words = self.words(&["sim", "--format", "json"]);
        words.extend([
            flag("--seed", self.seed.to_string()),
            flag("--pace", self.pace.to_string()),
            flag("--scenario", output_dir.scenario()),
            flag("--journal", output_dir.journal_dir()),
            flag("--resume-run", output_dir.run().to_string()),
            flag("--patience", format!("{}ns", self.patience.as_nanos())),
        ]);
        words.extend(self.view.control.then(|| "--control".into()));
        words
    }

    /// The planner of a robot.
    pub(super) fn planner(
        &self,
        program: &Path,
        robot: RobotId,
        algorithm: Name,
    ) -> Result<Supervised, Failure> {
        let number = robot.to_string();
        let mut child = match &self.planner_command {
            Some(command) => {
                let environment = vec![("HOPPER_INSTANCE", self.instance.clone()), ("HOPPER_ROBOT", number)];
                Supervised::start_own(command.program(), command.arguments(), environment)?
            }
            None => {
                let words = ["planner", "--algorithm", algorithm.as_str(), "--robot", &number];
                Supervised::start(program, Role::Planner, self.words(&words))?
            }
        };
        child.robots = RobotSet::NONE.with(robot);
        Ok(child)
    }

    /// A child as the log names it: where there are several robots, a planner by its own.
    pub(super) fn name_of(&self, child: &Supervised) -> String {
        match child.robots.is_empty() || self.planners.len() == 1 {
            true => child.role.to_string(),
            false => format!("{} of robot {}", child.role, child.robots),
        }
    }

    /// Who holds while a process is missing.
    pub(super) fn who_holds(&self) -> &'static str {
        if self.planners.len() == 1 { "the hopper" } else { "the mission" }
    }

    /// The commands that start what is missing.
    pub(super) fn commands_for(&self, missing: MissingPeer) -> String {
        let MissingPeer::Planner(robots) = missing else {
            return format!("`{}`", missing.command(Some(&self.instance)));
        };
        let command = |robot: RobotId| match &self.planner_command {
            Some(own) => format!("`HOPPER_INSTANCE={} HOPPER_ROBOT={robot} {own}`", self.instance),
            None => {
                let one = MissingPeer::Planner(RobotSet::NONE.with(robot)).command(Some(&self.instance));
                let algorithm = self.planners.get(usize::from(robot.0));
                algorithm.map_or(format!("`{one}`"), |algorithm| format!("`{one} --algorithm {algorithm}`"))
            }
        };
        robots.iter().map(command).collect::<Vec<_>>().join(" and ")
    }

    /// Whether a mission that goes on takes a decision within its patience, whatever its pace.
    pub(super) fn decides_within_patience(&self) -> bool {
        !self.view.control && self.pace == Pace::Max
    }

    pub(super) fn monitor(&self, output_dir: &OutputDir) -> Vec<OsString> {
        let mut words = self.words(&["monitor"]);
        let ViewArgs { web, ref web_host, web_exit, open, control } = self.view;
        words.extend(web.into_iter().flat_map(|address| ["--web".into(), address.to_string().into()]));
        words.extend(web_host.iter().flat_map(|name| ["--web-host".into(), name.into()]));
        // Without a page, orders come from monitors started by hand.
        for (name, is_set) in [("--control", control), ("--web-exit", web_exit), ("--open", open)] {
            words.extend((is_set && web.is_some()).then(|| name.into()));
        }
        let Some(recording) = &self.recording else { return words };
        words.push(flag("--record", &recording.file));
        words.push(flag("--record-scenario", output_dir.scenario()));
        for (key, value) in [
            ("seed", self.seed.to_string()),
            ("pace", self.pace.to_string()),
            ("commit", crate::COMMIT.to_owned()),
        ] {
            words.extend(["--record-note".into(), format!("{key}={value}").into()]);
        }
        words.extend(recording.with_policies.then(|| "--record-policies".into()));
        words
    }
}

/// A flag and its value in one word: a path may begin with a hyphen, and need not be UTF-8.
fn flag(name: &str, value: impl AsRef<OsStr>) -> OsString {
    let mut word = OsString::from(name);
    word.push("=");
    word.push(value);
    word
}
