//! What the shades of the ground mean.

use contract::Range;

use super::colour;

/// What the ground of a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Layer {
    /// Heights, sand and impassable ground.
    #[default]
    Heights,
    /// Expected speed of a driving rover, under what was observed.
    Speed,
    /// Standard deviation of that speed.
    Spread,
}

impl Layer {
    /// The scale, if it is the same in all pictures: m/Sol.
    pub(super) fn range(self) -> Option<Range> {
        match self {
            Layer::Heights => None,
            Layer::Speed => Some(Range { min: 0.0, max: 200.0 }),
            Layer::Spread => Some(Range { min: 0.0, max: 100.0 }),
        }
    }

    /// Beside the scale.
    pub(super) fn quantity(self) -> &'static str {
        match self {
            Layer::Heights => "height above datum (m)",
            Layer::Speed => "expected speed (m/Sol)",
            Layer::Spread => "standard deviation of speed (m/Sol)",
        }
    }

    /// Over the plot.
    pub(super) fn heading(self) -> &'static str {
        match self {
            Layer::Heights => "",
            Layer::Speed => "Expected speed at the end",
            Layer::Spread => "Spread of the speed at the end",
        }
    }

    /// Colour at `share` of the scale.
    pub(super) fn colour(self, share: f64) -> String {
        let [r, g, b] = match self {
            Layer::Heights => colour::height_rgb(share),
            Layer::Speed => colour::ramp(&colour::SPEEDS, share),
            Layer::Spread => colour::ramp(&colour::SPREADS, share),
        };
        format!("#{r:02x}{g:02x}{b:02x}")
    }
}
