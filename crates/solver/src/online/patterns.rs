//! The soils of blocks, each pattern stored once.
//!
//! A visit reads the soils of its block's lanes, five cache lines of numbers. Where soils form
//! patches, few patterns make up all blocks: one soil throughout, or an edge between two. Stored once each, they stay in
//! the nearest cache.

use std::collections::BTreeMap;

use super::kernel::{SoilCoefficients, SoilLanes};
use crate::simd::DOUBLE_LANES as LANES;

/// Classes of an entry: its soil, or that no backup may change it.
pub(super) const CLASSES: usize = 8;

/// Classes of a block's lanes.
pub(super) type Pattern = [u8; LANES];

/// The patterns that blocks have, numbered. A number that no block has any more is reused.
#[derive(Clone, Debug)]
pub(super) struct Patterns {
    /// The soil of each class.
    scatters: [SoilCoefficients; CLASSES],
    numbers: BTreeMap<Pattern, u32>,
    /// For each number its pattern, the soils of the pattern, and how many blocks have it.
    patterns: Vec<Pattern>,
    soils: Vec<SoilLanes>,
    blocks: Vec<u32>,
    /// Numbers that no block has.
    vacant: Vec<u32>,
}

impl Patterns {
    /// `blocks` blocks that all have `pattern`, number 0; `scatters` are the soils of the classes.
    pub fn new(scatters: [SoilCoefficients; CLASSES], pattern: Pattern, blocks: usize) -> Self {
        let mut patterns = Self {
            scatters,
            numbers: BTreeMap::new(),
            patterns: Vec::new(),
            soils: Vec::new(),
            blocks: Vec::new(),
            vacant: Vec::new(),
        };
        let first = patterns.number(pattern);
        patterns.blocks[first as usize] = blocks as u32;
        patterns
    }

    /// The soils of the patterns, by number.
    #[inline(always)]
    pub fn soils(&self) -> &[SoilLanes] {
        &self.soils
    }

    /// The new number of a block that had number `before` and now has `pattern`.
    pub fn change(&mut self, before: u32, pattern: Pattern) -> u32 {
        if self.patterns[before as usize] == pattern {
            return before;
        }
        let left = &mut self.blocks[before as usize];
        *left -= 1;
        if *left == 0 {
            self.numbers.remove(&self.patterns[before as usize]);
            self.vacant.push(before);
        }
        let number = self.number(pattern);
        self.blocks[number as usize] += 1;
        number
    }

    /// The number of a pattern; assigns one if it has none.
    fn number(&mut self, pattern: Pattern) -> u32 {
        if let Some(number) = self.numbers.get(&pattern) {
            return *number;
        }
        let soils = SoilLanes::each(pattern.map(|class| &self.scatters[usize::from(class)]));
        let number = match self.vacant.pop() {
            Some(number) => {
                (self.patterns[number as usize], self.soils[number as usize]) = (pattern, soils);
                number
            }
            None => {
                self.patterns.push(pattern);
                self.soils.push(soils);
                self.blocks.push(0);
                self.soils.len() as u32 - 1
            }
        };
        self.numbers.insert(pattern, number);
        number
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::SplitMix64;

    #[test]
    fn blocks_share_numbers_with_their_likes_alone_and_no_number_is_kept_for_nobody() {
        let scatter = |share: f64| SoilCoefficients { ahead: share, sideways: 0.0, stuck: 0.0, gain: 1.0 };
        let scatters = std::array::from_fn(|class| scatter(0.1 * class as f64));
        let mut blocks: Vec<(u32, Pattern)> = vec![(0, [2; LANES]); 12];
        let mut patterns = Patterns::new(scatters, [2; LANES], blocks.len());
        let mut draw = SplitMix64(1);
        for step in 0..4_000 {
            let at = (draw.uniform() * blocks.len() as f64) as usize;
            let (before, mut pattern) = blocks[at];
            let lane = (draw.uniform() * 3.0) as usize;
            pattern[lane] = (draw.uniform() * 3.0) as u8;
            blocks[at] = (patterns.change(before, pattern), pattern);
            for (number, pattern) in &blocks {
                assert_eq!(patterns.patterns[*number as usize], *pattern, "step {step}");
                let soils = SoilLanes::each(pattern.map(|class| &scatters[usize::from(class)]));
                let shared = &patterns.soils()[*number as usize];
                assert_eq!(format!("{shared:?}"), format!("{soils:?}"), "step {step}");
                let alike = blocks.iter().filter(|other| other.1 == *pattern);
                assert!(alike.clone().all(|other| other.0 == *number), "step {step}");
                assert_eq!(alike.count(), patterns.blocks[*number as usize] as usize, "step {step}");
            }
            assert!(patterns.soils().len() <= blocks.len(), "step {step}");
        }
    }
}
