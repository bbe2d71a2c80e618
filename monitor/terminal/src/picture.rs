//! Draws the history of a mission in a terminal, the map in characters.

use contract::{
    Action, Branch, Brief, Cell, Decision, Direction, Member, MonotonicNs, Origin, Policy, RobotId, Role,
    Stage, Waypoint,
};
use ratatui::Frame;
use ratatui::layout::{Alignment, Constraint, Flex, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Clear, Paragraph};

use monitor::History;
use monitor::history::{Hop, LeaderChange, PeerChange, Seen, SeenCells};
use report::picture::colour;

use crate::Layer;
use crate::layer::{ink, visits};

/// Smallest width of the terminal, columns.
pub const COLUMNS_MIN: u16 = 80;

/// Smallest height of the terminal, rows.
pub const ROWS_MIN: u16 = 24;

/// Colours of the stages, in the order of [`Stage::ALL`]; colour-blind readers can distinguish them.
const STAGES: [Color; 7] = [
    Color::Rgb(133, 147, 163),
    Color::Rgb(86, 180, 233),
    Color::Rgb(47, 127, 208),
    Color::Rgb(161, 139, 240),
    Color::Rgb(230, 161, 23),
    Color::Rgb(23, 168, 129),
    Color::Rgb(208, 127, 174),
];

/// Characters of the stages' bars, so that stages differ without colours too.
const TEXTURES: [&str; 7] = ["█", "▓", "▒", "░", "▞", "▤", "▥"];

const DIM: Style = Style::new().add_modifier(Modifier::DIM);
const BOLD: Style = Style::new().add_modifier(Modifier::BOLD);
const BAD: Style = Style::new().fg(Color::Red);
const GOOD: Style = Style::new().fg(Color::Green);
const AMBER: Color = Color::Rgb(240, 166, 58);

/// Number of hops that are searched for interventions of the guard.
const GUARDED_HOPS: u64 = 1024;

/// What the user has chosen to see.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct ViewSettings {
    /// Decision to look back at; `None` follows the mission.
    pub at: Option<Decision>,
    /// Whether to show the policy if the planner in command has one.
    pub policy: bool,
    /// Whether to show the map around the hopper, one cell per character pair, rather than all of it.
    pub follow: bool,
    /// Whether orders are allowed.
    pub control: bool,
    /// Whether to show what each key does.
    pub keys: bool,
    /// What the ground shows; `None` shows what suits the mission.
    pub layer: Option<Layer>,
}

impl ViewSettings {
    /// The decision that is shown if decision `due` is due.
    #[must_use]
    pub fn shown(&self, due: Decision) -> Decision {
        self.at.map_or(due, |at| at.min(due))
    }

    /// Back by one: from the keys to the mission, from an earlier hop to now.
    pub fn back(&mut self) {
        if self.keys {
            self.keys = false;
        } else {
            self.at = None;
        }
    }

    /// The layer that is shown of the mission: if none was chosen, the expected speed where speeds are uncertain, visits where
    /// ground is covered, else heights.
    #[must_use]
    pub fn layer(&self, brief: &Brief) -> Layer {
        let suits = |layer: &Layer| Layer::of(brief).contains(layer);
        self.layer.filter(suits).unwrap_or_else(|| Layer::first(brief))
    }

    /// Goes on to the next layer that the mission has.
    pub fn next_layer(&mut self, brief: &Brief) {
        let layers = Layer::of(brief);
        let at = layers.iter().position(|layer| *layer == self.layer(brief)).unwrap_or(0);
        self.layer = Some(layers[(at + 1) % layers.len()]);
    }

    /// Moves by `by` hops, back if negative; at the end of the history the view follows the mission again.
    pub fn go(&mut self, by: i64, due: Decision) {
        let to = self.shown(due).0.saturating_add_signed(by);
        self.at = (to < due.0).then_some(Decision(to));
    }
}

