//! The guard between planners and the hopper, through real processes.

use std::time::Duration;

use crate::harness::{Mission, eventually, lockstep};
use contract::wire::{CommandV3, HeartbeatV2};
use contract::{
    Action, Command, Direction, Heartbeat, Incarnation, MonotonicNs, RobotId, RobotSet, Role, State, Status,
};
use node::{Instance, Node};
use process::{Ports, Reader as _};
use rustix::process::Signal;

const WEST: Action = Action::Hop(Direction::West);

/// The paper's hard ground in profile hopper, started from the western edge, under a guard.
fn scenario(mission: &Mission, guard: &str) -> String {
    let file = mission.path("guarded.toml");
    let hard = include_str!("../scenarios/hard.toml").replace("paper-2023", "hopper");
    let text = format!("{}\n[guard]\n{guard}\n", hard.replace("start = [1, 2]", "start = [0, 2]"));
    std::fs::write(&file, text).unwrap();
    file.to_string_lossy().into_owned()
}

/// P-FALLBACK-FLOWN: A live mission whose planner is gone is continued by the fallback, and
/// lockstep repeats it.
#[test]
fn a_mission_whose_planner_is_gone_is_flown_on_by_the_fallback_and_repeated_by_lockstep() {
    let mission = Mission::new("fallback");
    let scenario = scenario(&mission, "deadline_s = 0.1");
    let words = ["--scenario", &scenario, "--seed", "3", "--pace", "20"];
    let mut sim = mission.start("sim", &words);
    let _perception = mission.start("perception", &[]);
    let mut planner = mission.start("planner", &[]);
    mission.await_decisions(3);
    planner.kill();
    let fallen = |kind: &str| mission.verified()["fallbacks"][kind].as_u64().unwrap();
    eventually("the last policy to be followed", || fallen("policy") >= 2);
    sim.kill();
    // The next life of hopper-sim knows no policy, and needs no planner to go on greedily.
    let mut sim = mission.start("sim", &words);
    eventually("a greedy hop", || fallen("greedy") >= 2 || mission.verified()["outcome"] != "underway");
    let _planner = mission.start("planner", &[]);
    let code = sim.code();
    let summary = sim.json();
    assert_eq!(code == 0, summary["outcome"] == "goal", "{summary}");
    let verified = mission.verified();
    assert!(fallen("greedy") >= 1, "{verified}");
    for field in ["digest", "fallbacks", "vetoes"] {
        assert_eq!(verified[field], summary[field], "{field}");
    }
    for (field, need) in [("contiguous", true), ("terms_rise", true)] {
        assert_eq!(verified[field], need, "{verified}");
    }
    let again = lockstep(&["--planners-from", mission.journal().to_str().unwrap()]);
    assert_eq!(again["digest"], summary["digest"], "the recorded actions, without a clock");
    assert_eq!(again["fallbacks"], summary["fallbacks"]);
}

/// P-VETO-FLOWN: In a live mission, a hop off the map under a valid term is vetoed, reported and
/// journalled.
#[test]
fn a_planner_that_hops_off_the_map_is_vetoed_told_so_and_journaled() {
    let mission = Mission::new("veto");
    let scenario = scenario(&mission, "hazard_max = 0.25");
    let mut sim = mission.start("sim", &["--scenario", &scenario, "--seed", "3", "--pace", "4"]);
    let _perception = mission.start("perception", &[]);
    let _planner = mission.start("planner", &["--algorithm", "hold"]);
    mission.await_decisions(1);
    let mut node = Node::visit(&Instance::new(&mission.name).unwrap()).unwrap();
    let mut states = node.reader::<State>(RobotId(0), false).unwrap();
    let mut commands = node.writer::<Command>(RobotId(0)).unwrap();
    let mut beats = node.writer::<Heartbeat>(RobotId(0)).unwrap();
    let mut counter = 0;
    eventually("a veto", || {
        node.sleep(Duration::from_millis(5));
        let Some(state) = states.newest().map(Result::unwrap) else { return false };
        // No decision is kept for a planner that nobody has heard.
        counter += 1;
        let beat = Heartbeat {
            role: Role::Planner,
            incarnation: Incarnation(0xbad),
            pid: std::process::id(),
            version: node::version(),
            planner: "rogue".parse().unwrap(),
            counter,
            run: state.run,
            decision: state.decision,
            status: Status::Underway,
            robots: RobotSet::default(),
        };
        beats.publish_wire((), &[HeartbeatV2::from(&beat)]).unwrap();
        // It asks for the next term, is too late, and has the next decision kept for it.
        let order = Command {
            run: state.run,
            robot: state.robot,
            decision: state.decision,
            digest: state.digest,
            term: state.leader.term.next(),
            action: WEST,
            observation: 1,
            planner: "rogue".parse().unwrap(),
            incarnation: Incarnation(0xbad),
            pid: std::process::id(),
            work: 0,
            cut: false,
            sensed: MonotonicNs(1),
            map_published: MonotonicNs(1),
            planning_started: MonotonicNs(1),
            planning_ended: MonotonicNs(1),
        };
        commands.publish_wire((), &[CommandV3::from(&order)]).unwrap();
        state.vetoed.has(WEST)
    });
    eventually("the veto to be journaled", || mission.verified()["vetoes"].as_u64() >= Some(1));
    sim.signal(Signal::TERM);
    assert_eq!(sim.code(), 130, "{}", sim.log());
    let summary = sim.json();
    assert!(summary["refusals"]["vetoed"].as_u64() >= Some(1), "{summary}");
    assert_eq!((&summary["hops"], &summary["cell"]["x"]), (&0.into(), &0.into()), "{summary}");
}
