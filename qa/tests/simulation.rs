//! Every promise holds over the seeds of continuous integration, and these leave nothing out.

use std::process::Command;

use hopper_qa::simulate::{Campaign, sweep};
use simulation::fault::{Forgery, Plan, points};
use simulation::setup::Missions;
use simulation::simulate;
use simulation::stream::Stream;

/// Simulates so many seeds, and checks that they break no promise. Of a simulation that has passed as it is, a quarter of them is
/// simulated where slow suites are left out; `None` then, since rare events need not come up in so few.
fn unbroken(missions: Missions, seeds: u64) -> Option<Campaign> {
    let in_part = suites::is_left_out("further seeds");
    let campaign = sweep(missions, 0..if in_part { seeds / 4 } else { seeds }, |_| ());
    assert!(campaign.failure.is_none(), "{:#?}", campaign.failure);
    (!in_part).then_some(campaign)
}

/// P-SIMULATED: Under every fault of the simulation, one command is executed per decision, terms
/// only rise, nothing is published that the journal does not hold, no planner knows an unseen cell
/// or decides too early, and the mission ends with the undisturbed digest.
/// P-SIMULATED-ALL: The simulation leaves out no kind of fault, crash point, refusal, takeover or
/// end.
/// P-SIMULATED-RARE: Rare events that could hide a broken promise come up in every long range of
/// seeds, which fails otherwise: a patch between two pages, a map asked for again, a journal
/// replaced while peers live, a slow bidder, turns of two robots reserved at once, a hopper-sim
/// resumed beyond the first page of its past, a second run for peers that stay.
// Long: a list of what the seeds must have covered.
#[test]
fn two_thousand_seeds_of_faults_break_no_promise_and_leave_no_fault_out() {
    let Some(campaign) = unbroken(Missions::Hopper, 2000) else { return };
    assert_eq!(campaign.seeds, 2000);
    let mut expected: Vec<(&str, &str)> = Vec::new();
    let forged: Vec<&str> = Forgery::of(Missions::Hopper).iter().map(|forgery| forgery.as_str()).collect();
    let groups: [(&str, &[&str]); 19] = [
        (
            "fault",
            &[
                "lose",
                "duplicate",
                "delay",
                "reorder",
                "kill",
                "kill_at",
                "stop",
                "stop_at",
                "tear",
                "full",
                "rival",
                "wall_clock",
                "power_loss",
                "new_run",
                "forge",
                "foreign_build",
                "lose_tail",
                "elsewhere",
                "slow",
                "misplaced",
            ],
        ),
        ("killed", &["hopper-sim", "perception", "planner", "monitor"]),
        ("stopped", &["hopper-sim", "perception", "planner", "monitor"]),
        (
            "journal",
            &[
                "resumed",
                "resumed_at_the_end",
                "torn_tail_cut",
                "killed_writing",
                "append_failed",
                "open_failed",
            ],
        ),
        ("refusal", &simulation::REASONS[..14]),
        ("fallback", &["policy", "greedy", "hold"]),
        ("takeover_asked", &["vacancy", "order", "succession", "silence"]),
        ("past_asked", &["sent", "answered"]),
        ("terrain_asked", &["sent", "answered"]),
        ("snapshot_asked", &["sent", "answered"]),
        ("order", &["pause", "resume", "step", "pace", "hand_over"]),
        ("tempo", &["paused", "running"]),
        ("policy", &["published"]),
        ("recording", &["acknowledged"]),
        ("forged", &forged),
        ("map", &["part", "landing"]),
        ("run", &["new", "after_the_end", "announced"]),
        ("left", &["hopper-sim", "perception", "planner", "monitor"]),
        ("ended", &["goal", "deadlock", "lost", "left_map"]),
    ];
    for (group, names) in groups {
        expected.extend(names.iter().map(|name| (group, *name)));
    }
    for kind in ["lose", "duplicate", "delay", "reorder"] {
        expected.extend(Stream::all(Missions::Hopper).into_iter().map(|stream| (kind, stream.as_str())));
    }
    expected.extend(points().into_iter().flat_map(|point| [("killed_at", point), ("stopped_at", point)]));
    let missing: Vec<_> =
        expected.iter().filter(|(group, name)| campaign.coverage.of(group, name) == 0).collect();
    assert!(missing.is_empty(), "never came up: {missing:?} of {:#?}", campaign.coverage);
    let never: Vec<_> = campaign.never().collect();
    assert!(never.is_empty(), "never came up in {} seeds: {never:?}", campaign.seeds);
}

