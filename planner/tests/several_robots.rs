//! A pilot that serves several robots: each under a term of its own, and none forgotten.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use contract::protocol::peer_table::SILENCE_NS;
use contract::{
    Action, Brief, Cell, Collected, Command, Decision, Digest, Direction, Incarnation, Leader, MapPatch,
    Member, MonotonicNs, Name, Origin, Pose, RobotId, RobotSet, Robots, RunId, State, Status, Team, Term,
    Timing, Vetoed,
};
use planner::pilot::{Effect, Event, Pilot, PilotConfig};
use planner::{Plan, PlanStatus};

const RUN: RunId = RunId(7);
const ME: Incarnation = Incarnation(1);
const OTHER: Incarnation = Incarnation(2);
const ROBOTS: u16 = 3;

fn name(text: &str) -> Name {
    text.parse().unwrap()
}

fn brief() -> Brief {
    let alone = scenario::load("hard").unwrap().resolve().unwrap().brief;
    let robots = Robots::new(&[alone.robots[0]; ROBOTS as usize]).unwrap();
    Brief { run: RUN, robots, ..alone }
}

fn leader(term: u64, of: Incarnation) -> Leader {
    Leader { term: Term(term), incarnation: of, pid: of.0 as u32 + 10, planner: name("mdp") }
}

/// A pilot of all robots, with those who lead them.
struct Fleet {
    pilot: Pilot,
    leaders: [Leader; ROBOTS as usize],
    decision: u64,
    now: MonotonicNs,
}

impl Fleet {
    fn new(takeover: bool, succeeds_pid: Option<u32>, leaders: [Leader; ROBOTS as usize]) -> Self {
        let robots = RobotSet::first(ROBOTS);
        let planner = name("mdp");
        let config = PilotConfig { robots, incarnation: ME, pid: 11, planner, takeover, succeeds_pid };
        let mut pilot = Pilot::new(config);
        assert_eq!(pilot.on(Event::Brief(brief()), MonotonicNs(0)), []);
        Self { pilot, leaders, decision: 0, now: MonotonicNs(0) }
    }

    /// The next decision is the turn of `due`; the terms under which the pilot commands it, with its number.
    fn turn(&mut self, due: u16) -> Vec<(u16, u64)> {
        self.decision += 1;
        let (decision, due) = (Decision(self.decision), RobotId(due));
        let robot = brief().robots[0];
        let member = |leader: &Leader| Member { leader: *leader, ..Member::at_start(&robot) };
        let members = self.leaders.iter().map(member).collect();
        let team = Team { run: RUN, decision, digest: Digest::default(), due, actor: None, members };
        self.pilot.on(Event::State(state(decision)), self.now);
        self.pilot.on(Event::Team(team), self.now);
        self.pilot.on(Event::Patch(map(decision)), self.now);
        self.commands()
    }

    /// What the pilot commands now, once its plan is there.
    fn commands(&mut self) -> Vec<(u16, u64)> {
        let action = Action::Hop(Direction::North);
        let plan = Plan { action, status: PlanStatus::Solved, work: 3, error_bound: 0.0 };
        let effects = self.pilot.on(Event::Planned(plan, self.now, self.now), self.now);
        let sent = effects.into_iter().filter_map(|effect| match effect {
            Effect::Send(Command { robot, term, .. }) => Some((robot.0, term.0)),
            _ => None,
        });
        sent.collect()
    }

    /// The command of that robot was accepted.
    fn leads(&mut self, robot: u16, term: u64) {
        self.leaders[usize::from(robot)] = leader(term, ME);
    }
}

fn state(decision: Decision) -> State {
    State {
        run: RUN,
        robot: RobotId(0),
        decision,
        steps: 0,
        status: Status::Underway,
        leader: Leader::default(),
        pose: Pose { cell: Cell::new(1, 2), height_m: 0.0 },
        collected: Collected::default(),
        last: None,
        previous: Digest::default(),
        digest: Digest::default(),
        landed: MonotonicNs(0),
        published: MonotonicNs(0),
        visits: 0,
        vetoed: Vetoed::NONE,
        last_origin: Origin::Planner,
        last_vetoed: Vetoed::NONE,
        last_timing: Timing::default(),
    }
}

/// A landing that revealed nothing.
fn map(through: Decision) -> MapPatch {
    MapPatch {
        run: RUN,
        robot: RobotId(0),
        through,
        digest: Digest::default(),
        more: 0,
        sequence: 0,
        before: 0,
        after: 0,
        sensed: MonotonicNs(0),
        published: MonotonicNs(0),
        grid: brief().grid,
        seen_cells: 0,
        treasures: Vec::new(),
        cells: Vec::new(),
    }
}

