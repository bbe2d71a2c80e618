//! A scenario fitted to an elevation model, for a first mission over ground that nobody has described.
//!
//! Crop, hop, start, goal, sensor and step limit follow from the model, and from nothing else: the same file always gives
//! the same mission.

use std::collections::VecDeque;
use std::fmt;
use std::io::{BufRead, Cursor, Seek};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use contract::limits::GRID_SIDE_MAX;
use contract::name::Name;
use contract::{Cell, Direction, Grid};
use terrain::{RasterFile, Relief, Sand, Terrain, Window, fitting_hop_m, hop_cells};

use crate::body::Body;
use crate::resolve::not_utf_8;
use crate::{Robot, Scenario, ScenarioError};

/// Most hops along a side of the part that is flown: room for a way around, and a mission of a minute.
const HOPS_ACROSS_MAX: u32 = 128;

/// Most cells that one hop spans; smaller cells get shorter hops than the default of a metre.
const HOP_CELLS_MAX: u32 = 8;

/// Hops of passable ground around start and goal, so that no single slip there ends the mission, where there is room.
const CLEARANCE_HOPS: i32 = 4;

/// Steps allowed for each hop of the shortest way: slopes make hops fail, and the way is not known beforehand.
const STEPS_PER_HOP: u64 = 10;

/// Least step limit, that of the paper.
const STEPS_MIN: u64 = 150;

/// The sensor sees this many hops far at the mean height of the map, half as many metres more for each metre above it,
/// and at most twice as far.
const SEEN_HOPS: f64 = 6.0;

/// A scenario for an elevation model. Displayed, it is what was chosen, in one phrase.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted {
    /// The scenario; it names the model by its absolute path.
    pub scenario: Scenario,
    choice: Choice,
}

/// What was chosen to fit the model.
#[derive(Clone, Debug, PartialEq)]
struct Choice {
    /// The model, by its absolute path.
    path: PathBuf,
    /// Values that are nodata, if the user has settled them.
    nodata: Option<Vec<f64>>,
    body: Option<Body>,
    window: Window,
    source_cells: (u32, u32),
    hop_distance_m: f64,
    start: Cell,
    goal: Cell,
    hops_min: u32,
}

impl fmt::Display for Fitted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Choice { window, source_cells: (width, height), hop_distance_m, start, goal, hops_min, .. } =
            &self.choice;
        if (window.width, window.height) == (*width, *height) {
            write!(f, "all {width} x {height} cells")?;
        } else {
            write!(f, "the middle {} x {} of {width} x {height} cells", window.width, window.height)?;
        }
        write!(f, ", hops of {hop_distance_m} m, from {start} to {goal}, {hops_min} hops at least")
    }
}

/// The scenario for the elevation model at `dem`: its middle, crossed from the south-west to the north-east in profile
/// hopper.
///
/// # Errors
/// If the file is no usable elevation model, or holds no ground that could be crossed.
pub fn fitted(dem: &Path) -> Result<Fitted, ScenarioError> {
    fitted_with(dem, None)
}

/// As [`fitted`], where `nodata` settles which stored values are nodata beside the declared one.
///
/// # Errors
/// As [`fitted`].
pub fn fitted_with(dem: &Path, nodata: Option<&[f64]>) -> Result<Fitted, ScenarioError> {
    let path = dem.canonicalize().map_err(|_| ScenarioError::FileMissing {
        field: "--dem",
        path: std::path::absolute(dem).unwrap_or_else(|_| dem.into()),
    })?;
    if path.to_str().is_none() {
        return Err(not_utf_8("--dem", &path));
    }
    let raster = RasterFile::open(&path)?;
    of_raster(raster, path, nodata)
}

/// As [`fitted`], for a file of this `name` that is at hand: `contents`, which the scenario holds.
///
/// # Errors
/// As [`fitted`].
pub fn fitted_to(name: &str, contents: &Arc<[u8]>) -> Result<Fitted, ScenarioError> {
    let path = PathBuf::from(name);
    let raster = RasterFile::new(Cursor::new(Arc::clone(contents))).map_err(|error| error.of(&path))?;
    let mut fitted = of_raster(raster, path, None)?;
    fitted.scenario.elevation = Some(Arc::clone(contents));
    Ok(fitted)
}

