//! What every built-in scenario came to before the structure changed: scenario hash, digest, and map, bit for bit.
//!
//! `cargo test --release --test tests golden:: -- --nocapture` prints the table as it is now, whatever it should be.

use std::fmt::Write as _;

use contract::{Brief, MonotonicNs, Profile, RunId};
use hopper_sim::Mission;
use lockstep::PlannerSchedule;
use scenario::{Overrides, Scenario};

const TABLE: &str = include_str!("golden/digests.csv");

/// Hops of the patrol that are compared; whole it has a million.
const PATROL_HOPS: &str = "hops_max = 300";

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        write!(text, "{byte:02x}").unwrap();
        text
    })
}

/// A smooth model of 160 × 110 cells of 4.98 m, in place of the one that `mars` names and nobody may ship.
fn elevation_model(folder: &std::path::Path) -> std::path::PathBuf {
    let (width, height) = (160, 110);
    let mut text = format!("ncols {width}\nnrows {height}\nxllcorner 0\nyllcorner 0\ncellsize 4.98\n");
    for y in 0..height {
        let row: Vec<String> = (0..width).map(|x| ((x * 7 % 40 + y * 5 % 30) / 16).to_string()).collect();
        text += &(row.join(" ") + "\n");
    }
    let path = folder.join("model.asc");
    std::fs::write(&path, text).unwrap();
    path
}

fn built_in(name: &str, dem: &std::path::Path) -> Scenario {
    match name {
        "patrol" => {
            let (_, text) = scenario::BUILT_IN.into_iter().find(|(known, _)| *known == name).unwrap();
            Scenario::parse(&text.replace("hops_max = 1000000", PATROL_HOPS), name).unwrap()
        }
        "mars" => {
            scenario::load(name).unwrap().with(&Overrides { dem: Some(dem.into()), ..Overrides::default() })
        }
        _ => scenario::load(name).unwrap(),
    }
}

fn row(name: &str, profile: Profile, planner: &str, seed: u64, dem: &std::path::Path) -> String {
    let overrides = Overrides { profile: Some(profile), ..Overrides::default() };
    let world = built_in(name, dem).with(&overrides).resolve().unwrap();
    let hash = hex(&world.brief.scenario_hash);
    // The elevation model's path is no part of the world; its run is fixed.
    let mission =
        Mission { brief: Brief { run: RunId(1), ..world.brief }, terrain: world.terrain, seed, fleet: None };
    let schedule = PlannerSchedule::single(planner.parse().unwrap());
    let flown = lockstep::fly(mission, &schedule, &mut || MonotonicNs(0), &mut |_| ()).unwrap();
    let (state, map) = (flown.state, flown.map.observation());
    let (decisions, steps, status, digest) = (state.decision, state.steps, state.status, state.digest);
    format!("{name},{profile},{planner},{seed},{decisions},{steps},{status},{hash},{digest},{map:016x}")
}

/// P-GOLDEN: no change of structure changes a result.
#[test]
fn every_built_in_scenario_has_the_hash_the_digest_and_the_map_it_had() {
    let folder = tempfile::tempdir().unwrap();
    let dem = elevation_model(folder.path());
    let mut rows =
        vec!["scenario,profile,planner,seed,decisions,steps,status,scenario_hash,digest,map".to_owned()];
    let of_hoppers = scenario::BUILT_IN.into_iter().filter(|(name, _)| {
        !name.starts_with("coverage") && !["rover-helicopter", "hopper-scout", "expedition"].contains(name)
    });
    for (name, _) in of_hoppers {
        for profile in Profile::ALL {
            let planners: &[&str] = match name {
                "hard" | "heterogeneous" | "sandy" => &["mdp", "greedy", "astar", "dstar_lite"],
                "vast" | "patrol" => &["mdp"],
                _ => &["mdp", "greedy"],
            };
            for planner in planners {
                for seed in [1, 2] {
                    rows.push(row(name, profile, planner, seed, &dem));
                }
            }
        }
    }
    let table = rows.join("\n") + "\n";
    println!("{table}");
    for (line, (is, was)) in table.lines().zip(TABLE.lines()).enumerate() {
        assert_eq!(is, was, "line {}", line + 1);
    }
    assert_eq!(table.lines().count(), TABLE.lines().count());
}
