//! The observed map in characters, with routes, robots and goals on it.

use contract::{Account, Action, Branch, Brief, Cell, Decision, Direction, Robot, RobotId, Waypoint};
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Color, Modifier, Style};

use monitor::History;
use monitor::history::{Details, Hop, Seen, SeenCells};
use report::Layer;
use report::colour;
use report::layers::Look;
use report::way;

use crate::ViewSettings;
use crate::layer::{ink, texture, visits};
use crate::moment::{goal, hop_before, pose};
use crate::style::DIM;

/// The map in characters: each character pair stands for one cell or a square of cells.
pub(crate) struct View<'a> {
    history: &'a History,
    ground: &'a SeenCells,
    at: Decision,
    /// Cells along the side of a character pair.
    stride: i32,
    /// Character pairs along the side of a cell, where the terminal has room for several.
    zoom: i32,
    /// Upper left cell of the upper left character pair.
    corner: Cell,
    places: (i32, i32),
    policy: bool,
    heights_m: (f32, f32),
    /// Number of robots; with more than one each is shown by its number.
    robots: u16,
    layer: Layer,
    /// How often each cell was visited, where visits are shown.
    visits: Vec<u16>,
}

impl<'a> View<'a> {
    pub(crate) fn of(history: &'a History, settings: &ViewSettings, area: Rect) -> Option<Self> {
        let (brief, ground) = (history.brief()?, history.seen_cells()?);
        let (width, height) = (brief.grid.width as i32, brief.grid.height as i32);
        let (columns, rows) = (i32::from(area.width) / 2, i32::from(area.height));
        let whole = ((width + columns - 1) / columns).max((height + rows - 1) / rows);
        let stride = if settings.follow { 1 } else { whole };
        let zoom = if settings.follow { 1 } else { (columns / width).min(rows / height).clamp(1, ZOOM_MAX) };
        let at = settings.shown(history.hops()?.due());
        let places = (columns.min((width + stride - 1) / stride), rows.min((height + stride - 1) / stride));
        let pose = pose(history, at)?;
        let from = |centre: i32, shown: i32, side: i32| (centre - shown / 2).clamp(0, (side - shown).max(0));
        let left = from(pose.x, places.0 * stride, width);
        let bottom = from(pose.y, places.1 * stride, height);
        let commands = hop_before(history, at).map(|hop| (hop.robot, hop.term));
        let mut changes = history.hops()?.leader_changes();
        let change = changes.find(|change| Some((change.robot, change.term)) == commands);
        let policy = history
            .policy()
            .is_some_and(|policy| change.is_none_or(|change| change.planner == policy.planner));
        Some(Self {
            history,
            ground,
            at,
            stride,
            zoom,
            corner: Cell::new(left, bottom + places.1 * stride - 1),
            places,
            policy: settings.policy && stride == 1 && policy,
            heights_m: ground.heights_m().unwrap_or((0.0, 1.0)),
            robots: brief.robots.count(),
            layer: settings.layer(brief),
            visits: match settings.layer(brief).definition().look {
                Look::Entries => visits(&brief.grid, history.hops()?, at),
                Look::Relief | Look::Scale(_) => Vec::new(),
            },
        })
    }

    pub(crate) fn draw(&self, frame: &mut Frame<'_>, area: Rect) {
        let zoom = self.zoom;
        let (indent, drop) = (
            (area.width as i32 - 2 * zoom * self.places.0) / 2,
            (area.height as i32 - zoom * self.places.1) / 2,
        );
        let mut symbols = vec![None; (self.places.0 * self.places.1) as usize];
        self.symbols(&mut symbols);
        let buffer = frame.buffer_mut();
        for row in 0..self.places.1 {
            for column in 0..self.places.0 {
                let cell = Cell::new(self.corner.x + column * self.stride, self.corner.y - row * self.stride);
                let (mut text, mut style) = self.ground_at(cell);
                if let Some((symbol, (ink, ground))) = symbols[(row * self.places.0 + column) as usize] {
                    text = symbol;
                    style = style.fg(ink).add_modifier(Modifier::BOLD);
                    style = ground.map_or(style, |ground| style.bg(ground));
                }
                // What fills a cell fills all of it; a sign stands once, near its middle.
                let (fill, middle) = (if is_texture(text) { text } else { "  " }, (zoom - 1) / 2);
                for (across, down) in (0..zoom).flat_map(|down| (0..zoom).map(move |across| (across, down))) {
                    let text = if (across, down) == (middle, middle) { text } else { fill };
                    let (x, y) = (indent + 2 * (zoom * column + across), drop + zoom * row + down);
                    buffer.set_string(area.x + x as u16, area.y + y as u16, text, style);
                }
            }
        }
    }

