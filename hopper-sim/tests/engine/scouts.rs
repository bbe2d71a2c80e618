//! A rover on uncertain ground and a helicopter: what they may do, and what a journal keeps of it.

use std::sync::Arc;

use contract::{
    Action, Announcement, Branch, Command, Decision, DriveSpeed, ErringCamera, Incarnation, MonotonicNs,
    Pace, Refusal, RobotId, Route, RunId, Sensor, SpeedPrior, State, Status, Team, Term, Travel, Waypoint,
};
use hopper_sim::{
    Arbiter, Attachment, Effect, Event, Journal, JournalError, JournalHeader, Mission, RecordStore,
};
use scenario::{ResolvedScenario, Scenario};

use crate::fixture::command;

const ROVER: RobotId = RobotId(0);
const HELICOPTER: RobotId = RobotId(1);

fn world(more: &str) -> ResolvedScenario {
    world_in("", more)
}

fn world_in(sampling: &str, more: &str) -> ResolvedScenario {
    let text = format!(
        "[truth.terrain.passages]\nseed = 1\n[sampling]\n{sampling}\n[brief]\nprofile = \"hopper\"\n\
         [limits]\nsteps_max = 40\n[guard]\nhazard_max = 0.01\n{more}\n\
         [[robots]]\nbody = \"driver\"\n[[robots]]\nbody = \"helicopter\"\nspeed_mps = 5.0\n"
    );
    Scenario::parse(&text, "test").unwrap().resolve().unwrap()
}

fn mission(world: &ResolvedScenario) -> Mission {
    let brief = contract::Brief { run: RunId(1), ..world.brief.clone() };
    Mission { brief, ..Mission::of(world, 1) }
}

/// An arbiter whose appends always succeed, perhaps into a journal.
struct Host {
    arbiter: Arbiter,
    journal: Option<Journal>,
    refused: Vec<Refusal>,
}

impl Host {
    fn new(world: &ResolvedScenario, deadlines: bool) -> Self {
        let arbiter = Arbiter::new(mission(world), None, Pace::Max, 0, MonotonicNs(1));
        let arbiter = if deadlines { arbiter } else { arbiter.without_deadlines() };
        let mut host = Self { arbiter, journal: None, refused: Vec::new() };
        host.on(Event::Tick, 1);
        host
    }

    fn on(&mut self, event: Event, now: u64) {
        for effect in self.arbiter.on(event, MonotonicNs(now)) {
            match effect {
                Effect::Append(record) => {
                    let attachment = self.arbiter.attachment(&record);
                    if let Some(journal) = &mut self.journal {
                        journal.append(&record, attachment.as_ref()).unwrap();
                    }
                    self.on(Event::Appended, now);
                }
                Effect::Refused(refusal) => self.refused.push(refusal),
                _ => {}
            }
        }
    }

    fn state(&self) -> State {
        *self.arbiter.state()
    }

    fn team(&self) -> Team {
        self.arbiter.team().unwrap().clone()
    }

    fn waits(&self, robot: RobotId) -> bool {
        self.team().member(robot).unwrap().waits
    }

    fn travel(&self, robot: RobotId) -> Travel {
        self.team().member(robot).unwrap().travel.unwrap()
    }

    /// A command of the planner of the robot that is due.
    fn command(&self, action: Action) -> Command {
        let robot = self.team().due;
        let life = Incarnation(1 + u64::from(robot.0));
        Command { robot, incarnation: life, term: Term(1), ..command(&self.state(), action) }
    }

    /// Commands the robot that is due, and tells why that was refused, if it was.
    fn send(&mut self, action: Action) -> Option<Refusal> {
        let before = (self.state().decision, self.refused.len());
        self.on(Event::Command(Ok(self.command(action))), 2);
        let accepted = self.state().decision > before.0;
        assert_eq!(accepted, self.refused.len() == before.1, "{action}: {:?}", self.refused);
        self.refused.get(before.1).cloned()
    }

