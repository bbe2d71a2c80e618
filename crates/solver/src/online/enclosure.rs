//! Bounds on the values around the hopper: what lies behind it is kept in reserve.
//!
//! Two fields, one above the values and one below, and a line behind the hopper: the levels from the line
//! on are frozen. See [`super`] for why the bounds hold.

use super::field::Field;
use super::relaxation::{Limits, Relaxation};

/// First reserve, in units of payoff.
const RESERVE: f64 = 1.0;

/// Largest reserve, in units of the field's magnitude: less than a hop is worth, or thereabouts.
const RESERVE_MAX: f64 = 1.0 / 1024.0;

/// Nothing coarser than the first stage is frozen, and the least reserve leaves room for that: (1 − γ) S.
const _: () = assert!(super::STAGES[0] * super::VALUE_ERROR < 0.5 * RESERVE);

/// Reserves laid on for one decision, at most.
const RESERVES_MAX: usize = 6;

/// The bounds.
#[derive(Clone, Debug, Default)]
pub(super) struct Enclosure {
    /// A super-harmonic field and a sub-harmonic one, but for what has been laid on and not yet written.
    pub bounds: Relaxation<2>,
    /// First frozen level.
    line: usize,
    /// The reserve to lay on next.
    reserve: f64,
    /// Reserve of each level in all.
    laid: Vec<f64>,
    /// How much of it the level's worths contain.
    written: Vec<f64>,
}

impl Enclosure {
    /// Encloses values at rest: nothing is frozen yet, and both bounds are what the values are.
    pub fn draw(&mut self, field: &Field, values: &Relaxation<1>) {
        let levels = field.rings.levels;
        self.bounds.take_over(values);
        self.line = levels;
        self.reserve = RESERVE;
        for laid in [&mut self.laid, &mut self.written] {
            laid.clear();
            laid.resize(levels, 0.0);
        }
    }

    /// First frozen level.
    pub fn line(&self) -> usize {
        self.line
    }

    /// The bounds on a free node's worth: the upper one, the lower one.
    #[cfg(test)]
    pub fn around(&self, field: &Field, node: usize) -> [f64; 2] {
        let (seat, level) =
            field.rings.seat(node).zip(field.rings.level(node)).expect("a free node has a seat");
        let unwritten = self.laid[level] - self.written[level];
        let [upper, lower] = self.bounds.worths.each_ref().map(|worths| worths[seat.place]);
        [upper + unwritten, lower - unwritten]
    }

    /// Draws the line nearer to the centre: what is frozen from now on gets a reserve.
    pub fn draw_in(&mut self, field: &Field, line: usize) {
        debug_assert!(line <= self.line, "nearer than {}, got {line}", self.line);
        self.line = line;
        self.lay(field);
        self.reserve = RESERVE.max(0.5 * self.reserve);
    }

    /// Draws the line farther out: what thaws is to be relaxed.
    pub fn draw_out(&mut self, field: &Field, line: usize) {
        let line = line.min(field.rings.levels);
        for level in self.line..line {
            self.write(field, level);
            self.bounds.touch_level(&field.rings, level);
        }
        self.line = self.line.max(line);
        self.write(field, self.line);
    }

    /// Lays a reserve on all that is frozen. The level before it is to be relaxed.
    fn lay(&mut self, field: &Field) {
        for laid in &mut self.laid[self.line..] {
            *laid += self.reserve;
        }
        self.write(field, self.line);
        if self.line > 0 && self.line < field.rings.levels {
            self.bounds.touch_level(&field.rings, self.line - 1);
        }
    }

    /// Writes a level's reserve into its worths.
    fn write(&mut self, field: &Field, level: usize) {
        if level < self.laid.len() && self.written[level] != self.laid[level] {
            let rise = self.laid[level] - self.written[level];
            self.bounds.raise_level(field, level, [rise, -rise]);
            self.written[level] = self.laid[level];
        }
    }

    /// Brings the bounds to rest at `tolerance` on all that is not frozen, with `relax`, and sees to it that
    /// they hold on what is; whether that was possible.
    pub fn rest(
        &mut self,
        field: &Field,
        limits: &Limits,
        relax: &mut dyn FnMut(&mut Relaxation<2>, &Limits),
    ) -> bool {
        for attempt in 0..RESERVES_MAX {
            let limits = Limits { frozen_from: self.line, ..*limits };
            self.bounds.refine(&field.rings, limits.tolerance, limits.frozen_from);
            relax(&mut self.bounds, &limits);
            if !self.bounds.at_rest(&field.rings, self.line) {
                return false;
            }
            let (wanted, level) = self.wanted(field, limits.finest, attempt > 0);
            if wanted <= 0.0 {
                self.bounds.unmark_from(&field.rings, self.line);
                return true;
            }
            if wanted > field.magnitude * RESERVE_MAX {
                self.draw_out(field, level + 2);
            } else {
                self.reserve = wanted.max(2.0 * self.reserve);
                self.lay(field);
            }
        }
        false
    }

    /// The reserve that the frozen blocks marked would need, and the level that needs it.
    fn wanted(&mut self, field: &Field, tolerance: f64, again: bool) -> (f64, usize) {
        let mut wanted = (0.0, self.line);
        for level in self.bounds.marked_from(&field.rings, self.line) {
            for around in level.saturating_sub(1)..=level + 1 {
                self.write(field, around);
            }
            let short = self.bounds.worst(field, level..level + 1, |[upper, lower]| upper.max(-lower));
            if short > tolerance {
                // At the line the reserve is not laid on what lies inwards; behind it only its discount helps.
                let factor = if level == self.line && !again { 4.0 } else { 1.25 / (1.0 - field.discount) };
                let wants = factor * short;
                if wants > wanted.0 {
                    wanted = (wants, level);
                }
            }
        }
        wanted
    }
}
