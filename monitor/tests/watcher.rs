//! The watcher is a fold over public messages, whichever of them get lost.

// Helpers of tests are not recognised as tests.
#![allow(clippy::unwrap_used)]

#[path = "../../crates/report/tests/mission/mod.rs"]
mod mission;

use contract::limits::{ASK_AGAIN_NS, PAST_PAGE_RECORDS};
use contract::protocol::peer_table::SILENCE_NS;
use contract::{
    Account, Action, Branch, Brief, Decision, Digest, Direction, Heartbeat, Incarnation, MapPatch,
    MonotonicNs, Name, PastPage, PastRequest, Record, Refusal, RobotId, Role, RunId, State, Status, Term,
};
use mission::{Step, brief, driver, ground, helicopter, name, records, start, with_robots};
use monitor::{Effect, Event, Progress, Watcher};

const SIDE: u32 = 100;

/// East and north in turn from (1, 1) to the goal at (98, 98), with a hop that gets nowhere now and then.
fn steps() -> Vec<Step> {
    let hop = |n: usize| Action::Hop(if n.is_multiple_of(2) { Direction::East } else { Direction::North });
    let leg = (0..194).flat_map(|n| {
        let stuck = n % 9 == 8;
        stuck.then_some((hop(n), Branch::Stayed)).into_iter().chain([(hop(n), Branch::Intended)])
    });
    leg.collect()
}

fn state(record: &Record, run: RunId) -> State {
    record.state_after(run, record.timing.committed, record.timing.committed.plus_ns(10))
}

/// The state before the first decision.
fn opening(brief: &Brief) -> State {
    let first = records(brief, &steps()[..1], 9)[0];
    State {
        decision: Decision(0),
        steps: 0,
        leader: contract::Leader::default(),
        pose: contract::Pose { cell: start(brief), height_m: 0.0 },
        last: None,
        digest: Digest::default(),
        last_timing: contract::Timing::default(),
        ..state(&first, brief.run)
    }
}

fn beat(role: Role, incarnation: u64, counter: u64) -> Event {
    Event::Heartbeat(Heartbeat {
        role,
        incarnation: Incarnation(incarnation),
        pid: 100 + incarnation as u32,
        version: Name::NONE,
        planner: Name::NONE,
        counter,
        run: RunId(1),
        decision: Decision(0),
        status: Status::Underway,
        robots: contract::RobotSet::default(),
    })
}

fn page(records: &[Record], request: &PastRequest) -> PastPage {
    let from = request.from.0 as usize;
    let upto = records.len().min(from + PAST_PAGE_RECORDS);
    PastPage {
        run: request.run,
        robot: request.robot,
        from: request.from,
        records: records[from..upto].to_vec(),
    }
}

fn requests(effects: &[Effect]) -> Vec<PastRequest> {
    effects
        .iter()
        .filter_map(|effect| if let Effect::RequestPast(r) = effect { Some(*r) } else { None })
        .collect()
}

fn finished(effects: &[Effect]) -> Option<Status> {
    effects.iter().find_map(|effect| if let Effect::Finished(status) = effect { Some(*status) } else { None })
}

/// Answers requests until there are none; gives all other effects.
fn answer(watcher: &mut Watcher, records: &[Record], effects: Vec<Effect>, now: MonotonicNs) -> Vec<Effect> {
    let mut queue = effects;
    let mut others = Vec::new();
    while !queue.is_empty() {
        let asked = requests(&queue);
        others.extend(queue.into_iter().filter(|effect| !matches!(effect, Effect::RequestPast(_))));
        queue =
            asked.iter().flat_map(|request| watcher.on(Event::Past(page(records, request)), now)).collect();
    }
    others
}

fn watching(brief: &Brief) -> Watcher {
    let mut watcher = Watcher::new(RobotId(0));
    watcher.on(Event::Brief(brief.clone()), MonotonicNs(0));
    watcher.on(Event::State(opening(brief)), MonotonicNs(0));
    watcher
}

/// Hears every state of the mission.
fn undisturbed(brief: &Brief, records: &[Record]) -> Watcher {
    let mut watcher = watching(brief);
    for record in records {
        let effects = watcher.on(Event::State(state(record, brief.run)), record.timing.committed);
        assert!(requests(&effects).is_empty(), "nothing is missing");
    }
    watcher
}