fn of_raster<R: BufRead + Seek>(
    raster: RasterFile<R>,
    path: PathBuf,
    nodata: Option<&[f64]>,
) -> Result<Fitted, ScenarioError> {
    let raster = raster.with_nodata(nodata.map(<[f64]>::to_vec));
    let source_cells = (raster.header().width, raster.header().height);
    let of_file = |error: terrain::TerrainError| error.of(&path);
    let georeference = raster.georeference().map_err(of_file)?;
    let cell_size_m = georeference.cell_size_m;
    let body = Body::of_coordinate_system(&georeference.coordinate_system);
    let hop_distance_m = fitting_hop_m(Robot::default().hop_distance_m, cell_size_m);
    let hop_distance_m =
        hop_distance_m.min(fitting_hop_m(f64::from(HOP_CELLS_MAX) * cell_size_m, cell_size_m));
    let hop_cells = hop_cells(hop_distance_m, cell_size_m).map_err(of_file)?;
    let window = middle(source_cells, (HOPS_ACROSS_MAX * hop_cells).min(GRID_SIDE_MAX));
    let elevation = raster.elevation(window).map_err(of_file)?;
    let relief = Relief::of_elevation(&elevation, 1.0, hop_cells).map_err(of_file)?;
    let slope_limit_rad = Robot::default().slope_limit_deg.to_radians();
    let terrain = Terrain::new(&relief, relief.mean_height_m(), slope_limit_rad, &Sand::default());
    let way = longest_region(&terrain).and_then(|region| way(&terrain, &region));
    let Some((start, goal)) = way else {
        let passable = terrain.cells.iter().filter(|ground| ground.passable).count();
        return Err(ScenarioError::NoWay { path, passable, width: window.width, height: window.height });
    };
    let hops_min = terrain.hops_between(start, goal).unwrap_or_default();
    let nodata = nodata.map(<[f64]>::to_vec);
    let choice = Choice { path, nodata, body, window, source_cells, hop_distance_m, start, goal, hops_min };
    let scenario = Scenario::parse(&choice.text(&choice.path), &choice.path.display().to_string())?;
    Ok(Fitted { scenario, choice })
}

impl Fitted {
    /// The scenario as a person may go on with it, with comments. It names the model by its path from `folder`, that of
    /// the scenario file.
    #[must_use]
    pub fn text_in(&self, folder: &Path) -> String {
        let path = &self.choice.path;
        let folder = std::path::absolute(folder).and_then(|folder| folder.canonicalize()).ok();
        let file = folder.and_then(|folder| relative(path, &folder));
        self.choice.text(&file.unwrap_or_else(|| path.clone()))
    }
}

impl Choice {
    /// The scenario, which names the model by the path `file`.
    fn text(&self, file: &Path) -> String {
        let Self { path, nodata, body, hop_distance_m, start, goal, hops_min, .. } = self;
        let Window { x, y, width, height } = self.window;
        let (columns, rows) = self.source_cells;
        let file = toml::Value::String(file.to_string_lossy().into_owned());
        let far_m = 2.0 * SEEN_HOPS * hop_distance_m;
        let steps_max = STEPS_MIN.max(STEPS_PER_HOP * u64::from(*hops_min));
        let nodata = nodata.as_ref().map_or_else(String::new, |values| {
            let values = toml::Value::Array(values.iter().map(|value| toml::Value::Float(*value)).collect());
            format!("# Values that are nodata, beside the one that the model declares.\nnodata = {values}\n")
        });
        let gravity = match body {
            Some(body) => format!(
                "# Surface gravity of {}, m/s2.\ngravity_mps2 = {:?}\n",
                body.name(),
                body.gravity_mps2()
            ),
            None => format!(
                "# Surface gravity, m/s2. The model does not say of which body it is: this is that of Mars; the Moon has 1.62, \
                 the Earth\n# 9.81.\ngravity_mps2 = {:?}\n",
                Robot::default().gravity_mps2
            ),
        };
        format!(
            "# A mission over {name}, fitted to it by `hopper scenario new`.\n\
             # `hopper scenario check FILE` tells what a change leads to; docs/scenario.md has all fields.\n\
             \n\
             [truth.terrain.elevation_file]\n\
             # From the folder of this file.\n\
             file = {file}\n\
             {nodata}\
             # The part that is flown, of {columns} x {rows} cells: its south-western corner, columns and rows.\n\
             crop_cells = {{ x = {x}, y = {y}, width = {width}, height = {height} }}\n\
             \n\
             [brief]\n\
             name = \"{name}\"\n\
             profile = \"hopper\"\n\
             # Column and row from the south-western corner of the part: whole hops apart, on ground that hops connect.\n\
             start = [{start_x}, {start_y}]\n\
             goal = [{goal_x}, {goal_y}]\n\
             # Heights count from the mean of the part.\n\
             datum_m = \"survey\"\n\
             \n\
             [robot]\n\
             # A hop spans whole cells.\n\
             hop_distance_m = {hop_distance_m:?}\n\
             {gravity}\
             # Sees {seen_m:?} m far at the mean height, half as many metres more for each metre above it, {far_m:?} m at most.\n\
             sensor = {{ gain = 0.5, offset_m = {far_m:?}, radius_max_m = {far_m:?} }}\n\
             \n\
             [limits]\n\
             # The shortest way takes {hops_min} hops; slopes make hops fail.\n\
             steps_max = {steps_max}\n",
            name = name(path),
            start_x = start.x,
            start_y = start.y,
            goal_x = goal.x,
            goal_y = goal.y,
            seen_m = SEEN_HOPS * hop_distance_m,
        )
    }
}

