//! How layers look in the terminal, and how often cells were visited.

use contract::{Decision, Grid};
use monitor::history::{Hop, Hops};
use ratatui::style::{Color, Style};
use ratatui::text::{Line, Span};
use report::Layer;
use report::colour;
use report::layers::Look;

/// From the darkest to the lightest: without colours the characters tell shades apart.
const TEXTURES: [[&str; 5]; 2] = [["█·", "▓·", "▒·", "░·", " ·"], ["██", "▓▓", "▒▒", "░░", "  "]];

/// Below the map: the scale, with its unit.
#[must_use]
pub(crate) fn scale(layer: Layer) -> Option<Line<'static>> {
    let scale = match layer.definition().look {
        Look::Relief => return None,
        Look::Entries => return Some(Line::raw(" ∙ once  : twice  ∴ three times  ∷ more ")),
        Look::Scale(scale) => scale,
    };
    let step = |n: u32| {
        let share = (f64::from(n) + 0.5) / 5.0;
        let [r, g, b] = layer.colour(share);
        let style = Style::new().bg(Color::Rgb(r, g, b)).fg(ink([r, g, b]));
        Span::styled(texture(layer, share, true), style)
    };
    let unit = layer.definition().unit;
    let space = if unit.is_empty() { "" } else { " " };
    let mut spans = vec![Span::raw(" "), Span::raw("0 ")];
    spans.extend((0..5).map(step));
    spans.push(Span::raw(format!(" {}{space}{unit}, · not seen ", scale.most)));
    Some(Line::from(spans))
}

/// The character pair of a share of the scale: the darker its colour, the denser.
#[must_use]
pub(crate) fn texture(layer: Layer, share: f64, is_seen: bool) -> &'static str {
    let steps = TEXTURES[usize::from(is_seen)];
    let darkens = layer.scale().is_some_and(|scale| scale.darkens());
    let lightness = if darkens { 1.0 - share } else { share };
    steps[((lightness * 5.0) as usize).min(4)]
}

/// Ink of a texture: a little darker or lighter than the ground, so that the colour stays that of the scale.
#[must_use]
pub(crate) fn ink(ground: [u8; 3]) -> Color {
    let is_dark = colour::contrast(ground, [255, 255, 255]) > 4.5;
    let [r, g, b] =
        ground.map(|part| if is_dark { part.saturating_add(48) } else { part.saturating_sub(48) });
    Color::Rgb(r, g, b)
}

/// How often robots had entered each cell when decision `at` was due, their starts included.
#[must_use]
pub(crate) fn visits(grid: &Grid, hops: &Hops, at: Decision) -> Vec<u16> {
    let mut visits = vec![0_u16; grid.cells()];
    let mut started = [false; 1 << 8];
    let mut enter = |cell| {
        if let Some(index) = grid.index(cell) {
            visits[index] = visits[index].saturating_add(1);
        }
    };
    let flown = at.0.saturating_sub(hops.first().0) as usize;
    for Hop { robot, from, to, .. } in hops.from(hops.first()).take(flown) {
        let is_first =
            started.get_mut(usize::from(robot.0)).is_some_and(|known| !std::mem::replace(known, true));
        if is_first {
            enter(*from);
        }
        if from != to {
            enter(*to);
        }
    }
    visits
}
