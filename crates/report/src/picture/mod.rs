//! The picture of a mission in the manner of the papers' figures (P23 figs. 3 to 13).
//!
//! Written as plain SVG. A chart library's SVG backend was weighed and left: it emits an element for
//! every cell and arrow head with its style spelled out (some 80 bytes a cell, 3 MB for 200×200), and it
//! knows no hatching, clipping, halo, or y axis turned north-up, so each of these would have been
//! worked around. Here cells of one shade are one path of merged rectangles, arrows of one direction
//! are one path, and what is left of a library's work, axes with round numbers, is a page of code.
//!
//! The coordinates are metres from the centre of cell (0, 0); the output depends on nothing but the
//! [`Picture`], to the byte.

mod colour;
mod curves;
mod legend;
mod panels;
mod plate;
mod raster;
mod scale;
mod sheet;

use std::collections::BTreeSet;
use std::fmt::Write as _;

use contract::{
    Action, Branch, Brief, Cell, Decision, Direction, Grid, Ground, ObservedMap, PolicyCell, Range, Record,
    Status,
};

pub use curves::{Chart, Curves, Line};
pub use panels::{Aim, Panel, Panels};

use crate::ReportError;
use crate::ending::{Ending, commanders, counted};
pub use plate::{Plate, View};
use raster::Raster;
use scale::Ticks;
use sheet::{Number, Sheet};

/// Longer side of the plot, in the picture's units (pixels at 96 dpi).
const PLOT_SIDE: f64 = 760.0;
/// Longer side of each plot where several stand side by side.
const PANEL_SIDE: f64 = 300.0;
/// Shortest side of the frame, lest a strip of cells leave no room for its colour bar.
const FRAME_MIN: f64 = 200.0;
const MARGIN_LEFT: f64 = 74.0;
const MARGIN_TOP: f64 = 82.0;
const MARGIN_RIGHT: f64 = 118.0;
const AXIS_HEIGHT: f64 = 58.0;
/// Shades of the height scale.
const SHADES: usize = 40;
/// Least distance of two policy arrows, as a share of the plot's longer side.
const ARROW_PITCH_MIN: f64 = 0.026;
/// Least distance of two policy arrows, in the picture's units.
const ARROW_PITCH_LEAST: f64 = 14.0;
/// Cells smaller than this leave no room for dashes.
const DASHED_PITCH_MIN: f64 = 12.0;

/// Everything that is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    /// The mission: grid, start, goal, names.
    pub brief: &'a Brief,
    /// The truth, drawn faintly where nothing was seen; empty if not known.
    pub terrain: &'a [Ground],
    /// The scenario's treasures; empty if not known.
    pub treasures: &'a [Cell],
    /// What was seen.
    pub map: &'a ObservedMap,
    /// The last policy, if the planner has one.
    pub policy: Option<&'a [PolicyCell]>,
    /// What the hopper did, in order.
    pub route: &'a [Record],
    /// How it ended.
    pub outcome: Status,
    /// Sensing radius at the present position, metres, if it shall be shown.
    pub sensing_radius_m: Option<f64>,
}

