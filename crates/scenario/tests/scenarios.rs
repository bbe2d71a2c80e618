//! Scenarios from text to world: what is resolved, what is refused, and how.

#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};

use contract::{Cell, DistanceNorm, GradientSource, Profile, Range, Reading, Soil};
use proptest::prelude::*;
use scenario::{
    BUILT_IN, Overrides, ResolvedScenario, Scenario, ScenarioCheck, ScenarioError, Warning, load,
};

/// A folder with an elevation model: 12 x 9 cells of 2 m that rise 0.5 m a cell northwards, with one
/// cell that has no height (0, 0) and a wall of cliffs around (6, 4).
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        folder.write(
            "dem.asc",
            &grid(|x, y| if (x, y) == (6, 4) { 40.0 } else { f64::from(y) * 0.5 - 4000.0 }),
        );
        folder
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    }

    /// The world of `text` as a file in this folder.
    fn world(&self, text: &str) -> Result<ResolvedScenario, ScenarioError> {
        let path = self.write("mission.toml", text);
        load(path.to_str().unwrap())?.resolve()
    }

    fn error(&self, text: &str) -> String {
        self.world(text).expect_err("the scenario is refused").to_string()
    }
}

/// An ASCII grid of 12 x 9 cells of 2 m; (0, 0) has no height.
fn grid(height: impl Fn(u32, u32) -> f64) -> String {
    let mut text =
        String::from("ncols 12\nnrows 9\nxllcorner 100\nyllcorner 300\ncellsize 2\nNODATA_value -9999\n");
    for y in (0..9).rev() {
        let row: Vec<String> = (0..12)
            .map(|x| if (x, y) == (0, 0) { "-9999".into() } else { height(x, y).to_string() })
            .collect();
        text += &(row.join(" ") + "\n");
    }
    text
}

const REAL: &str = r#"
[truth.terrain.elevation_file]
file = "dem.asc"
[brief]
start = [1, 1]
goal = [10, 7]
datum_m = -4000
[robot]
hop_distance_m = 2.0
"#;

const HILLY: &str = r#"
[truth.terrain.gaussians]
width_cells = 10
height_cells = 8
cell_size_m = 0.5
sigma_m = 1.0
amplitude_m = 0.2
raised_m = [[1, 1]]
[brief]
start = [0, 0]
goal = [8, 6]
"#;

fn hilly(from: &str, to: &str) -> Result<ResolvedScenario, ScenarioError> {
    assert!(HILLY.contains(from), "{from:?}");
    Scenario::parse(&HILLY.replace(from, to), "hilly")?.resolve()
}

fn says(text: &str, words: &[&str]) {
    for word in words {
        assert!(text.contains(word), "{word:?} is missing in: {text}");
    }
}

fn built_in(name: &str) -> ResolvedScenario {
    load(name).unwrap().resolve().unwrap()
}

