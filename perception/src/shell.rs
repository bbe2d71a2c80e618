//! The command line of perception, and its life in shared memory.

use node::peer::PeerArgs;
use node::{Exit, Failure, Instance, Node};
use process::block_on;

use contract::{RobotId, Role};

use crate::Cartographer;
use crate::process::Perception;

/// Arguments of `perception` and of `hopper perception`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    #[command(flatten)]
    peer: PeerArgs,
}

/// Runs the process until the mission ends.
///
/// # Errors
/// If shared memory fails, or a peer was waited for longer than `--wait`.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let instance = Instance::new(&args.peer.instance)?;
    let mut node = Node::join_with(&instance, Role::Perception, args.peer.joining())?;
    block_on(async {
        let cartographer = Cartographer::new(RobotId(0));
        let mut perception = Perception::join(&mut node, cartographer, args.peer.terms()).await?;
        tracing::info!("joined instance {:?}", args.peer.instance);
        process::run(&mut perception, &mut node).await
    })
}