impl Picture<'_> {
    /// The picture as an SVG document.
    ///
    /// # Errors
    /// [`ReportError::Cells`] if terrain, map or policy do not cover the grid.
    pub fn svg(&self) -> Result<String, ReportError> {
        let view = View { heading: String::new(), picture: *self };
        Plate { title: self.title(), caption: self.caption(), columns: 1, views: vec![view] }.svg()
    }

    /// Draws the plot into its frame.
    fn plot(&self, sheet: &mut Sheet, frame: &Frame, raster: &Raster, heights: Range) {
        sheet.open("defs", "");
        self.patterns(sheet, frame, raster);
        sheet.close("defs");
        self.ground(sheet, frame, raster, heights);
        self.arrows(sheet, frame);
        self.way(sheet, frame);
        self.marks(sheet, frame);
    }

    fn check(&self) -> Result<(), ReportError> {
        let need = self.brief.grid.cells();
        let terrain = if self.terrain.is_empty() { need } else { self.terrain.len() };
        let policy = self.policy.map_or(need, <[PolicyCell]>::len);
        for (layer, got) in [("terrain", terrain), ("map", self.map.cells().len()), ("policy", policy)] {
            if got != need {
                return Err(ReportError::Cells { layer, need, got });
            }
        }
        Ok(())
    }

    fn patterns(&self, sheet: &mut Sheet, frame: &Frame, raster: &Raster) {
        let Frame { left, top, width, height, .. } = *frame;
        let id = |name: &str| frame.id(name);
        sheet.raw(&format!(
            "<clipPath id=\"{}\"><rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/></clipPath>",
            id("plot"),
            Number(left),
            Number(top),
            Number(width),
            Number(height)
        ));
        // Cells are drawn in units of a tile; patterns are given in those units, too.
        let unit = 1.0 / (frame.pitch * f64::from(raster.block));
        let stripes = |id: &str, pitch: f64, line: f64, turn: u32, colour: &str| {
            let (pitch, line) = (Number(pitch * unit), Number(line * unit));
            format!(
                "<pattern id=\"{id}\" width=\"{pitch}\" height=\"{pitch}\" patternUnits=\"userSpaceOnUse\" \
                 patternTransform=\"rotate({turn})\"><rect width=\"{line}\" height=\"{pitch}\" fill=\"{colour}\"/></pattern>"
            )
        };
        sheet.raw(&stripes(&id("unseen-hatch"), 7.0, 0.9, 45, colour::HATCH));
        sheet.raw(&stripes(&id("blocked-hatch"), 4.0, 1.6, 135, colour::BLOCKED));
    }

    fn ground(&self, sheet: &mut Sheet, frame: &Frame, raster: &Raster, heights: Range) {
        let scale = frame.pitch * f64::from(raster.block);
        sheet.open("g", &format!("clip-path=\"url(#{})\"", frame.id("plot")));
        sheet.open(
            "g",
            &format!(
                "transform=\"translate({} {}) scale({} {})\" shape-rendering=\"crispEdges\"",
                Number(frame.left),
                Number(frame.top + frame.height),
                Number(scale),
                Number(-scale)
            ),
        );
        match frame.ground {
            None => truth(sheet, frame, raster, heights),
            Some(place) => sheet.raw(&format!("<use href=\"#ground-{place}\"/>")),
        }
        let unseen = raster.fill(|tile| !tile.seen);
        sheet.path(&unseen, "fill=\"#fff\" fill-opacity=\".72\"");
        let hatch = format!("fill=\"url(#{})\" shape-rendering=\"auto\"", frame.id("unseen-hatch"));
        sheet.path(&unseen, &hatch);
        let edge = format!(
            "fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" shape-rendering=\"auto\"",
            colour::EDGE,
            Number(1.2 / scale)
        );
        sheet.path(&raster.outline(|tile| tile.seen), &edge);
        sheet.close("g");
        sheet.close("g");
    }

    /// Arrows where the policy hops, thinned to what can be told apart; faint over unseen ground.
    fn arrows(&self, sheet: &mut Sheet, frame: &Frame) {
        let Some(policy) = self.policy else { return };
        let span = self.brief.grid.hop_cells;
        let pitch_min = (ARROW_PITCH_MIN * frame.width.max(frame.height)).max(ARROW_PITCH_LEAST);
        let hops = ((pitch_min / (frame.pitch * f64::from(span))).ceil() as u32).max(1);
        let stride = (hops * span) as i32;
        let quiver = Quiver::new((0.66 * frame.pitch * f64::from(stride)).min(26.0));
        let drawn = |cell: &Cell| {
            (cell.x - self.brief.start.x).rem_euclid(stride) == 0
                && (cell.y - self.brief.start.y).rem_euclid(stride) == 0
        };
        quiver.open(sheet);
        for (seen, opacity) in [(false, ".4"), (true, "1")] {
            for direction in Direction::ALL {
                let mut at = Vec::new();
                for (index, cell) in self.brief.grid.iter().enumerate().filter(|(_, cell)| drawn(cell)) {
                    let passable = self.ground_at(index).is_none_or(|ground| ground.passable);
                    let points =
                        policy[index].action == Action::Hop(direction) && passable && cell != self.leg().goal;
                    if points && self.map.cells()[index].is_some() == seen {
                        at.push(frame.centre(cell));
                    }
                }
                let ink = colour::arrow(direction);
                let path = quiver.path(direction, at);
                sheet.path(&path, &format!("fill=\"{ink}\" fill-opacity=\"{opacity}\""));
            }
        }
        sheet.close("g");
    }

    /// The route: one line for hops as intended, one for strays, rings where the hopper stayed.
    fn way(&self, sheet: &mut Sheet, frame: &Frame) {
        let breadth = (frame.pitch * 0.16).clamp(2.4, 5.0);
        let (intended, stray) =
            (self.line(frame, |branch| branch == Branch::Intended), self.line(frame, is_slip));
        let line = |colour: &str, width: f64, rest: &str| {
            format!(
                "fill=\"none\" stroke=\"{colour}\" stroke-width=\"{}\" stroke-linecap=\"round\" \
                 stroke-linejoin=\"round\"{rest}",
                Number(width)
            )
        };
        sheet.path(&intended, &line("#fff", breadth + 2.4, " stroke-opacity=\".85\""));
        sheet.path(&stray, &line("#fff", breadth + 2.4, " stroke-opacity=\".85\""));
        sheet.path(&intended, &line(colour::ROUTE, breadth, ""));
        let dashes = match frame.pitch > DASHED_PITCH_MIN {
            true => format!(" stroke-dasharray=\"{} {}\"", Number(breadth * 1.2), Number(breadth * 1.8)),
            false => String::new(),
        };
        sheet.path(&stray, &line(colour::STRAY, breadth, &dashes));
        let stuck: BTreeSet<Cell> = self
            .route
            .iter()
            .filter(|record| record.outcome.branch == Branch::Stayed)
            .map(|record| record.outcome.from)
            .collect();
        let radius = (frame.pitch * 0.24).clamp(2.6, 8.0);
        let (radius, rim) = (Number(radius), Number((radius * 0.4).min(2.4)));
        for cell in stuck {
            let (x, y) = frame.centre(cell);
            sheet.raw(&format!(
                "<circle cx=\"{}\" cy=\"{}\" r=\"{radius}\" fill=\"#fff\" stroke=\"{}\" stroke-width=\"{rim}\"/>",
                Number(x),
                Number(y),
                colour::STRAY
            ));
        }
    }

    /// Path over the hops of the branches that are `wanted`, each way drawn once.
    fn line(&self, frame: &Frame, wanted: impl Fn(Branch) -> bool) -> String {
        let mut path = String::new();
        let mut drawn = BTreeSet::new();
        let mut pen = None;
        for outcome in self.route.iter().map(|record| record.outcome).filter(|outcome| wanted(outcome.branch))
        {
            let (from, to) = (outcome.from, outcome.to);
            if !drawn.insert((from.min(to), from.max(to))) {
                continue;
            }
            if pen != Some(from) {
                let (x, y) = frame.centre(from);
                let _ = write!(path, "M{} {}", Number(x), Number(y));
            }
            let (x, y) = frame.centre(to);
            let _ = write!(path, "L{} {}", Number(x), Number(y));
            pen = Some(to);
        }
        path
    }

    /// What has become of the treasure on `cell`.
    fn find(&self, cell: Cell) -> Find {
        let seen = self.brief.grid.index(cell).is_some_and(|index| self.map.cells()[index].is_some());
        match self.route.iter().any(|record| record.pose.cell == cell) {
            true => Find::Collected,
            false if seen => Find::Seen,
            false => Find::Unseen,
        }
    }

    /// Start, goal, treasures, the hopper with the disc it senses.
    fn marks(&self, sheet: &mut Sheet, frame: &Frame) {
        let here = self.position();
        let size = (frame.pitch * 0.3).clamp(6.0, 10.0);
        if let Some(radius_m) = self.sensing_radius_m {
            let (x, y) = frame.centre(here);
            let radius = Number(radius_m / self.brief.grid.cell_size_m * frame.pitch);
            sheet.open("g", &format!("clip-path=\"url(#{})\"", frame.id("plot")));
            for (colour, width, dash) in [("#fff", 3.2, ""), ("#111", 1.4, " stroke-dasharray=\"5 4\"")] {
                sheet.raw(&format!(
                    "<circle cx=\"{}\" cy=\"{}\" r=\"{radius}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\"{dash}/>",
                    Number(x),
                    Number(y)
                ));
            }
            sheet.close("g");
        }
        for &cell in self.treasures {
            let (x, y) = frame.centre(cell);
            sheet.raw(&legend::treasure(x, y, size * 0.72, self.find(cell)));
        }
        let (x, y) = frame.centre(self.brief.start);
        sheet.raw(&legend::start(x, y, size));
        let goals = self.brief.patrol.map_or_else(|| vec![self.brief.goal], |patrol| patrol.goals().to_vec());
        for goal in goals {
            let (x, y) = frame.centre(goal);
            sheet.raw(&legend::goal(x, y, size));
        }
        let (x, y) = frame.centre(here);
        sheet.raw(&legend::hopper(x, y, size * 0.62));
    }

    /// How it ended.
    fn title(&self) -> String {
        let last = self.route.last();
        let cell = self.position();
        // Of a long patrol the route is the end alone.
        let whole = self.route.first().is_none_or(|record| record.decision == Decision(0));
        let decisions = last.map_or(0, |record| record.decision.next().0);
        let ending = Ending {
            outcome: self.outcome,
            hops: if whole { self.hops(|_| true) } else { decisions },
            steps: last.map_or(0, |record| record.steps),
            steps_max: self.brief.limits.steps_max,
            cell,
            distance_to_goal_m: cell.distance_cells(self.leg().goal) * self.brief.grid.cell_size_m,
            patrolled: self.brief.patrol.map(|_| last.map_or(0, |record| record.visits)),
        };
        ending.to_string()
    }

    /// What was run, by whom.
    fn caption(&self) -> String {
        let Brief { scenario, profile, .. } = self.brief;
        let planners = commanders(self.route.iter().map(|record| record.leader.planner));
        let stray = counted(self.hops(|branch| branch != Branch::Intended), "stray hop");
        format!("Scenario {scenario}, planner {planners}, profile {profile}, {stray}")
    }

    fn hops(&self, wanted: impl Fn(Branch) -> bool) -> u64 {
        let branches = self.route.iter().map(|record| record.outcome.branch);
        branches.filter(|&branch| branch != Branch::Held && wanted(branch)).count() as u64
    }

    /// The leg that is flown.
    fn leg(&self) -> Brief {
        self.brief.leg(self.route.last().map_or(0, |record| record.visits))
    }

    /// Where the hopper is.
    fn position(&self) -> Cell {
        self.route.last().map_or(self.brief.start, |record| record.pose.cell)
    }

    /// The truth of a cell, or what was seen of it where the truth is not known.
    fn ground_at(&self, index: usize) -> Option<&Ground> {
        self.terrain.get(index).or(self.map.cells()[index].as_ref())
    }
}

