//! The map of several robots: rovers that cover ground, and a rover whose way a helicopter scouts.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::num::NonZeroU8;
use std::sync::Arc;

use contract::{
    Account, Action, Body, Branch, Brief, Camera, Cell, Collected, Decision, Digest, Direction, DriveSpeed,
    Driver, ErringCamera, Flight, Goal, Grid, Ground, Helicopter, Leader, LookAhead, MapPatch, MonotonicNs,
    ObservedMap, Outcome, PastPage, Placement, Pose, Reach, Record, Robot, RobotId, Robots, Route, RouteId,
    RoutePage, RunId, Sampling, Sensor, State, Status, Timing, Track, Waypoint,
};
use perception::{Cartographer, Effect, Event, Observation};
use scout_world::TrueGround;
use terrain::Terrain;

const NOW: MonotonicNs = MonotonicNs(1);
const RUN: RunId = RunId(7);

/// A mission as its journal has it.
struct Mission {
    brief: Brief,
    terrain: Arc<Terrain>,
    records: Vec<Record>,
    routes: Vec<Route>,
}

impl Mission {
    /// Four rovers: one goes north and back, one waits, and one goes on to a cell that another has seen.
    fn rovers() -> Self {
        let world = scenario::load("coverage").unwrap().resolve().unwrap();
        let brief = Brief { run: RUN, ..world.brief };
        let mut mission =
            Self { brief: brief.clone(), terrain: world.terrain, records: Vec::new(), routes: Vec::new() };
        let mut cells: Vec<Cell> = brief.robots.iter().map(|robot| robot.start.cell).collect();
        let (north, east, south) = (Direction::North, Direction::East, Direction::South);
        for (robot, direction) in [
            (0, Some(north)),
            (1, Some(north)),
            (0, Some(south)),
            (2, None),
            (3, Some(south)),
            (0, Some(east)),
            (0, Some(north)),
        ] {
            let from = cells[robot];
            let (dx, dy) = direction.map_or((0, 0), Direction::step);
            let to = Cell::new(from.x + dx, from.y + dy);
            cells[robot] = to;
            mission.act(
                robot as u16,
                direction.map_or(Action::Hold, Action::Step),
                from,
                to,
                Branch::Intended,
            );
        }
        mission
    }

    /// A rover drives 20 m east and 10 m north, and a helicopter flies 40 m east and part of the way back.
    fn scouts() -> Self {
        let hopper = scenario::load("hard").unwrap().resolve().unwrap();
        let grid = Grid::new(50, 20, 1.0, 1).unwrap();
        let ground = |index: usize| Ground {
            height_m: (index as f64 * 0.37).sin(),
            speed: Some(DriveSpeed::ALL[1 + index % 2]),
            ..Ground::FLAT
        };
        let cells = (0..grid.cells()).map(ground).collect();
        let start = Waypoint { x_m: 2.5, y_m: 4.5 };
        let driver = Robot {
            body: Body::Driver(Driver {}),
            sensor: Sensor::Track(Track {}),
            start: Placement { cell: Cell::new(2, 4), heading: Direction::North },
            start_at: start,
            goal: Goal::Reach(Reach { at: Waypoint { x_m: 22.5, y_m: 14.5 }, radius_m: 1.0 }),
            required: true,
        };
        let helicopter = Robot {
            body: Body::Helicopter(Helicopter { speed_mps: 5.0, budget_m: 300.0 }),
            sensor: Sensor::Camera(Camera { radius_m: 3.0 }),
            goal: Goal::LookAhead(LookAhead {}),
            required: false,
            ..driver
        };
        let sampling = Sampling { seed: 1, rover_samples: 1, helicopter_samples: 1, stages: 1 };
        let mut mission = Self {
            brief: Brief {
                run: RUN,
                grid,
                account: Account::Actions,
                sampling: Some(sampling),
                robots: Robots::new(&[driver, helicopter]).unwrap(),
                ..hopper.brief
            },
            terrain: Terrain { grid, cells, treasures: Vec::new(), prior: Vec::new() }.into(),
            records: Vec::new(),
            routes: Vec::new(),
        };
        let by = |x_m, y_m| Waypoint { x_m: start.x_m + x_m, y_m: start.y_m + y_m };
        mission.routes = [
            vec![by(0.0, 0.0), by(20.0, 0.0), by(20.0, 10.0)],
            vec![by(0.0, 0.0), by(40.0, 0.0), by(20.0, 5.0)],
        ]
        .map(|points| Route::new(points).unwrap())
        .to_vec();
        let [way, flight] = [0, 1].map(|route| Action::Announce(mission.routes[route].id()));
        let here = mission.start();
        for (robot, action) in [
            (0, way),
            (1, flight),
            (1, Action::Fly),
            (0, Action::Drive),
            (1, Action::Wait),
            (0, Action::Drive),
            (1, Action::Fly),
        ] {
            mission.act(robot, action, here, here, Branch::Intended);
        }
        mission
    }

