//! A bug planted in each rule of the protocol is found.
//!
//! Each bug is a [`Meddler`] around the true machines: what a machine without that rule would hear or want.

use std::collections::{BTreeMap, BTreeSet};

use contract::{
    Command, Decision, Incarnation, Leader, MapPatch, MonotonicNs, ObservedMap, PastPage, Record, Refusal,
    RunId, SeenCell,
};
use hopper::simulate::disk::Disk;
use hopper::simulate::meddler::Meddler;
use hopper::simulate::sweep;
use hopper_sim::dynamics::{Execution, execute};
use hopper_sim::{Arbiter, Effect, Event, Mission, Storage};
use perception::Cartographer;
use planner::pilot::{self, Pilot};
use terrain::Terrain;

use crate::undisturbed::SEEDS;

/// P-PLANTED: plants the bug under every seed until one shows it; the failure is then small, and told in full.
#[allow(clippy::print_stderr, reason = "a test tells which seed found it")]
pub(crate) fn is_found<M: Meddler + Default>() {
    let bug = std::any::type_name::<M>();
    let campaign = sweep(SEEDS, M::default, |_| ());
    let Some(failing) = campaign.failure else {
        panic!("{bug}: not found in {} seeds", campaign.seeds);
    };
    let kept = failing.plan.faults.len();
    eprintln!(
        "{bug}: seed {}, {} of {} faults, {} lines: {} ({})",
        failing.seed,
        kept,
        failing.faults,
        failing.trace.len(),
        failing.violation.rule,
        failing.violation.detail,
    );
    assert!(kept <= failing.faults.min(4), "{bug}: {kept} of {} faults are left", failing.faults);
    assert!(!failing.trace.is_empty());
}

/// Rewrites commands that a rule would refuse into such as pass; the record keeps who really commanded.
#[derive(Default)]
struct Disguise {
    leader: Option<Leader>,
}

impl Disguise {
    /// Lets `command` pass for one of the planner in command.
    fn pass(&mut self, arbiter: &Arbiter, command: Command) -> Option<Event> {
        let held = arbiter.state().leader;
        let Command { incarnation, pid, planner, term, .. } = command;
        self.leader = Some(Leader { term, incarnation, pid, planner });
        let Leader { term, incarnation, pid, planner } = held;
        Some(Event::Command(Ok(Command { term, incarnation, pid, planner, ..command })))
    }

    fn sign(&mut self, effects: &mut [Effect]) {
        let Some(leader) = self.leader.take() else { return };
        for effect in effects {
            if let Effect::Append(record) = effect {
                record.leader = leader;
            }
        }
    }
}

/// Whether `command` is for the decision that is due, and `wrong` about it.
fn due_but(arbiter: &Arbiter, command: &Command, wrong: bool) -> bool {
    let state = arbiter.state();
    command.run == state.run && command.decision == state.decision && wrong
}

/// A term that has passed is accepted.
#[derive(Default)]
struct StaleTermAccepted {
    disguise: Disguise,
}

impl Meddler for StaleTermAccepted {
    fn arbiter_hears(&mut self, arbiter: &Arbiter, event: Event) -> Option<Event> {
        match event {
            Event::Command(Ok(command))
                if due_but(arbiter, &command, command.term < arbiter.state().leader.term) =>
            {
                self.disguise.pass(arbiter, command)
            }
            event => Some(event),
        }
    }

    fn arbiter_wants(&mut self, _: &Arbiter, effects: &mut Vec<Effect>) {
        self.disguise.sign(effects);
    }
}

/// A term in force is accepted from whoever uses it.
#[derive(Default)]
struct TermReused {
    disguise: Disguise,
}

impl Meddler for TermReused {
    fn arbiter_hears(&mut self, arbiter: &Arbiter, event: Event) -> Option<Event> {
        let held = arbiter.state().leader;
        match event {
            Event::Command(Ok(command))
                if due_but(arbiter, &command, command.term == held.term)
                    && command.incarnation != held.incarnation =>
            {
                self.disguise.pass(arbiter, command)
            }
            event => Some(event),
        }
    }

    fn arbiter_wants(&mut self, _: &Arbiter, effects: &mut Vec<Effect>) {
        self.disguise.sign(effects);
    }
}

/// Changes a command before the arbiter judges it.
fn altered(event: Event, alter: impl FnOnce(Command) -> Command) -> Option<Event> {
    Some(match event {
        Event::Command(Ok(command)) => Event::Command(Ok(alter(command))),
        event => event,
    })
}

