//! A hopper-sim that died and came back goes on as if it had not.

use contract::{Command, Decision, MonotonicNs, Record, Term};
use hopper_sim::{Arbiter, Effect, Event, Journal, JournalHeader, Pace};
use tempfile::tempdir;

use crate::fixture::{EAST, Host, LINGER_NS, WEST, command, header, mission, undisturbed};

#[test]
fn cut_at_every_record_the_mission_continues_to_the_same_digest() {
    let calm = undisturbed();
    let digests = |records: &[Record]| records.iter().map(|record| record.digest).collect::<Vec<_>>();
    for cut in 0..=calm.len() {
        let mut host = Host::new(mission(), calm[..cut].to_vec(), Pace::Max);
        host.fly();
        assert_eq!(digests(&host.records), digests(&calm), "cut after {cut} records");
    }
}

#[test]
fn the_state_after_a_restart_is_the_one_the_last_record_leads_to() {
    let calm = undisturbed();
    let last = calm[4];
    let host = Host::new(mission(), calm[..5].to_vec(), Pace::Max);
    let [state] = host.published[..] else { panic!("published once, by the first tick") };
    assert_eq!((state.decision, state.digest, state.leader), (Decision(5), last.digest, last.leader));
    assert_eq!((state.pose, state.steps, state.last), (last.pose, last.steps, Some(last.outcome)));
    assert_eq!(state.last_timing, last.timing);
}

#[test]
fn the_leader_goes_on_after_a_restart_and_a_stale_one_is_still_refused() {
    let mut host = Host::fresh();
    host.send(command(&host.state(), EAST));
    let takeover =
        Command { term: Term(2), incarnation: contract::Incarnation(2), ..command(&host.state(), EAST) };
    host.send(takeover);
    let mut host = Host::new(mission(), host.records, Pace::Max);
    host.send(command(&host.state(), EAST));
    assert_eq!(host.refused, ["stale_term"], "the term became durable with its first hop");
    host.send(Command { decision: host.state().decision, digest: host.state().digest, ..takeover });
    assert_eq!((host.state().decision, host.state().leader.term), (Decision(3), Term(2)));
}

#[test]
fn a_command_that_outlived_its_first_addressee_is_executed_once() {
    // Killed between acceptance and append: the planner repeats, the draw is the same.
    let (mut first, mut second) = (Host::fresh(), Host::fresh());
    let order = command(&first.state(), EAST);
    first.send(order);
    second.send(order);
    assert_eq!(first.records, second.records);
    // Killed between append and publication: the repeated command is answered, not executed.
    let mut host = Host::new(mission(), first.records, Pace::Max);
    host.send(Command { action: WEST, ..order });
    assert_eq!((host.refused.as_slice(), host.records.len()), (&["repeated_decision"][..], 1));
}

/// P-STAMPS-RESUMED: A resumed hopper-sim continues the mission when it first publishes its state
/// or executes a command; the time it waits before that counts for no decision.
#[test]
fn a_command_may_come_before_the_first_tick() {
    let calm = undisturbed();
    let mut arbiter = Arbiter::new(mission(), Some(&calm[0]), Pace::Max, LINGER_NS, MonotonicNs(9));
    let order = command(arbiter.state(), EAST);
    let effects = arbiter.on(Event::Command(Ok(order)), MonotonicNs(10));
    let [Effect::Publish(told), Effect::Append(record)] = effects[..] else { panic!("{effects:?}") };
    assert_eq!((told.decision, record.decision), (Decision(1), Decision(1)));
    assert_eq!((told.landed, told.published), (MonotonicNs(10), MonotonicNs(10)));
    assert_eq!((record.timing.landed, record.timing.state_published), (told.landed, told.published));
}

/// P-STAMPS-RESUMED. A repeated command of an earlier process is answered by the first tick; the
/// wait for it counts for no decision.
#[test]
fn a_repeated_command_before_the_first_tick_takes_nothing_up() {
    let calm = undisturbed();
    let mut arbiter = Arbiter::new(mission(), Some(&calm[0]), Pace::Max, LINGER_NS, MonotonicNs(9));
    let repeated = Command { decision: Decision(0), ..command(arbiter.state(), EAST) };
    let effects = arbiter.on(Event::Command(Ok(repeated)), MonotonicNs(10));
    assert!(matches!(effects[..], [Effect::Refused(_)]), "{effects:?}");
    let effects = arbiter.on(Event::Tick, MonotonicNs(500));
    let [Effect::Publish(told)] = effects[..] else { panic!("{effects:?}") };
    assert_eq!((told.landed, told.published), (MonotonicNs(500), MonotonicNs(500)));
}

#[test]
fn a_hop_that_was_in_the_air_has_landed_after_a_restart() {
    let mut host = Host::new(mission(), Vec::new(), Pace::Real);
    host.send(command(&host.state(), EAST));
    assert_eq!(host.state().decision, Decision(0), "in the air");
    let host = Host::new(mission(), host.records, Pace::Real);
    assert_eq!((host.state().decision, host.state().landed), (Decision(1), MonotonicNs(1_000)));
}

#[test]
fn through_a_journal_on_disk_killed_at_every_append_the_digest_stays() {
    let calm = undisturbed();
    let dir = tempdir().unwrap();
    let header = header(&mission());
    drop(Journal::create(dir.path(), &header, false).unwrap());
    loop {
        // Each life executes one decision and dies before it can tell anybody.
        let other_nonce: JournalHeader = header.clone().with_run(contract::RunId(99));
        let mut journal = Journal::resume(dir.path(), &other_nonce, &mission().terrain, false).unwrap();
        assert_eq!(journal.header(), &header, "the nonce of the first life stays");
        let mut arbiter = Arbiter::new(mission(), journal.last(), Pace::Max, LINGER_NS, MonotonicNs(0));
        let state = *arbiter.state();
        if state.status.is_over() {
            assert_eq!((state.digest, state.decision.0), (calm.last().unwrap().digest, journal.len()));
            break;
        }
        let order = command(&state, crate::fixture::steer(&header.brief, &state));
        let effects = arbiter.on(Event::Command(Ok(order)), MonotonicNs(1));
        let [Effect::Publish(_), Effect::Append(record)] = effects[..] else { panic!("{effects:?}") };
        journal.append(&record, None).unwrap();
    }
}
