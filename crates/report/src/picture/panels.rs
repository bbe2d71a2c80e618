//! Plans side by side: policy arrows, path, hills, sand, in the manner of P22's figures 4 to 11.

use std::fmt::Write as _;

use contract::{Cell, Direction, Grid, Ground, Range, Soil};

use super::scale::Ticks;
use super::sheet::{Number, Sheet};
use super::{Quiver, SHADES, arrow, colour, legend};
use crate::ReportError;

const MARGIN_LEFT: f64 = 58.0;
const MARGIN_TOP: f64 = 78.0;
/// Room to the right, for the height scale.
const MARGIN_RIGHT: f64 = 104.0;
/// Room over a panel for its title, under it for its axis.
const HEAD: f64 = 24.0;
const FOOT: f64 = 30.0;
const GAP: f64 = 34.0;
const LEGEND: f64 = 62.0;

/// Where a policy hops from a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Aim {
    /// Towards which neighbour.
    pub direction: Direction,
    /// Whether vertically, onto a rock.
    pub up: bool,
}

/// One plan.
#[derive(Clone, Debug)]
pub struct Panel<'a> {
    /// What is written over it.
    pub title: String,
    /// The lattice.
    pub grid: Grid,
    /// Ground of every cell in index order.
    pub ground: &'a [Ground],
    /// What the policy does in every cell; `None` where it does nothing.
    pub policy: Vec<Option<Aim>>,
    /// Where it leads, from the start on.
    pub path: &'a [Cell],
    /// Whether that is the goal.
    pub arrives: bool,
    /// The start.
    pub start: Cell,
    /// The goal.
    pub goal: Cell,
}

/// Panels in rows, under one title, with one height scale.
#[derive(Clone, Debug)]
pub struct Panels<'a> {
    /// The title.
    pub title: String,
    /// What is written under it.
    pub caption: String,
    /// Panels in a row, at least 1.
    pub columns: usize,
    /// Longer side of a panel, in the picture's units (pixels at 96 dpi).
    pub side: f64,
    /// The plans, left to right, top to bottom.
    pub panels: Vec<Panel<'a>>,
}

impl Panels<'_> {
    /// The picture as an SVG document; it depends on nothing but the panels, to the byte.
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
        let mut sheet = Sheet::new(width, bottom + LEGEND, &self.title);
        sheet.heading(24.0, 34.0, 20.0, "font-weight=\"bold\"", &self.title);
        sheet.heading(24.0, 58.0, 14.0, "fill=\"#555\"", &self.caption);
        let heights = self.heights();
        // Panels on the same ground share its drawing.
        let mut grounds: Vec<(&[Ground], Grid)> = Vec::new();
        sheet.open("defs", "");
        for panel in &self.panels {
            if !grounds.contains(&(panel.ground, panel.grid)) {
                let id = format!("ground-{}", grounds.len());
                ground(&mut sheet, &id, panel, heights);
                grounds.push((panel.ground, panel.grid));
            }
        }
        sheet.close("defs");
        for (n, panel) in self.panels.iter().enumerate() {
            let left = MARGIN_LEFT + (n % columns) as f64 * pitch_x;
            let top = MARGIN_TOP + HEAD + (n / columns) as f64 * pitch_y;
            let drawn = grounds.iter().position(|(ground, _)| *ground == panel.ground).unwrap_or(0);
            let frame = Frame::new(panel, left, top, self.side);
            frame.draw(&mut sheet, panel, drawn);
        }
        let top = MARGIN_TOP + HEAD;
        height_scale(&mut sheet, width - MARGIN_RIGHT + 26.0, top, bottom - FOOT - top, heights);
        self.legend(&mut sheet, bottom + 22.0);
        Ok(sheet.finish())
    }

    fn heights(&self) -> Range {
        let heights = self.panels.iter().flat_map(|panel| panel.ground).map(|ground| ground.height_m);
        let range = heights.fold(Range { min: f64::INFINITY, max: f64::NEG_INFINITY }, |range, height_m| {
            Range { min: range.min.min(height_m), max: range.max.max(height_m) }
        });
        if range.min > range.max { Range { min: 0.0, max: 0.0 } } else { range }
    }

    fn legend(&self, sheet: &mut Sheet, y: f64) {
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
            sheet.raw(&swatch(x));
            sheet.text(x + 20.0, y + 4.5, "", words);
            x += 48.0 + 7.3 * words.chars().count() as f64;
        };
        entry(&|x| legend::start(x, y, 6.0), "start");
        entry(&|x| legend::goal(x, y, 6.0), "goal");
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

/// Attributes of an arrow: vertical hops are white with a dark rim.
fn ink(direction: Direction, up: bool) -> String {
    match up {
        true => "fill=\"#fff\" stroke=\"#111\" stroke-width=\"4.5\" paint-order=\"stroke\" stroke-linejoin=\"round\"".to_owned(),
        false => format!("fill=\"{}\"", colour::arrow(direction)),
    }
}

