//! Several pictures on one sheet, with one legend and one scale of heights.

use contract::Range;

use super::raster::Raster;
use super::sheet::Sheet;
use super::{
    AXIS_HEIGHT, Frame, MARGIN_LEFT, MARGIN_RIGHT, MARGIN_TOP, Numbered, PANEL_SIDE, PLOT_SIDE, Picture,
    axes, colour_bar, legend,
};
use crate::ReportError;

/// Between two views side by side, in the picture's units.
const GAP: f64 = 22.0;
/// Of the line of text over a view.
const HEADING: f64 = 30.0;

/// A picture with a line of text over it.
#[derive(Clone, Debug)]
pub struct View<'a> {
    /// The line; may be empty.
    pub heading: String,
    /// The picture; its own title and caption are not drawn.
    pub picture: Picture<'a>,
}

/// A sheet of views in rows.
#[derive(Clone, Debug)]
pub struct Plate<'a> {
    /// Title of the sheet.
    pub title: String,
    /// A smaller line below the title.
    pub caption: String,
    /// Views in a row, at least 1.
    pub columns: usize,
    /// The views, row by row; best on grids of one size.
    pub views: Vec<View<'a>>,
}

impl Plate<'_> {
    /// The sheet as an SVG document. Heights have one scale, from the lowest of any view to the highest.
    ///
    /// # Errors
    /// [`ReportError::Cells`] if terrain, map or policy of a view do not cover its grid.
    pub fn svg(&self) -> Result<String, ReportError> {
        self.views.iter().try_for_each(|view| view.picture.check())?;
        let rasters: Vec<Raster> = self.views.iter().map(|view| Raster::new(&view.picture)).collect();
        let heights =
            rasters.iter().map(Raster::heights).reduce(union).unwrap_or(Range { min: 0.0, max: 1.0 });
        let frames = self.frames(&rasters);
        let right = frames.iter().map(|frame| frame.left + frame.width).fold(MARGIN_LEFT, f64::max);
        let bottom = frames.iter().map(|frame| frame.top + frame.height).fold(MARGIN_TOP, f64::max);
        let width = right + MARGIN_RIGHT;
        let legend_top = bottom + AXIS_HEIGHT;
        let legend = self.legend(&rasters);

        let mut sheet = Sheet::new(width, legend_top + legend::height(legend.len(), width), &self.title);
        sheet.heading(MARGIN_LEFT, 36.0, 20.0, "font-weight=\"bold\"", &self.title);
        sheet.heading(MARGIN_LEFT, 60.0, 14.0, "fill=\"#555\"", &self.caption);
        for ((place, frame), View { heading, picture }) in frames.iter().enumerate().zip(&self.views) {
            picture.plot(&mut sheet, frame, &rasters[place], heights);
            let last_of_column = place + self.columns >= self.views.len();
            let numbered = Numbered { left: place % self.columns == 0, below: last_of_column };
            axes(&mut sheet, frame, &picture.brief.grid, numbered);
            if !heading.is_empty() {
                sheet.text(frame.left, frame.top - 9.0, "font-size=\"13\"", heading);
            }
        }
        if let Some(first) = frames.first() {
            let all = Frame { width: right - first.left, height: bottom - first.top, ..*first };
            colour_bar(&mut sheet, &all, heights);
        }
        legend::draw(&mut sheet, &legend, legend_top, width);
        Ok(sheet.finish())
    }

    /// Where each view lies.
    fn frames(&self, rasters: &[Raster]) -> Vec<Frame> {
        let side = if self.views.len() > 1 { PANEL_SIDE } else { PLOT_SIDE };
        let heading = if self.views.iter().any(|view| !view.heading.is_empty()) { HEADING } else { 0.0 };
        let mut frames: Vec<Frame> =
            self.views.iter().map(|view| Frame::of(&view.picture.brief.grid, side)).collect();
        let mut top = MARGIN_TOP;
        for (number, row) in frames.chunks_mut(self.columns.max(1)).enumerate() {
            let mut left = MARGIN_LEFT;
            top += heading;
            for (column, frame) in row.iter_mut().enumerate() {
                (frame.left, frame.top, frame.place) = (left, top, number * self.columns + column);
                left += frame.width + GAP;
            }
            top += row.iter().map(|frame| frame.height).fold(0.0, f64::max) + GAP / 2.0;
        }
        for (place, frame) in frames.iter_mut().enumerate() {
            frame.ground = rasters[..place].iter().position(|raster| raster.has_ground_of(&rasters[place]));
        }
        frames
    }

    fn legend(&self, rasters: &[Raster]) -> Vec<legend::Entry> {
        let views = self.views.iter().zip(rasters);
        let mut entries: Vec<_> =
            views.map(|(view, raster)| legend::entries(&view.picture, raster)).collect();
        if entries.len() == 1 { entries.remove(0) } else { legend::shared(entries) }
    }
}

fn union(one: Range, other: Range) -> Range {
    Range { min: one.min.min(other.min), max: one.max.max(other.max) }
}