/// P-HAND-OVER-EACH: A planner that takes over several robots claims each of them once per order,
/// whichever turn comes first, and keeps those that it leads. A successor of a dead or silent
/// planner claims that planner's robots and no others.
#[test]
fn who_is_told_to_take_over_claims_each_robot_that_it_serves_once() {
    let others = [leader(4, OTHER), leader(9, OTHER), leader(2, Incarnation(3))];
    for (first, second, third) in [(0, 1, 2), (2, 1, 0), (1, 0, 2), (1, 2, 0)] {
        for told_at_start in [true, false] {
            let mut fleet = Fleet::new(told_at_start, None, others);
            if !told_at_start {
                assert_eq!(fleet.turn(first), [], "it stands by");
                fleet.pilot.on(Event::HandOver, fleet.now);
                assert_eq!(fleet.commands(), [(first, others[usize::from(first)].term.0 + 1)]);
            }
            for robot in [first, second, third] {
                let term = others[usize::from(robot)].term.0 + 1;
                // It may be too late: then it is tried again when that robot's turn comes next.
                assert_eq!(fleet.turn(robot), [(robot, term)], "{first}, {second}, {third}");
                assert_eq!(fleet.turn(robot), [(robot, term)], "{first}, {second}, {third}");
                fleet.leads(robot, term);
                assert_eq!(fleet.turn(robot), [(robot, term)], "it leads");
            }
            // Deposed everywhere, its right is spent everywhere.
            fleet.leaders = others.map(|held| leader(held.term.0 + 2, OTHER));
            for robot in [third, first, second] {
                assert_eq!(fleet.turn(robot), [], "what was told fires once");
            }
            fleet.pilot.on(Event::HandOver, fleet.now);
            assert_eq!(fleet.commands(), [(second, others[usize::from(second)].term.0 + 3)], "told again");
            assert_eq!(fleet.turn(first), [(first, others[usize::from(first)].term.0 + 3)]);
            assert_eq!(fleet.turn(third), [(third, others[usize::from(third)].term.0 + 3)]);
        }
    }
}

/// P-HAND-OVER-EACH. A planner that already leads some of the robots claims the others.
#[test]
fn who_leads_one_robot_and_is_told_to_take_over_claims_the_others() {
    let mut fleet = Fleet::new(false, None, [leader(4, OTHER), leader(9, ME), leader(2, OTHER)]);
    assert_eq!(fleet.turn(1), [(1, 9)], "it goes on");
    assert_eq!(fleet.turn(0), [], "it stands by");
    assert_eq!(fleet.turn(1), [(1, 9)]);
    fleet.pilot.on(Event::HandOver, fleet.now);
    assert_eq!(fleet.turn(2), [(2, 3)]);
    assert_eq!(fleet.turn(1), [(1, 9)], "what it leads it leads on");
    assert_eq!(fleet.turn(0), [(0, 5)]);
}

/// P-HAND-OVER-EACH. The successor of a dead process takes all robots that it led, and none that
/// another leads.
#[test]
fn the_successor_of_a_dead_process_takes_each_robot_that_it_led() {
    let dead = leader(4, OTHER);
    let leaders = [dead, leader(9, Incarnation(3)), Leader { term: Term(6), ..dead }];
    let mut fleet = Fleet::new(false, Some(dead.pid), leaders);
    assert_eq!(fleet.turn(2), [(2, 7)]);
    assert_eq!(fleet.turn(1), [], "its leader lives");
    assert_eq!(fleet.turn(0), [(0, 5)]);
}

/// P-HAND-OVER-EACH. A silent leader loses all robots that it led, and only those.
#[test]
fn the_robots_of_a_silent_leader_are_taken_and_no_others() {
    let mut fleet = Fleet::new(false, None, [leader(4, OTHER), leader(9, Incarnation(3)), leader(2, OTHER)]);
    for robot in [0, 1, 2] {
        assert_eq!(fleet.turn(robot), []);
    }
    let step_ns = SILENCE_NS / 4;
    for counter in 1..=5 {
        fleet.now = MonotonicNs(counter * step_ns);
        let beat = contract::Heartbeat {
            role: contract::Role::Planner,
            incarnation: Incarnation(3),
            pid: 13,
            version: Name::NONE,
            planner: Name::NONE,
            robots: RobotSet::default(),
            counter,
            run: RUN,
            decision: Decision(0),
            status: Status::Underway,
        };
        fleet.pilot.on(Event::Heartbeat(beat), fleet.now);
        fleet.pilot.on(Event::Tick, fleet.now);
    }
    assert_eq!(fleet.turn(2), [(2, 3)]);
    assert_eq!(fleet.turn(1), [], "its leader beats");
    assert_eq!(fleet.turn(0), [(0, 5)]);
}

/// Nobody leads yet: each robot has its own first term.
#[test]
fn robots_that_nobody_leads_are_each_led_in_a_first_term() {
    let mut fleet = Fleet::new(false, None, [Leader::default(), leader(9, ME), Leader::default()]);
    assert_eq!(fleet.turn(2), [(2, 1)]);
    assert_eq!(fleet.turn(1), [(1, 9)]);
    assert_eq!(fleet.turn(0), [(0, 1)]);
}