/// A term that leaps ahead is accepted.
#[derive(Default)]
struct LeapAccepted {
    disguise: Disguise,
}

impl Meddler for LeapAccepted {
    fn arbiter_hears(&mut self, arbiter: &Arbiter, event: Event) -> Option<Event> {
        match event {
            Event::Command(Ok(command))
                if due_but(arbiter, &command, command.term > arbiter.state().leader.term.next()) =>
            {
                self.disguise.pass(arbiter, command)
            }
            event => Some(event),
        }
    }

    fn arbiter_wants(&mut self, _: &Arbiter, effects: &mut Vec<Effect>) {
        self.disguise.sign(effects);
    }
}

/// A command for another run is executed.
#[derive(Default)]
struct OldRunAccepted;

impl Meddler for OldRunAccepted {
    fn arbiter_hears(&mut self, arbiter: &Arbiter, event: Event) -> Option<Event> {
        altered(event, |command| Command { run: arbiter.state().run, ..command })
    }
}

/// A command for another robot is executed.
#[derive(Default)]
struct OtherRobotAccepted;

impl Meddler for OtherRobotAccepted {
    fn arbiter_hears(&mut self, _: &Arbiter, event: Event) -> Option<Event> {
        altered(event, |command| Command { robot: hopper_sim::ROBOT, ..command })
    }
}

/// A command that comes again is executed again.
#[derive(Default)]
struct RepeatedExecuted;

impl Meddler for RepeatedExecuted {
    fn arbiter_hears(&mut self, arbiter: &Arbiter, event: Event) -> Option<Event> {
        let due = arbiter.state().decision;
        altered(event, |command| Command { decision: command.decision.max(due), ..command })
    }
}

/// A command for a decision that is not due yet is executed now.
#[derive(Default)]
struct FutureExecuted;

impl Meddler for FutureExecuted {
    fn arbiter_hears(&mut self, arbiter: &Arbiter, event: Event) -> Option<Event> {
        let due = arbiter.state().decision;
        altered(event, |command| Command { decision: command.decision.min(due), ..command })
    }
}

/// The next state is published, then the journal is asked.
#[derive(Default)]
struct PublishedBeforeAppend;

impl Meddler for PublishedBeforeAppend {
    fn arbiter_wants(&mut self, arbiter: &Arbiter, effects: &mut Vec<Effect>) {
        if let Some(index) = effects.iter().position(|effect| matches!(effect, Effect::Append(_))) {
            let Effect::Append(record) = effects[index] else { unreachable!() };
            let next = record.state_after(arbiter.state().run, MonotonicNs(1), MonotonicNs(1));
            effects.insert(index, Effect::Publish(next));
        }
    }
}

/// A record is taken for written that the journal never got.
#[derive(Default)]
struct PublishedButLost {
    appends: u64,
}

impl Meddler for PublishedButLost {
    fn commits(&mut self, _: &Record) -> bool {
        self.appends += 1;
        self.appends != 5
    }
}

/// A failed append is taken for one that succeeded.
#[derive(Default)]
struct FailureIgnored;

impl Meddler for FailureIgnored {
    fn arbiter_hears(&mut self, _: &Arbiter, event: Event) -> Option<Event> {
        Some(if event == Event::AppendFailed { Event::Appended } else { event })
    }
}

/// A record that could not be written draws its outcome anew.
#[derive(Default)]
struct DrawnTwice {
    failed: bool,
}

impl Meddler for DrawnTwice {
    fn arbiter_hears(&mut self, _: &Arbiter, event: Event) -> Option<Event> {
        self.failed |= event == Event::AppendFailed;
        Some(event)
    }

    fn arbiter_wants(&mut self, arbiter: &Arbiter, effects: &mut Vec<Effect>) {
        for effect in effects {
            let Effect::Append(record) = effect else { continue };
            if std::mem::take(&mut self.failed) {
                let again = Mission { seed: !arbiter.mission().seed, ..arbiter.mission().clone() };
                let Execution { outcome, pose, collected, steps, visits, status } =
                    execute(&again, arbiter.state(), record.action);
                *record = Record { outcome, pose, collected, steps, visits, status, ..*record };
                record.digest = record.previous.chain(record);
            }
        }
    }
}

/// The digest leaves the outcome out.
#[derive(Default)]
struct DigestUnchained;

impl Meddler for DigestUnchained {
    fn arbiter_wants(&mut self, _: &Arbiter, effects: &mut Vec<Effect>) {
        for effect in effects {
            if let Effect::Append(record) = effect {
                record.digest = record.previous;
            }
        }
    }
}

