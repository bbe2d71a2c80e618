//! What the ground of the terminal's map shows.

use contract::{Account, Brief, Decision, Grid};
use monitor::history::{Hop, Hops};
use ratatui::style::{Color, Style};
use ratatui::text::{Line, Span};
use report::picture::colour;
use speed_layer::{SPEED_MAX_M_PER_SOL, SPREAD_MAX_M_PER_SOL, SpeedEstimate};

/// A layer of the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Layer {
    /// Heights, soil and impassable ground.
    #[default]
    Ground,
    /// How often robots entered each cell.
    Visits,
    /// Expected speed of a rover.
    Speed,
    /// Standard deviation of that speed.
    Spread,
}

/// From the least to the most: without colours the characters tell shades apart.
const TEXTURES: [[&str; 5]; 2] = [["█·", "▓·", "▒·", "░·", " ·"], ["██", "▓▓", "▒▒", "░░", "  "]];

impl Layer {
    /// The layers of a mission, in the order in which a key goes through them.
    #[must_use]
    pub fn of(brief: &Brief) -> &'static [Layer] {
        match (brief.sampling.is_some(), brief.has_team()) {
            (true, _) => &[Layer::Ground, Layer::Visits, Layer::Speed, Layer::Spread],
            (false, true) => &[Layer::Ground, Layer::Visits],
            (false, false) => &[Layer::Ground],
        }
    }

    /// The layer that is shown first.
    #[must_use]
    pub fn first(brief: &Brief) -> Layer {
        match (brief.sampling.is_some(), brief.account == Account::Hopper) {
            (true, _) => Layer::Speed,
            (false, true) => Layer::Ground,
            (false, false) => Layer::Visits,
        }
    }

    /// Above the map.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Layer::Ground => "ground",
            Layer::Visits => "visits",
            Layer::Speed => "expected speed",
            Layer::Spread => "spread of speed",
        }
    }

    /// Below the map: the scale, with its unit.
    #[must_use]
    pub fn legend(self) -> Option<Line<'static>> {
        let (least, most) = match self {
            Layer::Ground => return None,
            Layer::Visits => return Some(Line::raw(" ∙ once  : twice  ∴ three times  ∷ more ")),
            Layer::Speed => ("0 ", format!(" {SPEED_MAX_M_PER_SOL:.0} m/Sol, · not seen ")),
            Layer::Spread => ("0 ", format!(" {SPREAD_MAX_M_PER_SOL:.0} m/Sol, · not seen ")),
        };
        let step = |n: u32| {
            let share = (f64::from(n) + 0.5) / 5.0;
            let [r, g, b] = self.colour(share);
            let style = Style::new().bg(Color::Rgb(r, g, b)).fg(ink([r, g, b]));
            Span::styled(self.texture(share, true), style)
        };
        let mut spans = vec![Span::raw(" "), Span::raw(least)];
        spans.extend((0..5).map(step));
        spans.push(Span::raw(most));
        Some(Line::from(spans))
    }

    /// What of an estimate it shows, as a share of its scale; `None` if it shows something else.
    #[must_use]
    pub fn share(self, estimate: SpeedEstimate) -> Option<f64> {
        match self {
            Layer::Ground | Layer::Visits => None,
            Layer::Speed => Some(estimate.mean_m_per_sol / SPEED_MAX_M_PER_SOL),
            Layer::Spread => Some(estimate.sd_m_per_sol / SPREAD_MAX_M_PER_SOL),
        }
    }

    /// Colour at a share of the scale, as in the pictures.
    #[must_use]
    pub fn colour(self, share: f64) -> [u8; 3] {
        match self {
            Layer::Ground | Layer::Visits => colour::height_rgb(share),
            Layer::Speed => colour::ramp(&colour::SPEEDS, share),
            Layer::Spread => colour::ramp(&colour::SPREADS, share),
        }
    }

    /// The character pair of a share of the scale: the denser the slower, or the less certain.
    #[must_use]
    pub fn texture(self, share: f64, is_seen: bool) -> &'static str {
        let steps = TEXTURES[usize::from(is_seen)];
        let density = if self == Layer::Spread { 1.0 - share } else { share };
        steps[((density * 5.0) as usize).min(4)]
    }
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
