//! The relief of each source of terrain: generated, or cut out of an elevation model.

use std::cell::RefCell;
use std::io::{BufRead, Cursor, Seek};
use std::path::Path;

use contract::limits::GRADIENT_MAX;
use contract::{Grid, Range};
use coverage_world::World;
use terrain::{
    Fill, Gaussian, LayerNotes, RandomField, RasterFile, Relief, SourceCells, Survey, TerrainError, Window,
    hop_cells, read_layer,
};

use crate::bounds::{in_range, positive};
use crate::truth::{CropCells, CropMetres};
use crate::{
    ElevationFile, Gaussians, Obstacles, Passages, RandomHills, Rock, Rocks, ScenarioError, Warning,
};

/// Most hills of a generated terrain.
const HILLS_MAX: usize = 1000;

/// A relief with the cells of its source, on which further rasters lie.
pub struct Shaped {
    pub relief: Relief,
    pub source: SourceCells,
    /// What reading the elevation model and the layers on it had to decide.
    pub warnings: RefCell<Vec<Warning>>,
}

impl Shaped {
    pub fn generated(relief: Relief) -> Self {
        let Grid { width, height, .. } = relief.grid;
        let window = Window::all(width, height);
        let source = SourceCells { shape: (width, height), window, ratio: None, georeference: None };
        Self { relief, source, warnings: RefCell::default() }
    }

    /// The values of the layer at `path`, in index order; NaN for nodata.
    pub fn layer(&self, path: &Path) -> Result<Vec<f64>, ScenarioError> {
        let layer = read_layer(path, &self.source)?;
        self.warn_of(path, &layer.notes);
        Ok(layer.values)
    }

    /// Warns of what reading the layer at `path` had to decide.
    pub fn warn_of(&self, path: &Path, notes: &LayerNotes) {
        let file = path.display();
        let mut warnings = self.warnings.borrow_mut();
        warnings.extend(notes.fills.iter().map(|fill| {
            let Fill { value, cells, .. } = *fill;
            let declared = fill.in_words();
            let text = format!(
                "{file}: {fill}; taken for nodata: declare it with gdal_translate -a_nodata {declared} IN OUT"
            );
            Warning::SuspectedNodata { value, cells, text }
        }));
        if let Some([own, of_model]) = &notes.other_system {
            let text = format!(
                "{file}: its coordinate system is {own}, that of the elevation model {of_model}: taken for the same, as its \
                 numbers are"
            );
            warnings.push(Warning::GroundConverted { text });
        }
    }
}

impl Gaussians {
    /// The hills raised and lowered.
    pub fn hills(&self) -> Result<Vec<Gaussian>, ScenarioError> {
        positive("truth.terrain.gaussians.sigma_m", self.sigma_m)?;
        in_range("truth.terrain.gaussians.amplitude_m", self.amplitude_m, -1e6..=1e6, "-1e6 to 1e6 m")?;
        let count = self.raised_m.len() + self.lowered_m.len();
        hill_count("truth.terrain.gaussians", count)?;
        for &coordinate in self.raised_m.iter().chain(&self.lowered_m).flatten() {
            in_range(
                "truth.terrain.gaussians.raised_m or lowered_m",
                coordinate,
                -1e6..=1e6,
                "-1e6 to 1e6 m",
            )?;
        }
        let offset_m = self.ground_at.offset_cells() * self.cell_size_m;
        let hill = |sign: f64| {
            move |centre_m: &[f64; 2]| Gaussian {
                centre_m: centre_m.map(|coordinate_m| coordinate_m - offset_m),
                sigma_m: self.sigma_m,
                amplitude_m: sign * self.amplitude_m,
            }
        };
        Ok(self.raised_m.iter().map(hill(1.0)).chain(self.lowered_m.iter().map(hill(-1.0))).collect())
    }
}

impl Rocks {
    /// Most rocks: every cell is tested against each.
    const ROCKS_MAX: usize = 1000;

    /// The relief of the plain with its rocks.
    pub fn shape(&self, hop_distance_m: f64) -> Result<Shaped, ScenarioError> {
        let grid = grid(self.width_cells, self.height_cells, self.cell_size_m, hop_distance_m)?;
        let refuse = |need, got| Err(ScenarioError::Value { field: "truth.terrain.rocks.rocks", need, got });
        if self.rocks.len() > Self::ROCKS_MAX {
            return refuse("at most 1000", self.rocks.len().to_string());
        }
        for Rock { x, y, height_m } in &self.rocks {
            if x[0] > x[1] || y[0] > y[1] {
                return refuse("[first, last] with first at most last", format!("x = {x:?}, y = {y:?}"));
            }
            in_range("truth.terrain.rocks.rocks.height_m", *height_m, -1e3..=1e3, "-1000 to 1000 m")?;
        }
        let covers = |rock: &&Rock, cell: contract::Cell| {
            (rock.x[0]..=rock.x[1]).contains(&cell.x) && (rock.y[0]..=rock.y[1]).contains(&cell.y)
        };
        let height_m = |cell| {
            let rock = self.rocks.iter().rev().find(|rock| covers(rock, cell));
            rock.map_or(0.0, |rock| rock.height_m)
        };
        let cells = grid.iter().map(|cell| Some((height_m(cell), [0.0, 0.0]))).collect();
        Ok(Shaped::generated(Relief { grid, cells }))
    }
}