/// Draws the history at `now`.
pub fn draw(frame: &mut Frame<'_>, history: &History, settings: &ViewSettings, now: MonotonicNs) {
    let area = frame.area();
    if area.width < COLUMNS_MIN || area.height < ROWS_MIN {
        let text = format!("needs {COLUMNS_MIN} x {ROWS_MIN}, got {} x {}", area.width, area.height);
        frame.render_widget(Paragraph::new(text).alignment(Alignment::Center), area);
        return;
    }
    let [head, body, foot] =
        Layout::vertical([Constraint::Length(1), Constraint::Fill(1), Constraint::Length(1)]).areas(area);
    frame.render_widget(heading(history, settings), head);
    frame.render_widget(keys(settings, history), foot);
    let [left, right] = Layout::horizontal([Constraint::Fill(1), Constraint::Length(38)]).areas(body);
    let shown = history.brief().map(|brief| settings.layer(brief)).unwrap_or_default();
    let around = match history.brief() {
        Some(brief) if !brief.is_of_hopper() => ", around the robot ",
        _ => ", around the hopper ",
    };
    let title = format!(" {}{}", shown.title(), if settings.follow { around } else { " " });
    let mut block = Block::bordered().border_style(DIM).title(title);
    if let Some(legend) = shown.legend() {
        block = block.title_bottom(legend);
    }
    let inside = block.inner(left);
    frame.render_widget(block, left);
    if let Some(view) = View::of(history, settings, inside) {
        view.draw(frame, inside);
    }
    frame.render_widget(Paragraph::new(side(history, settings, now, right)), right);
    if settings.keys {
        let [across] = Layout::horizontal([Constraint::Length(62)]).flex(Flex::Center).areas(body);
        let [panel] =
            Layout::vertical([Constraint::Length(KEYS.len() as u16 + 2)]).flex(Flex::Center).areas(across);
        let lines =
            KEYS.map(|(key, does)| Line::from(vec![Span::styled(format!(" {key:<15}"), BOLD), does.into()]));
        frame.render_widget(Clear, panel);
        frame.render_widget(Paragraph::new(lines.to_vec()).block(Block::bordered().title(" keys ")), panel);
    }
}

/// What each key does; those of the page that a terminal has use for.
const KEYS: [(&str, &str); 10] = [
    ("← →", "one hop back or ahead"),
    ("Page Up, Down", "ten hops back or ahead"),
    ("Home, End", "first hop; now"),
    ("P", "policy arrows"),
    ("M", "next map layer, where there are several"),
    ("F", "follow the robot, or the whole map"),
    ("Esc", "back to now"),
    ("Space, S, H", "pause, single step, hand over (--control)"),
    ("?", "these keys"),
    ("Q", "quit"),
];

fn heading(history: &History, settings: &ViewSettings) -> Line<'static> {
    let mut line = vec![Span::styled(" Hopper ", BOLD.fg(AMBER))];
    let Some(brief) = history.brief() else {
        line.push(Span::raw("waiting for a mission"));
        return line.into();
    };
    let due = history.hops().map_or(Decision(0), |hops| hops.due());
    let at = settings.shown(due);
    let status = history.progress().map(|progress| progress.status);
    let paused = history.pacing().is_some_and(|pacing| pacing.paused);
    let (word, style) = match status {
        Some(status) if status.is_over() => {
            (status.to_string(), if status == contract::Status::Goal { GOOD } else { BAD })
        }
        _ if settings.at.is_some() => ("looking back".to_owned(), BOLD.fg(AMBER)),
        _ if paused => ("paused".to_owned(), BOLD.fg(AMBER)),
        _ => match history.lacking() {
            Some(role) => (format!("waiting for hopper {role}"), BOLD.fg(AMBER)),
            None => ("under way".to_owned(), GOOD),
        },
    };
    line.push(Span::raw(format!("{} · {} ", brief.scenario, brief.profile)));
    line.push(Span::styled(format!("● {word} "), style));
    let before = hop_before(history, at);
    let count = match brief.patrol {
        None => format!("step {}/{}", before.map_or(0, |hop| hop.steps), brief.limits.steps_max),
        Some(_) => format!("goals visited {}", before.map_or(0, |hop| hop.visits)),
    };
    let pace = history.pacing().map_or_else(String::new, |pacing| format!(" · pace {}", pacing.pace));
    line.push(Span::raw(format!("{} {at} of {due} · {count}{pace}", noun(history))));
    line.into()
}

