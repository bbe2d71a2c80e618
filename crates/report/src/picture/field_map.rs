//! A quantity over a map, with ways across it.

use std::fmt::Write as _;

use contract::Range;

use super::curves::LINES;
use super::scale::{Ticks, range};
use super::svg_writer::{Number, SvgWriter};
use crate::colour::BLOCKED;

const LEFT: f64 = 60.0;
/// Upper edge of the shades' bar, and of the map.
pub(super) const TOP: f64 = 78.0;
const SIDE: f64 = 560.0;
const BAR: f64 = 22.0;
const FOOT: f64 = 70.0;
/// Shades of the quantity.
const SHADES: usize = 48;

/// A named way.
#[derive(Clone, Debug, PartialEq)]
pub struct Way {
    /// Name in the legend.
    pub name: String,
    /// Its points, x and y in metres from the south-western corner of the map.
    pub points: Vec<[f64; 2]>,
}

/// A quantity, drawn as shades, with at most four ways.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldMap {
    /// Title of the document.
    pub title: String,
    /// A smaller line below the title.
    pub caption: String,
    /// What the shades mean, with its unit.
    pub quantity: String,
    /// Columns of the map.
    pub columns: usize,
    /// Side of a cell, in metres.
    pub cell_m: f64,
    /// Row by row from the south-western corner; what is no number is drawn as blocked.
    pub values: Vec<f64>,
    /// The ways.
    pub ways: Vec<Way>,
}

impl FieldMap {
    /// The SVG document; it depends only on the map, to the byte.
    #[must_use]
    pub fn svg(&self) -> String {
        let rows = self.values.len() / self.columns;
        let size = SIDE / self.columns.max(rows) as f64;
        let (width, height) = (size * self.columns as f64, size * rows as f64);
        let mut svg = SvgWriter::new(LEFT + width + 130.0, TOP + height + FOOT, &self.title);
        svg.heading(24.0, 34.0, 20.0, "font-weight=\"bold\"", &self.title);
        svg.heading(24.0, 58.0, 14.0, "fill=\"#555\"", &self.caption);
        let values = range(self.values.iter().copied().filter(|value| value.is_finite()))
            .unwrap_or(Range { min: 0.0, max: 1.0 });
        shades(&mut svg, &self.values, self.columns, values, Place { left: LEFT, top: TOP, size });
        svg.outline(LEFT, TOP, width, height);
        self.axes(&mut svg, width, height);
        bar(&mut svg, values, LEFT + width + 24.0, height, &self.quantity);
        let scale = size / self.cell_m;
        for (n, way) in self.ways.iter().enumerate() {
            let (ink, dash) = LINES[n % LINES.len()];
            let (mut path, mut pen) = (String::new(), 'M');
            for [x_m, y_m] in &way.points {
                let (x, y) = (LEFT + scale * x_m, TOP + height - scale * y_m);
                let _ = write!(path, "{pen}{} {}", Number(x), Number(y));
                pen = 'L';
            }
            svg.path(&path, "fill=\"none\" stroke=\"#fff\" stroke-width=\"5\" stroke-opacity=\"0.7\"");
            svg.path(&path, &format!("fill=\"none\" stroke=\"{ink}\" stroke-width=\"2.6\"{dash}"));
            let (at, base) = (24.0 + 165.0 * n as f64, TOP + height + 54.0);
            let sample = format!("M{} {}h30", Number(at), Number(base - 4.0));
            svg.path(&sample, &format!("fill=\"none\" stroke=\"{ink}\" stroke-width=\"2.6\"{dash}"));
            svg.text(at + 36.0, base, "", &way.name);
        }
        svg.finish()
    }

    fn axes(&self, svg: &mut SvgWriter, width: f64, height: f64) {
        let rows = self.values.len() / self.columns;
        let (across_m, up_m) = (self.columns as f64 * self.cell_m, rows as f64 * self.cell_m);
        let base = TOP + height;
        for (value, label) in Ticks::over(Range { min: 0.0, max: across_m }, 8).labels() {
            svg.text(LEFT + width * value / across_m, base + 19.0, "text-anchor=\"middle\"", &label);
        }
        for (value, label) in Ticks::over(Range { min: 0.0, max: up_m }, 8).labels() {
            svg.text(LEFT - 8.0, base - height * value / up_m + 4.5, "text-anchor=\"end\"", &label);
        }
        svg.text(LEFT + width + 12.0, base + 19.0, "", "[m]");
    }
}

