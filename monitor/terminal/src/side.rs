//! The column beside the map: the mission in figures, decision times, who commands, processes, events.

use contract::{
    Account, Branch, Brief, Decision, Direction, MonotonicNs, Origin, Policy, RobotId, Role, Stage,
};
use ratatui::layout::Rect;
use ratatui::style::{Color, Style};
use ratatui::text::{Line, Span};
use report::way;

use monitor::History;
use monitor::history::{Hop, LeaderChange, Peer, PeerChange};

use crate::ViewSettings;
use crate::map::{ROBOT_NUMBERS, WHITE, robot_paint};
use crate::moment::{goal, hop_before, is_team, pose, robot_of};
use crate::style::{AMBER, BAD, BOLD, DIM, GOOD};

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

/// Number of hops that are searched for interventions of the guard.
const GUARDED_HOPS: u64 = 1024;

/// The column beside the map.
pub(crate) fn side(
    history: &History,
    settings: &ViewSettings,
    now: MonotonicNs,
    area: Rect,
) -> Vec<Line<'static>> {
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
    for peer in history.peers().peers().iter().filter(|peer| peer.beat.role != Role::Monitor) {
        let name = match peer.beat.role {
            Role::Planner => format!("planner {}", peer.beat.planner),
            role => role.to_string(),
        };
        let leads = commands(history, peer);
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

/// What a process commands, if it does: of several robots their numbers.
fn commands(history: &History, peer: &Peer) -> String {
    let led = history.led_by(peer.beat.incarnation);
    let numbers: Vec<String> = led.iter().map(RobotId::to_string).collect();
    match numbers.as_slice() {
        [] => String::new(),
        numbers if is_team(history) => format!(" commands {}", numbers.join(" ")),
        _ => " commands".to_owned(),
    }
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
    let height_m = hop_before(history, at).map_or(0.0, |hop| hop.height_m);
    let distance_m = pose(history, at)
        .zip(goal(history, brief, at))
        .map_or(0.0, |(cell, goal)| cell.distance_cells(goal) * brief.grid.cell_size_m);
    let cells = if at < hops.due() { ground.seen_by(at) } else { ground.seen() };
    let seen = 100.0 * cells as f64 / brief.grid.cells() as f64;
    let flown = at.0.saturating_sub(hops.first().0) as usize;
    let strays = |hop: &&Hop| matches!(hop.branch, Branch::Left | Branch::Right | Branch::Stayed);
    let stray = hops.from(hops.first()).take(flown).filter(strays).count();
    let treasures = hop_before(history, at).map_or(0, |hop| hop.collected.count());
    if brief.account != Account::Hopper {
        lines.extend(robots(history, brief, at, seen));
        return;
    }
    lines.push(Line::raw(format!("{distance_m:.1} m to go · {seen:.0} % seen · {stray} stray")));
    let radius_m = brief.robots[0].as_hopper().map_or(0.0, |(_, sensor)| sensor.radius_m(height_m));
    lines.push(Line::raw(format!("height {height_m:.2} m, sees {radius_m:.1} m · {treasures} ★")));
    lines.extend(way_of_hop(history, at));
    lines.extend(why(history, at));
}

/// What the planner that decides would do next and why: the two hops that are worth most by its policy.
fn why(history: &History, at: Decision) -> Option<Line<'static>> {
    if hop_before(history, at).is_some_and(|hop| hop.status.is_over()) {
        return None;
    }
    let reason = history.reason(pose(history, at)?, at)?;
    let (planner, _, action) = reason.policy?;
    let mut hops: Vec<_> = reason.hops.iter().filter_map(|hop| Some((hop.value?, hop.direction))).collect();
    hops.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    let worth = |&(value, direction): &(f64, Direction)| format!("{direction} {value:.2}");
    let values: Vec<_> = hops.iter().take(2).map(worth).collect();
    Some(Line::raw(match values.as_slice() {
        [] => format!("{planner}: {action} next"),
        values => format!("{planner} expects {}", values.join(", ")),
    }))
}

/// What became of the hop that led to a moment, where the motion model tells it.
fn way_of_hop(history: &History, at: Decision) -> Vec<Line<'static>> {
    let before = at.0.checked_sub(1).map(Decision);
    let detail = before.and_then(|before| history.details()?.of(before));
    let Some((detail, launch)) = detail.and_then(|detail| Some((detail, detail.path.first()?))) else {
        return Vec::new();
    };
    let [east, north, up] = launch.leaves_mps;
    let level_mps = east.hypot(north);
    let (speed_mps, angle_deg) = (level_mps.hypot(up), up.atan2(level_mps).to_degrees());
    let mut lines = vec![format!("{speed_mps:.2} m/s at {angle_deg:.0}°, for {:.1} s", way::seconds(detail))];
    if let (Some(impacts), Some(rolled_m)) = (detail.figure("impacts"), detail.figure("rolled_m")) {
        let plural = if impacts == 1.0 { "" } else { "s" };
        lines.push(format!("{impacts} impact{plural}, rolled {rolled_m:.2} m"));
    }
    lines.push(way::ending(detail).to_owned());
    lines.into_iter().map(Line::raw).collect()
}

/// Most robots that have a line of their own.
const ROBOT_LINES: usize = 6;

/// The robots with their numbers and colours, and whose turn it is.
fn robots(history: &History, brief: &Brief, at: Decision, seen_percent: f64) -> Vec<Line<'static>> {
    let due = history.hops().and_then(|hops| hops.get(at)).map(|hop| usize::from(hop.robot.0));
    let team = history.team().filter(|team| team.decision == at).map(|team| usize::from(team.due.0));
    let over = hop_before(history, at).is_some_and(|hop| hop.status.is_over());
    let due = if over { None } else { due.or(team) };
    let turn = due.map_or_else(|| "nobody's turn".into(), |robot| format!("robot {robot}'s turn"));
    let mut lines = vec![Line::raw(format!("{turn} · {seen_percent:.0} % seen"))];
    let members = history.progress().map_or(&[][..], |progress| &progress.robots);
    for (robot, (described, member)) in brief.robots.iter().zip(members).enumerate().take(ROBOT_LINES) {
        let (ink, ground) = robot_paint(robot);
        let number = Span::styled(
            ROBOT_NUMBERS[robot % ROBOT_NUMBERS.len()],
            Style::new().fg(ink).bg(ground.unwrap_or(WHITE)),
        );
        let kind = described.body.word();
        let text = format!(" {kind} {}, {}", member.leader.planner, member.standing);
        lines.push(Line::from(vec![number, Span::raw(text)]));
    }
    if brief.robots.len() > ROBOT_LINES {
        lines.push(Line::styled(format!("and {} more", brief.robots.len() - ROBOT_LINES), DIM));
    }
    lines
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

/// Recent interventions of the guard, newest first.
fn guarded(history: &History, at: Decision, count: usize) -> Vec<(Decision, Style, String)> {
    let from = Decision(at.0.saturating_sub(GUARDED_HOPS));
    let hop = |decision| Some((Decision(decision), history.hops()?.get(Decision(decision))?));
    let hops = (from.0..at.0).rev().filter_map(hop);
    let events = hops.flat_map(|(decision, hop)| {
        let (robot, vetoes) = (robot_of(history, hop.robot), hop.vetoed.count());
        let veto = (vetoes > 0).then(|| (AMBER, format!("{robot}the guard vetoes {vetoes}")));
        let fallback = match hop.origin {
            Origin::Planner => None,
            origin => Some((Color::Red, format!("{robot}the fallback acts: {origin}"))),
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
