//! A rover with a helicopter, through the turns of all processes, does exactly what the offline study does.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use contract::{
    Action, Branch, Brief, MonotonicNs, Name, Profile, Record, Robot, RobotId, Route, RunId, State, Status,
    Waypoint,
};
use hopper_sim::Mission;
use lockstep::{Flown, PlannerSchedule};
use p21::{Arm, Outcome, RoverPlanner, Samples, Setup, World, announce, monte_carlo};
use planner::drive::CLEARANCE_M;
use planner::{Budget, DRIVE_ALGORITHMS, Plan, Planner, Situation};
use rover::Point;
use scenario::Scenario;

/// A mission on the world of a seed, each robot with its planner.
fn mission(seed: u64, robots: &[(&str, &str)], hazard_max: f64) -> (Mission, PlannerSchedule) {
    mission_in(seed, robots, hazard_max, None, 1)
}

/// A mission in so many stages, whose helicopters read so large a share of speeds right.
fn mission_in(
    seed: u64,
    robots: &[(&str, &str)],
    hazard_max: f64,
    accuracy: Option<f64>,
    stages: u32,
) -> (Mission, PlannerSchedule) {
    let mut text = format!(
        "[truth.terrain.passages]\nseed = {seed}\n[sampling]\nstages = {stages}\n[brief]\n\
         name = \"world\"\nprofile = \"hopper\"\n[limits]\nsteps_max = 1000\n[guard]\nhazard_max = {hazard_max}\n"
    );
    for (body, _) in robots {
        text += &format!("[[robots]]\nbody = \"{body}\"\n");
        if *body == "helicopter" {
            text += &format!("speed_mps = 5.0\naccuracy = {:?}\n", accuracy.unwrap_or(1.0));
        }
    }
    let world = Scenario::parse(&text, "test").unwrap().resolve().unwrap();
    let brief = Brief { run: RunId(1), ..world.brief.clone() };
    let names: Vec<_> = robots.iter().map(|(_, planner)| planner.parse().unwrap()).collect();
    let mission = Mission { brief, ..Mission::of(&world, 1) };
    (mission, PlannerSchedule::of_robots(&names))
}

fn fly(mission: Mission, schedule: &PlannerSchedule) -> (Flown, Vec<Record>) {
    let mut records = Vec::new();
    // No time passes: nothing is asked for twice.
    let mut clock = || MonotonicNs(1);
    let flown = lockstep::fly(mission, schedule, &mut clock, &mut |record| records.push(*record)).unwrap();
    (flown, records)
}

/// What a robot did: the routes that it announced, and the points that it went to.
fn way<'a>(flown: &'a Flown, records: &[Record], robot: RobotId) -> (Vec<&'a Route>, Vec<Waypoint>) {
    let mut routes: Vec<&Route> = Vec::new();
    let (mut points, mut reached) = (Vec::new(), 0);
    for record in records.iter().filter(|record| record.robot == robot) {
        match record.action {
            Action::Announce(id) => {
                routes.push(flown.routes.iter().find(|route| route.id() == id).unwrap());
                reached = 0;
            }
            Action::Drive | Action::Fly if record.outcome.branch == Branch::Intended => {
                let route = routes.last().unwrap().waypoints();
                if reached == 0 {
                    points.push(route[0]);
                }
                reached += 1;
                points.push(route[reached]);
            }
            _ => {}
        }
    }
    (routes, points)
}

fn travel_sol(records: &[Record], robot: RobotId) -> f64 {
    let drives = records.iter().filter(|record| record.robot == robot && record.action == Action::Drive);
    drives.map(|record| record.outcome.flight.flight_time_s).sum::<f64>() / (rover::SOL_HOURS * 3600.0)
}

fn same(what: &str, got: &[Waypoint], expected: &[Point]) {
    let bits = |x: f64, y: f64| (x.to_bits(), y.to_bits());
    let got: Vec<_> = got.iter().map(|at| bits(at.x_m, at.y_m)).collect();
    let expected: Vec<_> = expected.iter().map(|at| bits(at.x_m, at.y_m)).collect();
    assert_eq!(got, expected, "{what}");
}

