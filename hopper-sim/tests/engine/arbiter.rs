//! Who may command, when a hop has happened, who is told.

use contract::{
    Action, Cell, Command, Decision, Heartbeat, Incarnation, MonotonicNs, PeerTable, Record, Refusal,
    RobotId, Role, RunId, Status, Term,
};
use hopper_sim::arbiter::BID_GRACE_NS;
use hopper_sim::{Arbiter, Effect, Event, Pace, REPUBLISH_NS};

use crate::fixture::{
    EAST, Host, LINGER_NS, RUN, WEST, beat, command, mission, name, sure_mission, undisturbed,
};

/// The command as another planner would send it, for `term`.
fn rival(command: Command, term: u64) -> Command {
    Command { term: Term(term), incarnation: Incarnation(2), pid: 200, planner: name("greedy"), ..command }
}

/// A host under way: planner 1 leads term 1, decision 1 is due.
fn led() -> Host {
    let mut host = Host::fresh();
    host.send(command(&host.state(), EAST));
    assert_eq!(host.state().decision, Decision(1));
    host
}

fn bare(pace: Pace) -> Arbiter {
    let mut arbiter = Arbiter::new(mission(), None, pace, LINGER_NS, MonotonicNs(1_000));
    arbiter.on(Event::Tick, MonotonicNs(1_000));
    arbiter
}

/// Accepts an eastward hop at 2,000 without answering the append.
fn committing(pace: Pace) -> (Arbiter, contract::Record) {
    let mut arbiter = bare(pace);
    let order = command(arbiter.state(), EAST);
    let effects = arbiter.on(Event::Command(Ok(order)), MonotonicNs(2_000));
    let [Effect::Append(record)] = effects[..] else {
        panic!("one append and nothing else, got {effects:?}")
    };
    (arbiter, record)
}

#[test]
fn the_first_tick_publishes_the_opening_state() {
    let mut arbiter = Arbiter::new(mission(), None, Pace::Max, LINGER_NS, MonotonicNs(1_000));
    assert_eq!(arbiter.wake_at(), Some(MonotonicNs(1_000)), "at once");
    let effects = arbiter.on(Event::Tick, MonotonicNs(1_200));
    let [Effect::Publish(state)] = effects[..] else { panic!("{effects:?}") };
    assert_eq!((state.run, state.decision, state.pose.cell), (RUN, Decision(0), Cell::new(1, 2)));
    assert_eq!((state.landed, state.published), (MonotonicNs(1_200), MonotonicNs(1_200)));
    assert_eq!((state.leader.term, state.last, state.digest), (Term(0), None, mission().genesis()));
}

#[test]
fn the_state_is_published_again_unchanged_every_period() {
    let mut arbiter = bare(Pace::Max);
    let due = MonotonicNs(1_000 + REPUBLISH_NS);
    assert_eq!(arbiter.wake_at(), Some(due));
    assert_eq!(arbiter.on(Event::Tick, MonotonicNs(due.0 - 1)), []);
    let before = *arbiter.state();
    assert_eq!(arbiter.on(Event::Tick, due), [Effect::Publish(before)]);
    assert_eq!(arbiter.wake_at(), Some(due.plus_ns(REPUBLISH_NS)));
}

/// P-COMMIT: Nothing is published before the journal holds it.
#[test]
fn nothing_is_published_before_the_journal_holds_it() {
    let (mut arbiter, record) = committing(Pace::Max);
    let effects = arbiter.on(Event::Tick, MonotonicNs(500_000_000));
    assert!(matches!(effects[..], [Effect::Publish(state)] if state.decision == Decision(0)), "{effects:?}");
    let effects = arbiter.on(Event::Appended, MonotonicNs(500_000_007));
    let [Effect::Publish(state)] = effects[..] else { panic!("{effects:?}") };
    assert_eq!(
        (state.decision, state.digest, state.last),
        (Decision(1), record.digest, Some(record.outcome))
    );
}

