//! What a message, a planner, a layer, a body, a goal, a sensor and a motion model that were added by the guides of ARCHITECTURE.md must be able to do.
//! `tests/guides.rs` compiles this against a copy of the tree with all of them added.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test that cannot go on has failed, and tells what it found"
)]

use std::collections::BTreeSet;
use std::num::NonZeroU8;

use contract::message::Visitor;
use contract::wire::{RobotV1, SeenCellV4};
use contract::{
    Account, Brief, Direction, Goal, Message, MonotonicNs, ObservedMap, Request, Robot, RobotId, RunId,
    SeenCell, Status,
};
use hopper_sim::{Attachment, Journal, JournalHeader, Mission};
use lockstep::{Flown, PlannerSchedule};
use scenario::{Scenario, ScenarioError};

/// A slider on the slope of a hollow, at whose lowest cell its goal is.
const SLOPE: &str = r#"
[truth.terrain.gaussians]
width_cells = 9
height_cells = 9
cell_size_m = 1.0
sigma_m = 3.0
amplitude_m = 2.0
lowered_m = [[6.0, 6.0]]

[brief]
profile = "hopper"
goal = [6, 6]

[[robots]]
body = "slider"
start = [1, 2]
"#;

/// Services of the registry.
pub fn registered() -> Vec<String> {
    struct Names(Vec<String>);
    impl Visitor for Names {
        fn message<M: Message>(&mut self) {
            self.0.push(M::SERVICE.name_of(RobotId(0)));
        }

        fn request<Q: Request>(&mut self) {
            self.0.push(Q::SERVICE.name_of(RobotId(0)));
        }
    }
    let mut names = Names(Vec::new());
    contract::wire::visit(&mut names);
    names.0
}

/// Services for which the memory budget has a line.
pub fn budgeted() -> Vec<String> {
    let budget = node::MemoryBudget::of(400, 1).unwrap();
    budget.services.into_iter().map(|service| service.service).collect()
}

/// Topics of the fault simulation, by their short names.
pub fn simulated() -> Vec<String> {
    simulation::stream::Stream::all(simulation::setup::Missions::Rovers)
        .into_iter()
        .map(|topic| topic.as_str().to_owned())
        .collect()
}

/// Services that a recording has as JSON, for want of a schema.
pub fn recorded_as_json() -> Vec<String> {
    struct Names(Vec<String>);
    impl Visitor for Names {
        fn message<M: Message>(&mut self) {
            self.0.extend(recording::JsonMessage::topic::<M>());
        }

        fn request<Q: Request>(&mut self) {}
    }
    let mut names = Names(Vec::new());
    contract::wire::visit(&mut names);
    names.0
}

/// The first mission of a scenario.
fn mission(scenario: Result<Scenario, ScenarioError>) -> Result<Mission, String> {
    let world = scenario.and_then(|scenario| scenario.resolve()).map_err(|error| error.to_string())?;
    let mission = Mission::of(&world, 1);
    Ok(Mission { brief: Brief { run: RunId(1), ..mission.brief }, ..mission })
}

/// The first mission of a built-in scenario.
pub fn built_in(name: &str) -> Mission {
    mission(scenario::load(name)).unwrap()
}

/// A mission whose rovers have the sensor of that code with that parameter; why there is no such sensor, if so.
pub fn sensing(code: u32, parameter: f64) -> Result<Mission, String> {
    let mut mission = built_in("coverage");
    for robot in 0..mission.brief.robots.len() {
        let mut wire = RobotV1::from(&mission.brief.robots[robot]);
        (wire.sensor, wire.sensor_values) = (code, Default::default());
        wire.sensor_values[0] = parameter;
        mission.brief.robots[robot] = Robot::try_from(&wire).map_err(|refusal| refusal.to_string())?;
    }
    Ok(mission)
}

/// Layers of the map that a mission has.
pub fn layers(brief: &Brief) -> Vec<String> {
    report::Layer::of(brief).iter().map(|layer| layer.definition().name.to_owned()).collect()
}