/// Checks that each of these events of a team came up, every fault of every stream, and the rare events that so many seeds have.
fn came_up(missions: Missions, campaign: &Campaign, mut expected: Vec<(&'static str, &'static str)>) {
    for kind in ["lose", "duplicate", "delay", "reorder"] {
        // Planners of teams have no policy.
        let streams = Stream::all(missions).into_iter().map(Stream::as_str);
        expected.extend(streams.filter(|stream| *stream != "policy").map(|stream| (kind, stream)));
    }
    // In a thousand seeds of robots of all kinds these are too rare to be asked for.
    let rare = [("forged", "beyond_budget"), ("refusal", "beyond_budget"), ("duplicate", "terrain_answered")];
    expected.retain(|event| missions != Missions::Mixed || !rare.contains(event));
    expected.retain(|(group, name)| campaign.coverage.of(group, name) == 0);
    assert!(expected.is_empty(), "never came up: {expected:?} of {:#?}", campaign.coverage);
    let never: Vec<_> = campaign.never().collect();
    assert!(never.is_empty(), "never came up in {} seeds: {never:?}", campaign.seeds);
}

/// P-SIMULATED-ROVERS: Under every fault of the simulation, missions of two or three rovers keep
/// the promises of a hopper alone. Turns, clocks, poses, faults of rovers and the share covered are
/// those of the checker's own rules, no two rovers share a cell, terms are counted for each robot,
/// and a command for a robot that is not due is refused.
#[test]
fn two_thousand_seeds_of_several_rovers_break_no_promise_and_leave_no_refusal_out() {
    let Some(campaign) = unbroken(Missions::Rovers, 2000) else { return };
    let mut expected: Vec<(&str, &str)> =
        Forgery::of(Missions::Rovers).iter().map(|forgery| ("forged", forgery.as_str())).collect();
    expected.extend(simulation::REASONS[..16].iter().map(|reason| ("refusal", *reason)));
    expected.extend(["goal", "deadlock", "lost"].map(|end| ("ended", end)));
    came_up(Missions::Rovers, &campaign, expected);
}

/// P-SIMULATED-SCOUTS: Under every fault of the simulation, missions of a rover with one or two
/// helicopters and all planners of both keep the promises of a hopper alone. Turns, waiting,
/// positions, routes, budgets, what is seen and known, and what is done at a deadline are those of
/// the checker's own rules. The journal holds the points of every announced route, only those are
/// served, and every plan is made with the prior of its run and the routes of its decision.
#[test]
fn a_thousand_seeds_of_a_rover_with_helicopters_break_no_promise_and_leave_no_refusal_out() {
    let Some(campaign) = unbroken(Missions::Scouts, 1000) else { return };
    let mut expected: Vec<(&str, &str)> =
        Forgery::of(Missions::Scouts).iter().map(|forgery| ("forged", forgery.as_str())).collect();
    // Helicopters fly above the others, so no cell is occupied. A life that nobody has heard of is rarer than a thousand seeds.
    let reasons =
        simulation::REASONS.into_iter().filter(|reason| !["occupied", "unknown_life"].contains(reason));
    expected.extend(reasons.map(|reason| ("refusal", reason)));
    // So is a drive that the guard would veto while somebody forges one; those of the planners are vetoed often enough.
    expected.retain(|forged| *forged != ("forged", "blocked"));
    expected.extend(["goal", "deadlock", "lost"].map(|end| ("ended", end)));
    expected.extend(
        ["prior_asked", "routes_asked"].into_iter().flat_map(|way| [(way, "sent"), (way, "answered")]),
    );
    came_up(Missions::Scouts, &campaign, expected);
}

