//! What programs and people read at the end of a run.

// Helpers of tests are not recognised as tests.
#![allow(clippy::unwrap_used)]

mod mission;

use std::path::PathBuf;

use contract::{
    Account, Action, Body, Branch, Cell, Cover, Direction, Goal, Member, MonotonicNs, Placement, Refusal,
    RefusalCounts, Robot, RobotId, Role, Rover, RunId, Sensor, Square, Standing, State, Status, Team,
    Waypoint,
};
use mission::{Step, brief, driver, helicopter, records, start, with_robots};
use report::{Ending, Executed, Process, Summary, SummaryBuilder, Tally, TeamEffort};

const EAST: Action = Action::Hop(Direction::East);
const NORTH: Action = Action::Hop(Direction::North);
/// From (1, 1) to the goal at (3, 3) of a world of five cells, with one of each mishap on the way.
const STEPS: [Step; 8] = [
    (EAST, Branch::Intended),
    (EAST, Branch::Stayed),
    (Action::Hold, Branch::Held),
    (EAST, Branch::Left),
    (EAST, Branch::Right),
    (EAST, Branch::Intended),
    (NORTH, Branch::Intended),
    (NORTH, Branch::Intended),
];

fn state(records: &[contract::Record]) -> State {
    records.last().unwrap().state_after(RunId(1), MonotonicNs(0), MonotonicNs(0))
}

fn summary(steps: &[Step]) -> Summary {
    let brief = brief(5);
    let records = records(&brief, steps, 5);
    let mut builder = SummaryBuilder::new(&brief, 7);
    records.iter().for_each(|record| builder.record(record));
    let mut refusals = RefusalCounts::default();
    refusals.count(&Refusal::MissionOver);
    let mut summary = builder.build(&state(&records), None, &refusals);
    summary.coverage = Some(0.625);
    summary.processes = vec![
        Process { role: Role::HopperSim, pid: 41, restarts: 0 },
        Process { role: Role::Perception, pid: 42, restarts: 1 },
    ];
    summary.artifacts = [("picture".into(), PathBuf::from("out/mission.svg"))].into();
    summary
}

#[test]
fn the_promised_json_fields_are_there_by_name_and_in_order() {
    let json = serde_json::to_string(&summary(&STEPS)).unwrap();
    let fields = [
        "scenario",
        "seed",
        "profile",
        "outcome",
        "steps",
        "hops",
        "digest",
        "planners",
        "latency",
        "processes",
        "artifacts",
    ];
    let places: Vec<_> = fields.iter().map(|field| json.find(&format!("{field:?}:")).expect(field)).collect();
    assert!(places.is_sorted(), "{json}");
    let value: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(value["scenario"], "tiny");
    assert_eq!(value["seed"], 7);
    assert_eq!(value["profile"], "paper-2023");
    assert_eq!(value["outcome"], "goal");
    assert_eq!(value["steps"], 15);
    assert_eq!(value["hops"], 7);
    assert_eq!(value["digest"].as_str().unwrap().len(), 64);
    assert_eq!(
        value["planners"],
        serde_json::json!([
            { "name": "mdp", "term": 1, "from_decision": 0, "to_decision": 4 },
            { "name": "greedy", "term": 2, "from_decision": 5, "to_decision": 7 },
        ])
    );
    assert_eq!(value["latency"]["decisions"], 8);
    assert_eq!(value["latency"]["total"]["max_us"], 300.0);
    assert_eq!(value["latency"]["stages"]["plan"]["p99_us"], 200.0);
    assert_eq!(value["processes"][1], serde_json::json!({ "role": "perception", "pid": 42, "restarts": 1 }));
    assert_eq!(value["artifacts"], serde_json::json!({ "picture": "out/mission.svg" }));
    assert_eq!((&value["decisions"], &value["stray_hops"]), (&8.into(), &3.into()));
    assert_eq!(value["refusals"]["mission_over"], 1);
}

#[test]
fn a_summary_survives_its_json() {
    let summary = summary(&STEPS);
    let json = serde_json::to_string(&summary).unwrap();
    assert_eq!(serde_json::from_str::<Summary>(&json).unwrap(), summary);
}

#[test]
fn the_text_for_a_terminal_stands_as_written() {
    let text = summary(&STEPS).to_string();
    assert!(text.lines().count() <= 27, "{text}");
    assert!(text.lines().all(|line| line.chars().count() <= 84 || line.contains("digest")), "{text}");
    insta::assert_snapshot!(text);
}