/// The patch of a landing after which so many cells are seen.
fn landing(brief: &Brief, decision: u64, seen_cells: usize) -> MapPatch {
    MapPatch {
        run: brief.run,
        robot: RobotId(0),
        through: Decision(decision),
        digest: Digest::default(),
        more: 0,
        sequence: decision + 1,
        before: 1,
        after: 2,
        sensed: MonotonicNs(0),
        published: MonotonicNs(0),
        grid: brief.grid,
        seen_cells: seen_cells as u32,
        treasures: Vec::new(),
        cells: Vec::new(),
    }
}

#[test]
fn a_rebuild_from_the_past_equals_the_undisturbed_fold() {
    let brief = brief(SIDE);
    let records = records(&brief, &steps(), 30);
    assert!(records.len() > 3 * PAST_PAGE_RECORDS && records.last().unwrap().status == Status::Goal);
    let whole = undisturbed(&brief, &records);
    for heard in [
        vec![records.len() - 1],
        vec![0, 70, 71, 140, 209, records.len() - 1],
        (100..records.len()).collect(),
    ] {
        let mut watcher = Watcher::new(RobotId(0));
        watcher.on(Event::Brief(brief.clone()), MonotonicNs(0));
        let mut others = Vec::new();
        for at in heard {
            let now = records[at].timing.committed;
            let effects = watcher.on(Event::State(state(&records[at], brief.run)), now);
            others.extend(answer(&mut watcher, &records, effects, now));
        }
        assert_eq!(watcher.tally(), whole.tally());
        assert_eq!(watcher.latency(), whole.latency());
        assert_eq!(watcher.progress(MonotonicNs(9)), whole.progress(MonotonicNs(9)));
        assert_eq!(finished(&others), Some(Status::Goal));
    }
}

#[test]
fn the_past_is_asked_for_again_and_again_until_it_answers() {
    let brief = brief(SIDE);
    let records = records(&brief, &steps(), 30);
    let mut watcher = watching(&brief);
    let request = PastRequest { run: brief.run, robot: RobotId(0), from: Decision(0) };
    let effects = watcher.on(Event::State(state(&records[9], brief.run)), MonotonicNs(5));
    assert_eq!(requests(&effects), [request]);
    let effects = watcher.on(Event::State(state(&records[10], brief.run)), MonotonicNs(6));
    assert!(requests(&effects).is_empty(), "asked when the gap opened; the next time at the tick");
    for tick in 1..4 {
        let now = MonotonicNs(5).plus_ns(tick * ASK_AGAIN_NS);
        let early = requests(&watcher.on(Event::Tick, MonotonicNs(now.0 - 1)));
        assert!(early.is_empty(), "asking anew gives up the answer that may be on its way");
        assert_eq!(requests(&watcher.on(Event::Tick, now)), [request]);
    }
    const LATE: MonotonicNs = MonotonicNs(1 << 40);
    let empty = PastPage { run: brief.run, robot: RobotId(0), from: Decision(0), records: Vec::new() };
    assert!(watcher.on(Event::Past(empty), LATE).is_empty(), "no news: wait for the tick");
    assert_eq!(watcher.progress(LATE).unwrap().missing, 11);
    watcher.on(Event::Past(page(&records, &request)), LATE.plus_ns(1));
    assert!(requests(&watcher.on(Event::Tick, LATE.plus_ns(ASK_AGAIN_NS))).is_empty());
    assert_eq!(watcher.progress(LATE.plus_ns(ASK_AGAIN_NS)).unwrap().missing, 0);
}

#[test]
fn repeated_old_and_foreign_messages_change_nothing() {
    let brief = brief(SIDE);
    let records = records(&brief, &steps(), 30);
    let mut watcher = undisturbed(&brief, &records[..50]);
    let before = watcher.progress(MonotonicNs(9));
    let foreign = RunId(2);
    for event in [
        Event::Brief(brief.clone()),
        Event::State(state(&records[49], brief.run)),
        Event::State(state(&records[3], brief.run)),
        Event::State(state(&records[60], foreign)),
        Event::State(State { robot: RobotId(1), ..state(&records[60], brief.run) }),
        Event::Past(page(&records, &PastRequest { run: foreign, robot: RobotId(0), from: Decision(50) })),
        Event::Past(page(
            &records[..50],
            &PastRequest { run: brief.run, robot: RobotId(0), from: Decision(0) },
        )),
        Event::Past(PastPage {
            run: brief.run,
            robot: RobotId(0),
            from: Decision(60),
            records: records[60..64].into(),
        }),
    ] {
        assert!(watcher.on(event, MonotonicNs(8)).is_empty());
        assert_eq!(watcher.progress(MonotonicNs(9)), before);
    }
}