/// Layers whose scales a picture of a mission has.
pub fn layers_in_the_picture(brief: &Brief) -> Vec<String> {
    let picture = report::Picture {
        brief,
        terrain: &[],
        treasures: &[],
        map: &ObservedMap::unseen(brief.run, RobotId(0), brief.grid),
        policy: None,
        route: &[],
        outcome: Status::Underway.into(),
        sensing_radius_m: None,
        speeds: &[],
        announced: &[],
        details: &[],
    };
    let drawn = picture.svg().unwrap();
    let layers = report::Layer::of(brief).into_iter().map(report::Layer::definition);
    let is_drawn = |layer: &&report::layers::Definition| drawn.contains(layer.quantity);
    layers.filter(is_drawn).map(|layer| layer.name.to_owned()).collect()
}

/// Layers that the page is told of a mission.
pub fn layers_on_the_page(brief: &Brief) -> Vec<String> {
    let mut history = monitor::History::new(RobotId(0));
    history.on(monitor::Input::Brief(brief), MonotonicNs(0));
    let frame = history.next(&mut monitor::history::Cursor::default(), MonotonicNs(0)).unwrap();
    let names = frame.data.split("\"name\":\"").skip(1);
    names.map(|rest| rest.split('"').next().unwrap().to_owned()).collect()
}

/// Topics of recordings that show layers.
pub fn layers_recorded() -> Vec<String> {
    let channels = recording::Channel::ALL.iter();
    let layers = channels.filter(|channel| matches!(channel, recording::Channel::ViewLayer(_)));
    layers.map(|channel| channel.name()).collect()
}

/// How `planner` flies a mission in lockstep, or why it cannot.
fn fly(mission: Mission, planner: &str) -> Result<Flown, String> {
    let crew = PlannerSchedule::single(planner.parse().unwrap());
    lockstep::fly(mission, &crew, &mut || MonotonicNs(0), &mut |_| ()).map_err(|error| error.to_string())
}

/// How `planner` ends on the scenario `hard` in lockstep, or why it cannot fly.
pub fn flown(planner: &str) -> Result<String, String> {
    fly(built_in("hard"), planner).map(|flown| flown.state.status.to_string())
}

/// How a slider ends on its slope in lockstep, or why it cannot slide.
pub fn slid() -> Result<String, String> {
    let mission = mission(Scenario::parse(SLOPE, "the slope"))?;
    fly(mission, "downhill").map(|flown| flown.state.status.to_string())
}

