//! Box plots beside each other.

use std::fmt::Write as _;

use contract::Range;

use super::scale::{Ticks, range};
use super::svg_writer::{Number, SvgWriter};

const LEFT: f64 = 92.0;
const TOP: f64 = 78.0;
const HEIGHT: f64 = 360.0;
const COLUMN: f64 = 128.0;
const BOX: f64 = 52.0;
const FOOT: f64 = 84.0;

/// One box with its whiskers.
#[derive(Clone, Debug, PartialEq)]
pub struct BoxOf {
    /// What stands below it; a line each.
    pub name: Vec<String>,
    /// The values, in any order.
    pub values: Vec<f64>,
}

/// Boxes from the first to the third quartile with a line at the median. Whiskers reach to the farthest value within 1.5 times
/// the box's height; values beyond are points.
#[derive(Clone, Debug, PartialEq)]
pub struct Boxes {
    /// Title of the document.
    pub title: String,
    /// A smaller line below the title.
    pub caption: String,
    /// Label of the y axis, with its unit.
    pub quantity: String,
    /// The boxes, left to right.
    pub boxes: Vec<BoxOf>,
}

impl Boxes {
    /// The SVG document; it depends only on the values, to the byte.
    #[must_use]
    pub fn svg(&self) -> String {
        let width = COLUMN * self.boxes.len() as f64;
        let mut svg = SvgWriter::new(LEFT + width + 24.0, TOP + HEIGHT + FOOT, &self.title);
        svg.heading(24.0, 34.0, 20.0, "font-weight=\"bold\"", &self.title);
        svg.heading(24.0, 58.0, 14.0, "fill=\"#555\"", &self.caption);
        let values = range(self.boxes.iter().flat_map(|of| of.values.iter().copied()))
            .unwrap_or(Range { min: 0.0, max: 1.0 });
        let y = |value: f64| TOP + HEIGHT - 10.0 - (HEIGHT - 20.0) * values.normalise(value);
        svg.outline(LEFT, TOP, width, HEIGHT);
        let mut grid = String::new();
        for (value, label) in Ticks::over(values, 8).labels() {
            let _ = write!(grid, "M{} {}h{}", Number(LEFT), Number(y(value)), Number(width));
            svg.text(LEFT - 9.0, y(value) + 4.5, "text-anchor=\"end\"", &label);
        }
        svg.path(&grid, "stroke=\"#ddd\"");
        svg.text_upwards(26.0, TOP + HEIGHT / 2.0, &self.quantity);
        for (n, of) in self.boxes.iter().enumerate() {
            let middle = LEFT + COLUMN * (n as f64 + 0.5);
            of.draw(&mut svg, middle, &y);
            for (line, words) in of.name.iter().enumerate() {
                let base = TOP + HEIGHT + 20.0 + 17.0 * line as f64;
                svg.text(middle, base, "text-anchor=\"middle\"", words);
            }
        }
        svg.finish()
    }
}

impl BoxOf {
    /// First quartile, median and third, interpolated between values.
    fn quartiles(sorted: &[f64]) -> [f64; 3] {
        [0.25, 0.5, 0.75].map(|share| {
            let at = share * (sorted.len() - 1) as f64;
            let (low, high) = (sorted[at.floor() as usize], sorted[at.ceil() as usize]);
            low + (at - at.floor()) * (high - low)
        })
    }

    fn draw(&self, svg: &mut SvgWriter, middle: f64, y: &dyn Fn(f64) -> f64) {
        let mut sorted = self.values.clone();
        sorted.sort_by(f64::total_cmp);
        if sorted.is_empty() {
            return;
        }
        let [first, median, third] = Self::quartiles(&sorted);
        let reach = 1.5 * (third - first);
        let within = |value: &&f64| (first - reach..=third + reach).contains(*value);
        let (low, high) = (
            sorted.iter().find(within).copied().unwrap_or(first).min(first),
            sorted.iter().rev().find(within).copied().unwrap_or(third).max(third),
        );
        let left = Number(middle - BOX / 2.0);
        svg.raw(&format!(
            "<rect x=\"{left}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"#cfe0f5\" stroke=\"#0050d8\" stroke-width=\"1.6\"/>",
            Number(y(third)),
            Number(BOX),
            Number(y(first) - y(third))
        ));
        let (centre, cap) = (Number(middle), Number(middle - BOX / 4.0));
        let mut whiskers = String::new();
        for (from, to) in [(third, high), (first, low)] {
            let (from, to) = (Number(y(from)), Number(y(to)));
            let _ = write!(whiskers, "M{centre} {from}V{to}M{cap} {to}h{}", Number(BOX / 2.0));
        }
        svg.path(&whiskers, "fill=\"none\" stroke=\"#333\" stroke-width=\"1.4\"");
        let line = format!("M{left} {}h{}", Number(y(median)), Number(BOX));
        svg.path(&line, "fill=\"none\" stroke=\"#c8102e\" stroke-width=\"2.6\"");
        let mut points = String::new();
        for value in sorted.iter().filter(|value| !within(value)) {
            let _ = write!(points, "M{centre} {}m-3 0h6m-3 -3v6", Number(y(*value)));
        }
        svg.path(&points, "fill=\"none\" stroke=\"#c8102e\"");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quartiles_are_interpolated() {
        assert_eq!(BoxOf::quartiles(&[1.0, 2.0, 3.0, 4.0]), [1.75, 2.5, 3.25]);
        assert_eq!(BoxOf::quartiles(&[7.0]), [7.0; 3]);
    }

    #[test]
    fn a_value_far_away_is_a_point_and_an_empty_box_is_nothing() {
        let of = |values: &[f64]| BoxOf { name: vec!["a".into()], values: values.to_vec() };
        let boxes = |values| Boxes {
            title: "t".into(),
            caption: "c".into(),
            quantity: "q".into(),
            boxes: vec![of(values), of(&[])],
        };
        let crosses = |values| boxes(values).svg().matches("m-3 0h6m-3 -3v6").count();
        assert_eq!(crosses(&[1.0, 1.1, 1.2, 1.3, 9.0]), 1);
        assert_eq!(crosses(&[1.0, 1.1, 1.2, 1.3]), 0);
    }
}