/// The state is told once; who missed it never knows.
#[derive(Default)]
struct StateToldOnce {
    told: Option<(RunId, Decision)>,
}

impl Meddler for StateToldOnce {
    fn arbiter_wants(&mut self, _: &Arbiter, effects: &mut Vec<Effect>) {
        effects.retain(|effect| match effect {
            Effect::Publish(state) => {
                self.told.replace((state.run, state.decision)) != Some((state.run, state.decision))
            }
            _ => true,
        });
    }
}

/// A disk that only appends, under a journal that means to overwrite.
#[derive(Debug)]
struct AppendOnly(Disk);

impl Storage for AppendOnly {
    fn bytes(&self) -> std::io::Result<u64> {
        self.0.bytes()
    }
    fn read_exact_at(&self, buffer: &mut [u8], offset: u64) -> std::io::Result<()> {
        self.0.read_exact_at(buffer, offset)
    }
    fn write_all_at(&self, bytes: &[u8], _: u64) -> std::io::Result<()> {
        self.0.write_all_at(bytes, self.0.bytes()?)
    }
    fn cut(&self, _: u64) -> std::io::Result<()> {
        Ok(())
    }
    fn sync(&self) -> std::io::Result<()> {
        self.0.sync()
    }
}

/// A torn tail stays, and the next record goes behind it.
#[derive(Default)]
struct TornTailKept;

impl Meddler for TornTailKept {
    fn storage(&mut self, disk: &Disk) -> Box<dyn Storage> {
        Box::new(AppendOnly(disk.clone()))
    }
}

/// A disk that says it has synced, and has not.
#[derive(Debug)]
struct NeverSyncs(Disk);

impl Storage for NeverSyncs {
    fn bytes(&self) -> std::io::Result<u64> {
        self.0.bytes()
    }
    fn read_exact_at(&self, buffer: &mut [u8], offset: u64) -> std::io::Result<()> {
        self.0.read_exact_at(buffer, offset)
    }
    fn write_all_at(&self, bytes: &[u8], offset: u64) -> std::io::Result<()> {
        self.0.write_all_at(bytes, offset)
    }
    fn cut(&self, bytes: u64) -> std::io::Result<()> {
        self.0.cut(bytes)
    }
    fn sync(&self) -> std::io::Result<()> {
        Ok(())
    }
}

/// `--sync` syncs nothing.
#[derive(Default)]
struct SyncForgotten;

impl Meddler for SyncForgotten {
    fn storage(&mut self, disk: &Disk) -> Box<dyn Storage> {
        Box::new(NeverSyncs(disk.clone()))
    }
}

/// The planner takes the newest map for one of the decision that is due.
#[derive(Default)]
struct DecidedBeforeMap;

impl Meddler for DecidedBeforeMap {
    fn pilot_hears(&mut self, pilot: &Pilot, _: Incarnation, event: pilot::Event) -> Option<pilot::Event> {
        Some(match event {
            pilot::Event::Patch(mut patch) => {
                patch.through = patch.through.max(pilot.seen().1);
                pilot::Event::Patch(patch)
            }
            pilot::Event::Page(mut page) => {
                page.through = page.through.max(pilot.seen().1);
                pilot::Event::Page(page)
            }
            event => event,
        })
    }
}

/// A command is sent once; who missed it never gets it.
#[derive(Default)]
struct CommandSentOnce {
    sent: BTreeSet<(RunId, Incarnation, Decision)>,
}

impl Meddler for CommandSentOnce {
    fn pilot_wants(&mut self, _: &Pilot, life: Incarnation, effects: &mut Vec<pilot::Effect>) {
        effects.retain(|effect| match effect {
            pilot::Effect::Send(command) => self.sent.insert((command.run, life, command.decision)),
            _ => true,
        });
    }
}

/// `--takeover` fires again whenever the planner has lost command.
#[derive(Default)]
struct TakeoverTwice {
    last: BTreeMap<Incarnation, Command>,
    led: BTreeSet<Incarnation>,
}

impl Meddler for TakeoverTwice {
    fn pilot_wants(&mut self, pilot: &Pilot, life: Incarnation, effects: &mut Vec<pilot::Effect>) {
        for effect in effects.iter() {
            match effect {
                pilot::Effect::Send(command) => drop(self.last.insert(life, *command)),
                pilot::Effect::Leads(_) => drop(self.led.insert(life)),
                _ => {}
            }
        }
        let (Some(situation), Some(command)) = (pilot.situation(), self.last.get(&life)) else { return };
        if self.led.contains(&life) && !pilot.leads() {
            let (term, decision) = (situation.state.leader.term.next(), situation.state.decision);
            let observation = situation.map.observation();
            effects.push(pilot::Effect::Send(Command { term, decision, observation, ..*command }));
        }
    }
}