/// `path` as seen from `folder`, both absolute; `None` if they have nothing but the root in common.
fn relative(path: &Path, folder: &Path) -> Option<PathBuf> {
    let (mut path, mut folder) = (path.components().peekable(), folder.components().peekable());
    let mut common = 0;
    while let (Some(one), Some(other)) = (path.peek(), folder.peek())
        && one == other
    {
        path.next();
        folder.next();
        common += 1;
    }
    (common > 1).then(|| folder.map(|_| Component::ParentDir).chain(path).collect())
}

/// The name of the file, as far as a scenario may have it.
fn name(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let allowed = |c: char| if c.is_ascii_alphanumeric() || "._-+".contains(c) { c } else { '-' };
    let name: String = stem.trim_start_matches('.').chars().map(allowed).take(Name::BYTES - 1).collect();
    if name.is_empty() { "dem".into() } else { name }
}

/// The middle of a raster, at most `side_max` cells a side.
fn middle((width, height): (u32, u32), side_max: u32) -> Window {
    let along = |side: u32| ((side - side.min(side_max)) / 2, side.min(side_max));
    let ((x, width), (y, height)) = (along(width), along(height));
    Window { x, y, width, height }
}

/// The most landing cells that hops over passable ground connect, of those reached from the south-western corner's
/// lattice; `None` if nothing is passable.
fn longest_region(terrain: &Terrain) -> Option<Vec<Cell>> {
    let grid = &terrain.grid;
    let is_free = |cell: Cell| terrain.ground(cell).is_some_and(|ground| ground.passable);
    let mut seen = vec![false; grid.cells()];
    let mut longest: Option<Vec<Cell>> = None;
    for first in grid.iter().filter(|&cell| grid.on_same_lattice(Cell::new(0, 0), cell) && is_free(cell)) {
        if mark(grid, &mut seen, first) {
            let mut region = Vec::new();
            let mut queue = VecDeque::from([first]);
            while let Some(cell) = queue.pop_front() {
                region.push(cell);
                let next = Direction::ALL.map(|direction| grid.hop(cell, direction));
                queue.extend(next.into_iter().filter(|&next| is_free(next) && mark(grid, &mut seen, next)));
            }
            if longest.as_ref().is_none_or(|longest| region.len() > longest.len()) {
                longest = Some(region);
            }
        }
    }
    longest
}

/// Marks `cell`; whether it was not marked before.
fn mark(grid: &Grid, seen: &mut [bool], cell: Cell) -> bool {
    grid.index(cell).is_some_and(|index| !std::mem::replace(&mut seen[index], true))
}