/// Compares a mission with the study's outcome for the same world, seed and arm.
fn compare(what: &str, flown: &Flown, records: &[Record], expected: &Outcome, helicopter: bool) {
    let rover = RobotId(0);
    let (routes, driven) = way(flown, records, rover);
    let status = match (expected.stuck, expected.route.is_empty()) {
        (true, _) => Status::Lost,
        (false, true) => Status::Deadlock,
        (false, false) => Status::Goal,
    };
    assert_eq!(flown.state.status, status, "{what}");
    match routes.last() {
        Some(route) if !expected.route.is_empty() => {
            same(what, route.waypoints(), &expected.route);
            // A rover that gets stuck has gone part of the way.
            same(
                what,
                &driven,
                &expected.route[..if expected.stuck { driven.len() } else { expected.route.len() }],
            );
        }
        _ => assert!(driven.is_empty() && expected.route.is_empty(), "{what}"),
    }
    if let Some(expected_sol) = expected.travel_sol {
        let got_sol = travel_sol(records, rover);
        assert!(
            (got_sol - expected_sol).abs() <= 1e-12 * expected_sol,
            "{what}: {got_sol}, {expected_sol} Sol"
        );
    }
    if helicopter {
        let (flights, flown_points) = way(flown, records, RobotId(1));
        assert_eq!(flights.len(), 1, "{what}");
        same(what, flights[0].waypoints(), &expected.flight);
        if expected.flight.len() > 1 {
            same(what, &flown_points, &expected.flight);
        }
    }
}

/// The study's outcome on the world of a seed, with the seed that planners of the mission are given.
fn studied(world: &World, arm: Arm, planner: RoverPlanner, seed: u64) -> Outcome {
    studied_with(world, arm, planner, seed, CLEARANCE_M)
}

/// The same, where `ett_exact` keeps a clearance.
fn studied_with(world: &World, arm: Arm, planner: RoverPlanner, seed: u64, clearance_m: f64) -> Outcome {
    let setup = Setup { clearance_m, ..Setup::new(planner, Samples::MONTE_CARLO) };
    let announced = announce(world, &setup, seed);
    p21::fly(world, arm, &setup, seed, announced.as_ref())
}

