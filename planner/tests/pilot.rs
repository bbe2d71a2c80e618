//! The pilot: who may speak, for which decision, under which term.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use contract::limits::ASK_AGAIN_NS;
use contract::protocol::peer_table::SILENCE_NS;
use contract::{
    Account, Action, Body, Brief, Cell, Command, Decision, Digest, Direction, Driver, Goal, Ground,
    Heartbeat, Incarnation, Leader, MapPage, MapPatch, MapRequest, Member, MonotonicNs, MotionRow,
    MotionTable, Name, ObservedMap, Pose, PriorCell, PriorPage, PriorRequest, Reach, Robot, RobotId, Robots,
    Role, Route, RoutePage, RouteRequest, RunId, Sampling, SeenCell, Sensor, SpeedPrior, State, Status,
    TableLanding, TablePage, TableRequest, Team, Term, Timing, Track, Travel, Visit, Waypoint,
};
use planner::pilot::{Effect, Event, Pilot, PilotConfig, RESEND_NS};
use planner::{Plan, PlanStatus};

const RUN: RunId = RunId(7);
const ME: Incarnation = Incarnation(1);
const OTHER: Incarnation = Incarnation(2);
/// How long a leader whose process is gone is waited for: a fifth of a second.
const DEATH_SILENCE_NS: u64 = 200_000_000;

fn name(text: &str) -> Name {
    text.parse().unwrap()
}

fn at(ns: u64) -> MonotonicNs {
    MonotonicNs(ns)
}

fn brief() -> Brief {
    Brief { run: RUN, ..scenario::load("hard").unwrap().resolve().unwrap().brief }
}

fn config(takeover: bool) -> PilotConfig {
    PilotConfig {
        robots: contract::RobotSet::default(),
        incarnation: ME,
        pid: 11,
        planner: name("mdp"),
        takeover,
        succeeds_pid: None,
    }
}

fn uninformed(takeover: bool) -> Pilot {
    Pilot::new(config(takeover))
}

fn pilot(takeover: bool) -> Pilot {
    let mut pilot = uninformed(takeover);
    assert_eq!(pilot.on(Event::Brief(brief()), at(0)), []);
    pilot
}

fn state(decision: u64, term: u64, leader: Incarnation) -> State {
    State {
        run: RUN,
        robot: RobotId(0),
        decision: Decision(decision),
        steps: 0,
        status: Status::Underway,
        leader: Leader {
            term: Term(term),
            incarnation: leader,
            pid: leader.0 as u32 + 10,
            planner: name("mdp"),
        },
        pose: Pose { cell: Cell::new(1, 2), height_m: 0.0 },
        collected: contract::Collected::default(),
        last: None,
        previous: Digest::default(),
        digest: Digest::default(),
        landed: at(0),
        published: at(0),
        visits: 0,
        vetoed: contract::Vetoed::NONE,
        last_origin: contract::Origin::Planner,
        last_vetoed: contract::Vetoed::NONE,
        last_timing: Timing::default(),
    }
}

/// A landing that revealed nothing; the map stays empty.
fn map(decision: u64) -> MapPatch {
    MapPatch {
        run: RUN,
        robot: RobotId(0),
        through: Decision(decision),
        digest: Digest::default(),
        more: 0,
        sequence: 0,
        before: 0,
        after: 0,
        sensed: at(0),
        published: at(0),
        grid: brief().grid,
        seen_cells: 0,
        treasures: Vec::new(),
        cells: Vec::new(),
    }
}

fn planned() -> Event {
    let plan =
        Plan { action: Action::Hop(Direction::North), status: PlanStatus::Solved, work: 3, error_bound: 0.0 };
    Event::Planned(plan, at(1), at(2))
}

/// The terms under which commands were sent.
fn sent(effects: &[Effect]) -> Vec<(u64, u64)> {
    effects
        .iter()
        .filter_map(|effect| match effect {
            Effect::Send(Command { decision, term, .. }) => Some((decision.0, term.0)),
            _ => None,
        })
        .collect()
}

fn beat(of: Incarnation, counter: u64) -> Event {
    Event::Heartbeat(Heartbeat {
        role: Role::Planner,
        incarnation: of,
        pid: 12,
        version: Name::NONE,
        planner: Name::NONE,
        counter,
        run: RUN,
        decision: Decision(0),
        status: Status::Underway,
        robots: contract::RobotSet::default(),
    })
}

