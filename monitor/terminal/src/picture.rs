//! What the terminal shows: home of the map in characters.

use contract::{Action, Branch, Brief, Cell, Decision, Direction, MonotonicNs, Origin, Policy, Role, Stage};
use ratatui::Frame;
use ratatui::layout::{Alignment, Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Paragraph};

use monitor::Chronicle;
use monitor::chronicle::{Change, Ground, Hop};

/// Narrowest terminal.
pub const COLUMNS_MIN: u16 = 80;

/// Lowest terminal.
pub const ROWS_MIN: u16 = 24;

/// Colours of the stages, in the order of [`Stage::ALL`]; they can be told apart by a colour-blind eye.
const STAGES: [Color; 7] = [
    Color::Rgb(133, 147, 163),
    Color::Rgb(86, 180, 233),
    Color::Rgb(47, 127, 208),
    Color::Rgb(161, 139, 240),
    Color::Rgb(230, 161, 23),
    Color::Rgb(23, 168, 129),
    Color::Rgb(208, 127, 174),
];

const DIM: Style = Style::new().add_modifier(Modifier::DIM);
const BOLD: Style = Style::new().add_modifier(Modifier::BOLD);
const BAD: Style = Style::new().fg(Color::Red);
const GOOD: Style = Style::new().fg(Color::Green);
const AMBER: Color = Color::Rgb(240, 166, 58);

/// Hops that are looked through for what the guard did.
const GUARDED_HOPS: u64 = 1024;

/// What whoever looks has chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Knobs {
    /// The moment to look at; `None` is now.
    pub at: Option<Decision>,
    /// Whether the policy is shown where the planner in command has one.
    pub policy: bool,
    /// Whether the map is shown around the hopper, a cell a place, rather than whole.
    pub follow: bool,
    /// Whether orders are allowed.
    pub control: bool,
}

impl Knobs {
    /// The moment shown of an account whose due decision is `due`.
    #[must_use]
    pub fn moment(&self, due: Decision) -> Decision {
        self.at.map_or(due, |at| at.min(due))
    }

    /// Goes `by` hops ahead, or back; at the end of the account time is now again.
    pub fn go(&mut self, by: i64, due: Decision) {
        let to = self.moment(due).0.saturating_add_signed(by);
        self.at = (to < due.0).then_some(Decision(to));
    }
}

/// Draws the account at `now`.
pub fn draw(frame: &mut Frame<'_>, account: &Chronicle, knobs: &Knobs, now: MonotonicNs) {
    let area = frame.area();
    if area.width < COLUMNS_MIN || area.height < ROWS_MIN {
        let text = format!("needs {COLUMNS_MIN} x {ROWS_MIN}, got {} x {}", area.width, area.height);
        frame.render_widget(Paragraph::new(text).alignment(Alignment::Center), area);
        return;
    }
    let [head, body, foot] =
        Layout::vertical([Constraint::Length(1), Constraint::Fill(1), Constraint::Length(1)]).areas(area);
    frame.render_widget(heading(account, knobs), head);
    frame.render_widget(keys(knobs, account), foot);
    let [left, right] = Layout::horizontal([Constraint::Fill(1), Constraint::Length(38)]).areas(body);
    let title = if knobs.follow { " ground, around the hopper " } else { " ground " };
    let block = Block::bordered().border_style(DIM).title(title);
    let inside = block.inner(left);
    frame.render_widget(block, left);
    if let Some(view) = View::of(account, knobs, inside) {
        view.draw(frame, inside);
    }
    frame.render_widget(Paragraph::new(side(account, knobs, now, right)), right);
}

