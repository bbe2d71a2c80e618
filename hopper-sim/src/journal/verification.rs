//! What a whole journal proves, checked from its first byte to its last.

use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

use contract::{Decision, Digest, Incarnation, Name, Profile, Record, RobotId, RunId, Status, Term};
use report::{Fallbacks, Leadership};
use scenario::Scenario;
use serde::Serialize;

use super::{JournalError, JournalHeader, JournalReader, Storage};
use crate::RobotTeam;
use crate::mission::{genesis, opening_status};

/// What a journal proves.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verification {
    /// Nonce that was drawn when the journal was created.
    pub run: RunId,
    /// Name of the scenario.
    pub scenario: Name,
    /// Of all chance in the mission.
    pub seed: u64,
    /// Reading of the model.
    pub profile: Profile,
    /// Decisions executed, each counted once.
    pub decisions: u64,
    /// Whether none is missing from 0 on.
    pub contiguous: bool,
    /// Records of decisions that had been executed already.
    pub duplicates: u64,
    /// The digest chain, computed anew from genesis.
    pub digest: Digest,
    /// First decision whose record disagrees with that chain, if one does.
    pub digest_broken_at: Option<Decision>,
    /// How the mission stands after the last record.
    pub outcome: Status,
    /// Steps after the last record, in the paper's count.
    pub steps: u64,
    /// Records that follow the end of the mission.
    pub after_the_end: u64,
    /// Whether terms only rise.
    pub terms_rise: bool,
    /// Actions that the guard vetoed.
    pub vetoes: u64,
    /// What the fallback did.
    pub fallbacks: Fallbacks,
    /// Bytes after the last whole frame.
    pub torn_bytes: u64,
    /// Terms in order, each with its planner and its first decision.
    pub planners: Vec<Leadership>,
    /// The life that commanded last; 0 if none has.
    pub commander: Incarnation,
}

/// The life that commanded each robot last.
type Commanders = BTreeMap<RobotId, Incarnation>;

impl Verification {
    /// Whether every decision was executed exactly once and the chain holds. A torn tail is no
    /// fault: what was not wholly written did not happen.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        self.faults().is_empty()
    }

    /// What is wrong, a sentence each.
    #[must_use]
    pub fn faults(&self) -> Vec<String> {
        let mut faults = Vec::new();
        if !self.contiguous {
            faults.push("a decision is missing".into());
        }
        if self.duplicates > 0 {
            faults.push(format!("{} records repeat a decision", self.duplicates));
        }
        if let Some(decision) = self.digest_broken_at {
            faults.push(format!("the digest chain breaks at decision {decision}"));
        }
        if self.after_the_end > 0 {
            faults.push(format!("{} records follow the end of the mission", self.after_the_end));
        }
        if !self.terms_rise {
            faults.push("a term falls, or changes hands without rising".into());
        }
        faults
    }

    /// What `history` proves.
    ///
    /// # Errors
    /// If it cannot be read through.
    pub fn of<S: Storage>(history: &JournalReader<S>) -> Result<Self, JournalError> {
        let mut verification = Self::new(history);
        let (mut due, mut commanders) = (Decision(0), BTreeMap::new());
        let mut records = history.records();
        for record in &mut records {
            verification.observe(&record?, &mut due, &mut commanders);
        }
        verification.torn_bytes = records.torn_bytes();
        if verification.decisions == 0 {
            verification.outcome = opening_status_of(history.header());
        }
        Ok(verification)
    }

    fn new<S: Storage>(history: &JournalReader<S>) -> Self {
        let header = history.header();
        let brief = &header.brief;
        Self {
            run: header.run(),
            scenario: brief.scenario,
            seed: header.seed,
            profile: brief.profile,
            decisions: 0,
            contiguous: true,
            duplicates: 0,
            digest: genesis(brief, header.seed),
            digest_broken_at: None,
            outcome: opening_status(brief),
            steps: header.brief.reading.opening_steps,
            after_the_end: 0,
            terms_rise: true,
            vetoes: 0,
            fallbacks: Fallbacks::default(),
            torn_bytes: 0,
            planners: Vec::new(),
            commander: Incarnation::default(),
        }
    }

    /// Folds in the next record; `due` is the decision after the highest so far.
    fn observe(&mut self, record: &Record, due: &mut Decision, commanders: &mut Commanders) {
        if record.decision < *due {
            self.duplicates += 1;
        } else {
            self.contiguous &= record.decision == *due;
            self.decisions += 1;
            *due = Decision(record.decision.0.saturating_add(1));
        }
        let digest = self.digest.chain(record);
        if (record.previous, record.digest) != (self.digest, digest) {
            self.digest_broken_at.get_or_insert(record.decision);
        }
        self.digest = digest;
        self.after_the_end += u64::from(self.outcome.is_over());
        self.outcome = record.status;
        self.steps = record.steps;
        self.vetoes += record.vetoed.count();
        self.fallbacks.count(record.origin);
        // A fallback leaves the command where it is.
        if !record.origin.is_fallback() {
            self.name_planner(record, commanders);
        }
    }

    fn name_planner(&mut self, record: &Record, commanders: &mut Commanders) {
        let (leader, robot) = (&record.leader, record.robot);
        let before = commanders.insert(robot, leader.incarnation).unwrap_or_default();
        let last = self.planners.iter().rev().find(|leadership| leadership.robot == robot);
        let goes_on = last.is_some_and(|last| (last.name, last.term) == (leader.planner, leader.term))
            && before == leader.incarnation;
        // Term 0 is before every planner; a change of hands takes a higher term.
        self.terms_rise &= goes_on || leader.term > last.map_or(Term(0), |last| last.term);
        self.commander = leader.incarnation;
        Leadership::note(&mut self.planners, leader, robot, record.decision);
    }
}

