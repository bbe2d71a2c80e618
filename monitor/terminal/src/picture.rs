//! Lays out the history of a mission in a terminal: heading, map, side column, keys.

use contract::{Account, Decision, MonotonicNs};
use ratatui::Frame;
use ratatui::layout::{Alignment, Constraint, Flex, Layout};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Clear, Paragraph};

use monitor::History;
use report::Layer;

use crate::ViewSettings;
use crate::layer::scale;
use crate::legend::{fitted, legend};
use crate::map::View;
use crate::moment::{hop_before, is_team};
use crate::side::side;
use crate::style::{AMBER, BAD, BOLD, DIM, GOOD};

/// Smallest width of the terminal, columns.
pub const COLUMNS_MIN: u16 = 80;

/// Smallest height of the terminal, rows.
pub const ROWS_MIN: u16 = 24;

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
        Some(brief) if brief.account != Account::Hopper => ", around the robot ",
        _ => ", around the hopper ",
    };
    let title = format!(" {}{}", shown.definition().title, if settings.follow { around } else { " " });
    let mut block = Block::bordered().border_style(DIM).title(title);
    let symbols = history.brief().map(legend).unwrap_or_default();
    block = block.title_bottom(match scale(shown) {
        Some(scale) => scale,
        None => fitted(&symbols, usize::from(left.width.saturating_sub(2))).into(),
    });
    let inside = block.inner(left);
    frame.render_widget(block, left);
    if let Some(view) = View::of(history, settings, inside) {
        view.draw(frame, inside);
    }
    frame.render_widget(Paragraph::new(side(history, settings, now, right)), right);
    if settings.keys {
        let lines = help(&symbols);
        let [across] = Layout::horizontal([Constraint::Length(62)]).flex(Flex::Center).areas(body);
        let [panel] =
            Layout::vertical([Constraint::Length(lines.len() as u16 + 2)]).flex(Flex::Center).areas(across);
        frame.render_widget(Clear, panel);
        frame
            .render_widget(Paragraph::new(lines).block(Block::bordered().title(" keys and symbols ")), panel);
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

/// The keys, then the symbols, three in a line.
fn help(symbols: &[(&'static str, &'static str)]) -> Vec<Line<'static>> {
    let keys =
        KEYS.map(|(key, does)| Line::from(vec![Span::styled(format!(" {key:<15}"), BOLD), does.into()]));
    let symbols = symbols.chunks(3).map(|symbols| {
        let entry = |(symbol, meaning): &(&str, &str)| {
            [Span::styled(format!(" {symbol:<5} "), BOLD), Span::raw(format!("{meaning:<12} "))]
        };
        Line::from(symbols.iter().flat_map(entry).collect::<Vec<_>>())
    });
    keys.into_iter().chain(symbols).collect()
}

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
        _ => match history.remedy() {
            Some(command) => (format!("waiting for {command}"), BOLD.fg(AMBER)),
            None => ("under way".to_owned(), GOOD),
        },
    };
    line.push(Span::raw(format!("{} · {} ", brief.scenario, brief.profile)));
    line.push(Span::styled(format!("● {word} "), style));
    let before = hop_before(history, at);
    let count = match brief.visits() {
        None => format!("step {}/{}", before.map_or(0, |hop| hop.steps), brief.limits.steps_max),
        Some(_) => format!("goals visited {}", before.map_or(0, |hop| hop.visits)),
    };
    let pace = history.pacing().map_or_else(String::new, |pacing| format!(" · pace {}", pacing.pace));
    let noun = if is_team(history) { "decision" } else { "hop" };
    line.push(Span::raw(format!("{noun} {at} of {due} · {count}{pace}")));
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
