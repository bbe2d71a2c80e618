//! The journal of a simulation: opened, replaced by another one, and compared at the end with the undisturbed mission.

use contract::{Decision, Incarnation, Leader, MonotonicNs, Name, Record};
use hopper_sim::{Attachment, Journal, JournalHeader, JournalReader, Mission};
use lockstep::PlannerSchedule;

use super::Simulation;
use crate::disk::Disk;
use crate::figures;
use crate::world::{Event, MS, World};

/// Lives of other instances have numbers from here on.
const ELSEWHERE: u64 = 1 << 40;

/// hopper-sim that could not open its journal is started again after this long, nanoseconds.
const RETRY_NS: u64 = 100 * MS;

impl Simulation<'_> {
    /// Opens the journal, or begins one; what cannot be opened for want of room is tried again.
    pub(super) fn open_journal(&mut self) -> Option<Journal<Disk>> {
        let world = &mut *self.world.borrow_mut();
        let mission = world.checker.mission();
        let (header, terrain) = (JournalHeader::untold(mission), &mission.terrain);
        let (disk, sync) = (world.disk.clone(), world.setup.sync);
        let file = disk.clone();
        let fresh = disk.is_empty();
        let opened = if fresh {
            Journal::create_on(file, &header, sync)
        } else {
            Journal::resume_on(file, &header, terrain, sync)
        };
        let torn = disk.take_torn();
        match opened {
            Ok(journal) => {
                if fresh {
                    world.coverage.count("journal", "begun");
                    if !sync {
                        // Losing power before a header is durable loses the run, which nobody has flown yet.
                        let _ = hopper_sim::Storage::sync(&disk);
                    }
                } else {
                    let over = world.checker.status().is_over();
                    world.coverage.count("journal", if over { "resumed_at_the_end" } else { "resumed" });
                    if journal.len() > contract::limits::PAST_PAGE_RECORDS as u64 {
                        world.coverage.count("journal", "resumed_beyond_a_page");
                    }
                }
                if journal.torn_bytes() > 0 {
                    world.coverage.count("journal", "torn_tail_cut");
                }
                let records: Result<Vec<_>, _> = journal.records().collect();
                match records {
                    Ok(records) => {
                        let may_have_lost = std::mem::take(&mut self.power_lost) && !sync;
                        if records.len() < world.checker.records().len() {
                            world.stamps.rewound();
                        }
                        world.checker.reopened(&records, may_have_lost);
                        world.checker.routes_read(journal.routes());
                    }
                    Err(error) => world.checker.violate("the journal can be read", || error.to_string()),
                }
                Some(journal)
            }
            Err(error) => {
                if fresh {
                    // The real one is written aside and renamed: a failure leaves none.
                    disk.erase();
                }
                if torn || disk.is_full() || disk.is_misplaced() {
                    world.coverage.count("journal", "open_failed");
                    world.note(|| format!("hopper-sim cannot start: {error}"));
                    world.schedule(world.time_ns + RETRY_NS, Event::Start(0));
                } else {
                    world.checker.violate("the journal can be opened again", || error.to_string());
                }
                None
            }
        }
    }

    /// hopper-sim ends, and its journal loses the last `records`; or those, and is flown on elsewhere by another planner for
    /// some hops. All other processes live on.
    pub(super) fn replace_journal(&mut self, records: u64, elsewhere: Option<(Name, u64)>, restart_ns: u64) {
        let can = |world: &World| !world.checker.status().is_over() && !world.disk.is_full();
        if !can(&self.world.borrow()) {
            return;
        }
        self.kill(0, Some(restart_ns), false);
        let Some(journal) = self.open_journal() else { return };
        let mut attachments: Vec<_> = match journal.attached().collect::<Result<Vec<_>, _>>() {
            Ok(attached) => attached.into_iter().map(|(_, attachment)| attachment).collect(),
            Err(_) => return,
        };
        drop(journal);
        let world = &mut *self.world.borrow_mut();
        if !can(world) || world.checker.records().is_empty() {
            return;
        }
        let held = world.checker.records().to_vec();
        let mut kept = held[..held.len().saturating_sub(records as usize)].to_vec();
        attachments.truncate(kept.len());
        if let Some((planner, hops)) = elsewhere {
            let (flown, named) = fly_elsewhere(world.checker.mission(), &kept, planner, hops);
            kept.extend(flown);
            attachments.extend(named);
        }
        let header = JournalHeader::untold(world.checker.mission());
        let elsewhere = Disk::default();
        let written = Journal::create_on(elsewhere.clone(), &header, true).and_then(|mut journal| {
            let mut attached = kept.iter().zip(&attachments);
            attached.try_for_each(|(record, attachment)| journal.append(record, attachment.as_ref()))
        });
        written.expect("a disk that is not full takes everything");
        world.disk.restore(&elsewhere);
        world.lives.iter().for_each(|life| life.disturb_map(world.time_ns));
        let relation = if kept.len() > held.len() { "replaced_after" } else { "replaced_before" };
        world.coverage.count("journal", relation);
        world.note(|| format!("the journal held {} records, and now holds {}", held.len(), kept.len()));
        world.checker.replaced(&kept);
        world.stamps.rewound();
        self.replaced = true;
        world.stirred_ns = world.stirred_ns.max(world.time_ns + restart_ns);
    }

    /// The journal as it lies on the disk, and the undisturbed mission with the same planners.
    pub(super) fn conclude(&mut self) {
        let world = &mut *self.world.borrow_mut();
        let checker = &mut world.checker;
        let read = JournalReader::on(world.disk.clone(), "disk".into()).and_then(|history| {
            let mut reader = history.records();
            let records: Vec<Record> = reader.by_ref().collect::<Result<_, _>>()?;
            Ok((records, reader.into_routes()))
        });
        let records = match read {
            Ok((records, routes)) if records == checker.records() => {
                checker.routes_read(&routes);
                records
            }
            Ok((records, _)) => {
                let held = checker.records().len();
                return checker.violate("what is committed is never lost", || {
                    format!("the disk holds {} records, {held} were committed", records.len())
                });
            }
            Err(error) => return checker.violate("the journal can be read", || error.to_string()),
        };
        let schedule = PlannerSchedule::from_records(records.iter().map(|record| Ok::<_, ()>(*record)))
            .expect("no record is an error");
        let mission = checker.mission().clone();
        let last = Some((Decision(checker.records().len() as u64), checker.digest()));
        let mut undisturbed = Vec::new();
        let flown = lockstep::fly(mission, &schedule, &mut || MonotonicNs(0), &mut |record| {
            undisturbed.push(*record)
        });
        let need = flown.map(|flown| Some((flown.state.decision, flown.state.digest))).unwrap_or_default();
        if last != need {
            checker.violate("the mission has the digest of the undisturbed one", || {
                let (got, need) = (last.map(|last| last.0), need.map(|need| need.0));
                let differs = records.iter().zip(&undisturbed).find(|(is, due)| is.digest != due.digest);
                format!("it ended at {got:?}, undisturbed at {need:?}; first, with its undisturbed record: {differs:?}")
            });
        }
        let differs = records.iter().zip(&undisturbed).find(|(is, due)| is.observation != due.observation);
        if let Some((record, _)) = differs.filter(|_| last == need) {
            let decision = record.decision;
            checker.violate("every decision was taken on the map of the undisturbed mission", || {
                format!("decision {decision} was taken on another")
            });
        }
        let status = checker.status().as_str();
        world.coverage.count("ended", status);
        let flown: Vec<Record> = records.iter().map(|record| world.stamps.as_flown(record)).collect();
        let found = figures::check(&world.checker.mission().brief, &flown);
        world.figured(found);
    }
}

