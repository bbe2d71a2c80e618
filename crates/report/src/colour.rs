//! The colours of all pictures.
//!
//! Heights run from umber to cream in OkLCh with equal steps of lightness, so they stay as distinct in grey
//! and to colour-blind readers, and light enough that arrows and route stand out on every shade. Colour is
//! never the only difference: stray hops are dashed, and arrows point.

use contract::Direction;

/// Hops that landed as intended.
pub const ROUTE: &str = "#005f8f";
/// Hops that slipped or stayed.
pub const STRAY: &str = "#e3000f";
/// What a body rolled.
pub const ROLLED: &str = "#6a2fa0";
/// Where a body hit the ground; its rim is [`DARK`].
pub const IMPACT: &str = "#ffffff";
/// Translucent layer over sand.
pub const SAND: &str = "#7d8288";
/// Hatching and tint of impassable ground.
pub const BLOCKED: &str = "#22262e";
/// Hatching of unseen ground.
pub const HATCH: &str = "#aab1bd";
/// Border between seen and unseen.
pub const EDGE: &str = "#3f4650";
/// Cells of unknown height.
pub const NOTHING: &str = "#e4e7ec";

/// Colour of a robot by its number.
#[must_use]
pub fn robot(number: u16) -> String {
    hex(ROBOTS[usize::from(number) % ROBOTS.len()])
}

/// Colour of a policy arrow: four as in P23 fig. 4, chosen so that colour-blind readers can distinguish them.
#[must_use]
pub fn arrow(direction: Direction) -> &'static str {
    match direction {
        Direction::North => "#0050d8",
        Direction::South => "#7a0f6e",
        Direction::East => "#c8102e",
        Direction::West => "#111111",
    }
}

/// The start, as in P23.
pub const START: &str = "#1f6fe0";
/// The hopper, as in P23.
pub const HOPPER: &str = "#ffd400";
/// A goal, as in P23.
pub const GOAL: &str = "#e3000f";
/// Robots by their numbers, red, green and blue; every eighth has the same.
pub const ROBOTS: [[u8; 3]; 8] = [
    [0xff, 0xd4, 0x00],
    [0x1f, 0x9f, 0xe0],
    [0xff, 0x8a, 0x3d],
    [0x7f, 0xd0, 0x69],
    [0xc9, 0x8b, 0xe8],
    [0xf2, 0x6d, 0x9a],
    [0x4f, 0xd0, 0xc0],
    [0xc9, 0xb4, 0x58],
];
/// The dark rim of symbols. On any ground, this or the light one has a contrast of at least 3:1.
pub const DARK: &str = "#111111";
/// The light rim of symbols.
pub const LIGHT: &str = "#ffffff";
/// A treasure.
pub const TREASURE: &str = "#111111";
/// A treasure that was collected.
pub const COLLECTED: &str = "#ffc400";

/// Expected speeds, slowest first: even steps of lightness, so that they stay distinct in grey and to colour-blind readers.
pub const SPEEDS: [[u8; 3]; 6] =
    [[30, 18, 66], [44, 72, 125], [52, 127, 142], [110, 178, 160], [178, 218, 196], [240, 246, 236]];

/// Spreads of a speed, least first.
pub const SPREADS: [[u8; 3]; 3] = [[253, 248, 225], [242, 170, 84], [96, 30, 90]];

/// A colour between those of `colours` at `share`, 0 for the first and 1 for the last.
#[must_use]
pub fn ramp(colours: &[[u8; 3]], share: f64) -> [u8; 3] {
    let last = colours.len() - 1;
    let place = share.clamp(0.0, 1.0) * last as f64;
    let from = (place as usize).min(last - 1);
    let band = |n: usize| {
        let (low, high) = (f64::from(colours[from][n]), f64::from(colours[from + 1][n]));
        (low + (high - low) * (place - from as f64)).round() as u8
    };
    [band(0), band(1), band(2)]
}

/// "#rrggbb" of red, green and blue.
#[must_use]
pub fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Red, green and blue of "#rrggbb"; black of anything else.
#[must_use]
pub fn rgb(hex: &str) -> [u8; 3] {
    let part =
        |at: usize| hex.get(at..at + 2).and_then(|part| u8::from_str_radix(part, 16).ok()).unwrap_or(0);
    [part(1), part(3), part(5)]
}

/// Contrast of two colours, 1 to 21 (WCAG 2.2, relative luminance).
#[must_use]
pub fn contrast(one: [u8; 3], other: [u8; 3]) -> f64 {
    let (one, other) = (luminance(one), luminance(other));
    (one.max(other) + 0.05) / (one.min(other) + 0.05)
}

