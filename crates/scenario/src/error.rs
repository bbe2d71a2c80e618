//! Errors of reading and resolving a scenario.

use std::path::PathBuf;

use contract::name::NameError;
use contract::{Cell, Refusal};
use terrain::TerrainError;

/// Why a scenario cannot be read or resolved: each message says what was needed, what was got and what to do.
#[derive(Debug, thiserror::Error)]
pub enum ScenarioError {
    /// Any of the errors of resolving, with the file of the scenario.
    #[error("{}: {source}", path.display())]
    In {
        /// File that the scenario was read from.
        path: PathBuf,
        /// The error itself.
        source: Box<ScenarioError>,
    },
    /// The selector is neither a built-in scenario nor an existing file.
    #[error("need a scenario file or one of {built_in}, got {got:?}")]
    Unknown {
        /// Names of the built-in scenarios, separated by commas.
        built_in: String,
        /// The selector as given on the command line or in a campaign.
        got: String,
    },
    /// The selector is none, and resembles a built-in scenario or a file.
    #[error("no scenario is called {got:?}{meant}")]
    Mistyped {
        /// The selector as given on the command line or in a campaign.
        got: String,
        /// What it resembles, as the end of a sentence.
        meant: String,
    },
    /// The selector names a file that does not exist.
    #[error(
        "{got}: need a scenario file, found none{meant}; `hopper scenario list` has those that are built in"
    )]
    NoFile {
        /// The path as given.
        got: String,
        /// What it resembles, as the end of a sentence.
        meant: String,
    },
    /// A folder was given where a file is needed.
    #[error("{}: need a file, got a folder; {}", path.display(), match files.as_str() {
        "" => "name the file in it".to_owned(),
        files => format!("name a file in it, such as {files}"),
    })]
    Folder {
        /// The folder.
        path: PathBuf,
        /// TOML files in it, separated by commas.
        files: String,
    },
    /// The file holds something else than text.
    #[error("{}: need a scenario or a campaign, which is text, got bytes that are none{hint}", path.display())]
    NotText {
        /// File that was read.
        path: PathBuf,
        /// Where a file with this ending belongs, as the end of the message; may be empty.
        hint: &'static str,
    },
    /// The file exists but cannot be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// File that was opened.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The file is longer than any scenario or campaign.
    #[error("{}: need at most {bytes_max} bytes, got more; name a scenario or a campaign file", path.display())]
    TooLong {
        /// File that was opened.
        path: PathBuf,
        /// Most bytes that are read.
        bytes_max: u64,
    },
    /// The text is not a scenario; the message has line and column.
    #[error("{origin}: {message}")]
    Toml {
        /// File or built-in scenario the text comes from.
        origin: String,
        /// Message of the TOML parser, shortened.
        message: String,
    },
    /// The text has a field of the time when a mission had a kind.
    #[error(
        "{origin}: line {line}: {field} is no field any more, since a mission follows from its robots; write {instead}"
    )]
    Former {
        /// File or built-in scenario the text comes from.
        origin: String,
        /// Its line in the text, from 1.
        line: usize,
        /// The field.
        field: &'static str,
        /// What to write in its place.
        instead: &'static str,
    },
    /// `brief.name` is empty, too long, or not printable.
    #[error("brief.name: {0}; set brief.name")]
    Name(#[from] NameError),
    /// The name of a planner in `robots` is empty, too long, or not printable.
    #[error("robots.planner: {error}, for robot {robot}")]
    Planner {
        /// Number of the robot, from 0.
        robot: usize,
        /// What is wrong with the name.
        error: NameError,
    },
    /// The obstacles do not fit on the ground.
    #[error("truth.terrain.obstacles: {0}")]
    Obstacles(#[from] coverage_world::WorldError),
    /// A file named by the scenario does not exist.
    #[error(
        "{field}: need the file {}, found none{}",
        path.display(), match *field {
            "--dem" => "",
            "truth.terrain.elevation_file.file" => {
                "; put it there, name another in the scenario, or point to it with --dem FILE"
            }
            _ => "; put it there, or name another in the scenario",
        }
    )]
    FileMissing {
        /// Scenario field that names the file.
        field: &'static str,
        /// Absolute path that was looked for.
        path: PathBuf,
    },
    /// `--dem` or `--nodata` was given for a scenario whose terrain is generated.
    #[error("{flag} needs a scenario with truth.terrain.elevation_file, got one whose terrain is generated")]
    DemUnused {
        /// What was given.
        flag: &'static str,
    },
    /// No two cells of the middle of an elevation model are connected by hops.
    #[error(
        "{}: need ground that hops can cross, got {passable} passable cells in the middle {width} x {height}; see \
         `hopper terrain check`, and choose a part with truth.terrain.elevation_file.crop_cells in a scenario",
        path.display()
    )]
    NoWay {
        /// The elevation model.
        path: PathBuf,
        /// Number of passable cells.
        passable: usize,
        /// Columns of the part looked at.
        width: u32,
        /// Rows of the part looked at.
        height: u32,
    },
    /// The elevation file has both `crop_cells` and `crop_m`.
    #[error("truth.terrain.elevation_file: need crop_cells or crop_m, got both; keep one")]
    TwoCrops,
    /// The elevation file or the lattice is unusable.
    #[error(transparent)]
    Terrain(#[from] TerrainError),
    /// A field is out of its range.
    #[error("{field}: need {need}, got {got}")]
    Value {
        /// Path of the field, such as `robot.sensor.radius_min_m`.
        field: &'static str,
        /// Allowed range, with its unit.
        need: &'static str,
        /// Value in the scenario.
        got: String,
    },
    /// The motion table that planners are to believe is unusable.
    #[error(
        "brief.motion.table: {}: need {need}, got {got}; `hopper motion derive --out DIR` writes a sound one",
        path.display()
    )]
    MotionTable {
        /// The file.
        path: PathBuf,
        /// What a table has.
        need: &'static str,
        /// What this one has.
        got: String,
    },
    /// Under contact dynamics no launch reaches the next cell on the flat.
    #[error(
        "truth.dynamics: need a launch that comes to rest {hop_m} m away on level {soil}, one hop; the fastest, {speed_mps} m/s with \
         a grip of {foot}, falls short: raise `speed_max_mps`, or `foot` or `restitution` of {soil}"
    )]
    ShortHop {
        /// The soil.
        soil: &'static str,
        /// Length of a hop, metres.
        hop_m: f64,
        /// Largest launch speed, m/s.
        speed_mps: f64,
        /// Grip of the foot on that soil.
        foot: f64,
    },
    /// The start or a goal lies outside the map.
    #[error("{field}: need a cell within (0, 0) to {last}, got {got}")]
    OffMap {
        /// Path of the field, such as `brief.start`.
        field: &'static str,
        /// North-eastern cell of the map, the largest valid one.
        last: Cell,
        /// Cell given in the scenario.
        got: String,
    },
    /// The start or a goal lies on impassable ground.
    #[error("{field}: need passable ground, got {got}, which {why}; choose a cell nearby, such as {nearby}")]
    Impassable {
        /// Path of the field, such as `brief.start`.
        field: &'static str,
        /// Cell given in the scenario.
        got: String,
        /// Why it is impassable: "has no height (nodata)" or "slopes N degrees".
        why: String,
        /// Nearest passable cell on the hop lattice, or "none on this map".
        nearby: String,
    },
    /// A goal is not a whole number of hops from the start.
    #[error(
        "{field}: need whole hops of {hop_cells} cells from the start {start}, got {goal}; \
         choose a goal whose columns and rows differ from the start's by multiples of {hop_cells}"
    )]
    OffLattice {
        /// Path of the field, such as `brief.goal`.
        field: &'static str,
        /// Cells spanned by one hop.
        hop_cells: u32,
        /// Start of the hopper, which fixes the lattice of its landing cells.
        start: Cell,
        /// First goal off that lattice.
        goal: String,
    },
    /// A resolved value is outside the range that the brief message allows.
    #[error("the resolved {0}")]
    Brief(Refusal),
}

impl ScenarioError {
    /// This error, about robot `number` of several.
    pub(crate) fn of_robot(mut self, number: usize) -> Self {
        if let Self::Value { got, .. }
        | Self::OffMap { got, .. }
        | Self::Impassable { got, .. }
        | Self::OffLattice { goal: got, .. } = &mut self
        {
            *got += &format!(" for robot {number}");
        }
        self
    }
}

/// The refusal of a value.
pub(crate) fn refuse<T>(field: &'static str, need: &'static str, got: String) -> Result<T, ScenarioError> {
    Err(ScenarioError::Value { field, need, got })
}