/// P-SCOUT-STUDY: A rover with a helicopter flies through the turns of all processes exactly what
/// the offline study computes, in each arm and on dozens of worlds: the same routes, flights and
/// end, bit for bit.
#[test]
fn the_mission_of_each_arm_is_that_of_the_study_on_dozens_of_worlds() {
    use RoverPlanner::{EttExact, RrtStarEtt};
    /// An arm of the study with the pairs of planners that are its like here.
    type Case = (Arm, RoverPlanner, &'static [(&'static str, &'static str)]);
    let arms: [Case; 7] = [
        (Arm::NaiveRover, RrtStarEtt, &[("driver", "rrt_star")]),
        (Arm::SafeRover, RrtStarEtt, &[("driver", "rrt_star_ett")]),
        (Arm::SafeRover, EttExact, &[("driver", "ett_exact")]),
        (Arm::ScoutRoute, RrtStarEtt, &[("driver", "rrt_star_ett"), ("helicopter", "scout_route")]),
        (Arm::InformationTheoretic, RrtStarEtt, &[("driver", "rrt_star_ett"), ("helicopter", "rrt_star_it")]),
        (Arm::InformationTheoretic, EttExact, &[("driver", "ett_exact"), ("helicopter", "rrt_star_it")]),
        (Arm::ScoutValue, RrtStarEtt, &[("driver", "rrt_star_ett"), ("helicopter", "scout_value")]),
    ];
    let (mut replanned, mut stuck, mut worlds) = (0, 0, 0);
    for seed in 1..=24_u64 {
        let world = monte_carlo(seed);
        for (arm, planner, robots) in arms {
            let hazard_max = if arm == Arm::NaiveRover { 1.0 } else { 0.01 };
            let (mission, schedule) = mission(seed, robots, hazard_max);
            let planner_seed = mission.brief.sampling.unwrap().seed;
            let expected = studied(&world, arm, planner, planner_seed);
            let (flown, records) = fly(mission, &schedule);
            let what = format!("world {seed}, {arm:?}, {planner:?}");
            compare(&what, &flown, &records, &expected, robots.len() > 1);
            replanned += usize::from(way(&flown, &records, RobotId(0)).0.len() > 1);
            stuck += usize::from(expected.stuck);
            worlds += 1;
        }
    }
    assert!(replanned > worlds / 10 && stuck > 0, "{replanned} replanned, {stuck} stuck of {worlds}");
}

/// P-SCOUT-STUDY.
#[test]
fn in_the_papers_profile_exact_routes_keep_no_clearance() {
    let mut differ = 0;
    for seed in 1..=6_u64 {
        let world = monte_carlo(seed);
        let robots = [("driver", "ett_exact"), ("helicopter", "rrt_star_it")];
        let [near, clear] = [(Profile::Paper2023, 0.0), (Profile::Hopper, CLEARANCE_M)].map(|of| {
            let (profile, clearance_m) = of;
            let (mut mission, schedule) = mission(seed, &robots, 0.01);
            mission.brief.profile = profile;
            let planner_seed = mission.brief.sampling.unwrap().seed;
            let arm = Arm::InformationTheoretic;
            let expected = studied_with(&world, arm, RoverPlanner::EttExact, planner_seed, clearance_m);
            let (flown, records) = fly(mission, &schedule);
            compare(&format!("world {seed}, {profile}"), &flown, &records, &expected, true);
            expected
        });
        differ += usize::from(near.route != clear.route);
    }
    assert!(differ > 3, "{differ} of 6 routes are others with a clearance");
}

/// P-SENSOR-LIVE: A mission whose helicopter has a camera that errs flies through the turns of all
/// processes exactly what the offline study computes; planners and guard believe the same.
#[test]
fn the_mission_with_a_camera_that_errs_is_that_of_the_study() {
    let (mut misled, mut worlds) = (0, 0);
    for (accuracy, seeds) in [(0.7, 1..=8_u64), (0.98, 9..=16), (1.0, 17..=18)] {
        let sensor = helicopter::Sensor::with_accuracy(accuracy).unwrap();
        for seed in seeds {
            let world = monte_carlo(seed);
            for (arm, search) in
                [(Arm::InformationTheoretic, "rrt_star_it"), (Arm::ScoutValue, "scout_value")]
            {
                let robots = [("driver", "rrt_star_ett"), ("helicopter", search)];
                let (mission, schedule) = mission_in(seed, &robots, 0.01, Some(accuracy), 1);
                let planner_seed = mission.brief.sampling.unwrap().seed;
                let exact = Setup::new(RoverPlanner::RrtStarEtt, Samples::MONTE_CARLO);
                let setup = Setup { sensor: Some((sensor, seed)), ..exact };
                let announced = announce(&world, &setup, planner_seed);
                let fly_study = |setup| p21::fly(&world, arm, setup, planner_seed, announced.as_ref());
                let expected = fly_study(&setup);
                let (flown, records) = fly(mission, &schedule);
                let vetoed = records.iter().filter(|record| record.vetoed.has(Action::Drive)).count();
                assert_eq!(vetoed, 0, "planner and guard believe the same");
                let what = format!("world {seed}, {arm:?}, {accuracy}");
                compare(&what, &flown, &records, &expected, true);
                misled += usize::from(expected.route != fly_study(&exact).route);
                worlds += 1;
            }
        }
    }
    assert!(
        misled > 0 && misled < worlds,
        "{misled} of {worlds} routes are not those of a camera without error"
    );
}

/// A rover on its way, folded from records.
#[derive(Default)]
struct RoverWay<'a> {
    /// Where it stands, once it has a route, and the points that it has not reached.
    at: Option<Waypoint>,
    ahead: &'a [Waypoint],
}