/// Relative luminance, 0 to 1 (WCAG 2.2).
pub(crate) fn luminance(colour: [u8; 3]) -> f64 {
    let [r, g, b] = colour.map(linear);
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// One part of an 8-bit sRGB colour, as light.
fn linear(part: u8) -> f64 {
    let value = f64::from(part) / 255.0;
    if value <= 0.040_45 { value / 12.92 } else { libm::pow((value + 0.055) / 1.055, 2.4) }
}

/// Colour of a height at `share` of the scale: 0 is the lowest, 1 the highest.
#[must_use]
pub fn height(share: f64) -> String {
    hex(height_rgb(share))
}

/// As [`height`], in red, green and blue, 0 to 255.
#[must_use]
pub fn height_rgb(share: f64) -> [u8; 3] {
    let lightness = 0.55 + 0.42 * share;
    let chroma = 0.080 + 0.025 * (1.0 - share) * share * 4.0 - 0.035 * share;
    let hue_rad = (48.0 + 47.0 * share).to_radians();
    srgb(lightness, chroma * libm::cos(hue_rad), chroma * libm::sin(hue_rad))
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
        let curved = if clipped <= 0.003_130_8 {
            12.92 * clipped
        } else {
            1.055 * libm::pow(clipped, 1.0 / 2.4) - 0.055
        };
        (255.0 * curved).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn higher_ground_is_lighter_by_equal_steps() {
        // CIE lightness follows Oklab's closely; equal within a fifth of a step.
        let star = |share: f64| 116.0 * libm::cbrt(luminance(height_rgb(share))) - 16.0;
        let steps: Vec<f64> =
            (0..10).map(|n| star(f64::from(n + 1) / 10.0) - star(f64::from(n) / 10.0)).collect();
        let mean = steps.iter().sum::<f64>() / 10.0;
        assert!(steps.iter().all(|step| (step / mean - 1.0).abs() < 0.2), "{steps:?}");
        assert!(mean > 3.5, "{mean}");
    }

    /// What the eye makes of "#rrggbb" in Oklab, colour-blind as `seen_by` says (a matrix on linear sRGB).
    fn seen(colour: &str, seen_by: &[[f64; 3]; 3]) -> [f64; 3] {
        let light = rgb(colour).map(linear);
        let [r, g, b] =
            seen_by.map(|row| row.iter().zip(light).map(|(m, c)| m * c).sum::<f64>().clamp(0.0, 1.0));
        let long = libm::cbrt(0.412_221_470_8 * r + 0.536_332_536_3 * g + 0.051_445_992_9 * b);
        let medium = libm::cbrt(0.211_903_498_2 * r + 0.680_699_545_1 * g + 0.107_396_956_6 * b);
        let short = libm::cbrt(0.088_302_461_9 * r + 0.281_718_837_6 * g + 0.629_978_700_5 * b);
        [
            0.210_454_255_3 * long + 0.793_617_785_0 * medium - 0.004_072_046_8 * short,
            1.977_998_495_1 * long - 2.428_592_205_0 * medium + 0.450_593_709_9 * short,
            0.025_904_037_1 * long + 0.782_771_766_2 * medium - 0.808_675_766_0 * short,
        ]
    }

    /// Full sight, then protanopia, deuteranopia, tritanopia (Machado, Oliveira & Fernandes 2009, table 1).
    const EYES: [[[f64; 3]; 3]; 4] = [
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        [
            [0.152_286, 1.052_583, -0.204_868],
            [0.114_503, 0.786_281, 0.099_216],
            [-0.003_882, -0.048_116, 1.051_998],
        ],
        [
            [0.367_322, 0.860_646, -0.227_968],
            [0.280_085, 0.672_501, 0.047_413],
            [-0.011_820, 0.042_940, 0.968_881],
        ],
        [
            [1.255_528, -0.076_749, -0.178_779],
            [-0.078_411, 0.930_809, 0.147_602],
            [0.004_733, 0.691_367, 0.303_900],
        ],
    ];

    #[test]
    fn a_colour_blind_eye_tells_arrows_apart_and_strays_from_the_route() {
        let arrows = Direction::ALL.map(arrow);
        let pairs = (0..4).flat_map(|a| (a + 1..4).map(move |b| (a, b)));
        let mut pairs: Vec<_> = pairs.map(|(a, b)| (arrows[a], arrows[b])).collect();
        pairs.push((ROUTE, STRAY));
        for (one, other) in pairs {
            for eye in &EYES {
                let (one_seen, other_seen) = (seen(one, eye), seen(other, eye));
                let distance =
                    one_seen.iter().zip(other_seen).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
                assert!(distance > 0.15, "{one} and {other} are {distance} apart");
            }
        }
    }

    /// P-SPEED-COLOURS: Shades of speed and spread differ by lightness alone, also for colour-blind
    /// eyes.
    #[test]
    fn speeds_and_spreads_are_told_by_lightness_alone() {
        for colours in [&SPEEDS[..], &SPREADS[..]] {
            for eye in &EYES {
                let lightness = |step: u32| {
                    let [r, g, b] = ramp(colours, f64::from(step) / 10.0);
                    seen(&format!("#{r:02x}{g:02x}{b:02x}"), eye)[0]
                };
                let steps: Vec<f64> = (0..10).map(|step| lightness(step + 1) - lightness(step)).collect();
                let rises = steps[0] > 0.0;
                assert!(steps.iter().all(|step| (*step > 0.0) == rises && step.abs() > 0.015), "{steps:?}");
            }
        }
    }

    #[test]
    fn arrows_stand_out_on_the_middle_of_the_scale() {
        for direction in Direction::ALL {
            let contrast = contrast(height_rgb(0.5), rgb(arrow(direction)));
            assert!(contrast > 2.5, "{direction} {contrast}");
        }
    }
}
