//! The decision that is planned for.

use contract::{Decision, Digest, RunId, State, Vetoed};

/// What is planned for: a decision, on the timeline of a digest, and what the guard has vetoed there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Due {
    run: RunId,
    decision: Decision,
    digest: Digest,
    vetoed: Vetoed,
}

impl Due {
    /// What is due by `state`.
    pub fn of(state: &State) -> Self {
        let State { run, decision, digest, vetoed, .. } = *state;
        Self { run, decision, digest, vetoed }
    }

    /// Whether that is what is due by `state`. Asked at every event: nothing is copied.
    pub fn is_of(&self, state: &State) -> bool {
        let Self { run, decision, digest, vetoed } = self;
        (run, decision, digest, vetoed) == (&state.run, &state.decision, &state.digest, &state.vetoed)
    }
}
