//! When hopper-sim may end: everyone knows, or has been waited for long enough.

use contract::protocol::peer_table::SILENCE_NS;
use contract::{Heartbeat, Role, RunId, Status};
use hopper_sim::arbiter::ANNOUNCE_NS;
use hopper_sim::{Arbiter, Effect, Event, Pace};

use crate::fixture::{Host, LINGER_NS, beat, mission, undisturbed};

const PEERS: [Role; 3] = [Role::Perception, Role::Planner, Role::Monitor];

/// A host whose mission is over; nobody has beaten yet.
fn over() -> (Host, Status) {
    let mut host = Host::fresh();
    let status = host.fly().state().status;
    assert_eq!(host.finished, []);
    (host, status)
}

fn hear(host: &mut Host, beat: Heartbeat) {
    host.on(Event::Heartbeat(beat));
}

#[test]
fn it_ends_as_soon_as_every_role_has_seen_the_end() {
    let (mut host, status) = over();
    for (life, role) in (10..).zip(PEERS) {
        assert_eq!(host.finished, [], "{role} is missing");
        hear(&mut host, beat(role, life, 1, status));
    }
    assert_eq!(host.finished, [status]);
}

#[test]
fn a_missing_role_is_waited_for_no_longer_than_the_linger() {
    let (mut host, status) = over();
    hear(&mut host, beat(Role::Perception, 10, 1, status));
    let end = host.state().published.plus_ns(LINGER_NS);
    while host.finished.is_empty() {
        let wake = host.arbiter.wake_at().unwrap();
        assert!(host.now < wake && wake <= end, "every wake is later than the last and none beyond the end");
        host.now = wake;
        host.on(Event::Tick);
    }
    assert_eq!((host.now, &host.finished[..]), (end, &[status][..]));
}

#[test]
fn a_live_peer_that_has_not_seen_the_end_is_waited_for() {
    let (mut host, status) = over();
    hear(&mut host, beat(Role::Planner, 20, 1, Status::Underway));
    hear(&mut host, Heartbeat { run: RunId(5), ..beat(Role::Monitor, 21, 1, status) });
    for (life, role) in (10..).zip(PEERS) {
        hear(&mut host, beat(role, life, 1, status));
    }
    assert_eq!(host.finished, [], "a stand-by planner is behind, a monitor is in another run");
    hear(&mut host, beat(Role::Planner, 20, 2, status));
    assert_eq!(host.finished, []);
    hear(&mut host, beat(Role::Monitor, 21, 2, status));
    assert_eq!(host.finished, [status]);
}

#[test]
fn a_dead_peer_is_not_waited_for() {
    let (mut host, status) = over();
    hear(&mut host, beat(Role::Planner, 20, 1, Status::Underway));
    host.tick_after(SILENCE_NS + 1);
    for (life, role) in (10..).zip(PEERS) {
        hear(&mut host, beat(role, life, 1, status));
    }
    assert_eq!(host.finished, [status]);
}

#[test]
fn its_own_heartbeat_keeps_nobody_waiting() {
    let (mut host, status) = over();
    hear(&mut host, beat(Role::HopperSim, 1, 1, Status::Underway));
    for (life, role) in (10..).zip(PEERS) {
        hear(&mut host, beat(role, life, 1, status));
    }
    assert_eq!(host.finished, [status]);
}

#[test]
fn the_end_is_told_once_and_the_final_state_is_served_on() {
    let (mut host, status) = over();
    host.tick_after(LINGER_NS);
    host.tick_after(LINGER_NS);
    hear(&mut host, beat(Role::Monitor, 10, 1, status));
    assert_eq!(host.finished, [status]);
    let told = host.published.len();
    assert!(host.arbiter.wake_at().unwrap() > host.now);
    host.tick_after(LINGER_NS);
    assert_eq!(host.published.len(), told + 1, "for who stays");
}

#[test]
fn a_finished_journal_serves_its_final_state_before_the_end() {
    let records = undisturbed();
    let status = records.last().unwrap().status;
    let mut host = Host::new(mission(), records, Pace::Max);
    assert_eq!((host.published.len(), host.state().status, host.finished.len()), (1, status, 0));
    host.tick_after(LINGER_NS);
    assert_eq!(host.finished, [status]);
}