#[test]
fn a_new_run_drops_everything_known() {
    let old = brief(SIDE);
    let records = records(&old, &steps(), 30);
    let mut watcher = undisturbed(&old, &records);
    watcher.on(Event::Map(landing(&old, 4, 7)), MonotonicNs(1));
    watcher.on(Event::Refused(Refusal::malformed("pose.x", "0 to 99", -1)), MonotonicNs(1));
    let new = Brief { run: RunId(2), ..old };
    watcher.on(Event::Brief(new.clone()), MonotonicNs(2));
    assert_eq!(watcher.seen(), (RunId(0), Decision(0), Status::Underway));
    watcher.on(Event::State(opening(&new)), MonotonicNs(3));
    let mut fresh = Watcher::new(RobotId(0));
    fresh.on(Event::Brief(new.clone()), MonotonicNs(2));
    fresh.on(Event::State(opening(&new)), MonotonicNs(3));
    assert_eq!(watcher.progress(MonotonicNs(4)), fresh.progress(MonotonicNs(4)));
    assert_eq!(watcher.seen(), (new.run, Decision(0), Status::Underway));
}

#[test]
fn changes_of_leader_are_recorded_even_if_they_fall_into_a_gap() {
    let brief = brief(SIDE);
    let records = records(&brief, &steps(), 30);
    let mut watcher = undisturbed(&brief, &records[..20]);
    let effects = watcher.on(Event::State(state(&records[39], brief.run)), MonotonicNs(1));
    answer(&mut watcher, &records, effects, MonotonicNs(1));
    let progress = watcher.progress(MonotonicNs(2)).unwrap();
    assert_eq!(progress.changes_of_leader(), 1);
    let [first, second] = progress.planners[..] else { panic!("{progress:?}") };
    assert_eq!((first.name, first.term), (name("mdp"), Term(1)));
    assert_eq!((first.from_decision, first.to_decision), (Decision(0), Decision(29)));
    assert_eq!((second.name, second.term), (name("greedy"), Term(2)));
    assert_eq!(second.from_decision, Decision(30));
    assert!(second.to_decision >= Decision(39) && progress.leader() == Some(&second));
}

#[test]
fn progress_tells_steps_distance_coverage_and_latency() {
    let brief = brief(SIDE);
    let mut records = records(&brief, &steps()[..4], 30);
    records[3].timing.committed = records[3].timing.landed.plus_ns(700_000_000);
    let mut watcher = undisturbed(&brief, &records);
    let map = ground(&brief).1;
    let patch = landing(&brief, 4, map.seen_cells());
    watcher.on(Event::Map(patch.clone()), MonotonicNs(1));
    watcher.on(Event::Map(MapPatch { through: Decision(3), seen_cells: 1, ..patch.clone() }), MonotonicNs(1));
    watcher.on(Event::Map(MapPatch { run: RunId(99), seen_cells: 2, ..patch }), MonotonicNs(1));
    let progress = watcher.progress(MonotonicNs(2)).unwrap();
    assert_eq!((progress.decision, progress.steps, progress.steps_max), (Decision(4), 8, 150));
    assert_eq!(progress.distance_to_goal_m, Some((95.0_f64 * 95.0 * 2.0).sqrt()));
    assert_eq!(progress.coverage, Some(map.coverage()));
    assert_eq!((progress.latency.decisions, progress.latency.misses), (4, 1));
    assert_eq!((progress.latency.last_us, progress.latency.budget_us), (700_000.0, 600_000.0));
    assert!((progress.latency.p50_us - 300.0).abs() < 0.3, "three digits: {}", progress.latency.p50_us);
    let stages: f64 = watcher.latency().unwrap().stages.values().map(|stage| stage.mean_us).sum();
    assert!((stages - watcher.latency().unwrap().total.mean_us).abs() < 0.005, "stages sum to the total");
}