/// A planner hears no heartbeat, and takes every leader for dead.
#[derive(Default)]
struct HeartbeatsUnheard;

impl Meddler for HeartbeatsUnheard {
    fn pilot_hears(&mut self, _: &Pilot, _: Incarnation, event: pilot::Event) -> Option<pilot::Event> {
        (!matches!(event, pilot::Event::Heartbeat(_))).then_some(event)
    }
}

/// A planner keeps the brief of the run it has met first.
#[derive(Default)]
struct OldBriefKept {
    runs: BTreeMap<Incarnation, RunId>,
}

impl Meddler for OldBriefKept {
    fn pilot_hears(&mut self, _: &Pilot, life: Incarnation, event: pilot::Event) -> Option<pilot::Event> {
        match &event {
            pilot::Event::Brief(brief) => {
                let first = *self.runs.entry(life).or_insert(brief.run);
                (first == brief.run).then_some(event)
            }
            _ => Some(event),
        }
    }
}

/// perception keeps the brief of the run it has met first.
#[derive(Default)]
struct OldMapKept {
    run: Option<RunId>,
}

impl Meddler for OldMapKept {
    fn cartographer_hears(
        &mut self,
        _: &Cartographer,
        event: perception::Event,
    ) -> Option<perception::Event> {
        match &event {
            perception::Event::Brief(brief) => {
                let first = *self.run.get_or_insert(brief.run);
                (first == brief.run).then_some(event)
            }
            _ => Some(event),
        }
    }
}

/// A rebuild takes the second record of a page for the first.
#[derive(Default)]
struct RecordSkipped;

impl Meddler for RecordSkipped {
    fn cartographer_hears(
        &mut self,
        _: &Cartographer,
        event: perception::Event,
    ) -> Option<perception::Event> {
        Some(match event {
            perception::Event::Past(page) if page.records.len() > 1 => {
                let shifted =
                    |record: &Record| Record { decision: Decision(record.decision.0 - 1), ..*record };
                let records = page.records[1..].iter().map(shifted).collect();
                perception::Event::Past(PastPage { records, ..page })
            }
            event => event,
        })
    }
}

/// perception tells more than it has seen.
#[derive(Default)]
struct UnseenTold;

impl Meddler for UnseenTold {
    fn cartographer_publishes(&mut self, patch: &mut MapPatch, map: &ObservedMap, terrain: &Terrain) {
        if let Some(unseen) = map.cells().iter().position(Option::is_none)
            && terrain.cells.len() == map.cells().len()
        {
            let ground = terrain.cells[unseen];
            patch.cells.push(SeenCell { index: unseen as u32, ground });
            patch.cells.sort_by_key(|cell| cell.index);
            patch.after = patch.after.wrapping_add(ObservedMap::step(unseen, None, &ground));
        }
    }
}

/// A planner never asks for the map; who missed a patch never gets it.
#[derive(Default)]
struct MapNeverAsked;

impl Meddler for MapNeverAsked {
    fn pilot_wants(&mut self, _: &Pilot, _: Incarnation, effects: &mut Vec<pilot::Effect>) {
        effects.retain(|effect| !matches!(effect, pilot::Effect::RequestMap(_)));
    }
}

/// A landing is told once; who missed the last never learns that there was one.
#[derive(Default)]
struct MapToldOnce {
    told: Option<Option<Decision>>,
}

impl Meddler for MapToldOnce {
    fn cartographer_wants(&mut self, cartographer: &Cartographer, effects: &mut Vec<perception::Effect>) {
        let through = cartographer.map().and_then(|map| map.through);
        effects.retain(|effect| {
            *effect != perception::Effect::PublishMap || self.told.replace(through) != Some(through)
        });
    }
}

/// A planner takes a part of a landing for all of it.
#[derive(Default)]
struct PartForTheWhole;

impl Meddler for PartForTheWhole {
    fn pilot_hears(&mut self, _: &Pilot, _: Incarnation, event: pilot::Event) -> Option<pilot::Event> {
        Some(match event {
            pilot::Event::Patch(patch) => pilot::Event::Patch(MapPatch { more: 0, ..patch }),
            event => event,
        })
    }
}