/// P-TOGETHER: No planner decides before its state and its map belong to the same decision.
#[test]
fn nobody_decides_before_state_and_map_are_of_one_decision() {
    let mut pilot = pilot(false);
    assert_eq!(pilot.on(Event::State(state(3, 0, Incarnation(0))), at(0)), []);
    assert_eq!(pilot.on(Event::Patch(map(2)), at(0)), []);
    assert!(pilot.waits_for().is_some_and(|what| what.contains("perception")));
    assert_eq!(pilot.on(Event::Patch(map(3)), at(0)), [Effect::Plan]);
    assert!(pilot.waits_for().is_none());
    assert_eq!(sent(&pilot.on(planned(), at(2))), [(3, 1)]);
}

/// P-WHOLE: A planner that has missed a patch decides only once it holds the whole map again.
#[test]
fn nobody_decides_on_a_map_with_a_gap() {
    let mut pilot = pilot(false);
    pilot.on(Event::State(state(3, 0, Incarnation(0))), at(0));
    let request = |from| {
        let request = MapRequest { run: RUN, robot: RobotId(0), from, observation: 0 };
        [Effect::RequestMap(request)]
    };
    assert_eq!(pilot.on(Event::Tick, at(0)), request(0), "who has just come asks");
    let cell = SeenCell { index: 30, visits: 0, ground: Ground::FLAT };
    let after = ObservedMap::unseen(RUN, RobotId(0), brief().grid).step(30, &cell.ground, 0);
    let missed = MapPatch { sequence: 1, after, cells: vec![cell], ..map(2) };
    let next = MapPatch { sequence: 2, before: after, after, ..map(3) };
    assert_eq!(pilot.on(Event::Patch(next.clone()), at(1)), [], "asked for already");
    assert_eq!(pilot.on(Event::Tick, at(ASK_AGAIN_NS)), request(0), "the request is repeated");
    assert!(pilot.situation().is_none() && pilot.waits_for().is_some());
    let page = MapPage {
        run: RUN,
        robot: RobotId(0),
        through: missed.through,
        digest: missed.digest,
        sequence: missed.sequence,
        observation: missed.after,
        sensed: at(0),
        published: at(0),
        grid: brief().grid,
        from: 0,
        next: 400,
        treasures: Vec::new(),
        cells: missed.cells.clone(),
    };
    assert_eq!(pilot.on(Event::Page(page), at(ASK_AGAIN_NS + 1)), [Effect::Plan], "the rest was buffered");
    let situation = pilot.situation().unwrap();
    assert_eq!((situation.map.seen_cells(), situation.map.observation()), (1, after));
}

/// P-WHOLE. A plan that was given up because its map was lost is requested again.
#[test]
fn a_plan_whose_map_went_before_it_was_begun_is_asked_for_again() {
    let mut pilot = pilot(false);
    pilot.on(Event::State(state(3, 0, Incarnation(0))), at(0));
    assert_eq!(pilot.on(Event::Patch(map(3)), at(0)), [Effect::Plan]);
    let request = MapRequest { run: RUN, robot: RobotId(0), from: 0, observation: 0 };
    let gap = MapPatch { sequence: 7, before: 1, after: 1, ..map(3) };
    assert_eq!(pilot.on(Event::Patch(gap), at(1)), [Effect::RequestMap(request)]);
    assert!(pilot.situation().is_none(), "nobody can plan now");
    assert_eq!(
        pilot.on(Event::Patch(MapPatch { published: at(2), ..map(3) }), at(2)),
        [Effect::Plan],
        "a reminder: the map is whole after all"
    );
}

/// One turn of a work loop may hear so much that a plan is asked for twice.
#[test]
fn a_plan_asked_for_twice_is_made_once() {
    let mut pilot = pilot(false);
    pilot.on(Event::State(state(0, 1, ME)), at(0));
    let mut asked = pilot.on(Event::Patch(map(0)), at(0));
    asked.extend(pilot.on(Event::State(state(1, 1, ME)), at(0)));
    asked.extend(pilot.on(Event::Patch(map(1)), at(0)));
    assert_eq!(asked, [Effect::Plan, Effect::Plan]);
    let mut made = 0;
    for _ in asked {
        if pilot.awaits_plan() {
            assert_eq!(sent(&pilot.on(planned(), at(2))), [(1, 1)]);
            made += 1;
        }
    }
    assert_eq!(made, 1);
}

#[test]
fn a_map_that_comes_before_its_state_is_kept() {
    let mut pilot = pilot(false);
    assert_eq!(pilot.on(Event::Patch(map(1)), at(0)), []);
    assert_eq!(pilot.on(Event::State(state(1, 0, Incarnation(0))), at(0)), [Effect::Plan]);
}