#[test]
fn the_moments_of_a_decision_are_recorded_and_told() {
    let (mut arbiter, record) = committing(Pace::Max);
    let timing = record.timing;
    assert_eq!(
        timing.moments().map(|moment| moment.0),
        [1_000, 1_000, 1_010, 1_020, 1_030, 1_040, 2_000, 2_000]
    );
    arbiter.on(Event::Appended, MonotonicNs(2_009));
    let state = arbiter.state();
    assert_eq!(state.last_timing.committed, MonotonicNs(2_009), "the moment it was appended");
    assert_eq!((state.landed, state.published), (MonotonicNs(2_009), MonotonicNs(2_009)));
    assert_eq!(contract::Timing { committed: timing.committed, ..state.last_timing }, timing);
}

#[test]
fn the_record_says_who_commanded_what_and_continues_the_chain() {
    let (_, record) = committing(Pace::Max);
    assert_eq!((record.decision, record.action, record.observation, record.work), (Decision(0), EAST, 5, 12));
    let leader = record.leader;
    assert_eq!(
        (leader.term, leader.incarnation, leader.pid, leader.planner),
        (Term(1), Incarnation(1), 100, name("mdp"))
    );
    assert_eq!(record.previous, mission().genesis());
    assert_eq!(record.digest, record.previous.chain(&record));
    let mut arbiter = bare(Pace::Max);
    let cut = Command { cut: true, ..command(arbiter.state(), EAST) };
    let effects = arbiter.on(Event::Command(Ok(cut)), MonotonicNs(2_000));
    assert!(matches!(effects[..], [Effect::Append(Record { cut: true, .. })]) && !record.cut, "{effects:?}");
}

/// P-TERM: A stale term is refused; the next term takes over by compare-and-swap.
#[test]
fn the_current_term_goes_on_and_a_stale_one_is_refused() {
    let mut host = led();
    host.send(command(&host.state(), EAST));
    host.send(rival(command(&host.state(), EAST), 2));
    assert_eq!((host.state().decision, host.state().leader.term), (Decision(3), Term(2)));
    host.send(command(&host.state(), EAST));
    assert_eq!(host.refused, ["stale_term"]);
    assert_eq!(host.state().decision, Decision(3));
    assert_eq!(host.arbiter.refusals().of("stale_term"), 1);
}

/// P-TERM.
#[test]
fn the_next_term_takes_over_by_compare_and_swap_and_a_leap_is_refused() {
    let mut host = led();
    host.send(rival(command(&host.state(), EAST), 3));
    assert_eq!(host.refused, ["future_term"]);
    host.send(rival(command(&host.state(), EAST), 2));
    let leader = host.state().leader;
    assert_eq!((leader.term, leader.incarnation, leader.planner), (Term(2), Incarnation(2), name("greedy")));
}

/// P-BID: A takeover that arrived too late gets the next decision, in a team the next decision of
/// its robot. One that falls silent delays nobody for long.
#[test]
fn a_takeover_that_came_too_late_gets_the_next_decision() {
    let mut arbiter = led().arbiter;
    let now = arbiter.state().published;
    let incumbent = command(arbiter.state(), EAST);
    let late = Command { decision: Decision(0), ..rival(incumbent, 2) };
    arbiter.on(Event::Command(Ok(late)), now);
    assert_eq!(arbiter.refusals().of("repeated_decision"), 1);
    let effects = arbiter.on(Event::Command(Ok(incumbent)), now.plus_ns(BID_GRACE_NS - 1));
    assert!(matches!(effects[..], [Effect::Refused(Refusal::Yielding { .. })]), "{effects:?}");
    let effects = arbiter.on(Event::Command(Ok(rival(incumbent, 2))), now.plus_ns(BID_GRACE_NS - 1));
    assert!(matches!(effects[..], [Effect::Append(record)] if record.leader.term == Term(2)), "{effects:?}");
}