fn heading(account: &Chronicle, knobs: &Knobs) -> Line<'static> {
    let mut line = vec![Span::styled(" Hopper ", BOLD.fg(AMBER))];
    let Some(brief) = account.brief_known() else {
        line.push(Span::raw("waiting for a mission"));
        return line.into();
    };
    let due = account.hops().map_or(Decision(0), |hops| hops.due());
    let at = knobs.moment(due);
    let status = account.progress().map(|progress| progress.status);
    let paused = account.tempo().is_some_and(|tempo| tempo.paused);
    let (word, style) = match status {
        Some(status) if status.is_over() => {
            (status.to_string(), if status == contract::Status::Goal { GOOD } else { BAD })
        }
        _ if knobs.at.is_some() => ("looking back".to_owned(), BOLD.fg(AMBER)),
        _ if paused => ("paused".to_owned(), BOLD.fg(AMBER)),
        _ => ("under way".to_owned(), GOOD),
    };
    line.push(Span::raw(format!("{} · {} ", brief.scenario, brief.profile)));
    line.push(Span::styled(format!("● {word} "), style));
    let before = hop_before(account, at);
    let count = match brief.patrol {
        None => format!("step {}/{}", before.map_or(0, |hop| hop.steps), brief.limits.steps_max),
        Some(_) => format!("goals visited {}", before.map_or(0, |hop| hop.visits)),
    };
    let pace = account.tempo().map_or_else(String::new, |tempo| format!(" · pace {}", tempo.pace));
    line.push(Span::raw(format!("hop {at} of {due} · {count}{pace}")));
    line.into()
}

fn keys(knobs: &Knobs, account: &Chronicle) -> Line<'static> {
    let view = " q quit  ←→ PgUp PgDn Home End  p policy  f follow";
    let heeds = account.tempo().is_none_or(|tempo| tempo.heeds);
    let control = match (knobs.control, heeds) {
        (true, true) => "  space pause  s step  h hand",
        // hopper-sim was started without --control; planners heed all the same.
        (true, false) => "  h hand",
        (false, _) => "",
    };
    Line::styled(format!("{view}{control}"), DIM)
}

fn hop_before(account: &Chronicle, at: Decision) -> Option<&Hop> {
    account.hops()?.get(Decision(at.0.checked_sub(1)?))
}

/// The map in characters: each place two columns wide, for one cell or a square of them.
struct View<'a> {
    account: &'a Chronicle,
    ground: &'a Ground,
    at: Decision,
    /// Cells along a place's side.
    stride: i32,
    /// The cell of the upper left place's upper left corner.
    corner: Cell,
    places: (i32, i32),
    policy: bool,
    heights_m: (f32, f32),
}

impl<'a> View<'a> {
    fn of(account: &'a Chronicle, knobs: &Knobs, area: Rect) -> Option<Self> {
        let (brief, ground) = (account.brief_known()?, account.ground()?);
        let (width, height) = (brief.grid.width as i32, brief.grid.height as i32);
        let (columns, rows) = (i32::from(area.width) / 2, i32::from(area.height));
        let whole = ((width + columns - 1) / columns).max((height + rows - 1) / rows);
        let stride = if knobs.follow { 1 } else { whole };
        let at = knobs.moment(account.hops()?.due());
        let places = (columns.min((width + stride - 1) / stride), rows.min((height + stride - 1) / stride));
        let pose = pose(account, at)?;
        let from = |centre: i32, shown: i32, side: i32| (centre - shown / 2).clamp(0, (side - shown).max(0));
        let left = from(pose.x, places.0 * stride, width);
        let bottom = from(pose.y, places.1 * stride, height);
        let commands = hop_before(account, at).map(|hop| hop.term);
        let reign = account.hops()?.reigns().find(|reign| Some(reign.term) == commands);
        let policy =
            account.policy().is_some_and(|policy| reign.is_none_or(|reign| reign.planner == policy.planner));
        let prior = brief.priors.height_m;
        Some(Self {
            account,
            ground,
            at,
            stride,
            corner: Cell::new(left, bottom + places.1 * stride - 1),
            places,
            policy: knobs.policy && stride == 1 && policy,
            heights_m: (prior.min as f32, prior.max as f32),
        })
    }

    fn draw(&self, frame: &mut Frame<'_>, area: Rect) {
        let (indent, drop) =
            ((area.width as i32 - 2 * self.places.0) / 2, (area.height as i32 - self.places.1) / 2);
        let mut signs = vec![None; (self.places.0 * self.places.1) as usize];
        self.signs(&mut signs);
        let buffer = frame.buffer_mut();
        for row in 0..self.places.1 {
            for column in 0..self.places.0 {
                let cell = Cell::new(self.corner.x + column * self.stride, self.corner.y - row * self.stride);
                let (mut text, mut style) = self.face(cell);
                if let Some((sign, paint)) = signs[(row * self.places.0 + column) as usize] {
                    text = sign;
                    style = style.fg(paint).add_modifier(Modifier::BOLD);
                }
                let (x, y) = (area.x + (indent + 2 * column) as u16, area.y + (drop + row) as u16);
                buffer.set_string(x, y, text, style);
            }
        }
    }