fn keys(settings: &ViewSettings, history: &History) -> Line<'static> {
    let has_layers = history.brief().is_some_and(|brief| Layer::of(brief).len() > 1);
    let layer = if has_layers { "  m layer" } else { "" };
    let view = format!(" ? keys  q quit  ←→ PgUp PgDn Home End  p policy{layer}");
    let obeys = history.pacing().is_none_or(|pacing| pacing.obeys);
    let control = match (settings.control, obeys) {
        (true, true) => "  space pause  s step  h hand",
        // hopper-sim was started without --control; planners obey all the same.
        (true, false) => "  h hand",
        (false, _) => "",
    };
    Line::styled(format!("{view}{control}"), DIM)
}

fn hop_before(history: &History, at: Decision) -> Option<&Hop> {
    history.hops()?.get(Decision(at.0.checked_sub(1)?))
}

/// The map in characters: each character pair stands for one cell or a square of cells.
struct View<'a> {
    history: &'a History,
    ground: &'a SeenCells,
    at: Decision,
    /// Cells along the side of a character pair.
    stride: i32,
    /// Upper left cell of the upper left character pair.
    corner: Cell,
    places: (i32, i32),
    policy: bool,
    heights_m: (f32, f32),
    /// Number of robots; with more than one each is shown by its number.
    robots: u16,
    layer: Layer,
    /// Of each cell, where visits are shown.
    visits: Vec<u16>,
}

