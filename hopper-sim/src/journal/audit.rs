//! What each record of a journal must be, given those before it: the one check that verifying a journal and resuming it share.
//!
//! Where the ground of the mission is at hand, every record is executed again by the [`Arbiter`] that would have made it, and
//! must come out the same in every field but its times, which no decision depends on. So a resumed mission goes on from
//! what it would have been, and nothing that a decision depends on is taken from a record unchecked. Without the ground
//! only that is checked which follows from header and records alone.
//!
//! A record does not show which actions were tried in vain: of its vetoes it is checked that the guard vetoes each, not that
//! somebody tried it, nor that none is missing. No later decision depends on them.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

use contract::{
    Announcement, Brief, Cell, Command, Decision, Digest, Incarnation, Leader, MonotonicNs, Name, Record,
    Refusal, RobotId, Status, Timing,
};
use serde::Serialize;
use terrain::Terrain;

use super::JournalHeader;
use super::disagreement::Disagreement;
use crate::mission::{genesis, opening_status};
use crate::{Arbiter, Attachment, Effect, Event, Fallback, Mission, Pace};

/// The first thing that is wrong with a journal.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Fault {
    /// Which record it is in, counted from 0 as they lie in the file; `None` for the header.
    pub record: Option<u64>,
    /// The field of the record, or its path in the header.
    pub field: Cow<'static, str>,
    /// What it needs to be.
    pub need: String,
    /// What it is.
    pub got: String,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { record, field, need, got } = self;
        match record {
            Some(record) => write!(f, "record {record}: {field} needs {need}, got {got}"),
            None => write!(f, "header: {field} needs {need}, got {got}"),
        }
    }
}

impl Fault {
    pub(super) fn of_header(Disagreement { field, need, got }: Disagreement) -> Self {
        Self { record: None, field: field.into(), need, got }
    }
}

/// Checks the records of a journal, one after the other. Its size does not depend on how many there are.
#[derive(Debug)]
pub(super) struct Audit {
    brief: Brief,
    /// Records so far.
    records: u64,
    /// Digest after the last record.
    digest: Digest,
    /// Status after the last record.
    status: Status,
    /// Who leads each robot after the last record.
    leaders: BTreeMap<RobotId, Leader>,
    /// The mission as the records so far leave it, if its ground is at hand.
    arbiter: Option<Box<Arbiter>>,
    /// Whether hops end by the law of the papers.
    is_law: bool,
    /// Of a hopper that is alone, where it is, its goals visited and its steps.
    alone: (Cell, u64, u64),
}

impl Audit {
    /// Before the first record of the journal with that header; `terrain` is the ground of its mission.
    ///
    /// # Panics
    /// If the ground is another mission's.
    pub fn new(header: &JournalHeader, terrain: Option<Arc<Terrain>>) -> Self {
        let JournalHeader { brief, seed, dynamics, faults, .. } = header;
        let mission = terrain.map(|terrain| Mission {
            brief: brief.clone(),
            terrain,
            seed: *seed,
            dynamics: dynamics.clone(),
            // Nobody plans.
            table: None,
            faults: faults.clone(),
        });
        let begin = |mission| Arbiter::new(mission, None, Pace::Max, 0, MonotonicNs(0)).without_deadlines();
        let arbiter = mission.map(|mission| Box::new(begin(mission)));
        Self {
            brief: brief.clone(),
            records: 0,
            digest: genesis(brief, *seed),
            status: arbiter.as_ref().map_or_else(|| opening_status(brief), |arbiter| arbiter.state().status),
            leaders: BTreeMap::new(),
            arbiter,
            is_law: dynamics.is_law(),
            alone: (brief.robots[0].start.cell, 0, brief.reading.opening_steps),
        }
    }

    /// How the mission stands after the records so far.
    pub fn status(&self) -> Status {
        self.status
    }

    /// Checks the next record, with what it names. After a fault nothing more can be said.
    ///
    /// # Errors
    /// The first field that is not what it must be.
    pub fn observe(&mut self, record: &Record, attachment: Option<&Attachment>) -> Result<(), Fault> {
        let number = self.records;
        let at =
            |(field, need, got): Difference| Fault { record: Some(number), field: field.into(), need, got };
        self.follows(record).map_err(at)?;
        match &mut self.arbiter {
            Some(arbiter) => repeat(arbiter, record, attachment).map_err(at)?,
            None => self.is_possible(record).map_err(at)?,
        }
        let digest = self.digest.chain(record);
        same("digest", digest, record.digest).map_err(at)?;
        self.records += 1;
        (self.digest, self.status) = (digest, record.status);
        self.leaders.insert(record.robot, record.leader);
        self.alone = (record.outcome.to, record.visits, record.steps);
        Ok(())
    }