    /// What stands on places: route, stray hops, start, goal, treasures, hopper; the later cover the earlier.
    fn signs(&self, signs: &mut [Option<(&'static str, Color)>]) {
        let mut put = |cell: Cell, sign: &'static str, paint: Color| {
            let (dx, dy) = (cell.x - self.corner.x, self.corner.y - cell.y);
            let (column, row) = (dx.div_euclid(self.stride), dy.div_euclid(self.stride));
            if (0..self.places.0).contains(&column) && (0..self.places.1).contains(&row) {
                signs[(row * self.places.0 + column) as usize] = Some((sign, paint));
            }
        };
        let (Some(brief), Some(hops)) = (self.account.brief_known(), self.account.hops()) else { return };
        let flown = (self.at.0.saturating_sub(hops.first().0)) as usize;
        // Of a patrol there are the leg under way and the one before.
        let visits = hop_before(self.account, self.at).map_or(0, |hop| hop.visits);
        for hop in hops.from(hops.first()).take(flown).filter(|hop| hop.visits + 1 >= visits) {
            put(hop.from, "• ", Color::White);
            match hop.branch {
                Branch::Left | Branch::Right => put(hop.to, "× ", Color::LightRed),
                Branch::Stayed => put(hop.to, "o ", Color::LightRed),
                Branch::Intended => put(hop.to, "• ", Color::White),
                Branch::Held => {}
            }
        }
        put(brief.start, "S ", Color::White);
        for treasure in self.account.treasures(self.at) {
            put(treasure, "★ ", Color::Yellow);
        }
        for &goal in brief.patrol.iter().flat_map(|patrol| patrol.goals()) {
            put(goal, "⚑ ", Color::Gray);
        }
        put(goal(self.account, brief, self.at), "⚑ ", Color::LightGreen);
        if let Some(cell) = pose(self.account, self.at) {
            put(cell, "@ ", AMBER);
        }
    }

    /// The ground of a place: the brightest thing to know of it.
    fn face(&self, cell: Cell) -> (&'static str, Style) {
        let middle = Cell::new(cell.x + self.stride / 2, cell.y - self.stride / 2);
        let grid = self.account.brief_known().map(|brief| brief.grid);
        let index = grid.and_then(|grid| grid.index(middle).or_else(|| grid.index(cell)));
        let seen =
            index.and_then(|index| self.ground.get(index)).filter(|seen| u64::from(seen.at) <= self.at.0);
        let Some(seen) = seen else { return ("· ", DIM) };
        let style = Style::new().bg(shade(seen.height_m, self.heights_m, seen.sand)).fg(Color::Black);
        let arrow = index.filter(|_| self.policy).and_then(|index| self.account.policy()?.cells.get(index));
        match arrow.map(|cell| cell.action) {
            Some(Action::Hop(direction)) => (arrow_on(direction, seen.sand), style),
            _ if !seen.passable => ("##", style),
            _ if seen.sand => ("░░", style),
            _ => ("  ", style),
        }
    }
}

/// An arrow on hard ground or on sand, which is told without colours too.
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

/// The goal in force at a moment.
fn goal(account: &Chronicle, brief: &Brief, at: Decision) -> Cell {
    brief.leg(hop_before(account, at).map_or(0, |hop| hop.visits)).goal
}

fn pose(account: &Chronicle, at: Decision) -> Option<Cell> {
    let start = account.brief_known()?.start;
    Some(hop_before(account, at).map_or(start, |hop| hop.to))
}

/// From dusk to dust by height, ochre where there is sand.
fn shade(height_m: f32, (low, high): (f32, f32), sand: bool) -> Color {
    let share = ((height_m - low) / (high - low).max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
    let mix = |dark: f32, bright: f32| (dark + (bright - dark) * share) as u8;
    if sand {
        Color::Rgb(mix(150.0, 235.0), mix(105.0, 185.0), mix(40.0, 90.0))
    } else {
        Color::Rgb(mix(60.0, 232.0), mix(58.0, 214.0), mix(72.0, 180.0))
    }
}

fn side(account: &Chronicle, knobs: &Knobs, now: MonotonicNs, area: Rect) -> Vec<Line<'static>> {
    let mut lines = Vec::new();
    let Some(brief) = account.brief_known() else { return lines };
    let due = account.hops().map_or(Decision(0), |hops| hops.due());
    let at = knobs.moment(due);
    let hop = hop_before(account, at);
    mission(account, at, &mut lines);
    lines.push(title("decision time"));
    let budget_ns = brief.limits.decision_budget_ns;
    let stages = hop.map_or([0; 7], |hop| hop.stages_ns);
    lines.push(bar(&stages, budget_ns));
    lines.extend(stage_lines(&stages));
    if let Some(progress) = account.progress() {
        let pulse = &progress.latency;
        let [p50, p99] = [pulse.p50_us, pulse.p99_us].map(|us| duration(us * 1e3));
        let missed = format!("{} missed", pulse.misses);
        let style = if pulse.misses > 0 { BAD } else { Style::new() };
        lines.push(Line::from(vec![
            Span::raw(format!("p50 {p50}  p99 {p99}  ")),
            Span::styled(missed, style),
        ]));
    }
    lines.push(history(account, at));
    lines.push(title("command"));
    if let Some(hops) = account.hops() {
        for reign in hops.reigns().rev().filter(|reign| reign.from <= at).take(2) {
            let text =
                format!("term {} {} from hop {} ({})", reign.term, reign.planner, reign.from, reign.pid);
            lines.push(Line::raw(text));
        }
    }
    lines.extend(certificate(account, at));
    lines.push(title("processes"));
    let leader = account.state().map(|state| state.leader.incarnation);
    for peer in account.lives().peers().iter().filter(|peer| peer.beat.role != Role::Monitor) {
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
    lines.extend(events(account, at, left));
    lines
}

/// How far the values of the policy in sight may be from the true ones at most, where its planner proves that.
fn certificate(account: &Chronicle, at: Decision) -> Option<Line<'static>> {
    let Policy { planner, decision, error_bound, .. } = account.policy()?;
    let claims = *error_bound > 0.0 && *decision <= at;
    claims.then(|| Line::raw(format!("{planner} at hop {decision}: |V − V*| ≤ {error_bound:.1e}")))
}

fn title(text: &str) -> Line<'static> {
    Line::styled(format!("─ {text} {}", "─".repeat(34_usize.saturating_sub(text.len()))), DIM)
}