/// The cells of `region` furthest to the south-west and to the north-east, as clear of edges and steep ground as can be
/// had without halving the way; `None` if the region is a single cell.
fn way(terrain: &Terrain, region: &[Cell]) -> Option<(Cell, Cell)> {
    let grid = &terrain.grid;
    let hop = grid.hop_cells as i32;
    let is_clear = |cell: Cell, hops: i32| {
        let offsets = || (-hops..=hops).map(|offset| offset * hop);
        offsets().all(|dy| {
            offsets().all(|dx| {
                terrain.ground(Cell::new(cell.x + dx, cell.y + dy)).is_some_and(|ground| ground.passable)
            })
        })
    };
    let ends = |hops: i32| {
        let clear = || region.iter().copied().filter(|&cell| is_clear(cell, hops));
        let along = |cell: &Cell| (cell.x + cell.y, cell.x);
        clear().min_by_key(along).zip(clear().max_by_key(along))
    };
    let length = |(start, goal): (Cell, Cell)| goal.x + goal.y - start.x - start.y;
    let longest = length(ends(0)?);
    let clearest = (0..=CLEARANCE_HOPS).rev().filter_map(ends).find(|&way| 2 * length(way) >= longest);
    clearest.filter(|(start, goal)| start != goal)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid_file(cell_size_m: f64, rows: &[String]) -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("my dem.asc");
        let columns = rows[0].split_whitespace().count();
        let header = format!(
            "ncols {columns}\nnrows {}\nxllcorner 5e5\nyllcorner 4e6\ncellsize {cell_size_m}\nNODATA_value -9\n",
            rows.len()
        );
        std::fs::write(&path, header + &rows.join("\n") + "\n").unwrap();
        (folder, path)
    }

    fn plain(side: usize, height_m: &str) -> Vec<String> {
        vec![vec![height_m; side].join(" "); side]
    }

    #[test]
    fn any_cell_size_gets_hops_of_whole_cells() {
        for (cell_size_m, hop_m) in
            [(0.25, 1.0), (0.3, 0.9), (1.0, 1.0), (4.98, 4.98), (30.0, 30.0), (0.01, 0.08)]
        {
            let (_folder, path) = grid_file(cell_size_m, &plain(60, "7"));
            let fitted = fitted(&path).unwrap();
            let world = fitted.scenario.resolve().unwrap();
            assert!((world.brief.grid.hop_distance_m() - hop_m).abs() < 1e-12, "{cell_size_m}");
            assert_eq!(world.brief.scenario.as_str(), "my-dem");
            assert!(world.warnings.is_empty(), "{:?}", world.warnings);
            assert!(
                fitted.to_string().contains(&format!("all 60 x 60 cells, hops of {hop_m} m")),
                "{fitted}"
            );
        }
    }

    #[test]
    fn of_a_large_model_the_middle_is_flown() {
        let (_folder, path) = grid_file(2.0, &plain(300, "7"));
        let fitted = fitted(&path).unwrap();
        assert_eq!(fitted.choice.window, Window { x: 86, y: 86, width: 128, height: 128 });
        assert_eq!((fitted.choice.start, fitted.choice.goal), (Cell::new(4, 4), Cell::new(123, 123)));
        assert!(fitted.to_string().starts_with("the middle 128 x 128 of 300 x 300 cells"), "{fitted}");
    }

    #[test]
    fn start_and_goal_are_on_the_largest_ground_that_hops_connect() {
        // A gap one column wide cuts twenty columns off forty.
        let row = |x: usize| if x == 20 { "-9" } else { "7" };
        let row = (0..61).map(row).collect::<Vec<_>>().join(" ");
        let (_folder, path) = grid_file(1.0, &vec![row; 30]);
        let fitted = fitted(&path).unwrap();
        assert!(fitted.choice.start.x > 20 && fitted.choice.goal.x > fitted.choice.start.x, "{fitted}");
        assert!(fitted.scenario.resolve().unwrap().warnings.is_empty());
    }

    /// P-SCENARIO-NEW. The scenario flies as the model alone does.
    #[test]
    fn a_scenario_is_written_with_a_path_from_its_folder_and_a_comment_to_every_choice() {
        let (folder, path) = grid_file(2.0, &plain(60, "7"));
        let fitted = fitted(&path).unwrap();
        let below = folder.path().join("a");
        std::fs::create_dir(&below).unwrap();
        for (from, file) in [(folder.path(), "my dem.asc"), (&below, "../my dem.asc")] {
            let text = fitted.text_in(from);
            assert!(text.contains(&format!("file = \"{file}\"")), "{text}");
            let mut written = Scenario::parse(&text, "mine.toml").unwrap();
            written.folder = from.into();
            assert_eq!(written.resolve().unwrap().hash, fitted.scenario.clone().resolve().unwrap().hash);
        }
        let text = fitted.text_in(folder.path());
        assert!(text.contains("gravity_mps2 = 3.72") && text.contains("the Moon has 1.62"), "{text}");
        let longest = text.lines().map(str::len).max();
        assert!(longest <= Some(130) && text.matches("\n# ").count() > 7, "{text}");
        assert_eq!(relative(Path::new("/a/b"), Path::new("/c")), None);
    }

    #[test]
    fn ground_that_nobody_can_cross_is_refused() {
        for rows in [plain(1, "7"), vec!["0 90 0 90".into(), "90 0 90 0".into()]] {
            let (_folder, path) = grid_file(1.0, &rows);
            let refused = fitted(&path).unwrap_err().to_string();
            assert!(
                refused.contains("need ground that hops can cross") && refused.contains("my dem.asc"),
                "{refused}"
            );
        }
        let missing = fitted(Path::new("no/such.tif")).unwrap_err().to_string();
        assert!(missing.contains("no/such.tif"), "{missing}");
    }
}