#[test]
fn a_brief_that_comes_after_its_state_is_planned_for() {
    let mut pilot = uninformed(false);
    assert_eq!(pilot.on(Event::State(state(1, 0, Incarnation(0))), at(0)), []);
    assert_eq!(pilot.on(Event::Brief(brief()), at(0)), []);
    assert_eq!(pilot.on(Event::Patch(map(1)), at(0)), [Effect::Plan]);
}

#[test]
fn of_goals_visited_in_turn_the_one_in_force_is_planned_for() {
    let goals = [Cell::new(4, 4), Cell::new(9, 2)];
    let visit = Goal::Visit(Visit::new(&goals, 9).unwrap());
    let mut brief = brief();
    brief.robots[0].goal = visit;
    let mut pilot = uninformed(false);
    pilot.on(Event::Brief(brief), at(0));
    for visits in 0..3 {
        pilot.on(Event::State(State { visits, ..state(visits, 1, ME) }), at(0));
        pilot.on(Event::Patch(map(visits)), at(0));
        assert_eq!(pilot.situation().unwrap().leg().goal, goals[visits as usize % 2], "{visits} visits");
    }
}

#[test]
fn where_robots_have_routes_nobody_plans_before_the_prior_and_all_routes_are_known() {
    let sampling = Sampling { seed: 1, rover_samples: 1, helicopter_samples: 1, stages: 1 };
    let start = Waypoint { x_m: 1.5, y_m: 2.5 };
    let route = Route::new(vec![start, Waypoint { x_m: 4.5, ..start }]).unwrap();
    let robot = Robot {
        body: Body::Driver(Driver {}),
        sensor: Sensor::Track(Track {}),
        start_at: start,
        goal: Goal::Reach(Reach { at: start, radius_m: 1.0 }),
        ..brief().robots[0]
    };
    let robots = Robots::new(&[robot; 2]).unwrap();
    let brief = Brief { robots, account: Account::Actions, sampling: Some(sampling), ..brief() };
    let member = |route| {
        let travel = Some(Travel { route, ..Travel::from_start(start) });
        Member { travel, ..Member::at_start(&robot) }
    };
    let team = Team {
        run: RUN,
        decision: Decision(3),
        digest: Digest::default(),
        due: RobotId(0),
        actor: None,
        members: [member(None), member(Some(route.id()))].into(),
    };
    let mut pilot = uninformed(false);
    let prior = PriorRequest { run: RUN, from: 0 };
    assert_eq!(pilot.on(Event::Brief(brief.clone()), at(0)), [Effect::RequestPrior(prior)]);
    pilot.on(Event::State(state(3, 0, Incarnation(0))), at(0));
    pilot.on(Event::Patch(map(3)), at(0));
    let asked = Effect::RequestRoute(RouteRequest { run: RUN, id: route.id() });
    assert_eq!(pilot.on(Event::Team(team), at(0)), [asked]);
    let speeds = SpeedPrior::new([0.0, 0.0, 0.0, 1.0]).unwrap();
    let cells = vec![PriorCell { speeds, height_m: 0.0 }; brief.grid.cells()];
    let page = PriorPage { run: RUN, grid: brief.grid, from: 0, cells };
    assert_eq!(pilot.on(Event::Prior(page), at(0)), [], "the other robot's route is not known");
    assert!(pilot.waits_for().is_some_and(|what| what.contains("routes")));
    assert_eq!(pilot.on(Event::Route(RoutePage { run: RUN, route }), at(0)), [Effect::Plan]);
    assert!(pilot.situation().unwrap().scouting.is_some());
}

/// P-TABLE-WHOLE: A planner plans no hop before it holds the whole motion table that the brief names, and says that it waits.
#[test]
fn a_planner_waits_for_the_whole_motion_table() {
    let sure = MotionRow::new(&[TableLanding { forward: 1, left: 0, probability: 1.0 }]).unwrap();
    let table = MotionTable::new(vec![sure; MotionTable::ROWS]).unwrap();
    let mut brief = brief();
    for robot in brief.robots.iter_mut() {
        if let contract::Body::Hopper(hopper) = &mut robot.body {
            hopper.motion.table = table.fingerprint();
        }
    }
    let mut pilot = uninformed(false);
    let ask = |from| Effect::RequestTable(TableRequest { run: RUN, from });
    assert_eq!(pilot.on(Event::Brief(brief), at(0)), [ask(0)]);
    pilot.on(Event::State(state(3, 0, Incarnation(0))), at(0));
    assert_eq!(pilot.on(Event::Patch(map(3)), at(0)), []);
    assert_eq!(pilot.waits_for(), Some("hopper-sim: the motion table"));
    let page = |from: usize, row| {
        let rows = vec![row; MotionTable::ROWS - from];
        Event::Table(TablePage { run: RUN, from: from as u32, rows })
    };
    assert_eq!(pilot.on(page(0, MotionRow::default()), at(0)), [ask(0)], "another table");
    assert_eq!(pilot.map().refusals().of("malformed"), 1);
    let begins = TablePage { run: RUN, from: 0, rows: vec![sure; 1000] };
    assert_eq!(pilot.on(Event::Table(begins), at(0)), [ask(1000)]);
    assert!(pilot.situation().is_none());
    assert_eq!(pilot.on(page(1000, sure), at(0)), [Effect::Plan]);
    assert_eq!(pilot.situation().unwrap().table, Some(&table));
    assert_eq!(pilot.waits_for(), None);
}

