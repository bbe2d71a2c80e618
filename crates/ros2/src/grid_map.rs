//! The map as `grid_map_msgs/GridMap`: what is known of each cell, layer by layer.
//!
//! It reaches over the smallest rectangle that holds all seen cells. Row 0 is its eastern border and column 0 its northern one, as in
//! the `grid_map` library, whose indices grow against the axes; numbers stand column by column.

use contract::{Brief, Cell, Ground, ObservedMap, Policy, PriorCell, Soil};
use report::Layer;
use report::layers::Value;
use speed_layer::SpeedLayer;

use crate::Clock;
use crate::message::{Float32MultiArray, GridMap, GridMapInfo, MultiArrayDimension, MultiArrayLayout, Pose};
use crate::pose::MAP;
use crate::seen_box::SeenBox;

/// The layer without which a cell is not valid.
const BASIC: &str = "height";

/// The layer of a policy's values.
const VALUE: &str = "value";

/// The number that a layer has of seen ground.
type Number = fn(&Ground) -> f64;

/// What every mission's ground has. Soils have the numbers of `view/map`: 1 hard, 2 sand.
const GROUND: [(&str, Number); 6] = [
    (BASIC, |ground| ground.height_m),
    ("gradient", Ground::steepness),
    ("gradient_x", |ground| ground.gradient[0]),
    ("gradient_y", |ground| ground.gradient[1]),
    ("soil", |ground| if ground.soil == Soil::Hard { 1.0 } else { 2.0 }),
    ("passable", |ground| f64::from(u8::from(ground.passable))),
];

/// The layer that says which cells are seen.
const SEEN: &str = "seen";

/// Bytes of a number.
const NUMBER_BYTES: u64 = 4;

/// The layers of one mission.
#[derive(Clone, Debug)]
pub(crate) struct Layers {
    scales: Vec<(&'static str, Value)>,
    speeds: Option<SpeedLayer>,
}

impl Layers {
    /// Those of `brief`, with those of uncertain ground if its whole prior is known.
    pub fn new(brief: &Brief, prior: &[PriorCell]) -> Self {
        let has_prior = prior.len() == brief.grid.cells();
        let speeds = has_prior.then(|| SpeedLayer::new(prior, &brief.robots));
        let scales = Layer::of(brief).into_iter().filter_map(|layer| {
            let value = layer.scale()?.value;
            let is_known = speeds.is_some() || matches!(value, Value::Ground { .. });
            is_known.then_some((layer.definition().name, value))
        });
        Self { scales: scales.collect(), speeds }
    }

    /// The size of the numbers of a map, bytes.
    pub fn bytes(&self, seen: &SeenBox, has_values: bool) -> u64 {
        let layers = GROUND.len() + 1 + self.scales.len() + usize::from(has_values);
        seen.cells().saturating_mul(layers as u64 * NUMBER_BYTES)
    }

    /// The map, with the values of the policy that was made on it, if one was recorded; `None` if nothing is seen.
    pub fn map(
        &self,
        map: &ObservedMap,
        seen: &SeenBox,
        policy: Option<&Policy>,
        clock: &Clock,
    ) -> Option<GridMap> {
        let [least, most] = seen.corners()?;
        let [rows, columns] = seen.sides();
        let cells = Cells { map, least, most };
        let mut layers = Vec::new();
        let mut data = Vec::new();
        let mut add = |name: &str, value: &dyn Fn(usize) -> f64| {
            layers.push(name.to_owned());
            data.push(array(cells.indices().map(|index| value(index) as f32).collect(), rows, columns));
        };
        for (name, of) in GROUND {
            add(name, &|index| map.cells()[index].as_ref().map_or(f64::NAN, of));
        }
        add(SEEN, &|index| f64::from(u8::from(map.cells()[index].is_some())));
        for (name, value) in &self.scales {
            add(name, &|index| self.scale(map, index, value));
        }
        if let Some(policy) = policy {
            add(VALUE, &|index| policy.cells.get(index).map_or(f64::NAN, |cell| cell.value));
        }
        let side_m = map.grid.cell_size_m;
        let middle = |least: i32, most: i32| (f64::from(least) + f64::from(most) + 1.0) / 2.0 * side_m;
        let info = GridMapInfo {
            resolution: side_m,
            length_x: f64::from(rows) * side_m,
            length_y: f64::from(columns) * side_m,
            pose: Pose::at([middle(least.x, most.x), middle(least.y, most.y), 0.0], 0.0),
        };
        Some(GridMap {
            header: clock.header(map.published, MAP),
            info,
            layers,
            basic_layers: vec![BASIC.to_owned()],
            data,
            outer_start_index: 0,
            inner_start_index: 0,
        })
    }

    /// What a layer with a scale shows of a cell; no number where it shows nothing.
    fn scale(&self, map: &ObservedMap, index: usize, value: &Value) -> f64 {
        let ground = map.cells()[index].as_ref();
        match value {
            Value::Ground { of, .. } => ground.map_or(f64::NAN, |ground| of(ground, map.visits(index))),
            Value::Speed { of, .. } => {
                let estimate = self.speeds.as_ref().and_then(|speeds| speeds.estimate_seen(index, ground));
                estimate.map_or(f64::NAN, |estimate| of(estimate.mean_and_sd_m_per_sol()))
            }
        }
    }
}

/// The cells of a rectangle in the order of a grid map.
struct Cells<'a> {
    map: &'a ObservedMap,
    least: Cell,
    most: Cell,
}

impl Cells<'_> {
    fn indices(&self) -> impl Iterator<Item = usize> {
        let columns = (self.least.y..=self.most.y).rev();
        let cells = columns.flat_map(|y| (self.least.x..=self.most.x).rev().map(move |x| Cell::new(x, y)));
        cells.map(|cell| self.map.grid.index(cell).expect("a seen cell's row and column lie on the lattice"))
    }
}

fn array(data: Vec<f32>, rows: u32, columns: u32) -> Float32MultiArray {
    let dimension = |label: &str, size, stride| MultiArrayDimension { label: label.to_owned(), size, stride };
    let dim = vec![
        dimension("column_index", columns, rows.saturating_mul(columns)),
        dimension("row_index", rows, rows),
    ];
    Float32MultiArray { layout: MultiArrayLayout { dim, data_offset: 0 }, data }
}
