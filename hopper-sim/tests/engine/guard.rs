//! What the guard lets pass, what it vetoes, and what is done when nobody commands.

use std::sync::Arc;

use contract::{
    Action, Cell, Decision, Direction, GradientSource, Grid, Ground, Leader, MonotonicNs, Origin, Policy,
    PolicyCell, Pose, Vetoed,
};
use hopper_sim::{Arbiter, Effect, Event, Fallback, Guard, Mission, Pace, ROBOT};

use crate::fixture::{EAST, Host, LINGER_NS, RUN, WEST, command, disc, mission, name};

const NORTH: Action = Action::Hop(Direction::North);
const DEADLINE_NS: u64 = 3_000_000_000;

/// The mission from `start` on ground without slopes, with rocks, under a guard.
fn guarded(start: Cell, rocks: &[Cell], hazard_max: f64, deadline_ns: u64) -> Mission {
    let mut mission = mission();
    mission.brief.robots[0].start.cell = start;
    mission.brief.guard = contract::Guard { hazard_max, deadline_ns };
    for (cell, ground) in mission.brief.grid.iter().zip(&mut Arc::make_mut(&mut mission.terrain).cells) {
        ground.gradient = [0.0; 2];
        ground.height_m = 0.0;
        ground.passable = !rocks.contains(&cell);
    }
    mission
}

fn host(mission: Mission) -> Host {
    Host::new(mission, Vec::new(), Pace::Max)
}

fn hazards(mission: &Mission, cell: Cell) -> [f64; 5] {
    let pose = Pose { cell, height_m: mission.terrain.ground(cell).unwrap().height_m };
    let hazard =
        |action| Guard::new(&mission.brief, &mission.terrain, hopper_sim::ROBOT, pose).hazard(action);
    [0, 1, 2, 3, 4].map(|code| hazard(Action::from_code(code).unwrap()))
}

fn policy(mission: &Mission, planner: &str, action: Action) -> Policy {
    let cells = vec![PolicyCell { action, value: 0.0 }; mission.brief.grid.cells()];
    Policy { run: RUN, robot: ROBOT, decision: Decision(0), planner: name(planner), error_bound: 0.0, cells }
}

#[test]
fn the_hazard_is_the_probability_of_ruin_in_closed_form() {
    let mission = guarded(Cell::new(1, 2), &[Cell::new(2, 4)], 1.0, 0);
    let close = |got: [f64; 5], need: [f64; 5]| {
        assert!(got.iter().zip(need).all(|(got, need)| (got - need).abs() < 1e-12), "{got:?}, not {need:?}");
    };
    // Hold, north, east, south, west; hard ground lands 0.9 ahead and 0.05 to either side.
    close(hazards(&mission, Cell::new(7, 4)), [0.0; 5]);
    close(hazards(&mission, Cell::new(0, 0)), [0.0, 0.05, 0.05, 0.9 + 0.05, 0.9 + 0.05]);
    close(hazards(&mission, Cell::new(2, 3)), [0.0, 0.9, 0.05, 0.0, 0.05]);
    // Sand lands 0.7 ahead and 0.1 to either side.
    close(hazards(&mission, Cell::new(4, 0)), [0.0, 0.0, 0.1, 0.7, 0.1]);
    // A slope that rises to the right makes a slip to the right, off the map, the rarer one: s (1 − t).
    let mut sloped = mission.clone();
    let t = 0.1_f64.atan() / sloped.brief.leg(0).motion.slope_limit_rad;
    Arc::make_mut(&mut sloped.terrain).cells[sloped.brief.grid.index(Cell::new(0, 4)).unwrap()].gradient =
        [-0.1, 0.0];
    let [_, north, ..] = hazards(&sloped, Cell::new(0, 4));
    assert!((north - 0.05 * (1.0 + t)).abs() < 1e-12, "{north}");
}

#[test]
fn the_slope_underfoot_is_what_the_observed_map_has() {
    let mut mission = guarded(Cell::new(1, 2), &[], 1.0, 0);
    disc(&mut mission.brief).gradient = GradientSource::SeenDifferences;
    // The true slope is not known in profile hopper; heights rise westwards by 0.1 a metre, seen from (0, 4).
    let grid = mission.brief.grid;
    let index = |x: i32, y: i32| grid.index(Cell::new(x, y)).unwrap();
    Arc::make_mut(&mut mission.terrain).cells[index(0, 4)].gradient = [9.0, 9.0];
    Arc::make_mut(&mut mission.terrain).cells[index(1, 4)].height_m = -0.1;
    let t = 0.1_f64.atan() / mission.brief.leg(0).motion.slope_limit_rad;
    let [_, north, ..] = hazards(&mission, Cell::new(0, 4));
    assert!((north - 0.05 * (1.0 + t)).abs() < 1e-12, "{north}");
}

