//! The colours, each named once.
//!
//! Heights run from umber to cream in OkLCh with equal steps of lightness: as far apart in grey or to
//! a colour-blind eye as in full colour, and light enough that arrows and route stand out on every
//! shade. What is told apart by colour is told apart by form, too: strays are dashed, arrows point.

use contract::Direction;

/// Route as intended.
pub const ROUTE: &str = "#00873e";
/// Stray hops.
pub const STRAY: &str = "#e3000f";
/// Veil over sand.
pub const SAND: &str = "#7d8288";
/// Impassable ground.
pub const BLOCKED: &str = "#22262e";
/// Hatching of unseen ground.
pub const HATCH: &str = "#aab1bd";
/// Border between seen and unseen.
pub const EDGE: &str = "#3f4650";
/// Ground of which nothing at all is known.
pub const NOTHING: &str = "#e4e7ec";

/// Colour of a policy arrow, as in P23 fig. 4.
pub fn arrow(direction: Direction) -> &'static str {
    match direction {
        Direction::North => "#0a3fd0",
        Direction::South => "#8013a8",
        Direction::East => "#c8102e",
        Direction::West => "#111111",
    }
}

/// Colour of a height at `share` of the scale, 0 the lowest to 1 the highest.
pub fn height(share: f64) -> String {
    let lightness = 0.55 + 0.42 * share;
    let chroma = 0.080 + 0.025 * (1.0 - share) * share * 4.0 - 0.035 * share;
    let hue_rad = (48.0 + 47.0 * share).to_radians();
    let [r, g, b] = srgb(lightness, chroma * hue_rad.cos(), chroma * hue_rad.sin());
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// From Oklab (Ottosson 2020) to 8-bit sRGB.
fn srgb(lightness: f64, a: f64, b: f64) -> [u8; 3] {
    let long = (lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
    let medium = (lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
    let short = (lightness - 0.089_484_177_5 * a - 1.291_485_548_0 * b).powi(3);
    [
        4.076_741_662_1 * long - 3.307_711_591_3 * medium + 0.230_969_929_2 * short,
        -1.268_438_004_6 * long + 2.609_757_401_1 * medium - 0.341_319_396_5 * short,
        -0.004_196_086_3 * long - 0.703_418_614_7 * medium + 1.707_614_701_0 * short,
    ]
    .map(|linear| {
        let clipped = linear.clamp(0.0, 1.0);
        let curved =
            if clipped <= 0.003_130_8 { 12.92 * clipped } else { 1.055 * clipped.powf(1.0 / 2.4) - 0.055 };
        (255.0 * curved).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative luminance (WCAG 2) of "#rrggbb".
    fn luminance(colour: &str) -> f64 {
        let linear = |at: usize| {
            let value = f64::from(u8::from_str_radix(&colour[at..at + 2], 16).unwrap()) / 255.0;
            if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * linear(1) + 0.7152 * linear(3) + 0.0722 * linear(5)
    }

    #[test]
    fn higher_ground_is_lighter_by_equal_steps() {
        // CIE lightness follows Oklab's closely; equal within a fifth of a step.
        let star = |share: f64| 116.0 * luminance(&height(share)).cbrt() - 16.0;
        let steps: Vec<f64> =
            (0..10).map(|n| star(f64::from(n + 1) / 10.0) - star(f64::from(n) / 10.0)).collect();
        let mean = steps.iter().sum::<f64>() / 10.0;
        assert!(steps.iter().all(|step| (step / mean - 1.0).abs() < 0.2), "{steps:?}");
        assert!(mean > 3.5, "{mean}");
    }

    #[test]
    fn arrows_stand_out_on_the_middle_of_the_scale() {
        for direction in Direction::ALL {
            let contrast = (luminance(&height(0.5)) + 0.05) / (luminance(arrow(direction)) + 0.05);
            assert!(contrast > 2.5, "{direction} {contrast}");
        }
    }
}
