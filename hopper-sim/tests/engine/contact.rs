//! A mission whose hops are followed by physics: exactly once, with exact rest positions in journal and digest.

use std::sync::Arc;

use contract::{Action, Branch, Cell, Direction, Leader, MotionModel, Record, Status};
use hopper_sim::{
    Arbiter, Attachment, Event, Execution, Journal, JournalError, Mission, Pace, RecordStore, RobotTeam,
    Verification, verify,
};
use scenario::{Dynamics, Scenario};

use super::fixture::{LINGER_NS, command, steer};

const WORLD: &str = "
[truth.terrain.random_hills]
width_cells = 12
height_cells = 12
cell_size_m = 1.0
seed = 3
hills = 8
sigma_m = [1.0, 2.0]
amplitude_m = [0.1, 0.4]

[truth.sand]
rectangles = [{ x = [5, 7], y = [0, 11] }]

[truth.dynamics]
model = \"contact\"

[brief]
name = \"bouncy\"
profile = \"hopper\"
start = [1, 1]
goal = [10, 10]

[limits]
steps_max = 200
";

fn mission(seed: u64) -> Mission {
    let world = Scenario::parse(WORLD, "the test").and_then(|scenario| scenario.resolve()).unwrap();
    Mission::of(&world, seed)
}

/// A mission flown to its end: each record with what it names.
fn flown(mission: Mission) -> Vec<(Record, Option<Attachment>)> {
    let mut arbiter = Arbiter::new(mission, None, Pace::Max, LINGER_NS, contract::MonotonicNs(1_000));
    fly_on(&mut arbiter, usize::MAX)
}

/// Flies at most so many decisions on.
fn fly_on(arbiter: &mut Arbiter, decisions: usize) -> Vec<(Record, Option<Attachment>)> {
    let now = contract::MonotonicNs(2_000);
    arbiter.on(Event::Tick, now);
    let mut records = Vec::new();
    while !arbiter.state().status.is_over() && records.len() < decisions {
        let state = *arbiter.state();
        let given = command(&state, steer(&arbiter.mission().brief, &state));
        for effect in arbiter.on(Event::Command(Ok(given)), now) {
            if let hopper_sim::Effect::Append(record) = effect {
                records.push((record, arbiter.attachment(&record)));
                arbiter.on(Event::Appended, now);
            }
        }
        assert!(arbiter.state().decision > state.decision, "the mission goes on");
    }
    records
}

/// P-CONTACT-JOURNAL: Every record of a hopper under contact names its exact rest position, which the next hop departs from, and a
/// journal that is resumed anywhere goes on as the undisturbed mission.
#[test]
fn a_mission_that_is_resumed_anywhere_is_the_undisturbed_one_to_the_last_bit() {
    let undisturbed = flown(mission(7));
    assert!(undisturbed.len() > 8, "{}", undisturbed.len());
    for (record, attachment) in &undisturbed {
        let Some(Attachment::Detail(detail)) = attachment else { panic!("{record:?}") };
        assert_eq!((detail.model, detail.id()), (MotionModel::Contact, record.detail));
    }
    let inexact = undisturbed.iter().filter_map(|(_, attachment)| attachment.as_ref()?.detail());
    assert!(inexact.filter(|detail| (detail.rest_m[0].fract() - 0.5).abs() > 0.01).count() > 4);
    let folder = tempfile::tempdir().unwrap();
    for cut in 0..undisturbed.len() {
        let path = folder.path().join(cut.to_string());
        let header = super::fixture::header(&mission(7));
        let mut journal = Journal::create(&path, &header, false).unwrap();
        for (record, attachment) in &undisturbed[..cut] {
            journal.append(record, attachment.as_ref()).unwrap();
        }
        drop(journal);
        let journal = Journal::resume(&path, &header, &mission(7).terrain, false).unwrap();
        let last = journal.last().copied();
        let mut arbiter =
            Arbiter::new(mission(7), last.as_ref(), Pace::Max, LINGER_NS, contract::MonotonicNs(9_000));
        if let Some(last) = last {
            let detail = RecordStore::detail(&journal, last.decision).unwrap().unwrap();
            arbiter.recall_detail(last.robot, detail);
        }
        let rest = fly_on(&mut arbiter, usize::MAX);
        let digests =
            |records: &[(Record, _)]| records.iter().map(|(record, _)| record.digest).collect::<Vec<_>>();
        assert_eq!(digests(&rest), digests(&undisturbed[cut..]), "resumed at decision {cut}");
    }
}