/// What has become of a treasure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Find {
    Collected,
    Seen,
    Unseen,
}

/// Heights, sand and impassable ground, as a group that other plots can use.
fn truth(sheet: &mut Sheet, frame: &Frame, raster: &Raster, heights: Range) {
    sheet.open("g", &format!("id=\"{}\"", frame.id("ground")));
    sheet.path(&raster.fill(|_| true), &format!("fill=\"{}\"", colour::NOTHING));
    let shade_of =
        |height_m: f64| (heights.normalise(height_m) * SHADES as f64).min(SHADES as f64 - 1.0) as usize;
    for shade in 0..SHADES {
        let colour = colour::height((shade as f64 + 0.5) / SHADES as f64);
        let cells = raster.fill(|tile| tile.height_m.is_some_and(|height_m| shade_of(height_m) == shade));
        sheet.path(&cells, &format!("fill=\"{colour}\""));
    }
    sheet.path(&raster.fill(|tile| tile.sand), &format!("fill=\"{}\" fill-opacity=\".5\"", colour::SAND));
    let blocked = raster.fill(|tile| tile.blocked);
    sheet.path(&blocked, &format!("fill=\"{}\" fill-opacity=\".45\"", colour::BLOCKED));
    sheet.path(&blocked, &format!("fill=\"url(#{})\"", frame.id("blocked-hatch")));
    sheet.close("g");
}