    /// A rover that drives 50 m/Sol goes 40 m east, and north until the first of two stages is over; then the helicopter flies
    /// on from there.
    fn scouts_in_two_stages() -> Self {
        let mut mission = Self::scouts();
        mission.brief.sampling.as_mut().unwrap().stages = 2;
        // Of no cell the middle is just at the border of the view.
        mission.brief.robots[1].sensor = Sensor::Camera(Camera { radius_m: 2.9 });
        for ground in &mut std::sync::Arc::make_mut(&mut mission.terrain).cells {
            *ground = Ground { speed: Some(DriveSpeed::Slow), ..Ground::FLAT };
        }
        let at = |x_m, y_m| Waypoint { x_m, y_m };
        let halt = at(42.5, 14.5);
        mission.routes = [
            vec![at(2.5, 4.5), at(42.5, 4.5), at(42.5, 19.0)],
            vec![at(2.5, 4.5), at(2.5, 7.5)],
            vec![halt, at(32.5, 14.5)],
        ]
        .map(|points| Route::new(points).unwrap())
        .to_vec();
        mission.records.clear();
        let [way, flight, again] = [0, 1, 2].map(|route| Action::Announce(mission.routes[route].id()));
        let here = mission.start();
        for (robot, action, branch) in [
            (0, way, Branch::Held),
            (1, flight, Branch::Held),
            (1, Action::Fly, Branch::Intended),
            (0, Action::Drive, Branch::Intended),
            (0, Action::Drive, Branch::Halted),
            (1, again, Branch::Held),
            (1, Action::Fly, Branch::Intended),
        ] {
            mission.act(robot, action, here, here, branch);
        }
        mission
    }

    /// A rover with a helicopter whose camera reads 0 m/Sol wherever the cell's number is divisible
    /// by 3.
    fn scouts_that_err() -> Self {
        let mut mission = Self::scouts();
        mission.brief.robots[1].sensor = Sensor::ErringCamera(ErringCamera { radius_m: 3.0, accuracy: 0.7 });
        let cells = &mut std::sync::Arc::make_mut(&mut mission.terrain).cells;
        for (index, ground) in cells.iter_mut().enumerate() {
            ground.reading = if index % 3 == 0 { Some(DriveSpeed::Zero) } else { ground.speed };
        }
        mission
    }

    /// Where robot 0 begins.
    fn start(&self) -> Cell {
        self.brief.robots[0].start.cell
    }

    fn act(&mut self, robot: u16, action: Action, from: Cell, to: Cell, branch: Branch) {
        let previous = self.records.last().map_or(Digest::default(), |record| record.digest);
        let range_m = if matches!(action, Action::Drive | Action::Fly) { 10.0 } else { 0.0 };
        let record = Record {
            robot: RobotId(robot),
            decision: Decision(self.records.len() as u64),
            leader: Leader::default(),
            action,
            origin: contract::Origin::Planner,
            visits: 0,
            vetoed: contract::Vetoed::NONE,
            observation: 0,
            work: 0,
            cut: false,
            outcome: Outcome { branch, from, to, flight: Flight { range_m, ..Flight::default() } },
            pose: Pose { cell: to, height_m: 0.0 },
            detail: contract::DetailId::NONE,
            collected: Collected::default(),
            steps: self.records.len() as u64 + 1,
            status: Status::Underway,
            timing: Timing::default(),
            previous,
            digest: Digest::default(),
        };
        self.records.push(Record { digest: previous.chain(&record), ..record });
    }