/// How a hopper ends on the scenario `hard` that shall stand where nothing in view is higher, and how many of the cells around it are
/// higher; or why it cannot fly.
pub fn climbed() -> Result<String, String> {
    let mut mission = built_in("hard");
    mission.brief.account = Account::ActionsWithoutWaits;
    // The tree itself does not have the goal.
    let goal: Result<Goal, _> = serde_json::from_str(r#"{ "summit": {} }"#);
    mission.brief.robots[0].goal = goal.map_err(|error| error.to_string())?;
    let (grid, terrain) = (mission.brief.grid, mission.terrain.clone());
    let flown = fly(mission, "mdp")?;
    let pose = flown.state.pose;
    let around =
        Direction::ALL.into_iter().filter_map(|direction| terrain.ground(grid.hop(pose.cell, direction)));
    let higher = around.filter(|ground| ground.height_m > pose.height_m).count();
    Ok(format!("{}, higher neighbours: {higher}", flown.state.status))
}

/// How a hopper ends whose hops are blown off the middle of their cells, whether the wind is told of each, and whether the journal that
/// holds it can be resumed; or why it cannot fly.
pub fn blown() -> Result<String, String> {
    let text = "[truth.terrain.gaussians]\nwidth_cells = 9\nheight_cells = 9\ncell_size_m = 1.0\nsigma_m = 1.0\n\
                amplitude_m = 0.1\n[truth.dynamics]\nmodel = \"gust\"\nstrength_mps = 0.5\n\
                [brief]\nprofile = \"hopper\"\nstart = [1, 1]\ngoal = [7, 7]\n";
    let world = Scenario::parse(text, "the wind").and_then(|scenario| scenario.resolve());
    let mission = Mission::of(&world.map_err(|error| error.to_string())?, 1);
    let crew = PlannerSchedule::single("mdp".parse().unwrap());
    let mut records = Vec::new();
    let flown =
        lockstep::fly(mission.clone(), &crew, &mut || MonotonicNs(0), &mut |record| records.push(*record));
    let flown = flown.map_err(|error| error.to_string())?;
    let gust = |record| match flown.attachment(record) {
        Some(Attachment::Detail(detail)) => {
            detail.figures[0] != 0.0 && detail.model.figures() == ["gust_mps"]
        }
        _ => false,
    };
    let all = records.iter().all(gust);
    let (disk, header) = (simulation::disk::Disk::default(), JournalHeader::untold(&mission));
    let mut journal = Journal::create_on(disk.clone(), &header, false).map_err(|error| error.to_string())?;
    for record in &records {
        let attachment = flown.attachment(record);
        journal.append(record, attachment.as_ref()).map_err(|error| error.to_string())?;
    }
    drop(journal);
    let resumed =
        Journal::resume_on(disk, &header, &mission.terrain, false).map_err(|error| error.to_string())?;
    let journalled = resumed.len() == records.len() as u64;
    Ok(format!("{}, a gust for each hop: {all}, journalled: {journalled}", flown.state.status))
}

/// The distinct numbers that sensors have reported of seen cells, and the share of these with one.
pub fn reported(map: &ObservedMap) -> (BTreeSet<u8>, f64) {
    let seen = map.cells().iter().flatten();
    let reported: Vec<u8> = seen.filter_map(|ground| ground.reported).map(NonZeroU8::get).collect();
    (reported.iter().copied().collect(), reported.len() as f64 / map.seen_cells() as f64)
}

/// The same map after its cells have travelled as messages.
pub fn received(map: &ObservedMap) -> ObservedMap {
    let mut received = ObservedMap::unseen(map.run, map.robot, map.grid);
    for (index, ground) in map.cells().iter().enumerate() {
        let Some(ground) = *ground else { continue };
        let sent = SeenCellV4::from(&SeenCell { index: index as u32, visits: map.visits(index), ground });
        let SeenCell { ground, visits, .. } = SeenCell::try_from(&sent).unwrap();
        received.learn_visited(index, ground, visits);
    }
    received
}

/// Prints what it finds, one line a claim.
pub fn main() {
    println!("registered {}", registered().join(" "));
    println!("budgeted {}", budgeted().join(" "));
    println!("simulated {}", simulated().join(" "));
    println!("recorded as JSON {}", recorded_as_json().join(" "));
    let hard = built_in("hard");
    println!("map layers {}", layers(&hard.brief).join(" "));
    println!("layers in the picture {}", layers_in_the_picture(&hard.brief).join(" "));
    println!("layers on the page {}", layers_on_the_page(&hard.brief).join(" "));
    println!("layers recorded {}", layers_recorded().join(" "));
    println!("flown {}", flown("beeline").unwrap_or_else(|why| why));
    println!("slid {}", slid().unwrap_or_else(|why| why));
    println!("climbed {}", climbed().unwrap_or_else(|why| why));
    println!("blown {}", blown().unwrap_or_else(|why| why));
    let sonar = sensing(6, 3.0).unwrap();
    println!("sonar layers {}", layers(&sonar.brief).join(" "));
    println!("sonar layers in the picture {}", layers_in_the_picture(&sonar.brief).join(" "));
    println!("sonar layers on the page {}", layers_on_the_page(&sonar.brief).join(" "));
    let flown = fly(sonar, "cover_frontier").unwrap();
    println!("sonar flown {}", flown.state.status);
    let (numbers, share) = reported(&flown.map);
    println!("sonar reported {} to {}", numbers.first().unwrap(), numbers.last().unwrap());
    println!("sonar share {share}");
    assert_eq!(received(&flown.map).observation(), flown.map.observation());
}
