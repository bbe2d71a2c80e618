//! Campaigns: the grid as text, the plan of a folder, its rows.

use std::path::Path;
use std::sync::LazyLock;

use campaign::row::TrialResult;
use campaign::{Campaign, Manifest, Plan, Report, Row, Rows, Shard, TrialPlan as _, TrialRow as _};
use contract::{Digest, Status};

use crate::told;

const GRID: &str = r#"
name = "specimen"
seed = 11
repetitions = 3
scenarios = ["hard"]
profiles = ["paper-2023", "hopper"]
planners = ["mdp", "greedy"]
weights = [{ safety = 0.5, information = 0.5 }, { safety = 1.0, information = 0.0, distance = 3.0 }]
"#;

/// Built-in scenarios whose worlds are built at once.
const SMALL: [&str; 3] = ["hard", "heterogeneous", "sandy"];

/// Most worlds that are built here.
const WORLDS_MAX: usize = 8;

static MANIFEST: LazyLock<Manifest> = LazyLock::new(|| {
    let text = GRID.replace("profiles = [\"paper-2023\", \"hopper\"]\n", "").replace("\"mdp\", ", "");
    Manifest { shard: Shard { number: 2, count: 3 }, plan: planned(&text) }
});

fn planned(text: &str) -> Plan {
    let campaign = Campaign::parse(text, "specimen").expect("the fixture is a campaign");
    campaign.plan(Path::new(""), "0.1.0").expect("the fixture can be flown")
}

/// The plan of the fixture's second shard of three.
#[must_use]
pub fn manifest() -> &'static Manifest {
    &MANIFEST
}

/// Parses, and lays out what is small: trials are numbered without gap.
pub fn read(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let campaign = match Campaign::parse(text, "hostile.toml") {
        Ok(campaign) => campaign,
        Err(error) => return told(&error),
    };
    let Campaign { scenarios, profiles, planners, weights, readings, .. } = &campaign;
    let worlds =
        scenarios.len() * profiles.len() * planners.len() * weights.len().max(1) * readings.len().max(1);
    if worlds > WORLDS_MAX || !scenarios.iter().all(|name| SMALL.contains(&name.as_str())) {
        return;
    }
    match campaign.plan(Path::new(""), "0.1.0") {
        Err(error) => told(&error),
        Ok(plan) => {
            let last = plan.trials() - 1;
            assert!(plan.trial(last).is_some() && plan.trial(last + 1).is_none());
            let manifest = Manifest { shard: Shard::WHOLE, plan };
            assert_eq!(
                Manifest::parse(&manifest.text()).as_ref().ok(),
                Some(&manifest),
                "a plan is read as written"
            );
        }
    }
}

/// Reads `campaign.json`; what is read is written to be read again, and a report of no rows can be made.
pub fn read_checkpoint(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    match Manifest::<Plan>::parse(text) {
        Err(error) => told(&error),
        Ok(manifest) => {
            let Manifest { shard, plan } = &manifest;
            assert_eq!(Manifest::parse(&manifest.text()).as_ref().ok(), Some(&manifest));
            assert!(shard.nth(shard.len(plan.trials()), plan.trials()).is_none());
            if let Some(trial) = shard.nth(0, plan.trials()) {
                assert!(plan.trial(trial).is_some());
            }
            let report = Report::new(plan.clone());
            told(&p23::PaperReport::against_paper(&report.results(&[])).markdown());
        }
    }
}

/// Reads `trials.jsonl` of the fixtures' plan: a first part of its rows and no other, then the end or an error.
pub fn read_rows(bytes: &[u8]) {
    let manifest = manifest();
    let mut rows = Rows::new(manifest, bytes);
    let mut report = Report::new(manifest.plan.clone());
    loop {
        match rows.next() {
            Err(error) => return told(&error),
            Ok(None) => break,
            Ok(Some(row)) => {
                assert_eq!(Some(row.trial), manifest.shard.nth(rows.count() - 1, manifest.plan.trials()));
                report.fold(&row);
            }
        }
    }
    told(&p23::PaperReport::against_paper(&report.results(&[])).markdown());
}

/// Valid campaign files to start mutations from.
#[must_use]
pub fn seeds() -> Vec<Vec<u8>> {
    vec![GRID.into()]
}

/// The manifest of a campaign folder, as written by `hopper campaign run`.
#[must_use]
pub fn checkpoints() -> Vec<Vec<u8>> {
    vec![manifest().text().into()]
}

/// The rows of that folder, all of them.
#[must_use]
pub fn rows() -> Vec<Vec<u8>> {
    let Manifest { shard, plan } = manifest();
    let endings = [Status::Goal, Status::Deadlock, Status::LeftMap];
    let rows =
        (0..).map_while(|index| plan.trial(shard.nth(index, plan.trials())?)).zip(endings.iter().cycle());
    let lines = rows.map(|(trial, &outcome)| {
        let ending = TrialResult {
            outcome,
            steps: 40 + trial.number,
            hops: 20,
            treasures: 0,
            coverage: 0.4375,
            digest: Digest([trial.number as u8; 32]),
        };
        Row::new(plan, &trial, ending).line()
    });
    vec![lines.collect::<String>().into()]
}
