//! Rovers that cover ground through the turns of all processes go exactly where the engine of `coverage-world` sends them.

use contract::{
    Account, Action, Body, Brief, Cell, Cover, CoverMode, Decision, Digest, Direction, Goal, Grid, Ground,
    Member, MonotonicNs, ObservedMap, Placement, Record, Robot, RobotId, Robots, Rover, RunId, Sensor,
    Square, Standing, Status, Team, Waypoint,
};
use coverage::{Algorithm, Knowledge};
use coverage_world::{Fault, Sensing, Setup, World};
use hopper_sim::{Arbiter, Mission, Pace};
use lockstep::PlannerSchedule;
use terrain::Terrain;

/// What is covered how, and by whom.
struct Case {
    world: World,
    setup: Setup,
}

impl Case {
    fn new(side: (u32, u32), obstacle_percent: f64, rovers: usize, algorithm: Algorithm, seed: u64) -> Self {
        let grid = Grid::new(side.0, side.1, 1.0, 1).unwrap();
        let world = World::random(grid, obstacle_percent, seed).unwrap();
        let starts = world.random_starts(rovers, seed).unwrap();
        let setup = Setup::new(&world, algorithm, CoverMode::Overlap, starts, 100);
        Self { world, setup }
    }

    /// The mission of this setup, for the processes.
    fn mission(&self) -> Mission {
        let Setup { mode, sensing, starts, percent, faults, steps_max, .. } = &self.setup;
        let grid = *self.world.grid();
        let ground = |cell| Ground { passable: self.world.is_free(cell), ..Ground::FLAT };
        let cells = grid.iter().map(ground).collect();
        let terrain = Terrain { grid, cells, treasures: Vec::new(), prior: Vec::new() };
        let robot = |start: &Placement| Robot {
            body: Body::Rover(Rover { speed_mps: 1.0 }),
            sensor: Sensor::Square(Square { range_cells: sensing.range_cells() as u32 }),
            start: *start,
            start_at: Waypoint::middle_of(&grid, start.cell),
            goal: Goal::Cover(Cover { percent: *percent, mode: *mode }),
            required: true,
        };
        let robots: Vec<Robot> = starts.iter().map(robot).collect();
        let faults = faults
            .iter()
            .map(|fault| scenario::Fault { robot: RobotId(fault.robot as u16), action: fault.action });
        let base = scenario::load("hard").unwrap().resolve().unwrap().brief;
        let mut brief = Brief {
            run: RunId(1),
            grid,
            account: Account::ActionsWithoutWaits,
            robots: Robots::new(&robots).unwrap(),
            ..base
        };
        brief.limits.steps_max = *steps_max;
        Mission { faults: faults.collect(), ..Mission::under_law(brief, terrain, 1) }
    }

    fn fly(&self) -> (lockstep::Flown, Vec<Record>) {
        let schedule = PlannerSchedule::single(self.setup.algorithm.name().parse().unwrap());
        fly(self.mission(), &schedule)
    }

    /// Flies both ways and compares everything round by round.
    fn check(&self) {
        let Self { world, setup } = self;
        let what = format!("{} {:?} {} rovers", setup.algorithm, setup.mode, setup.starts.len());
        let (flown, records) = self.fly();
        let mut engine = coverage_world::Mission::new(world, setup).unwrap();
        let mut places: Vec<(Cell, Direction)> =
            setup.starts.iter().map(|start| (start.cell, start.heading)).collect();
        let mut records = records.iter().peekable();
        let mut covered_at = vec![0; setup.starts.len()];
        while !engine.is_over() {
            engine.round();
            let round = engine.outcome().steps;
            while let Some(record) = records.next_if(|record| record.steps == round) {
                let place = &mut places[usize::from(record.robot.0)];
                if let (Action::Step(heading), true) =
                    (record.action, record.outcome.from != record.outcome.to)
                {
                    *place = (record.pose.cell, heading);
                }
                if record.visits > covered_at.len() as u64 {
                    covered_at.push(round);
                }
            }
            let expected: Vec<(Cell, Direction)> =
                engine.rovers().iter().map(|rover| (rover.pose.cell, rover.pose.heading)).collect();
            assert_eq!(places, expected, "{what}, round {round}");
        }
        assert!(records.next().is_none(), "{what}: the mission ends with the engine's");
        let outcome = engine.outcome();
        let stranded = engine.rovers().iter().all(|rover| rover.stranded);
        let status = match outcome.covered {
            true => Status::Goal,
            false if stranded || outcome.steps < setup.steps_max => Status::Lost,
            false => Status::Deadlock,
        };
        assert_eq!((flown.state.status, flown.state.steps), (status, outcome.steps), "{what}");
        assert_eq!(covered_at, outcome.covered_at, "{what}");
        same_map(&flown.map, &engine, &what);
    }
}

