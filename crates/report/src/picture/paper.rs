//! A picture for a paper: one column wide, without title and legend, which are the caption's.

use super::frame::{Frame, MARGIN_RIGHT, Numbered, PAPER_ROOM, axes, colour_bar};
use super::mission::Picture;
use super::style::PictureStyle;
use super::svg_writer::SvgWriter;
use crate::ReportError;

/// Width of a column of a two-column page, millimetres.
pub const COLUMN_MM: f64 = 85.0;

/// Width of the document in the picture's units; on paper 642 of them are [`COLUMN_MM`].
const WIDTH: f64 = 642.0;
const MARGIN_LEFT: f64 = 74.0;
const MARGIN_TOP: f64 = 12.0;
const AXIS_HEIGHT: f64 = 52.0;

impl Picture<'_> {
    /// The picture in a style as an SVG document.
    ///
    /// # Errors
    /// [`ReportError::Cells`] if terrain, map or policy do not cover the grid.
    pub fn svg_in(&self, style: PictureStyle) -> Result<String, ReportError> {
        match style {
            PictureStyle::Screen => self.svg(),
            PictureStyle::Paper => self.paper_svg(),
        }
    }

    fn paper_svg(&self) -> Result<String, ReportError> {
        self.check()?;
        let layer = self.layers()[0];
        let tiles = self.tiles(layer);
        let heights = tiles.heights();
        let side = WIDTH - MARGIN_LEFT - MARGIN_RIGHT - PAPER_ROOM;
        let frame = Frame {
            left: MARGIN_LEFT,
            top: MARGIN_TOP,
            style: PictureStyle::Paper,
            ..Frame::of(&self.brief.grid, side)
        };
        let mut svg =
            SvgWriter::column(WIDTH, frame.top + frame.height + AXIS_HEIGHT, COLUMN_MM, &self.title());
        self.plot(&mut svg, &frame, &tiles, (layer, heights));
        axes(&mut svg, &frame, &self.brief.grid, Numbered { left: true, below: true });
        let range = layer.range().unwrap_or(heights);
        colour_bar(&mut svg, &frame, layer, range);
        Ok(svg.finish())
    }
}