#[test]
fn the_text_ends_with_the_command_that_shows_the_mission_on_a_page() {
    let mut summary = summary(&STEPS);
    for (journal, need) in [
        ("out/journal", "out"),
        ("/tmp/my runs/it's/journal", r"'/tmp/my runs/it'\''s'"),
        ("-x/journal", "./-x"),
        ("journal", "./"),
    ] {
        summary.artifacts.insert("journal".into(), PathBuf::from(journal));
        let text = summary.to_string();
        assert_eq!(text.lines().last(), Some(&*format!("On a page, hop by hop: hopper view {need} --open")));
    }
    summary.artifacts.clear();
    assert!(!summary.to_string().contains("hopper view"), "there is nothing to look at");
}

#[test]
fn each_outcome_has_its_sentence() {
    let mut summary = summary(&STEPS);
    for (outcome, need) in [
        (Ending::Mission(Status::Goal), "Goal reached at (3, 3): 7 hops, 15 of 150 steps."),
        (
            Ending::Mission(Status::Deadlock),
            "Out of steps at (3, 3), 0.0 m short of the goal: 7 hops, 15 steps, limit 150.",
        ),
        (Ending::Mission(Status::LeftMap), "Left the map at (3, 3): 7 hops, 15 of 150 steps."),
        (Ending::Mission(Status::Lost), "Lost on impassable ground at (3, 3): 7 hops, 15 of 150 steps."),
        (Ending::Stopped, "Stopped at (3, 3), 0.0 m short of the goal: 7 hops, 15 of 150 steps."),
    ] {
        summary.outcome = outcome;
        assert_eq!(summary.sentence(), need);
        assert_eq!(serde_json::to_value(&summary).unwrap()["outcome"], outcome.as_str());
    }
}

#[test]
fn each_outcome_of_several_robots_has_its_sentence() {
    let mut summary = summary(&STEPS);
    let (cover, reach) = (Some(12), None);
    for (outcome, covered, need) in [
        (Ending::Mission(Status::Goal), cover, "Covered, 12 cells: 9 actions of 4 robots"),
        (Ending::Mission(Status::Goal), reach, "The rover is at the goal, (3, 3): 9 actions of 4 robots"),
        (Ending::Mission(Status::Deadlock), cover, "Out of actions: 9 actions of 4 robots"),
        (Ending::Mission(Status::Lost), cover, "No robot can go on: 9 actions of 4 robots"),
        (Ending::Mission(Status::Lost), reach, "The rover is stuck: 9 actions of 4 robots"),
        (Ending::Stopped, reach, "Stopped: 9 actions of 4 robots"),
    ] {
        summary.outcome = outcome;
        summary.team = Some(TeamEffort { robots: 4, actions: 9, covered, is_mixed: false });
        assert_eq!(summary.sentence(), format!("{need}, at most 15 of 150 each."));
    }
}

/// A rover with a goal, alone with helicopters or beside a hopper, a rover that covers ground and a helicopter; robot 0 has acted
/// twice, robot 1 once.
fn team_summary(has_own_goals: bool, outcome: Status) -> Summary {
    let alone = brief(5);
    let mut records = records(&alone, &STEPS[..3], 2);
    let point = Waypoint { x_m: 1.0, y_m: 1.0 };
    let (driver, helicopter) = (driver(&alone, point), helicopter(&alone));
    let covering = Robot {
        body: Body::Rover(Rover { speed_mps: 1.0 }),
        sensor: Sensor::Square(Square { range_cells: 1 }),
        goal: Goal::Cover(Cover::default()),
        ..driver
    };
    let (account, robots) = match has_own_goals {
        true => (Account::ActionsWithoutWaits, [driver, alone.robots[0], covering, helicopter]),
        false => (Account::Actions, [driver, helicopter, helicopter, helicopter]),
    };
    let brief = with_robots(&alone, account, &robots);
    records[1].robot = RobotId(1);
    let mut builder = SummaryBuilder::new(&brief, 7);
    records.iter().for_each(|record| builder.record(record));
    let standings = [Standing::Active, Standing::Done, Standing::Stranded, Standing::Active];
    let member = |(number, robot): (RobotId, &Robot)| {
        let at = Placement { cell: Cell::new(number.0.into(), 2), heading: Direction::North };
        Member { at, standing: standings[usize::from(number.0)], ..Member::at_start(robot) }
    };
    let state = State { status: outcome, ..state(&records) };
    let team = Team {
        run: brief.run,
        decision: state.decision,
        digest: state.digest,
        due: RobotId(0),
        actor: Some(RobotId(0)),
        members: brief.robots.numbered().map(member).collect(),
    };
    builder.build(&state, Some(&team), &RefusalCounts::default())
}

