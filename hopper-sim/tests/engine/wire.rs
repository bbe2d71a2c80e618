//! What a rogue process may write, and that none of it moves the hopper.

use bytemuck::Zeroable;
use contract::wire::{CommandV3, RecordV5, StateV4};
use contract::{Action, Command, MonotonicNs, Record, State, Timing};
use hopper_sim::{Effect, Event};
use proptest::prelude::*;

use crate::fixture::{EAST, Host, command, undisturbed};

fn valid() -> CommandV3 {
    CommandV3::from(&command(&Host::fresh().state(), EAST))
}

/// A change to a valid command with the reason for which it is refused.
type Case = (&'static str, fn(&mut CommandV3));

/// P-HOSTILE: A command with any field at its extremes is refused or harmless.
#[test]
fn every_field_of_a_command_at_its_extremes_is_refused_or_harmless() {
    let refused: [Case; 24] = [
        ("wrong_run", |wire| wire.run = [0; 2]),
        ("wrong_run", |wire| wire.run = [u64::MAX; 2]),
        ("wrong_run", |wire| wire.run.swap(0, 1)),
        ("future_decision", |wire| wire.decision = 1),
        ("malformed", |wire| wire.decision = u64::MAX),
        ("malformed", |wire| wire.term = 0),
        ("future_term", |wire| wire.term = 2),
        ("malformed", |wire| wire.term = u64::MAX),
        ("malformed", |wire| wire.incarnation = 0),
        ("wrong_robot", |wire| wire.robot = 1),
        ("wrong_robot", |wire| wire.robot = u32::from(u16::MAX)),
        ("wrong_robot", |wire| wire.robot = u32::MAX),
        ("malformed", |wire| wire.action = 5),
        ("malformed", |wire| wire.action = u32::MAX),
        ("malformed", |wire| wire.cut = 2),
        ("malformed", |wire| wire.cut = u32::MAX),
        ("malformed", |wire| wire.planner = [0; 32]),
        ("malformed", |wire| wire.planner = [b'x'; 32]),
        ("malformed", |wire| wire.planner = [0xff; 32]),
        ("malformed", |wire| wire.planner[31] = 1),
        ("malformed", |wire| wire.planner[0] = b' '),
        ("malformed", |wire| wire.planning_ended_ns = 0),
        ("malformed", |wire| wire.planning_started_ns = u64::MAX),
        ("malformed", |wire| *wire = CommandV3::zeroed()),
    ];
    for (index, (reason, change)) in refused.into_iter().enumerate() {
        let mut wire = valid();
        change(&mut wire);
        let mut host = Host::fresh();
        host.on(Event::Command(Command::try_from(&wire)));
        assert_eq!(host.refused, [reason], "case {index}: {wire:?}");
        assert_eq!((host.records.len(), host.arbiter.refusals().of(reason)), (0, 1));
    }
    let harmless: [fn(&mut CommandV3); 10] = [
        |_| {},
        |wire| wire.incarnation = u64::MAX,
        |wire| wire.observation = u64::MAX,
        |wire| wire.work = u64::MAX,
        |wire| wire.pid = u32::MAX,
        |wire| wire.sensed_ns = u64::MAX,
        |wire| wire.map_published_ns = 0,
        |wire| wire.planning_ended_ns = u64::MAX,
        |wire| wire.planning_started_ns = 0,
        |wire| wire.cut = 1,
    ];
    for change in harmless {
        let mut wire = valid();
        change(&mut wire);
        let mut host = Host::fresh();
        host.on(Event::Command(Command::try_from(&wire)));
        let [record] = host.records[..] else { panic!("{wire:?} is executed, got {:?}", host.refused) };
        let timing = record.timing;
        assert_eq!(
            timing.stages_ns().iter().sum::<u64>(),
            timing.total_ns(),
            "its stages telescope all the same"
        );
    }
}

proptest! {
    /// P-HOSTILE.
    #[test]
    fn random_bytes_never_move_the_hopper(bytes in prop::collection::vec(any::<u8>(), size_of::<CommandV3>())) {
        let wire: CommandV3 = bytemuck::pod_read_unaligned(&bytes);
        let mut host = Host::fresh();
        let effects = host.arbiter.on(Event::Command(Command::try_from(&wire)), MonotonicNs(2_000));
        prop_assert!(matches!(effects[..], [Effect::Refused(_)]), "{:?}", effects);
    }
}

/// Numbers that no float of a message may be.
const NO_NUMBERS: [f64; 5] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1.0e300, -1.0e300];

