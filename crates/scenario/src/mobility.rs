//! Section `[truth.mobility]`: how fast a rover drives, as far as is known and in truth.

use std::path::PathBuf;

use contract::{Cell, DriveSpeed, SpeedPrior};
use routing::Stream;
use rover::{Lattice, Point, Speed, SpeedDistribution, Surface, TerrainClass, speed, speed_distribution};
use terrain::Terrain;

use crate::ScenarioError;
use crate::error::refuse;
use crate::shape::Shaped;
use crate::truth::{Layer, Mobility};

/// A driver is at its goal within this distance, metres, as in the Monte Carlo study.
pub(crate) const GOAL_RADIUS_M: f64 = 3.0;

/// What is known of the cells.
enum Known {
    Classes(Vec<[f64; 11]>),
    Speeds(Vec<SpeedDistribution>),
}

/// Names of the terrain classes, in the order of [`TerrainClass::ALL`].
const CLASSES: [&str; 11] = [
    "smooth_regolith",
    "smooth_outcrop",
    "fractured_outcrop",
    "sparse_linear_ripples",
    "rough_outcrop",
    "crater",
    "rock_field",
    "dense_linear_ripples",
    "deep_sand",
    "polygonal_ripples",
    "scarp",
];

/// What a name in `classes` needs to be.
const CLASS_NEEDED: &str = "names of terrain classes (smooth_regolith, smooth_outcrop, fractured_outcrop, \
    sparse_linear_ripples, rough_outcrop, crater, rock_field, dense_linear_ripples, deep_sand, polygonal_ripples, scarp)";

impl Layer {
    fn file(&mut self) -> Option<&mut PathBuf> {
        match self {
            Self::Everywhere(_) => None,
            Self::File(file) => Some(file),
        }
    }

    /// The values in index order, each from 0 to 1 where the terrain has a height; errors say `of` what.
    fn shares(&self, field: &'static str, of: &str, shaped: &Shaped) -> Result<Vec<f64>, ScenarioError> {
        let (need, is_share) = ("0 to 1", |value: f64| (0.0..=1.0).contains(&value));
        match self {
            Self::Everywhere(value) if is_share(*value) => Ok(vec![*value; shaped.relief.cells.len()]),
            Self::Everywhere(value) => Err(ScenarioError::Value { field, need, got: format!("{value}{of}") }),
            Self::File(file) => {
                let (origin, values) = (format!("{}{of}", file.display()), shaped.layer(file)?);
                checked(field, need, origin, values, shaped, is_share)
            }
        }
    }
}

/// The values of a layer, which are right wherever the terrain has a height.
fn checked(
    field: &'static str,
    need: &'static str,
    origin: String,
    values: Vec<f64>,
    shaped: &Shaped,
    is_right: impl Fn(f64) -> bool,
) -> Result<Vec<f64>, ScenarioError> {
    let heights = shaped.relief.cells.iter();
    let wrong = values.iter().zip(heights).position(|(value, height)| height.is_some() && !is_right(*value));
    match wrong {
        None => Ok(values),
        Some(index) => {
            let (cell, value) = (shaped.relief.grid.cell(index), values[index]);
            let value = if value.is_nan() { "no value".into() } else { value.to_string() };
            Err(ScenarioError::Value { field, need, got: format!("{value} in cell {cell} of {origin}") })
        }
    }
}

impl Mobility {
    /// All files that it names.
    pub(crate) fn files(&mut self) -> impl Iterator<Item = &mut PathBuf> {
        let Self { rock_abundance, class_file, classes, speeds, true_speed_file, .. } = self;
        let layers =
            std::iter::once(rock_abundance).chain(classes.values_mut()).chain(speeds.iter_mut().flatten());
        layers.filter_map(Layer::file).chain(class_file).chain(true_speed_file)
    }

