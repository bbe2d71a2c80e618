//! Line charts over logarithmic axes, each line with points of its own.

use std::fmt::Write as _;

use contract::Range;

use super::curves::LINES;
use super::scale::range;
use super::svg_writer::{Number, SvgWriter};

const LEFT: f64 = 92.0;
const TOP: f64 = 78.0;
const WIDTH: f64 = 620.0;
const HEIGHT: f64 = 260.0;
const GAP: f64 = 34.0;
const FOOT: f64 = 96.0;
/// Colour of the marks.
const MARK: &str = "#0a7a3d";

/// One line of a chart.
#[derive(Clone, Debug, PartialEq)]
pub struct PointLine {
    /// Name in the legend.
    pub name: String,
    /// x and y of its points, both above 0; x ascending.
    pub points: Vec<[f64; 2]>,
}

/// One chart of a stack.
#[derive(Clone, Debug, PartialEq)]
pub struct LogChart {
    /// Label of the y axis, with its unit.
    pub quantity: String,
    /// The lines; at most four look different.
    pub lines: Vec<PointLine>,
    /// A vertical line: its name and its x.
    pub mark: Option<(String, f64)>,
}

/// Charts above each other over one x axis, all axes logarithmic.
#[derive(Clone, Debug, PartialEq)]
pub struct LogCurves {
    /// Title of the document.
    pub title: String,
    /// A smaller line below the title.
    pub caption: String,
    /// Label of the x axis, with its unit.
    pub axis: String,
    /// The charts, top to bottom, with lines of the same names.
    pub charts: Vec<LogChart>,
}

impl LogCurves {
    /// The SVG document; it depends only on the curves, to the byte.
    #[must_use]
    pub fn svg(&self) -> String {
        let bottom = TOP + self.charts.len() as f64 * (HEIGHT + GAP);
        let mut svg = SvgWriter::new(LEFT + WIDTH + 40.0, bottom + FOOT - GAP, &self.title);
        svg.heading(24.0, 34.0, 20.0, "font-weight=\"bold\"", &self.title);
        svg.heading(24.0, 58.0, 14.0, "fill=\"#555\"", &self.caption);
        let points = self.charts.iter().flat_map(|chart| &chart.lines).flat_map(|line| &line.points);
        let marks = self.charts.iter().filter_map(|chart| chart.mark.as_ref()).map(|(_, x)| *x);
        let across = decades(points.map(|[x, _]| *x).chain(marks));
        let x = |value: f64| LEFT + WIDTH * across.normalise(libm::log10(value));
        for (n, chart) in self.charts.iter().enumerate() {
            chart.draw(&mut svg, TOP + n as f64 * (HEIGHT + GAP), &x);
        }
        let base = bottom - GAP;
        for (exponent, label) in powers(across) {
            let at = LEFT + WIDTH * across.normalise(exponent);
            svg.text(at, base + 20.0, "text-anchor=\"middle\"", &label);
        }
        svg.text(LEFT + WIDTH / 2.0, base + 42.0, "text-anchor=\"middle\" font-size=\"14\"", &self.axis);
        let names = self.charts.first().map(|chart| chart.lines.as_slice()).unwrap_or_default();
        for (n, line) in names.iter().enumerate() {
            let at = LEFT + 200.0 * n as f64;
            let (ink, dash) = LINES[n % LINES.len()];
            svg.path(
                &format!("M{} {}h34", Number(at), Number(base + 72.0)),
                &format!("fill=\"none\" stroke=\"{ink}\" stroke-width=\"2.6\"{dash}"),
            );
            svg.text(at + 42.0, base + 76.0, "", &line.name);
        }
        svg.finish()
    }
}

impl LogChart {
    fn draw(&self, svg: &mut SvgWriter, top: f64, x: &dyn Fn(f64) -> f64) {
        let values = decades(self.lines.iter().flat_map(|line| &line.points).map(|[_, y]| *y));
        let place = |exponent: f64| top + HEIGHT - HEIGHT * values.normalise(exponent);
        let y = |value: f64| place(libm::log10(value));
        svg.outline(LEFT, top, WIDTH, HEIGHT);
        let mut grid = String::new();
        for (exponent, label) in powers(values) {
            let _ = write!(grid, "M{} {}h{}", Number(LEFT), Number(place(exponent)), Number(WIDTH));
            svg.text(LEFT - 9.0, place(exponent) + 4.5, "text-anchor=\"end\"", &label);
        }
        svg.path(&grid, "stroke=\"#ddd\"");
        svg.text_upwards(26.0, top + HEIGHT / 2.0, &self.quantity);
        if let Some((name, at)) = &self.mark {
            let line = format!("M{} {}v{}", Number(x(*at)), Number(top), Number(HEIGHT));
            svg.path(&line, &format!("fill=\"none\" stroke=\"{MARK}\" stroke-width=\"2\""));
            svg.text(x(*at) + 6.0, top + 18.0, &format!("fill=\"{MARK}\""), name);
        }
        for (n, line) in self.lines.iter().enumerate() {
            let (ink, dash) = LINES[n % LINES.len()];
            let (mut path, mut pen, mut dots) = (String::new(), 'M', String::new());
            for [at, value] in &line.points {
                let (at, value) = (Number(x(*at)), Number(y(*value)));
                let _ = write!(path, "{pen}{at} {value}");
                let _ = write!(dots, "M{at} {value}m-3 0a3 3 0 1 0 6 0a3 3 0 1 0 -6 0z");
                pen = 'L';
            }
            svg.path(&path, &format!("fill=\"none\" stroke=\"{ink}\" stroke-width=\"2.6\"{dash}"));
            svg.path(&dots, &format!("fill=\"{ink}\""));
        }
    }
}

/// The powers of ten around `values`, as exponents; 1 to 10 without values.
fn decades(values: impl Iterator<Item = f64>) -> Range {
    let range = range(values.map(libm::log10)).unwrap_or(Range { min: 0.0, max: 1.0 });
    let (min, max) = (range.min.floor(), range.max.ceil());
    Range { min, max: if max > min { max } else { min + 1.0 } }
}

/// Each power of ten with its label.
fn powers(range: Range) -> impl Iterator<Item = (f64, String)> {
    (range.min as i32..=range.max as i32).map(|exponent| {
        let decimals = usize::try_from(-exponent).unwrap_or(0);
        (f64::from(exponent), format!("{:.decimals$}", 10_f64.powi(exponent)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_reach_from_power_to_power_of_ten() {
        let labels = |values: &[f64]| -> Vec<String> {
            powers(decades(values.iter().copied())).map(|(_, label)| label).collect()
        };
        assert_eq!(labels(&[0.2, 30.0]), ["0.1", "1", "10", "100"]);
        assert_eq!(labels(&[10.0]), ["10", "100"]);
    }

    #[test]
    fn a_line_has_a_dot_for_each_of_its_points_and_the_mark_its_name() {
        let chart = LogChart {
            quantity: "q".into(),
            lines: vec![PointLine { name: "a".into(), points: vec![[1.0, 1.0], [10.0, 0.1], [30.0, 0.01]] }],
            mark: Some(("m".into(), 3.0)),
        };
        let title = String::from("t");
        let svg = LogCurves { title, caption: "c".into(), axis: "x".into(), charts: vec![chart] }.svg();
        assert_eq!(svg.matches("a3 3 0 1 0 6 0").count(), 3);
        assert!(svg.contains(">m</text>"));
    }
}
