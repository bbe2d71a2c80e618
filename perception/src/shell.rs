//! The perception process: shared memory and clock around the [`Cartographer`].

use contract::{Name, RobotId, Role};
use node::peer::{Attendance, PeerArgs, TICK, accept};
use node::{Exit, Failure, Instance, Node, crash_point};

use terrain::Terrain;

use crate::{Cartographer, Effect, Event};

/// Points at which a test may kill this process: see [`node::crash_point`].
pub const CRASH_POINTS: &[&str] =
    &["perception.joined", "perception.state_received", "perception.sensed", "perception.published"];

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
    let mut terrains = node.terrain_reader()?;
    let mut states = node.state_reader(robot)?;
    let mut past = node.past_client()?;
    let mut maps = None;
    crash_point("perception.joined");
    tracing::info!("joined instance {:?}", args.peer.instance);

    let mut cartographer = Cartographer::new(robot);
    let mut attendance = Attendance::new(&args.peer);
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
            let (run, grid) = (brief.run, brief.grid);
            effects.extend(cartographer.on(Event::Brief(brief), Node::now()));
            if maps.as_ref().is_none_or(|(known, _)| *known != run) {
                // The old run's writer goes first: a service has one map writer.
                drop(maps.take());
                maps = Some((run, node.map_writer(robot, grid.cells())?));
            }
        }
        if let Some(truth) = accept(terrains.newest()) {
            // Heights are relative to the datum already; its absolute elevation is the brief's affair.
            let terrain =
                Terrain { grid: truth.grid, datum_m: 0.0, cells: truth.cells, treasures: truth.treasures };
            effects.extend(cartographer.on(Event::Terrain(truth.run, terrain), Node::now()));
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
                Effect::PublishMap => {
                    let sensed = Node::now();
                    crash_point("perception.sensed");
                    if let Some((_, writer)) = &mut maps {
                        writer.publish(cartographer.stamped_map(sensed, Node::now()))?;
                    }
                    crash_point("perception.published");
                }
                Effect::Finished(status) => attendance.mission_ended(status),
            }
        }
        if let Some((_, writer)) = &mut maps {
            writer.idle()?;
        }
        if attendance.close_turn(&mut node, cartographer.seen(), cartographer.waits_for())? {
            return Ok(Exit::Done);
        }
    }
}
