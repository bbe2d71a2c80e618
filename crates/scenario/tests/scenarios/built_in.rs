//! The scenarios that come with Hopper.

use std::path::Path;

use contract::{Cell, Leg, Profile, Soil};
use scenario::{BUILT_IN, ResolvedScenario, load};

use crate::{built_in, says};

#[test]
fn the_papers_scenarios_are_the_papers_worlds() {
    for (name, sand) in [("hard", 0), ("heterogeneous", 7 * 9), ("sandy", 400 - 42)] {
        let ResolvedScenario { brief, terrain, warnings, .. } = built_in(name);
        assert_eq!((brief.grid.width, brief.grid.height, brief.grid.hop_cells), (20, 20, 1));
        let Leg { start, goal, motion, sensor, .. } = brief.leg(0);
        assert_eq!((start, goal), (Cell::new(1, 2), Cell::new(18, 18)));
        assert_eq!(brief.profile, Profile::Paper2023);
        assert_eq!(brief.scenario.as_str(), name);
        assert_eq!((brief.limits.steps_max, brief.limits.decision_budget_ns), (150, 600_000_000));
        assert_eq!((motion.hard.intended, motion.hard.stuck, motion.hard.sideways), (0.9, 0.0, 0.05));
        assert_eq!((motion.sand.intended, motion.sand.stuck, motion.sand.sideways), (0.7, 0.1, 0.1));
        assert_eq!((motion.hard.flights, motion.sand.flights), (1, 2));
        assert_eq!(motion.slope_limit_rad, std::f64::consts::PI / 6.0);
        assert_eq!(motion.launch_angle_rad, std::f64::consts::PI / 4.0);
        assert_eq!((brief.payoff.goal, brief.payoff.discount, brief.payoff.sand_term), (100.0, 0.99, -5.0));
        assert_eq!((sensor.gain, sensor.offset_m), (2.0, 1.0));
        assert_eq!(terrain.cells.iter().filter(|ground| ground.soil == Soil::Sand).count(), sand, "{name}");
        assert!(terrain.cells.iter().all(|ground| ground.passable));
        assert!((brief.priors.height_m.max - 0.161).abs() < 5e-4);
        let safest = if sand > 0 { 5.0 } else { 0.0 };
        assert!((brief.priors.safety.max - safest).abs() < 0.01, "{:?}", brief.priors);
        assert!(warnings.is_empty(), "{warnings:?}");
    }
    let amplitude =
        built_in("hard").resolved.contains(&format!("amplitude_m = {}", 1.0 / std::f64::consts::TAU));
    assert!(amplitude, "1/(2 pi) to the last bit");
}

#[test]
fn the_built_in_scenarios_are_the_files_in_the_folder() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios");
    let mut files: Vec<String> = std::fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().path().file_stem().unwrap().to_str().unwrap().to_string())
        .collect();
    files.sort();
    let mut names = BUILT_IN.map(|(name, _)| name.to_string());
    names.sort();
    assert_eq!(files, names);
    for (name, text) in BUILT_IN {
        assert_eq!(std::fs::read_to_string(folder.join(name).with_extension("toml")).unwrap(), text);
        assert_eq!(load(name).unwrap().brief.name.as_deref(), Some(name));
    }
}

#[test]
fn the_generated_hills_can_be_crossed_without_any_file() {
    let world = built_in("hills");
    assert_eq!((world.brief.grid.width, world.brief.grid.height), (40, 40));
    assert!(world.warnings.is_empty(), "{:?}", world.warnings);
    let sand = world.terrain.cells.iter().filter(|ground| ground.soil == Soil::Sand).count();
    assert!((40..800).contains(&sand), "some sand, not all: {sand}");
}

#[test]
fn the_large_map_has_the_papers_size_way_and_limit() {
    let world = built_in("large");
    let brief = &world.brief;
    assert_eq!((brief.grid.width, brief.grid.height, brief.limits.steps_max), (50, 50, 800));
    assert_eq!((brief.leg(0).start, brief.leg(0).goal), (Cell::new(1, 2), Cell::new(48, 48)));
    assert!(world.warnings.is_empty() && world.terrain.cells.iter().all(|ground| ground.passable));
    let sand = world.terrain.cells.iter().filter(|ground| ground.soil == Soil::Sand).count();
    assert_eq!(sand, 643, "of 2,500");
}

#[test]
fn the_wide_and_the_vast_world_can_be_crossed_and_are_made_quickly() {
    for (name, side, hops) in [("wide", 200, 255), ("vast", 821, 1010)] {
        let world = built_in(name);
        assert_eq!((world.brief.grid.width, world.brief.grid.height), (side, side));
        assert!(world.warnings.is_empty(), "{name}: {:?}", world.warnings);
        let share = |of: fn(&contract::Ground) -> bool| {
            world.terrain.cells.iter().filter(|ground| of(ground)).count() as f64
                / world.terrain.cells.len() as f64
        };
        let sand = share(|ground| ground.soil == Soil::Sand);
        assert!((0.05..0.4).contains(&sand), "{name}: {sand} sand");
        let impassable = share(|ground| !ground.passable);
        assert!(impassable < 0.05, "{name}: {impassable} impassable");
        let leg = world.brief.leg(0);
        let way = world.terrain.hops_between(leg.start, leg.goal).unwrap();
        assert!((hops..hops + hops / 5).contains(&way), "{name}: {way} hops");
    }
}

#[test]
fn the_mars_scenario_asks_for_its_model() {
    let text = load("mars").unwrap().resolve().unwrap_err().to_string();
    says(&text, &["gale_hirise_DTEEC_009650_1755_crop_4p98m.tif", "found none", "--dem FILE"]);
}

#[test]
fn an_unknown_selector_names_the_known_scenarios() {
    says(
        &load("nowhere").unwrap_err().to_string(),
        &["hard, heterogeneous, sandy, large, treasures, wide, vast, hills, patrol, mars", "nowhere"],
    );
}