/// P-GUARD-UNSEEN: What cannot be seen changes no veto.
#[test]
fn what_cannot_be_seen_from_here_changes_no_hazard() {
    let mission = guarded(Cell::new(1, 2), &[Cell::new(4, 5), Cell::new(3, 3)], 1.0, 0);
    for here in mission.brief.grid.iter() {
        let mut other = mission.clone();
        for (cell, ground) in mission.brief.grid.iter().zip(&mut Arc::make_mut(&mut other.terrain).cells) {
            if cell.distance_cells(here) > 2.0 {
                ground.passable = !ground.passable;
                ground.height_m += 3.0;
                ground.gradient = [0.4, -0.4];
            }
        }
        assert_eq!(hazards(&mission, here), hazards(&other, here), "at {here}");
    }
}

/// P-GUARD-REACH: A landing one hop ahead is seen and guarded at the smallest sensing radius,
/// whatever the rounding of cells and hops.
#[test]
fn a_rock_one_hop_ahead_is_seen_at_the_smallest_radius_whatever_the_rounding() {
    let mut rounded = 0;
    for hop_cells in 1..=12 {
        for cell_size_m in (1..=40).map(|step| f64::from(step) / 20.0) {
            let side = 2 * hop_cells + 1;
            let (here, rock) = (Cell::new(hop_cells as i32, 0), Cell::new(2 * hop_cells as i32, 0));
            let mut mission = guarded(here, &[], 0.0, 0);
            let grid = Grid::new(side, side, cell_size_m, hop_cells).unwrap();
            (mission.brief.grid, Arc::make_mut(&mut mission.terrain).grid) = (grid, grid);
            let disc = disc(&mut mission.brief);
            (disc.gain, disc.radius_min_m, disc.radius_max_m) = (0.0, grid.hop_distance_m(), 1e3);
            let ground = |cell| Ground { passable: cell != rock, ..Ground::FLAT };
            Arc::make_mut(&mut mission.terrain).cells = grid.iter().map(ground).collect();
            let east = hazards(&mission, here)[2];
            assert!(east >= 0.9, "{hop_cells} cells of {cell_size_m} m: {east}");
            rounded += u32::from(grid.hop_distance_m() / cell_size_m < f64::from(hop_cells));
        }
    }
    assert!(rounded > 10, "{rounded} cases in point");
}

/// P-GUARD: A hop into danger that is visible from where the hopper stands is vetoed, whoever
/// commands it. The veto is named in the state, counted and journalled, and another command can be
/// executed.
#[test]
fn a_vetoed_command_is_refused_by_name_told_and_journaled_and_another_is_executed() {
    let mut host = host(guarded(Cell::new(0, 4), &[], 0.25, 0));
    let published = host.published.len();
    host.send(command(&host.state(), WEST));
    host.send(command(&host.state(), WEST));
    assert_eq!(host.refused, ["vetoed"; 2]);
    assert_eq!((host.state().decision, host.records.len()), (Decision(0), 0), "nothing has happened");
    assert_eq!(host.state().leader, Leader::default(), "and nobody commands for it");
    let told = host.published[published];
    assert!(told.vetoed.has(WEST) && told.vetoed.count() == 1 && told.decision == Decision(0), "{told:?}");
    host.send(command(&host.state(), NORTH));
    let record = host.records[0];
    assert_eq!((record.action, record.origin), (NORTH, Origin::Planner));
    assert_eq!(record.vetoed, Vetoed::NONE.with(WEST));
    let state = host.state();
    assert_eq!(
        (state.vetoed, state.last_vetoed),
        (Vetoed::NONE, record.vetoed),
        "a new decision, a new trial"
    );
    assert_eq!(host.arbiter.refusals().of("vetoed"), 2);
}