/// P-CONTACT-TAMPERED: A rest position that is not what physics gives is found, though its record and all digests fit.
#[test]
fn a_rest_position_that_was_changed_is_refused() {
    let undisturbed = flown(mission(7));
    let folder = tempfile::tempdir().unwrap();
    let header = super::fixture::header(&mission(7));
    let mut journal = Journal::create(folder.path(), &header, false).unwrap();
    let mut digest = None;
    for (number, (record, attachment)) in undisturbed.iter().enumerate() {
        let (mut record, mut attachment) = (*record, attachment.clone());
        if number == 3
            && let Some(Attachment::Detail(detail)) = &mut attachment
        {
            detail.rest_m[0] = detail.rest_m[0].next_up();
            record.detail = detail.id();
        }
        record.previous = digest.unwrap_or(record.previous);
        record.digest = record.previous.chain(&record);
        digest = Some(record.digest);
        journal.append(&record, attachment.as_ref()).unwrap();
    }
    drop(journal);
    let refused = Journal::resume(folder.path(), &header, &mission(7).terrain, false).unwrap_err();
    assert!(refused.to_string().contains("record 3: detail"), "{refused}");
    // Without the ground, which the header of this test does not know, only the chain is checked.
    assert!(matches!(verify(folder.path()), Ok(Verification { unrepeated: Some(_), fault: None, .. })));
}

#[test]
fn a_record_without_what_it_names_is_refused() {
    let (record, attachment) = flown(mission(7)).swap_remove(0);
    let folder = tempfile::tempdir().unwrap();
    let mut journal = Journal::create(folder.path(), &super::fixture::header(&mission(7)), false).unwrap();
    let refused =
        |result: Result<(), JournalError>| matches!(result, Err(JournalError::OtherAttachment { .. }));
    assert!(refused(journal.append(&record, None)));
    let Some(Attachment::Detail(mut detail)) = attachment else { panic!("{record:?}") };
    detail.figures[0] += 1.0;
    assert!(refused(journal.append(&record, Some(&Attachment::Detail(detail)))));
}

/// One hop of robot 0 at decision 0.
fn hop(mission: &Mission, direction: Direction) -> Execution {
    let arbiter = Arbiter::new(mission.clone(), None, Pace::Max, 0, contract::MonotonicNs(0));
    let mut team = RobotTeam::new(mission);
    team.execute(mission, arbiter.state(), Leader::default(), Action::Hop(direction)).1
}

/// P-CONTACT-WALL: A wall that a table of landings would let pass stops a hop.
#[test]
fn a_wall_stops_a_hop() {
    let walled = |dynamics: Dynamics, seed| {
        let mut mission = Mission { dynamics, ..mission(seed) };
        for (index, ground) in Arc::make_mut(&mut mission.terrain).cells.iter_mut().enumerate() {
            (ground.height_m, ground.gradient) = (if index % 12 >= 2 { 1.0 } else { 0.0 }, [0.0; 2]);
        }
        hop(&mission, Direction::East)
    };
    let contact = mission(1).dynamics;
    let mut passed = 0;
    for seed in 0..200 {
        passed += u32::from(walled(Dynamics::default(), seed).outcome.to == Cell::new(2, 1));
        let stopped = walled(contact.clone(), seed);
        assert!(stopped.outcome.to.x < 2, "seed {seed}: {stopped:?}");
    }
    assert!(passed > 150, "the law lets {passed} of 200 pass");
}

/// P-CONTACT-MAP: A hop over the border has left the map, and ends the mission.
#[test]
fn a_hop_over_the_border_leaves_the_map() {
    let mut left = 0;
    for seed in 0..50 {
        let mut mission = mission(seed);
        mission.brief.robots[0].start.cell = Cell::new(0, 1);
        let Execution { outcome, status, .. } = hop(&mission, Direction::West);
        if outcome.to == Cell::new(-1, 1) || outcome.to.x < 0 {
            left += 1;
            assert_eq!((outcome.branch, status), (Branch::Elsewhere, Status::LeftMap));
        }
    }
    assert!(left > 40, "{left} of 50");
}