fn fly(mission: Mission, schedule: &PlannerSchedule) -> (lockstep::Flown, Vec<Record>) {
    let mut records = Vec::new();
    let mut time = 0;
    let mut clock = || {
        time += 1;
        MonotonicNs(time)
    };
    let flown = lockstep::fly(mission, schedule, &mut clock, &mut |record| records.push(*record)).unwrap();
    (flown, records)
}

fn same_map(map: &ObservedMap, engine: &coverage_world::Mission<'_>, what: &str) {
    for (index, cell) in map.grid.iter().enumerate() {
        let known = match map.cells()[index] {
            None => Knowledge::Unknown,
            Some(ground) if ground.passable => Knowledge::Free,
            Some(_) => Knowledge::Obstacle,
        };
        let team = engine.map();
        assert_eq!(
            (known, u32::from(map.visits(index))),
            (team.knowledge(cell), team.visits(cell)),
            "{what} {cell}"
        );
    }
}

/// P-COVER-ENGINE: In missions flown through the turns of all processes, rovers that cover ground
/// go exactly where the engine of `coverage-world` sends them.
#[test]
fn rovers_go_where_the_engine_sends_them_on_hundreds_of_worlds() {
    for seed in 0..40_u64 {
        for (number, algorithm) in Algorithm::ALL.into_iter().enumerate() {
            let rovers = [1, 2, 3, 4, 8, 16][(seed as usize + number) % 6];
            let side = (8 + seed as u32 % 9, 8 + (seed as u32 * 7) % 11);
            let mut case = Case::new(side, (seed % 4) as f64 * 6.0, rovers, algorithm, seed);
            for mode in [CoverMode::Overlap, CoverMode::Voronoi] {
                case.setup.mode = mode;
                case.setup.percent = [100, 95, 60][seed as usize % 3];
                case.setup.sensing = if seed % 5 == 4 { Sensing::TwoSteps } else { Sensing::OneStep };
                case.check();
            }
        }
    }
}

/// P-COVER-FAULT: A rover that fails stays where it is. The others go on, and cover its ground in
/// mode `overlap`.
#[test]
fn a_rover_that_fails_stays_where_it_is_and_the_others_go_on_as_in_the_engine() {
    let mut covered = 0;
    for seed in 0..60_u64 {
        for algorithm in [Algorithm::Spiral, Algorithm::CoverFrontier] {
            let mut case = Case::new((10, 10), 10.0, 3, algorithm, seed);
            case.setup.faults = vec![Fault { robot: seed as usize % 3, action: 1 + seed % 17 }];
            if seed % 4 == 3 {
                case.setup.faults.push(Fault { robot: (seed as usize + 1) % 3, action: 5 });
            }
            for mode in [CoverMode::Overlap, CoverMode::Voronoi] {
                case.setup.mode = mode;
                case.check();
            }
            case.setup.mode = CoverMode::Overlap;
            covered += usize::from(case.fly().0.state.status == Status::Goal);
        }
    }
    assert_eq!(covered, 120, "two of three rovers cover for the third, and one for two");
}

/// P-COVER-RECALL: Whoever takes up the journal of a single rover has it where it was, with all that it has covered.
#[test]
fn a_single_rover_is_taken_up_where_it_was() {
    let case = Case::new((6, 6), 0.0, 1, Algorithm::ALL[0], 3);
    let (flown, records) = case.fly();
    assert_eq!(flown.state.status, Status::Goal);
    for count in [1, 5, records.len()] {
        let last = &records[count - 1];
        let mut arbiter = Arbiter::new(case.mission(), Some(last), Pace::Max, 0, MonotonicNs(0));
        arbiter.recall(&records[..count]);
        let took_s: f64 = records[..count].iter().map(|record| record.outcome.flight.flight_time_s).sum();
        let rover = arbiter.team().unwrap().members[0];
        assert_eq!((rover.at.cell, rover.ready_at_ns), (last.pose.cell, (took_s * 1e9).round() as u64));
        let standing = if count == records.len() { Standing::Done } else { Standing::Active };
        assert_eq!(rover.standing, standing, "after {count} decisions");
    }
}

/// P-COVER-LIMIT: A coverage mission that runs out of actions ends as a deadlock.
#[test]
fn a_mission_that_runs_out_of_actions_ends_as_a_deadlock_where_the_engine_ends() {
    for seed in 0..20 {
        let mut case = Case::new((12, 12), 10.0, 4, Algorithm::Boustrophedon, seed);
        case.setup.steps_max = 1 + seed;
        case.check();
        assert_eq!(case.fly().0.state.status, Status::Deadlock);
    }
}

