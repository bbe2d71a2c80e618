//! Lines over a common axis, one chart above the other.

use std::fmt::Write as _;

use contract::Range;

use super::scale::Ticks;
use super::sheet::{Number, Sheet};

const LEFT: f64 = 92.0;
const TOP: f64 = 78.0;
const WIDTH: f64 = 620.0;
const HEIGHT: f64 = 230.0;
const GAP: f64 = 34.0;
const FOOT: f64 = 96.0;
/// Told apart by colour, dash, and mark.
const LINES: [(&str, &str); 4] = [
    ("#0050d8", ""),
    ("#c8102e", " stroke-dasharray=\"9 4\""),
    ("#111111", " stroke-dasharray=\"2 5\""),
    ("#7a0f6e", " stroke-dasharray=\"12 4 2 4\""),
];

/// One line: its name, and y at each x of the chart, `None` where there is none.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// What the legend says.
    pub name: String,
    /// The values.
    pub values: Vec<Option<f64>>,
}

/// One chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// What y is, with its unit.
    pub quantity: String,
    /// Up to four lines.
    pub lines: Vec<Line>,
}

/// Charts over one axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Curves {
    /// The title.
    pub title: String,
    /// What is written under it.
    pub caption: String,
    /// What x is.
    pub axis: String,
    /// Every x, ascending.
    pub at: Vec<f64>,
    /// The charts, top to bottom, with lines of the same names.
    pub charts: Vec<Chart>,
}

impl Curves {
    /// The picture as an SVG document; it depends on nothing but the curves, to the byte.
    #[must_use]
    pub fn svg(&self) -> String {
        let bottom = TOP + self.charts.len() as f64 * (HEIGHT + GAP);
        let mut sheet = Sheet::new(LEFT + WIDTH + 40.0, bottom + FOOT - GAP, &self.title);
        sheet.heading(24.0, 34.0, 20.0, "font-weight=\"bold\"", &self.title);
        sheet.heading(24.0, 58.0, 14.0, "fill=\"#555\"", &self.caption);
        let across = extent(self.at.iter().copied());
        let x = |value: f64| LEFT + WIDTH * across.normalise(value);
        for (n, chart) in self.charts.iter().enumerate() {
            self.chart(&mut sheet, chart, TOP + n as f64 * (HEIGHT + GAP), &x);
        }
        let base = bottom - GAP;
        for (value, label) in Ticks::over(across, 11).labels() {
            sheet.text(x(value), base + 20.0, "text-anchor=\"middle\"", &label);
        }
        sheet.text(LEFT + WIDTH / 2.0, base + 42.0, "text-anchor=\"middle\" font-size=\"14\"", &self.axis);
        let names = self.charts.first().map(|chart| chart.lines.as_slice()).unwrap_or_default();
        for (n, line) in names.iter().enumerate() {
            let at = LEFT + 200.0 * n as f64;
            let (ink, dash) = LINES[n % LINES.len()];
            sheet.path(
                &format!("M{} {}h34", Number(at), Number(base + 72.0)),
                &format!("fill=\"none\" stroke=\"{ink}\" stroke-width=\"2.6\"{dash}"),
            );
            sheet.text(at + 42.0, base + 76.0, "", &line.name);
        }
        sheet.finish()
    }

    fn chart(&self, sheet: &mut Sheet, chart: &Chart, top: f64, x: &dyn Fn(f64) -> f64) {
        let range = extent(chart.lines.iter().flat_map(|line| line.values.iter().flatten().copied()));
        let y = |value: f64| top + HEIGHT - 8.0 - (HEIGHT - 16.0) * range.normalise(value);
        sheet.raw(&format!(
            "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#333\"/>",
            Number(LEFT),
            Number(top),
            Number(WIDTH),
            Number(HEIGHT)
        ));
        let mut grid = String::new();
        for (value, label) in Ticks::over(range, 6).labels() {
            let _ = write!(grid, "M{} {}h{}", Number(LEFT), Number(y(value)), Number(WIDTH));
            sheet.text(LEFT - 9.0, y(value) + 4.5, "text-anchor=\"end\"", &label);
        }
        sheet.path(&grid, "stroke=\"#ddd\"");
        sheet.text_upwards(26.0, top + HEIGHT / 2.0, &chart.quantity);
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
            sheet.path(&path, &format!("fill=\"none\" stroke=\"{ink}\" stroke-width=\"2.6\"{dash}"));
            sheet.path(&dots, &format!("fill=\"{ink}\""));
        }
    }
}

fn extent(values: impl Iterator<Item = f64>) -> Range {
    let range = values.fold(Range { min: f64::INFINITY, max: f64::NEG_INFINITY }, |range, value| Range {
        min: range.min.min(value),
        max: range.max.max(value),
    });
    if range.min > range.max { Range { min: 0.0, max: 1.0 } } else { range }
}