#[test]
fn the_papers_scenarios_are_the_papers_worlds() {
    for (name, sand) in [("hard", 0), ("heterogeneous", 7 * 9), ("sandy", 400 - 42)] {
        let ResolvedScenario { brief, terrain, warnings, .. } = built_in(name);
        assert_eq!((brief.grid.width, brief.grid.height, brief.grid.hop_cells), (20, 20, 1));
        assert_eq!((brief.start, brief.goal), (Cell::new(1, 2), Cell::new(18, 18)));
        assert_eq!(brief.profile, Profile::Paper2023);
        assert_eq!(brief.scenario.as_str(), name);
        assert_eq!((brief.limits.steps_max, brief.limits.decision_budget_ns), (150, 600_000_000));
        let motion = brief.motion;
        assert_eq!((motion.hard.intended, motion.hard.stuck, motion.hard.sideways), (0.9, 0.0, 0.05));
        assert_eq!((motion.sand.intended, motion.sand.stuck, motion.sand.sideways), (0.7, 0.1, 0.1));
        assert_eq!((motion.hard.flights, motion.sand.flights), (1, 2));
        assert_eq!(motion.slope_limit_rad, std::f64::consts::PI / 6.0);
        assert_eq!(motion.launch_angle_rad, std::f64::consts::PI / 4.0);
        assert_eq!((brief.payoff.goal, brief.payoff.discount, brief.payoff.sand_term), (100.0, 0.99, -5.0));
        assert_eq!((brief.sensor.gain, brief.sensor.offset_m), (2.0, 1.0));
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
fn the_scenarios_of_the_house_are_the_files_in_the_folder() {
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
    assert_eq!((brief.start, brief.goal), (Cell::new(1, 2), Cell::new(48, 48)));
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
        let way = world.terrain.hops_between(world.brief.start, world.brief.goal).unwrap();
        assert!((hops..hops + hops / 5).contains(&way), "{name}: {way} hops");
    }
}

#[test]
fn a_resolved_scenario_resolves_to_the_very_same_world() {
    let folder = Folder::new();
    let real = folder.world(&REAL.replace("datum_m = -4000", "datum_m = \"survey\"")).unwrap();
    let hopper = Overrides { profile: Some(Profile::Hopper), ..Overrides::default() };
    let worlds = ["hard", "heterogeneous", "sandy", "hills"]
        .into_iter()
        .flat_map(|name| [built_in(name), load(name).unwrap().with(&hopper).resolve().unwrap()])
        .chain([real]);
    for world in worlds {
        let again = Scenario::parse(&world.resolved, "resolved").unwrap().resolve().unwrap();
        assert_eq!(again, world, "{}", world.resolved);
    }
}

#[test]
fn the_gradient_source_follows_the_profile_unless_stated() {
    let source = |text: &str, profile: Option<Profile>| {
        let overrides = Overrides { profile, ..Overrides::default() };
        let world = Scenario::parse(text, "hilly").unwrap().with(&overrides).resolve().unwrap();
        world.brief.sensor.gradient
    };
    assert_eq!(source(HILLY, None), GradientSource::Measured);
    assert_eq!(source(HILLY, Some(Profile::Hopper)), GradientSource::SeenDifferences);
    let stated = format!("{HILLY}[robot.sensor]\ngradient = \"measured\"\n");
    assert_eq!(source(&stated, Some(Profile::Hopper)), GradientSource::Measured);
}

/// P-GUARD-SCENARIO.
#[test]
fn the_guard_is_on_in_profile_hopper_and_off_in_the_papers() {
    let world = |text: &str, profile: Profile| {
        let overrides = Overrides { profile: Some(profile), ..Overrides::default() };
        Scenario::parse(text, "hilly").unwrap().with(&overrides).resolve().unwrap()
    };
    let guard = |text: &str, profile| {
        let guard = world(text, profile).brief.guard;
        (guard.hazard_max, guard.deadline_ns)
    };
    assert_eq!(guard(HILLY, Profile::Hopper), (0.25, 0));
    assert_eq!(guard(HILLY, Profile::Paper2023), (1.0, 0));
    let stated = format!("{HILLY}[guard]\nhazard_max = 0.0\ndeadline_s = 1.5\n");
    assert_eq!(guard(&stated, Profile::Hopper), (0.0, 1_500_000_000));
    assert_eq!(guard(&stated, Profile::Paper2023), (1.0, 0), "the paper flies without a guard");
    let unused = world(&stated, Profile::Paper2023);
    assert!(unused.warnings.iter().any(|warning| warning.to_string().contains("[guard] is not used")));
    assert!(world(HILLY, Profile::Paper2023).warnings.is_empty());
    // The guard is a part of the mission, and of its hash; without one, everything is as it was.
    assert_ne!(world(HILLY, Profile::Hopper).hash, world(&stated, Profile::Hopper).hash);
    assert_eq!(world(HILLY, Profile::Paper2023).hash, unused.hash);
    assert!(!unused.resolved.contains("[guard]"));
}

/// P-PATROL-SCENARIO.
#[test]
fn a_reading_is_in_the_brief_and_in_the_hash_only_where_it_differs() {
    let text = include_str!("../../../scenarios/hard.toml");
    let plain = Scenario::parse(text, "hard").unwrap().resolve().unwrap();
    assert!(plain.brief.reading.is_default() && !plain.resolved.contains("reading"));
    assert!(!plain.resolved.contains("ground_at"));
    let read = |section: &str| {
        Scenario::parse(&format!("{text}\n[brief.reading]\n{section}\n"), "hard").unwrap().resolve()
    };
    let defaults = read("distance = \"euclidean\"\nopening_steps = 0").unwrap();
    assert_eq!(defaults.hash, plain.hash, "spelled out, the defaults are the same mission");
    let other =
        read("leaving = -100.0\ndistance = \"manhattan\"\ndistance_scale_cells = 20.0\nopening_steps = 1")
            .unwrap();
    let reading = Reading {
        leaving: Some(-100.0),
        distance: DistanceNorm::Manhattan,
        distance_scale_cells: Some(20.0),
        opening_steps: 1,
    };
    assert_eq!(other.brief.reading, reading);
    assert_ne!(other.hash, plain.hash);
    assert_eq!(Scenario::parse(&other.resolved, "hard").unwrap().resolve().unwrap(), other);
    let refused = |section: &str, words: &[&str]| says(&read(section).unwrap_err().to_string(), words);
    refused("leaving = 5.0", &["brief.reading.leaving", "below 0", "5"]);
    refused("distance_scale_cells = 0.0", &["brief.reading.distance_scale_cells", "at least 0.001"]);
    refused("opening_steps = 150", &["brief.reading.opening_steps", "150"]);
    let ours = text.replace("paper-2023", "hopper");
    let ours = Scenario::parse(&format!("{ours}\n[brief.reading]\nopening_steps = 1\n"), "hard").unwrap();
    says(&ours.resolve().unwrap_err().to_string(), &["brief.reading", "paper-2023", "hopper"]);
}

#[test]
fn ground_at_the_centre_is_that_half_a_cell_further_on() {
    let text = include_str!("../../../scenarios/hard.toml");
    let at = |point: &str| {
        let terrain = format!("[truth.terrain.gaussians]\nground_at = \"{point}\"");
        let text = text.replace("[truth.terrain.gaussians]", &terrain);
        Scenario::parse(&text, "hard").unwrap().resolve().unwrap()
    };
    let (corner, centre) = (at("corner"), at("centre"));
    assert_eq!(corner.terrain, built_in("hard").terrain);
    // The hill at (1, 6) m is highest at the corner of (1, 6); halfway between cells its four neighbours are equal.
    let height = |world: &ResolvedScenario, x, y| world.terrain.ground(Cell::new(x, y)).unwrap().height_m;
    assert!(height(&corner, 1, 6) > height(&corner, 0, 5) && height(&corner, 1, 6) > height(&corner, 0, 6));
    assert!((height(&centre, 1, 6) - height(&centre, 0, 5)).abs() < 1e-3);
}

#[test]
fn a_patrol_has_goals_in_turn_and_a_count_of_hops() {
    let patrol = |text: &str| {
        let mission = format!("[mission]\nkind = \"patrol\"\n{text}\n[brief]");
        hilly("[brief]", &mission).map(|world| world.brief)
    };
    let brief = patrol("goals = [[2, 2], [4, 2]]\nhops_max = 77").unwrap();
    let flown = brief.patrol.unwrap();
    assert_eq!(flown.goals(), [brief.goal, Cell::new(2, 2), Cell::new(4, 2)]);
    assert_eq!(flown.hops_max, 77);
    assert!(brief.limits.steps_max > 1 << 31, "no limit of steps");
    assert_eq!(patrol("goals = [[2, 2]]").unwrap().patrol.unwrap().hops_max, 1 << 32);
    let same = format!("goals = [[{}, {}]]", brief.goal.x, brief.goal.y);
    for wrong in ["", &same, "goals = [[2, 2], [2, 2]]", "goals = [[2, 2]]\nhops_max = 0"] {
        let text = patrol(wrong).expect_err(wrong).to_string();
        says(&text, &["mission."]);
    }
    says(&patrol("goals = [[98, 2]]").unwrap_err().to_string(), &["goal", "(98, 2)"]);
    let reach = hilly("[brief]", "[mission]\nhops_max = 5\n[brief]").unwrap_err().to_string();
    says(&reach, &["mission.kind", "patrol"]);
    let built_in = built_in("patrol").brief.patrol.unwrap();
    assert_eq!((built_in.goals().len(), built_in.hops_max), (4, 1_000_000));
}

#[test]
fn overrides_change_profile_budget_and_elevation_file() {
    let folder = Folder::new();
    let path = folder.write("mission.toml", REAL);
    let other = folder.write("other.asc", &grid(|x, _| f64::from(x) * 0.25 - 4000.0));
    let overrides =
        Overrides { profile: Some(Profile::Hopper), decision_budget_ns: Some(123_456_789), dem: Some(other) };
    let world = load(path.to_str().unwrap()).unwrap().with(&overrides).resolve().unwrap();
    assert_eq!(world.brief.profile, Profile::Hopper);
    assert_eq!(world.brief.limits.decision_budget_ns, 123_456_789);
    assert_eq!(world.terrain.ground(Cell::new(4, 4)).unwrap().gradient, [0.125, 0.0]);
    assert!(world.resolved.contains("other.asc"));

    let refused = load("hard").unwrap().with(&overrides).resolve().unwrap_err().to_string();
    says(&refused, &["--dem", "elevation_file", "generated"]);
}

#[test]
fn an_elevation_file_gives_heights_over_the_datum_gradients_and_impassable_ground() {
    let world = Folder::new().world(REAL).unwrap();
    assert_eq!(world.brief.scenario.as_str(), "mission", "named after its file");
    let ground = |x, y| *world.terrain.ground(Cell::new(x, y)).unwrap();
    assert_eq!((ground(3, 2).height_m, ground(3, 2).gradient), (1.0, [0.0, 0.25]));
    assert!(!ground(0, 0).passable, "nodata");
    let blocked: Vec<Cell> =
        world.terrain.grid.iter().filter(|&cell| !ground(cell.x, cell.y).passable).collect();
    let cliff = [(6, 3), (5, 4), (7, 4), (6, 5)].map(|(x, y)| Cell::new(x, y));
    assert_eq!(blocked, [&[Cell::new(0, 0)], &cliff[..]].concat(), "the slopes around the spire");
    assert_eq!(world.brief.priors.height_m, Range { min: 0.0, max: 4040.0 });
    assert!(world.warnings.is_empty(), "a way leads around");
    let survey = Folder::new().world(&REAL.replace("-4000", "\"survey\"")).unwrap();
    let mean: f64 = survey.terrain.cells.iter().skip(1).map(|ground| ground.height_m).sum::<f64>() / 107.0;
    assert!(mean.abs() < 1e-9, "heights are relative to their mean");
}

#[test]
fn crop_resampling_and_exaggeration_follow_one_another() {
    let folder = Folder::new();
    let with = |fields: &str| {
        let text = REAL.replace("dem.asc\"", &format!("dem.asc\"\n{fields}"));
        folder.world(&text.replace("[10, 7]", "[3, 3]")).unwrap()
    };
    let cells = with("crop_cells = { x = 7, y = 4, width = 5, height = 4 }");
    assert_eq!((cells.brief.grid.width, cells.brief.grid.height), (5, 4));
    assert_eq!(cells.terrain.ground(Cell::new(2, 0)).unwrap().height_m, 2.0);
    let metres = with("crop_m = { west = 114, south = 308, width = 10, height = 8 }");
    assert_eq!(metres.terrain, cells.terrain, "the same crop in metres");

    let fine = with(
        "crop_cells = { x = 7, y = 4, width = 5, height = 4 }\ncell_size_m = 1.0\nvertical_exaggeration = 2.0",
    );
    assert_eq!((fine.brief.grid.width, fine.brief.grid.height, fine.brief.grid.hop_cells), (10, 8, 2));
    let ground = fine.terrain.ground(Cell::new(6, 3)).unwrap();
    // The middle of row 3 lies 0.25 old cells above that of row 1: 4 + 1.25 rows of 0.5 m, doubled; the
    // datum stays -4000 while the heights of some -8000 do not.
    assert!((ground.height_m - (2.0 * (5.25 * 0.5 - 4000.0) + 4000.0)).abs() < 1e-9, "{ground:?}");
    assert_eq!(ground.gradient, [0.0, 0.5]);
}

#[test]
fn a_hop_that_is_no_whole_number_of_cells_is_refused_with_the_cell_size_that_mends_it() {
    let folder = Folder::new();
    says(&folder.error(&REAL.replace("= 2.0", "= 5.0")), &["whole number of cells", "cell_size_m = 1.6666"]);
    says(&folder.error(&REAL.replace("= 2.0", "= 1.0")), &["1 m over cells of 2 m", "cell_size_m = 1 "]);
    let mended = REAL
        .replace("[1, 1]", "[3, 1]")
        .replace("[10, 7]", "[20, 14]")
        .replace("= 2.0", "= 1.0")
        .replace("dem.asc\"", "dem.asc\"\ncell_size_m = 1");
    assert_eq!(folder.world(&mended).unwrap().brief.grid.hop_cells, 1);
}

#[test]
fn sand_lies_in_rectangles_hollows_and_masks() {
    let folder = Folder::new();
    let mask = folder.write("mask.asc", &grid(|x, y| f64::from(u32::from(x == 8 && y > 2))));
    let sand = format!(
        "[truth.sand]\nmask_file = {:?}\nrectangles = [{{ x = [1, 2], y = [7, 99] }}]\nbelow_height_m = 0.5\n",
        mask
    );
    let is_sand =
        |world: &ResolvedScenario, x, y| world.terrain.ground(Cell::new(x, y)).unwrap().soil == Soil::Sand;
    let world = folder.world(&format!("{sand}{REAL}")).unwrap();
    for (x, y, expected) in [
        (8, 3, true),
        (8, 2, false),
        (9, 3, false),
        (1, 8, true),
        (2, 7, true),
        (3, 7, false),
        (5, 0, true),
        (5, 1, false),
    ] {
        assert_eq!(is_sand(&world, x, y), expected, "({x}, {y})");
    }
    // The mask is cropped and resampled with the terrain: the column of x = 8 becomes two.
    let crop = "dem.asc\"\ncrop_cells = { x = 7, y = 3, width = 5, height = 6 }\ncell_size_m = 1";
    let text = format!("{sand}{REAL}").replace("dem.asc\"", crop).replace("[10, 7]", "[9, 7]");
    let fine = folder.world(&text).unwrap();
    let columns: Vec<i32> = (0..10).filter(|&x| is_sand(&fine, x, 5)).collect();
    assert_eq!(columns, [2, 3]);

    let small = folder.write("small.asc", "ncols 1\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 2\n1\n");
    let refused = folder.error(&format!("[truth.sand]\nmask_file = {small:?}\n{REAL}"));
    says(&refused, &["small.asc", "12 x 9 cells", "1 x 1"]);
    says(
        &folder.error(&format!("[truth.sand]\nmask_file = \"none.asc\"\n{REAL}")),
        &["truth.sand.mask_file", "none.asc", "found none"],
    );
}

#[test]
fn start_and_goal_have_to_be_on_the_map_passable_and_whole_hops_apart() {
    let folder = Folder::new();
    says(&folder.error(&REAL.replace("[10, 7]", "[12, 7]")), &["brief.goal", "(11, 8)", "(12, 7)"]);
    says(&folder.error(&REAL.replace("[1, 1]", "[0, 0]")), &["brief.start", "nodata", "such as (1, 0)"]);
    says(&folder.error(&REAL.replace("[10, 7]", "[5, 4]")), &["brief.goal", "degrees", "such as (5, 3)"]);
    let long = REAL.replace("= 2.0", "= 4.0");
    says(&folder.error(&long), &["whole hops of 2 cells", "multiples of 2"]);
    assert!(folder.world(&long.replace("[10, 7]", "[9, 7]")).is_ok());
}

#[test]
fn a_check_tells_what_rovers_cover_and_what_they_are() {
    let told = ScenarioCheck::of(&load("coverage").unwrap().resolve().unwrap()).to_string();
    says(&told, &["cover 100 % of the cells that can be reached, together", "robot 3", "sees 3 x 3 cells"]);
    assert!(!told.contains("hops of") && !told.contains("payoff"), "{told}");
}

#[test]
fn a_goal_that_no_chain_of_hops_reaches_is_a_warning() {
    let folder = Folder::new();
    folder.write("dem.asc", &grid(|x, _| if x >= 6 { 50.0 } else { 0.0 }));
    let world = folder.world(REAL).unwrap();
    let [warning] = &world.warnings[..] else { panic!("{:?}", world.warnings) };
    assert!(matches!(warning, Warning::Unreachable { .. }));
    says(&ScenarioCheck::of(&world).to_string(), &["no way", "warning: no chain of hops"]);

    let hasty = hilly("[brief]", "[limits]\nsteps_max = 5\n[brief]").unwrap();
    says(&hasty.warnings[0].to_string(), &["steps_max = 5", "14 steps", "7 hops"]);
}

#[test]
fn a_missing_elevation_file_says_where_it_was_looked_for_and_how_to_name_another() {
    let folder = Folder::new();
    let text = folder.error(&REAL.replace("dem.asc", "gone/dem.tif"));
    says(&text, &["truth.terrain.elevation_file.file", "gone/dem.tif", "found none", "--dem FILE"]);
    assert!(text.contains(folder.0.path().to_str().unwrap()), "the absolute path: {text}");
    let cut_short = folder.write("short.asc", "ncols 12\nnrows 9\n");
    let text = folder.error(&REAL.replace("dem.asc", "short.asc"));
    says(&text, &[cut_short.file_name().unwrap().to_str().unwrap(), "xllcorner", "none"]);
}

#[test]
fn the_mars_scenario_asks_for_its_model() {
    let text = load("mars").unwrap().resolve().unwrap_err().to_string();
    says(&text, &["gale_hirise_DTEEC_009650_1755_crop_4p98m.tif", "found none", "--dem FILE"]);
}

#[test]
fn the_hash_changes_with_any_cell_and_any_field_but_not_with_folder_or_budget() {
    let (here, there) = (Folder::new(), Folder::new());
    let hash = |folder: &Folder, text: &str| folder.world(text).unwrap().hash;
    let first = hash(&here, REAL);
    assert_eq!(first, hash(&there, REAL), "the same mission in another folder");
    assert_eq!(first, hash(&here, &format!("{REAL}[limits]\ndecision_budget_ms = 1\n")));
    assert_ne!(first, hash(&here, &format!("{REAL}[limits]\nsteps_max = 149\n")));
    assert_ne!(first, hash(&here, &REAL.replace("[brief]", "[brief]\nweights = { safety = 0.4 }")));
    let bumped = grid(|x, y| {
        let bump = if (x, y) == (11, 0) { 1e-6 } else { 0.0 };
        if (x, y) == (6, 4) { 40.0 } else { f64::from(y) * 0.5 - 4000.0 + bump }
    });
    there.write("dem.asc", &bumped);
    assert_ne!(first, hash(&there, REAL), "one cell a micrometre higher");
    assert_eq!(here.world(REAL).unwrap().brief.scenario_hash, first);
}

#[test]
fn priors_and_datum_are_given_or_surveyed() {
    let given = hilly("[brief]", "[brief]\npriors = { safety = [-1, 0], height_m = [0.5, 2] }").unwrap();
    assert_eq!(given.brief.priors.safety, Range { min: -1.0, max: 0.0 });
    assert_eq!(given.brief.priors.height_m, Range { min: 0.5, max: 2.0 });
    let surveyed = hilly("[brief]", "[brief]\npriors = { safety = \"survey\" }").unwrap();
    assert_eq!(surveyed.brief.priors.height_m, surveyed.terrain.height_range());
    assert_eq!(surveyed.brief.priors.safety, surveyed.terrain.safety_range(-5.0));
    let lower = hilly("[brief]", "[brief]\ndatum_m = 100").unwrap();
    assert!((lower.brief.priors.height_m.max - (0.2 - 100.0)).abs() < 1e-12);
    let treasures = |name: &str| scenario::load(name).unwrap().resolve().unwrap().brief.priors.treasures;
    assert_eq!((treasures("hard"), treasures("treasures")), (0, 4));
}

#[test]
fn mistakes_in_the_text_are_told_with_line_and_column() {
    for (from, to, line, words) in [
        ("sigma_m = 1.0", "sigma = 1.0", "line 6, column 1", "unknown field `sigma`"),
        ("start = [0, 0]", "start = [0]", "line 10, column 9", "length"),
        ("[brief]", "[journey]", "line 9, column 2", "unknown field `journey`"),
        ("start = [0, 0]", "profile = \"paper\"", "line 10, column 11", "unknown variant `paper`"),
        ("start = [0, 0]", "datum_m = \"lowest\"", "line 10, column 11", "need \"survey\", a number"),
        ("start = [0, 0]", "start = [0, 0", "line 1", ""),
        ("[truth.terrain.gaussians]", "[truth.terrain.sphere]", "line 2", "unknown variant `sphere`"),
    ] {
        let text = hilly(from, to).unwrap_err().to_string();
        says(&text, &["hilly: TOML parse error at", words]);
        assert!(text.contains(line) || line == "line 1", "{line} is missing in: {text}");
    }
    let two = HILLY.replace("[brief]", "[truth.terrain.elevation_file]\nfile = \"x\"\n[brief]");
    says(&Scenario::parse(&two, "two").unwrap_err().to_string(), &["TOML parse error"]);
}

#[test]
fn values_out_of_range_are_refused_with_need_and_got() {
    for (from, to, words) in [
        ("sigma_m = 1.0", "sigma_m = 0", ["sigma_m", "above 0 m"]),
        ("sigma_m = 1.0", "sigma_m = nan", ["sigma_m", "NaN"]),
        ("amplitude_m = 0.2", "amplitude_m = inf", ["amplitude_m", "inf"]),
        ("[[1, 1]]", "[[nan, 1]]", ["raised_m", "NaN"]),
        ("cell_size_m = 0.5", "cell_size_m = -0.5", ["cell_size_m", "above 0 m"]),
        ("cell_size_m = 0.5", "cell_size_m = 0.3", ["whole number of cells", "cell_size_m = 0.333"]),
        ("width_cells = 10", "width_cells = 2000", ["1 to 1024 cells", "2000"]),
        ("width_cells = 10", "width_cells = 0", ["1 to 1024 cells", "0 x 8"]),
        ("[brief]", "[brief]\nname = \"two words\"", ["brief.name", "two words"]),
        ("[brief]", "[brief]\ndatum_m = 1e9", ["brief.datum_m", "1000000000"]),
        ("[brief]", "[brief]\npayoff = { discount = 1.0 }", ["brief.payoff.discount", "got 1"]),
        ("[brief]", "[brief]\nweights = { safety = nan }", ["brief.weights.safety", "NaN"]),
        ("[brief]", "[brief]\npriors = { safety = [1, 0] }", ["brief.priors.safety", "got 0"]),
        ("[brief]", "[limits]\nsteps_max = 0\n[brief]", ["brief.steps_max", "got 0"]),
        ("[brief]", "[limits]\ndecision_budget_ms = -1\n[brief]", ["limits.decision_budget_ms", "-1"]),
        ("[brief]", "[guard]\nhazard_max = 1.5\n[brief]", ["guard.hazard_max", "1.5"]),
        ("[brief]", "[guard]\ndeadline_s = 0\n[brief]", ["guard.deadline_s", "got 0"]),
        ("[brief]", "[robot]\nslope_limit_deg = 95\n[brief]", ["slope_limit_rad", "1.65"]),
        ("[brief]", "[robot]\ngravity_mps2 = 0\n[brief]", ["gravity_mps2", "got 0"]),
        ("[brief]", "[robot]\nhop_distance_m = nan\n[brief]", ["robot.hop_distance_m", "NaN"]),
        ("[brief]", "[robot.sensor]\nradius_min_m = 0.2\n[brief]", ["robot.sensor.radius_min_m", "one hop"]),
        ("[brief]", "[robot.sensor]\nradius_max_m = 0.2\n[brief]", ["sensor.radius_max_m", "0.2"]),
        (
            "[brief]",
            "[robot.hard]\nintended = 0.9\nstuck = 0\nsideways = 0.2\nflights = 1\n[brief]",
            ["robot.hard: need intended + stuck + 2 x sideways = 1", "1.3"],
        ),
        (
            "[brief]",
            "[robot.sand]\nintended = 0.8\nstuck = 0\nsideways = 0.1\nflights = 3\n[brief]",
            ["motion.flights", "got 3"],
        ),
        (
            "[brief]",
            "[truth.sand]\nrectangles = [{ x = [3, 1], y = [0, 1] }]\n[brief]",
            ["rectangles", "[3, 1]"],
        ),
    ] {
        let text = hilly(from, to).expect_err(to).to_string();
        says(&text, &words);
        assert_eq!(text.lines().count(), 1, "{text}");
    }
}

/// P-TREASURE-CELLS
#[test]
fn treasures_lie_where_they_can_be_collected() {
    let treasures = built_in("treasures").terrain.treasures;
    assert_eq!(
        treasures,
        [(12, 4), (4, 10), (10, 10), (15, 15)].map(|(x, y)| Cell::new(x, y)),
        "in index order"
    );
    let at = |cells: &str| {
        let text = BUILT_IN.iter().find(|(name, _)| *name == "treasures").unwrap().1;
        let all = "[[12, 4], [10, 10], [4, 10], [15, 15]]";
        assert!(text.contains(all));
        Scenario::parse(&text.replace(all, cells), "test").unwrap().resolve()
    };
    assert_ne!(at("[[12, 4]]").unwrap().hash, at("[[12, 5]]").unwrap().hash);
    assert_eq!(at("[[5, 4], [3, 4]]").unwrap().hash, at("[[3, 4], [5, 4]]").unwrap().hash);
    let many = format!("{:?}", [[3, 3]; 17]);
    for (cells, got) in [
        ("[[20, 4]]", "(20, 4)"),
        ("[[-1, 4]]", "(-1, 4)"),
        ("[[1, 2]]", "other than start and goal"),
        ("[[18, 18]]", "other than start and goal"),
        ("[[3, 3], [4, 4], [3, 3]]", "(3, 3) twice"),
        (&many, "got 17"),
    ] {
        says(&at(cells).unwrap_err().to_string(), &["truth.treasures", got]);
    }
}

#[test]
fn random_hills_out_of_bounds_are_refused() {
    let text = |fields: &str| {
        let terrain = format!(
            "[truth.terrain.random_hills]\nwidth_cells = 9\nheight_cells = 9\ncell_size_m = 1\nseed = 1\n{fields}\n"
        );
        let scenario = format!("{terrain}[brief]\nstart = [0, 0]\ngoal = [8, 8]\n");
        Scenario::parse(&scenario, "hills").unwrap().resolve().unwrap_err().to_string()
    };
    says(&text("hills = 1001\nsigma_m = [1, 2]\namplitude_m = [0, 1]"), &["at most 1000 hills", "1001"]);
    says(&text("hills = 5\nsigma_m = [0, 2]\namplitude_m = [0, 1]"), &["sigma_m", "[0, 2]"]);
    says(&text("hills = 5\nsigma_m = [1, 2]\namplitude_m = [2, 1]"), &["amplitude_m", "[2, 1]"]);
    let near = "hills = 5\nsigma_m = [1, 2]\namplitude_m = [0, 1]\nreach_sigma = 2";
    says(&text(near), &["reach_sigma", "at least 3", "got 2"]);
}

#[test]
fn an_unknown_selector_names_the_known_scenarios() {
    says(
        &load("nowhere").unwrap_err().to_string(),
        &["hard, heterogeneous, sandy, large, treasures, wide, vast, hills, patrol, mars", "nowhere"],
    );
}

/// Walks a scenario along the schema, following references, and fails where a field is not in it.
#[test]
fn every_field_of_every_shipped_scenario_is_in_the_schema() {
    let schema = Scenario::schema();
    for (name, text) in BUILT_IN {
        let value: toml::Table = text.parse().unwrap();
        follow(&schema, &schema, &serde_json::to_value(value).unwrap(), name);
    }
    let text = schema.to_string();
    says(
        &text,
        &["additionalProperties\":false", "paper-2023", "seen_differences", "elevation_file", "survey"],
    );
}

fn follow(root: &serde_json::Value, schema: &serde_json::Value, value: &serde_json::Value, at: &str) {
    let schema = match schema.get("$ref").and_then(serde_json::Value::as_str) {
        Some(reference) => root.pointer(reference.trim_start_matches('#')).unwrap(),
        None => schema,
    };
    let serde_json::Value::Object(fields) = value else { return };
    if let Some(variants) = schema.get("oneOf").or(schema.get("anyOf")).and_then(serde_json::Value::as_array)
    {
        let variant = variants.iter().find(|variant| {
            let properties = follow_reference(root, variant).get("properties");
            properties.is_some_and(|properties| fields.keys().all(|key| properties.get(key).is_some()))
        });
        return follow(root, variant.unwrap_or_else(|| panic!("{at} is no variant of {schema}")), value, at);
    }
    for (key, value) in fields {
        let property = schema.pointer(&format!("/properties/{key}"));
        follow(
            root,
            property.unwrap_or_else(|| panic!("{at}.{key} is not in the schema")),
            value,
            &format!("{at}.{key}"),
        );
    }
}

fn follow_reference<'a>(root: &'a serde_json::Value, schema: &'a serde_json::Value) -> &'a serde_json::Value {
    match schema.get("$ref").and_then(serde_json::Value::as_str) {
        Some(reference) => root.pointer(reference.trim_start_matches('#')).unwrap(),
        None => schema,
    }
}

/// P-SCOUT-SCENARIO.
#[test]
fn missions_with_scouts_that_cannot_be_are_refused_by_name() {
    const ROVER: &str = "[[robots]]\nvehicle = \"rover\"\n";
    const HELICOPTER: &str = "[[robots]]\nvehicle = \"helicopter\"\n";
    let resolve = |terrain: &str, mission: &str, robots: &str| {
        let text = format!("[truth.terrain.{terrain}\n[mission]\n{mission}\n[brief]\n{robots}");
        Scenario::parse(&text, "scouts").unwrap().resolve().map(|world| world.planners.len())
    };
    let error = |terrain, mission, robots: &str| resolve(terrain, mission, robots).unwrap_err().to_string();
    let passages = "passages]\nseed = 3";
    let scout = "kind = \"scout\"";
    assert_eq!(resolve(passages, scout, &[ROVER, HELICOPTER].concat()).unwrap(), 2);
    assert_eq!(resolve(passages, scout, &[HELICOPTER, ROVER, HELICOPTER].concat()).unwrap(), 3);
    let with = |field: &str| format!("{ROVER}{HELICOPTER}{field}\n");
    let open = "obstacles]\nwidth_cells = 9\nheight_cells = 9\ncell_size_m = 1\npercent = 0\nseed = 1";
    let cover = "kind = \"cover\"";
    for (error, need) in [
        (error(passages, scout, ""), "robots"),
        (error(passages, scout, HELICOPTER), "one rover"),
        (error(passages, scout, &ROVER.repeat(2)), "one rover"),
        (error(passages, scout, &[ROVER, &HELICOPTER.repeat(16)].concat()), "1 to 16"),
        (error(passages, scout, &with("start = [3, 4]")), "robots.start"),
        (error(passages, scout, &with("budget_m = -1")), "robots.budget_m"),
        (error(passages, scout, &with("view_radius_m = 0")), "robots.view_radius_m"),
        (error(passages, scout, &with("speed_mps = 0")), "robots.speed_mps"),
        (error(passages, scout, &format!("{ROVER}budget_m = 9\n")), "vehicle = \"helicopter\""),
        (error(passages, scout, &with("[[faults]]\nrobot = 2\naction = 1")), "faults"),
        (error(passages, "kind = \"scout\"\nrover_samples = 0", ROVER), "mission.rover_samples"),
        (error(passages, "kind = \"reach\"", "start = [0, 0]\ngoal = [9, 9]"), "mission.kind"),
        (error(open, scout, ROVER), "mission.kind"),
        (error(open, cover, &format!("{ROVER}start = [0, 0]\n{HELICOPTER}")), "robots.vehicle"),
        (error(open, cover, ROVER), "robots.start"),
        (
            error(open, "kind = \"cover\"\nhelicopter_samples = 5", &format!("{ROVER}start = [0, 0]\n")),
            "scout",
        ),
    ] {
        says(&error, &[need]);
    }
}

/// The seed of planners is public: it is that of no draw, and the same whatever the mission's.
#[test]
fn a_mission_with_scouts_tells_planners_a_seed_that_is_not_the_worlds() {
    let world = load("rover-helicopter").unwrap().resolve().unwrap();
    let seed = world.brief.scout.unwrap().seed;
    assert!(seed > 1 << 32, "{seed}");
    assert_eq!(world.terrain.prior.len(), world.terrain.cells.len());
    let again = Scenario::parse(&world.resolved, "again").unwrap().resolve().unwrap();
    assert_eq!((again.hash, again.brief.scout, again.fleet), (world.hash, world.brief.scout, world.fleet));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn a_scenario_with_foreign_bytes_resolves_or_is_refused(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<char>()), 1..4),
    ) {
        let mut text: Vec<char> = HILLY.chars().collect();
        for (at, character) in changes {
            let at = at.index(text.len());
            text[at] = character;
        }
        let text: String = text.into_iter().collect();
        let _ = Scenario::parse(&text, "damaged").and_then(|scenario| scenario.resolve());
    }
}