    /// Robots 0 and 1 have held, and a takeover of robot 1 came too late for its decision.
    fn after_a_late_takeover(world: &ResolvedScenario) -> Self {
        let mut host = Self::new(world, false);
        assert_eq!(host.send(Action::Hold), None);
        let late = host.command(Action::Hold);
        assert_eq!((late.robot, host.send(Action::Hold)), (RobotId(1), None));
        host.on(Event::Command(Ok(rival(&late))), 2);
        assert_eq!(host.refused.pop().map(|refusal| refusal.reason()), Some("repeated_decision"));
        host
    }

    /// Tells the points of a route and announces it.
    fn announce(&mut self, points: &[Waypoint]) -> Option<Refusal> {
        let route = Route::new(points.to_vec()).unwrap();
        let id = route.id();
        let announcement = Announcement { run: RunId(1), robot: self.team().due, route };
        self.on(Event::Announcement(Ok(announcement)), 2);
        self.send(Action::Announce(id))
    }
}

/// The command as a planner would send it that takes over.
fn rival(command: &Command) -> Command {
    Command { incarnation: Incarnation(9), term: Term(2), ..*command }
}

/// A point so many metres east of where the rover starts, within the safe west of the map.
fn east(world: &ResolvedScenario, by_m: f64) -> Waypoint {
    let start = world.brief.robots[0].start_at;
    Waypoint { x_m: start.x_m + by_m, ..start }
}

/// P-SCOUT-GUARD: Four commands are refused by name: a rover told to fly, a route that begins
/// elsewhere, a flight beyond its budget, and a drive through ground known to be impassable.
#[test]
fn what_a_robot_cannot_do_is_refused_by_name() {
    let world = world("");
    let mut host = Host::new(&world, false);
    let at = |by_m| east(&world, by_m);
    let reason = |refusal: Option<Refusal>| refusal.map_or("accepted", |refusal| refusal.reason());
    for action in [Action::Fly, Action::Drive, Action::Hop(contract::Direction::North)] {
        assert_eq!(reason(host.send(action)), "malformed", "{action} of a rover without a route");
    }
    let unknown = Route::new(vec![at(0.0), at(9.0)]).unwrap();
    assert_eq!(reason(host.send(Action::Announce(unknown.id()))), "unknown_route");
    assert_eq!(reason(host.announce(&[at(1.0), at(9.0)])), "malformed", "it begins elsewhere");
    let outside = Waypoint { x_m: -1.0, ..at(0.0) };
    assert_eq!(reason(host.announce(&[at(0.0), outside])), "malformed", "it leads off the map");
    // Through the northern disc, which everybody knows to be impassable.
    let disc = [Waypoint { x_m: 95.0, y_m: 137.5 }, Waypoint { x_m: 105.0, y_m: 137.5 }];
    assert_eq!(reason(host.announce(&[at(0.0), disc[0], disc[1]])), "accepted");
    // The helicopter: a rover's action, then a flight beyond its 300 m, then one within.
    assert_eq!(reason(host.send(Action::Drive)), "malformed");
    let far: Vec<Waypoint> = [0.0, 151.0, 0.0].map(at).to_vec();
    let refusal = host.announce(&far).unwrap();
    assert!(refusal.to_string().starts_with("a flight needs at most 300 m, got 30"), "{refusal}");
    assert_eq!(reason(Some(refusal)), "beyond_budget");
    assert_eq!(reason(host.announce(&[at(0.0), at(150.0), at(0.0)])), "accepted");
    assert_eq!(host.team().due, ROVER);
    assert_eq!(reason(host.send(Action::Drive)), "vetoed", "the prior along it says 0 m/Sol");
    assert!(host.state().vetoed.has(Action::Drive));
    // Another run, another robot, another task.
    let route = Route::new(vec![at(0.0)]).unwrap();
    for (announcement, need) in [
        (Announcement { run: RunId(2), robot: ROVER, route: route.clone() }, "wrong_run"),
        (Announcement { run: RunId(1), robot: RobotId(2), route: route.clone() }, "wrong_robot"),
    ] {
        host.on(Event::Announcement(Ok(announcement)), 3);
        assert_eq!(host.refused.last().unwrap().reason(), need);
    }
    let mut hopper = crate::fixture::Host::fresh();
    hopper.on(Event::Announcement(Ok(Announcement { run: crate::fixture::RUN, robot: ROVER, route })));
    let state = hopper.state();
    for action in [Action::Drive, Action::Fly, Action::Wait, Action::Done, Action::Announce(unknown.id())] {
        hopper.send(command(&state, action));
    }
    assert_eq!((hopper.state().decision, hopper.refused), (Decision(0), vec!["malformed"; 6]));
}