#[test]
fn a_command_says_whether_its_plan_was_cut_short() {
    for (status, cut) in [(PlanStatus::Solved, false), (PlanStatus::Cut, true)] {
        let mut pilot = pilot(false);
        pilot.on(Event::State(state(0, 1, ME)), at(0));
        pilot.on(Event::Patch(map(0)), at(0));
        let plan = Plan { action: Action::Hold, status, work: 3, error_bound: 0.0 };
        let effects = pilot.on(Event::Planned(plan, at(1), at(2)), at(2));
        assert!(matches!(effects[..], [Effect::Send(command)] if command.cut == cut), "{effects:?}");
    }
}

#[test]
fn a_map_of_another_run_is_not_planned_on() {
    let mut pilot = pilot(false);
    pilot.on(Event::State(state(0, 0, Incarnation(0))), at(0));
    let foreign = MapPatch { run: RunId(8), ..map(0) };
    assert_eq!(pilot.on(Event::Patch(foreign), at(0)), []);
}

#[test]
fn the_leader_repeats_its_command_until_the_state_moves_on() {
    let mut pilot = pilot(false);
    pilot.on(Event::State(state(0, 4, ME)), at(0));
    pilot.on(Event::Patch(map(0)), at(0));
    assert_eq!(sent(&pilot.on(planned(), at(0))), [(0, 4)]);
    assert_eq!(sent(&pilot.on(Event::Tick, at(RESEND_NS - 1))), []);
    assert_eq!(sent(&pilot.on(Event::Tick, at(RESEND_NS))), [(0, 4)]);
    assert_eq!(sent(&pilot.on(Event::Tick, at(2 * RESEND_NS))), [(0, 4)]);
    pilot.on(Event::State(state(1, 4, ME)), at(2 * RESEND_NS));
    assert_eq!(sent(&pilot.on(Event::Tick, at(9 * RESEND_NS))), [], "the old command is never sent again");
}

#[test]
fn a_stand_by_stays_silent_while_the_leader_beats() {
    let mut pilot = pilot(false);
    pilot.on(Event::State(state(0, 4, OTHER)), at(0));
    pilot.on(Event::Patch(map(0)), at(0));
    for beats in 1..20 {
        let now = at(beats * SILENCE_NS / 2);
        assert_eq!(pilot.on(beat(OTHER, beats), now), []);
        assert_eq!(pilot.on(Event::Tick, now), []);
    }
}

#[test]
fn a_stand_by_takes_the_next_term_when_the_leaders_heartbeat_stands_still() {
    let mut pilot = pilot(false);
    pilot.on(Event::State(state(0, 4, OTHER)), at(0));
    pilot.on(Event::Patch(map(0)), at(0));
    pilot.on(beat(OTHER, 1), at(0));
    pilot.on(beat(OTHER, 1), at(SILENCE_NS));
    assert_eq!(pilot.on(Event::Tick, at(SILENCE_NS / 2)), []);
    assert_eq!(pilot.on(Event::Tick, at(SILENCE_NS)), []);
    assert_eq!(pilot.on(Event::Tick, at(SILENCE_NS + 1)), [Effect::Plan]);
    assert_eq!(sent(&pilot.on(planned(), at(SILENCE_NS + 1))), [(0, 5)]);
    let effects = pilot.on(Event::State(state(1, 5, ME)), at(SILENCE_NS + 2));
    assert_eq!(effects, [Effect::Leads(Term(5))]);
}

/// Two robots at decision 3, which is the second's, both led by another planner, and a pilot of the second alone.
fn two_robots() -> (Brief, Team, Pilot) {
    let robot = brief().robots[0];
    let brief = Brief { robots: Robots::new(&[robot; 2]).unwrap(), ..brief() };
    let State { leader, digest, .. } = state(3, 4, OTHER);
    let member = Member { leader, ..Member::at_start(&robot) };
    let (decision, due) = (Decision(3), RobotId(1));
    let team = Team { run: RUN, decision, digest, due, actor: None, members: [member; 2].into() };
    let robots = contract::RobotSet(0).with(due);
    (brief, team, Pilot::new(PilotConfig { robots, ..config(false) }))
}