#[test]
fn the_end_waits_for_the_past_while_hopper_sim_lives() {
    let brief = brief(SIDE);
    let records = records(&brief, &steps(), 30);
    let mut watcher = Watcher::new(RobotId(0));
    watcher.on(Event::Brief(brief.clone()), MonotonicNs(0));
    let end = state(records.last().unwrap(), brief.run);
    assert_eq!(finished(&watcher.on(Event::State(end), MonotonicNs(0))), None);
    assert_eq!(watcher.seen().2, Status::Underway, "hopper-sim shall linger");
    watcher.on(beat(Role::HopperSim, 1, 1), MonotonicNs(SILENCE_NS));
    let effects = watcher.on(Event::Tick, MonotonicNs(2 * SILENCE_NS));
    assert_eq!(finished(&effects), None);
    let mut orphan = watcher.clone();
    assert_eq!(
        finished(&orphan.on(Event::Tick, MonotonicNs(2 * SILENCE_NS + 1))),
        Some(Status::Goal),
        "nobody left"
    );
    assert_eq!(finished(&orphan.on(Event::Tick, MonotonicNs(2 * SILENCE_NS + 2))), None, "said once");
    let others = answer(&mut watcher, &records, effects, MonotonicNs(2 * SILENCE_NS));
    assert_eq!(finished(&others), Some(Status::Goal));
    let shown: Vec<&Progress> = others
        .iter()
        .filter_map(|effect| if let Effect::Progress(p) = effect { Some(&**p) } else { None })
        .collect();
    assert_eq!(shown.last().map(|progress| (progress.status, progress.missing)), Some((Status::Goal, 0)));
    assert_eq!(watcher.seen(), (brief.run, end.decision, Status::Goal));
}

/// hopper-sim leaves once the end is acknowledged, and `hopper run` then stops the monitor: the last line comes first.
#[test]
fn the_end_is_acknowledged_only_once_it_was_shown() {
    let brief = brief(SIDE);
    let records = records(&brief, &steps(), 30);
    let (last, before) = records.split_last().unwrap();
    let mut watcher = undisturbed(&brief, before);
    watcher.on(Event::Map(landing(&brief, before.len() as u64, 1)), MonotonicNs(1));
    let now = last.timing.committed;
    let effects = watcher.on(Event::State(state(last, brief.run)), now);
    assert_eq!((finished(&effects), watcher.seen().2), (None, Status::Underway), "the last map is due");
    let mut mapped = watcher.clone();
    mapped.on(Event::Map(landing(&brief, records.len() as u64, 2)), now);
    for (mut watcher, later) in [(mapped, now), (watcher, now.plus_ns(400_000_000))] {
        assert_eq!(finished(&watcher.on(Event::Tick, later)), Some(Status::Goal));
        assert_eq!(watcher.seen().2, Status::Goal);
    }
}

/// What is published of the robots may come later than the first state.
#[test]
fn a_mission_of_several_robots_is_worded_for_robots_from_its_first_line_on() {
    let alone = brief(SIDE);
    let line = |brief: &Brief| watching(brief).progress(MonotonicNs(1)).unwrap();
    assert!(line(&alone).to_string().starts_with("hop 0, step 0/150, 137.2 m to go"));
    let hopper = alone.robots[0];
    let rover = contract::Robot {
        body: contract::Body::Rover(contract::Rover { speed_mps: 1.0 }),
        goal: contract::Goal::Cover(contract::Cover::default()),
        ..hopper
    };
    let (driver, helicopter) = (driver(&alone, hopper.start_at), helicopter(&alone));
    for (account, robots, need, compact) in [
        (Account::Hopper, &[hopper, helicopter][..], "137.2 m to go", "137.2 m"),
        (Account::ActionsWithoutWaits, &[rover; 4], "0 cells covered", "0 cells"),
        (Account::Actions, &[driver, helicopter], "2 robots", "2 robots"),
    ] {
        let brief = with_robots(&alone, account, robots);
        let progress = line(&brief);
        assert!(progress.to_string().starts_with(&format!("decision 0, step 0/150, {need}")), "{progress}");
        assert_eq!(progress.compact(), format!("decision 0 · {compact}"));
    }
}

#[test]
fn a_mission_stopped_between_hops_ends() {
    let brief = brief(SIDE);
    let records = records(&brief, &steps(), 30);
    let mut watcher = undisturbed(&brief, &records[..5]);
    let lost = State { status: Status::Lost, ..state(&records[4], brief.run) };
    assert_eq!(finished(&watcher.on(Event::State(lost), MonotonicNs(1))), Some(Status::Lost));
    assert_eq!(watcher.seen(), (brief.run, Decision(5), Status::Lost));
}