#[test]
fn a_flight_takes_its_length_divided_by_the_speed_and_wakes_whoever_waits() {
    let world = world("");
    let mut host = Host::new(&world, false);
    let at = |by_m| east(&world, by_m);
    assert_eq!(host.announce(&[at(0.0), at(20.0)]), None);
    assert_eq!(host.announce(&[at(0.0), at(10.0), at(30.0)]), None);
    assert_eq!(host.send(Action::Wait), None);
    assert!(host.waits(ROVER));
    assert_eq!(host.send(Action::Fly), None);
    let team = host.team();
    // A second to announce, two to fly 10 m; the rover is ready when the flight ends, and comes first.
    assert_eq!([0, 1].map(|robot| team.members[robot].ready_at_ns), [3_000_000_000; 2]);
    assert_eq!((team.due, host.waits(ROVER)), (ROVER, false));
    let travel = host.travel(HELICOPTER);
    assert_eq!((travel.at, travel.reached, travel.legs, travel.flown_m), (at(10.0), 1, 2, 10.0));
    assert_eq!(host.send(Action::Drive), None);
    let travel = host.travel(ROVER);
    assert_eq!((travel.at, travel.is_under_way(), travel.moved), (at(20.0), false, Some(Decision(4))));
    // 20 m at 200 m/Sol are a tenth of a Sol of 24.66 h.
    let lasted_ns = host.team().members[0].ready_at_ns - 3_000_000_000;
    assert!(lasted_ns.abs_diff(8_877_600_000_000) < 1_000, "{lasted_ns}");
}

/// P-SCOUT-DEADLOCK: A team deadlocks if its last robot that can act waits, or if only waiting
/// robots are left.
#[test]
fn to_wait_as_the_last_or_to_leave_only_those_who_wait_is_a_deadlock() {
    let world = world("");
    let mut both_wait = Host::new(&world, false);
    assert_eq!(both_wait.send(Action::Wait), None);
    let mut left_alone = Host::new(&world, false);
    assert_eq!(left_alone.send(Action::Wait), None);
    assert_eq!(both_wait.send(Action::Wait), None);
    assert_eq!(left_alone.send(Action::Done), None);
    let mut gives_up = Host::new(&world, false);
    assert_eq!(gives_up.send(Action::Done), None);
    for host in [both_wait, left_alone, gives_up] {
        assert_eq!(host.state().status, Status::Deadlock);
    }
}

/// P-SCOUT-FAULT: A helicopter that fails ends only its own part; a rover that fails ends the
/// mission as lost.
#[test]
fn a_helicopter_that_fails_is_out_and_a_rover_that_fails_is_lost() {
    let faulty = world("[[faults]]\nrobot = 1\naction = 1\n");
    let mut host = Host::new(&faulty, false);
    assert_eq!(host.send(Action::Wait), None);
    assert_eq!(host.send(Action::Hold), None);
    assert_eq!(host.state().last.unwrap().branch, Branch::Stranded);
    let state = host.state();
    assert_eq!((state.status, host.team().due), (Status::Underway, ROVER), "who waited goes on alone");
    let mut host = Host::new(&world("[[faults]]\nrobot = 0\naction = 1\n"), false);
    assert_eq!(host.send(Action::Hold), None);
    assert_eq!(host.state().status, Status::Lost);
}

