//! The perception process: shared memory and clock around the [`Cartographer`].

use contract::{Name, RobotId, Role};
use node::peer::{Attendance, PeerArgs, TICK, accept, refuse};
use node::{Exit, Failure, Instance, Node, crash_point};

use crate::{Cartographer, Effect, Event};

/// Points at which a test may kill this process: see [`node::crash_point`].
pub const CRASH_POINTS: &[&str] = &[
    "perception.joined",
    "perception.state_received",
    "perception.sensed",
    "perception.part_published",
    "perception.published",
];

/// Arguments of `perception` and of `hopper perception`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    #[command(flatten)]
    peer: PeerArgs,
}

/// Runs the process until the mission ends.
///
/// # Errors
/// If shared memory fails, or nobody came within `--wait`.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let robot = RobotId(0);
    let instance = Instance::new(&args.peer.instance)?;
    let mut node = Node::join(&instance, Role::Perception, Name::NONE)?;
    if args.peer.lifeline {
        node.hold_lifeline();
    }
    node.listen(&contract::service::state(robot))?;
    let mut briefs = node.brief_reader()?;
    let mut truths = node.truth_client()?;
    let mut states = node.state_reader(robot)?;
    let mut past = node.past_client()?;
    let maps = node.map_writer(robot)?;
    let mut snapshots = node.snapshot_server(robot)?;
    crash_point("perception.joined");
    tracing::info!("joined instance {:?}", args.peer.instance);

    let mut cartographer = Cartographer::new(robot);
    let mut attendance = Attendance::new(&args.peer, &instance);
    loop {
        node.wait(TICK);
        if node.stop_requested().is_some() {
            return Ok(Exit::Interrupted);
        }
        let mut effects = Vec::new();
        for beat in node.heartbeats().into_iter().flatten() {
            attendance.hear(&beat);
        }
        if let Some(brief) = accept(briefs.newest()) {
            effects.extend(cartographer.on(Event::Brief(brief), Node::now()));
        }
        while let Some(page) = accept(truths.receive()) {
            effects.extend(cartographer.on(Event::Truth(page), Node::now()));
        }
        if let Some(state) = accept(states.newest()) {
            crash_point("perception.state_received");
            effects.extend(cartographer.on(Event::State(state), Node::now()));
        }
        while let Some(page) = accept(past.receive()) {
            effects.extend(cartographer.on(Event::Past(page), Node::now()));
        }
        effects.extend(cartographer.on(Event::Tick, Node::now()));
        for effect in effects {
            match effect {
                Effect::RequestPast(request) => past.request(&request)?,
                Effect::RequestTruth(request) => truths.request(&request)?,
                Effect::PublishMap => {
                    let sensed = Node::now();
                    crash_point("perception.sensed");
                    for patch in cartographer.patches(sensed, &mut Node::now) {
                        maps.publish(&patch)?;
                        crash_point("perception.part_published");
                    }
                    crash_point("perception.published");
                }
                Effect::Refused(refusal) => refuse(&refusal),
                Effect::Finished(status) => attendance.mission_ended(status),
            }
        }
        // After the patches: a page never tells of a landing that is not published.
        for refusal in snapshots.serve(|request| cartographer.page(request))? {
            refuse(&refusal);
        }
        maps.idle()?;
        if attendance.close_turn(&mut node, cartographer.seen(), cartographer.waits_for())? {
            return Ok(Exit::Done);
        }
    }
}