impl RoverWay<'_> {
    fn points(&self) -> Vec<Waypoint> {
        self.at.iter().chain(self.ahead).copied().collect()
    }
}

/// Compares a mission of several stages with the study's outcome, stage by stage: the flight, the route after it, and the
/// point where its drive ended. How many stages it took.
fn compare_stages(what: &str, flown: &Flown, records: &[Record], expected: &Outcome) -> usize {
    let (flights, _) = way(flown, records, RobotId(1));
    let mut way = RoverWay::default();
    let mut stages = expected.stages.iter().zip(&flights);
    let (mut present, mut drives) = (None, false);
    for record in records.iter().filter(|record| record.robot == RobotId(0)) {
        if let Action::Announce(id) = record.action {
            let route = flown.routes.iter().find(|route| route.id() == id).unwrap().waypoints();
            if let Some(at) = way.at {
                assert_eq!(route[0], at, "{what}: a route begins where the rover is");
            }
            way = RoverWay { at: Some(route[0]), ahead: &route[1..] };
        }
        if record.action != Action::Drive {
            continue;
        }
        if !drives {
            present = stages.next();
            let (stage, flight) = present.unwrap();
            same(what, flight.waypoints(), &stage.flight);
            same(what, &way.points(), &stage.route);
        }
        let (stage, _) = present.unwrap();
        drives = record.outcome.branch != Branch::Halted;
        match record.outcome.branch {
            Branch::Intended => way = RoverWay { at: way.ahead.first().copied(), ahead: &way.ahead[1..] },
            // The flight after it begins where it ended.
            Branch::Halted => way.at = Some(Waypoint { x_m: stage.end.x_m, y_m: stage.end.y_m }),
            branch => assert_eq!((branch, expected.stuck), (Branch::Stranded, true), "{what}"),
        }
        if let (Branch::Intended, []) = (record.outcome.branch, way.ahead) {
            same(what, &[way.at.unwrap()], &[stage.end]);
        }
    }
    for (stage, flight) in stages {
        // Halted within the goal's disc: its route is the point where it stands.
        same(what, flight.waypoints(), &stage.flight);
        same(what, &way.points(), &stage.route);
        assert_eq!(stage.route, [stage.end], "{what}: as many stages");
    }
    let halts = records.iter().filter(|record| record.outcome.branch == Branch::Halted).count();
    let needed = expected.stages.len().saturating_sub(1);
    // A rover that finds no route after a flight has halted once more than it has driven on.
    let has_given_up = expected.travel_sol.is_none() && !expected.stuck;
    assert_eq!(halts, needed + usize::from(has_given_up && !expected.stages.is_empty()), "{what}");
    let status = match (expected.travel_sol, expected.stuck) {
        (Some(_), _) => Status::Goal,
        (None, true) => Status::Lost,
        (None, false) => Status::Deadlock,
    };
    assert_eq!(flown.state.status, status, "{what}");
    if let Some(expected_sol) = expected.travel_sol {
        let got_sol = travel_sol(records, RobotId(0));
        assert!(
            (got_sol - expected_sol).abs() <= 1e-12 * expected_sol,
            "{what}: {got_sol}, {expected_sol} Sol"
        );
    }
    expected.stages.len()
}

