//! What monitors know of the mission.

use std::collections::BTreeSet;

use contract::protocol::peer_table::SILENCE_NS;
use contract::{Decision, Digest, Incarnation, MonotonicNs, Record, RunId};
use report::Tally;

use super::Checker;

impl Checker {
    /// A monitor that records acknowledges the end of the mission, with these decisions on record.
    pub(crate) fn recorded(
        &mut self,
        monitor: Incarnation,
        recorded: &BTreeSet<(Decision, Digest)>,
        now: MonotonicNs,
    ) {
        let heard = self.acquaintance.last_heard(monitor, self.sim);
        let asked = heard.is_some_and(|at| now.since_ns(at) < SILENCE_NS);
        let is_missing = |record: &&Record| !recorded.contains(&(record.decision, record.digest));
        let missing = self.records.iter().find(is_missing).map(|record| record.decision);
        let held = self.records.len();
        self.require(
            !asked || missing.is_none(),
            "the end is acknowledged once every decision is recorded",
            || format!("decision {missing:?} of {held} is missing in the recording"),
        );
    }

    /// The watcher has taken account of everything up to `tally`.
    pub fn watched(&mut self, tally: &Tally, run: RunId, is_final: bool) {
        if run != self.mission.brief.run || self.violation.is_some() {
            return;
        }
        let due = tally.due();
        let need = self.state_at(due).map(|state| (state.digest, state.pose, state.steps));
        let got = tally.last.map(|last| (last.digest, last.pose, last.steps));
        // Who has not heard yet that the journal was replaced holds what it held before.
        let is_lost =
            tally.last.is_some_and(|last| self.lost.get(&last.digest) == Some(&(due, last.pose, last.steps)));
        if is_lost && !is_final {
            return;
        }
        let route = &tally.route;
        let known = self.records.iter().take(due.0 as usize);
        let in_route = known.filter(|record| self.model.is_on_route(record.robot)).count() as u64;
        let whole = route.hops() + route.held == in_route && (due == Decision(0) || need == got);
        self.require(whole, "the monitor knows what the journal holds", || {
            format!("its tally through {due} is another's")
        });
    }
}