fn is_slip(branch: Branch) -> bool {
    matches!(branch, Branch::Left | Branch::Right)
}

/// Arrows of one length, in units of a fiftieth of it: their coordinates are short whole numbers.
#[derive(Clone, Copy, Debug)]
struct Quiver {
    /// A fiftieth of an arrow, in the picture's units.
    unit: f64,
}

impl Quiver {
    fn new(length: f64) -> Self {
        // As many digits as are written, so that what is written is where the arrows go.
        Self { unit: ((length * 200.0).round() / 10_000.0).max(0.0001) }
    }

    /// Opens the group that the arrows' paths belong in.
    fn open(self, sheet: &mut Sheet) {
        sheet.open("g", &format!("transform=\"scale({})\"", Number(self.unit)));
    }

    /// The path of arrows towards `direction` with their middles at the points (x, y).
    fn path(self, direction: Direction, at: impl IntoIterator<Item = (f64, f64)>) -> String {
        let mut path = String::new();
        let mut pen = (0, 0);
        for (x, y) in at {
            let (x, y) = ((x / self.unit).round() as i64, (y / self.unit).round() as i64);
            // The pen is where the last arrow began.
            let _ = write!(path, "m{}{}{}", x - pen.0, Next(y - pen.1), arrow(direction));
            pen = (x, y);
        }
        path
    }
}

