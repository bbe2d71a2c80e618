//! Flies the same missions in Node and on this machine.

use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;

use browser::{Outcome, Request, fly};
use process::Failure;
use serde_json::json;

/// Scenarios, profiles and dynamics that the seeds take in turn, each with the planner that comes with it; what is empty is as the
/// scenario says.
const MISSIONS: [(&str, &str, &str, &str); 13] = [
    ("hard", "paper-2023", "", "mdp"),
    ("hard", "hopper", "", "mdp"),
    ("sandy", "paper-2023", "", "mdp"),
    ("sandy", "hopper", "", "astar"),
    ("heterogeneous", "hopper", "", "mdp"),
    ("treasures", "paper-2023", "", "mdp"),
    ("hills", "hopper", "", "dstar_lite"),
    ("heterogeneous", "paper-2023", "", "greedy"),
    ("coverage", "hopper", "", "cover_frontier"),
    ("rover-helicopter", "hopper", "", ""),
    ("hard", "hopper", "contact", "mdp"),
    ("sandy", "hopper", "contact", "greedy"),
    ("rocks", "", "", "mdp"),
];

/// What Node runs: a request a line on standard input, its outcome a line on standard output.
const SCRIPT: &str = "
const { readFileSync } = await import('node:fs');
const { join } = await import('node:path');
const { pathToFileURL } = await import('node:url');
const site = process.argv[1];
const { load } = await import(pathToFileURL(join(site, 'module.js')));
const call = await load(readFileSync(join(site, 'hopper.wasm')));
for (const line of readFileSync(0, 'utf8').split('\\n').filter(Boolean)) {
  let answer;
  try { answer = call('fly', line); } catch (error) { answer = JSON.stringify({ error: error.message }); }
  console.log(answer);
}
";

/// Requests for the seeds from 1 on.
#[must_use]
pub fn missions(seeds: u64) -> Vec<String> {
    let or_none = |text: &str| if text.is_empty() { json!(null) } else { json!(text) };
    let mission = |(seed, (scenario, profile, dynamics, planner)): (u64, &(&str, &str, &str, &str))| {
        let planners =
            if planner.is_empty() { json!([]) } else { json!([{ "from": 0, "planner": planner }]) };
        let (profile, dynamics) = (or_none(profile), or_none(dynamics));
        json!({ "scenario": scenario, "profile": profile, "dynamics": dynamics, "seed": seed, "planners": planners })
            .to_string()
    };
    (1..=seeds).zip(MISSIONS.iter().cycle()).map(mission).collect()
}

/// Flies each of `missions`, requests in JSON, with the module in `site` and on this machine; a line for each that differs.
///
/// # Errors
/// If Node cannot be run, or breaks off.
pub fn differences(site: &Path, missions: &[String]) -> Result<Vec<String>, Failure> {
    let answers = in_node(site, &missions.join("\n"))?;
    let answers: Vec<&str> = answers.lines().collect();
    if answers.len() != missions.len() {
        let (need, got) = (missions.len(), answers.len());
        return Err(Failure::run(format!("Node breaks off: {need} missions need outcomes, got {got}")));
    }
    let differs = |(mission, answer): (&String, &str)| {
        let request: Request = serde_json::from_str(mission).ok()?;
        let need = fly(&request, &Arc::from([]));
        let got: Result<Outcome, _> = serde_json::from_str(answer);
        match (&need, got) {
            (Ok(need), Ok(got)) if *need == got => None,
            (need, _) => Some(format!("{mission} needs {need:?}, got {answer}")),
        }
    };
    Ok(missions.iter().zip(answers).filter_map(differs).collect())
}

fn in_node(site: &Path, missions: &str) -> Result<String, Failure> {
    let failed = |error: std::io::Error| Failure::run(format!("the check needs node on PATH, got: {error}"));
    let site = site.canonicalize().map_err(|error| Failure::usage(format!("{}: {error}", site.display())))?;
    let mut node = Command::new("node")
        .args(["--input-type=module", "--eval", SCRIPT])
        .arg(&site)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .map_err(failed)?;
    if let Some(mut input) = node.stdin.take() {
        std::io::Write::write_all(&mut input, missions.as_bytes()).map_err(failed)?;
    }
    let output = node.wait_with_output().map_err(failed)?;
    match output.status.success() {
        true => Ok(String::from_utf8_lossy(&output.stdout).into_owned()),
        false => Err(Failure::run("Node cannot fly with the module: it says why above")),
    }
}