    /// Symbols of route, stray hops, start, treasures, goals and hopper; later ones replace earlier ones.
    fn symbols(&self, symbols: &mut [Option<(&'static str, Paint)>]) {
        let mut put = |cell: Cell, symbol: &'static str, paint: Paint| {
            let (dx, dy) = (cell.x - self.corner.x, self.corner.y - cell.y);
            let (column, row) = (dx.div_euclid(self.stride), dy.div_euclid(self.stride));
            if (0..self.places.0).contains(&column) && (0..self.places.1).contains(&row) {
                symbols[(row * self.places.0 + column) as usize] = Some((symbol, paint));
            }
        };
        let (Some(brief), Some(hops)) = (self.history.brief(), self.history.hops()) else { return };
        self.travels(brief, &mut put);
        let flown = (self.at.0.saturating_sub(hops.first().0)) as usize;
        // Of goals visited in turn only the current leg and the one before are shown.
        let visits = hop_before(self.history, self.at).map_or(0, |hop| hop.visits);
        let is_shown = |hop: &&Hop| {
            hop.visits + 1 >= visits && (self.robots == 1 || !has_ways(brief) || hop.robot.0 == 0)
        };
        let shown = || hops.from(hops.first()).take(flown).filter(is_shown);
        self.impacts(brief, &mut put);
        for hop in shown() {
            put(hop.from, "• ", ROUTE);
            if hop.branch == Branch::Intended {
                put(hop.to, "• ", ROUTE);
            }
        }
        // After all of the route: the next hop begins where a stray one ended.
        for hop in shown() {
            match hop.branch {
                Branch::Left | Branch::Right | Branch::Elsewhere | Branch::RolledAway => {
                    put(hop.to, "× ", STRAY);
                }
                Branch::Stayed | Branch::Stranded => put(hop.to, "o ", STRAY),
                Branch::Intended | Branch::Held | Branch::Halted => {}
            }
        }
        if brief.account == Account::Hopper {
            put(brief.robots[0].start.cell, "S ", START);
            for treasure in self.history.treasures(self.at) {
                put(treasure, "✦ ", TREASURE);
            }
            for &goal in brief.visits().iter().flat_map(|visit| visit.goals()) {
                put(goal, "☆ ", LATER_GOAL);
            }
            if let Some(goal) = goal(self.history, brief, self.at) {
                put(goal, "★ ", GOAL);
            }
        }
        if self.robots > 1 {
            for (robot, cell) in self.robot_cells() {
                put(cell, ROBOT_NUMBERS[robot % ROBOT_NUMBERS.len()], robot_paint(robot));
            }
        } else if let Some(cell) = pose(self.history, self.at) {
            put(cell, "@ ", HOPPER);
        }
    }

    /// Where bodies hit the ground before the moment that is shown. Departures and landings cover them.
    fn impacts(&self, brief: &Brief, put: &mut impl FnMut(Cell, &'static str, Paint)) {
        let told = self.history.details().into_iter().flat_map(Details::iter);
        for told in told.filter(|told| told.decision < self.at) {
            for [x_m, y_m, _] in way::impacts(&told.detail) {
                put(Waypoint { x_m, y_m }.cell_of(&brief.grid), "◇ ", IMPACT);
            }
        }
    }

    /// What robots see, their routes, and where they have been; what is drawn later covers what was drawn before.
    fn travels(&self, brief: &Brief, put: &mut impl FnMut(Cell, &'static str, Paint)) {
        let (Some(hops), Some(routes)) = (self.history.hops(), self.history.announcements()) else { return };
        if !has_ways(brief) {
            return;
        }
        let middle = |cell| Waypoint::middle_of(&brief.grid, cell);
        let mut line = |from: Waypoint, to: Waypoint, symbol, paint| {
            let steps = (from.distance_m(to) / brief.grid.cell_size_m).ceil().clamp(1.0, 4096.0) as u32;
            for step in 0..=steps {
                let share = f64::from(step) / f64::from(steps);
                let along = |from: f64, to: f64| from + (to - from) * share;
                let point = Waypoint { x_m: along(from.x_m, to.x_m), y_m: along(from.y_m, to.y_m) };
                put(point.cell_of(&brief.grid), symbol, paint);
            }
        };
        for (robot, cell) in self.robot_cells() {
            let (at, paint) = (middle(cell), (robot_paint(robot).1.unwrap_or(BLACK), Some(BLACK)));
            let view_m = brief.robots.get(robot).and_then(|robot| robot.sensor.view_m());
            let on_rim = |n: u32, view_m: f64| {
                let (sine, cosine) = (std::f64::consts::TAU * f64::from(n) / 64.0).sin_cos();
                Waypoint { x_m: at.x_m + view_m * cosine, y_m: at.y_m + view_m * sine }
            };
            for n in 0..64 * u32::from(view_m.is_some()) {
                let (from, to) = (on_rim(n, view_m.unwrap_or(0.0)), on_rim(n + 1, view_m.unwrap_or(0.0)));
                line(from, to, "∘ ", paint);
            }
            let route = routes.of(RobotId(robot as u16), self.at);
            for leg in route.map_or(&[][..], |announced| announced.route.waypoints()).windows(2) {
                line(leg[0], leg[1], "+ ", paint);
            }
        }
        let flown = (self.at.0.saturating_sub(hops.first().0)) as usize;
        for hop in hops.from(hops.first()).take(flown) {
            // A hopper's own way is drawn hop by hop.
            let is_drawn = hop.from != hop.to && !(brief.account == Account::Hopper && hop.robot.0 == 0);
            if is_drawn {
                let paint = robot_paint(hop.robot.0.into());
                line(middle(hop.from), middle(hop.to), "• ", paint);
            }
        }
        // The goals of a mission's hopper are drawn last, by the caller.
        let others = if brief.account == Account::Hopper { 1 } else { 0 };
        for robot in &brief.robots[others..] {
            let goals = robot.goal.cells(&brief.grid);
            if robot.body.drives() && !goals.is_empty() {
                put(robot.start_at.cell_of(&brief.grid), "S ", START);
            }
            for goal in goals {
                put(goal, "★ ", GOAL);
            }
        }
    }

    /// Where each robot stood at the moment that is shown, as far as it is known.
    fn robot_cells(&self) -> Vec<(usize, Cell)> {
        let Some(hops) = self.history.hops() else { return Vec::new() };
        let members = self.history.progress().map_or(&[][..], |progress| &progress.robots);
        let flown = (self.at.0.saturating_sub(hops.first().0)) as usize;
        let of_robot = |robot: usize| {
            let own = |hop: &&Hop| usize::from(hop.robot.0) == robot;
            let before = hops.from(hops.first()).take(flown).rev().find(own).map(|hop| hop.to);
            let later = || hops.from(hops.first()).find(own).map(|hop| hop.from);
            before.or_else(later).or_else(|| members.get(robot).map(|member| member.at.cell))
        };
        (0..usize::from(self.robots)).filter_map(|robot| Some((robot, of_robot(robot)?))).collect()
    }

    /// What the layer shows of a cell, as a share of its scale; `None` if it has none, or nothing to show there.
    fn share(&self, index: usize, seen: Option<&Seen>) -> Option<f64> {
        let most = self.layer.scale()?.most;
        Some(self.history.value(self.layer, index, seen)? / most)
    }

    /// Text and style of a character pair without symbols: policy arrow, impassable, sand, or height alone.
    fn ground_at(&self, cell: Cell) -> (&'static str, Style) {
        let middle = Cell::new(cell.x + self.stride / 2, cell.y - self.stride / 2);
        let grid = self.history.brief().map(|brief| brief.grid);
        let index = grid.and_then(|grid| grid.index(middle).or_else(|| grid.index(cell)));
        let seen =
            index.and_then(|index| self.ground.get(index)).filter(|seen| u64::from(seen.at) <= self.at.0);
        if let Some(share) = index.and_then(|index| self.share(index, seen)) {
            let [r, g, b] = self.layer.colour(share);
            let style = Style::new().bg(Color::Rgb(r, g, b)).fg(ink([r, g, b]));
            return (texture(self.layer, share, seen.is_some()), style);
        }
        let Some(seen) = seen else { return ("· ", DIM) };
        if let Some(count) = index.and_then(|index| self.visits.get(index)).filter(|count| **count > 0) {
            let share = (0.28 + 0.17 * f64::from(count - 1)).min(0.9);
            let ground = mixed(colour::height_rgb(0.5), colour::rgb(colour::ROUTE), share);
            let [r, g, b] = ground;
            return (
                VISITS[usize::from(*count).min(VISITS.len()) - 1],
                Style::new().bg(Color::Rgb(r, g, b)).fg(ground_ink(ground)),
            );
        }
        let style = Style::new().bg(shade(seen.height_m, self.heights_m, seen.sand)).fg(Color::Black);
        let arrow = match index {
            Some(index) if self.policy => self.history.policy().and_then(|policy| policy.cells.get(index)),
            _ => None,
        };
        match arrow.map(|cell| cell.action) {
            Some(Action::Hop(direction) | Action::Up(direction)) => (arrow_on(direction, seen.sand), style),
            _ if !seen.passable => ("##", style),
            _ if seen.sand => ("░░", style),
            _ => ("  ", style),
        }
    }
}

/// Most character pairs along the side of a cell.
const ZOOM_MAX: i32 = 4;

/// Whether a character pair is a shade of its ground, and no sign on it.
fn is_texture(text: &str) -> bool {
    text.chars().all(|character| "█▓▒░#".contains(character))
}

/// Whether each robot's way is drawn in its colour: not of a lone hopper, nor where all robots cover ground.
pub(crate) fn has_ways(brief: &Brief) -> bool {
    let covers = |robot: &Robot| robot.goal.cover().is_some();
    brief.has_team() && !brief.robots.iter().all(covers)
}

/// Cells that were visited once, twice, and so on.
const VISITS: [&str; 4] = ["∙ ", ": ", "∴ ", "∷ "];

/// Dark or light ink, whichever stands out.
fn ground_ink(ground: [u8; 3]) -> Color {
    let [dark, light] = [[17, 17, 17], [255, 255, 255]].map(|ink| colour::contrast(ink, ground));
    if dark >= light { BLACK } else { WHITE }
}

/// An arrow on hard ground or on sand; the two differ without colour too.
fn arrow_on(direction: Direction, sand: bool) -> &'static str {
    match (direction, sand) {
        (Direction::North, false) => "↑ ",
        (Direction::East, false) => "→ ",
        (Direction::South, false) => "↓ ",
        (Direction::West, false) => "← ",
        (Direction::North, true) => "↑░",
        (Direction::East, true) => "→░",
        (Direction::South, true) => "↓░",
        (Direction::West, true) => "←░",
    }
}

/// Background colour: that of the pictures by height, greyer on sand.
fn shade(height_m: f32, (low, high): (f32, f32), sand: bool) -> Color {
    let share = ((height_m - low) / (high - low).max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
    let rgb = colour::height_rgb(f64::from(share));
    let [r, g, b] = if sand { mixed(rgb, [125, 130, 136], 0.4) } else { rgb };
    Color::Rgb(r, g, b)
}

/// `share` of `other` in `colour`.
fn mixed(colour: [u8; 3], other: [u8; 3], share: f64) -> [u8; 3] {
    let band = |n: usize| ((1.0 - share) * f64::from(colour[n]) + share * f64::from(other[n])).round() as u8;
    [band(0), band(1), band(2)]
}

/// Ink of a symbol, and the ground it stands on where that of the map would not set it off.
type Paint = (Color, Option<Color>);

const BLACK: Color = Color::Rgb(17, 17, 17);
pub(crate) const WHITE: Color = Color::Rgb(255, 255, 255);
const ROUTE: Paint = (BLACK, None);
const IMPACT: Paint = (BLACK, None);
const STRAY: Paint = (Color::Rgb(227, 0, 15), Some(WHITE));
const START: Paint = (WHITE, Some(Color::Rgb(31, 111, 224)));
const TREASURE: Paint = (BLACK, Some(Color::Rgb(255, 196, 0)));
const GOAL: Paint = (WHITE, Some(Color::Rgb(227, 0, 15)));
const LATER_GOAL: Paint = (WHITE, Some(Color::Rgb(110, 60, 62)));
const HOPPER: Paint = (BLACK, Some(Color::Rgb(255, 212, 0)));

/// A robot by its number.
pub(crate) const ROBOT_NUMBERS: [&str; 16] =
    ["0 ", "1 ", "2 ", "3 ", "4 ", "5 ", "6 ", "7 ", "8 ", "9 ", "10", "11", "12", "13", "14", "15"];

/// A robot's colour; the same as on the page.
pub(crate) fn robot_paint(robot: usize) -> Paint {
    let [r, g, b] = colour::ROBOTS[robot % colour::ROBOTS.len()];
    (BLACK, Some(Color::Rgb(r, g, b)))
}