/// Where cells are drawn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Left edge of the map.
    pub left: f64,
    /// Its upper edge.
    pub top: f64,
    /// Side of a cell.
    pub size: f64,
}

/// A path for each shade, of rows of equal cells; `cells` row by row from the south-western corner.
pub(super) fn shades(svg: &mut SvgWriter, cells: &[f64], columns: usize, values: Range, place: Place) {
    let Place { left, top, size } = place;
    let bottom = top + size * (cells.len() / columns) as f64;
    let shade = |value: f64| {
        let level = (values.normalise(value) * SHADES as f64) as usize;
        if value.is_finite() { level.min(SHADES - 1) } else { SHADES }
    };
    let mut paths = vec![String::new(); SHADES + 1];
    for (row, line) in cells.chunks(columns).enumerate() {
        let y = bottom - size * (row + 1) as f64;
        let mut column = 0;
        while column < line.len() {
            let level = shade(line[column]);
            let run = line[column..].iter().take_while(|value| shade(**value) == level).count();
            let (x, length) = (Number(left + size * column as f64), Number(size * run as f64));
            let _ = write!(paths[level], "M{x} {}h{length}v{}h-{length}z", Number(y), Number(size));
            column += run;
        }
    }
    for (level, path) in paths.iter().enumerate() {
        let ink = if level == SHADES { BLOCKED.to_owned() } else { ink(level) };
        // A stroke of the same colour closes the seams between rows.
        svg.path(path, &format!("fill=\"{ink}\" stroke=\"{ink}\" stroke-width=\"0.3\""));
    }
}

/// The shades with their values.
pub(super) fn bar(svg: &mut SvgWriter, values: Range, left: f64, height: f64, quantity: &str) {
    let step = height / SHADES as f64;
    for level in 0..SHADES {
        let y = TOP + height - step * (level + 1) as f64;
        svg.raw(&format!(
            "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{}\"/>",
            Number(left),
            Number(y),
            Number(BAR),
            Number(step + 0.4),
            ink(level)
        ));
    }
    for (value, label) in Ticks::over(values, 7).labels() {
        svg.text(left + BAR + 6.0, TOP + height * (1.0 - values.normalise(value)) + 4.5, "", &label);
    }
    svg.text_upwards(left + BAR + 66.0, TOP + height / 2.0, quantity);
}

/// From pale to dark, so that shades differ in grey too.
fn ink(level: usize) -> String {
    const ENDS: [[f64; 3]; 3] = [[253.0, 248.0, 225.0], [242.0, 170.0, 84.0], [96.0, 30.0, 90.0]];
    let at = 2.0 * level as f64 / (SHADES - 1) as f64;
    let from = (at as usize).min(1);
    let channel = |n: usize| ENDS[from][n] + (at - from as f64) * (ENDS[from + 1][n] - ENDS[from][n]);
    format!("#{:02x}{:02x}{:02x}", channel(0) as u8, channel(1) as u8, channel(2) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_cells_of_a_row_are_one_rectangle_and_what_is_no_number_is_blocked() {
        let map = FieldMap {
            title: "t".into(),
            caption: "c".into(),
            quantity: "q".into(),
            columns: 3,
            cell_m: 1.0,
            values: vec![0.0, 0.0, 1.0, 1.0, f64::NAN, 1.0],
            ways: vec![Way { name: "w".into(), points: vec![[0.5, 0.5], [2.5, 1.5]] }],
        };
        let svg = map.svg();
        // Two shades in the south, three runs in the north.
        let cells = svg.lines().filter(|line| line.contains("stroke-width=\"0.3\""));
        assert_eq!(cells.map(|line| line.matches('z').count()).sum::<usize>(), 5);
        assert_eq!(svg.matches(BLOCKED).count(), 2);
    }
}