/// P-SCOUT-UNSEEN: Of ground that only a failed flight would have shown, the guard knows no more
/// than the prior, as the map does.
#[test]
fn a_flight_that_failed_has_shown_the_guard_nothing() {
    for (fault, seen) in [("[[faults]]\nrobot = 1\naction = 2\n", false), ("", true)] {
        let mut world = world(fault);
        let at = |by_m| east(&world, by_m);
        let points = [at(0.0), at(5.0)];
        let terrain = Arc::make_mut(&mut world.terrain);
        // Free ground of which it is not known that it is.
        let doubtful = terrain.grid.index(points[1].cell_of(&terrain.grid)).unwrap();
        terrain.prior[doubtful] = SpeedPrior::new([0.5, 0.0, 0.0, 0.5]).unwrap();
        let mut host = Host::new(&world, false);
        assert_eq!(host.announce(&points), None, "the rover");
        assert_eq!(host.announce(&points), None, "the helicopter");
        assert_eq!(host.send(Action::Wait), None, "the rover");
        assert_eq!(host.send(Action::Fly), None);
        let branch = host.state().last.unwrap().branch;
        assert_eq!(branch, if seen { Branch::Intended } else { Branch::Stranded });
        assert_eq!(host.team().due, ROVER);
        let refusal = host.send(Action::Drive).map(|refusal| refusal.reason());
        assert_eq!(refusal, (!seen).then_some("vetoed"));
    }
}

/// P-SENSOR-GUARD: The guard weighs a reading of a camera that errs by Bayes' rule.
#[test]
fn a_reading_of_a_camera_that_errs_weighs_the_prior_for_the_guard() {
    // Prior, reading, and the probability of getting stuck by hand: 0.9 against (1 - 0.9) / 3.
    let misread = 0.1 / 3.0;
    let cases = [
        (0.5, Some(DriveSpeed::Fast), 0.5 * misread / (0.5 * misread + 0.5 * 0.9)),
        (0.25, Some(DriveSpeed::Zero), 0.25 * 0.9 / (0.25 * 0.9 + 0.75 * misread)),
        (0.5, None, 0.5),
    ];
    for (trap, reading, expected) in cases {
        let mut world = world("");
        let at = |by_m| east(&world, by_m);
        let points = [at(0.0), at(5.0)];
        let camera = ErringCamera { radius_m: 25.0, accuracy: 0.9 };
        world.brief.robots[1].sensor = Sensor::ErringCamera(camera);
        let terrain = Arc::make_mut(&mut world.terrain);
        let doubtful = terrain.grid.index(points[1].cell_of(&terrain.grid)).unwrap();
        terrain.prior[doubtful] = SpeedPrior::new([trap, 0.0, 0.0, 1.0 - trap]).unwrap();
        terrain.cells[doubtful].reading = reading;
        let mut host = Host::new(&world, false);
        assert_eq!(host.announce(&points), None, "the rover");
        assert_eq!(host.announce(&points), None, "the helicopter");
        assert_eq!(host.send(Action::Wait), None, "the rover");
        assert_eq!(host.send(Action::Fly), None);
        let Some(Refusal::Vetoed { need, got, .. }) = host.send(Action::Drive) else {
            panic!("{trap} is lethal")
        };
        assert!((got - expected).abs() < 1e-12 && need == 0.01, "{got}, expected {expected}");
    }
}

/// P-SCOUT-FALLBACK: At the deadline a robot continues along its announced route; without one it
/// holds.
#[test]
fn at_the_deadline_a_robot_goes_on_along_its_route_or_holds() {
    let world = world("deadline_s = 1.0\n");
    let mut host = Host::new(&world, true);
    let actions = |host: &mut Host, now| {
        host.on(Event::Tick, now);
        host.state().last.unwrap().branch
    };
    assert_eq!(actions(&mut host, 2_000_000_000), Branch::Held, "no route yet");
    assert_eq!(host.team().due, HELICOPTER);
    let at = |by_m| east(&world, by_m);
    assert_eq!(host.announce(&[at(0.0), at(5.0)]), None);
    assert_eq!(host.announce(&[at(0.0), at(4.0)]), None, "the rover");
    assert_eq!(host.team().due, HELICOPTER);
    assert_eq!(actions(&mut host, 9_000_000_000), Branch::Intended);
    assert_eq!(host.travel(HELICOPTER).at, at(5.0));
    assert_eq!(actions(&mut host, 19_000_000_000), Branch::Intended);
    assert_eq!((host.travel(ROVER).at, host.state().last_origin), (at(4.0), contract::Origin::Policy));
}