    /// This mission up to `decision`, then another past.
    fn flown_elsewhere_from(mut self, decision: usize) -> Self {
        self.records.truncate(decision);
        let cell = self.start();
        for _ in 0..3 {
            self.act(0, Action::Hold, cell, cell, Branch::Held);
        }
        self
    }

    fn through(&self) -> u64 {
        self.records.len() as u64
    }

    fn state(&self, decision: u64) -> State {
        let Some(last) = decision.checked_sub(1) else {
            let pose = Pose { cell: self.start(), height_m: 0.0 };
            let first = self.records[0].state_after(RUN, NOW, NOW);
            let (decision, digest) = (Decision(0), Digest::default());
            return State { decision, digest, pose, last: None, steps: 0, robot: RobotId(0), ..first };
        };
        self.records[last as usize].state_after(RUN, NOW, NOW)
    }

    fn ready(&self) -> Cartographer {
        let mut cartographer = Cartographer::new(RobotId(0));
        for event in [Event::Brief(self.brief.clone()), Event::Terrain(RUN, self.terrain.clone())] {
            assert_eq!(cartographer.on(event, NOW), []);
        }
        cartographer
    }

    /// Tells of a state, and answers at once what is asked for, until the map is published.
    fn tell(&self, cartographer: &mut Cartographer, state: State) -> Told {
        let mut told = Told::default();
        let mut effects = cartographer.on(Event::State(state), state.published);
        loop {
            let [effect, rest @ ..] = &effects[..] else { panic!("nothing is asked for: {told:?}") };
            let answer = match effect {
                Effect::RequestPast(request) => {
                    assert!(rest.is_empty(), "{effects:?}");
                    told.pages += 1;
                    assert!(told.pages < 100, "catching up has no end");
                    let from = request.from.0 as usize;
                    let until = (from + 2).min(state.decision.0 as usize);
                    let records = self.records[from..until].to_vec();
                    Event::Past(PastPage { run: RUN, robot: RobotId(0), from: request.from, records })
                }
                Effect::RequestRoute(request) => {
                    told.routes.push(request.id);
                    let route = self.routes.iter().find(|route| route.id() == request.id).unwrap().clone();
                    Event::Route(RoutePage { run: RUN, route })
                }
                Effect::PublishMap => {
                    told.patches = cartographer.patches(NOW, &mut || NOW);
                    told.then = rest.to_vec();
                    return told;
                }
                other => panic!("{other:?}"),
            };
            effects = cartographer.on(answer, state.published);
        }
    }

    /// A cartographer that has heard of every state.
    fn followed(&self) -> (Cartographer, Vec<MapPatch>) {
        let mut cartographer = self.ready();
        let told = |decision| self.tell(&mut cartographer, self.state(decision)).patches;
        let patches = (0..=self.through()).flat_map(told).collect();
        (cartographer, patches)
    }

    /// One that hears of the last state alone.
    fn rebuilt(&self) -> (Cartographer, Told) {
        let mut cartographer = self.ready();
        let told = self.tell(&mut cartographer, self.state(self.through()));
        (cartographer, told)
    }
}

/// What a cartographer asked for, and what it published.
#[derive(Debug, Default)]
struct Told {
    pages: usize,
    routes: Vec<RouteId>,
    patches: Vec<MapPatch>,
    then: Vec<Effect>,
}

/// What readers know of a map; its moments aside.
fn content(map: &ObservedMap) -> impl PartialEq + std::fmt::Debug {
    let visits: Vec<u16> = (0..map.grid.cells()).map(|index| map.visits(index)).collect();
    (map.through, map.digest, map.sequence, map.observation(), map.cells().to_vec(), visits)
}

/// P-REBUILD.
#[test]
fn a_map_of_several_robots_is_the_same_followed_and_rebuilt_from_the_past() {
    for mission in
        [Mission::rovers(), Mission::scouts(), Mission::scouts_that_err(), Mission::scouts_in_two_stages()]
    {
        let ((followed, _), (rebuilt, told)) = (mission.followed(), mission.rebuilt());
        assert_eq!(content(rebuilt.map().unwrap()), content(followed.map().unwrap()));
        assert_eq!(rebuilt.map().unwrap().through, Some(Decision(mission.through())));
        assert_eq!(rebuilt.map().unwrap().digest, mission.state(mission.through()).digest);
        assert_eq!(told.patches.last().map(|patch| patch.robot), Some(mission.records.last().unwrap().robot));
        assert_eq!((rebuilt.waits_for(), rebuilt.seen().1), (None, Decision(mission.through())));
    }
}