/// P-STANDBY-TIME: A leader's silence is counted from the moment at which a planner knows who
/// leads, in whatever order brief, state and robots arrive.
#[test]
fn a_leader_that_is_told_before_the_brief_is_given_time_to_be_heard() {
    let (brief, team, mut pilot) = two_robots();
    let leader = team.members[1].leader;
    let now = at(9 * SILENCE_NS);
    for tick in 0..=36 {
        assert_eq!(pilot.on(Event::Tick, at(tick * SILENCE_NS / 4)), []);
    }
    for event in [Event::State(state(3, 4, OTHER)), Event::Team(team), Event::Patch(map(3))] {
        assert_eq!(pilot.on(event, now), []);
    }
    assert_eq!(pilot.on(Event::Brief(brief), now), [Effect::StandsBy(leader)]);
    assert_eq!(pilot.on(Event::Patch(map(3)), now), []);
    assert_eq!(pilot.on(Event::Tick, at(now.0 + SILENCE_NS / 2)), []);
    assert_eq!(pilot.on(Event::Tick, at(now.0 + SILENCE_NS)), []);
    assert_eq!(pilot.on(Event::Tick, at(now.0 + SILENCE_NS + 1)), [Effect::Plan]);
}

#[test]
fn a_leader_whose_process_is_gone_is_waited_for_less() {
    let mut pilot = pilot(false);
    let leader = state(0, 4, OTHER).leader;
    assert_eq!(pilot.on(Event::State(state(0, 4, OTHER)), at(0)), [Effect::StandsBy(leader)]);
    pilot.on(Event::Patch(map(0)), at(0));
    assert_eq!(pilot.rival_pid(), Some(leader.pid));
    assert_eq!(pilot.on(Event::Gone(leader.pid), at(DEATH_SILENCE_NS)), []);
    pilot.on(beat(OTHER, 1), at(DEATH_SILENCE_NS));
    assert_eq!(pilot.on(Event::Tick, at(2 * DEATH_SILENCE_NS)), [], "it beats: it lives elsewhere");
    assert_eq!(pilot.on(Event::Tick, at(2 * DEATH_SILENCE_NS + 1)), [Effect::Plan]);
}

#[test]
fn a_stand_by_that_was_stopped_itself_gives_the_leader_time_to_be_heard() {
    for awake in [SILENCE_NS + 2, 20 * SILENCE_NS] {
        let mut pilot = pilot(false);
        pilot.on(Event::State(state(0, 4, OTHER)), at(0));
        pilot.on(Event::Patch(map(0)), at(0));
        pilot.on(Event::Tick, at(1));
        assert_eq!(pilot.on(Event::Tick, at(awake)), []);
        pilot.on(beat(OTHER, 9), at(awake + 1));
        assert_eq!(pilot.on(Event::Tick, at(awake + SILENCE_NS / 2)), []);
    }
}

/// P-TAKEOVER-ONCE.
#[test]
fn a_takeover_fires_once() {
    let mut pilot = pilot(true);
    pilot.on(Event::State(state(0, 4, OTHER)), at(0));
    assert_eq!(pilot.on(Event::Patch(map(0)), at(0)), [Effect::Plan]);
    assert_eq!(sent(&pilot.on(planned(), at(0))), [(0, 5)]);
    // The rival was faster with decision 0: the next is tried for.
    pilot.on(Event::State(state(1, 4, OTHER)), at(0));
    assert_eq!(pilot.on(Event::Patch(map(1)), at(0)), [Effect::Plan]);
    assert_eq!(sent(&pilot.on(planned(), at(0))), [(1, 5)]);
    assert_eq!(pilot.on(Event::State(state(2, 5, ME)), at(0)), [Effect::Leads(Term(5))]);
    // Deposed: it stands by, its right is spent.
    assert_eq!(pilot.on(Event::State(state(3, 6, OTHER)), at(0)), [Effect::StepsBack(Term(6))]);
    assert_eq!(pilot.on(Event::Patch(map(3)), at(0)), []);
    assert_eq!(pilot.on(Event::Tick, at(0)), []);
}