/// P-ROUTE-JOURNAL: Routes are journalled by content. A resumed mission knows every route and each
/// robot's place on its own.
#[test]
fn a_resumed_mission_knows_every_route_and_where_each_robot_is_on_it() {
    let world = world("");
    let folder = tempfile::tempdir().unwrap();
    let header = JournalHeader::new(&world, 1).with_run(RunId(1));
    let mut host = Host::new(&world, false);
    host.journal = Some(Journal::create(folder.path(), &header, false).unwrap());
    let at = |by_m| east(&world, by_m);
    let long: Vec<Waypoint> = (0..256).map(|point| at(0.1 * f64::from(point))).collect();
    assert_eq!(host.announce(&long), None);
    assert_eq!(host.announce(&[at(0.0), at(10.0), at(20.0)]), None);
    for action in [Action::Wait, Action::Fly, Action::Drive, Action::Fly, Action::Done] {
        assert_eq!(host.send(action), None, "{action}");
    }
    drop(host.journal.take());
    let journal = Journal::resume(folder.path(), &header, &world.terrain, false).unwrap();
    assert_eq!(journal.routes().len(), 2);
    let records: Vec<_> = journal.records().map(Result::unwrap).collect();
    let last = *records.last().unwrap();
    let mut resumed =
        Arbiter::new(mission(&world), Some(&last), Pace::Max, 0, MonotonicNs(1)).without_deadlines();
    resumed.recall_routes(RecordStore::routes(&journal).unwrap());
    resumed.recall(&records);
    assert_eq!(resumed.team(), Some(&host.team()));
    assert_eq!(resumed.state().digest, host.state().digest);
    assert!(hopper_sim::verify(folder.path()).unwrap().is_sound());
}

/// A mission of two stages, in which the rover goes to and fro over 45 m at 200 m/Sol and the helicopter has flown 10 m: as far as
/// the fourth drive, which leaves 20 m of its first Sol. The flight is not over.
fn near_the_end_of_a_stage(world: &ResolvedScenario, journal: Option<Journal>) -> Host {
    let mut host = Host { journal, ..Host::new(world, false) };
    let at = |by_m| east(world, by_m);
    let to_and_fro: Vec<Waypoint> = (0..7).map(|point| at(45.0 * f64::from(point % 2))).collect();
    assert_eq!(host.announce(&to_and_fro), None);
    assert_eq!(host.announce(&[at(0.0), at(10.0), at(20.0)]), None);
    for action in [Action::Wait, Action::Fly] {
        assert_eq!(host.send(action), None, "{action}");
    }
    while host.travel(ROVER).reached < 4 {
        let action = if host.team().due == ROVER { Action::Drive } else { Action::Wait };
        assert_eq!(host.send(action), None);
    }
    assert_eq!((host.team().due, host.waits(HELICOPTER)), (ROVER, false));
    host
}

/// P-STAGES-HALT: All drives of a stage, except the last stage, together take a Sol. The drive that
/// uses it up ends on its way, and the helicopters begin the next stage at the rover, with their
/// whole budget and no earlier than the rover. The fallback drives no longer than a stage either.
#[test]
fn a_stage_ends_a_drive_on_its_way_and_the_helicopter_begins_the_next_at_the_rover() {
    let world = world_in("stages = 2", "");
    let mut host = near_the_end_of_a_stage(&world, None);
    assert_eq!(host.travel(HELICOPTER).flown_m, 10.0);
    assert_eq!(host.send(Action::Drive), None);
    let outcome = host.state().last.unwrap();
    assert_eq!(outcome.branch, Branch::Halted);
    assert!((outcome.flight.range_m - 20.0).abs() < 1e-9, "{} m", outcome.flight.range_m);
    let (rover, helicopter) = (host.travel(ROVER), host.travel(HELICOPTER));
    assert!((rover.at.x_m - east(&world, 20.0).x_m).abs() < 1e-9, "{}", rover.at);
    let halt = Some(Decision(host.state().decision.0 - 1));
    assert_eq!((rover.reached, rover.halts, rover.halted, rover.moved), (4, 1, halt, halt));
    assert!(rover.is_under_way(), "it keeps its route");
    assert_eq!(helicopter, Travel { moved: helicopter.moved, ..Travel::from_start(rover.at) });
    let team = host.team();
    assert_eq!(team.members[1].at.cell, team.members[0].at.cell);
    let [rover_ns, helicopter_ns] = [0, 1].map(|robot| team.members[robot].ready_at_ns);
    assert_eq!(rover_ns, helicopter_ns, "it begins when the rover has halted, though it was ready before");
    // All of the last stage's drives are as long as they are.
    assert_eq!(host.send(Action::Drive), None);
    assert_eq!((host.travel(ROVER).at, host.travel(ROVER).reached), (east(&world, 45.0), 5));
    // A whole budget, from where the rover was.
    let far = Waypoint { x_m: rover.at.x_m, y_m: rover.at.y_m + 30.0 };
    let there_and_back: Vec<Waypoint> =
        (0..11).map(|point| if point % 2 == 0 { rover.at } else { far }).collect();
    assert_eq!((host.team().due, host.announce(&there_and_back)), (HELICOPTER, None), "300 m");
}