    /// Whether the record is the next one, of a robot of the mission, under a leader that may follow the one before.
    fn follows(&self, record: &Record) -> Result<(), Difference> {
        same("decision", Decision(self.records), record.decision)?;
        same("previous", self.digest, record.previous)?;
        if self.status.is_over() {
            return Err((
                "status",
                format!("no record after the end, {}", self.status),
                record.status.to_string(),
            ));
        }
        if record.robot.0 >= self.brief.robots.count() {
            let need = format!("a robot below {}", self.brief.robots.count());
            return Err(("robot", need, record.robot.to_string()));
        }
        self.may_lead(record)?;
        if record.origin.is_fallback() && self.brief.guard.deadline_ns == 0 {
            return Err((
                "origin",
                "planner, since the mission has no deadline".into(),
                record.origin.to_string(),
            ));
        }
        are_in_order(&record.timing)
    }

    /// Whether the record's leader may follow that of the record before of the same robot.
    fn may_lead(&self, record: &Record) -> Result<(), Difference> {
        let (held, leader) = (self.leaders.get(&record.robot).copied().unwrap_or_default(), record.leader);
        let is_led = held != Leader::default();
        let (stays, rises) = (leader == held, leader.term == held.term.next());
        let may_command = rises || stays && is_led;
        if record.origin.is_fallback() && !stays {
            return Err((
                "leader",
                format!("the one before, {held:?}, since a fallback commands nobody"),
                format!("{leader:?}"),
            ));
        }
        if !record.origin.is_fallback() && !may_command {
            let need = match is_led {
                true => format!("{held:?}, or another one under term {}", held.term.next()),
                false => format!("one under term {}", held.term.next()),
            };
            return Err(("leader", need, format!("{leader:?}")));
        }
        // A command without either is none.
        let is_named = leader.planner != Name::NONE && leader.incarnation != Incarnation::default();
        if !record.origin.is_fallback() && !is_named {
            return Err(("leader", "a planner with a name and an incarnation".into(), format!("{leader:?}")));
        }
        Ok(())
    }

    /// What of the record of a hopper that is alone follows from its action and branch, whatever the ground.
    fn is_possible(&self, record: &Record) -> Result<(), Difference> {
        if self.brief.has_team() {
            return Ok(());
        }
        let (from, visits, steps) = self.alone;
        let outcome = &record.outcome;
        same("outcome.from", from, outcome.from)?;
        let landing = |direction| motion::landing(&self.brief.grid, from, direction, outcome.branch);
        let to = record.action.hop().map_or(from, landing);
        // Physics may lead anywhere.
        let to = if self.is_law { to } else { outcome.to };
        same("outcome.to", to, outcome.to)?;
        same("pose.cell", to, record.pose.cell)?;
        same("visits", visits + u64::from(self.brief.is_visit(visits, to)), record.visits)?;
        if record.steps < steps {
            return Err(("steps", format!("at least {steps}"), record.steps.to_string()));
        }
        Ok(())
    }
}

