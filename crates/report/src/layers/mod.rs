//! What the ground of a map can show: one list for page, terminal, pictures and recordings.
//!
//! Each layer is a file with one constant, and a line in the list below. Displays go through the list and name no layer: what
//! they need to know is in [`Definition`], above all the [`Look`].

use contract::{Brief, Ground, Range};

use crate::colour;

/// Declares the module of each layer, and the list of them in the order of the lines.
macro_rules! layers {
    ($($module:ident => $name:ident,)+) => {
        $(mod $module;)+

        /// A layer of the map.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Layer {
            $(#[doc = concat!("See `", stringify!($module), ".rs`.")] $name,)+
        }

        impl Layer {
            /// Every layer, in the order in which menus have them.
            pub const ALL: &[Layer] = &[$(Layer::$name,)+];

            /// What the layer is.
            #[must_use]
            pub const fn definition(self) -> &'static Definition {
                match self {
                    $(Layer::$name => &$module::LAYER,)+
                }
            }
        }
    };
}

layers! {
    heights => Heights,
    visits => Visits,
    speed => Speed,
    spread => Spread,
}

/// What a layer is.
#[derive(Clone, Copy, Debug)]
pub struct Definition {
    /// Short name without spaces, for the page; a layer with a scale has the topic `view/NAME` in recordings.
    pub name: &'static str,
    /// In the page's menu.
    pub menu: &'static str,
    /// Over the terminal's map.
    pub title: &'static str,
    /// Over a plot of a picture.
    pub heading: &'static str,
    /// Along the scale of a picture, with the unit.
    pub quantity: &'static str,
    /// Unit of the values, behind the scale in the terminal; empty if they have none.
    pub unit: &'static str,
    /// Behind the scale on the page.
    pub legend: &'static str,
    /// How it is drawn.
    pub look: Look,
    /// Whether a mission has the layer.
    pub exists: fn(&Brief) -> bool,
    /// Whether a mission shows the layer before anything was chosen. If several layers say so, the first in the list is shown; if
    /// none does, the first of all layers.
    pub is_first: fn(&Brief) -> bool,
}

/// How a layer is drawn.
#[derive(Clone, Copy, Debug)]
pub enum Look {
    /// Heights, sand and impassable ground; the scale reaches from the lowest ground seen to the highest.
    Relief,
    /// The relief, with a mark on each cell that robots entered, darker the more often.
    Entries,
    /// Shades of a scale that is the same in all missions, without relief.
    Scale(Scale),
}

/// The scale of a layer, which begins at 0.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    /// The end of the scale, in the layer's unit.
    pub most: f64,
    /// Colours from 0 to the end, evenly spaced, at least two.
    pub ramp: &'static [[u8; 3]],
    /// What it shows of a cell.
    pub value: Value,
}

/// What a layer with a scale shows of a cell, in the layer's unit.
#[derive(Clone, Copy, Debug)]
pub enum Value {
    /// Of every cell of uncertain ground, seen or not: from the expected speed and its standard deviation, m/Sol.
    Speed {
        /// The value.
        of: fn([f64; 2]) -> f64,
        /// The value in words, with `{}` for it, where a cell is pointed at.
        words: &'static str,
    },
    /// Of seen cells: from what is known of the ground, and how often rovers that cover ground have entered it.
    Ground {
        /// The value.
        of: fn(&Ground, u16) -> f64,
        /// The value in words, with `{}` for it, where a cell is pointed at.
        words: &'static str,
    },
}

impl Default for Layer {
    fn default() -> Self {
        Self::ALL[0]
    }
}

impl Layer {
    /// The layers of a mission, in the order in which a key goes through them.
    #[must_use]
    pub fn of(brief: &Brief) -> Vec<Layer> {
        Self::ALL.iter().copied().filter(|layer| (layer.definition().exists)(brief)).collect()
    }

    /// The layer that is shown before anything was chosen.
    #[must_use]
    pub fn first(brief: &Brief) -> Layer {
        let layers = Self::of(brief);
        let first = layers.iter().find(|layer| (layer.definition().is_first)(brief));
        first.copied().unwrap_or_default()
    }

    /// The scale; `None` of layers that show the relief.
    #[must_use]
    pub const fn scale(self) -> Option<Scale> {
        match self.definition().look {
            Look::Scale(scale) => Some(scale),
            Look::Relief | Look::Entries => None,
        }
    }

    /// The scale as a range; `None` of layers that show the relief.
    #[must_use]
    pub fn range(self) -> Option<Range> {
        self.scale().map(|scale| Range { min: 0.0, max: scale.most })
    }

    /// Whether it shows speeds of uncertain ground.
    #[must_use]
    pub fn is_of_speeds(self) -> bool {
        self.scale().is_some_and(|scale| matches!(scale.value, Value::Speed { .. }))
    }

    /// Colour at a share of the scale, in red, green and blue.
    #[must_use]
    pub fn colour(self, share: f64) -> [u8; 3] {
        match self.scale() {
            Some(scale) => colour::ramp(scale.ramp, share),
            None => colour::height_rgb(share),
        }
    }
}

impl Scale {
    /// Whether the colours become darker along the scale.
    #[must_use]
    pub fn darkens(&self) -> bool {
        colour::luminance(self.ramp[0]) > colour::luminance(self.ramp[self.ramp.len() - 1])
    }

    /// Parts that a unit is divided into where values are rounded: a power of ten, so that the scale has 1000 steps or more.
    #[must_use]
    pub fn parts(&self) -> f64 {
        let mut parts = 1.0;
        while parts * self.most < 1000.0 {
            parts *= 10.0;
        }
        parts
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// P-LAYERS.
    #[test]
    fn every_layer_has_a_name_of_its_own_words_and_a_scale() {
        let names: BTreeSet<&str> = Layer::ALL.iter().map(|layer| layer.definition().name).collect();
        assert_eq!(names.len(), Layer::ALL.len(), "{names:?}");
        for layer in Layer::ALL {
            let Definition { name, menu, title, look, .. } = layer.definition();
            assert!(name.bytes().all(|byte| byte.is_ascii_lowercase() || byte == b'_'), "{name}");
            assert!(!menu.is_empty() && !title.is_empty(), "{name}");
            let Look::Scale(scale) = look else { continue };
            let Definition { heading, quantity, .. } = layer.definition();
            assert!(!heading.is_empty() && !quantity.is_empty(), "{name}");
            assert!(scale.most > 0.0 && scale.ramp.len() >= 2, "{name}");
            let (Value::Speed { words, .. } | Value::Ground { words, .. }) = scale.value;
            assert_eq!(words.matches("{}").count(), 1, "{name}: {words}");
        }
    }

    #[test]
    fn values_are_rounded_to_a_thousandth_of_the_scale_or_finer() {
        let speed = Layer::Speed.scale().unwrap();
        let scale = |most| Scale { most, ..speed };
        let parts = [200.0, 100.0, 99.0, 1.0, 0.5].map(|most| scale(most).parts());
        assert_eq!(parts, [10.0, 10.0, 100.0, 1000.0, 10_000.0]);
    }

    #[test]
    fn speeds_get_lighter_and_spreads_darker() {
        assert_eq!(
            [Layer::Speed, Layer::Spread].map(|layer| layer.scale().unwrap().darkens()),
            [false, true]
        );
    }
}