/// A number after another one: with a space unless a minus parts them.
struct Next(i64);

impl std::fmt::Display for Next {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.0 < 0 { write!(f, "{}", self.0) } else { write!(f, " {}", self.0) }
    }
}

/// Outline of an arrow 50 units long towards `direction`, from its middle and back; north is up on the
/// sheet.
fn arrow(direction: Direction) -> String {
    let (dx, dy) = direction.step();
    let (ahead, aside) = ((i64::from(dx), i64::from(-dy)), (i64::from(dy), i64::from(dx)));
    let corners = [(-25, 4), (4, 4), (4, 13), (25, 0), (4, -13), (4, -4), (-25, -4), (-25, 0)];
    let mut path = String::new();
    let mut pen = (0, 0);
    // The first stroke runs inside the outline to its tail: filled, it does not show.
    for (along, across) in std::iter::once((-25, 0)).chain(corners) {
        let at = (along * ahead.0 + across * aside.0, along * ahead.1 + across * aside.1);
        let _ = match (at.0 - pen.0, at.1 - pen.1) {
            (along_x, 0) => write!(path, "h{along_x}"),
            (0, along_y) => write!(path, "v{along_y}"),
            (along_x, along_y) => write!(path, "l{along_x}{}", Next(along_y)),
        };
        pen = at;
    }
    path.push('z');
    path
}

/// Where the plot lies on the sheet.
#[derive(Clone, Copy, Debug)]
struct Frame {
    left: f64,
    top: f64,
    width: f64,
    height: f64,
    /// Units of the sheet per cell.
    pitch: f64,
    /// Number of the plot on its sheet, from 0.
    place: usize,
    /// The plot whose ground this one shares, if an earlier one has the same.
    ground: Option<usize>,
}

impl Frame {
    /// A frame of `side` for `grid`, at the origin.
    fn of(grid: &Grid, side: f64) -> Self {
        let (columns, rows) = (f64::from(grid.width), f64::from(grid.height));
        let pitch = side / columns.max(rows);
        let (width, height) = ((columns * pitch).max(FRAME_MIN), (rows * pitch).max(FRAME_MIN));
        Self { left: 0.0, top: 0.0, width, height, pitch, place: 0, ground: None }
    }

    /// An id that no other plot on the sheet has.
    fn id(&self, name: &str) -> String {
        format!("{name}-{}", self.place)
    }