    /// Writes prior and true speeds into `terrain`.
    ///
    /// # Errors
    /// If a raster does not fit or has a value that cannot be.
    pub(crate) fn spread(&self, shaped: &Shaped, terrain: &mut Terrain) -> Result<(), ScenarioError> {
        let grid = terrain.grid;
        if grid.cell_size_m != 1.0 {
            return Err(ScenarioError::Value {
                field: "truth.mobility",
                need: "terrain with cells of 1 m; set truth.terrain.elevation_file.cell_size_m = 1.0, which resamples",
                got: format!("{} m", grid.cell_size_m),
            });
        }
        let lattice = Lattice::new(grid.width as usize, grid.height as usize);
        let lattice = lattice.map_err(|error| ScenarioError::Value {
            field: "truth.mobility",
            need: "terrain that a rover's map can hold",
            got: error.to_string(),
        })?;
        let heights_m: Vec<f64> = terrain.cells.iter().map(|ground| ground.height_m).collect();
        let surface = Surface::from_heights(lattice, &heights_m).expect("a finite height for each cell");
        let abundance = self.rock_abundance.shares("truth.mobility.rock_abundance", "", shaped)?;
        let known = self.known(shaped)?;
        let prior = known.prior(&surface, &abundance, shaped)?;
        let truth = match &self.true_speed_file {
            Some(file) => true_speeds(file, shaped)?,
            None => known.drawn(self.seed, &surface, &abundance),
        };
        for (index, ground) in terrain.cells.iter_mut().enumerate() {
            let is_ground = shaped.relief.cells[index].is_some();
            let speed = if is_ground { scout_world::drive_speed(truth[index]) } else { DriveSpeed::Zero };
            ground.speed = Some(speed);
        }
        let prior = prior.iter().map(|speeds| SpeedPrior::new(speeds.probabilities()));
        terrain.prior = prior.collect::<Result<_, _>>().map_err(ScenarioError::Brief)?;
        Ok(())
    }

    /// Which of the fields are given of which there may be one.
    fn given(&self) -> String {
        let given = [
            ("class_file", self.class_file.is_some()),
            ("classes", !self.classes.is_empty()),
            ("speeds", self.speeds.is_some()),
        ];
        let given: Vec<_> = given.iter().filter(|(_, is_given)| *is_given).map(|(field, _)| *field).collect();
        if given.is_empty() { "none".into() } else { given.join(" and ") }
    }

    fn known(&self, shaped: &Shaped) -> Result<Known, ScenarioError> {
        let cells = shaped.relief.cells.len();
        match (&self.class_file, self.classes.is_empty(), &self.speeds) {
            (Some(file), true, None) => {
                let is_class = |value: f64| value.fract() == 0.0 && (0.0..=10.0).contains(&value);
                let codes = shaped.layer(file)?;
                let (field, origin) = ("truth.mobility.class_file", file.display().to_string());
                let codes = checked(field, "classes 0 to 10", origin, codes, shaped, is_class)?;
                let certain =
                    |code: &f64| std::array::from_fn(|class| f64::from(u8::from(*code == class as f64)));
                Ok(Known::Classes(codes.iter().map(certain).collect()))
            }
            (None, false, None) => {
                let field = "truth.mobility.classes";
                let mut probabilities = vec![[0.0; 11]; cells];
                for (name, layer) in &self.classes {
                    let class = CLASSES.iter().position(|class| class == name);
                    let class = class.ok_or_else(|| ScenarioError::Value {
                        field,
                        need: CLASS_NEEDED,
                        got: format!("{name:?}"),
                    })?;
                    let shares = layer.shares(field, &format!(" for {name}"), shaped)?;
                    probabilities.iter_mut().zip(shares).for_each(|(of, share)| of[class] = share);
                }
                Ok(Known::Classes(probabilities))
            }
            (None, true, Some(layers)) => {
                let shares = |(speed, layer): (Speed, &Layer)| {
                    layer.shares(
                        "truth.mobility.speeds",
                        &format!(" for {} m/Sol", speed.m_per_sol()),
                        shaped,
                    )
                };
                let layers = Speed::ALL.into_iter().zip(layers);
                let layers = layers.map(shares).collect::<Result<Vec<_>, _>>()?;
                let speeds = (0..cells).map(|cell| {
                    let probabilities: [f64; 4] = std::array::from_fn(|speed| layers[speed][cell]);
                    let given = SpeedDistribution::as_given(probabilities);
                    let sum = probabilities.iter().sum();
                    distribution("truth.mobility.speeds", given.ok(), sum, cell, shaped)
                });
                Ok(Known::Speeds(speeds.collect::<Result<_, _>>()?))
            }
            _ => Err(ScenarioError::Value {
                field: "truth.mobility",
                need: "exactly one of class_file, classes (with at least one class) and speeds",
                got: self.given(),
            }),
        }
    }
}

/// The distribution of a cell, none if its probabilities do not have the `sum` 1; where the terrain has no height, speed 0.
fn distribution(
    field: &'static str,
    given: Option<SpeedDistribution>,
    sum: f64,
    cell: usize,
    shaped: &Shaped,
) -> Result<SpeedDistribution, ScenarioError> {
    if shaped.relief.cells[cell].is_none() {
        return Ok(SpeedDistribution::certain(Speed::Zero));
    }
    given.ok_or_else(|| {
        let (need, cell) = ("probabilities that add up to 1 in each cell", shaped.relief.grid.cell(cell));
        let sum = (1e9 * sum).round() / 1e9;
        ScenarioError::Value { field, need, got: format!("a sum of {sum} in cell {cell}") }
    })
}