/// P-STAGES-STUDY: A mission of two or three stages flies through the turns of all processes
/// exactly what the offline study computes: the same flights and routes, and the same point at
/// which each stage ends the drive, bit for bit, for both planners of the rover, all planners of
/// the helicopter, and a camera that errs.
#[test]
fn the_mission_in_several_stages_is_that_of_the_study() {
    let helicopters = [
        (Arm::ScoutRoute, "scout_route"),
        (Arm::InformationTheoretic, "rrt_star_it"),
        (Arm::ScoutValue, "scout_value"),
    ];
    let rovers = [(RoverPlanner::RrtStarEtt, "rrt_star_ett"), (RoverPlanner::EttExact, "ett_exact")];
    let mut flown_stages = [0; 4];
    let mut changed = 0;
    // Few worlds take more than two Sol: these do.
    let cases: [(u32, Option<f64>, &[u64]); 4] = [
        (2, None, &[1, 2, 3, 4, 5, 6]),
        (3, None, &[7, 39, 156, 201, 375]),
        (2, Some(0.8), &[13, 14, 15]),
        (3, Some(0.9), &[16, 39, 201]),
    ];
    for (stages, accuracy, seeds) in cases {
        let sensor = accuracy.map(|accuracy| helicopter::Sensor::with_accuracy(accuracy).unwrap());
        for &seed in seeds {
            let world = monte_carlo(seed);
            for (arm, scout) in helicopters {
                for (planner, rover) in rovers {
                    let robots = [("driver", rover), ("helicopter", scout)];
                    let (mission, schedule) = mission_in(seed, &robots, 0.01, accuracy, stages);
                    let planner_seed = mission.brief.sampling.unwrap().seed;
                    let one = Setup::new(planner, Samples::MONTE_CARLO);
                    let sensor = sensor.map(|sensor| (sensor, seed));
                    let setup = Setup { stages, sensor, clearance_m: CLEARANCE_M, ..one };
                    let announced = announce(&world, &setup, planner_seed);
                    let expected = p21::fly(&world, arm, &setup, planner_seed, announced.as_ref());
                    let (flown, records) = fly(mission, &schedule);
                    let vetoed = records.iter().filter(|record| record.vetoed.has(Action::Drive)).count();
                    assert_eq!(vetoed, 0, "planner and guard believe the same");
                    let what = format!("world {seed}, {arm:?}, {planner:?}, {stages} stages, {accuracy:?}");
                    flown_stages[compare_stages(&what, &flown, &records, &expected)] += 1;
                    let kept = |pair: &[p21::Stage]| pair[0].route.ends_with(&pair[1].route[1..]);
                    changed += usize::from(!expected.stages.windows(2).all(kept));
                }
            }
        }
    }
    assert!(flown_stages[2] > 50 && flown_stages[3] > 2, "{flown_stages:?}");
    assert!(changed > 5, "after some halts the rover takes another route: {changed}");
}

/// P-STAGES-LAW: The current stage follows from the robots alone: planners that are replaced by
/// fresh ones at every decision fly the same stages, and planners of another algorithm can take
/// over between two stages.
#[test]
fn fresh_planners_at_every_decision_fly_the_same_stages() {
    let mut halted = 0;
    for (seed, scout) in [(2, "rrt_star_it"), (39, "scout_route"), (201, "scout_value")] {
        let robots = [("driver", "ett_exact"), ("helicopter", scout)];
        let (mission, schedule) = mission_in(seed, &robots, 0.01, None, 3);
        let (flown, records) = fly(mission.clone(), &schedule);
        halted += records.iter().filter(|record| record.outcome.branch == Branch::Halted).count();
        let (again, _) = fly(mission.clone(), &PlannerSchedule::relieved(&records));
        assert_eq!(again.state.digest, flown.state.digest, "world {seed}");
        let Some(halt) = records.iter().find(|record| record.outcome.branch == Branch::Halted) else {
            continue;
        };
        let swapped = records.iter().map(|record| {
            let mut record = *record;
            if record.decision > halt.decision {
                let planner = if record.robot == RobotId(0) { "rrt_star_ett" } else { "scout_value" };
                record.leader.planner = planner.parse().unwrap();
            }
            Ok::<_, std::convert::Infallible>(record)
        });
        let Ok(schedule) = PlannerSchedule::from_records(swapped);
        let (mixed, made) = fly(mission, &schedule);
        assert_eq!(mixed.state.status, Status::Goal, "world {seed}");
        assert_eq!(made[..=halt.decision.0 as usize].last().unwrap().digest, halt.digest, "world {seed}");
        let flights = way(&mixed, &made, RobotId(1)).0;
        assert!(flights.len() > 1, "world {seed}: the helicopter flies again under its new planner");
    }
    assert!(halted > 0);
}