/// P-STAGES-RESUME: A hopper-sim that resumes in the middle of a stage, or after one, continues in
/// that stage.
#[test]
fn a_resumed_hopper_sim_goes_on_in_the_same_stage() {
    let world = world_in("stages = 2", "");
    let folder = tempfile::tempdir().unwrap();
    let header = JournalHeader::new(&world, 1).with_run(RunId(1));
    let journal = Journal::create(folder.path(), &header, false).unwrap();
    let mut host = near_the_end_of_a_stage(&world, Some(journal));
    for _ in 0..2 {
        drop(host.journal.take());
        let journal = Journal::resume(folder.path(), &header, &world.terrain, false).unwrap();
        let records: Vec<_> = journal.records().map(Result::unwrap).collect();
        let mut resumed = Arbiter::new(mission(&world), records.last(), Pace::Max, 0, MonotonicNs(1));
        resumed = resumed.without_deadlines();
        resumed.recall_routes(RecordStore::routes(&journal).unwrap());
        resumed.recall(&records);
        assert_eq!(resumed.team(), Some(&host.team()));
        let mut again = Host { arbiter: resumed, journal: Some(journal), refused: Vec::new() };
        again.on(Event::Tick, 1);
        assert_eq!((host.send(Action::Drive), again.send(Action::Drive)), (None, None));
        assert_eq!((again.state().digest, again.team()), (host.state().digest, host.team()));
        host.journal = again.journal.take();
    }
    assert_eq!(host.travel(ROVER).halts, 1);
    drop(host.journal.take());
    assert!(hopper_sim::verify(folder.path()).unwrap().is_sound());
}

/// P-STAGES-HALT. The fallback drives no longer than a stage either.
#[test]
fn at_the_deadline_a_rover_drives_to_the_end_of_its_stage() {
    let world = world_in("stages = 2", "deadline_s = 1.0\n");
    let mut host = Host::new(&world, true);
    let at = |by_m| east(&world, by_m);
    let to_and_fro: Vec<Waypoint> = (0..7).map(|point| at(45.0 * f64::from(point % 2))).collect();
    assert_eq!(host.announce(&to_and_fro), None);
    assert_eq!(host.send(Action::Done), None, "the helicopter");
    let branches: Vec<Branch> = (2..8)
        .map(|turn| {
            host.on(Event::Tick, turn * 2_000_000_000);
            host.state().last.unwrap().branch
        })
        .collect();
    assert_eq!(branches[..4], [Branch::Intended; 4]);
    assert_eq!(branches[4..], [Branch::Halted, Branch::Intended]);
    assert_eq!(host.travel(HELICOPTER).at, at(0.0), "who is done stays where it is");
}

