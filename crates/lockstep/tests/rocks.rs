//! The fourth world of Sakamoto & Kubota 2022, flown by all processes.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use contract::{
    Action, Branch, Brief, Cell, Decision, Direction, MonotonicNs, Record, RobotId, RunId, Status,
};
use hopper_sim::Mission;
use lockstep::{Flown, PlannerSchedule};
use motion::{Domain, Draw};
use p22::{Experiment, Hop, KnownMap, Model, P22, Plan, Weights};
use scenario::ResolvedScenario;

fn world(name: &str) -> ResolvedScenario {
    scenario::load(name).unwrap().resolve().unwrap()
}

fn fly(world: &ResolvedScenario, seed: u64, planner: &str) -> (Flown, Vec<Record>) {
    let brief = Brief { run: RunId(1), ..world.brief.clone() };
    let mission = Mission { brief, ..Mission::of(world, seed) };
    let schedule = PlannerSchedule::single(planner.parse().unwrap());
    let mut records = Vec::new();
    let mut clock = || MonotonicNs(1);
    let observe = &mut |record: &Record| records.push(*record);
    let flown = lockstep::fly(mission, &schedule, &mut clock, observe).unwrap();
    (flown, records)
}

/// The path of `hopper known` over the rocks: the actions, and the probability that each ends as aimed.
fn known_path() -> Vec<(Action, f64)> {
    let map = KnownMap::new(Experiment::Rocks, &P22);
    let model = Model::new(&map, &P22);
    let weights = Weights { safety: 0.5, information: 0.5, goal: Weights::GOAL };
    let plan = Plan::new(&map, &model, &P22, weights);
    let action = |hop| match hop {
        Hop::Forward(direction) => Action::Hop(direction),
        Hop::Up(direction) => Action::Up(direction),
    };
    let aimed = |(cell, hop): (&Cell, &Hop)| {
        let index = map.grid.index(*cell).unwrap();
        let choice = plan.solution.policy[index].unwrap();
        (action(*hop), model.choices[choice].scatter.intended)
    };
    plan.path.cells.iter().zip(&plan.path.hops).map(aimed).collect()
}

/// The first seed with which hops of these probabilities all end as aimed.
fn seed_as_aimed(path: &[(Action, f64)]) -> u64 {
    let as_aimed = |seed: u64, decision: usize, probability: f64| {
        Draw::new(seed, Domain::Motion, RobotId(0), Decision(decision as u64)).uniform() < probability
    };
    let all =
        |seed: &u64| path.iter().enumerate().all(|(n, (_, probability))| as_aimed(*seed, n, *probability));
    (0..10_000_000).find(all).unwrap()
}

/// P-UP-ROCKS: With outcomes as aimed, the mission `rocks` takes the actions of the path that `hopper known` plans over the rocks, a vertical
/// hop at (9, 11) among them, and reaches the goal.
#[test]
fn the_mission_takes_the_path_of_the_offline_study_over_the_rocks() {
    let path = known_path();
    let up = Action::Up(Direction::East);
    assert_eq!((path.len(), path.iter().filter(|(action, _)| *action == up).count()), (26, 1));
    let seed = seed_as_aimed(&path);
    let (flown, records) = fly(&world("rocks"), seed, "mdp");
    let flew: Vec<Action> = records.iter().map(|record| record.action).collect();
    let need: Vec<Action> = path.iter().map(|(action, _)| *action).collect();
    assert_eq!(flew, need, "seed {seed}");
    assert!(records.iter().all(|record| record.outcome.branch == Branch::Intended));
    assert_eq!(flown.state.status, Status::Goal);
    let climb = records.iter().find(|record| record.action == up).unwrap();
    assert_eq!((climb.outcome.from, climb.outcome.to), (Cell::new(9, 11), Cell::new(10, 11)));
    assert_eq!(climb.pose.height_m, 0.25);
    assert!((climb.outcome.flight.apex_height_m - 0.485).abs() < 5e-4);
}