impl<'a> View<'a> {
    fn of(history: &'a History, settings: &ViewSettings, area: Rect) -> Option<Self> {
        let (brief, ground) = (history.brief()?, history.seen_cells()?);
        let (width, height) = (brief.grid.width as i32, brief.grid.height as i32);
        let (columns, rows) = (i32::from(area.width) / 2, i32::from(area.height));
        let whole = ((width + columns - 1) / columns).max((height + rows - 1) / rows);
        let stride = if settings.follow { 1 } else { whole };
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
            corner: Cell::new(left, bottom + places.1 * stride - 1),
            places,
            policy: settings.policy && stride == 1 && policy,
            heights_m: ground.heights_m().unwrap_or((0.0, 1.0)),
            robots: brief.robots,
            layer: settings.layer(brief),
            visits: match settings.layer(brief) {
                Layer::Visits => visits(&brief.grid, history.hops()?, at),
                _ => Vec::new(),
            },
        })
    }

    fn draw(&self, frame: &mut Frame<'_>, area: Rect) {
        let (indent, drop) =
            ((area.width as i32 - 2 * self.places.0) / 2, (area.height as i32 - self.places.1) / 2);
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
                let (x, y) = (area.x + (indent + 2 * column) as u16, area.y + (drop + row) as u16);
                buffer.set_string(x, y, text, style);
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
        // On a patrol only the current leg and the one before are shown.
        let visits = hop_before(self.history, self.at).map_or(0, |hop| hop.visits);
        let is_shown = |hop: &&Hop| {
            hop.visits + 1 >= visits && (self.robots == 1 || !brief.has_routes() || hop.robot.0 == 0)
        };
        let shown = || hops.from(hops.first()).take(flown).filter(is_shown);
        for hop in shown() {
            put(hop.from, "• ", ROUTE);
            if hop.branch == Branch::Intended {
                put(hop.to, "• ", ROUTE);
            }
        }
        // After all of the route: the next hop begins where a stray one ended.
        for hop in shown() {
            match hop.branch {
                Branch::Left | Branch::Right => put(hop.to, "× ", STRAY),
                Branch::Stayed | Branch::Stranded => put(hop.to, "o ", STRAY),
                Branch::Intended | Branch::Held | Branch::Halted => {}
            }
        }
        if brief.is_of_hopper() {
            put(brief.start, "S ", START);
            for treasure in self.history.treasures(self.at) {
                put(treasure, "✦ ", TREASURE);
            }
            for &goal in brief.patrol.iter().flat_map(|patrol| patrol.goals()) {
                put(goal, "☆ ", LATER_GOAL);
            }
            put(goal(self.history, brief, self.at), "★ ", GOAL);
        }
        if self.robots > 1 {
            for (robot, cell) in self.robot_cells() {
                put(cell, ROBOT_NUMBERS[robot % ROBOT_NUMBERS.len()], robot_paint(robot));
            }
        } else if let Some(cell) = pose(self.history, self.at) {
            put(cell, "@ ", HOPPER);
        }
    }

    /// Where robots that announce routes look, will go, and have gone; later ones replace earlier ones.
    fn travels(&self, brief: &Brief, put: &mut impl FnMut(Cell, &'static str, Paint)) {
        let (Some(hops), Some(routes)) = (self.history.hops(), self.history.announcements()) else { return };
        let members = self.history.progress().map_or(&[][..], |progress| &progress.robots);
        if !brief.has_routes() {
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
            let view_m = members.get(robot).and_then(|member| member.robot.sensor.view_m());
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
            let is_drawn = hop.from != hop.to && !(brief.is_of_hopper() && hop.robot.0 == 0);
            if is_drawn {
                let paint = robot_paint(hop.robot.0.into());
                line(middle(hop.from), middle(hop.to), "• ", paint);
            }
        }
        for member in members {
            match member.robot.vehicle {
                contract::Vehicle::Driver { start, goal, .. } => {
                    put(start.cell_of(&brief.grid), "S ", START);
                    put(goal.cell_of(&brief.grid), "★ ", GOAL);
                }
                contract::Vehicle::HopperTo { goal } => put(goal, "★ ", GOAL),
                _ => {}
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

    /// What the layer shows of a cell, as a share of its scale; `None` if it shows heights or visits.
    fn share(&self, index: usize, seen: Option<&Seen>) -> Option<f64> {
        let (speed, reading) = seen.map_or((None, None), |seen| (seen.speed, seen.reading));
        self.layer.share(self.history.speeds()?.estimate(index, speed, reading)?)
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
            return (self.layer.texture(share, seen.is_some()), style);
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
        let arrow = index.filter(|_| self.policy).and_then(|index| self.history.policy()?.cells.get(index));
        match arrow.map(|cell| cell.action) {
            Some(Action::Hop(direction)) => (arrow_on(direction, seen.sand), style),
            _ if !seen.passable => ("##", style),
            _ if seen.sand => ("░░", style),
            _ => ("  ", style),
        }
    }
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

/// The goal of the leg being flown when a decision was due.
fn goal(history: &History, brief: &Brief, at: Decision) -> Cell {
    brief.leg(hop_before(history, at).map_or(0, |hop| hop.visits)).goal
}

fn pose(history: &History, at: Decision) -> Option<Cell> {
    let start = history.brief()?.start;
    Some(hop_before(history, at).map_or(start, |hop| hop.to))
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
const WHITE: Color = Color::Rgb(255, 255, 255);
const ROUTE: Paint = (BLACK, None);
const STRAY: Paint = (Color::Rgb(227, 0, 15), Some(WHITE));
const START: Paint = (WHITE, Some(Color::Rgb(31, 111, 224)));
const TREASURE: Paint = (BLACK, Some(Color::Rgb(255, 196, 0)));
const GOAL: Paint = (WHITE, Some(Color::Rgb(227, 0, 15)));
const LATER_GOAL: Paint = (WHITE, Some(Color::Rgb(110, 60, 62)));
const HOPPER: Paint = (BLACK, Some(Color::Rgb(255, 212, 0)));

/// A robot by its number.
const ROBOT_NUMBERS: [&str; 16] =
    ["0 ", "1 ", "2 ", "3 ", "4 ", "5 ", "6 ", "7 ", "8 ", "9 ", "10", "11", "12", "13", "14", "15"];

/// A robot's colour; the same as on the page.
fn robot_paint(robot: usize) -> Paint {
    let [r, g, b] = colour::ROBOTS[robot % colour::ROBOTS.len()];
    (BLACK, Some(Color::Rgb(r, g, b)))
}

fn side(history: &History, settings: &ViewSettings, now: MonotonicNs, area: Rect) -> Vec<Line<'static>> {
    let mut lines = Vec::new();
    let Some(brief) = history.brief() else { return lines };
    let due = history.hops().map_or(Decision(0), |hops| hops.due());
    let at = settings.shown(due);
    let hop = hop_before(history, at);
    mission(history, at, &mut lines);
    lines.push(title("decision time"));
    let budget_ns = brief.limits.decision_budget_ns;
    let stages = hop.map_or([0; 7], |hop| hop.stages_ns);
    lines.push(bar(&stages, budget_ns));
    lines.extend(stage_lines(&stages));
    if let Some(progress) = history.progress() {
        let latency = &progress.latency;
        let [p50, p99] = [latency.p50_us, latency.p99_us].map(|us| duration(us * 1e3));
        let missed = format!("{} missed", latency.misses);
        let style = if latency.misses > 0 { BAD } else { Style::new() };
        lines.push(Line::from(vec![
            Span::raw(format!("p50 {p50}  p99 {p99}  ")),
            Span::styled(missed, style),
        ]));
    }
    lines.push(decision_times(history, at));
    lines.push(title("command"));
    if let Some(hops) = history.hops() {
        for change in hops.leader_changes().rev().filter(|change| change.from <= at).take(2) {
            let LeaderChange { robot, term, planner, from, pid, .. } = change;
            lines.push(Line::raw(if is_team(history) {
                format!("robot {robot}: term {term} {planner} from {from}")
            } else {
                format!("term {term} {planner} from hop {from} ({pid})")
            }));
        }
    }
    lines.extend(certificate(history, at));
    lines.push(title("processes"));
    let leader = history.state().map(|state| state.leader.incarnation);
    for peer in history.peers().peers().iter().filter(|peer| peer.beat.role != Role::Monitor) {
        let name = match peer.beat.role {
            Role::Planner => format!("planner {}", peer.beat.planner),
            role => role.to_string(),
        };
        let leads = if Some(peer.beat.incarnation) == leader { " commands" } else { "" };
        let (word, style) = if peer.silent { ("silent", BAD) } else { ("●", GOOD) };
        let silent = now.since_ns(peer.heard) as f64;
        let text = format!(" {name} ({}){leads} {}", peer.beat.pid, duration(silent));
        lines.push(Line::from(vec![Span::styled(word, style), Span::raw(text)]));
    }
    let left = (area.height as usize).saturating_sub(lines.len() + 1);
    lines.push(title("events"));
    lines.extend(events(history, at, left));
    lines
}

/// The proven error bound of the displayed policy; `None` if its planner proves none.
fn certificate(history: &History, at: Decision) -> Option<Line<'static>> {
    let Policy { planner, decision, error_bound, .. } = history.policy()?;
    let claims = *error_bound > 0.0 && *decision <= at;
    claims.then(|| Line::raw(format!("{planner} at hop {decision}: |V − V*| ≤ {error_bound:.1e}")))
}

fn title(text: &str) -> Line<'static> {
    Line::styled(format!("─ {text} {}", "─".repeat(34_usize.saturating_sub(text.len()))), DIM)
}

fn mission(history: &History, at: Decision, lines: &mut Vec<Line<'static>>) {
    let (Some(brief), Some(ground), Some(hops)) = (history.brief(), history.seen_cells(), history.hops())
    else {
        return;
    };
    let cell = pose(history, at).unwrap_or(brief.start);
    let height_m = hop_before(history, at).map_or(0.0, |hop| hop.height_m);
    let distance_m = cell.distance_cells(goal(history, brief, at)) * brief.grid.cell_size_m;
    let cells = if at < hops.due() { ground.seen_by(at) } else { ground.seen() };
    let seen = 100.0 * cells as f64 / brief.grid.cells() as f64;
    let flown = at.0.saturating_sub(hops.first().0) as usize;
    let strays = |hop: &&Hop| matches!(hop.branch, Branch::Left | Branch::Right | Branch::Stayed);
    let stray = hops.from(hops.first()).take(flown).filter(strays).count();
    let treasures = hop_before(history, at).map_or(0, |hop| hop.collected.count());
    lines.push(Line::raw(format!("{distance_m:.1} m to go · {seen:.0} % seen · {stray} stray")));
    if !brief.is_of_hopper() {
        lines.truncate(lines.len() - 1);
        lines.extend(robots(history, brief, at, seen));
        return;
    }
    let radius_m = brief.sensor.radius_m(height_m);
    lines.push(Line::raw(format!("height {height_m:.2} m, sees {radius_m:.1} m · {treasures} ★")));
}

/// Most robots that have a line of their own.
const ROBOT_LINES: usize = 6;

/// The robots with their numbers and colours, and whose turn it is.
fn robots(history: &History, brief: &Brief, at: Decision, seen_percent: f64) -> Vec<Line<'static>> {
    let due = history.hops().and_then(|hops| hops.get(at)).map(|hop| usize::from(hop.robot.0));
    let team = history.team().filter(|team| team.decision == at).map(|team| usize::from(team.due.0));
    let over = hop_before(history, at).is_some_and(|hop| hop.status.is_over());
    let due = due.or(team).filter(|_| !over);
    let turn = due.map_or_else(|| "nobody's turn".into(), |robot| format!("robot {robot}'s turn"));
    let mut lines = vec![Line::raw(format!("{turn} · {seen_percent:.0} % seen"))];
    let members = history.progress().map_or(&[][..], |progress| &progress.robots);
    for (robot, member) in members.iter().enumerate().take(ROBOT_LINES) {
        let (ink, ground) = robot_paint(robot);
        let number = Span::styled(
            ROBOT_NUMBERS[robot % ROBOT_NUMBERS.len()],
            Style::new().fg(ink).bg(ground.unwrap_or(WHITE)),
        );
        let kind = kind(member);
        let text = format!(" {kind} {}, {}", member.leader.planner, member.standing);
        lines.push(Line::from(vec![number, Span::raw(text)]));
    }
    if usize::from(brief.robots) > ROBOT_LINES {
        lines.push(Line::styled(format!("and {} more", usize::from(brief.robots) - ROBOT_LINES), DIM));
    }
    lines
}

fn kind(member: &Member) -> &'static str {
    match member.robot.vehicle {
        contract::Vehicle::Rover { .. } | contract::Vehicle::Driver { .. } => "rover",
        contract::Vehicle::Helicopter { .. } => "helicopter",
        contract::Vehicle::Hopper | contract::Vehicle::HopperTo { .. } => "hopper",
    }
}

