//! Shards: equal parts of a campaign that can be flown on different machines.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// Shard `number` of `count`: every `count`-th trial, so that all shards hold the same mix of cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// Number of this shard, 1 to `count`.
    pub number: u64,
    /// Number of shards, 1 to 100,000.
    pub count: u64,
}

impl Shard {
    /// The whole campaign as one shard.
    pub const WHOLE: Self = Self { number: 1, count: 1 };

    /// The trial at position `index`, from 0, of this shard; `None` if a campaign of `trials` has no such trial.
    #[must_use]
    pub fn nth(self, index: u64, trials: u64) -> Option<u64> {
        let trial = index.checked_mul(self.count)?.checked_add(self.number - 1)?;
        (trial < trials).then_some(trial)
    }

    /// Number of trials in this shard of a campaign of `trials`.
    #[must_use]
    pub fn len(self, trials: u64) -> u64 {
        (trials + self.count - self.number) / self.count
    }

    /// Position of `trial` in this shard, from 0; `None` if it belongs to another.
    #[must_use]
    pub fn index_of(self, trial: u64) -> Option<u64> {
        (trial % self.count == self.number - 1).then_some(trial / self.count)
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.count)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| text.parse::<u64>().ok().filter(|n| (1..=100_000).contains(n));
        text.split_once('/')
            .and_then(|(i, n)| Some(Self { number: number(i)?, count: number(n)? }))
            .filter(|shard| shard.number <= shard.count)
            .ok_or_else(|| format!("a shard is I/N with 1 <= I <= N, such as 2/8, got {text:?}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_part_a_campaign_without_gap_or_overlap() {
        for trials in 0..40_u64 {
            for count in 1..9 {
                let mut all: Vec<u64> = (1..=count)
                    .map(|number| Shard { number, count })
                    .flat_map(|shard| {
                        let own: Vec<u64> = (0..).map_while(|index| shard.nth(index, trials)).collect();
                        assert_eq!(own.len() as u64, shard.len(trials));
                        assert!(
                            own.iter().enumerate().all(|(i, trial)| shard.index_of(*trial) == Some(i as u64))
                        );
                        own
                    })
                    .collect();
                all.sort_unstable();
                assert_eq!(all, (0..trials).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn a_shard_is_one_of_its_count() {
        assert_eq!("2/8".parse(), Ok(Shard { number: 2, count: 8 }));
        for text in ["0/3", "4/3", "3", "1/0", "-1/2", "a/b", "1/2/3"] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
    }
}