#[test]
fn a_takeover_whose_term_another_was_given_is_tried_in_the_next() {
    let mut pilot = pilot(true);
    pilot.on(Event::State(state(0, 4, OTHER)), at(0));
    pilot.on(Event::Patch(map(0)), at(0));
    assert_eq!(sent(&pilot.on(planned(), at(0))), [(0, 5)]);
    pilot.on(Event::State(state(1, 5, Incarnation(3))), at(0));
    assert_eq!(pilot.on(Event::Patch(map(1)), at(0)), [Effect::Plan]);
    assert_eq!(sent(&pilot.on(planned(), at(0))), [(1, 6)]);
}

#[test]
fn what_heartbeats_say_is_of_the_run_of_the_brief_and_a_rival_is_who_commands_in_its_place() {
    let mut pilot = pilot(false);
    let nothing = (RunId::default(), Decision(0), Status::Underway);
    assert_eq!((pilot.known_brief(), pilot.seen(), pilot.rival_pid()), (Some(&brief()), nothing, None));
    pilot.on(Event::State(state(3, 0, Incarnation(0))), at(0));
    assert_eq!(
        (pilot.seen(), pilot.rival_pid()),
        ((RUN, Decision(3), Status::Underway), None),
        "nobody commands"
    );
    pilot.on(Event::State(state(4, 1, OTHER)), at(0));
    assert_eq!((pilot.seen().1, pilot.rival_pid()), (Decision(4), Some(12)));
    pilot.on(Event::State(state(5, 2, ME)), at(0));
    assert_eq!((pilot.seen().1, pilot.rival_pid()), (Decision(5), None));
    pilot.on(Event::Brief(Brief { run: RunId(8), ..brief() }), at(0));
    assert_eq!(pilot.seen(), nothing, "the state is of another run");
}

/// P-HAND-OVER: A stand-by planner that is ordered to take over takes the next term of each robot
/// that it serves, once per order.
#[test]
fn a_stand_by_that_is_told_to_takes_over_once() {
    let mut pilot = pilot(false);
    pilot.on(Event::State(state(0, 4, OTHER)), at(0));
    assert_eq!(pilot.on(Event::Patch(map(0)), at(0)), [], "it stands by");
    assert_eq!(pilot.on(Event::HandOver, at(0)), [Effect::Plan]);
    assert_eq!(sent(&pilot.on(planned(), at(0))), [(0, 5)]);
    assert_eq!(pilot.on(Event::State(state(1, 5, ME)), at(0)), [Effect::Leads(Term(5))]);
    assert_eq!(pilot.on(Event::HandOver, at(0)), [], "it leads already");
    assert_eq!(pilot.on(Event::State(state(2, 6, OTHER)), at(0)), [Effect::StepsBack(Term(6))]);
    assert_eq!(pilot.on(Event::Patch(map(2)), at(0)), [], "what was told fires once");
    assert_eq!(pilot.on(Event::HandOver, at(0)), [Effect::Plan]);
    assert_eq!(sent(&pilot.on(planned(), at(0))), [(2, 7)]);
}

/// P-HAND-OVER. The order names a planner, which takes over the robots that it serves, whichever
/// they are.
#[test]
fn a_stand_by_takes_over_the_robots_that_it_serves() {
    let (brief, team, mut pilot) = two_robots();
    for event in [Event::Brief(brief), Event::State(state(3, 4, OTHER)), Event::Team(team)] {
        pilot.on(event, at(0));
    }
    assert_eq!(pilot.on(Event::Patch(map(3)), at(0)), [], "it stands by");
    assert_eq!(pilot.on(Event::HandOver, at(0)), [Effect::Plan]);
}

/// P-TAKEOVER-ONCE.
#[test]
fn a_takeover_that_may_have_fired_unseen_does_not_fire_again() {
    let mut pilot = pilot(true);
    pilot.on(Event::State(state(0, 4, OTHER)), at(0));
    pilot.on(Event::Patch(map(0)), at(0));
    assert_eq!(sent(&pilot.on(planned(), at(0))), [(0, 5)]);
    // The state in which it led, term 5, was overtaken by the next: another has deposed it.
    let deposed = pilot.on(Event::State(state(2, 6, OTHER)), at(0));
    assert!(matches!(deposed[..], [Effect::StandsBy(_)]), "{deposed:?}");
    assert_eq!(pilot.on(Event::Patch(map(2)), at(0)), []);
    assert_eq!(pilot.on(Event::Tick, at(0)), []);
}

#[test]
fn a_planner_woken_after_its_term_passed_steps_back_and_sends_nothing() {
    let mut pilot = pilot(false);
    pilot.on(Event::State(state(0, 1, ME)), at(0));
    pilot.on(Event::Patch(map(0)), at(0));
    pilot.on(planned(), at(0));
    let awake = at(10 * SILENCE_NS);
    pilot.on(beat(OTHER, 5), awake);
    assert_eq!(pilot.on(Event::State(state(4, 2, OTHER)), awake), [Effect::StepsBack(Term(2))]);
    assert_eq!(pilot.on(Event::Patch(map(4)), awake), []);
    assert_eq!(pilot.on(Event::Tick, awake), []);
}