/// P-BID.
#[test]
fn a_takeover_that_falls_silent_keeps_nobody_waiting_for_long() {
    let mut arbiter = led().arbiter;
    let now = arbiter.state().published;
    let incumbent = command(arbiter.state(), EAST);
    let late = Command { decision: Decision(0), ..rival(incumbent, 2) };
    arbiter.on(Event::Command(Ok(late)), now);
    let grace_ns = BID_GRACE_NS.max(2 * arbiter.mission().brief.limits.decision_budget_ns);
    let effects = arbiter.on(Event::Command(Ok(incumbent)), now.plus_ns(grace_ns));
    assert!(matches!(effects[..], [Effect::Append(record)] if record.leader.term == Term(1)), "{effects:?}");
}

/// P-BID.
#[test]
fn of_two_takeovers_that_came_too_late_the_first_gets_the_next_decision() {
    let (mut arbiter, _) = committing(Pace::Hertz(10.0));
    let order = command(arbiter.state(), EAST);
    let third = |command| Command { incarnation: Incarnation(3), ..rival(command, 2) };
    let now = MonotonicNs(2_001);
    for late in [rival(order, 2), third(order)] {
        arbiter.on(Event::Command(Ok(late)), now);
    }
    assert_eq!(arbiter.refusals().of("busy"), 2);
    arbiter.on(Event::Appended, now);
    let now = arbiter.wake_at().unwrap().max(MonotonicNs(200_000_000));
    arbiter.on(Event::Tick, now);
    let order = command(arbiter.state(), EAST);
    for early in [order, third(order)] {
        let effects = arbiter.on(Event::Command(Ok(early)), now);
        assert!(matches!(effects[..], [Effect::Refused(Refusal::Yielding { .. })]), "{effects:?}");
    }
    let effects = arbiter.on(Event::Command(Ok(rival(order, 2))), now);
    assert!(matches!(effects[..], [Effect::Append(_)]), "{effects:?}");
}

/// P-BID.
#[test]
fn whoever_let_a_kept_decision_pass_is_not_waited_for_again_but_another_is() {
    let mut host = led();
    let grace_ns = BID_GRACE_NS.max(2 * mission().brief.limits.decision_budget_ns);
    let third = |command| Command { incarnation: Incarnation(3), ..rival(command, 2) };
    let before = command(&host.state(), EAST);
    host.send(Command { decision: Decision(0), ..rival(before, 2) });
    host.now = host.now.plus_ns(grace_ns);
    host.send(before);
    assert_eq!(host.state().decision, Decision(2), "it was waited for in vain");
    host.send(rival(before, 2));
    host.send(command(&host.state(), EAST));
    assert_eq!(host.state().decision, Decision(3), "it is too slow");
    host.send(third(before));
    host.send(command(&host.state(), EAST));
    assert_eq!((host.state().decision, host.refused.last()), (Decision(3), Some(&"yielding")));
    host.send(third(command(&host.state(), EAST)));
    assert_eq!((host.state().decision, host.state().leader.incarnation), (Decision(4), Incarnation(3)));
}

#[test]
fn a_stale_term_or_an_old_decision_is_no_bid() {
    let mut arbiter = led().arbiter;
    let now = arbiter.state().published;
    let incumbent = command(arbiter.state(), EAST);
    for (decision, term) in [(0, 1), (0, 3), (2, 2)] {
        let idle = Command { decision: Decision(decision), ..rival(incumbent, term) };
        arbiter.on(Event::Command(Ok(idle)), now);
    }
    let effects = arbiter.on(Event::Command(Ok(incumbent)), now);
    assert!(matches!(effects[..], [Effect::Append(_)]), "{effects:?}");
}

#[test]
fn before_the_first_command_only_term_one_may_begin() {
    for term in [0, 2, u64::MAX - 1] {
        let mut host = Host::fresh();
        let nobody = Command {
            incarnation: Incarnation(0),
            pid: 0,
            planner: contract::Name::NONE,
            ..command(&host.state(), EAST)
        };
        host.send(Command { term: Term(term), ..nobody });
        assert_eq!((host.state().decision, host.refused.len()), (Decision(0), 1), "term {term}");
    }
}