#[test]
fn hazards_up_to_the_limit_pass_and_standing_still_always_does() {
    for (hazard_max, passes) in [(0.04, false), (0.06, true), (1.0, true)] {
        let mut host = host(guarded(Cell::new(0, 4), &[], hazard_max, 0));
        host.send(command(&host.state(), NORTH));
        assert_eq!(host.state().decision.0 == 1, passes, "{hazard_max}");
    }
    let [_, north, ..] = hazards(&guarded(Cell::new(0, 4), &[], 1.0, 0), Cell::new(0, 4));
    let mut at_the_limit = host(guarded(Cell::new(0, 4), &[], north, 0));
    at_the_limit.send(command(&at_the_limit.state(), NORTH));
    assert_eq!(at_the_limit.state().decision, Decision(1), "{north}");
    let mut walled = host(guarded(Cell::new(0, 0), &[Cell::new(1, 0), Cell::new(0, 1)], 0.0, 0));
    for action in Action::ALL.into_iter().filter(|action| matches!(action, Action::Hold | Action::Hop(_))) {
        walled.send(command(&walled.state(), action));
    }
    assert_eq!((walled.records[0].action, walled.refused.len()), (Action::Hold, 4));
    let off = contract::Guard::OFF;
    assert_eq!((off.hazard_max, off.deadline_ns), (1.0, 0));
}

#[test]
fn a_life_that_is_resumed_vetoes_the_same() {
    let mission = guarded(Cell::new(0, 4), &[], 0.25, 0);
    let mut first = host(mission.clone());
    first.send(command(&first.state(), WEST));
    first.send(command(&first.state(), Action::Hold));
    let mut second = Host::new(mission, first.records.clone(), Pace::Max);
    assert_eq!(second.state().last_vetoed, Vetoed::NONE.with(WEST));
    second.send(command(&second.state(), WEST));
    assert_eq!(second.refused, ["vetoed"]);
}

/// P-FALLBACK: At the deadline the fallback acts: by the last policy, else greedily, else it holds.
/// Leader and term stay unchanged.
#[test]
fn at_the_deadline_the_fallback_acts_greedily_and_the_command_stays_where_it_is() {
    let mut host = host(guarded(Cell::new(1, 2), &[Cell::new(2, 2)], 0.25, DEADLINE_NS));
    host.send(command(&host.state(), NORTH));
    let (leader, from) = (host.state().leader, host.state().pose.cell);
    assert_eq!(host.arbiter.wake_at().map(|at| at.since_ns(host.now) <= DEADLINE_NS), Some(true));
    host.tick_after(DEADLINE_NS - 1);
    assert_eq!(host.records.len(), 1, "not before the deadline");
    host.tick_after(1);
    let record = host.records[1];
    // The goal lies at (7, 6): east comes nearest.
    assert_eq!((record.origin, record.action), (Origin::Greedy, EAST), "from {from}");
    assert_eq!((record.leader, record.observation, record.work), (leader, 0, 0));
    let moments = [record.timing.landed, record.timing.state_published].map(|moment| moment.0);
    assert_eq!(moments, [1_005; 2], "of the state that nobody answered");
    assert_eq!([record.timing.accepted, record.timing.committed], [MonotonicNs(1_005 + DEADLINE_NS); 2]);
    assert_eq!(record.timing.planning_ended, MonotonicNs(0), "nobody planned");
    assert_eq!(record.digest, record.previous.chain(&record));
    let state = host.state();
    assert_eq!((state.decision, state.leader, state.last_origin), (Decision(2), leader, Origin::Greedy));
    host.tick_after(DEADLINE_NS - 1);
    assert_eq!(host.records.len(), 2, "each decision has a deadline of its own");
    host.send(command(&host.state(), EAST));
    assert_eq!((host.records[2].origin, host.records[2].leader), (Origin::Planner, leader));
}

#[test]
fn without_a_deadline_the_hopper_stands_still_for_ever() {
    let mut host = host(guarded(Cell::new(1, 2), &[], 0.25, 0));
    for _ in 0..100 {
        host.tick_after(DEADLINE_NS);
    }
    assert!(host.records.is_empty());
}

/// P-FALLBACK.
#[test]
fn the_last_policy_of_the_algorithm_in_command_comes_first_if_the_guard_lets_it_pass() {
    let mission = guarded(Cell::new(1, 4), &[], 0.25, DEADLINE_NS);
    let cases = [
        ("mdp", NORTH, Origin::Policy, NORTH),
        ("mdp", WEST, Origin::Policy, WEST),
        ("greedy", NORTH, Origin::Greedy, EAST),
        ("mdp", Action::Hold, Origin::Greedy, EAST),
    ];
    for (planner, advice, origin, action) in cases {
        let mut host = host(mission.clone());
        host.send(command(&host.state(), Action::Hold));
        host.on(Event::Policy(policy(&mission, planner, advice)));
        host.tick_after(DEADLINE_NS);
        let record = host.records[1];
        assert_eq!((record.origin, record.action), (origin, action), "{planner} says {advice}");
    }
    let mut edge = host(guarded(Cell::new(0, 4), &[], 0.25, DEADLINE_NS));
    edge.send(command(&edge.state(), Action::Hold));
    edge.on(Event::Policy(policy(&mission, "mdp", WEST)));
    edge.tick_after(DEADLINE_NS);
    assert_eq!(edge.records[1].origin, Origin::Greedy, "off the map the policy is not followed");
}