#[test]
fn a_role_that_falls_silent_is_told_and_counted() {
    let brief = brief(SIDE);
    let mut watcher = watching(&brief);
    let health = |watcher: &Watcher, now| watcher.progress(now).unwrap().health[2];
    assert_eq!((health(&watcher, MonotonicNs(1)).alive, health(&watcher, MonotonicNs(1)).pid), (0, None));
    watcher.on(beat(Role::Planner, 5, 1), MonotonicNs(10));
    watcher.on(beat(Role::Planner, 6, 1), MonotonicNs(10));
    assert_eq!(health(&watcher, MonotonicNs(20)).alive, 2);
    // A counter that stands still proves no life; an hour later nobody remembers the process but its silence is told.
    let hour = MonotonicNs(3600 * SILENCE_NS);
    for now in [MonotonicNs(SILENCE_NS + 11), hour] {
        watcher.on(beat(Role::Planner, 5, 1), now);
        watcher.on(Event::Tick, now);
    }
    let silent = health(&watcher, MonotonicNs(SILENCE_NS * 3600));
    assert_eq!((silent.silences, silent.pid, silent.silent_ms), (1, Some(106), 3_599_999));
    watcher.on(beat(Role::Planner, 7, 1), hour.plus_ns(1));
    watcher.on(Event::Tick, hour.plus_ns(2));
    let back = health(&watcher, hour.plus_ns(2));
    assert_eq!((back.silences, back.longest_silence_ms, back.silent_ms), (1, 3_599_999, 0));
    assert_eq!(back.pid, Some(107));
}

#[test]
fn malformed_messages_and_a_broken_chain_are_counted() {
    let brief = brief(SIDE);
    let records = records(&brief, &steps(), 30);
    let mut watcher = undisturbed(&brief, &records[..5]);
    watcher.on(Event::Refused(Refusal::malformed("pose.x", "0 to 99", -1)), MonotonicNs(1));
    watcher.on(Event::State(state(&records[9], brief.run)), MonotonicNs(1));
    let request = PastRequest { run: brief.run, robot: RobotId(0), from: Decision(5) };
    let mut forged = page(&records[..10], &request);
    forged.records[0].previous = Digest([9; 32]);
    watcher.on(Event::Past(forged), MonotonicNs(1));
    let progress = watcher.progress(MonotonicNs(1)).unwrap();
    assert_eq!((progress.refusals.of("malformed"), progress.missing), (2, 5));
    watcher.on(Event::Past(page(&records, &request)), MonotonicNs(1));
    assert_eq!(watcher.progress(MonotonicNs(1)).unwrap().missing, 0, "the true past still counts");
}

#[test]
fn progress_is_shown_ten_times_a_second() {
    let mut watcher = watching(&brief(SIDE));
    let ticks = (0..1000).map(|ms| watcher.on(Event::Tick, MonotonicNs(1_000_000 * ms)));
    assert_eq!(ticks.flatten().filter(|effect| matches!(effect, Effect::Progress(_))).count(), 10);
}

#[test]
fn a_watcher_says_for_what_it_waits() {
    let brief = brief(SIDE);
    let mut watcher = Watcher::new(RobotId(0));
    assert_eq!(watcher.waits_for(), Some("hopper-sim: no brief yet"));
    watcher.on(Event::Brief(brief.clone()), MonotonicNs(0));
    assert_eq!(watcher.waits_for(), Some("hopper-sim: no state yet"));
    watcher.on(Event::State(opening(&brief)), MonotonicNs(0));
    assert_eq!(watcher.waits_for(), None);
}

/// P-TIMELINE. A journal is restored to decision 10 and continued elsewhere, to before, at and
/// after the decision that the monitor knows.
#[test]
fn a_past_that_is_no_longer_the_journals_is_folded_anew() {
    let brief = brief(SIDE);
    let walked = records(&brief, &steps(), 30);
    let detour = [(Action::Hop(Direction::North), Branch::Stayed)];
    let other: Vec<Step> =
        steps()[..10].iter().copied().chain(detour).chain(steps()[10..].to_vec()).collect();
    let elsewhere = records(&brief, &other, 10);
    assert_eq!((walked[9].digest, walked[10].digest == elsewhere[10].digest), (elsewhere[9].digest, false));
    for through in [8, 15, 19, 20, 21, 60] {
        let mut watcher = undisturbed(&brief, &walked[..20]);
        let later = walked[19].timing.committed.plus_ns(1_000_000_000_000);
        let told = State { published: later, ..state(&elsewhere[through - 1], brief.run) };
        let mut effects = watcher.on(Event::State(told), later);
        for round in 0..4 {
            answer(&mut watcher, &elsewhere[..through], effects, later.plus_ns(2 * round * ASK_AGAIN_NS));
            effects = watcher.on(Event::Tick, later.plus_ns((2 * round + 1) * ASK_AGAIN_NS));
        }
        let tally = watcher.tally().unwrap();
        assert_eq!(tally.due(), Decision(through as u64));
        assert_eq!(tally.last.unwrap().digest, elsewhere[through - 1].digest, "{through}");
        assert_eq!(
            tally.route,
            undisturbed(&brief, &elsewhere[..through]).tally().unwrap().route,
            "{through}"
        );
    }
}
