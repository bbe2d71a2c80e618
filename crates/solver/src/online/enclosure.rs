//! Bounds on the values around the hopper: two fields, one above the values and one below.
//!
//! Levels far behind the hopper are frozen, and an offset keeps the bounds valid there. See [`super`] for why they hold.

use super::layout::Layout;
use super::relaxation::{Limits, Relaxation};
use super::tolerance::{STAGES, VALUE_ERROR};

/// First and least offset, in units of payoff.
const OFFSET: f64 = 1.0;

/// Largest offset, in units of the layout's magnitude: about what a hop is worth, or less.
const OFFSET_MAX: f64 = 1.0 / 1024.0;

/// Nothing coarser than the first stage is frozen, and the slack (1 − γ) S of the least offset covers that.
const _: () = assert!(STAGES[0] * VALUE_ERROR < 0.5 * OFFSET);

/// Most offsets added for one decision.
const OFFSETS_MAX: usize = 6;

/// The bounds, and how far they are frozen.
#[derive(Clone, Debug, Default)]
pub(super) struct Enclosure {
    /// A super-harmonic field and a sub-harmonic one, except for offsets not yet applied.
    pub bounds: Relaxation<2>,
    /// First frozen level.
    frozen_from: usize,
    /// The offset to add next.
    next_offset: f64,
    /// Sum of the offsets of each level.
    offsets: Vec<f64>,
    /// The part of it that the level's values contain.
    applied: Vec<f64>,
}

impl Enclosure {
    /// Starts with nothing frozen, and with converged values as both bounds.
    pub fn start(&mut self, layout: &Layout, values: &Relaxation<1>) {
        let levels = layout.rings.levels;
        self.bounds.copy_from(values);
        self.frozen_from = levels;
        self.next_offset = OFFSET;
        for sums in [&mut self.offsets, &mut self.applied] {
            sums.clear();
            sums.resize(levels, 0.0);
        }
    }

    /// First frozen level.
    pub fn frozen_from(&self) -> usize {
        self.frozen_from
    }

    /// The upper and the lower bound on a free node's afterstate value.
    #[cfg(test)]
    pub fn bounds_at(&self, layout: &Layout, node: usize) -> [f64; 2] {
        let (slot, level) =
            layout.rings.slot(node).zip(layout.rings.level(node)).expect("a free node has a slot");
        let pending = self.offsets[level] - self.applied[level];
        let [upper, lower] = self.bounds.afterstates.each_ref().map(|afterstates| afterstates[slot.entry]);
        [upper + pending, lower - pending]
    }

    /// Freezes the levels from `level` on, and adds an offset to all frozen ones.
    pub fn freeze_from(&mut self, layout: &Layout, level: usize) {
        debug_assert!(level <= self.frozen_from, "needs a level up to {}, got {level}", self.frozen_from);
        self.frozen_from = level;
        self.add_offset(layout);
        self.next_offset = OFFSET.max(0.5 * self.next_offset);
    }

    /// Thaws the levels before `end`, and marks them.
    pub fn thaw_to(&mut self, layout: &Layout, end: usize) {
        let end = end.min(layout.rings.levels);
        for level in self.frozen_from..end {
            self.apply(layout, level);
            self.bounds.mark_level(&layout.rings, level);
        }
        self.frozen_from = self.frozen_from.max(end);
        self.apply(layout, self.frozen_from);
    }

    /// Adds an offset to all frozen levels, and marks the level before them.
    fn add_offset(&mut self, layout: &Layout) {
        for offset in &mut self.offsets[self.frozen_from..] {
            *offset += self.next_offset;
        }
        self.apply(layout, self.frozen_from);
        if self.frozen_from > 0 && self.frozen_from < layout.rings.levels {
            self.bounds.mark_level(&layout.rings, self.frozen_from - 1);
        }
    }

    /// Applies a level's offset to its values.
    fn apply(&mut self, layout: &Layout, level: usize) {
        if level < self.offsets.len() && self.applied[level] != self.offsets[level] {
            let rise = self.offsets[level] - self.applied[level];
            self.bounds.raise_level(layout, level, [rise, -rise]);
            self.applied[level] = self.offsets[level];
        }
    }

    /// Converges the bounds at the tolerance of `limits` on the clear levels, with `relax`, and makes sure that they hold
    /// on the frozen ones; whether that was possible.
    pub fn converge(
        &mut self,
        layout: &Layout,
        limits: &Limits,
        relax: &mut dyn FnMut(&mut Relaxation<2>, &Limits),
    ) -> bool {
        for attempt in 0..OFFSETS_MAX {
            let limits = Limits { frozen_from: self.frozen_from, ..*limits };
            self.bounds.refine(&layout.rings, limits.tolerance, limits.frozen_from);
            relax(&mut self.bounds, &limits);
            if !self.bounds.is_converged(&layout.rings, self.frozen_from) {
                return false;
            }
            let (needed, level) = self.needed(layout, limits.finest, attempt > 0);
            if needed <= 0.0 {
                self.bounds.unmark_from(&layout.rings, self.frozen_from);
                return true;
            }
            if needed > layout.magnitude * OFFSET_MAX {
                self.thaw_to(layout, level + 2);
            } else {
                self.next_offset = needed.max(2.0 * self.next_offset);
                self.add_offset(layout);
            }
        }
        false
    }

    /// The offset that the marked frozen blocks need, and the level that needs it.
    fn needed(&mut self, layout: &Layout, tolerance: f64, again: bool) -> (f64, usize) {
        let mut needed = (0.0, self.frozen_from);
        for level in self.bounds.marked_from(&layout.rings, self.frozen_from) {
            for around in level.saturating_sub(1)..=level + 1 {
                self.apply(layout, around);
            }
            let short = self.bounds.worst(layout, level..level + 1, |[upper, lower]| upper.max(-lower));
            if short > tolerance {
                // At the first frozen level the neighbours inwards get no offset; further out only its discount helps.
                let factor =
                    if level == self.frozen_from && !again { 4.0 } else { 1.25 / (1.0 - layout.discount) };
                let needs = factor * short;
                if needs > needed.0 {
                    needed = (needs, level);
                }
            }
        }
        needed
    }
}