#[test]
fn without_linger_it_ends_with_the_final_state_but_not_before_it_is_published() {
    let records = undisturbed();
    let now = contract::MonotonicNs(5);
    let mut arbiter = Arbiter::new(mission(), records.last(), Pace::Max, 0, now);
    assert_eq!(arbiter.on(Event::Heartbeat(beat(Role::Monitor, 1, 1, Status::Goal)), now), []);
    let effects = arbiter.on(Event::Tick, now);
    assert!(matches!(effects[..], [Effect::Publish(_), Effect::Finished(_)]), "{effects:?}");
}

#[test]
fn while_the_mission_is_underway_nobody_ends_it() {
    let mut host = Host::fresh();
    for (life, role) in (10..).zip(PEERS) {
        hear(&mut host, beat(role, life, 1, Status::Goal));
    }
    host.tick_after(100 * LINGER_NS);
    assert_eq!(host.finished, []);
}

/// P-ANNOUNCE: A peer that has missed the brief is sent it again.
#[test]
fn a_peer_that_goes_on_without_knowing_the_run_is_told_of_it_again() {
    let mut host = Host::fresh();
    let ignorant =
        |role, life, counter| Heartbeat { run: RunId(0), ..beat(role, life, counter, Status::Underway) };
    let tenth = ANNOUNCE_NS / 10;
    let hear_for = |host: &mut Host, tenths: u64, beats: &dyn Fn(u64) -> Heartbeat| {
        for counter in 0..tenths {
            hear(host, beats(counter));
            host.now = host.now.plus_ns(tenth);
        }
        std::mem::take(&mut host.announced)
    };
    let planner = |counter| ignorant(Role::Planner, 20, counter);
    assert_eq!(hear_for(&mut host, 10, &planner), 0, "it may be just about to read it");
    assert_eq!(hear_for(&mut host, 33, &planner), 3, "once a while, as long as it does not know");
    let knows = |counter| beat(Role::Planner, 20, counter, Status::Underway);
    assert_eq!(hear_for(&mut host, 30, &knows), 0);
    // One that died ignorant makes room for the next.
    assert_eq!(hear_for(&mut host, 5, &|counter| ignorant(Role::Monitor, 30, counter)), 0);
    let perception = |counter| ignorant(Role::Perception, 40, counter);
    assert!(hear_for(&mut host, 40, &perception) >= 1);
    let rival = |counter| ignorant(Role::HopperSim, 50, counter);
    assert_eq!(hear_for(&mut host, 40, &rival), 0, "another hopper-sim has a run of its own");
}

/// P-ANNOUNCE. A peer that left before it knew the run does not delay others, and its wait does not
/// count for a peer that comes much later.
#[test]
fn a_peer_that_went_before_it_knew_the_run_makes_room_for_another() {
    let mut host = Host::fresh();
    let ignorant =
        |role, life, counter| Heartbeat { run: RunId(0), ..beat(role, life, counter, Status::Underway) };
    let tenth = ANNOUNCE_NS / 10;
    for (pause, need) in [(0, 10), (30, 10)] {
        hear(&mut host, ignorant(Role::Monitor, 30, 1));
        host.now = host.now.plus_ns(pause * tenth);
        let begun = host.now;
        while host.announced == 0 {
            let counter = host.now.0;
            hear(&mut host, ignorant(Role::Perception, 40, counter));
            assert!(host.now.since_ns(begun) <= 40 * tenth, "it is never told");
            host.now = host.now.plus_ns(tenth);
        }
        assert_eq!(host.now.since_ns(begun) / tenth, need + 1, "after a pause of {pause}");
        host.announced = 0;
    }
}

#[test]
fn two_peers_that_do_not_know_the_run_do_not_keep_each_other_from_it() {
    let mut host = Host::fresh();
    for counter in 0..=10 {
        for (role, life) in [(Role::Monitor, 30), (Role::Perception, 40)] {
            let beat = Heartbeat { run: RunId(0), ..beat(role, life, counter, Status::Underway) };
            hear(&mut host, beat);
        }
        host.now = host.now.plus_ns(ANNOUNCE_NS / 10);
    }
    assert_eq!(host.announced, 1);
}

#[test]
fn a_mission_that_nobody_watches_ends_after_a_moment() {
    let (mut host, status) = over();
    for (life, role) in (10..).zip([Role::Perception, Role::Planner]) {
        hear(&mut host, beat(role, life, 1, status));
    }
    assert_eq!(host.finished, []);
    host.tick_after(LINGER_NS / 8);
    assert_eq!(host.finished, [status]);
}
