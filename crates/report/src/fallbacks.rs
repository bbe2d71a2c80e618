//! How often the guard in hopper-sim stepped in.

use contract::Origin;
use serde::{Deserialize, Serialize};

use crate::ending::counted;

/// What the fallback did, by where the action came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Fallbacks {
    /// By the last policy.
    pub policy: u64,
    /// Greedily.
    pub greedy: u64,
    /// Held.
    pub hold: u64,
}

impl Fallbacks {
    /// Counts one more action of `origin`; a planner's is none.
    pub fn count(&mut self, origin: Origin) {
        match origin {
            Origin::Planner => {}
            Origin::Policy => self.policy += 1,
            Origin::Greedy => self.greedy += 1,
            Origin::Hold => self.hold += 1,
        }
    }

    /// All of them.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.policy + self.greedy + self.hold
    }
}

/// What the guard did, in a phrase: "3 vetoes, 2 fallbacks (1 by policy, 1 greedy)".
#[must_use]
pub fn guarded(vetoes: u64, fallbacks: Fallbacks) -> String {
    let mut phrase = if vetoes == 1 { "1 veto".to_owned() } else { format!("{vetoes} vetoes") };
    let Fallbacks { policy, greedy, hold } = fallbacks;
    let kinds = [(policy, "by policy"), (greedy, "greedy"), (hold, "held")];
    let kinds: Vec<String> =
        kinds.iter().filter(|(count, _)| *count > 0).map(|(count, how)| format!("{count} {how}")).collect();
    if !kinds.is_empty() {
        phrase += &format!(", {} ({})", counted(fallbacks.total(), "fallback"), kinds.join(", "));
    }
    phrase
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fallbacks_are_counted_by_kind_and_told_in_a_phrase() {
        let mut fallbacks = Fallbacks::default();
        assert_eq!(guarded(1, fallbacks), "1 veto");
        Origin::ALL.into_iter().chain([Origin::Greedy]).for_each(|origin| fallbacks.count(origin));
        assert_eq!(fallbacks.total(), 4);
        assert_eq!(guarded(3, fallbacks), "3 vetoes, 4 fallbacks (1 by policy, 2 greedy, 1 held)");
    }
}
