//! What the journal holds: decisions in order, under a chain of digests, commanded and executed as they have to be.

use contract::{Action, Branch, Decision, Leader, Record, RunId, Team};
use hopper_sim::Execution;

use super::{Checker, Sent};
use crate::expected::next_digest;

/// Routes that a robot announces at most before it goes on: two planners may command it in turn.
const ANNOUNCEMENTS_MAX: u64 = 4;

impl Checker {
    /// A decision was executed: more may be seen.
    pub(super) fn see(&mut self, record: &Record) {
        self.model.see(Some(record), &mut self.maps.expected);
        self.maps.mapped_at(record.digest);
    }

    /// The journal holds another record.
    pub fn committed(&mut self, record: &Record) {
        let due = Decision(self.records.len() as u64);
        self.require(record.decision == due, "one command is executed per decision", || {
            format!("decision {} was committed, {due} was due", record.decision)
        });
        let before = self.state_at(due).unwrap_or(self.opening);
        self.require(!before.status.is_over(), "nothing follows the end", || {
            format!("decision {due} was committed after {}", before.status)
        });
        let previous = self.digest();
        let chained = record.previous == previous && record.digest == next_digest(previous, record);
        self.require(chained, "the digest chain is intact", || format!("it breaks at decision {due}"));
        if !before.status.is_over() {
            let need = self.model.execute(&before, record.action);
            let Record { robot, outcome, pose, detail, collected, steps, visits, status, .. } = *record;
            let got = Some((robot, Execution { outcome, pose, detail, collected, steps, visits, status }));
            self.require(need == got, "the outcome depends on seed, robot and decision alone", || {
                format!("decision {due} came out as {got:?}, needs {need:?}")
            });
        }
        let leader = self.leader_of(record.robot);
        self.succession(leader, record);
        self.guarded(&before, record);
        if record.origin.is_fallback() {
            self.fell_back(leader, record);
        } else {
            let sent = self.sent.contains(&signature(record, self.mission.brief.run));
            self.require(sent, "what is executed was commanded", || {
                format!("nobody sent decision {due} as {} of {:?}", record.action, record.leader)
            });
            let seen = self.maps.prints.get(&previous) == Some(&record.observation);
            self.require(seen, "nobody decides before the map covers the decision", || {
                format!("decision {due} was taken on another map")
            });
        }
        self.records.push(*record);
        self.model.committed(record);
        self.see(record);
        let all_wait = self.model.is_all_waiting();
        let is_last = all_wait && record.action == Action::Wait && record.outcome.branch == Branch::Held;
        self.require(!is_last, "nobody waits for others as the last one that can act", || {
            format!("robot {} did at decision {due}", record.robot)
        });
        self.goes_on(record);
    }

    /// Whoever has announced a route goes on along it: while no other robot acts, it announces no others again and again.
    pub(super) fn goes_on(&mut self, record: &Record) {
        let Record { robot, action, decision, .. } = *record;
        let (last, times) = self.announcements;
        let times = match action {
            Action::Announce(_) if last == robot => times + 1,
            Action::Announce(_) => 1,
            _ => 0,
        };
        self.announcements = (robot, times);
        self.require(times <= ANNOUNCEMENTS_MAX, "who has announced a route goes on along it", || {
            format!("robot {robot} announced {times} routes one after the other up to decision {decision}")
        });
    }

    pub(super) fn succession(&mut self, held: Leader, record: &Record) {
        let Record { decision, leader, .. } = *record;
        let Leader { term, incarnation, planner, .. } = leader;
        let goes_on = term == held.term && (incarnation, planner) == (held.incarnation, held.planner);
        self.require(goes_on || term == held.term.next(), "terms only rise, by one", || {
            format!("decision {decision}: term {} of {} after {}", term, incarnation, held.term)
        });
        let owner = self.succession.owner(record);
        self.require(owner == incarnation, "no term is shared by two planners", || {
            format!("decision {decision}: term {term} of {incarnation} was {owner}'s")
        });
    }

    /// hopper-sim has opened the journal, which holds `records`; `may_have_lost` after a loss of power
    /// without --sync.
    pub fn reopened(&mut self, records: &[Record], may_have_lost: bool) {
        let known = self.records.len().min(records.len());
        let (kept, more) = records.split_at(known);
        let whole = kept == &self.records[..known] && (may_have_lost || known == self.records.len());
        let (held, got) = (self.records.len(), records.len());
        self.require(whole, "what is committed is never lost", || {
            format!("the journal held {held} records, and was opened again with {got}")
        });
        self.require(more.len() <= 1, "one command is executed per decision", || {
            format!("{} records appeared in the journal by themselves", more.len())
        });
        if known < self.records.len() {
            self.rewind(known);
        }
        for record in more {
            self.committed(record);
        }
    }

    /// The journal has lost its tail, as it may.
    pub(super) fn rewind(&mut self, kept: usize) {
        let kept: Vec<Record> = self.records[..kept].to_vec();
        let mission = self.mission.clone();
        self.begin(&mission);
        for record in &kept {
            self.committed(record);
        }
    }

    /// The journal was replaced by one that holds `records`: an earlier state of itself, perhaps flown on elsewhere. What
    /// was told of the hops that are gone may still be heard.
    pub(crate) fn replaced(&mut self, records: &[Record]) {
        let run = self.mission.brief.run;
        let (visible, mut lost) = (self.maps.visible.clone(), std::mem::take(&mut self.lost));
        lost.extend(
            self.records
                .iter()
                .map(|record| (record.digest, (record.decision.next(), record.pose, record.steps))),
        );
        self.sent.extend(records.iter().map(|record| signature(record, run)));
        let mission = self.mission.clone();
        self.begin(&mission);
        records.iter().for_each(|record| self.committed(record));
        self.lost = lost;
        for (index, was_visible) in visible.into_iter().enumerate() {
            self.maps.visible[index] |= was_visible;
        }
    }

    /// hopper-sim publishes all robots.
    pub(crate) fn team_published(&mut self, team: &Team) {
        let held = self.records.len() as u64;
        // While an action is in the air the robots before it are published again; they are compared once it has landed.
        if team.decision.0 != held || team.run != self.mission.brief.run {
            let right = team.decision.0 < held || team.run != self.mission.brief.run;
            return self.require(right, "nothing is published that the journal does not hold", || {
                format!("the robots of decision {}, the journal holds {held}", team.decision)
            });
        }
        let digest = self.digest();
        let need = self.model.team(team.run, team.decision, digest);
        self.require(need == *team, "the robots are where the journal leaves them", || {
            format!("told {team:?}, needs {need:?}")
        });
    }
}

fn signature(record: &Record, run: RunId) -> Sent {
    let action: Action = record.action;
    let Leader { incarnation, term, .. } = record.leader;
    (run, record.robot, incarnation, record.decision, record.previous, term, action.code(), action.route())
}