#[test]
fn each_of_several_robots_is_listed_in_text_and_json() {
    let summary = team_summary(true, Status::Goal);
    let text = summary.to_string();
    for line in [
        "  robot 0     rover, greedy, 2 actions, active at (0, 2)\n",
        "  robot 1     hopper, mdp, 1 action, done at (1, 2)\n",
        "  robot 2     rover, no planner, 0 actions, stranded at (2, 2)\n",
        "  robot 3     helicopter, no planner, 0 actions, active at (3, 2)\n",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
    let json = serde_json::to_value(&summary).unwrap();
    assert_eq!(
        json["robots"][1],
        serde_json::json!({
            "robot": 1, "kind": "hopper", "planner": "mdp", "actions": 1, "status": "done", "cell": { "x": 1, "y": 2 }
        })
    );
    assert_eq!(json["robots"].as_array().unwrap().len(), 4);
    assert_eq!(serde_json::from_value::<Summary>(json).unwrap(), summary);
    let alone = serde_json::to_value(self::summary(&STEPS)).unwrap();
    assert_eq!(alone.get("robots"), None, "a hopper that is alone is not listed");
}

/// Where a rover has the only goal, its end is that of the mission, whatever it is told itself.
#[test]
fn the_only_rover_with_a_goal_ends_as_its_mission_does() {
    for (outcome, need) in [
        (Status::Goal, Standing::Done),
        (Status::Lost, Standing::Stranded),
        (Status::Deadlock, Standing::Active),
    ] {
        assert_eq!(team_summary(false, outcome).robots[0].status, need);
        assert_eq!(team_summary(false, outcome).robots[3].status, Standing::Active, "a helicopter has none");
    }
}

#[test]
fn a_run_that_ends_before_its_mission_is_stopped() {
    assert_eq!(summary(&STEPS[..3]).outcome, Ending::Stopped);
}

#[test]
fn a_run_without_a_decision_is_summed_up_without_a_nan() {
    let brief = brief(5);
    let mut opening = state(&records(&brief, &STEPS[..1], 9));
    (opening.status, opening.digest, opening.visits) = (Status::Underway, contract::Digest([9; 32]), 4);
    let summary = SummaryBuilder::new(&brief, 7).build(&opening, None, &RefusalCounts::default());
    assert_eq!(summary.visits, 4, "cells in which rovers start are covered already");
    assert_eq!((summary.outcome, summary.hops, summary.steps), (Ending::Stopped, 0, 0));
    assert_eq!(summary.digest, opening.digest);
    assert_eq!((summary.cell, summary.distance_to_goal_m), (start(&brief), Some(8_f64.sqrt())));
    let json = serde_json::to_string(&summary).unwrap();
    assert!(!json.contains("NaN"), "{json}");
    assert_eq!(serde_json::from_str::<Summary>(&json).unwrap(), summary);
    assert!(summary.to_string().contains("nothing was measured"));
}

#[test]
fn states_and_records_tell_the_same_tally() {
    let brief = brief(5);
    let records = records(&brief, &STEPS, 5);
    let (mut of_records, mut of_states) = (Tally::new(&brief), Tally::new(&brief));
    for record in &records {
        of_records.fold(&Executed::from(record));
        of_states
            .fold(&Executed::before(&record.state_after(brief.run, MonotonicNs(1), MonotonicNs(2))).unwrap());
    }
    assert_eq!(of_records, of_states);
    assert_eq!((of_records.route.length_m, of_records.distance_to_goal_m()), (6.0, Some(0.0)));
    assert_eq!(of_records.duration_s, 7.0003);
}

#[test]
#[should_panic(expected = "decisions are folded in order")]
fn a_gap_in_the_decisions_is_not_summed_over() {
    let brief = brief(5);
    let records = records(&brief, &STEPS, 5);
    let mut builder = SummaryBuilder::new(&brief, 7);
    builder.record(&records[0]);
    builder.record(&records[2]);
}