#[test]
fn the_successor_of_a_dead_process_takes_its_term_at_once_but_nobody_elses() {
    let config = PilotConfig {
        robots: contract::RobotSet::default(),
        incarnation: ME,
        pid: 11,
        planner: name("mdp"),
        takeover: false,
        succeeds_pid: Some(12),
    };
    let mut pilot = Pilot::new(config);
    pilot.on(Event::Brief(brief()), at(0));
    pilot.on(Event::State(state(0, 4, OTHER)), at(0));
    assert_eq!(pilot.on(Event::Patch(map(0)), at(0)), [Effect::Plan], "pid 12 led, and is dead");
    pilot.on(Event::State(state(1, 5, Incarnation(3))), at(0));
    assert_eq!(pilot.on(Event::Patch(map(1)), at(0)), [], "a third planner was faster");
}

#[test]
fn a_plan_for_a_decision_that_has_passed_is_dropped() {
    let mut pilot = pilot(false);
    pilot.on(Event::State(state(0, 1, ME)), at(0));
    assert_eq!(pilot.on(Event::Patch(map(0)), at(0)), [Effect::Plan]);
    pilot.on(Event::State(state(1, 1, ME)), at(0));
    assert_eq!(pilot.on(planned(), at(0)), []);
    assert_eq!(pilot.on(Event::Patch(map(1)), at(0)), [Effect::Plan]);
}

#[test]
fn a_new_run_is_started_from_nothing_and_the_end_is_reported_once() {
    let mut pilot = pilot(false);
    let end = State { status: Status::Goal, ..state(5, 1, ME) };
    assert_eq!(pilot.on(Event::State(end), at(0)), [Effect::Leads(Term(1)), Effect::Finished(Status::Goal)]);
    assert_eq!(pilot.on(Event::State(end), at(0)), []);
    let next = Brief { run: RunId(8), ..brief() };
    pilot.on(Event::Brief(next.clone()), at(0));
    assert!(pilot.waits_for().is_some());
    let fresh = State { run: RunId(8), ..state(0, 0, Incarnation(0)) };
    pilot.on(Event::State(fresh), at(0));
    let map = MapPatch { run: RunId(8), ..map(0) };
    assert_eq!(pilot.on(Event::Patch(map), at(0)), [Effect::Plan]);
    pilot.on(Event::Brief(next.clone()), at(0));
    let end = State { run: RunId(8), ..end };
    assert_eq!(pilot.on(Event::State(end), at(0)), [Effect::Leads(Term(1)), Effect::Finished(Status::Goal)]);
    pilot.on(Event::Brief(next), at(0));
    assert_eq!(pilot.on(Event::State(end), at(0)), [], "the same brief again begins nothing");
}

/// What was sent: decision, action.
fn actions(effects: &[Effect]) -> Vec<(u64, Action)> {
    let sent = |effect: &Effect| match effect {
        Effect::Send(Command { decision, action, .. }) => Some((decision.0, *action)),
        _ => None,
    };
    effects.iter().filter_map(sent).collect()
}

fn planned_as(action: Action) -> Event {
    Event::Planned(Plan { action, status: PlanStatus::Solved, work: 3, error_bound: 0.0 }, at(1), at(2))
}

/// P-VETO-TOLD: A planner whose command is vetoed plans again, and never sends that command again.
#[test]
fn a_vetoed_command_is_planned_anew_and_never_sent_again() {
    let (north, east) = (Action::Hop(Direction::North), Action::Hop(Direction::East));
    let told = |vetoed| Event::State(State { vetoed, ..state(3, 1, ME) });
    let north_vetoed = contract::Vetoed::NONE.with(north);
    let mut pilot = pilot(false);
    pilot.on(told(contract::Vetoed::NONE), at(0));
    assert_eq!(pilot.on(Event::Patch(map(3)), at(0)), [Effect::Plan]);
    assert_eq!(actions(&pilot.on(planned_as(north), at(0))), [(3, north)]);
    assert_eq!(pilot.on(told(north_vetoed), at(1)), [Effect::Plan]);
    assert!(pilot.situation().unwrap().state.vetoed.has(north), "the planner is told");
    assert_eq!(pilot.on(Event::Tick, at(2 * RESEND_NS)), [], "the old command is not repeated");
    assert_eq!(actions(&pilot.on(planned_as(east), at(2 * RESEND_NS))), [(3, east)]);
    assert_eq!(
        pilot.on(told(contract::Vetoed::NONE), at(2 * RESEND_NS)),
        [],
        "an older copy changes nothing"
    );
    assert_eq!(actions(&pilot.on(Event::Tick, at(4 * RESEND_NS))), [(3, east)]);
    // A plan that was under way when the veto came is dropped; one that insists becomes a hold.
    let both = north_vetoed.with(east);
    assert_eq!(pilot.on(told(both), at(5 * RESEND_NS)), [Effect::Plan]);
    assert_eq!(actions(&pilot.on(planned_as(east), at(5 * RESEND_NS))), [(3, Action::Hold)]);
}

