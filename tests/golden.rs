//! What every built-in scenario came to before the structure changed: scenario hash, digest, map and routes, bit for bit.
//!
//! `cargo test --test tests golden:: -- --nocapture` prints the table as it is now, whatever it should be.
//!
//! A scenario's hash begins every digest chain, so it changes every digest when the text of a scenario does. The column
//! `chain` begins at zero: it pins down what was executed, and nothing of how a scenario is written.

use std::fmt::Write as _;

use contract::{Brief, Digest, MonotonicNs, Profile, Route, RunId};
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

/// Planners of each scenario whose results are compared. Robots that a planner does not suit keep their own.
fn planners(scenario: &str) -> &'static [&'static str] {
    match scenario {
        "hard" | "heterogeneous" | "sandy" => &["mdp", "greedy", "astar", "dstar_lite"],
        "known-hard" | "known-heterogeneous" | "known-sandy" | "rocks" => {
            &["mdp", "greedy", "astar", "dstar_lite"]
        }
        "vast" | "patrol" => &["mdp"],
        "coverage" | "coverage-8" => &["spiral", "boustrophedon", "cover_frontier"],
        "rover-helicopter" => &["rrt_star_ett", "ett_exact", "scout_value"],
        _ => &["mdp", "greedy"],
    }
}

/// Profiles in which a scenario is flown: that of the predecessor paper on the ground of that paper alone.
fn profiles(scenario: &str) -> &'static [Profile] {
    match scenario {
        "known-hard" | "known-heterogeneous" | "known-sandy" | "rocks" => &Profile::ALL,
        _ => &[Profile::Paper2023, Profile::Hopper],
    }
}

/// All points of all routes in the order of their fingerprints, as one number.
fn fingerprint(mut routes: Vec<Route>) -> u64 {
    routes.sort_by_key(|route| route.id());
    routes.iter().fold(0, |sum: u64, route| sum.rotate_left(1) ^ route.id().0)
}

/// What one mission came to. The chain begins at zero and so depends on nothing but what was executed; the digest begins
/// with the hash of the scenario's text.
fn row(name: &str, profile: Profile, planner: &str, seed: u64, dem: &std::path::Path) -> String {
    let overrides = Overrides { profile: Some(profile), ..Overrides::default() };
    let world = built_in(name, dem).with(&overrides).resolve().unwrap();
    let hash = hex(&world.brief.scenario_hash);
    let given = planner.parse().unwrap();
    let planners = planner::assigned(&world.brief, Some(given), &world.planners).unwrap();
    // The elevation model's path is no part of the world; its run is fixed.
    let brief = Brief { run: RunId(1), ..world.brief.clone() };
    let mission = Mission { brief, ..Mission::of(&world, seed) };
    let schedule = PlannerSchedule::of_robots(&planners);
    let mut chain = Digest::default();
    let flown = lockstep::fly(mission, &schedule, &mut || MonotonicNs(0), &mut |record| {
        chain = chain.chain(record);
    })
    .unwrap();
    let (state, map, routes) = (flown.state, flown.map.observation(), fingerprint(flown.routes));
    let (decisions, steps, status, digest) = (state.decision, state.steps, state.status, state.digest);
    format!(
        "{name},{profile},{planner},{seed},{decisions},{steps},{status},{hash},{digest},{map:016x},{chain},{routes:016x}"
    )
}

/// P-GOLDEN: No change of structure changes a result: every built-in scenario keeps its scenario
/// hash, digest, map and routes bit for bit, and the chain of executed decisions that is begun
/// without the scenario's hash.
#[test]
fn every_built_in_scenario_has_the_digest_the_map_and_the_routes_it_had() {
    let folder = tempfile::tempdir().unwrap();
    let dem = elevation_model(folder.path());
    let header = "scenario,profile,planner,seed,decisions,steps,status,scenario_hash,digest,map,chain,routes";
    let mut rows = vec![header.to_owned()];
    for (name, _) in scenario::BUILT_IN {
        for profile in profiles(name) {
            for planner in planners(name) {
                for seed in [1, 2] {
                    rows.push(row(name, *profile, planner, seed, &dem));
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