#[test]
fn a_rovers_map_counts_who_entered_a_cell_and_holds_the_squares_around_them() {
    let mission = Mission::rovers();
    let (cartographer, patches) = mission.followed();
    let map = cartographer.map().unwrap();
    let moves = mission.records.iter().filter(|record| record.outcome.from != record.outcome.to);
    let moved = moves.map(|record| record.outcome.to);
    let starts = mission.brief.robots.iter().map(|robot| robot.start.cell);
    let entered: Vec<Cell> = starts.chain(moved).collect();
    for (index, cell) in mission.brief.grid.iter().enumerate() {
        let visits = entered.iter().filter(|entered| **entered == cell).count();
        assert_eq!(usize::from(map.visits(index)), visits, "{cell}");
        let near = |at: &Cell| (at.x - cell.x).abs() <= 1 && (at.y - cell.y).abs() <= 1;
        assert_eq!(map.ground(cell).is_some(), entered.iter().any(near), "{cell}");
    }
    let of: Vec<u16> = patches.iter().map(|patch| patch.robot.0).collect();
    assert_eq!(of, [0, 0, 1, 0, 2, 3, 0, 0], "each patch names the robot that has acted");
}

#[test]
fn the_map_of_robots_with_routes_holds_what_they_have_seen_on_their_way() {
    let mission = Mission::scouts();
    let (cartographer, patches) = mission.followed();
    let truth = TrueGround::new(mission.brief.grid, &mission.terrain.cells).unwrap();
    let points = |route: usize| mission.routes[route].waypoints().to_vec();
    let mut seen: Vec<usize> = truth.seen(mission.brief.robots[0].sensor, points(0)[0], points(0)[0]);
    for (robot, points) in [(0, points(0)), (1, points(1))] {
        for leg in points.windows(2) {
            seen.extend(truth.seen(mission.brief.robots[robot].sensor, leg[0], leg[1]));
        }
    }
    let map = cartographer.map().unwrap();
    for (index, ground) in map.cells().iter().enumerate() {
        assert_eq!(ground.is_some(), seen.contains(&index), "{}", mission.brief.grid.cell(index));
    }
    let of: Vec<u16> = patches.iter().map(|patch| patch.robot.0).collect();
    assert_eq!(of, [0, 0, 1, 1, 0, 1, 0, 1], "each patch names the robot that has acted");
}

/// P-SENSOR-MAP: A reading of a camera that errs is on the map until a rover has driven there;
/// until then nothing reveals the truth.
#[test]
fn a_reading_is_on_the_map_until_a_rover_has_been_there() {
    let mission = Mission::scouts_that_err();
    let (cartographer, patches) = mission.followed();
    let truth = TrueGround::new(mission.brief.grid, &mission.terrain.cells).unwrap();
    let way = mission.routes[0].waypoints();
    let driven: Vec<usize> =
        way.windows(2).flat_map(|leg| truth.seen(Sensor::Track(Track {}), leg[0], leg[1])).collect();
    let (mut read, mut corrected) = (0, 0);
    let map = cartographer.map().unwrap();
    for (index, ground) in map.cells().iter().enumerate() {
        let Some(ground) = ground else { continue };
        let true_ground = mission.terrain.cells[index];
        if driven.contains(&index) {
            assert_eq!(*ground, Ground { reading: None, ..true_ground }, "cell {index} was driven over");
            // By the helicopter that flew before the rover drove.
            let before = patches[..4].iter().flat_map(|patch| &patch.cells);
            corrected +=
                before.filter(|cell| cell.index as usize == index && cell.ground.reading.is_some()).count();
        } else {
            let passable = true_ground.reading != Some(DriveSpeed::Zero);
            assert_eq!(
                *ground,
                Ground { speed: None, passable, ..true_ground },
                "cell {index} was flown over"
            );
            read += 1;
        }
    }
    assert!(read > 100 && corrected > 10, "{read} read, {corrected} corrected");
}