/// P-SIMULATED-ACCOMPANIED: Under every fault of the simulation, missions of a hopper with one or
/// two helicopters and all planners of both keep the promises of a hopper alone. State, pose,
/// steps, visits and treasures are the hopper's whichever robot acted, its hops are drawn as those
/// of a hopper alone, with its number, and what either robot sees is known.
#[test]
fn two_thousand_seeds_of_a_hopper_with_helicopters_break_no_promise_and_leave_no_refusal_out() {
    let Some(campaign) = unbroken(Missions::Accompanied, 2000) else { return };
    let mut expected: Vec<(&str, &str)> =
        Forgery::of(Missions::Accompanied).iter().map(|forgery| ("forged", forgery.as_str())).collect();
    // Nobody else stands where a hopper lands, and what the guard forbids it nobody forges here.
    let reasons =
        simulation::REASONS.into_iter().filter(|reason| !["occupied", "unknown_life"].contains(reason));
    expected.extend(reasons.map(|reason| ("refusal", reason)));
    expected.retain(|forged| *forged != ("forged", "blocked"));
    expected.extend(["goal", "deadlock", "lost", "left_map"].map(|end| ("ended", end)));
    expected.extend(["policy", "greedy", "hold"].map(|origin| ("fallback", origin)));
    expected.extend(["sent", "answered"].map(|way| ("routes_asked", way)));
    came_up(Missions::Accompanied, &campaign, expected);
}

/// P-SIMULATED-MIXED: Under every fault of the simulation, missions of two to five robots of any
/// kind, some of them required, with all planners of each, keep the promises of a hopper alone.
/// Turns, clocks, places, routes, draws, occupied cells, stray hops, what each robot sees, which
/// robots are done, what is done at a deadline and how the mission stands are those of the
/// checker's own rules.
#[test]
fn a_thousand_seeds_of_robots_of_all_kinds_break_no_promise_and_leave_no_refusal_out() {
    let Some(campaign) = unbroken(Missions::Mixed, 1000) else { return };
    let mut expected: Vec<(&str, &str)> =
        Forgery::of(Missions::Mixed).iter().map(|forgery| ("forged", forgery.as_str())).collect();
    // A forged command into what is blocked, where something is, and a life that nobody has heard of are rarer than a thousand seeds;
    // planners' own commands are refused as occupied often enough.
    expected.retain(|forged| *forged != ("forged", "blocked"));
    let reasons = simulation::REASONS.into_iter().filter(|reason| *reason != "unknown_life");
    expected.extend(reasons.map(|reason| ("refusal", reason)));
    expected.extend(["goal", "deadlock", "lost", "left_map"].map(|end| ("ended", end)));
    expected.extend(["policy", "greedy", "hold"].map(|origin| ("fallback", origin)));
    expected.extend(
        ["prior_asked", "routes_asked"].into_iter().flat_map(|way| [(way, "sent"), (way, "answered")]),
    );
    came_up(Missions::Mixed, &campaign, expected);
}

/// P-SIMULATED-PROTOCOL: Under every fault of the simulation, missions of a hopper on flat ground
/// whose hops land where they are meant to keep the promises of a hopper alone, by a model that
/// shares no rule with those of other missions.
#[test]
fn a_thousand_seeds_of_the_protocol_alone_break_no_promise() {
    let Some(campaign) = unbroken(Missions::Protocol, 1000) else { return };
    let mut expected: Vec<(&str, &str)> =
        Forgery::of(Missions::Protocol).iter().map(|forgery| ("forged", forgery.as_str())).collect();
    expected.extend(["goal", "deadlock"].map(|end| ("ended", end)));
    expected.extend(["vacancy", "order", "succession", "silence"].map(|cause| ("takeover_asked", cause)));
    came_up(Missions::Protocol, &campaign, expected);
}

/// P-PAST-NAMED. In the first two seeds a stale plan was executed after the journal had lost its
/// tail, since the rover's planner looked at who planned for the helicopter.
/// P-SIMULATED-MIXED. In the third a rover announced the same route again and again, since a robot
/// that still acted stood where each way around it began.
#[test]
fn seeds_that_once_broke_a_promise_break_none() {
    for (missions, seed) in [(Missions::Mixed, 7163), (Missions::Mixed, 9861), (Missions::Mixed, 1213)] {
        let report = simulate(&Plan::of(missions, seed), false);
        assert_eq!(report.violation, None, "seed {seed}");
    }
}

