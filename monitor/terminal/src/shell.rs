//! The terminal itself: its keys, its screen, and a clean end.

use std::io::IsTerminal;
use std::time::Duration;

use contract::{Decision, MonotonicNs, Role};
use node::{Exit, Failure, hold_log_back};
use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

use monitor::{Chronicle, Screen, Wish};

use crate::picture::{Knobs, draw};

/// Maps longer than this are followed from the start: whole, they would be a blot.
const WHOLE_CELLS_MAX: u32 = 60;

/// The screen, for as long as it lives; dropping it gives the terminal back as it was.
#[derive(Debug)]
pub struct Terminal {
    screen: DefaultTerminal,
    knobs: Knobs,
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
        let screen = ratatui::try_init().map_err(Failure::run)?;
        hold_log_back(true);
        let knobs = Knobs { policy: true, control, ..Knobs::default() };
        Ok(Self { screen, knobs, begun: false })
    }

    fn press(&mut self, key: &KeyEvent, account: &Chronicle) -> Option<Wish> {
        if key.kind != KeyEventKind::Press {
            return None;
        }
        let due = account.hops().map_or(Decision(0), |hops| hops.due());
        let tell = |order| self.knobs.control.then_some(Wish::Order(order));
        let paused = account.tempo().is_some_and(|tempo| tempo.paused);
        let heeds = account.tempo().is_none_or(|tempo| tempo.heeds);
        match key.code {
            KeyCode::Char('c') if key.modifiers.contains(KeyModifiers::CONTROL) => return Some(Wish::Quit),
            KeyCode::Char('q') | KeyCode::Esc => return Some(Wish::Quit),
            KeyCode::Char(' ' | 's') if !heeds => {
                tracing::warn!("hopper-sim obeys no orders: it was started without --control");
            }
            KeyCode::Char(' ') => {
                return tell(if paused { contract::Order::Resume } else { contract::Order::Pause });
            }
            KeyCode::Char('s') => return tell(contract::Order::Step),
            KeyCode::Char('h') => {
                let leader = account.state().map(|state| state.leader.incarnation);
                let peers = account.lives().peers();
                let stands_by = peers.iter().find(|peer| {
                    peer.beat.role == Role::Planner && !peer.silent && Some(peer.beat.incarnation) != leader
                });
                return stands_by.and_then(|peer| tell(contract::Order::HandOver(peer.beat.incarnation)));
            }
            KeyCode::Left => self.knobs.go(-1, due),
            KeyCode::Right => self.knobs.go(1, due),
            KeyCode::PageUp => self.knobs.go(-10, due),
            KeyCode::PageDown => self.knobs.go(10, due),
            KeyCode::Home => self.knobs.at = Some(Decision(0)),
            KeyCode::End => self.knobs.at = None,
            KeyCode::Char('p') => self.knobs.policy = !self.knobs.policy,
            KeyCode::Char('f') => self.knobs.follow = !self.knobs.follow,
            _ => {}
        }
        None
    }
}

impl Screen for Terminal {
    fn wants_policy(&self) -> bool {
        self.knobs.policy
    }

    fn show(&mut self, account: &Chronicle, now: MonotonicNs) -> Result<Vec<Wish>, Failure> {
        if let Some(brief) = account.brief_known().filter(|_| !self.begun) {
            self.begun = true;
            self.knobs.follow = brief.grid.width.max(brief.grid.height) > WHOLE_CELLS_MAX;
            self.knobs.policy &= !self.knobs.follow;
        }
        let mut wishes = Vec::new();
        while event::poll(Duration::ZERO).map_err(Failure::run)? {
            if let Event::Key(key) = event::read().map_err(Failure::run)? {
                wishes.extend(self.press(&key, account));
            }
        }
        self.screen.draw(|frame| draw(frame, account, &self.knobs, now)).map_err(Failure::run)?;
        Ok(wishes)
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        // Whoever is gone by now needs no terminal.
        let _ = ratatui::try_restore();
        hold_log_back(false);
    }
}