#[test]
fn a_route_is_served_once_the_journal_holds_its_announcement() {
    let world = world("");
    let mut host = Host::new(&world, false);
    let route = Route::new(vec![east(&world, 0.0), east(&world, 3.0)]).unwrap();
    let id = route.id();
    host.on(Event::Announcement(Ok(Announcement { run: RunId(1), robot: ROVER, route })), 2);
    let announce = host.command(Action::Announce(id));
    let now = MonotonicNs(3);
    assert!(matches!(host.arbiter.on(Event::Command(Ok(announce)), now)[..], [Effect::Append(_)]));
    assert_eq!(host.arbiter.committed_route(id), None, "its append may fail");
    assert_eq!(host.arbiter.on(Event::AppendFailed, now), []);
    assert_eq!(host.arbiter.committed_route(id), None, "it is not written");
    host.arbiter.on(Event::Tick, now);
    host.arbiter.on(Event::Appended, now);
    assert_eq!(host.arbiter.committed_route(id).map(Route::id), Some(id));
    assert_eq!(host.arbiter.routes().map(Route::id).collect::<Vec<_>>(), [id]);
    let other = Route::new(vec![east(&world, 0.0), east(&world, 4.0)]).unwrap();
    let offer = Announcement { run: RunId(1), robot: HELICOPTER, route: other.clone() };
    host.on(Event::Announcement(Ok(offer)), 4);
    let effects = host.arbiter.on(Event::Command(Ok(host.command(Action::Announce(other.id())))), now);
    assert!(matches!(effects[..], [Effect::Append(_)]), "{effects:?}");
    assert!(host.arbiter.committed_route(id).is_some(), "while another is written");
}

/// P-BID. In a team each robot's own next decision is reserved.
#[test]
fn a_takeover_of_a_robot_that_came_too_late_gets_that_robots_next_decision() {
    let world = world("");
    let mut host = Host::after_a_late_takeover(&world);
    assert_eq!((host.team().due, host.send(Action::Hold)), (ROVER, None), "the rover's decision is not kept");
    assert_eq!(host.team().due, HELICOPTER);
    assert_eq!(host.send(Action::Hold).map(|refusal| refusal.reason()), Some("yielding"));
    host.on(Event::Command(Ok(rival(&host.command(Action::Hold)))), 2);
    assert_eq!((host.team().due, host.team().members[1].leader.term), (ROVER, Term(2)));
}

/// P-BID. A takeover that waits for its robot's turn waits through the turns of all others, and no
/// longer.
#[test]
fn a_takeover_that_came_too_late_waits_through_the_turns_of_the_others() {
    let world = world("[[robots]]\nbody = \"helicopter\"\nspeed_mps = 5.0\n");
    let mut host = Host::after_a_late_takeover(&world);
    for other in [2, 0] {
        assert_eq!((host.team().due, host.send(Action::Hold)), (RobotId(other), None), "it is not kept");
    }
    assert_eq!(host.team().due, RobotId(1));
    assert_eq!(host.send(Action::Hold).map(|refusal| refusal.reason()), Some("yielding"));
    host.on(Event::Command(Ok(rival(&host.command(Action::Hold)))), 2);
    assert_eq!((host.team().due, host.team().members[1].leader.term), (RobotId(2), Term(2)));
}

/// P-BID-EACH: The next turn of each robot is reserved separately: two takeovers that were too late
/// for two robots each get their robot's next turn, and a takeover that missed one robot's turn
/// keeps its reservation for another.
#[test]
fn two_takeovers_of_two_robots_are_each_given_their_turn() {
    let world = world("[[robots]]\nbody = \"helicopter\"\nspeed_mps = 5.0\n");
    for swapped in [false, true] {
        let mut host = Host::new(&world, false);
        let mut late = Vec::new();
        for robot in 0..3 {
            late.push(host.command(Action::Hold));
            assert_eq!((host.team().due, host.send(Action::Hold)), (RobotId(robot), None));
        }
        let lives = if swapped { [(2, 10), (1, 9)] } else { [(1, 9), (2, 10)] };
        let bid = |robot: usize, life| Command { incarnation: Incarnation(life), ..rival(&late[robot]) };
        for (robot, life) in lives {
            host.on(Event::Command(Ok(bid(robot, life))), 2);
            assert_eq!(host.refused.pop().map(|refusal| refusal.reason()), Some("repeated_decision"));
        }
        assert_eq!((host.team().due, host.send(Action::Hold)), (RobotId(0), None), "nobody bid for it");
        for (robot, life) in [(1, 9), (2, 10)] {
            let command = host.command(Action::Hold);
            assert_eq!(command.robot, RobotId(robot));
            for other in [1 + u64::from(robot), if life == 9 { 10 } else { 9 }] {
                let takes_over = other >= 9;
                let term = Term(if takes_over { 2 } else { 1 });
                host.on(Event::Command(Ok(Command { incarnation: Incarnation(other), term, ..command })), 2);
                assert_eq!(host.team().due, RobotId(robot), "it is kept for life {life}, not {other}");
            }
            let bidder = Command { incarnation: Incarnation(life), term: Term(2), ..command };
            host.on(Event::Command(Ok(bidder)), 2);
            let leader = host.team().members[usize::from(robot)].leader;
            assert_eq!((leader.incarnation, leader.term), (Incarnation(life), Term(2)));
        }
    }
}

