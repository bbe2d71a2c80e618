//! Frame, axes and colour bar of a plot.

use std::fmt::Write as _;

use contract::{Cell, Grid, Range};

use super::scale::Ticks;
use super::style::PictureStyle;
use super::svg_writer::{Number, SvgWriter};
use crate::Layer;
use crate::colour;

pub const MARGIN_RIGHT: f64 = 118.0;
/// What the larger letters of a picture for a paper need beyond [`MARGIN_RIGHT`].
pub const PAPER_ROOM: f64 = 16.0;
/// Number of shades of the height scale.
pub const SHADES: usize = 40;
/// Shortest side of the frame, so that even a strip of cells leaves room for its colour bar.
const FRAME_MIN: f64 = 200.0;

/// Position and scale of a plot in the document.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    pub left: f64,
    pub top: f64,
    pub width: f64,
    pub height: f64,
    /// Side of a cell, in the picture's units.
    pub pitch: f64,
    /// Number of the plot in its document, from 0.
    pub place: usize,
    /// Number of an earlier plot with the same terrain, whose drawing is reused.
    pub ground: Option<usize>,
    /// What the plot is drawn for.
    pub style: PictureStyle,
}

impl Frame {
    /// A frame for `grid` at the origin, its longer side `side` units.
    pub fn of(grid: &Grid, side: f64) -> Self {
        let (columns, rows) = (f64::from(grid.width), f64::from(grid.height));
        let pitch = side / columns.max(rows);
        let (width, height) = ((columns * pitch).max(FRAME_MIN), (rows * pitch).max(FRAME_MIN));
        Self {
            left: 0.0,
            top: 0.0,
            width,
            height,
            pitch,
            place: 0,
            ground: None,
            style: PictureStyle::Screen,
        }
    }

    /// An element id that is unique in the document.
    pub fn id(&self, name: &str) -> String {
        format!("{name}-{}", self.place)
    }

    /// Centre of `cell`; a cell outside of the grid is drawn just beyond the edge.
    pub fn centre(&self, cell: Cell) -> (f64, f64) {
        let beyond = 9.0;
        let x = self.left + (f64::from(cell.x) + 0.5) * self.pitch;
        let y = self.top + self.height - (f64::from(cell.y) + 0.5) * self.pitch;
        (
            x.clamp(self.left - beyond, self.left + self.width + beyond),
            y.clamp(self.top - beyond, self.top + self.height + beyond),
        )
    }
}

/// Which sides of a plot have labelled ticks.
#[derive(Clone, Copy, Debug)]
pub struct Numbered {
    pub left: bool,
    pub below: bool,
}

pub fn axes(svg: &mut SvgWriter, frame: &Frame, grid: &Grid, numbered: Numbered) {
    let Frame { left, top, width, height, pitch, .. } = *frame;
    let bottom = top + height;
    svg.outline(left, top, width, height);
    let reach = |cells: u32| Range { min: 0.0, max: f64::from(cells - 1) * grid.cell_size_m };
    let mut strokes = String::new();
    let room = |cells: u32| ((f64::from(cells) * pitch / 40.0) as usize).clamp(2, 10);
    let east = Ticks::over(reach(grid.width), room(grid.width));
    for (at_m, label) in east.labels() {
        let x = left + (at_m / grid.cell_size_m + 0.5) * pitch;
        let _ = write!(strokes, "M{} {}v6", Number(x), Number(bottom));
        if numbered.below {
            svg.text(x, bottom + 21.0, "text-anchor=\"middle\"", &label);
        }
    }
    let north = Ticks::over(reach(grid.height), room(grid.height));
    for (at_m, label) in north.labels() {
        let y = bottom - (at_m / grid.cell_size_m + 0.5) * pitch;
        let _ = write!(strokes, "M{} {}h-6", Number(left), Number(y));
        if numbered.left {
            svg.text(left - 10.0, y + 4.5, "text-anchor=\"end\"", &label);
        }
    }
    svg.path(&strokes, "stroke=\"#333\"");
    if numbered.below {
        svg.text(left + width / 2.0, bottom + 42.0, "text-anchor=\"middle\" font-size=\"14\"", "x, east (m)");
    }
    if numbered.left {
        svg.text_upwards(left - 52.0, top + height / 2.0, "y, north (m)");
    }
}

pub fn colour_bar(svg: &mut SvgWriter, frame: &Frame, layer: Layer, range: Range) {
    let (left, top, width, height) = (frame.left + frame.width + 24.0, frame.top, 18.0, frame.height);
    for shade in 0..SHADES {
        let step = height / SHADES as f64;
        let y = top + height - step * (shade + 1) as f64;
        let colour = colour::hex(layer.colour((shade as f64 + 0.5) / SHADES as f64));
        // Half a unit of overlap hides the seams of antialiasing.
        let overlap = if shade == 0 { 0.0 } else { 0.5 };
        svg.raw(&format!(
            "<rect x=\"{}\" y=\"{}\" width=\"{width}\" height=\"{}\" fill=\"{colour}\"/>",
            Number(left),
            Number(y),
            Number(step + overlap)
        ));
    }
    svg.outline(left, top, width, height);
    let mut strokes = String::new();
    for (value, label) in Ticks::over(range, 8).labels() {
        let y = top + height * (1.0 - range.normalise(value));
        let _ = write!(strokes, "M{} {}h5", Number(left + width), Number(y));
        svg.text(left + width + 9.0, y + 4.5, "", &label);
    }
    svg.path(&strokes, "stroke=\"#333\"");
    // The larger letters of a paper's picture need more room.
    let room = if frame.style == PictureStyle::Paper { MARGIN_RIGHT + PAPER_ROOM } else { MARGIN_RIGHT };
    svg.text_upwards(frame.left + frame.width + room - 12.0, top + height / 2.0, layer.definition().quantity);
}