/// P-COVER-LAW: The decision of a planner for coverage never depends on its cache.
#[test]
fn a_planner_with_an_empty_cache_decides_as_one_that_has_seen_all() {
    for algorithm in Algorithm::ALL {
        let case = Case::new((9, 9), 12.0, 3, algorithm, 5);
        let (brief, state) = (case.mission().brief, case.fly().0.state);
        let mut engine = coverage_world::Mission::new(&case.world, &case.setup).unwrap();
        let mut map = ObservedMap::unseen(brief.run, RobotId(0), brief.grid);
        let mut warm = planner::algorithm(algorithm.name()).unwrap();
        while !engine.is_over() {
            for (index, cell) in brief.grid.iter().enumerate() {
                let passable = match engine.map().knowledge(cell) {
                    Knowledge::Free => true,
                    Knowledge::Obstacle => false,
                    Knowledge::Unknown | Knowledge::Outside => continue,
                };
                let visits = engine.map().visits(cell) as u16;
                map.learn_visited(index, Ground { passable, ..Ground::FLAT }, visits);
            }
            map.mark();
            for robot in 0..3 {
                let team = team(&brief, &engine, RobotId(robot));
                let situation = planner::Situation {
                    brief: &brief,
                    leg: None,
                    map: &map,
                    state: &state,
                    team: Some(&team),
                    scouting: None,
                    table: None,
                };
                let mut fresh = planner::algorithm(algorithm.name()).unwrap();
                let plan = fresh.plan(&situation, &planner::Budget::default());
                assert_eq!(warm.plan(&situation, &planner::Budget::default()), plan, "{algorithm}");
            }
            engine.round();
        }
    }
}

/// The rovers of the engine as a message has them.
fn team(brief: &Brief, engine: &coverage_world::Mission<'_>, due: RobotId) -> Team {
    let member = |(robot, rover): (&Robot, &coverage::Rover)| Member {
        at: Placement { cell: rover.pose.cell, heading: rover.pose.heading },
        ..Member::at_start(robot)
    };
    Team {
        run: RunId(1),
        decision: Decision(0),
        digest: Digest::default(),
        due,
        actor: None,
        members: brief.robots.iter().zip(engine.rovers()).map(member).collect(),
    }
}

/// P-COVER-SWAP: In lockstep the planner of one rover can be swapped alone, and the journal repeats
/// the mission.
#[test]
fn the_planner_of_one_robot_is_swapped_and_the_journal_repeats_the_mission() {
    let case = Case::new((10, 10), 10.0, 3, Algorithm::Spiral, 9);
    let (flown, records) = case.fly();
    // Robot 1 is taken over at its third action; all others go on.
    let swapped = records.iter().map(|record| {
        let mut record = *record;
        if record.robot == RobotId(1) && record.decision >= Decision(7) {
            record.leader.planner = "cover_frontier".parse().unwrap();
        }
        Ok::<_, std::convert::Infallible>(record)
    });
    let Ok(schedule) = PlannerSchedule::from_records(swapped);
    let (mixed, made) = fly(case.mission(), &schedule);
    assert_eq!(mixed.state.status, Status::Goal);
    assert_ne!(mixed.state.digest, flown.state.digest);
    for record in &made {
        let taken_over = record.robot == RobotId(1) && record.decision >= Decision(7);
        let expected = if taken_over { "cover_frontier" } else { "spiral" };
        assert_eq!(record.leader.planner.as_str(), expected, "decision {}", record.decision);
        assert_eq!(record.leader.term.0, 1 + u64::from(taken_over), "terms are counted for each robot");
    }
    let Ok(repeated) =
        PlannerSchedule::from_records(made.iter().map(|record| Ok::<_, std::convert::Infallible>(*record)));
    assert_eq!(fly(case.mission(), &repeated).0.state.digest, mixed.state.digest);
}

/// P-GOLDEN.
#[test]
fn the_built_in_scenarios_of_rovers_keep_their_digests() {
    for (name, decisions, digest) in [
        ("coverage", 395, "6ab1324400bc8cf3911d96b5c60cb27725cbac17703c228a1339bd0b9da29688"),
        ("coverage-8", 392, "5509fe6708f784e8906cbe7e248f733b40d1a2d5c917c0d4bed4a3e61da95be3"),
    ] {
        let world = scenario::load(name).unwrap().resolve().unwrap();
        let mission = Mission::of(&world, 1);
        let schedule = PlannerSchedule::single("cover_frontier".parse().unwrap());
        let (flown, records) = fly(mission, &schedule);
        assert_eq!(records.len(), decisions, "{name}");
        assert_eq!(flown.state.digest.to_string(), digest, "{name}");
    }
}