impl RandomHills {
    /// The field that random hills are drawn from.
    pub fn field(&self) -> Result<RandomField, ScenarioError> {
        hill_count("truth.terrain.random_hills.hills", self.hills as usize)?;
        let range = |field, [min, max]: [f64; 2], least: f64| {
            if min > least && min <= max && max <= 1e6 {
                Ok(Range { min, max })
            } else {
                let need = "[smallest, largest], at most 1e6 m, sigma_m above 0";
                Err(ScenarioError::Value { field, need, got: format!("[{min}, {max}]") })
            }
        };
        Ok(RandomField {
            seed: u64::from(self.seed),
            hills: self.hills,
            sigma_m: range("truth.terrain.random_hills.sigma_m", self.sigma_m, 0.0)?,
            amplitude_m: range("truth.terrain.random_hills.amplitude_m", self.amplitude_m, -1e6)?,
        })
    }
}

impl Obstacles {
    /// Obstacles are cells without ground.
    pub fn shape(&self, hop_distance_m: Option<f64>) -> Result<Shaped, ScenarioError> {
        let hop_distance_m = hop_distance_m.unwrap_or(self.cell_size_m);
        let grid = grid(self.width_cells, self.height_cells, self.cell_size_m, hop_distance_m)?;
        let world = World::random(grid, self.percent, self.seed)?;
        let ground = |cell| world.is_free(cell).then_some((0.0, [0.0; 2]));
        Ok(Shaped::generated(Relief { grid, cells: grid.iter().map(ground).collect() }))
    }
}

impl Passages {
    /// Level ground; what it is like is written into the terrain later.
    pub fn shape(&self, hop_distance_m: Option<f64>) -> Result<Shaped, ScenarioError> {
        let lattice = scout_world::monte_carlo(self.seed).prior.surface().lattice();
        let grid = grid(lattice.width() as u32, lattice.height() as u32, 1.0, hop_distance_m.unwrap_or(1.0))?;
        let level = vec![Some((0.0, [0.0; 2])); grid.cells()];
        Ok(Shaped::generated(Relief { grid, cells: level }))
    }
}

impl ElevationFile {
    /// The ground, out of `contents` if they are at hand, otherwise out of the file.
    pub fn read(&self, contents: Option<&[u8]>, hop_distance_m: f64) -> Result<Shaped, ScenarioError> {
        match contents {
            Some(contents) => self.read_from(RasterFile::new(Cursor::new(contents))?, hop_distance_m),
            None => self.read_from(RasterFile::open(&self.file)?, hop_distance_m),
        }
    }

    fn read_from<R: BufRead + Seek>(
        &self,
        raster: RasterFile<R>,
        hop_distance_m: f64,
    ) -> Result<Shaped, ScenarioError> {
        in_range(
            "truth.terrain.elevation_file.vertical_exaggeration",
            self.vertical_exaggeration,
            1e-3..=1e3,
            "0.001 to 1000",
        )?;
        let source_cells = (raster.header().width, raster.header().height);
        let georeference = raster.georeference()?;
        let window = match (self.crop_cells, self.crop_m) {
            (Some(_), Some(_)) => return Err(ScenarioError::TwoCrops),
            (Some(CropCells { x, y, width, height }), None) => Window { x, y, width, height },
            (None, Some(CropMetres { west, south, width, height })) => {
                georeference.window(source_cells, [west, south, width, height])?
            }
            (None, None) => Window::all(source_cells.0, source_cells.1),
        };
        // A cell size that no hop can span is refused before the cells are read.
        let cell_size_m = self.cell_size_m.unwrap_or(georeference.cell_size_m);
        let hop_cells = hop_cells(hop_distance_m, cell_size_m)?;
        let survey = raster.with_nodata(self.nodata.clone()).survey(window)?;
        let Survey { mut elevation, georeference, remarks } = survey;
        let mut ratio = None;
        if cell_size_m != elevation.cell_size_m {
            ratio = Some(cell_size_m / elevation.cell_size_m);
            elevation = elevation.resampled(cell_size_m)?;
        }
        let relief = Relief::of_elevation(&elevation, self.vertical_exaggeration, hop_cells)?;
        check_slopes(&relief)?;
        let source = SourceCells { shape: source_cells, window, ratio, georeference: Some(georeference) };
        let warnings = RefCell::new(remarks.iter().map(Warning::from).collect());
        Ok(Shaped { relief, source, warnings })
    }
}

/// Refuses ground that is too steep for the messages that carry it, where the file is known.
fn check_slopes(relief: &Relief) -> Result<(), TerrainError> {
    let known = || relief.cells.iter().flatten();
    let gradients = known().flat_map(|(_, gradient)| gradient.map(f64::abs));
    let gradient = gradients.fold(0.0, f64::max);
    if gradient <= GRADIENT_MAX {
        return Ok(());
    }
    let heights = || known().map(|(height_m, _)| *height_m);
    let (min_m, max_m) =
        (heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max));
    Err(TerrainError::TooSteep { gradient_max: GRADIENT_MAX, gradient, min_m, max_m })
}

/// The lattice on which a hop spans whole cells.
pub fn grid(width: u32, height: u32, cell_size_m: f64, hop_distance_m: f64) -> Result<Grid, ScenarioError> {
    positive("truth.terrain cell_size_m", cell_size_m)?;
    let hop_cells = hop_cells(hop_distance_m, cell_size_m)?;
    Ok(Grid::new(width, height, cell_size_m, hop_cells).map_err(TerrainError::from)?)
}

fn hill_count(field: &'static str, count: usize) -> Result<(), ScenarioError> {
    if count <= HILLS_MAX {
        Ok(())
    } else {
        Err(ScenarioError::Value { field, need: "at most 1000 hills", got: count.to_string() })
    }
}