/// P-STAGES-SEEN: Of a drive that was ended by its stage, only the cells that were driven over are
/// on the map, and the next flight begins at its end.
#[test]
fn of_a_drive_that_its_stage_ended_only_what_was_driven_is_on_the_map() {
    let mission = Mission::scouts_in_two_stages();
    let known = |through: u64| -> Vec<Cell> {
        let mut cartographer = mission.ready();
        mission.tell(&mut cartographer, mission.state(through));
        let map = cartographer.map().unwrap();
        mission.brief.grid.iter().filter(|cell| map.ground(*cell).is_some()).collect()
    };
    let near = |cell: &Cell, from: [i32; 2], to: [i32; 2]| {
        let outside = |at: i32, low: i32, high: i32| f64::from((low - at).max(at - high).max(0));
        outside(cell.x, from[0], to[0]).hypot(outside(cell.y, from[1], to[1]))
    };
    let cells = || mission.brief.grid.iter();
    let driven = |cell: &Cell| near(cell, [2, 4], [42, 4]) == 0.0 || near(cell, [42, 4], [42, 14]) == 0.0;
    let first_flight = |cell: &Cell| near(cell, [2, 4], [2, 7]) <= 2.9;
    let need: Vec<Cell> = cells().filter(|cell| driven(cell) || first_flight(cell)).collect();
    assert_eq!(known(5), need, "the drive north ends in the cell in which its Sol is over");
    let second_flight = |cell: &Cell| near(cell, [32, 14], [42, 14]) <= 2.9;
    let need: Vec<Cell> =
        cells().filter(|cell| driven(cell) || first_flight(cell) || second_flight(cell)).collect();
    assert_eq!(known(7), need, "the helicopter flies from where the rover is");
}

#[test]
fn a_route_is_asked_for_when_its_first_leg_is_driven_and_never_again() {
    let mission = Mission::scouts();
    let mut cartographer = mission.ready();
    let [way, flight] = [0, 1].map(|route| mission.routes[route].id());
    let expected = [vec![], vec![], vec![], vec![flight], vec![way], vec![], vec![], vec![]];
    for (decision, routes) in expected.into_iter().enumerate() {
        let told = mission.tell(&mut cartographer, mission.state(decision as u64));
        assert_eq!(told.routes, routes, "decision {decision}");
        assert_eq!(told.pages, usize::from(decision > 0) + routes.len(), "decision {decision}");
    }
    let stray = RoutePage { run: RUN, route: mission.routes[0].clone() };
    assert_eq!(cartographer.on(Event::Route(stray), NOW), [], "nobody asked for it");
}

#[test]
fn records_that_are_in_the_map_are_no_reason_to_publish_it() {
    let mission = Mission::scouts();
    let (mut cartographer, _) = mission.followed();
    let page = PastPage { run: RUN, robot: RobotId(0), from: Decision(0), records: mission.records.clone() };
    assert_eq!(cartographer.on(Event::Past(page), NOW), []);
}

#[test]
fn the_robots_of_an_earlier_mission_have_no_part_in_a_hoppers() {
    let rovers = Mission::rovers();
    let (mut cartographer, _) = rovers.followed();
    let hopper = scenario::load("hard").unwrap().resolve().unwrap();
    let (run, start) = (RunId(8), hopper.brief.robots[0].start.cell);
    let pose = Pose { cell: start, height_m: hopper.terrain.ground(start).unwrap().height_m };
    cartographer.on(Event::Brief(Brief { run, ..hopper.brief }), NOW);
    cartographer.on(Event::Terrain(run, hopper.terrain), NOW);
    let state = State { run, pose, ..rovers.state(0) };
    assert_eq!(cartographer.on(Event::State(state), NOW), [Effect::PublishMap]);
    let map = cartographer.map().unwrap();
    assert!(map.ground(start).is_some());
    assert!((0..map.grid.cells()).all(|index| map.visits(index) == 0), "nobody drives there");
}