fn mission(account: &Chronicle, at: Decision, lines: &mut Vec<Line<'static>>) {
    let (Some(brief), Some(ground), Some(hops)) = (account.brief_known(), account.ground(), account.hops())
    else {
        return;
    };
    let cell = pose(account, at).unwrap_or(brief.start);
    let height_m = hop_before(account, at).map_or(0.0, |hop| hop.height_m);
    let distance_m = cell.distance_cells(goal(account, brief, at)) * brief.grid.cell_size_m;
    let cells = if at < hops.due() { ground.seen_by(at) } else { ground.seen() };
    let seen = 100.0 * cells as f64 / brief.grid.cells() as f64;
    let flown = at.0.saturating_sub(hops.first().0) as usize;
    let strays = |hop: &&Hop| matches!(hop.branch, Branch::Left | Branch::Right | Branch::Stayed);
    let stray = hops.from(hops.first()).take(flown).filter(strays).count();
    let treasures = hop_before(account, at).map_or(0, |hop| hop.collected.count());
    lines.push(Line::raw(format!("{distance_m:.1} m to go · {seen:.0} % seen · {stray} stray")));
    let radius_m = brief.sensor.radius_m(height_m);
    lines.push(Line::raw(format!("height {height_m:.2} m, sees {radius_m:.1} m · {treasures} ★")));
}

/// Columns of the time axis.
const AXIS: usize = 36;

