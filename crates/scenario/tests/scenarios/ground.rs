//! Ground from elevation models, and what lies on it.

use contract::{Cell, Range, Soil};
use scenario::{ResolvedScenario, Scenario, ScenarioCheck, Warning};

use crate::{Folder, REAL, built_in, grid, hilly, says};

#[test]
fn ground_at_the_centre_is_that_half_a_cell_further_on() {
    let text = include_str!("../../../../scenarios/hard.toml");
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
    assert_eq!(world.brief.priors.height_m, Range { min: 0.0, max: 20.0 });
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

/// P-DEM-LAYERS.
#[test]
fn a_sand_mask_lies_where_the_model_does_and_what_looks_like_nodata_in_it_is_warned_of() {
    let folder = Folder::new();
    let mask = |text: &str| format!("[truth.sand]\nmask_file = {:?}\n{REAL}", folder.write("mask.asc", text));
    let filled = grid(|x, y| if x == 2 { 255.0 } else { f64::from(u32::from(x == 8 && y > 2)) });
    let world = folder.world(&mask(&filled)).unwrap();
    let sand = world.terrain.cells.iter().filter(|ground| ground.soil == Soil::Sand).count();
    assert_eq!(sand, 6, "255 is no sand");
    let [Warning::SuspectedNodata { value, cells, text }] = &world.warnings[..] else {
        panic!("{:?}", world.warnings)
    };
    assert_eq!((*value, *cells), (255.0, 9));
    says(text, &["mask.asc", "255 looks like nodata", "gdal_translate -a_nodata 255"]);
    let elsewhere = filled.replace("xllcorner 100", "xllcorner 102");
    says(&folder.error(&mask(&elsewhere)), &["mask.asc", "(101, 301)", "(103, 301)", "same extent"]);
}

/// P-DEM-FILL. Datum, priors and ground leave out what looks like nodata until the scenario settles
/// it.
#[test]
fn what_looks_like_nodata_counts_for_nothing_until_it_is_settled() {
    let folder = Folder::new();
    folder.write("dem.asc", &grid(|x, y| if x == 11 { -10000.0 } else { f64::from(y) * 0.5 - 4000.0 }));
    let survey = REAL.replace("= -4000", "= \"survey\"").replace("[10, 7]", "[8, 7]");
    let suspected = folder.world(&survey).unwrap();
    assert!(
        matches!(suspected.warnings[..], [Warning::SuspectedNodata { cells: 9, .. }]),
        "{:?}",
        suspected.warnings
    );
    assert!((suspected.brief.datum_m + 3998.0).abs() < 0.1, "{}", suspected.brief.datum_m);
    assert!(!suspected.terrain.ground(Cell::new(11, 4)).unwrap().passable);
    let settle = |values: &str| survey.replace("dem.asc\"", &format!("dem.asc\"\nnodata = {values}"));
    let settled = folder.world(&settle("[-10000]")).unwrap();
    assert_eq!((&settled.warnings, settled.hash), (&vec![], suspected.hash));
    let none = folder.world(&settle("[]")).unwrap();
    assert!(none.warnings.is_empty() && none.brief.datum_m < -4400.0, "{}", none.brief.datum_m);
}

#[test]
fn a_goal_whole_hops_away_is_accepted() {
    let long = REAL.replace("= 2.0", "= 4.0").replace("[10, 7]", "[9, 7]");
    assert!(Folder::new().world(&long).is_ok());
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

/// P-UP-GROUND: A plain with rocks is level within each cell; where several rocks lie on a cell, the last of them counts.
#[test]
fn rocks_have_level_tops_and_steps_around_them() {
    let world = built_in("rocks");
    assert!(world.terrain.cells.iter().all(|ground| ground.gradient == [0.0; 2] && ground.passable));
    let height_m = |x, y| world.terrain.ground(Cell::new(x, y)).unwrap().height_m;
    let corners = [(2, 3), (3, 3), (6, 6), (7, 6), (10, 10), (12, 12), (13, 12)];
    assert_eq!(corners.map(|(x, y)| height_m(x, y)), [0.0, 1.0, 1.0, 0.0, 0.25, 0.25, 0.0]);
    assert_eq!(world.brief.priors.safety, Range { min: -0.25, max: 0.0 }, "the climb of a vertical hop");
    let text = include_str!("../../../../scenarios/rocks.toml");
    let with = |rocks: &str| {
        let (before, rest) = text.split_once("rocks = [").unwrap();
        let (_, after) = rest.split_once("]\n\n").unwrap();
        Scenario::parse(&format!("{before}rocks = [{rocks}]\n\n{after}"), "rocks").unwrap().resolve()
    };
    let rock = |height_m: f64| format!("{{ x = [5, 5], y = [5, 5], height_m = {height_m} }},");
    let world = with(&(rock(1.0) + &rock(-0.5))).unwrap();
    assert_eq!(world.terrain.ground(Cell::new(5, 5)).unwrap().height_m, -0.5);
    let refused = with(&rock(0.1).repeat(1001)).unwrap_err().to_string();
    assert_eq!(refused, "truth.terrain.rocks.rocks: need at most 1000, got 1001");
}

/// P-UP-SCENARIO: With a known map a hopper sees the whole map from any cell; what is at its default is left out of the canonical text.
#[test]
fn a_known_map_is_in_sight_and_defaults_are_left_out() {
    let known = built_in("known-hard");
    let (grid, sensor) = (known.brief.grid, known.brief.leg(0).sensor);
    for height_m in [-3.0, 0.0, 9.0] {
        let reach_cells = sensor.reach_cells(&grid, height_m);
        assert!(reach_cells >= Cell::new(0, 0).distance_cells(Cell::new(19, 19)), "{reach_cells}");
    }
    assert!(known.resolved.contains("map = \"known\"") && known.resolved.contains("vertical = true"));
    let plain = built_in("hard");
    assert!(!plain.resolved.contains("map =") && !plain.resolved.contains("vertical"));
    let text = include_str!("../../../../scenarios/hard.toml");
    let said = text.replace("profile =", "map = \"unknown\"\nprofile =");
    let said = said.replace("hop_distance_m =", "vertical = false\nhop_distance_m =");
    assert_eq!(Scenario::parse(&said, "hard").unwrap().resolve().unwrap().hash, plain.hash);
    let again = Scenario::parse(&known.resolved, "again").unwrap().resolve().unwrap();
    assert_eq!((again.hash, again.brief), (known.hash, known.brief), "the canonical text resolves to itself");
}