/// P-OFFERS: Planners that publish routes again and again displace neither each other's routes nor
/// those of other robots.
#[test]
fn a_route_is_known_though_the_planners_of_others_publish_theirs_meanwhile() {
    let world = world("[[robots]]\nbody = \"helicopter\"\nspeed_mps = 5.0\n");
    let mut host = Host::new(&world, false);
    let start = east(&world, 0.0);
    let route = |by_m: f64| Route::new(vec![start, east(&world, by_m)]).unwrap();
    // Two planners of each robot, a few times over.
    for _ in 0..4 {
        for robot in 0..3 {
            for rival in 0..2 {
                let route = route(1.0 + f64::from(robot) + 0.5 * f64::from(rival));
                let announcement = Announcement { run: RunId(1), robot: RobotId(robot), route };
                host.on(Event::Announcement(Ok(announcement)), 2);
            }
        }
    }
    for robot in 0..3 {
        assert_eq!(host.team().due, RobotId(robot));
        let id = route(1.0 + f64::from(robot)).id();
        assert_eq!(host.send(Action::Announce(id)), None, "robot {robot}");
    }
}

#[test]
fn an_announcement_without_its_points_is_not_journalled() {
    let world = world("");
    let folder = tempfile::tempdir().unwrap();
    let header = JournalHeader::new(&world, 1).with_run(RunId(1));
    let mut journal = Journal::create(folder.path(), &header, false).unwrap();
    let mut host = Host::new(&world, false);
    let at = |by_m| east(&world, by_m);
    let route = Route::new(vec![at(0.0), at(3.0)]).unwrap();
    let announcement = Announcement { run: RunId(1), robot: ROVER, route };
    let id = announcement.route.id();
    host.on(Event::Announcement(Ok(announcement)), 2);
    let effects = host.arbiter.on(Event::Command(Ok(host.command(Action::Announce(id)))), MonotonicNs(3));
    let Some(Effect::Append(record)) = effects.first() else { panic!("{effects:?}") };
    assert!(matches!(journal.append(record, None), Err(JournalError::OtherAttachment { .. })));
    let other = Attachment::Route(Route::new(vec![at(0.0), at(4.0)]).unwrap());
    assert!(matches!(journal.append(record, Some(&other)), Err(JournalError::OtherAttachment { .. })));
    assert!(journal.is_empty());
}

/// P-PACE-TIMES: At a multiple of real time, simulated time passes once for all robots, however
/// many act in it.
#[test]
fn robots_that_act_at_the_same_time_share_it_at_every_multiple_of_real_time() {
    let world = world("");
    for (pace, second_ns) in [(Pace::Real, 1_000_000_000), (Pace::Times(3600.0), 277_778)] {
        let arbiter = Arbiter::new(mission(&world), None, pace, 0, MonotonicNs(1)).without_deadlines();
        let mut host = Host { arbiter, journal: None, refused: Vec::new() };
        host.on(Event::Tick, 1);
        // Both hold for a second: that of the helicopter begins when the rover's does, and the rover is due again after it.
        assert_eq!(host.send(Action::Hold), None, "lands at once");
        assert_eq!((host.team().due, host.state().landed), (HELICOPTER, MonotonicNs(2)));
        host.on(Event::Command(Ok(host.command(Action::Hold))), 2);
        host.on(Event::Tick, 1 + second_ns);
        assert_eq!(host.team().due, HELICOPTER, "the second is not over");
        host.on(Event::Tick, 2 + second_ns);
        assert_eq!((host.team().due, host.state().landed), (ROVER, MonotonicNs(2 + second_ns)));
    }
}