/// P-GOLDEN.
#[test]
fn the_built_in_scenario_keeps_its_digest() {
    let world = scenario::load("rover-helicopter").unwrap().resolve().unwrap();
    let names: Vec<_> = world.planners.iter().flatten().copied().collect();
    let mission = Mission::of(&world, 1);
    let (flown, records) = fly(mission, &PlannerSchedule::of_robots(&names));
    assert_eq!(flown.state.status, Status::Goal);
    assert_eq!(records.len(), 46);
    assert_eq!(
        flown.state.digest.to_string(),
        "5546081ee620960fe540c0defa05db9c5c1b0272c6c609ebdaa5566fd686eeed"
    );
}

/// P-MOBILITY-SLOPES: Planner and simulator know the same slopes: a drive over certain ground takes
/// the expected time.
#[test]
fn on_slopes_a_drive_takes_what_the_planner_expects_of_certain_ground() {
    let mission_on = |amplitude_m: f64| {
        let text = format!(
            "[truth.terrain.gaussians]\nwidth_cells = 60\nheight_cells = 40\ncell_size_m = 1.0\nsigma_m = 12.0\n\
             amplitude_m = {amplitude_m:?}\nraised_m = [[30.0, 20.0]]\n[truth.mobility]\nspeeds = [0, 0, 0, 1]\n\
             [brief]\nprofile = \"hopper\"\nstart = [5, 20]\ngoal = [54, 20]\n\
             [limits]\nsteps_max = 100\n[[robots]]\nbody = \"driver\"\nplanner = \"ett_exact\"\n"
        );
        let world = scenario::Scenario::parse(&text, "slopes").unwrap().resolve().unwrap();
        let mission = Mission::of(&world, 1);
        fly(mission, &PlannerSchedule::of_robots(&["ett_exact".parse().unwrap()]))
    };
    let time_s = |records: &[Record]| {
        let drives = records.iter().filter(|record| record.action == Action::Drive);
        drives.map(|record| record.outcome.flight.flight_time_s).sum::<f64>()
    };
    let (flat, hilly) = (mission_on(0.0), mission_on(6.0));
    assert_eq!((flat.0.state.status, hilly.0.state.status), (Status::Goal, Status::Goal));
    // Straight over level ground: 49 m less the 3 m of the goal's disc, at 200 m a Sol.
    let straight_s = 46.0 / 200.0 * rover::SOL_HOURS * 3600.0;
    assert!((time_s(&flat.1) / straight_s - 1.0).abs() < 1e-3, "{}", time_s(&flat.1));
    assert!(hilly.1.iter().any(|record| record.pose.height_m > 0.5), "a pose has the height of its ground");
    let longer = time_s(&hilly.1) / time_s(&flat.1);
    assert!((1.002..1.05).contains(&longer), "{longer}: over or around a hill of six metres");
}

/// P-SCOUT-LAW: Planners of routes for rover and helicopter fly the same mission if they are
/// replaced by fresh ones at every decision.
#[test]
fn fresh_planners_at_every_decision_fly_the_same_mission() {
    for (seed, scout) in [(1, "rrt_star_it"), (2, "scout_route"), (5, "scout_value")] {
        let robots = [("driver", "rrt_star_ett"), ("helicopter", scout)];
        let (mission, schedule) = mission(seed, &robots, 0.01);
        let (flown, records) = fly(mission.clone(), &schedule);
        let (again, repeated) = fly(mission, &PlannerSchedule::relieved(&records));
        assert_eq!(again.state.digest, flown.state.digest, "world {seed}");
        let terms = repeated.iter().map(|record| record.leader.term.0);
        assert!(terms.max() > Some(3), "each life has a term of its own");
    }
}