/// P-UP-STUDY: On every cell of the rocks, the hops that the live check offers are those of the offline study, with its stepped ground: their
/// actions, their probabilities, and where each branch ends.
#[test]
fn the_live_check_offers_the_hops_of_the_offline_study() {
    let world = world("rocks");
    let map = KnownMap::new(Experiment::Rocks, &P22);
    let model = Model::new(&map, &P22);
    let (grid, motion) = (world.brief.grid, world.brief.leg(0).motion);
    let height_m = |cell| world.terrain.ground(cell).map(|ground| ground.height_m);
    let mut ups = 0;
    for (index, ground) in world.terrain.cells.iter().enumerate() {
        let cell = grid.cell(index);
        let live = motion::offers(&motion, &grid, (cell, ground), height_m);
        let mut offline = [None; 4];
        for choice in model.choices_of(index) {
            offline[model.choices[choice].hop.direction() as usize] = Some(choice);
        }
        for direction in Direction::ALL {
            let (offer, choice) = (live[direction as usize], offline[direction as usize]);
            assert_eq!(offer.is_some(), choice.is_some(), "{cell} {direction}");
            let (Some(offer), Some(choice)) = (offer, choice) else { continue };
            let studied = &model.choices[choice];
            assert_eq!(matches!(offer.action, Action::Up(_)), studied.hop.is_up(), "{cell} {direction}");
            assert_eq!(offer.drawn, studied.scatter, "{cell} {direction}");
            let stays = [false, false, offer.collides[0], offer.collides[1]];
            let branches = [Branch::Intended, Branch::Stayed, Branch::Left, Branch::Right];
            for ((branch, stays), landing) in branches.into_iter().zip(stays).zip(model.landings[choice]) {
                let to = motion::landing(&grid, cell, direction, branch);
                let to = if stays { cell } else { to };
                assert_eq!(
                    grid.index(to).unwrap_or(grid.cells()),
                    landing.index,
                    "{cell} {direction} {branch:?}"
                );
            }
            ups += usize::from(studied.hop.is_up());
        }
    }
    assert_eq!(ups, 12, "one from each cell beside the low rock");
}

/// P-UP-MAP: With a known map the whole of it is seen before the first decision.
#[test]
fn a_known_map_is_seen_as_a_whole_before_the_first_hop() {
    for name in ["rocks", "known-hard", "known-heterogeneous", "known-sandy"] {
        let known = world(name);
        let mission = Mission::of(&known, 1);
        let terrain = mission.terrain.clone();
        let schedule = PlannerSchedule::single("hold".parse().unwrap());
        let mut clock = || MonotonicNs(1);
        let flown = lockstep::fly(mission, &schedule, &mut clock, &mut |_| ()).unwrap();
        let map = flown.map;
        let cells: Vec<_> = map.cells().iter().map(|cell| cell.unwrap()).collect();
        assert_eq!(cells, terrain.cells, "{name}");
    }
}

/// P-UP-PLANNERS: Planners with and without a model hop up where a hop would collide, and none of what they command is refused.
#[test]
fn planners_hop_up_and_none_is_refused() {
    // A wall from side to side has to be climbed.
    let (_, text) = scenario::BUILT_IN.into_iter().find(|(name, _)| *name == "rocks").unwrap();
    let changes = [
        ("{ x = [10, 12], y = [10, 12], height_m = 0.25 }", "{ x = [0, 13], y = [8, 8], height_m = 0.25 }"),
        ("paper-2022", "hopper"),
        ("distance = 0.0", "distance = 10.0"),
        ("goal = 10.0, discount = 0.95", "goal = 100.0, discount = 0.99"),
    ];
    let text = changes.iter().fold(text.to_owned(), |text, (old, new)| {
        assert!(text.contains(old), "{old}");
        text.replace(old, new)
    });
    let world = scenario::Scenario::parse(&text, "a wall").unwrap().resolve().unwrap();
    for planner in ["mdp", "greedy", "astar", "dstar_lite", "clairvoyant"] {
        let mut ups = 0;
        for seed in 0..40 {
            let (flown, records) = fly(&world, seed, planner);
            ups += records.iter().filter(|record| matches!(record.action, Action::Up(_))).count();
            let vetoed: u64 = records.iter().map(|record| record.vetoed.count()).sum();
            assert_eq!(vetoed, 0, "{planner}, seed {seed}");
            assert!(flown.state.status.is_over());
        }
        assert!(ups > 20, "{planner} hops up {ups} times");
    }
}
