//! What a whole journal proves, checked from its first byte to its last.

use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

use contract::{Decision, Digest, Incarnation, Name, Profile, Record, RobotId, RunId, Status, Term};
use report::{Fallbacks, Leadership};
use serde::Serialize;

use super::audit::{Audit, Fault};
use super::world::NoWorld;
use super::{JournalError, JournalReader, Storage};
use crate::mission::{genesis, opening_status};

/// What a journal proves.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verification {
    /// Nonce that was drawn when the journal was created.
    pub run: RunId,
    /// Name of the scenario.
    pub scenario: Name,
    /// Seed of all chance in the mission.
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
    /// The first field of the header or of a record that is not what it must be.
    pub fault: Option<Fault>,
    /// Why no record could be executed again, so that outcomes are not checked: a file of the ground is missing or has other contents.
    pub unrepeated: Option<String>,
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
        faults.extend(self.fault.iter().map(Fault::to_string));
        faults
    }

    /// What `history` proves.
    ///
    /// # Errors
    /// If it cannot be read through.
    pub fn of<S: Storage>(history: &JournalReader<S>) -> Result<Self, JournalError> {
        let (terrain, unrepeated, fault) = match history.header().world() {
            Ok(world) => (Some(world.terrain), None, None),
            Err(NoWorld::NotAtHand(reason)) => (None, Some(reason), None),
            Err(NoWorld::Contradicts(disagreement)) => (None, None, Some(Fault::of_header(disagreement))),
        };
        let mut audit = Audit::new(history.header(), terrain);
        let mut verification = Self { outcome: audit.status(), unrepeated, fault, ..Self::new(history) };
        let (mut due, mut commanders) = (Decision(0), BTreeMap::new());
        let mut records = history.records();
        while let Some(record) = records.next().transpose()? {
            verification.observe(&record, &mut due, &mut commanders);
            if verification.fault.is_none() {
                verification.fault = audit.observe(&record, records.attachment()).err();
            }
        }
        verification.torn_bytes = records.torn_bytes();
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
            fault: None,
            unrepeated: None,
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
        if let Some(reason) = &self.unrepeated {
            fact("outcomes", format!("not executed again, since the ground is not at hand: {reason}"))?;
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

/// Checks the journal in `dir` without locking or changing it.
///
/// # Errors
/// If it cannot be read through: missing, a damaged header, a broken frame before whole ones.
pub fn verify(dir: &Path) -> Result<Verification, JournalError> {
    Verification::of(&JournalReader::open(dir)?)
}

impl<S: Storage> JournalReader<S> {
    /// What shows missions is given those alone whose records can have been flown.
    ///
    /// # Errors
    /// [`JournalError::NotSound`] if the records are not sound; else if they cannot be read through.
    pub fn require_sound(&self) -> Result<(), JournalError> {
        match Verification::of(self)?.faults() {
            faults if faults.is_empty() => Ok(()),
            faults => Err(JournalError::NotSound { path: self.path().into(), faults }),
        }
    }
}
