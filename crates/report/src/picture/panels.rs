//! Plans on known ground side by side, in the style of P22's figures 4 to 11.

use std::fmt::Write as _;

use contract::{Cell, Direction, Grid, Ground, Range, Soil};

use super::frame::SHADES;
use super::quiver::{Quiver, arrow};
use super::scale::{Ticks, range};
use super::svg_writer::{Number, SvgWriter};
use super::symbols;
use crate::ReportError;
use crate::colour;

const MARGIN_LEFT: f64 = 58.0;
const MARGIN_TOP: f64 = 78.0;
/// Room to the right, for the height scale.
const MARGIN_RIGHT: f64 = 104.0;
/// Room over a panel for its title, under it for its axis.
const HEAD: f64 = 24.0;
const FOOT: f64 = 30.0;
const GAP: f64 = 34.0;
const LEGEND: f64 = 62.0;

/// The hop of a policy in one cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Aim {
    /// Direction of the hop.
    pub direction: Direction,
    /// Whether it is a vertical hop, onto a rock.
    pub up: bool,
}

/// One plan with its terrain.
#[derive(Clone, Debug)]
pub struct Panel<'a> {
    /// Line of text over the panel.
    pub title: String,
    /// Lattice of the cells.
    pub grid: Grid,
    /// True ground of every cell in index order.
    pub ground: &'a [Ground],
    /// Hop of the policy in every cell, in index order; `None` where it has none.
    pub policy: Vec<Option<Aim>>,
    /// Cells of the path that the policy intends, from the start on.
    pub path: &'a [Cell],
    /// Whether the path ends at the goal.
    pub arrives: bool,
    /// Start of the path.
    pub start: Cell,
    /// Goal of the plan.
    pub goal: Cell,
}

/// Panels in rows, under one title, with one height scale.
#[derive(Clone, Debug)]
pub struct Panels<'a> {
    /// Title of the document.
    pub title: String,
    /// A smaller line below the title.
    pub caption: String,
    /// Panels in a row, at least 1.
    pub columns: usize,
    /// Longer side of a panel, in the picture's units (pixels at 96 dpi).
    pub side: f64,
    /// The plans, left to right, top to bottom.
    pub panels: Vec<Panel<'a>>,
}

impl Panels<'_> {
    /// The SVG document; it depends only on the panels, to the byte.
    ///
    /// # Errors
    /// [`ReportError::Cells`] if ground or policy of a panel do not cover its grid.
    pub fn svg(&self) -> Result<String, ReportError> {
        for panel in &self.panels {
            let need = panel.grid.cells();
            for (layer, got) in [("ground", panel.ground.len()), ("policy", panel.policy.len())] {
                if got != need {
                    return Err(ReportError::Cells { layer, need, got });
                }
            }
        }
        let columns = self.columns.clamp(1, self.panels.len().max(1));
        let rows = self.panels.len().div_ceil(columns);
        let (pitch_x, pitch_y) = (self.side + GAP, self.side + HEAD + FOOT);
        let width = MARGIN_LEFT + columns as f64 * pitch_x - GAP + MARGIN_RIGHT;
        let bottom = MARGIN_TOP + rows as f64 * pitch_y;
        let mut svg = SvgWriter::new(width, bottom + LEGEND, &self.title);
        svg.heading(24.0, 34.0, 20.0, "font-weight=\"bold\"", &self.title);
        svg.heading(24.0, 58.0, 14.0, "fill=\"#555\"", &self.caption);
        let heights = self.heights();
        // Panels with the same terrain share its drawing.
        let mut grounds: Vec<(&[Ground], Grid)> = Vec::new();
        svg.open("defs", "");
        for panel in &self.panels {
            if !grounds.contains(&(panel.ground, panel.grid)) {
                let id = format!("ground-{}", grounds.len());
                ground(&mut svg, &id, panel, heights);
                grounds.push((panel.ground, panel.grid));
            }
        }
        svg.close("defs");
        for (n, panel) in self.panels.iter().enumerate() {
            let left = MARGIN_LEFT + (n % columns) as f64 * pitch_x;
            let top = MARGIN_TOP + HEAD + (n / columns) as f64 * pitch_y;
            let drawn = grounds.iter().position(|(ground, _)| *ground == panel.ground).unwrap_or(0);
            let frame = Frame::new(panel, left, top, self.side);
            frame.draw(&mut svg, panel, drawn);
        }
        let top = MARGIN_TOP + HEAD;
        height_scale(&mut svg, width - MARGIN_RIGHT + 26.0, top, bottom - FOOT - top, heights);
        self.legend(&mut svg, bottom + 22.0);
        Ok(svg.finish())
    }

    fn heights(&self) -> Range {
        let heights = self.panels.iter().flat_map(|panel| panel.ground).map(|ground| ground.height_m);
        range(heights).unwrap_or(Range { min: 0.0, max: 0.0 })
    }

    fn legend(&self, svg: &mut SvgWriter, y: f64) {
        let any = |wanted: &dyn Fn(&Panel<'_>) -> bool| self.panels.iter().any(wanted);
        let line = |x: f64, colour: &str, rest: &str| {
            format!(
                "<path stroke=\"{colour}\" stroke-width=\"3.4\" stroke-linecap=\"round\"{rest} d=\"M{} {}h24\"/>",
                Number(x - 12.0),
                Number(y)
            )
        };
        let mut x = 36.0;
        let mut entry = |swatch: &dyn Fn(f64) -> String, words: &str| {
            svg.raw(&swatch(x));
            svg.text(x + 20.0, y + 4.5, "", words);
            x += 48.0 + 7.3 * words.chars().count() as f64;
        };
        entry(&|x| symbols::start(x, y, 6.0), "start");
        entry(&|x| symbols::goal(x, y, 6.0), "goal");
        if any(&|panel| panel.arrives) {
            entry(&|x| line(x, colour::ROUTE, ""), "path");
        }
        if any(&|panel| !panel.arrives) {
            entry(&|x| line(x, colour::BLOCKED, " stroke-dasharray=\"1 6\""), "no path");
        }
        if any(&|panel| panel.ground.iter().any(|ground| ground.soil == Soil::Sand)) {
            let patch = |x: f64| {
                let (left, top) = (Number(x - 12.0), Number(y - 7.0));
                let rect = |fill: &str, rest: &str| {
                    format!(
                        "<rect x=\"{left}\" y=\"{top}\" width=\"24\" height=\"14\" fill=\"{fill}\"{rest}/>"
                    )
                };
                rect(&colour::height(0.5), "") + &rect(colour::SAND, " fill-opacity=\".5\"")
            };
            entry(&patch, "sand");
        }
        let hop = |x: f64, direction, up| {
            let (x, y, ink) = (Number(x), Number(y), ink(direction, up));
            format!(
                "<path {ink} transform=\"translate({x} {y}) scale(.28)\" d=\"M0 0{}\"/>",
                arrow(direction)
            )
        };
        for direction in [Direction::North, Direction::South, Direction::East, Direction::West] {
            entry(&|x| hop(x, direction, false), &direction.to_string());
        }
        if any(&|panel| panel.policy.iter().flatten().any(|aim| aim.up)) {
            entry(&|x| hop(x, Direction::East, true), "vertical hop");
        }
    }
}