/// Width of the time axis, columns.
const AXIS: usize = 36;

/// Column of a duration on the logarithmic time axis from 10 µs to 2 s.
fn column(ns: f64) -> usize {
    let share = (ns.max(1e4) / 1e4).ln() / (2e9_f64 / 1e4).ln();
    ((share * AXIS as f64).round() as usize).min(AXIS - 1)
}

/// The stages on the time axis, from landing on, with the budget as a line.
fn bar(stages_ns: &[u64; 7], budget_ns: u64) -> Line<'static> {
    let budget = column(budget_ns as f64);
    let mut columns: Vec<Span<'static>> = vec![Span::styled("·", DIM); AXIS];
    let mut sum = 0;
    for (stage, &ns) in stages_ns.iter().enumerate().filter(|(_, ns)| **ns > 0) {
        let from = if sum == 0 { 0 } else { column(sum as f64) };
        sum += ns;
        let style = Style::new().fg(STAGES[stage]);
        columns[from..column(sum as f64).max(from)].fill(Span::styled(TEXTURES[stage], style));
    }
    columns[budget] = Span::styled("│", BAD);
    columns.into()
}

/// Names and durations of the stages in two columns, with their sum.
fn stage_lines(stages_ns: &[u64; 7]) -> Vec<Line<'static>> {
    let entry = |stage: usize| {
        let name = Stage::ALL[stage].as_str();
        let text = format!(" {name:<7} {:>8}  ", duration(stages_ns[stage] as f64));
        [Span::styled(TEXTURES[stage], Style::new().fg(STAGES[stage])), Span::raw(text)]
    };
    let total = format!("  total   {:>8}", duration(stages_ns.iter().sum::<u64>() as f64));
    let mut lines: Vec<Line<'static>> =
        (0..3).map(|row| Line::from([entry(2 * row), entry(2 * row + 1)].concat())).collect();
    lines.push(Line::from([entry(6).to_vec(), vec![Span::styled(total, BOLD)]].concat()));
    lines
}