#[test]
fn a_policy_of_another_run_robot_size_or_future_is_not_kept() {
    let mission = guarded(Cell::new(1, 4), &[], 0.25, DEADLINE_NS);
    let good = policy(&mission, "mdp", NORTH);
    let bad = [
        Policy { run: contract::RunId(1), ..good.clone() },
        Policy { robot: contract::RobotId(1), ..good.clone() },
        Policy { cells: good.cells[1..].to_vec(), ..good.clone() },
        Policy { decision: Decision(99), ..good },
    ];
    for policy in bad {
        let mut host = host(mission.clone());
        host.send(command(&host.state(), Action::Hold));
        host.on(Event::Policy(policy));
        host.tick_after(DEADLINE_NS);
        assert_eq!(host.records[1].origin, Origin::Greedy);
    }
}

/// P-FALLBACK.
#[test]
fn where_nothing_is_safe_the_fallback_holds() {
    let rocks = [Cell::new(1, 0), Cell::new(0, 1)];
    let mut host = host(guarded(Cell::new(0, 0), &rocks, 0.0, DEADLINE_NS));
    host.tick_after(DEADLINE_NS);
    let record = host.records[0];
    assert_eq!((record.origin, record.action), (Origin::Hold, Action::Hold));
    assert_eq!(record.leader, Leader::default(), "before the first command nobody commands");
}

/// P-FALLBACK.
#[test]
fn the_fallback_aims_at_no_visible_danger_even_where_the_guard_lets_it_pass() {
    let mut host = host(guarded(Cell::new(1, 2), &[Cell::new(2, 2)], 1.0, DEADLINE_NS));
    host.tick_after(DEADLINE_NS);
    // East comes nearest to the goal, and is a rock.
    assert_eq!((host.records[0].origin, host.records[0].action), (Origin::Greedy, NORTH));
}

#[test]
fn what_the_fallback_did_is_not_repeated_after_the_end() {
    let mut host = host(guarded(Cell::new(1, 4), &[], 1.0, DEADLINE_NS));
    host.fly();
    let flown = host.records.len();
    host.on(Event::Repeat(Fallback { action: EAST, origin: Origin::Greedy }));
    assert_eq!(host.records.len(), flown);
}

/// P-FALLBACK-REPEATED: A mission with fallbacks is repeated from its records, without a clock.
#[test]
fn a_mission_with_fallbacks_is_repeated_from_its_records_without_a_clock() {
    let mission = guarded(Cell::new(1, 4), &[], 0.25, DEADLINE_NS);
    let mut flown = host(mission.clone());
    for _ in 0..3 {
        flown.send(command(&flown.state(), EAST));
        flown.tick_after(DEADLINE_NS);
    }
    let mut again = host(mission);
    for record in &flown.records {
        match record.origin {
            Origin::Planner => again.send(command(&again.state(), record.action)),
            origin => again.on(Event::Repeat(Fallback { action: record.action, origin })),
        }
    }
    let told = |host: &Host| -> Vec<_> {
        host.records.iter().map(|record| (record.origin, record.digest)).collect()
    };
    assert_eq!(told(&flown), told(&again));
    assert!(flown.records.len() == 6);
}

#[test]
fn a_command_that_comes_while_the_fallback_is_written_waits_for_the_next_decision() {
    let mission = guarded(Cell::new(1, 4), &[], 0.25, DEADLINE_NS);
    let start = MonotonicNs(1_000);
    let mut arbiter = Arbiter::new(mission, None, Pace::Max, LINGER_NS, start);
    arbiter.on(Event::Tick, start);
    let late = start.plus_ns(DEADLINE_NS);
    let effects = arbiter.on(Event::Tick, late);
    assert!(effects.iter().any(|effect| matches!(effect, Effect::Append(_))), "{effects:?}");
    let order = command(arbiter.state(), EAST);
    let effects = arbiter.on(Event::Command(Ok(order)), late);
    assert!(matches!(&effects[..], [Effect::Refused(refusal)] if refusal.reason() == "busy"), "{effects:?}");
}