/// SVG attributes of an arrow: vertical hops are white with a dark rim.
fn ink(direction: Direction, up: bool) -> String {
    match up {
        true => "fill=\"#fff\" stroke=\"#111\" stroke-width=\"4.5\" paint-order=\"stroke\" stroke-linejoin=\"round\"".to_owned(),
        false => format!("fill=\"{}\"", colour::arrow(direction)),
    }
}

/// Draws the terrain once, in units of a cell with y upwards, for every panel that shows it.
fn ground(svg: &mut SvgWriter, id: &str, panel: &Panel<'_>, heights: Range) {
    svg.open("g", &format!("id=\"{id}\" shape-rendering=\"crispEdges\""));
    let shade = |ground: &Ground| {
        (heights.normalise(ground.height_m) * SHADES as f64).min(SHADES as f64 - 1.0).max(0.0) as usize
    };
    let cells = |wanted: &dyn Fn(&Ground) -> bool| {
        let mut path = String::new();
        for (cell, _) in panel.grid.iter().zip(panel.ground).filter(|(_, ground)| wanted(ground)) {
            let _ = write!(path, "M{} {}h1v1h-1z", cell.x, cell.y);
        }
        path
    };
    for n in 0..SHADES {
        let fill = format!("fill=\"{}\"", colour::height((n as f64 + 0.5) / SHADES as f64));
        svg.path(&cells(&|ground| shade(ground) == n), &fill);
    }
    let sand = cells(&|ground| ground.soil == Soil::Sand);
    svg.path(&sand, &format!("fill=\"{}\" fill-opacity=\".5\"", colour::SAND));
    svg.close("g");
}

/// Position and scale of a panel in the document.
struct Frame {
    left: f64,
    top: f64,
    width: f64,
    height: f64,
    pitch: f64,
}

impl Frame {
    fn new(panel: &Panel<'_>, left: f64, top: f64, side: f64) -> Self {
        let (columns, rows) = (f64::from(panel.grid.width), f64::from(panel.grid.height));
        let pitch = side / columns.max(rows);
        Self { left, top, width: columns * pitch, height: rows * pitch, pitch }
    }

    fn centre(&self, cell: Cell) -> (f64, f64) {
        let x = self.left + (f64::from(cell.x) + 0.5) * self.pitch;
        (x, self.top + self.height - (f64::from(cell.y) + 0.5) * self.pitch)
    }