/// Processes read the wall clock.
#[derive(Default)]
struct WallClockRead;

impl Meddler for WallClockRead {
    fn clock(&mut self, _: MonotonicNs, wall: MonotonicNs) -> MonotonicNs {
        wall
    }
}

/// A decision is kept for ever for a takeover that has fallen silent.
#[derive(Default)]
struct KeptForEver {
    heard: Option<(RunId, Decision, Incarnation)>,
    put_off: BTreeSet<(RunId, Decision, Incarnation)>,
}

impl Meddler for KeptForEver {
    fn arbiter_hears(&mut self, _: &Arbiter, event: Event) -> Option<Event> {
        if let Event::Command(Ok(Command { run, decision, incarnation, .. })) = event {
            self.heard = Some((run, decision, incarnation));
            return (!self.put_off.contains(&(run, decision, incarnation))).then_some(event);
        }
        Some(event)
    }

    fn arbiter_wants(&mut self, _: &Arbiter, effects: &mut Vec<Effect>) {
        if effects.iter().any(|effect| matches!(effect, Effect::Refused(Refusal::Yielding { .. }))) {
            self.put_off.extend(self.heard);
        }
    }
}

#[test]
fn an_accepted_stale_term_is_found() {
    is_found::<StaleTermAccepted>();
}

#[test]
fn a_term_shared_by_two_planners_is_found() {
    is_found::<TermReused>();
}

#[test]
fn an_accepted_leap_of_terms_is_found() {
    is_found::<LeapAccepted>();
}

#[test]
fn an_accepted_command_of_another_run_is_found() {
    is_found::<OldRunAccepted>();
}

#[test]
fn an_accepted_command_for_another_robot_is_found() {
    is_found::<OtherRobotAccepted>();
}

#[test]
fn a_repeated_decision_that_is_executed_is_found() {
    is_found::<RepeatedExecuted>();
}

#[test]
fn a_future_decision_that_is_executed_is_found() {
    is_found::<FutureExecuted>();
}

#[test]
fn a_state_published_before_its_append_is_found() {
    is_found::<PublishedBeforeAppend>();
}

#[test]
fn a_record_that_is_published_but_lost_is_found() {
    is_found::<PublishedButLost>();
}

#[test]
fn a_failed_append_taken_for_a_success_is_found() {
    is_found::<FailureIgnored>();
}

#[test]
fn an_outcome_drawn_twice_is_found() {
    is_found::<DrawnTwice>();
}

#[test]
fn a_digest_that_does_not_chain_is_found() {
    is_found::<DigestUnchained>();
}

#[test]
fn a_state_that_is_told_once_is_found() {
    is_found::<StateToldOnce>();
}

#[test]
fn a_torn_tail_that_is_not_cut_is_found() {
    is_found::<TornTailKept>();
}

#[test]
fn an_append_that_is_not_synced_is_found() {
    is_found::<SyncForgotten>();
}

#[test]
fn a_decision_before_the_map_covers_it_is_found() {
    is_found::<DecidedBeforeMap>();
}

#[test]
fn a_command_that_is_sent_once_is_found() {
    is_found::<CommandSentOnce>();
}

#[test]
fn a_takeover_that_fires_twice_is_found() {
    is_found::<TakeoverTwice>();
}

#[test]
fn a_takeover_from_a_leader_that_beats_is_found() {
    is_found::<HeartbeatsUnheard>();
}

#[test]
fn a_brief_of_another_run_that_is_kept_is_found() {
    is_found::<OldBriefKept>();
}

#[test]
fn a_map_of_another_run_that_is_kept_is_found() {
    is_found::<OldMapKept>();
}

#[test]
fn a_rebuild_that_skips_a_record_is_found() {
    is_found::<RecordSkipped>();
}

#[test]
fn an_unseen_cell_on_the_map_is_found() {
    is_found::<UnseenTold>();
}

#[test]
fn a_map_that_is_never_asked_for_is_found() {
    is_found::<MapNeverAsked>();
}

#[test]
fn a_map_that_is_told_once_is_found() {
    is_found::<MapToldOnce>();
}

#[test]
fn a_part_of_a_landing_taken_for_the_whole_is_found() {
    is_found::<PartForTheWhole>();
}

#[test]
fn a_machine_that_reads_the_wall_clock_is_found() {
    is_found::<WallClockRead>();
}

#[test]
fn a_decision_kept_for_ever_is_found() {
    is_found::<KeptForEver>();
}
