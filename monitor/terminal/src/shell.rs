//! The terminal itself: its keys, its screen, and a clean end.

use std::io::IsTerminal;
use std::time::Duration;

use contract::{Decision, MonotonicNs};
use node::{Exit, Failure, hold_log_back};
use ratatui::DefaultTerminal;
use ratatui::buffer::Buffer;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

use monitor::{History, Screen, Wish};

use crate::ViewSettings;
use crate::picture::draw;
use crate::scrollback::leave_behind;

/// Maps longer than this are followed from the start: whole, they would be a blot.
const WHOLE_CELLS_MAX: u32 = 60;

/// The screen, for as long as it lives; dropping it gives the terminal back as it was.
#[derive(Debug)]
pub struct Terminal {
    screen: DefaultTerminal,
    settings: ViewSettings,
    /// The last picture, which stays on the terminal.
    last: Option<Buffer>,
    /// Whether the map's size has been looked at.
    begun: bool,
}

impl Terminal {
    /// Takes the terminal over.
    ///
    /// # Errors
    /// If standard output is none.
    pub fn open(control: bool) -> Result<Self, Failure> {
        if !std::io::stdout().is_terminal() {
            return Err(Failure::new(Exit::Usage, "--tui needs a terminal on standard output"));
        }
        if std::env::var_os("TERM").is_none_or(|name| name.is_empty() || name == "dumb") {
            let why = "--tui needs a terminal that can draw, got one whose TERM is dumb or not set: leave --tui out for lines";
            return Err(Failure::new(Exit::Usage, why));
        }
        let screen = ratatui::try_init().map_err(Failure::run)?;
        hold_log_back(true);
        let settings = ViewSettings { policy: true, control, ..ViewSettings::default() };
        Ok(Self { screen, settings, last: None, begun: false })
    }

    fn press(&mut self, key: &KeyEvent, history: &History) -> Option<Wish> {
        if key.kind != KeyEventKind::Press {
            return None;
        }
        let due = history.hops().map_or(Decision(0), |hops| hops.due());
        let order = |order| self.settings.control.then_some(Wish::Order(order));
        let paused = history.pacing().is_some_and(|pacing| pacing.paused);
        let obeys = history.pacing().is_none_or(|pacing| pacing.obeys);
        match lower(key.code) {
            KeyCode::Char('c') if key.modifiers.contains(KeyModifiers::CONTROL) => {
                return Some(Wish::Quit);
            }
            KeyCode::Char('q') => return Some(Wish::Quit),
            KeyCode::Esc => self.settings.back(),
            KeyCode::Char('?') => self.settings.keys = !self.settings.keys,
            KeyCode::Char(' ' | 'k' | 's') if !obeys => {
                tracing::warn!("hopper-sim obeys no orders: it was started without --control");
            }
            KeyCode::Char(' ' | 'k') => {
                return order(if paused { contract::Order::Resume } else { contract::Order::Pause });
            }
            KeyCode::Char('s') => return order(contract::Order::Step),
            KeyCode::Char('h') => {
                return history
                    .stand_by()
                    .and_then(|peer| order(contract::Order::HandOver(peer.beat.incarnation)));
            }
            KeyCode::Left => self.settings.go(-1, due),
            KeyCode::Right => self.settings.go(1, due),
            KeyCode::PageUp => self.settings.go(-10, due),
            KeyCode::PageDown => self.settings.go(10, due),
            KeyCode::Home => self.settings.at = Some(Decision(0)),
            KeyCode::End => self.settings.at = None,
            KeyCode::Char('p') => self.settings.policy = !self.settings.policy,
            KeyCode::Char('m') => {
                if let Some(brief) = history.brief() {
                    self.settings.next_layer(brief);
                }
            }
            KeyCode::Char('f') => self.settings.follow = !self.settings.follow,
            _ => {}
        }
        None
    }
}

/// A key in lower case, as the page takes it.
fn lower(code: KeyCode) -> KeyCode {
    match code {
        KeyCode::Char(character) => KeyCode::Char(character.to_ascii_lowercase()),
        other => other,
    }
}

impl Screen for Terminal {
    fn wants_policy(&self) -> bool {
        self.settings.policy
    }

    fn show(&mut self, history: &History, now: MonotonicNs) -> Result<Vec<Wish>, Failure> {
        if !self.begun
            && let Some(brief) = history.brief()
        {
            self.begun = true;
            // Robots that go from point to point are far apart: of them the whole map is shown.
            let is_large = brief.grid.width.max(brief.grid.height) > WHOLE_CELLS_MAX;
            self.settings.follow = is_large && brief.sampling.is_none();
            self.settings.policy &= !self.settings.follow;
        }
        let mut wishes = Vec::new();
        while event::poll(Duration::ZERO).map_err(Failure::run)? {
            if let Event::Key(key) = event::read().map_err(Failure::run)? {
                wishes.extend(self.press(&key, history));
            }
        }
        let drawn =
            self.screen.draw(|frame| draw(frame, history, &self.settings, now)).map_err(Failure::run)?;
        self.last = history.brief().map(|_| drawn.buffer.clone());
        Ok(wishes)
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        // Whoever is gone by now needs no terminal.
        let _ = ratatui::try_restore();
        if let Some(last) = &self.last {
            let _ = leave_behind(last, &mut std::io::stdout().lock());
        }
        hold_log_back(false);
    }
}