    /// Centre of `cell` on the sheet; a cell outside of the grid is drawn in the first row beyond it.
    fn centre(&self, cell: Cell) -> (f64, f64) {
        let beyond = 9.0;
        let x = self.left + (f64::from(cell.x) + 0.5) * self.pitch;
        let y = self.top + self.height - (f64::from(cell.y) + 0.5) * self.pitch;
        (
            x.clamp(self.left - beyond, self.left + self.width + beyond),
            y.clamp(self.top - beyond, self.top + self.height + beyond),
        )
    }
}

/// Which sides of a plot have numbers.
#[derive(Clone, Copy, Debug)]
struct Numbered {
    left: bool,
    below: bool,
}

fn axes(sheet: &mut Sheet, frame: &Frame, grid: &Grid, numbered: Numbered) {
    let Frame { left, top, width, height, pitch, .. } = *frame;
    let bottom = top + height;
    sheet.raw(&format!(
        "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#333\"/>",
        Number(left),
        Number(top),
        Number(width),
        Number(height)
    ));
    let reach = |cells: u32| Range { min: 0.0, max: f64::from(cells - 1) * grid.cell_size_m };
    let mut strokes = String::new();
    let room = |cells: u32| ((f64::from(cells) * pitch / 40.0) as usize).clamp(2, 10);
    let east = Ticks::over(reach(grid.width), room(grid.width));
    for (at_m, label) in east.labels() {
        let x = left + (at_m / grid.cell_size_m + 0.5) * pitch;
        let _ = write!(strokes, "M{} {}v6", Number(x), Number(bottom));
        if numbered.below {
            sheet.text(x, bottom + 21.0, "text-anchor=\"middle\"", &label);
        }
    }
    let north = Ticks::over(reach(grid.height), room(grid.height));
    for (at_m, label) in north.labels() {
        let y = bottom - (at_m / grid.cell_size_m + 0.5) * pitch;
        let _ = write!(strokes, "M{} {}h-6", Number(left), Number(y));
        if numbered.left {
            sheet.text(left - 10.0, y + 4.5, "text-anchor=\"end\"", &label);
        }
    }
    sheet.path(&strokes, "stroke=\"#333\"");
    if numbered.below {
        sheet.text(
            left + width / 2.0,
            bottom + 42.0,
            "text-anchor=\"middle\" font-size=\"14\"",
            "x, east (m)",
        );
    }
    if numbered.left {
        sheet.text_upwards(left - 52.0, top + height / 2.0, "y, north (m)");
    }
}

fn colour_bar(sheet: &mut Sheet, frame: &Frame, heights: Range) {
    let (left, top, width, height) = (frame.left + frame.width + 24.0, frame.top, 18.0, frame.height);
    for shade in 0..SHADES {
        let step = height / SHADES as f64;
        let y = top + height - step * (shade + 1) as f64;
        let colour = colour::height((shade as f64 + 0.5) / SHADES as f64);
        // Half a unit of overlap hides the seams of antialiasing.
        let overlap = if shade == 0 { 0.0 } else { 0.5 };
        sheet.raw(&format!(
            "<rect x=\"{}\" y=\"{}\" width=\"{width}\" height=\"{}\" fill=\"{colour}\"/>",
            Number(left),
            Number(y),
            Number(step + overlap)
        ));
    }
    sheet.raw(&format!(
        "<rect x=\"{}\" y=\"{}\" width=\"{width}\" height=\"{}\" fill=\"none\" stroke=\"#333\"/>",
        Number(left),
        Number(top),
        Number(height)
    ));
    let mut strokes = String::new();
    for (height_m, label) in Ticks::over(heights, 8).labels() {
        let y = top + height * (1.0 - heights.normalise(height_m));
        let _ = write!(strokes, "M{} {}h5", Number(left + width), Number(y));
        sheet.text(left + width + 9.0, y + 4.5, "", &label);
    }
    sheet.path(&strokes, "stroke=\"#333\"");
    sheet.text_upwards(
        frame.left + frame.width + MARGIN_RIGHT - 12.0,
        top + height / 2.0,
        "height above datum (m)",
    );
}