#[test]
fn a_state_with_a_float_that_is_no_number_is_refused() {
    let floats: [fn(&mut StateV4) -> &mut f64; 7] = [
        |wire| &mut wire.pose.height_m,
        |wire| &mut wire.last.launch_speed_mps,
        |wire| &mut wire.last.launch_angle_rad,
        |wire| &mut wire.last.range_m,
        |wire| &mut wire.last.rise_m,
        |wire| &mut wire.last.apex_height_m,
        |wire| &mut wire.last.flight_time_s,
    ];
    let state = Host::new(crate::fixture::mission(), undisturbed(), hopper_sim::Pace::Max).state();
    assert_eq!(State::try_from(&StateV4::from(&state)).unwrap(), state);
    for float in floats {
        for value in NO_NUMBERS {
            let mut wire = StateV4::from(&state);
            *float(&mut wire) = value;
            assert_eq!(State::try_from(&wire).unwrap_err().reason(), "malformed");
        }
    }
}

/// P-STAMPS-WIRE: Each moment of a message has a field of its own on the wire, and a reminder of
/// the map has those of its landing.
#[test]
fn every_stamp_has_its_own_field_on_the_wire() {
    let timing = Timing {
        landed: MonotonicNs(101),
        state_published: MonotonicNs(202),
        sensed: MonotonicNs(303),
        map_published: MonotonicNs(404),
        planning_started: MonotonicNs(505),
        planning_ended: MonotonicNs(606),
        accepted: MonotonicNs(707),
        committed: MonotonicNs(808),
    };
    let in_order = [101, 202, 303, 404, 505, 606, 707, 808];
    let record = Record { timing, ..undisturbed()[1] };
    let wire = RecordV5::from(&record);
    assert_eq!(wire.timing_ns, in_order);
    assert_eq!(Record::try_from(&wire).unwrap().timing, timing);

    let state = record.state_after(Host::fresh().state().run, MonotonicNs(11), MonotonicNs(22));
    assert_eq!(
        (state.landed, state.published, state.last_timing),
        (MonotonicNs(11), MonotonicNs(22), timing)
    );
    let wire = StateV4::from(&state);
    assert_eq!((wire.landed_ns, wire.published_ns, wire.last_timing_ns), (11, 22, in_order));
    assert_eq!(State::try_from(&wire).unwrap(), state);

    let Timing { sensed, map_published, planning_started, planning_ended, .. } = timing;
    let plain = command(&Host::fresh().state(), EAST);
    let command = Command { sensed, map_published, planning_started, planning_ended, ..plain };
    let wire = CommandV3::from(&command);
    let stamps = [wire.sensed_ns, wire.map_published_ns, wire.planning_started_ns, wire.planning_ended_ns];
    assert_eq!(stamps, [303, 404, 505, 606]);
    assert_eq!(Command::try_from(&wire).unwrap(), command);
}

#[test]
fn every_record_of_a_mission_survives_the_wire_and_broken_ones_do_not() {
    for record in undisturbed() {
        assert_eq!(Record::try_from(&RecordV5::from(&record)).unwrap(), record);
    }
    let changes: [fn(&mut RecordV5); 12] = [
        |wire| wire.decision = u64::MAX,
        |wire| wire.leader.term = u64::MAX,
        |wire| wire.action = Action::CODES as u32,
        |wire| wire.cut = 9,
        |wire| wire.status = 0,
        |wire| wire.outcome.branch = 0,
        |wire| wire.outcome.from = [i32::MIN; 2],
        |wire| wire.pose.height_m = f64::NAN,
        |wire| wire.collected = 1 << 16,
        |wire| wire.origin = 0,
        |wire| wire.origin = 5,
        |wire| wire.vetoed = 1 << Action::CODES,
    ];
    for (index, change) in changes.into_iter().enumerate() {
        let mut wire = RecordV5::from(&undisturbed()[0]);
        change(&mut wire);
        assert!(Record::try_from(&wire).is_err(), "change {index}");
    }
}