#[test]
fn of_two_rivals_for_one_term_the_first_wins() {
    let mut host = led();
    let order = command(&host.state(), EAST);
    let (first, second) = (rival(order, 2), Command { incarnation: Incarnation(3), ..rival(order, 2) });
    host.send(first);
    host.send(second);
    assert_eq!(host.refused, ["repeated_decision"], "its decision is gone");
    host.send(Command { decision: host.state().decision, digest: host.state().digest, ..second });
    assert_eq!(host.refused[1..], ["not_leader"], "and so is its term");
    assert_eq!(host.state().leader.incarnation, Incarnation(2));
}

#[test]
fn a_rival_learns_that_the_term_is_gone_while_its_first_command_is_being_committed() {
    let (mut arbiter, _) = committing(Pace::Max);
    let order = command(arbiter.state(), WEST);
    let mut reason = |order| {
        let effects = arbiter.on(Event::Command(Ok(order)), MonotonicNs(2_001));
        let [Effect::Refused(refusal)] = &effects[..] else { panic!("{effects:?}") };
        refusal.reason()
    };
    assert_eq!(reason(rival(order, 1)), "not_leader");
    assert_eq!(reason(rival(order, 2)), "busy", "it may ask again at the next decision");
    assert_eq!(reason(order), "busy");
}

#[test]
fn one_life_may_not_lead_a_term_under_two_names() {
    let mut host = led();
    host.send(Command { planner: name("greedy"), ..command(&host.state(), EAST) });
    assert_eq!(host.refused, ["not_leader"]);
}

/// P-ONCE: A repeated decision gets its recorded outcome, and is executed once however often its
/// command arrives.
#[test]
fn a_repeated_decision_gets_the_recorded_outcome() {
    let mut host = led();
    let told = host.state();
    let again = Command { decision: Decision(0), action: WEST, ..command(&told, WEST) };
    host.now = host.now.plus_ns(50);
    host.send(again);
    assert_eq!(host.refused, ["repeated_decision"]);
    assert_eq!(host.published.last(), Some(&told), "unchanged, its stamps included");
    assert_eq!(host.records.len(), 1);
}

/// P-ONCE.
#[test]
fn a_repeated_command_executes_once_however_often_it_comes() {
    let mut host = led();
    let order = command(&host.state(), EAST);
    for _ in 0..5 {
        host.send(order);
    }
    assert_eq!((host.records.len(), host.refused.len()), (2, 4));
}

#[test]
fn a_wrong_run_or_robot_or_a_future_decision_is_refused_and_counted() {
    let mut host = led();
    let order = command(&host.state(), EAST);
    host.send(Command { run: RunId(1), ..order });
    host.send(Command { robot: RobotId(1), ..order });
    host.send(Command { decision: Decision(2), ..order });
    host.on(Event::Command(Err(contract::Refusal::malformed("command.action", "a known tag", 9))));
    assert_eq!(host.refused, ["wrong_run", "wrong_robot", "future_decision", "malformed"]);
    assert_eq!(host.arbiter.refusals().0.values().sum::<u64>(), 4);
    assert_eq!(host.records.len(), 1);
}

/// P-TIMELINE. The command was planned on a past that the journal has lost since, for a decision
/// that is due again.
#[test]
fn a_command_planned_on_another_past_is_refused_and_its_sender_hears_the_state() {
    let mut host = led();
    let order = command(&host.state(), EAST);
    let published = host.published.len();
    host.send(Command { digest: contract::Digest([9; 32]), ..order });
    assert_eq!(host.refused, ["other_past"]);
    assert_eq!((host.records.len(), host.published.len()), (1, published + 1));
    assert_eq!(host.published.last(), Some(&host.state()));
    host.send(order);
    assert_eq!(host.records.len(), 2);
}

#[test]
fn when_the_mission_is_over_nothing_more_is_executed() {
    let mut host = Host::fresh();
    host.fly();
    let flown = host.records.len();
    let order = command(&host.state(), EAST);
    host.send(order);
    host.send(rival(order, 2));
    assert_eq!(host.refused, ["mission_over", "mission_over"]);
    host.send(Command { decision: Decision(order.decision.0 - 1), ..order });
    assert_eq!(host.published.last(), Some(&host.state()), "who missed the end is told");
    assert_eq!(host.records.len(), flown);
}