    fn draw(&self, svg: &mut SvgWriter, panel: &Panel<'_>, ground: usize) {
        let Self { left, top, width, height, pitch } = *self;
        svg.text(left, top - 8.0, "font-size=\"13\"", &panel.title);
        svg.raw(&format!(
            "<use href=\"#ground-{ground}\" transform=\"translate({} {}) scale({} {})\"/>",
            Number(left),
            Number(top + height),
            Number(pitch),
            Number(-pitch)
        ));
        self.policy(svg, panel);
        self.path(svg, panel);
        let size = (pitch * 0.4).clamp(4.0, 9.0);
        for (cell, mark) in
            [(panel.start, symbols::start as fn(f64, f64, f64) -> String), (panel.goal, symbols::goal)]
        {
            let (x, y) = self.centre(cell);
            svg.raw(&mark(x, y, size));
        }
        svg.outline(left, top, width, height);
        self.axes(svg, panel);
    }

    fn policy(&self, svg: &mut SvgWriter, panel: &Panel<'_>) {
        let aims =
            || panel.grid.iter().zip(&panel.policy).filter_map(|(cell, aim)| aim.map(|aim| (cell, aim)));
        for direction in Direction::ALL {
            for up in [false, true] {
                let quiver = Quiver::new(self.pitch * if up { 0.95 } else { 0.72 });
                let wanted = aims().filter(|(_, aim)| *aim == Aim { direction, up });
                let path = quiver.path(direction, wanted.map(|(cell, _)| self.centre(cell)));
                if !path.is_empty() {
                    quiver.open(svg);
                    svg.path(&path, &ink(direction, up));
                    svg.close("g");
                }
            }
        }
    }

    fn path(&self, svg: &mut SvgWriter, panel: &Panel<'_>) {
        let mut path = String::new();
        for (n, &cell) in panel.path.iter().enumerate() {
            let (x, y) = self.centre(cell);
            let _ = write!(path, "{}{} {}", if n == 0 { 'M' } else { 'L' }, Number(x), Number(y));
        }
        let breadth = (self.pitch * 0.24).clamp(2.0, 5.0);
        let stroke = |colour: &str, width: f64, rest: &str| {
            format!(
                "fill=\"none\" stroke=\"{colour}\" stroke-width=\"{}\" stroke-linecap=\"round\" stroke-linejoin=\"round\"{rest}",
                Number(width)
            )
        };
        svg.path(&path, &stroke("#fff", breadth + 2.0, " stroke-opacity=\".8\""));
        match panel.arrives {
            true => svg.path(&path, &stroke(colour::ROUTE, breadth, "")),
            false => {
                let dots = format!(" stroke-dasharray=\"0.5 {}\"", Number(breadth * 1.8));
                svg.path(&path, &stroke(colour::BLOCKED, breadth, &dots));
            }
        }
    }

    fn axes(&self, svg: &mut SvgWriter, panel: &Panel<'_>) {
        let reach = |cells: u32| Range { min: 0.0, max: f64::from(cells - 1) * panel.grid.cell_size_m };
        let mut strokes = String::new();
        let small = "font-size=\"10.5\" fill=\"#444\"";
        for (at_m, label) in Ticks::over(reach(panel.grid.width), 5).labels() {
            let (x, y) =
                (self.left + (at_m / panel.grid.cell_size_m + 0.5) * self.pitch, self.top + self.height);
            let _ = write!(strokes, "M{} {}v4", Number(x), Number(y));
            svg.text(x, y + 16.0, &format!("text-anchor=\"middle\" {small}"), &label);
        }
        for (at_m, label) in Ticks::over(reach(panel.grid.height), 5).labels() {
            let y = self.top + self.height - (at_m / panel.grid.cell_size_m + 0.5) * self.pitch;
            let _ = write!(strokes, "M{} {}h-4", Number(self.left), Number(y));
            svg.text(self.left - 7.0, y + 3.8, &format!("text-anchor=\"end\" {small}"), &label);
        }
        svg.path(&strokes, "stroke=\"#333\"");
    }
}

fn height_scale(svg: &mut SvgWriter, left: f64, top: f64, height: f64, heights: Range) {
    let height = height.min(360.0);
    let step = height / SHADES as f64;
    for shade in 0..SHADES {
        let fill = colour::height((shade as f64 + 0.5) / SHADES as f64);
        let overlap = if shade == 0 { 0.0 } else { 0.5 };
        svg.raw(&format!(
            "<rect x=\"{}\" y=\"{}\" width=\"15\" height=\"{}\" fill=\"{fill}\"/>",
            Number(left),
            Number(top + height - step * (shade + 1) as f64),
            Number(step + overlap)
        ));
    }
    let mut strokes = String::new();
    for (height_m, label) in Ticks::over(heights, 8).labels() {
        let y = top + height * (1.0 - heights.normalise(height_m));
        let _ = write!(strokes, "M{} {}h4", Number(left + 15.0), Number(y));
        svg.text(left + 23.0, y + 4.0, "font-size=\"11\"", &label);
    }
    svg.path(&strokes, "stroke=\"#333\"");
    svg.text_upwards(left + 70.0, top + height / 2.0, "height (m)");
}