/// The hops that `planner` flies on from the journal that holds `kept`, as some other hopper-sim would have written them down.
fn fly_elsewhere(
    mission: &Mission,
    kept: &[Record],
    planner: Name,
    hops: u64,
) -> (Vec<Record>, Vec<Option<Attachment>>) {
    let held = kept.last().map(|record| record.leader).unwrap_or_default();
    let from = Decision(kept.len() as u64);
    let leader = Leader {
        term: held.term.next(),
        incarnation: Incarnation(ELSEWHERE + held.term.0),
        pid: u32::MAX,
        planner,
    };
    let Some(template) = kept.last() else { return (Vec::new(), Vec::new()) };
    let next = Record { decision: from, leader, origin: contract::Origin::Planner, ..*template };
    let schedule =
        PlannerSchedule::from_records(kept.iter().chain([&next]).map(|record| Ok::<_, ()>(*record)))
            .expect("no record is an error");
    let mut flown = Vec::new();
    // What comes after the hops asked for is flown for nothing: missions are short.
    let ended = lockstep::fly(mission.clone(), &schedule, &mut || MonotonicNs(0), &mut |record| {
        if record.decision >= from && flown.len() < hops as usize && !record.status.is_over() {
            flown.push(Record { leader, ..*record });
        }
    });
    let Ok(ended) = ended else { return (Vec::new(), Vec::new()) };
    let named = flown.iter().map(|record| ended.attachment(record)).collect();
    (flown, named)
}
