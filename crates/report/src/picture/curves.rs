//! Line charts over a common x axis, one above the other.

use std::fmt::Write as _;

use contract::Range;

use super::scale::{Ticks, range};
use super::svg_writer::{Number, SvgWriter};

const LEFT: f64 = 92.0;
const TOP: f64 = 78.0;
const WIDTH: f64 = 620.0;
const HEIGHT: f64 = 230.0;
const GAP: f64 = 34.0;
const FOOT: f64 = 96.0;
/// Colour and dash pattern of each line.
pub(super) const LINES: [(&str, &str); 4] = [
    ("#0050d8", ""),
    ("#c8102e", " stroke-dasharray=\"9 4\""),
    ("#111111", " stroke-dasharray=\"2 5\""),
    ("#7a0f6e", " stroke-dasharray=\"12 4 2 4\""),
];

/// One line of a chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Name in the legend.
    pub name: String,
    /// y at each x of [`Curves::at`]; `None` leaves a gap.
    pub values: Vec<Option<f64>>,
}

/// One chart of a stack.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Label of the y axis, with its unit.
    pub quantity: String,
    /// The lines; at most four look different.
    pub lines: Vec<Line>,
}

/// Charts above each other over one x axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Curves {
    /// Title of the document.
    pub title: String,
    /// A smaller line below the title.
    pub caption: String,
    /// Label of the x axis, with its unit.
    pub axis: String,
    /// The x values, ascending.
    pub at: Vec<f64>,
    /// The charts, top to bottom, with lines of the same names.
    pub charts: Vec<Chart>,
}

impl Curves {
    /// The SVG document; it depends only on the curves, to the byte.
    #[must_use]
    pub fn svg(&self) -> String {
        let bottom = TOP + self.charts.len() as f64 * (HEIGHT + GAP);
        let mut svg = SvgWriter::new(LEFT + WIDTH + 40.0, bottom + FOOT - GAP, &self.title);
        svg.heading(24.0, 34.0, 20.0, "font-weight=\"bold\"", &self.title);
        svg.heading(24.0, 58.0, 14.0, "fill=\"#555\"", &self.caption);
        let across = extent(self.at.iter().copied());
        let x = |value: f64| LEFT + WIDTH * across.normalise(value);
        for (n, chart) in self.charts.iter().enumerate() {
            self.chart(&mut svg, chart, TOP + n as f64 * (HEIGHT + GAP), &x);
        }
        let base = bottom - GAP;
        for (value, label) in Ticks::over(across, 11).labels() {
            svg.text(x(value), base + 20.0, "text-anchor=\"middle\"", &label);
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

    fn chart(&self, svg: &mut SvgWriter, chart: &Chart, top: f64, x: &dyn Fn(f64) -> f64) {
        let values = extent(chart.lines.iter().flat_map(|line| line.values.iter().flatten().copied()));
        let y = |value: f64| top + HEIGHT - 8.0 - (HEIGHT - 16.0) * values.normalise(value);
        svg.outline(LEFT, top, WIDTH, HEIGHT);
        let mut grid = String::new();
        for (value, label) in Ticks::over(values, 6).labels() {
            let _ = write!(grid, "M{} {}h{}", Number(LEFT), Number(y(value)), Number(WIDTH));
            svg.text(LEFT - 9.0, y(value) + 4.5, "text-anchor=\"end\"", &label);
        }
        svg.path(&grid, "stroke=\"#ddd\"");
        svg.text_upwards(26.0, top + HEIGHT / 2.0, &chart.quantity);
        for (n, line) in chart.lines.iter().enumerate() {
            let (ink, dash) = LINES[n % LINES.len()];
            let (mut path, mut pen, mut dots) = (String::new(), 'M', String::new());
            for (&at, value) in self.at.iter().zip(&line.values) {
                let Some(value) = *value else {
                    pen = 'M';
                    continue;
                };
                let _ = write!(path, "{pen}{} {}", Number(x(at)), Number(y(value)));
                let _ = write!(
                    dots,
                    "M{} {}m-3 0a3 3 0 1 0 6 0a3 3 0 1 0 -6 0z",
                    Number(x(at)),
                    Number(y(value))
                );
                pen = 'L';
            }
            svg.path(&path, &format!("fill=\"none\" stroke=\"{ink}\" stroke-width=\"2.6\"{dash}"));
            svg.path(&dots, &format!("fill=\"{ink}\""));
        }
    }
}

/// Range of `values`; 0 to 1 without values.
fn extent(values: impl Iterator<Item = f64>) -> Range {
    range(values).unwrap_or(Range { min: 0.0, max: 1.0 })
}