/// P-SIMULATED-TWICE: A seed that is simulated twice gives the same trace to the last line.
#[test]
fn a_seed_simulated_twice_is_the_same_to_the_last_line() {
    let whose = [Missions::Hopper, Missions::Scouts, Missions::Mixed];
    for (missions, seed) in whose.into_iter().flat_map(|of| (0..10).map(move |seed| (of, seed))) {
        let plan = Plan::of(missions, seed);
        let [one, two] = [(); 2].map(|()| simulate(&plan, true));
        assert_eq!(one.trace, two.trace, "seed {seed}");
        assert_eq!((one.events, one.coverage), (two.events, two.coverage), "seed {seed}");
        assert!(one.trace.len() > 10, "seed {seed}");
    }
}

/// P-SIMULATE-COMMAND: `hopper simulate` answers in text and JSON, and refuses bad seed ranges.
#[test]
fn hopper_simulate_answers_in_text_and_json_and_refuses_what_are_no_seeds() {
    let hopper = |words: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hopper-qa"));
        command.arg("simulate").args(words).output().unwrap()
    };
    let json = hopper(&["--seeds", "0..12", "--jobs", "1", "--format", "json"]);
    let answer: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!((json.status.code(), &answer["seeds"]), (Some(0), &12.into()));
    assert!(answer["failure"].is_null() && answer["events"].as_u64().unwrap() > 1000);
    let text = hopper(&["--seeds", "0..12", "--jobs", "2"]);
    let text = String::from_utf8(text.stdout).unwrap();
    assert!(text.contains("12 seeds") && text.contains("no promise was broken"), "{text}");
    for nonsense in ["5", "5..5", "7..3", "a..b", "-1..3"] {
        let refused = hopper(&["--seeds", nonsense]);
        assert_eq!(refused.status.code(), Some(2), "{nonsense}");
    }
}

/// P-SIMULATED-APART: The checker of the simulation computes map, fingerprint, digest, landings,
/// reservations and the answer to each command by its own code, not by the product's.
#[test]
fn the_checker_computes_map_and_digest_without_the_products_code() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../crates/simulation/src/");
    let lists = ["oracle/body", "oracle/goal"].into_iter().flat_map(|list| {
        let files = std::fs::read_dir(format!("{folder}{list}")).unwrap();
        files.map(move |file| format!("{list}/{}", file.unwrap().file_name().display()))
    });
    let others = [
        "checker.rs",
        "checker/dependence.rs",
        "checker/guard.rs",
        "checker/journal.rs",
        "checker/own_way.rs",
        "checker/seen_maps.rs",
        "checker/succession.rs",
        "expected.rs",
        "sensor.rs",
        "sensor/disc.rs",
        "sensor/on_way.rs",
        "sensor/square.rs",
        "claims.rs",
        "offers.rs",
        "reservation.rs",
        "tempo.rs",
        "routes.rs",
        "testing_model.rs",
        "oracle.rs",
        "oracle/actor.rs",
        "oracle/along.rs",
        "oracle/body.rs",
        "oracle/covering.rs",
        "oracle/goal.rs",
        "oracle/parts.rs",
        "oracle/turns.rs",
        "oracle/uncertain.rs",
    ];
    for file in lists.chain(others.map(Into::into)) {
        let source = std::fs::read_to_string(format!("{folder}{file}")).unwrap();
        for of_the_product in [
            "perception::",
            "Observation",
            "ObservedMap",
            "Cartographer",
            "Replica",
            ".chain(",
            "genesis",
            "differences(",
            "learn(",
            "reach_cells",
            "radius_m(",
            "Timeline",
            "TrueGround",
            ".id()",
            ".length_m()",
            "is_under_way",
            "outcome_of_hop",
            "is_drivable",
            "coverage_world",
            "goal.cell(",
            "leg_on(",
            "is_reached_at_start(",
            "cell_of(",
            "goal_after(",
            "is_visit(",
            "RobotTeam",
        ] {
            assert!(!source.contains(of_the_product), "{file} uses {of_the_product}");
        }
    }
}