/// Shades of the ground once, in units of a cell, y up, for every panel that stands on it.
fn ground(sheet: &mut Sheet, id: &str, panel: &Panel<'_>, heights: Range) {
    sheet.open("g", &format!("id=\"{id}\" shape-rendering=\"crispEdges\""));
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
        sheet.path(&cells(&|ground| shade(ground) == n), &fill);
    }
    let sand = cells(&|ground| ground.soil == Soil::Sand);
    sheet.path(&sand, &format!("fill=\"{}\" fill-opacity=\".5\"", colour::SAND));
    sheet.close("g");
}

/// Where a panel lies on the sheet.
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

    fn draw(&self, sheet: &mut Sheet, panel: &Panel<'_>, ground: usize) {
        let Self { left, top, width, height, pitch } = *self;
        sheet.text(left, top - 8.0, "font-size=\"13\"", &panel.title);
        sheet.raw(&format!(
            "<use href=\"#ground-{ground}\" transform=\"translate({} {}) scale({} {})\"/>",
            Number(left),
            Number(top + height),
            Number(pitch),
            Number(-pitch)
        ));
        self.policy(sheet, panel);
        self.path(sheet, panel);
        let size = (pitch * 0.4).clamp(4.0, 9.0);
        for (cell, mark) in
            [(panel.start, legend::start as fn(f64, f64, f64) -> String), (panel.goal, legend::goal)]
        {
            let (x, y) = self.centre(cell);
            sheet.raw(&mark(x, y, size));
        }
        sheet.raw(&format!(
            "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#333\"/>",
            Number(left),
            Number(top),
            Number(width),
            Number(height)
        ));
        self.axes(sheet, panel);
    }

    fn policy(&self, sheet: &mut Sheet, panel: &Panel<'_>) {
        let aims =
            || panel.grid.iter().zip(&panel.policy).filter_map(|(cell, aim)| aim.map(|aim| (cell, aim)));
        for direction in Direction::ALL {
            for up in [false, true] {
                let quiver = Quiver::new(self.pitch * if up { 0.95 } else { 0.72 });
                let wanted = aims().filter(|(_, aim)| *aim == Aim { direction, up });
                let path = quiver.path(direction, wanted.map(|(cell, _)| self.centre(cell)));
                if !path.is_empty() {
                    quiver.open(sheet);
                    sheet.path(&path, &ink(direction, up));
                    sheet.close("g");
                }
            }
        }
    }

    fn path(&self, sheet: &mut Sheet, panel: &Panel<'_>) {
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
        sheet.path(&path, &stroke("#fff", breadth + 2.0, " stroke-opacity=\".8\""));
        match panel.arrives {
            true => sheet.path(&path, &stroke(colour::ROUTE, breadth, "")),
            false => {
                let dots = format!(" stroke-dasharray=\"0.5 {}\"", Number(breadth * 1.8));
                sheet.path(&path, &stroke(colour::BLOCKED, breadth, &dots));
            }
        }
    }

    fn axes(&self, sheet: &mut Sheet, panel: &Panel<'_>) {
        let reach = |cells: u32| Range { min: 0.0, max: f64::from(cells - 1) * panel.grid.cell_size_m };
        let mut strokes = String::new();
        let small = "font-size=\"10.5\" fill=\"#444\"";
        for (at_m, label) in Ticks::over(reach(panel.grid.width), 5).labels() {
            let (x, y) =
                (self.left + (at_m / panel.grid.cell_size_m + 0.5) * self.pitch, self.top + self.height);
            let _ = write!(strokes, "M{} {}v4", Number(x), Number(y));
            sheet.text(x, y + 16.0, &format!("text-anchor=\"middle\" {small}"), &label);
        }
        for (at_m, label) in Ticks::over(reach(panel.grid.height), 5).labels() {
            let y = self.top + self.height - (at_m / panel.grid.cell_size_m + 0.5) * self.pitch;
            let _ = write!(strokes, "M{} {}h-4", Number(self.left), Number(y));
            sheet.text(self.left - 7.0, y + 3.8, &format!("text-anchor=\"end\" {small}"), &label);
        }
        sheet.path(&strokes, "stroke=\"#333\"");
    }
}

fn height_scale(sheet: &mut Sheet, left: f64, top: f64, height: f64, heights: Range) {
    let height = height.min(360.0);
    let step = height / SHADES as f64;
    for shade in 0..SHADES {
        let fill = colour::height((shade as f64 + 0.5) / SHADES as f64);
        let overlap = if shade == 0 { 0.0 } else { 0.5 };
        sheet.raw(&format!(
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
        sheet.text(left + 23.0, y + 4.0, "font-size=\"11\"", &label);
    }
    sheet.path(&strokes, "stroke=\"#333\"");
    sheet.text_upwards(left + 70.0, top + height / 2.0, "height (m)");
}