/// Where a duration stands on the axis: logarithmic, 10 µs to 2 s.
fn column(ns: f64) -> usize {
    let share = (ns.max(1e4) / 1e4).ln() / (2e9_f64 / 1e4).ln();
    ((share * AXIS as f64).round() as usize).min(AXIS - 1)
}

/// The stages on an axis of time since landing, with the budget as a line.
fn bar(stages_ns: &[u64; 7], budget_ns: u64) -> Line<'static> {
    let budget = column(budget_ns as f64);
    let mut columns: Vec<Span<'static>> = vec![Span::styled("·", DIM); AXIS];
    let mut sum = 0;
    for (stage, &ns) in stages_ns.iter().enumerate().filter(|(_, ns)| **ns > 0) {
        let from = if sum == 0 { 0 } else { column(sum as f64) };
        sum += ns;
        let style = Style::new().fg(STAGES[stage]);
        columns[from..column(sum as f64).max(from)].fill(Span::styled("█", style));
    }
    columns[budget] = Span::styled("│", BAD);
    columns.into()
}

/// Names and durations of the stages in two columns, and their sum.
fn stage_lines(stages_ns: &[u64; 7]) -> Vec<Line<'static>> {
    let entry = |stage: usize| {
        let name = Stage::ALL[stage].as_str();
        let text = format!(" {name:<7} {:>8}  ", duration(stages_ns[stage] as f64));
        [Span::styled("█", Style::new().fg(STAGES[stage])), Span::raw(text)]
    };
    let total = format!("  total   {:>8}", duration(stages_ns.iter().sum::<u64>() as f64));
    let mut lines: Vec<Line<'static>> =
        (0..3).map(|row| Line::from([entry(2 * row), entry(2 * row + 1)].concat())).collect();
    lines.push(Line::from([entry(6).to_vec(), vec![Span::styled(total, BOLD)]].concat()));
    lines
}

/// The last decisions, a column each, on the same axis upright.
fn history(account: &Chronicle, at: Decision) -> Line<'static> {
    const STEPS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    let Some(hops) = account.hops() else { return Line::default() };
    let from = Decision(at.0.saturating_sub(AXIS as u64));
    let count = at.0.saturating_sub(from.0.max(hops.first().0)) as usize;
    let mark = |hop: &Hop| STEPS[column(hop.total_ns() as f64) * STEPS.len() / AXIS];
    Line::styled(hops.from(from).take(count).map(mark).collect::<String>(), Style::new().fg(STAGES[1]))
}

/// The newest events first: swaps, who came, who fell silent.
fn events(account: &Chronicle, at: Decision, count: usize) -> Vec<Line<'static>> {
    let mut events: Vec<(Decision, Style, String)> = Vec::new();
    for mark in account.lives().marks() {
        let style = match mark.change {
            Change::Joined => Style::new(),
            Change::Silent => BAD,
            Change::Back => GOOD,
        };
        let text = format!("{} ({}) {}", mark.beat.role, mark.beat.pid, mark.change.as_str());
        events.push((mark.decision, style, text));
    }
    if let Some(hops) = account.hops() {
        for reign in hops.reigns().skip(1) {
            let text = format!("{} takes command, term {}", reign.planner, reign.term);
            events.push((reign.from, Style::new().fg(AMBER), text));
        }
    }
    events.retain(|(decision, ..)| *decision <= at);
    events.extend(guarded(account, at, count));
    events.sort_by_key(|(decision, ..)| *decision);
    let line = |(decision, style, text): (Decision, Style, String)| {
        Line::from(vec![Span::styled(format!("{decision:>5} "), DIM), Span::styled(text, style)])
    };
    events.into_iter().rev().take(count).map(line).collect()
}

/// What the guard did of late.
fn guarded(account: &Chronicle, at: Decision, count: usize) -> Vec<(Decision, Style, String)> {
    let from = Decision(at.0.saturating_sub(GUARDED_HOPS));
    let hop = |decision| Some((Decision(decision), account.hops()?.get(Decision(decision))?));
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

/// A duration in the unit that suits it.
fn duration(ns: f64) -> String {
    match ns {
        ns if ns < 1e6 => format!("{:.0} µs", ns / 1e3),
        ns if ns < 1e9 => format!("{:.1} ms", ns / 1e6),
        ns => format!("{:.2} s", ns / 1e9),
    }
}
