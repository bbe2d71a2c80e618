//! The layers of the map, as they are sent to the page.

use contract::{Brief, DriveSpeed, Ground};
use report::Layer;
use report::layers::{Look, Value};
use serde_json::json;
use speed_layer::SpeedEstimate;

/// The value of a layer of speeds, and the parts of a unit that it is rounded to.
pub(super) type SpeedValue = (fn([f64; 2]) -> f64, f64);

/// The layers of a mission that show speeds, in the order of their columns.
pub(super) fn of_speeds(brief: &Brief) -> Vec<SpeedValue> {
    let value = |layer: Layer| {
        let scale = layer.scale()?;
        let Value::Speed { of, .. } = scale.value else { return None };
        Some((of, scale.parts()))
    };
    Layer::of(brief).into_iter().filter_map(value).collect()
}

/// A layer that shows a value of seen ground.
#[derive(Clone, Copy, Debug)]
pub(super) struct GroundLayer {
    pub layer: Layer,
    /// The value of a cell.
    pub of: fn(&Ground, u16) -> f64,
    /// Parts of a unit that values are rounded to for the page.
    pub parts: f64,
}

/// The layers of a mission that show values of seen ground, in the order of their columns.
pub(super) fn of_ground(brief: &Brief) -> Vec<GroundLayer> {
    let value = |layer: Layer| {
        let scale = layer.scale()?;
        let Value::Ground { of, .. } = scale.value else { return None };
        Some(GroundLayer { layer, of, parts: scale.parts() })
    };
    Layer::of(brief).into_iter().filter_map(value).collect()
}

/// The layers of a mission as JSON: how each is drawn. A layer with a scale also names the column of the frames `speeds` or `cells`
/// that holds its values.
pub(super) fn for_page(brief: &Brief) -> serde_json::Value {
    let (mut speeds, mut cells) = (0, 0);
    let first = Layer::first(brief);
    let layer = |layer: Layer| {
        let definition = layer.definition();
        let mut described = json!({
            "name": definition.name,
            "menu": definition.menu,
            "legend": definition.legend,
            "first": layer == first,
        });
        match definition.look {
            Look::Relief => described["look"] = json!("relief"),
            Look::Entries => described["look"] = json!("entries"),
            Look::Scale(scale) => {
                let (of, words, count) = match scale.value {
                    Value::Speed { words, .. } => ("speeds", words, &mut speeds),
                    Value::Ground { words, .. } => ("cells", words, &mut cells),
                };
                described["look"] = json!("scale");
                described["ramp"] = json!(scale.ramp);
                described["most"] = json!(scale.most);
                described["of"] = json!(of);
                described["words"] = json!(words);
                described["column"] = json!(*count);
                *count += 1;
            }
        }
        described
    };
    Layer::of(brief).into_iter().map(layer).collect()
}

/// What the layers of speeds show of a cell whose speed was seen, for each of the four speeds.
pub(super) fn certain(brief: &Brief) -> Vec<Vec<f64>> {
    let layers = of_speeds(brief);
    let row = |speed: &DriveSpeed| {
        let estimate = SpeedEstimate::certain(*speed).mean_and_sd_m_per_sol();
        layers.iter().map(|(of, _)| of(estimate)).collect()
    };
    DriveSpeed::ALL.iter().map(row).collect()
}