/// Whether a mission is manned by those who beat so.
fn is_manned(arbiter: &Arbiter, beats: &[Heartbeat]) -> bool {
    let now = MonotonicNs(2_000);
    let mut peers = PeerTable::default();
    beats.iter().for_each(|beat| peers.observe(*beat, now));
    arbiter.is_manned(&peers, now)
}

#[test]
fn a_mission_is_manned_by_a_perception_that_knows_its_run_and_a_planner() {
    let arbiter = bare(Pace::Max);
    let [perception, planner] =
        [(Role::Perception, 2), (Role::Planner, 3)].map(|(role, life)| beat(role, life, 1, Status::Underway));
    assert!(is_manned(&arbiter, &[perception, planner]));
    let stranger = Heartbeat { run: RunId(9), ..perception };
    for few in [&[][..], &[perception], &[planner], &[stranger, planner]] {
        assert!(!is_manned(&arbiter, few), "{few:?}");
    }
}

#[test]
fn a_mission_that_is_over_or_under_way_with_a_fallback_needs_nobody() {
    let mut host = Host::fresh();
    host.fly();
    assert!(is_manned(&host.arbiter, &[]));
    let mut mission = mission();
    mission.brief.guard.deadline_ns = 1_000_000;
    let mut host = Host::new(mission, Vec::new(), Pace::Max);
    assert!(!is_manned(&host.arbiter, &[]), "the first decision is a planner's");
    host.send(command(&host.state(), EAST));
    assert!(is_manned(&host.arbiter, &[]));
    assert!(!is_manned(&led().arbiter, &[]), "there is no deadline");
}

/// P-FULL.
#[test]
fn a_failed_append_keeps_the_very_record_and_draws_nothing_anew() {
    let (mut arbiter, record) = committing(Pace::Max);
    for attempt in 1..=3 {
        let now = MonotonicNs(2_000 + attempt * 10);
        assert_eq!(arbiter.on(Event::AppendFailed, now), [], "nothing is published");
        let resent = command(arbiter.state(), WEST);
        let effects = arbiter.on(Event::Command(Ok(resent)), now);
        assert!(matches!(effects[..], [Effect::Refused(contract::Refusal::Busy { .. })]), "{effects:?}");
        assert_eq!(arbiter.on(Event::Tick, now), [Effect::Append(record)], "bit for bit");
        assert_eq!(arbiter.on(Event::Tick, now), [], "asked once an attempt");
    }
    let effects = arbiter.on(Event::Appended, MonotonicNs(3_000));
    assert!(matches!(effects[..], [Effect::Publish(state)] if state.digest == record.digest));
}

#[test]
fn while_the_journal_refuses_the_state_before_is_still_served_and_ticks_go_on() {
    let (mut arbiter, record) = committing(Pace::Max);
    arbiter.on(Event::AppendFailed, MonotonicNs(2_010));
    let wake = arbiter.wake_at().unwrap();
    assert!(wake <= MonotonicNs(2_010 + REPUBLISH_NS), "the retry is not forgotten");
    let before = *arbiter.state();
    assert_eq!(arbiter.on(Event::Tick, wake), [Effect::Append(record), Effect::Publish(before)]);
}

#[test]
fn a_planner_that_dies_after_sending_loses_nothing_and_its_heir_takes_the_next_term() {
    let mut host = led();
    host.send(command(&host.state(), EAST));
    let order = command(&host.state(), EAST);
    host.send(rival(order, 2));
    assert_eq!((host.state().decision, host.state().leader.planner), (Decision(3), name("greedy")));
}