impl fmt::Display for Verification {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut fact = |name: &str, text: String| writeln!(f, "  {name:<10}  {text}");
        fact(
            "run",
            format!("{} of {}, seed {}, profile {}", self.run, self.scenario, self.seed, self.profile),
        )?;
        fact("decisions", format!("{}, {} steps, {}", self.decisions, self.steps, self.outcome))?;
        for leadership in &self.planners {
            fact("command", leadership.to_string())?;
        }
        if self.vetoes > 0 || self.fallbacks.total() > 0 {
            fact("guard", report::guard_phrase(self.vetoes, self.fallbacks))?;
        }
        fact("digest", self.digest.to_string())?;
        if self.torn_bytes > 0 {
            fact(
                "torn",
                format!("{} bytes after the last whole record, to be cut on resume", self.torn_bytes),
            )?;
        }
        for fault in self.faults() {
            fact("FAULT", fault)?;
        }
        fact(
            "verdict",
            if self.is_sound() { "sound: each decision exactly once" } else { "NOT SOUND" }.into(),
        )
    }
}

/// How the mission of `header` stands before its first command. Whether several robots have anything to do depends on the ground,
/// which may be no longer there: then as if they had.
fn opening_status_of(header: &JournalHeader) -> Status {
    let team = header.fleet.as_ref().and_then(|fleet| {
        let scenario = Scenario::parse(&header.resolved, "the journal's scenario").ok()?;
        let world = scenario.resolve().ok().filter(|world| world.terrain.grid == header.brief.grid)?;
        Some(RobotTeam::new(&header.brief, &world.terrain, fleet))
    });
    team.map_or_else(|| opening_status(&header.brief), |team| team.opening(&header.brief).0)
}

/// Checks the journal in `dir` without locking or changing it.
///
/// # Errors
/// If it cannot be read through: missing, a damaged header, a broken frame before whole ones.
pub fn verify(dir: &Path) -> Result<Verification, JournalError> {
    Verification::of(&JournalReader::open(dir)?)
}
