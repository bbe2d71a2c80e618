//! The command line of a planner, and its life in shared memory.

use contract::Role;
use node::peer::PeerArgs;
use node::{Exit, Failure, Instance, Node};
use process::block_on;

use crate::process::{Claim, PlannerProcess};
use crate::{ALGORITHMS, algorithm};

/// Arguments of `planner` and of `hopper planner`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    #[command(flatten)]
    peer: PeerArgs,
    #[arg(long, default_value = "mdp", value_name = "NAME", help = format!("Algorithm: {}", ALGORITHMS.join(", ")))]
    algorithm: String,
    /// Take over from a living planner with the first command, once. Without it this planner stands by
    /// until the one in command dies or hangs.
    #[arg(long)]
    takeover: bool,
    /// Take over at once if the planner in command is this process, which is known to be dead.
    #[arg(long, hide = true)]
    succeeds_pid: Option<u32>,
}

/// Runs the process until the mission ends.
///
/// # Errors
/// If the algorithm is unknown, shared memory fails, or a peer was waited for longer than `--wait`.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let planner = algorithm(&args.algorithm).map_err(|error| Failure::new(Exit::Usage, error.to_string()))?;
    let name = planner.name();
    let instance = Instance::new(&args.peer.instance)?;
    let mut node = Node::join(&instance, Role::Planner)?;
    if args.peer.lifeline {
        node.hold_lifeline();
    }
    let claim = Claim { takeover: args.takeover, succeeds_pid: args.succeeds_pid };
    block_on(async {
        let mut planner = PlannerProcess::join(&mut node, planner, claim, args.peer.terms()).await?;
        tracing::info!("joined instance {:?} as {name}", args.peer.instance);
        process::run(&mut planner, &mut node).await
    })
}