/// P-TIMELINE.
#[test]
fn a_map_of_several_robots_is_built_anew_for_another_past() {
    for mission in [Mission::rovers, Mission::scouts] {
        for from in 0..7 {
            let (walked, elsewhere) = (mission(), mission().flown_elsewhere_from(from));
            let (mut cartographer, _) = walked.followed();
            let later = NOW.plus_ns(1_000_000_000);
            let state = State { published: later, ..elsewhere.state(elsewhere.through()) };
            let mut effects = cartographer.on(Event::State(state), later);
            let mut now = later;
            while !effects.contains(&Effect::PublishMap) {
                now = now.plus_ns(contract::limits::ASK_AGAIN_NS);
                effects = match effects[..] {
                    [Effect::RequestPast(request)] => {
                        let records = elsewhere.records[request.from.0 as usize..].to_vec();
                        let page = PastPage { run: RUN, robot: RobotId(0), from: request.from, records };
                        cartographer.on(Event::Past(page), now)
                    }
                    [Effect::RequestRoute(_)] => panic!("routes are kept"),
                    _ => cartographer.on(Event::Tick, now),
                };
                assert!(now.since_ns(later) < 1_000_000_000, "never caught up");
            }
            let (undisturbed, _) = elsewhere.followed();
            assert_eq!(content(cartographer.map().unwrap()), content(undisturbed.map().unwrap()), "{from}");
        }
    }
}

#[test]
fn the_end_of_a_mission_of_several_robots_is_reported_with_its_last_map_and_once() {
    for mission in [Mission::rovers(), Mission::scouts()] {
        let (mut cartographer, _) = mission.followed();
        let cell = mission.start();
        let mut ended = mission;
        ended.act(0, Action::Hold, cell, cell, Branch::Held);
        let end = State { status: Status::Goal, ..ended.state(ended.through()) };
        assert_eq!(ended.tell(&mut cartographer, end).then, [Effect::Finished(Status::Goal)]);
        let again = cartographer.on(Event::State(end), NOW);
        assert!(!again.iter().any(|effect| matches!(effect, Effect::Finished(_))), "{again:?}");
    }
}

/// P-MIXED-TREASURE: A treasure is collected once: a rover that enters its cell later finds none.
#[test]
fn a_treasure_that_was_collected_is_none_to_the_rover_that_enters_its_cell() {
    let world = scenario::load("coverage").unwrap().resolve().unwrap();
    let at = Cell::new(1, 1);
    let terrain = Terrain { treasures: vec![at], ..(*world.terrain).clone() };
    let index = terrain.grid.index(at).unwrap();
    let mut observation = Observation::unseen(&world.brief, RobotId(0));
    let mut sense = |entered: &[Cell], landed, decision| {
        observation.sense(&terrain, [index], entered, landed, Decision(decision));
        observation.map().treasures().to_vec()
    };
    assert_eq!(sense(&[], None, 0), [at], "seen");
    assert_eq!(sense(&[], Some(at), 1), [], "collected");
    assert_eq!(sense(&[at], None, 2), [], "entered");
}

#[test]
fn a_cell_keeps_the_highest_report_of_it_also_if_it_was_seen_before() {
    let world = scenario::load("coverage").unwrap().resolve().unwrap();
    let terrain = &*world.terrain;
    let report = |index: usize, report: u8| (index, NonZeroU8::new(report).unwrap());
    let mut observation = Observation::unseen(&world.brief, RobotId(0));
    observation.sense(terrain, [5, 6], &[], None, Decision(0));
    let unreported = observation.map().observation();
    observation.note_reports([report(6, 3), report(7, 9), report(7, 8)]);
    observation.sense(terrain, [6, 7], &[], None, Decision(1));
    let reported = |observation: &Observation, index: usize| {
        observation.map().cells()[index].unwrap().reported.map_or(0, NonZeroU8::get)
    };
    assert_eq!([5, 6, 7].map(|index| reported(&observation, index)), [0, 3, 9]);
    assert_eq!(observation.map().changed_since(unreported), Some(&[6, 7][..]));
    let before = observation.map().observation();
    observation.note_reports([report(6, 3), report(7, 1)]);
    observation.sense(terrain, [6, 7], &[], None, Decision(2));
    assert_eq!(observation.map().observation(), before, "no news");
    observation.sense(terrain, [5, 6], &[Cell::new(6, 0)], None, Decision(3));
    assert_eq!(reported(&observation, 6), 3, "a visit changes nothing of it");
}