#[test]
fn a_plan_that_was_under_way_when_a_veto_came_is_dropped() {
    let north = Action::Hop(Direction::North);
    let mut pilot = pilot(false);
    pilot.on(Event::State(state(3, 1, ME)), at(0));
    assert_eq!(pilot.on(Event::Patch(map(3)), at(0)), [Effect::Plan]);
    let vetoed = contract::Vetoed::NONE.with(north);
    assert_eq!(pilot.on(Event::State(State { vetoed, ..state(3, 1, ME) }), at(0)), [Effect::Plan]);
    assert_eq!(
        actions(&pilot.on(planned_as(north), at(1))),
        [(3, Action::Hold)],
        "it answers the newer request"
    );
    assert_eq!(pilot.on(planned_as(north), at(1)), [], "and nothing else");
}

/// P-TIMELINE. The same decision on another timeline is planned again, on a map that is requested
/// again.
#[test]
fn a_plan_for_the_same_decision_of_another_past_is_not_sent() {
    let mut pilot = pilot(false);
    pilot.on(Event::State(state(3, 0, Incarnation(0))), at(0));
    pilot.on(Event::Patch(map(3)), at(0));
    assert_eq!(sent(&pilot.on(planned(), at(2))), [(3, 1)]);
    let elsewhere = State { digest: Digest([9; 32]), published: at(5), ..state(3, 0, Incarnation(0)) };
    pilot.on(Event::State(elsewhere), at(6));
    assert!(pilot.situation().is_none(), "its map may hold cells seen on hops that never were");
    assert_eq!(sent(&pilot.on(Event::Tick, at(2 + RESEND_NS))), []);
    let known = State { published: at(5), ..state(3, 0, Incarnation(0)) };
    pilot.on(Event::State(known), at(7));
    pilot.on(Event::Patch(map(3)), at(7));
    assert!(pilot.situation().is_none(), "the same cells, but the map of the past that is gone");
    let right = MapPatch { digest: Digest([9; 32]), ..map(3) };
    assert_eq!(pilot.on(Event::Patch(right), at(8)), [Effect::Plan], "the older state changes nothing");
    assert_eq!(pilot.situation().unwrap().state.digest, Digest([9; 32]));
    let effects = pilot.on(planned(), at(9));
    let answered = effects.iter().find_map(|effect| match effect {
        Effect::Send(command) => Some(command.digest),
        _ => None,
    });
    assert_eq!(answered, Some(Digest([9; 32])), "the command names the past it was planned on");
}

/// P-PAST-NAMED: Planners see only what follows from the past that a command names by its digest:
/// not who commands, who chose the last action, when something happened, or which other routes are
/// known. So a plan for a past that was lost and flown again is also the plan for the new past.
#[test]
fn a_planner_sees_nothing_that_the_digest_does_not_tell() {
    let seen = |state: State| {
        let mut pilot = pilot(false);
        pilot.on(Event::State(state), at(1));
        pilot.on(Event::Patch(map(3)), at(2));
        *pilot.situation().unwrap().state
    };
    let plain = state(3, 0, Incarnation::default());
    let plain = State { leader: Leader::default(), ..plain };
    let told = State {
        leader: state(3, 9, OTHER).leader,
        last_origin: contract::Origin::Greedy,
        last_vetoed: contract::Vetoed::NONE.with(Action::Hop(Direction::North)),
        landed: at(7),
        published: at(8),
        last_timing: Timing { accepted: at(5), ..Timing::default() },
        ..plain
    };
    assert_eq!(seen(told), seen(plain));
    let of_the_past = [
        State { visits: 1, ..plain },
        State { steps: 2, ..plain },
        State { vetoed: contract::Vetoed::NONE.with(Action::Hop(Direction::North)), ..plain },
    ];
    for state in of_the_past {
        assert_ne!(seen(state), seen(plain));
    }
}
