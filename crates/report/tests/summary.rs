//! What programs and people read at the end of a run.

// Helpers of tests are not recognised as tests.
#![allow(clippy::unwrap_used)]

mod mission;

use std::path::PathBuf;

use contract::{Action, Branch, Direction, MonotonicNs, Refusal, RefusalCounts, Role, RunId, State, Status};
use mission::{Step, brief, records};
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
    let mut summary = builder.build(&state(&records), &refusals);
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
    let (cover, scout) = (Some(12), None);
    for (outcome, covered, need) in [
        (Ending::Mission(Status::Goal), cover, "Covered, 12 cells: 9 actions of 4 robots"),
        (Ending::Mission(Status::Goal), scout, "The rover is at the goal, (3, 3): 9 actions of 4 robots"),
        (Ending::Mission(Status::Deadlock), cover, "Out of actions: 9 actions of 4 robots"),
        (Ending::Mission(Status::Lost), cover, "No robot can go on: 9 actions of 4 robots"),
        (Ending::Mission(Status::Lost), scout, "The rover is stuck: 9 actions of 4 robots"),
        (Ending::Stopped, scout, "Stopped: 9 actions of 4 robots"),
    ] {
        summary.outcome = outcome;
        summary.team = Some(TeamEffort { robots: 4, actions: 9, covered, is_mixed: false });
        assert_eq!(summary.sentence(), format!("{need}, at most 15 of 150 each."));
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
    (opening.status, opening.digest) = (Status::Underway, contract::Digest([9; 32]));
    let summary = SummaryBuilder::new(&brief, 7).build(&opening, &RefusalCounts::default());
    assert_eq!((summary.outcome, summary.hops, summary.steps), (Ending::Stopped, 0, 0));
    assert_eq!(summary.digest, opening.digest);
    assert_eq!((summary.cell, summary.distance_to_goal_m), (brief.start, 8_f64.sqrt()));
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
    assert_eq!((of_records.route.length_m, of_records.distance_to_goal_m()), (6.0, 0.0));
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
