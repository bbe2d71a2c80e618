//! The command line of a planner, and its life in shared memory.

use std::process::ExitCode;

use clap::Parser as _;
use contract::limits::ROBOTS_MAX;
use contract::{RobotId, RobotSet, Role};
use node::peer::PeerArgs;
use node::{Exit, Failure, Instance, Node};
use process::block_on;

use crate::process::{Claim, PlannerProcess};
use crate::usual::UsualAlgorithm;
use crate::{Planner, algorithm};

/// Arguments of `planner` and of `hopper planner`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    #[command(flatten)]
    peer: PeerArgs,
    #[arg(
        long, value_name = "NAME",
        help = format!("Algorithm: {} [default: the usual one of the mission: mdp for a hopper]", crate::listed())
    )]
    algorithm: Option<String>,
    #[command(flatten)]
    claim: ClaimArgs,
}

/// Which robots a planner process commands, and how it takes command.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct ClaimArgs {
    /// Numbers of the robots to command, separated by commas [default: 0].
    #[arg(
        long, env = "HOPPER_ROBOT", hide_env = true, value_parser = robots, default_value = "0",
        hide_default_value = true, value_name = "N,..."
    )]
    pub robot: RobotSet,
    /// Take over from a living planner with the first command, once. Without it this planner stands by
    /// until the one in command dies or hangs.
    #[arg(long)]
    pub takeover: bool,
    /// Take over at once if the planner in command is this process, which is known to be dead.
    #[arg(long, hide = true, env = "HOPPER_SUCCEEDS_PID", hide_env = true)]
    pub succeeds_pid: Option<u32>,
}

/// The command line of a planner of one's own.
#[derive(clap::Parser)]
#[command(
    name = "planner",
    about = "A planner process of Hopper: decides what its robots do next, or stands by."
)]
struct OwnPlanner {
    #[command(flatten)]
    peer: PeerArgs,
    #[command(flatten)]
    claim: ClaimArgs,
}

/// The `main` of a program that is a planner process: parses the command line, joins the instance, and runs the planner
/// that `make` returns until the mission ends. It knows the flags of `hopper planner` but `--algorithm`.
///
/// Exit codes are those of every command of `hopper`.
#[must_use]
pub fn main<P: Planner + 'static>(make: impl FnOnce() -> P) -> ExitCode {
    let OwnPlanner { peer, claim } = OwnPlanner::parse();
    node::main("planner", || fly(&peer, &claim, Box::new(make())))
}

/// Runs the process until the mission ends.
///
/// # Errors
/// If the algorithm is unknown, shared memory fails, or a peer was waited for longer than `--wait`.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let named = |name: &str| algorithm(name).map_err(|error| Failure::new(Exit::Usage, error.to_string()));
    let planner = args.algorithm.as_deref().map(named).transpose()?;
    let mut node = join(&args.peer)?;
    let planner = match planner {
        Some(planner) => planner,
        None => {
            tracing::info!("joined instance {:?}: the mission will tell the algorithm", args.peer.instance);
            let found = block_on(async {
                let mut usual = UsualAlgorithm::join(&mut node, args.claim.robot, args.peer.terms())?;
                let exit = process::run(&mut usual, &mut node).await?;
                Ok::<_, Failure>(usual.name().ok_or(exit))
            })?;
            match found {
                Ok(name) => named(name)?,
                Err(exit) => return Ok(exit),
            }
        }
    };
    run_in(&mut node, &args.peer, &args.claim, planner)
}

/// Runs a process with `planner` until the mission ends.
///
/// # Errors
/// If shared memory fails, or a peer was waited for longer than [`PeerArgs::wait`].
pub fn fly(peer: &PeerArgs, claim: &ClaimArgs, planner: Box<dyn Planner>) -> Result<Exit, Failure> {
    run_in(&mut join(peer)?, peer, claim, planner)
}

fn join(peer: &PeerArgs) -> Result<Node, Failure> {
    Ok(Node::join_with(&Instance::new(&peer.instance)?, Role::Planner, peer.joining())?)
}

fn run_in(
    node: &mut Node,
    peer: &PeerArgs,
    claim: &ClaimArgs,
    planner: Box<dyn Planner>,
) -> Result<Exit, Failure> {
    let name = planner.name();
    let ClaimArgs { robot: robots, takeover, succeeds_pid } = *claim;
    block_on(async {
        let claim = Claim { robots, takeover, succeeds_pid };
        let mut planner = PlannerProcess::join(node, planner, claim, peer.terms()).await?;
        tracing::info!("joined instance {:?} as {name}", peer.instance);
        process::run(&mut planner, node).await
    })
}

/// Robots by their numbers.
fn robots(text: &str) -> Result<RobotSet, String> {
    let need =
        || format!("robots are numbers from 0 to {}, separated by commas; got {text:?}", ROBOTS_MAX - 1);
    let number = |number: &str| number.trim().parse().ok().filter(|&number| usize::from(number) < ROBOTS_MAX);
    text.split(',').try_fold(RobotSet(0), |set, part| Ok(set.with(RobotId(number(part).ok_or_else(need)?))))
}