/// Total times of the last decisions, one column each, on the same scale.
fn decision_times(history: &History, at: Decision) -> Line<'static> {
    const STEPS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    let Some(hops) = history.hops() else { return Line::default() };
    let from = Decision(at.0.saturating_sub(AXIS as u64));
    let count = at.0.saturating_sub(from.0.max(hops.first().0)) as usize;
    let mark = |hop: &Hop| STEPS[column(hop.total_ns() as f64) * STEPS.len() / AXIS];
    Line::styled(hops.from(from).take(count).map(mark).collect::<String>(), Style::new().fg(STAGES[1]))
}

/// Events, newest first: changes of leader, processes that joined or fell silent, interventions of the guard.
fn events(history: &History, at: Decision, count: usize) -> Vec<Line<'static>> {
    let mut events: Vec<(Decision, Style, String)> = Vec::new();
    for mark in history.peers().events() {
        let style = match mark.change {
            PeerChange::Joined => Style::new(),
            PeerChange::Silent => BAD,
            PeerChange::Back => GOOD,
        };
        let text = format!("{} ({}) {}", mark.beat.role, mark.beat.pid, mark.change.as_str());
        events.push((mark.decision, style, text));
    }
    if let Some(hops) = history.hops() {
        for change in hops.leader_changes().filter(|change| !change.is_first) {
            let robot = robot_of(history, change.robot);
            let text = format!("{robot}{} takes command, term {}", change.planner, change.term);
            events.push((change.from, Style::new().fg(AMBER), text));
        }
    }
    events.retain(|(decision, ..)| *decision <= at);
    events.extend(guarded(history, at, count));
    events.sort_by_key(|(decision, ..)| *decision);
    let line = |(decision, style, text): (Decision, Style, String)| {
        Line::from(vec![Span::styled(format!("{decision:>5} "), DIM), Span::styled(text, style)])
    };
    events.into_iter().rev().take(count).map(line).collect()
}

