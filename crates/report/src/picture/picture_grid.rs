//! Several pictures in one SVG document, with one legend and one height scale.

use contract::Range;

use super::frame::{Frame, MARGIN_RIGHT, Numbered, axes, colour_bar};
use super::legend;
use super::mission::Picture;
use super::scale::range;
use super::svg_writer::SvgWriter;
use super::tile_map::TileMap;
use crate::{Layer, ReportError};

/// Longer side of a single plot, in the picture's units (pixels at 96 dpi).
const PLOT_SIDE: f64 = 760.0;
/// Longer side of each plot if there are several.
const PANEL_SIDE: f64 = 300.0;
const MARGIN_LEFT: f64 = 74.0;
const MARGIN_TOP: f64 = 82.0;
const AXIS_HEIGHT: f64 = 58.0;
/// Longer side of each plot if they show layers with a scale of their own.
const SCALE_SIDE: f64 = 520.0;
/// Space between two pictures side by side, in the picture's units.
const GAP: f64 = 22.0;
/// Height of the heading over a picture, in the picture's units.
const HEADING: f64 = 30.0;

/// A picture with a heading.
#[derive(Clone, Debug)]
pub struct TitledPicture<'a> {
    /// One line of text over the picture; may be empty.
    pub heading: String,
    /// The picture itself; its own title and caption are not drawn.
    pub picture: Picture<'a>,
    /// What its ground shows.
    pub layer: Layer,
}

/// Pictures in rows, under one title.
#[derive(Clone, Debug)]
pub struct PictureGrid<'a> {
    /// Title of the document.
    pub title: String,
    /// A smaller line below the title.
    pub caption: String,
    /// Pictures in a row, at least 1.
    pub columns: usize,
    /// The pictures, row by row; they line up if their grids have one size.
    pub views: Vec<TitledPicture<'a>>,
}

impl PictureGrid<'_> {
    /// The SVG document. All pictures share one height scale, from the lowest cell of any to the highest.
    ///
    /// # Errors
    /// [`ReportError::Cells`] if terrain, map or policy of a picture do not cover its grid.
    pub fn svg(&self) -> Result<String, ReportError> {
        self.views.iter().try_for_each(|view| view.picture.check())?;
        let tile_maps: Vec<TileMap> = self.views.iter().map(|view| view.picture.tiles(view.layer)).collect();
        let heights = tile_maps.iter().map(TileMap::heights).flat_map(|heights| [heights.min, heights.max]);
        let heights = range(heights).unwrap_or(Range { min: 0.0, max: 1.0 });
        let frames = self.frames(&tile_maps);
        let right = frames.iter().map(|frame| frame.left + frame.width).fold(MARGIN_LEFT, f64::max);
        let bottom = frames.iter().map(|frame| frame.top + frame.height).fold(MARGIN_TOP, f64::max);
        let width = right + MARGIN_RIGHT;
        let legend_top = bottom + AXIS_HEIGHT;
        let legend = self.legend(&tile_maps);

        let mut svg = SvgWriter::new(width, legend_top + legend::height(legend.len(), width), &self.title);
        svg.heading(MARGIN_LEFT, 36.0, 20.0, "font-weight=\"bold\"", &self.title);
        svg.heading(MARGIN_LEFT, 60.0, 14.0, "fill=\"#555\"", &self.caption);
        for ((place, frame), TitledPicture { heading, picture, layer }) in
            frames.iter().enumerate().zip(&self.views)
        {
            picture.plot(&mut svg, frame, &tile_maps[place], (*layer, heights));
            let last_of_column = place + self.columns >= self.views.len();
            let numbered = Numbered { left: place % self.columns == 0, below: last_of_column };
            axes(&mut svg, frame, &picture.brief.grid, numbered);
            if !heading.is_empty() {
                svg.text(frame.left, frame.top - 9.0, "font-size=\"13\"", heading);
            }
            if let Some(range) = layer.range() {
                colour_bar(&mut svg, frame, *layer, range);
            } else if !self.is_of_relief() {
                colour_bar(&mut svg, frame, *layer, heights);
            }
        }
        if self.is_of_relief()
            && let (Some(first), Some(view)) = (frames.first(), self.views.first())
        {
            let all = Frame { width: right - first.left, height: bottom - first.top, ..*first };
            colour_bar(&mut svg, &all, view.layer, heights);
        }
        legend::draw(&mut svg, &legend, legend_top, width);
        Ok(svg.finish())
    }

    /// Whether the pictures share a scale of heights.
    fn is_of_relief(&self) -> bool {
        self.views.iter().all(|view| view.layer.range().is_none())
    }

    /// The frame of each picture.
    fn frames(&self, tile_maps: &[TileMap]) -> Vec<Frame> {
        let (side, gap) = match (self.is_of_relief(), self.views.len()) {
            (false, _) => (SCALE_SIDE, GAP + MARGIN_RIGHT),
            (true, 0 | 1) => (PLOT_SIDE, GAP),
            (true, _) => (PANEL_SIDE, GAP),
        };
        let heading = if self.views.iter().any(|view| !view.heading.is_empty()) { HEADING } else { 0.0 };
        let mut frames: Vec<Frame> =
            self.views.iter().map(|view| Frame::of(&view.picture.brief.grid, side)).collect();
        let mut top = MARGIN_TOP;
        for (number, row) in frames.chunks_mut(self.columns.max(1)).enumerate() {
            let mut left = MARGIN_LEFT;
            top += heading;
            for (column, frame) in row.iter_mut().enumerate() {
                (frame.left, frame.top, frame.place) = (left, top, number * self.columns + column);
                left += frame.width + gap;
            }
            top += row.iter().map(|frame| frame.height).fold(0.0, f64::max) + GAP / 2.0;
        }
        for (place, frame) in frames.iter_mut().enumerate() {
            let (layer, tiles) = (self.views[place].layer, &tile_maps[place]);
            frame.ground = (0..place).find(|&earlier| {
                self.views[earlier].layer == layer && tile_maps[earlier].has_ground_of(tiles)
            });
        }
        frames
    }

    fn legend(&self, tile_maps: &[TileMap]) -> Vec<legend::Entry> {
        let views = self.views.iter().zip(tile_maps);
        let mut entries: Vec<_> = views.map(|(view, tiles)| legend::entries(&view.picture, tiles)).collect();
        if entries.len() == 1 { entries.remove(0) } else { legend::shared(entries) }
    }
}

impl Picture<'_> {
    /// The picture as an SVG document.
    ///
    /// # Errors
    /// [`ReportError::Cells`] if terrain, map or policy do not cover the grid.
    pub fn svg(&self) -> Result<String, ReportError> {
        let layers = self.layers();
        let view = |layer: &Layer| {
            let heading = if layers.len() > 1 { layer.definition().heading } else { "" };
            TitledPicture { heading: heading.into(), picture: *self, layer: *layer }
        };
        let views: Vec<_> = layers.iter().map(view).collect();
        PictureGrid { title: self.title(), caption: self.caption(), columns: views.len(), views }.svg()
    }
}