impl Known {
    fn prior(
        &self,
        surface: &Surface,
        abundance: &[f64],
        shaped: &Shaped,
    ) -> Result<Vec<SpeedDistribution>, ScenarioError> {
        let classes = match self {
            Known::Speeds(speeds) => return Ok(speeds.clone()),
            Known::Classes(classes) => classes,
        };
        let of = |(cell, classes): (usize, &[f64; 11])| {
            let given = speed_distribution(classes, surface.slope_deg(cell), abundance[cell]);
            distribution("truth.mobility.classes", given.ok(), classes.iter().sum(), cell, shaped)
        };
        classes.iter().enumerate().map(of).collect()
    }

    /// True speeds: those of a class or speed drawn for each region, in the order of their first cells.
    fn drawn(&self, seed: u64, surface: &Surface, abundance: &[f64]) -> Vec<Speed> {
        let mut draws = Stream::new(seed, "mobility");
        let mut uniforms: Vec<Option<f64>> = vec![None; abundance.len()];
        for cell in 0..uniforms.len() {
            if uniforms[cell].is_none() {
                let uniform = draws.uniform();
                self.spread_over_region(cell, surface.lattice(), uniform, &mut uniforms);
            }
        }
        let speed_of = |(cell, uniform): (usize, &Option<f64>)| {
            let uniform = uniform.unwrap_or_default();
            match self {
                Known::Speeds(speeds) => speeds[cell].quantile(uniform),
                Known::Classes(classes) => {
                    speed(class_at(&classes[cell], uniform), surface.slope_deg(cell), abundance[cell])
                }
            }
        };
        uniforms.iter().enumerate().map(speed_of).collect()
    }

    /// Gives `uniform` to all cells that are connected with `first` and of which the same is known.
    fn spread_over_region(&self, first: usize, lattice: Lattice, uniform: f64, uniforms: &mut [Option<f64>]) {
        let (width, cells) = (lattice.width(), uniforms.len());
        let mut left = vec![first];
        while let Some(cell) = left.pop() {
            if uniforms[cell].is_some() || !self.is_same(first, cell) {
                continue;
            }
            uniforms[cell] = Some(uniform);
            let column = cell % width;
            left.extend((column > 0).then(|| cell - 1));
            left.extend((column + 1 < width).then(|| cell + 1));
            left.extend(cell.checked_sub(width));
            left.extend(Some(cell + width).filter(|above| *above < cells));
        }
    }

    fn is_same(&self, one: usize, other: usize) -> bool {
        match self {
            Known::Classes(classes) => classes[one] == classes[other],
            Known::Speeds(speeds) => speeds[one] == speeds[other],
        }
    }
}

/// The class at which the probabilities, added up in order, exceed `uniform`.
fn class_at(probabilities: &[f64; 11], uniform: f64) -> TerrainClass {
    let mut sum = 0.0;
    let likely = |(class, probability): (TerrainClass, &f64)| {
        sum += probability;
        (uniform < sum).then_some(class)
    };
    // Rounding may leave the sum just below 1: then it is the last class that there may be.
    let last =
        || (0..11).rev().find(|class| probabilities[*class] > 0.0).map(|class| TerrainClass::ALL[class]);
    TerrainClass::ALL
        .into_iter()
        .zip(probabilities)
        .find_map(likely)
        .or_else(last)
        .unwrap_or(TerrainClass::Scarp)
}

fn true_speeds(file: &std::path::Path, shaped: &Shaped) -> Result<Vec<Speed>, ScenarioError> {
    let speed = |value: f64| Speed::ALL.into_iter().find(|speed| speed.m_per_sol() == value);
    let values = shaped.layer(file)?;
    let (field, need) = ("truth.mobility.true_speed_file", "0, 50, 150 or 200 m/Sol");
    let origin = file.display().to_string();
    let values = checked(field, need, origin, values, shaped, |value| speed(value).is_some())?;
    Ok(values.into_iter().map(|value| speed(value).unwrap_or(Speed::Zero)).collect())
}

/// The middle of a cell, given in `field`, at which a driver starts or ends.
///
/// # Errors
/// If it is off the map, or no driver can move there.
pub(crate) fn middle_of_drivable(
    field: &'static str,
    cell: Cell,
    terrain: &Terrain,
) -> Result<Point, ScenarioError> {
    match terrain.ground(cell) {
        None => refuse(field, "a cell on the map", cell.to_string()),
        Some(ground) if ground.speed == Some(DriveSpeed::Zero) => {
            refuse(field, "a cell whose true speed is above 0", cell.to_string())
        }
        Some(_) => Ok(Point::new(f64::from(cell.x) + 0.5, f64::from(cell.y) + 0.5)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_class_is_answered_with_the_name_of_each() {
        assert_eq!(CLASS_NEEDED, format!("names of terrain classes ({})", CLASSES.join(", ")));
    }
}