/// A field, what it needs to be, and what it is.
type Difference = (&'static str, String, String);

fn same<T: PartialEq + fmt::Debug>(field: &'static str, need: T, got: T) -> Result<(), Difference> {
    if need == got { Ok(()) } else { Err((field, format!("{need:?}"), format!("{got:?}"))) }
}

/// Checks the stamps that hopper-sim itself takes, all in one life. Stamps of other processes are not checked, nor those of different
/// records against each other: after a reboot the clock starts again.
fn are_in_order(timing: &Timing) -> Result<(), Difference> {
    let Timing { landed, state_published, accepted, committed, .. } = *timing;
    let not_before = |field, need: MonotonicNs, got: MonotonicNs| match got < need {
        true => Err((field, format!("at least {}", need.0), got.0.to_string())),
        false => Ok(()),
    };
    not_before("timing.state_published", landed, state_published)?;
    not_before("timing.accepted", state_published, accepted)?;
    // A record is written before its commit is over, so both are the moment at which it was made.
    same("timing.committed", accepted.0, committed.0)
}

/// Has the arbiter do what the record says, and compares what it comes to.
fn repeat(arbiter: &mut Arbiter, record: &Record, attachment: Option<&Attachment>) -> Result<(), Difference> {
    same("robot", arbiter.due(), record.robot)?;
    if let Err(action) = arbiter.recall_vetoes(record.vetoed) {
        return Err(("vetoed", "only what the guard vetoes".into(), action.to_string()));
    }
    let (run, robot) = (arbiter.state().run, record.robot);
    if let Some(Attachment::Route(route)) = attachment {
        arbiter
            .on(Event::Announcement(Ok(Announcement { run, robot, route: route.clone() })), MonotonicNs(0));
    }
    let event = match record.origin.is_fallback() {
        true => Event::Repeat(fallback(arbiter, record)?),
        false => Event::Command(Ok(command(arbiter, record))),
    };
    // The first command publishes the state before it is judged.
    let effects = arbiter.on(event, MonotonicNs(0));
    let answer = |effect: &Effect| matches!(effect, Effect::Append(_) | Effect::Refused(_));
    match effects.into_iter().find(answer) {
        Some(Effect::Append(need)) => compare(&need, record)?,
        Some(Effect::Refused(refusal)) => return Err(refused(&refusal, record)),
        _ => return Err(("status", "a mission that goes on".into(), arbiter.state().status.to_string())),
    }
    arbiter.on(Event::Appended, MonotonicNs(0));
    Ok(())
}

/// The command that the record says was executed.
fn command(arbiter: &Arbiter, record: &Record) -> Command {
    let (Leader { term, incarnation, pid, planner }, timing) = (record.leader, &record.timing);
    Command {
        run: arbiter.state().run,
        robot: record.robot,
        decision: record.decision,
        digest: record.previous,
        term,
        action: record.action,
        observation: record.observation,
        planner,
        incarnation,
        pid,
        work: record.work,
        cut: record.cut,
        sensed: timing.sensed,
        map_published: timing.map_published,
        planning_started: timing.planning_started,
        planning_ended: timing.planning_ended,
    }
}

/// The fallback that the record says was executed: the one that is due without a policy, or what a policy may have said,
/// which no record holds.
fn fallback(arbiter: &Arbiter, record: &Record) -> Result<Fallback, Difference> {
    let (got, need) = (Fallback { action: record.action, origin: record.origin }, arbiter.fallback());
    let may_be_advised = arbiter.follows_policies()
        && got.origin == contract::Origin::Policy
        && got.action.hop().is_some()
        && arbiter.refusal_of(got.action).is_none();
    if got == need || may_be_advised {
        return Ok(got);
    }
    let field = if got.origin == need.origin { "action" } else { "origin" };
    Err((field, format!("{} by {}", need.action, need.origin), format!("{} by {}", got.action, got.origin)))
}

fn refused(refusal: &Refusal, record: &Record) -> Difference {
    let is_of_term =
        matches!(refusal, Refusal::StaleTerm { .. } | Refusal::FutureTerm { .. } | Refusal::NotLeader { .. });
    match is_of_term {
        true => ("leader", refusal.to_string(), format!("{:?}", record.leader)),
        false => ("action", "one that is not refused".into(), format!("{}: {refusal}", record.action)),
    }
}

/// Compares a record with what it needs to be, field by field.
fn compare(need: &Record, got: &Record) -> Result<(), Difference> {
    // Named one by one, so that a new field is either compared or left out on purpose.
    let Record {
        robot,
        decision,
        leader,
        action,
        origin,
        vetoed,
        observation,
        work,
        cut,
        outcome,
        pose,
        detail,
        collected,
        visits,
        steps,
        status,
        // When something happened: nothing depends on it, and the clock of that time is gone. Their order is checked before.
        timing: _,
        previous,
        // Compared by the chain, after all that it covers.
        digest: _,
    } = *got;
    same("robot", need.robot, robot)?;
    same("decision", need.decision, decision)?;
    same("leader", need.leader, leader)?;
    same("action", need.action, action)?;
    same("origin", need.origin, origin)?;
    same("vetoed", need.vetoed, vetoed)?;
    same("observation", need.observation, observation)?;
    same("work", need.work, work)?;
    same("cut", need.cut, cut)?;
    same("outcome.branch", need.outcome.branch, outcome.branch)?;
    same("outcome.from", need.outcome.from, outcome.from)?;
    same("outcome.to", need.outcome.to, outcome.to)?;
    same("outcome.flight", need.outcome.flight, outcome.flight)?;
    same("pose.cell", need.pose.cell, pose.cell)?;
    same("pose.height_m", need.pose.height_m, pose.height_m)?;
    same("detail", need.detail, detail)?;
    same("collected", need.collected, collected)?;
    same("visits", need.visits, visits)?;
    same("steps", need.steps, steps)?;
    same("status", need.status, status)?;
    same("previous", need.previous, previous)
}