/// What a decision is called: robots of a team do not all hop.
fn noun(history: &History) -> &'static str {
    if is_team(history) { "decision" } else { "hop" }
}

/// Which of several robots something is about, as the beginning of a line.
fn robot_of(history: &History, robot: RobotId) -> String {
    if is_team(history) { format!("robot {robot}: ") } else { String::new() }
}

fn is_team(history: &History) -> bool {
    history.brief().is_some_and(|brief| brief.robots > 1)
}

/// Recent interventions of the guard, newest first.
fn guarded(history: &History, at: Decision, count: usize) -> Vec<(Decision, Style, String)> {
    let from = Decision(at.0.saturating_sub(GUARDED_HOPS));
    let hop = |decision| Some((Decision(decision), history.hops()?.get(Decision(decision))?));
    let hops = (from.0..at.0).rev().filter_map(hop);
    let events = hops.flat_map(|(decision, hop)| {
        let vetoes = hop.vetoed.count();
        let veto = (vetoes > 0).then(|| (AMBER, format!("the guard vetoes {vetoes}")));
        let fallback = match hop.origin {
            Origin::Planner => None,
            origin => Some((Color::Red, format!("the fallback acts: {origin}"))),
        };
        [veto, fallback]
            .into_iter()
            .flatten()
            .map(move |(paint, text)| (decision, Style::new().fg(paint), text))
    });
    events.take(count).collect()
}

/// A duration in µs, ms or s.
fn duration(ns: f64) -> String {
    match ns {
        ns if ns < 1e6 => format!("{:.0} µs", ns / 1e3),
        ns if ns < 1e9 => format!("{:.1} ms", ns / 1e6),
        ns => format!("{:.2} s", ns / 1e9),
    }
}
