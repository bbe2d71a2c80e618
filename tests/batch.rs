//! The batch jobs of docs/campaigns.md, taken from the page: by a shell, by a real Slurm, by GNU parallel.

#[path = "batch/slurm.rs"]
mod slurm;

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::harness::{eventually, hopper, skip, stderr};
use slurm::Slurm;

/// The fenced block of docs/campaigns.md with this info string.
fn documented(fence: &str) -> String {
    let page = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/campaigns.md")).unwrap();
    let block = page.split(&format!("```{fence}\n")).nth(1).expect("the page has the block");
    block.split("```").next().unwrap().into()
}

/// A folder with a campaign under the documented name, and its rows from a single run.
struct Campaign {
    dir: tempfile::TempDir,
    single: (String, String),
}

impl Campaign {
    fn new(repetitions: u32) -> Self {
        let dir = tempfile::tempdir().unwrap();
        fs::create_dir(dir.path().join("campaigns")).unwrap();
        let text = format!(
            "name = \"small\"\nseed = 11\nrepetitions = {repetitions}\nscenarios = [\"hard\", \"sandy\"]\n\
             planners = [\"mdp\", \"greedy\"]\nweights = [{{ safety = 0.5, information = 0.5 }}]\n"
        );
        fs::write(dir.path().join("campaigns/p23-tables.toml"), text).unwrap();
        let mut single = hopper(&["campaign", "run", "campaigns/p23-tables.toml", "--out", "single"]);
        done(single.current_dir(dir.path()));
        let single = rows(dir.path().join("single"));
        Self { dir, single }
    }

    /// Runs a script of the page, with this build's `hopper` first in the path.
    fn script(&self, text: &str, environment: &[(&str, &str)]) -> Output {
        let mut command = Command::new("sh");
        command.args(["-euc", text]).current_dir(self.dir.path());
        done(command.env("PATH", path()).envs(environment.iter().copied()))
    }

    /// Merges the shards by the lines of the page, and compares them with the single run.
    fn assert_merged(&self) {
        self.script(&documented("merge"), &[]);
        assert!(
            rows(self.dir.path().join("out/p23-tables")) == self.single,
            "other rows than a single run's"
        );
    }
}

/// The path with this build's `hopper` first.
fn path() -> String {
    let bin = Path::new(env!("CARGO_BIN_EXE_hopper")).parent().unwrap();
    format!("{}:{}", bin.display(), std::env::var("PATH").unwrap())
}

fn done(command: &mut Command) -> Output {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{command:?}: {}", stderr(&output));
    output
}

/// Both forms of the rows, byte for byte.
fn rows(dir: PathBuf) -> (String, String) {
    let read = |file| fs::read_to_string(dir.join(file)).unwrap();
    (read("trials.jsonl"), read("trials.csv"))
}

/// P-BATCH: The documented Slurm array and GNU parallel lines give the rows of a single run.
///
/// A shell stands in for the batch systems, so this test runs everywhere.
#[test]
fn the_documented_batch_jobs_give_the_rows_of_a_single_run() {
    if suites::is_left_out("batch systems") {
        return;
    }
    let campaign = Campaign::new(5);
    for id in ["1", "2", "3", "4"] {
        let array =
            [("SLURM_ARRAY_TASK_ID", id), ("SLURM_ARRAY_TASK_COUNT", "4"), ("SLURM_CPUS_PER_TASK", "2")];
        campaign.script(&documented("slurm"), &array);
    }
    campaign.assert_merged();

    fs::remove_dir_all(campaign.dir.path().join("out")).unwrap();
    // What GNU parallel would run: the command once for each argument after `:::`.
    let parallel = documented("parallel");
    let (_, command) = parallel.split_once("--resume ").unwrap();
    let (command, arguments) = command.trim().split_once(" ::: ").unwrap();
    let lines = arguments.split(' ').fold(String::new(), |mut lines, argument| {
        let _ = writeln!(lines, "{}", command.replace("{}", argument));
        lines
    });
    campaign.script(&lines, &[]);
    campaign.assert_merged();
}

/// P-SLURM: On a real Slurm of one node the documented array gives the rows of a single run, also
/// if a job is requeued while it flies. Skipped, with a note, where Slurm is not installed or
/// cannot run.
#[test]
fn slurm_runs_the_documented_array_and_a_requeued_job_continues() {
    if suites::is_left_out("batch systems") {
        return;
    }
    let what = "the documented array on Slurm";
    let mut slurm = match Slurm::start() {
        Ok(slurm) => slurm,
        Err(why) => return skip(what, &why),
    };
    let campaign = Campaign::new(600);
    let dir = campaign.dir.path();
    fs::write(dir.join("campaign.sbatch"), documented("slurm")).unwrap();
    let submitted = campaign.script(&documented("submit"), &[("SLURM_CONF", &slurm.configuration())]);
    let line = String::from_utf8(submitted.stdout).unwrap();
    let job = line.trim().strip_prefix("Submitted batch job ").expect("sbatch prints the job");

    let task = format!("{job}_1");
    let rows = dir.join("out/p23/1/trials.jsonl");
    eventually("the first rows of a job", || fs::metadata(&rows).is_ok_and(|file| file.len() > 0));
    slurm.run("scontrol", &["requeue", &task]);
    let shown = slurm.run("scontrol", &["show", "job", &task]);
    assert!(shown.contains("Requeue=1 Restarts=1"), "{shown}");
    slurm.await_end(job);
    campaign.assert_merged();
}

/// P-PARALLEL: GNU parallel runs the documented line, gives the rows of a single run, and has
/// nothing left to do when the line is repeated. Skipped, with a note, where it is not installed.
#[test]
fn gnu_parallel_runs_the_documented_line() {
    if suites::is_left_out("batch systems") {
        return;
    }
    let version = Command::new("parallel").arg("--version").output();
    // Another program of that name is in moreutils.
    if !version.is_ok_and(|output| String::from_utf8_lossy(&output.stdout).starts_with("GNU parallel")) {
        return skip("the documented line on GNU parallel", "parallel is not installed");
    }
    let campaign = Campaign::new(5);
    campaign.script(&documented("parallel"), &[]);
    campaign.assert_merged();
    let log = || fs::read_to_string(campaign.dir.path().join("joblog")).unwrap();
    let first = log();
    assert_eq!(first.lines().count(), 5, "a line for each job below the header: {first}");
    campaign.script(&documented("parallel"), &[]);
    assert_eq!(log(), first);
}
