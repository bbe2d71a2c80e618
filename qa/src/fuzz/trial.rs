//! What must hold for a drafted mission, in one thread.

use std::panic::{AssertUnwindSafe, catch_unwind};

use contract::{Digest, MonotonicNs, Name, Record, RobotId, RobotSet};
use hopper_sim::{Attachment, Journal, JournalHeader, Mission};
use lockstep::PlannerSchedule;
use serde::Serialize;
use simulation::disk::Disk;
use simulation::fault::{Kind as FaultKind, Plan};
use simulation::setup::Seat;
use simulation::{Given, shrink, simulate_given};

use super::Draft;

/// A promise that did not hold.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Broken {
    /// The promise, in words.
    pub promise: String,
    /// What was found instead.
    pub detail: String,
}

fn broken(promise: &str, detail: impl Into<String>) -> Broken {
    Broken { promise: promise.into(), detail: detail.into() }
}

/// A mission that was flown undisturbed.
#[derive(Clone, Debug)]
pub struct Flown {
    /// Every decision.
    pub records: Vec<Record>,
    /// Digest of the last one; of the mission where there is none.
    pub digest: Digest,
    /// What each of them names.
    attachments: Vec<Option<Attachment>>,
}

/// A mission in which every promise held.
#[derive(Clone, Debug)]
pub struct Checked {
    /// The mission undisturbed.
    pub flown: Flown,
    /// Whether it was also flown with simulated faults.
    pub simulated: bool,
}

/// Flies a drafted mission in lockstep, again and again, and with faults.
///
/// # Errors
/// The promise that did not hold.
pub fn check(draft: &Draft) -> Result<Checked, Broken> {
    let checked = catch_unwind(AssertUnwindSafe(|| {
        let flown = in_lockstep(draft)?;
        let simulated = with_faults(draft)?;
        Ok(Checked { flown, simulated })
    }));
    checked.unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().cloned();
        let text = text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned()));
        Err(broken("nothing panics", text.unwrap_or_default()))
    })
}

/// The mission of a draft in lockstep.
///
/// # Errors
/// If its digest depends on anything but the mission.
///
/// # Panics
/// If lockstep stalls, or the draft cannot be flown.
pub fn in_lockstep(draft: &Draft) -> Result<Flown, Broken> {
    let (mission, planners) = draft.mission().expect("a draft can be flown");
    let schedule = PlannerSchedule::of_robots(&planners);
    let flown = fly(&mission, &schedule)?;
    if !flown.records.last().is_none_or(|last| last.status.is_over()) {
        return Err(broken("a mission ends", "it does not"));
    }
    same("a mission flown twice has one digest", &flown, &fly(&mission, &schedule)?)?;
    let relieved = PlannerSchedule::relieved(&flown.records);
    if !relieved.is_empty() {
        let fresh = fly(&mission, &relieved)?;
        same("a decision depends on no planner's past", &flown, &fresh)?;
    }
    let world = draft.world().expect("a draft can be flown");
    let again = scenario::Scenario::parse(&world.resolved, "the canonical text")
        .and_then(|scenario| scenario.resolve())
        .map_err(|error| broken("the canonical text of a scenario can be flown", error.to_string()))?;
    if again.hash != world.hash {
        let detail = format!("its hash is another: {}", world.resolved);
        return Err(broken("the canonical text of a scenario is the same mission", detail));
    }
    journalled(&mission, &flown)?;
    Ok(flown)
}

fn fly(mission: &Mission, schedule: &PlannerSchedule) -> Result<Flown, Broken> {
    let mut records = Vec::new();
    // Any clock will do, and one that goes on shows that nothing depends on it.
    let mut ns = 0;
    let mut clock = || {
        ns += 1_000_003;
        MonotonicNs(ns)
    };
    let flown = lockstep::fly(mission.clone(), schedule, &mut clock, &mut |record| records.push(*record))
        .map_err(|error| broken("every planner suits its robot", error.to_string()))?;
    let attachments = records.iter().map(|record| flown.attachment(record)).collect();
    Ok(Flown { records, digest: flown.state.digest, attachments })
}

fn same(promise: &str, one: &Flown, other: &Flown) -> Result<(), Broken> {
    let outline = |record: &Record| (record.digest, record.observation);
    let differs = one.records.iter().zip(&other.records).find(|(one, other)| outline(one) != outline(other));
    if let Some((one, other)) = differs {
        return Err(broken(promise, format!("decision {} is {one:?} and {other:?}", one.decision)));
    }
    if one.digest == other.digest {
        return Ok(());
    }
    let lengths = (one.records.len(), other.records.len());
    Err(broken(promise, format!("{} and {} decisions end with different digests", lengths.0, lengths.1)))
}

/// The journal of the mission can be read to its end, and resumed.
fn journalled(mission: &Mission, flown: &Flown) -> Result<(), Broken> {
    let promise = "the journal of a mission can be resumed";
    let refused = |error: hopper_sim::JournalError| broken(promise, error.to_string());
    let header = JournalHeader::untold(mission);
    let disk = Disk::default();
    let mut journal = Journal::create_on(disk.clone(), &header, false).map_err(refused)?;
    for (record, attachment) in flown.records.iter().zip(&flown.attachments) {
        journal.append(record, attachment.as_ref()).map_err(refused)?;
    }
    drop(journal);
    let journal = Journal::resume_on(disk, &header, &mission.terrain, false).map_err(refused)?;
    let read: Vec<Record> = journal.records().collect::<Result<_, _>>().map_err(refused)?;
    if read != flown.records {
        return Err(broken(promise, format!("{} of {} records are read", read.len(), flown.records.len())));
    }
    Ok(())
}

/// The planner processes of a mission: one for each algorithm, with all robots that name it.
fn seats(planners: &[Name]) -> Vec<Seat> {
    let mut seats: Vec<Seat> = Vec::new();
    for (robot, planner) in (0..).map(RobotId).zip(planners) {
        match seats.iter_mut().find(|seat| seat.planner == *planner) {
            Some(seat) => seat.robots = seat.robots.with(robot),
            None => seats.push(Seat { planner: *planner, robots: RobotSet(0).with(robot) }),
        }
    }
    seats
}

/// The faults of a draft's seed, whose rivals are planners of its robots.
fn plan(draft: &Draft, seats: &[Seat]) -> Plan {
    let mut plan = Plan::of(draft.kind.missions(), draft.seed);
    for (number, fault) in plan.faults.iter_mut().enumerate() {
        if let FaultKind::Rival { seat, .. } | FaultKind::ForeignBuild { seat } = &mut fault.kind {
            *seat = seats[number % seats.len()];
        }
    }
    plan
}

/// The mission under a virtual clock, with the faults of its seed; false if it is none that the simulation's checker computes.
fn with_faults(draft: &Draft) -> Result<bool, Broken> {
    let (mission, planners) = draft.mission().expect("a draft can be flown");
    // The checker computes flights on cells of a metre, as the worlds of its seeds have.
    if mission.brief.has_team() && (mission.brief.grid.cell_size_m - 1.0).abs() > 1e-9 {
        return Ok(false);
    }
    let given = Given { planners: seats(&planners), mission };
    let plan = plan(draft, &given.planners);
    let report = simulate_given(&plan, &given, false);
    let Some(violation) = report.violation else { return Ok(true) };
    let fewer = shrink::shrink(&plan, violation.rule, |plan| simulate_given(plan, &given, false).violation);
    let detail = format!("{}; with the faults {:#?}", violation.detail, fewer.faults);
    Err(broken(violation.rule, detail))
}
