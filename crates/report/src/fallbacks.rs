//! Counts how often the guard of hopper-sim intervened.

use contract::Origin;
use serde::{Deserialize, Serialize};

use crate::phrases::counted;

/// Number of fallback actions by their origin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Fallbacks {
    /// Actions of the last policy.
    pub policy: u64,
    /// Actions that the guard's greedy rule chose.
    pub greedy: u64,
    /// Decisions to hold.
    pub hold: u64,
}

impl Fallbacks {
    /// Adds one action of `origin`; a planner's is not counted.
    pub fn count(&mut self, origin: Origin) {
        match origin {
            Origin::Planner => {}
            Origin::Policy => self.policy += 1,
            Origin::Greedy => self.greedy += 1,
            Origin::Hold => self.hold += 1,
        }
    }

    /// Number of fallback actions of all origins.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.policy + self.greedy + self.hold
    }
}

/// The interventions of the guard as a phrase: "3 vetoes, 2 fallbacks (1 by policy, 1 greedy)".
#[must_use]
pub fn guard_phrase(vetoes: u64, fallbacks: Fallbacks) -> String {
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
    fn fallbacks_are_counted_by_origin_and_summed_up_in_a_phrase() {
        let mut fallbacks = Fallbacks::default();
        assert_eq!(guard_phrase(1, fallbacks), "1 veto");
        Origin::ALL.into_iter().chain([Origin::Greedy]).for_each(|origin| fallbacks.count(origin));
        assert_eq!(fallbacks.total(), 4);
        assert_eq!(guard_phrase(3, fallbacks), "3 vetoes, 4 fallbacks (1 by policy, 2 greedy, 1 held)");
    }
}