#[test]
fn in_real_time_the_next_state_is_published_when_the_hop_lands() {
    let (mut arbiter, record) = committing(Pace::Real);
    let flight_ns = (record.outcome.flight.flight_time_s * 1e9).round() as u64;
    assert!(flight_ns > 500_000_000, "a hop of one metre on Mars takes 0.7 s, got {flight_ns} ns");
    assert_eq!(arbiter.on(Event::Appended, MonotonicNs(2_050)), [], "in the air");
    let landing = MonotonicNs(2_050 + flight_ns);
    let mut now = MonotonicNs(2_050);
    while now < landing {
        assert_eq!(arbiter.state().decision, Decision(0));
        now = arbiter.wake_at().unwrap();
        let republished = arbiter.on(Event::Tick, now);
        assert_eq!(republished.len(), 1, "each wake has a reason");
    }
    assert_eq!(now, landing, "woken for the landing exactly");
    let state = arbiter.state();
    assert_eq!((state.decision, state.landed, state.published), (Decision(1), landing, landing));
    assert_eq!(state.last_timing.committed, MonotonicNs(2_050));
}

#[test]
fn in_real_time_a_hop_on_sand_lasts_its_two_flights() {
    let mut arbiter =
        Arbiter::new(sure_mission(Cell::new(3, 2)), None, Pace::Real, LINGER_NS, MonotonicNs(1_000));
    arbiter.on(Event::Tick, MonotonicNs(1_000));
    let order = command(arbiter.state(), EAST);
    arbiter.on(Event::Command(Ok(order)), MonotonicNs(2_000));
    arbiter.on(Event::Appended, MonotonicNs(2_000));
    let mut now = MonotonicNs(2_000);
    while arbiter.state().decision == Decision(0) {
        now = arbiter.wake_at().unwrap();
        arbiter.on(Event::Tick, now);
    }
    let flight = arbiter.state().last.unwrap().flight;
    assert_eq!(flight.flights, 2);
    assert_eq!(now.since_ns(MonotonicNs(2_000)), (2.0 * flight.flight_time_s * 1e9).round() as u64);
}

#[test]
fn in_the_air_commands_are_refused_as_busy_and_the_late_tick_is_not_the_landing() {
    let (mut arbiter, _) = committing(Pace::Hertz(10.0));
    arbiter.on(Event::Appended, MonotonicNs(2_050));
    let order = command(arbiter.state(), EAST);
    let effects = arbiter.on(Event::Command(Ok(order)), MonotonicNs(3_000));
    assert!(matches!(effects[..], [Effect::Refused(contract::Refusal::Busy { decision: Decision(0) })]));
    arbiter.on(Event::Tick, MonotonicNs(150_000_000));
    let state = arbiter.state();
    assert_eq!((state.landed, state.published), (MonotonicNs(100_001_000), MonotonicNs(150_000_000)));
}

#[test]
fn a_rate_is_kept_without_drift() {
    let mut host = Host::new(sure_mission(Cell::new(1, 2)), Vec::new(), Pace::Hertz(4.0));
    for hop in 1..=5 {
        let order = command(&host.state(), Action::Hold);
        host.send(order);
        host.now = host.arbiter.wake_at().unwrap().max(MonotonicNs(1_000 + hop * 250_000_000));
        host.tick_after(3);
        assert_eq!((host.state().decision.0, host.state().landed.0), (hop, 1_000 + hop * 250_000_000));
    }
}

#[test]
fn a_mission_that_starts_at_its_goal_is_over_before_its_first_command() {
    let mut mission = mission();
    mission.brief.robots[0].start.cell = mission.brief.goal_after(0).unwrap();
    let mut host = Host::new(mission, Vec::new(), Pace::Max);
    assert_eq!(host.state().status, Status::Goal);
    host.send(command(&host.state(), EAST));
    assert_eq!(host.refused, ["mission_over"]);
}

#[test]
fn the_digest_knows_nothing_of_terms_times_and_incarnations() {
    let calm = undisturbed();
    let mut host = Host::fresh();
    let mut term = 0;
    while !host.state().status.is_over() {
        let state = host.state();
        term += u64::from(state.decision.0.is_multiple_of(3));
        host.now = host.now.plus_ns(state.decision.0 * 1_234_567);
        let order = command(&state, crate::fixture::steer(&mission().brief, &state));
        host.send(Command {
            term: Term(term),
            incarnation: Incarnation(900 + term),
            pid: 7,
            work: 1,
            ..order
        });
        host.send(order);
    }
    assert!(term > 3);
    assert_eq!(host.records.last().unwrap().digest, calm.last().unwrap().digest);
}