/// A planner that at each decision also plans with vetoes, of what it would do and of what it would not.
struct Vetoed {
    planner: Box<dyn Planner>,
    heeded: Arc<AtomicU32>,
}

impl Planner for Vetoed {
    fn name(&self) -> Name {
        self.planner.name()
    }

    fn suits(&self, robot: &Robot) -> bool {
        self.planner.suits(robot)
    }

    fn announces(&self) -> bool {
        self.planner.announces()
    }

    fn plan(&mut self, situation: &Situation<'_>, budget: &Budget) -> Plan {
        let mut choice = |vetoed| {
            let state = State { vetoed, ..*situation.state };
            self.planner.plan(&Situation { state: &state, ..*situation }, budget).action
        };
        let action = choice(contract::Vetoed::NONE);
        for other in [Action::Drive, Action::Fly].into_iter().filter(|other| *other != action) {
            assert_eq!(choice(contract::Vetoed::NONE.with(other)), action, "{other} is vetoed");
        }
        if action == Action::Drive {
            assert_eq!(choice(contract::Vetoed::NONE.with(action)), Action::Hold);
            self.heeded.fetch_add(1, Ordering::Relaxed);
        }
        self.planner.plan(situation, budget)
    }

    fn announced(&self) -> Option<&Route> {
        self.planner.announced()
    }
}

/// P-SCOUT-VETO: A rover does not drive where the guard has vetoed a drive. A veto of an action
/// that its planner would not choose, such as one of the planner before it, changes nothing.
#[test]
fn a_veto_stops_a_drive_and_nothing_else() {
    for name in DRIVE_ALGORITHMS {
        let (mission, schedule) = mission(1, &[("driver", name), ("helicopter", "scout_route")], 0.01);
        let (flown, _) = fly(mission.clone(), &schedule);
        let heeded = Arc::new(AtomicU32::new(0));
        let make = &mut |name: Name, _: &Mission| {
            let planner = planner::algorithm(name.as_str())?;
            Ok(Box::new(Vetoed { planner, heeded: Arc::clone(&heeded) }) as Box<dyn Planner>)
        };
        let vetoed =
            lockstep::fly_with(mission, &schedule, make, &mut || MonotonicNs(1), &mut |_| ()).unwrap();
        assert_eq!(vetoed.state.digest, flown.state.digest, "{name}");
        assert!(heeded.load(Ordering::Relaxed) > 0, "{name} never drives");
    }
}

/// P-SCOUT-SWAP: The helicopter's planner can be swapped alone; a flight that was announced is
/// flown to its end.
#[test]
fn the_helicopters_planner_is_swapped_in_flight_and_its_flight_goes_on() {
    let robots = [("driver", "rrt_star_ett"), ("helicopter", "rrt_star_it")];
    let (mission, schedule) = mission(1, &robots, 0.01);
    let (flown, records) = fly(mission.clone(), &schedule);
    let swapped = records.iter().map(|record| {
        let mut record = *record;
        if record.robot == RobotId(1) && record.decision.0 > 8 {
            record.leader.planner = "scout_value".parse().unwrap();
        }
        Ok::<_, std::convert::Infallible>(record)
    });
    let Ok(schedule) = PlannerSchedule::from_records(swapped);
    let (mixed, made) = fly(mission, &schedule);
    assert_eq!(mixed.state.digest, flown.state.digest, "a flight that was announced is flown to its end");
    let led = |robot: u16, name: &str| {
        made.iter().any(|record| record.robot == RobotId(robot) && record.leader.planner.as_str() == name)
    };
    assert!(led(1, "rrt_star_it") && led(1, "scout_value") && led(0, "rrt_star_ett"));
    assert!(made.iter().filter(|record| record.robot == RobotId(0)).all(|record| record.leader.term.0 == 1));
}
