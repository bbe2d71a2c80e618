//! The planner process: shared memory and clock around the [`Pilot`].

use std::cell::RefCell;
use std::collections::VecDeque;

use contract::{Decision, Order, Policy, Refusal, RobotId, Role, RunId};
use node::peer::{Attendance, PeerArgs, TICK, accept, refuse};
use node::{Exit, Failure, Instance, Node, crash_point};

use crate::pilot::{Commission, Effect, Event, Pilot};
use crate::{Budget, Planner, Pulse, algorithm};

/// Points at which a test may kill this process: see [`node::crash_point`].
pub const CRASH_POINTS: &[&str] =
    &["planner.joined", "planner.map_received", "planner.planned", "planner.sent"];

/// Arguments of `planner` and of `hopper planner`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    #[command(flatten)]
    peer: PeerArgs,
    /// Algorithm: mdp, greedy, astar, dstar_lite, or hold.
    #[arg(long, default_value = "mdp", value_name = "NAME")]
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
/// If the algorithm is unknown, shared memory fails, or nobody came within `--wait`.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let robot = RobotId(0);
    let mut planner =
        algorithm(&args.algorithm).map_err(|error| Failure::new(Exit::Usage, error.to_string()))?;
    let instance = Instance::new(&args.peer.instance)?;
    let mut node = Node::join(&instance, Role::Planner, planner.name())?;
    if args.peer.lifeline {
        node.hold_lifeline();
    }
    node.listen(&contract::service::map(robot))?;
    let mut briefs = node.brief_reader()?;
    let mut states = node.state_reader(robot)?;
    let mut maps = node.map_reader(robot)?;
    let mut snapshots = node.snapshot_client(robot)?;
    let mut controls = node.control_reader(robot)?;
    let commands = node.command_writer(robot)?;
    let mut policies = node.policy_port(robot)?;
    let mut told = Told::default();
    let mut error_bound = 0.0;
    crash_point("planner.joined");
    tracing::info!("joined instance {:?} as {}", args.peer.instance, planner.name());

    let mut pilot = Pilot::new(Commission {
        robot,
        incarnation: node.incarnation(),
        pid: node.pid(),
        planner: planner.name(),
        takeover: args.takeover,
        succeeds_pid: args.succeeds_pid,
    });
    let mut attendance = Attendance::new(&args.peer, &instance);
    let mut refused = 0;
    loop {
        node.wait(TICK);
        if node.stop_requested().is_some() {
            return Ok(Exit::Interrupted);
        }
        let mut effects = VecDeque::new();
        for beat in node.heartbeats().into_iter().flatten() {
            if attendance.hear(&beat) {
                effects.extend(pilot.on(Event::Heartbeat(beat), Node::now()));
            }
        }
        if let Some(brief) = accept(briefs.newest()) {
            effects.extend(pilot.on(Event::Brief(brief), Node::now()));
        }
        if let Some(state) = accept(states.newest()) {
            effects.extend(pilot.on(Event::State(state), Node::now()));
        }
        // The page first: with it come all patches published before it was made.
        let page = snapshots.receive();
        for patch in maps.drain() {
            crash_point("planner.map_received");
            effects.extend(pilot.on(heard(patch, Event::Patch), Node::now()));
        }
        if let Some(page) = page {
            crash_point("planner.map_received");
            effects.extend(pilot.on(heard(page, Event::Page), Node::now()));
        }
        for control in controls.drain().collect::<Vec<_>>() {
            let Some(control) = accept(Some(control)) else { continue };
            let meant = control.run == pilot.seen().0 && control.robot == robot;
            if meant && control.order == Order::HandOver(node.incarnation()) {
                effects.extend(pilot.on(Event::HandOver, Node::now()));
            }
        }
        if let Some(gone) = pilot.rival_pid().filter(|&pid| !node::host::process_exists(pid)) {
            effects.extend(pilot.on(Event::Gone(gone), Node::now()));
        }
        effects.extend(pilot.on(Event::Tick, Node::now()));
        while let Some(effect) = effects.pop_front() {
            match effect {
                Effect::RequestMap(request) => snapshots.request(&request)?,
                Effect::Plan => {
                    if let Some((further, reached)) = plan(&mut pilot, planner.as_mut(), &mut node) {
                        effects.extend(further);
                        error_bound = reached;
                    }
                }
                Effect::Send(command) => {
                    commands.publish(&command)?;
                    crash_point("planner.sent");
                    // For the eye, and after the command: it may take long, and must not end the mission.
                    if told.is_news(command.run, command.decision, policies.readers())
                        && let Some(policy) = policy(&pilot, planner.as_mut(), error_bound)
                        && let Err(error) = policies.publish(&policy)
                    {
                        tracing::warn!("nobody gets the policy of decision {}: {error}", policy.decision);
                    }
                }
                Effect::Leads(term) => tracing::info!("in command, term {term}"),
                Effect::StepsBack(term) => {
                    tracing::info!("another planner commands, term {term}: standing by")
                }
                Effect::StandsBy(leader) => tracing::info!(
                    "standing by: {} (process {}) commands, term {}",
                    leader.planner,
                    leader.pid,
                    leader.term
                ),
                Effect::Finished(status) => attendance.mission_ended(status),
            }
        }
        tell_of_refusals(&pilot, &mut refused);
        commands.idle()?;
        if attendance.close_turn(&mut node, pilot.seen(), pilot.waits_for())? {
            return Ok(Exit::Done);
        }
    }
}

/// Which policy was told last, and to how many.
#[derive(Clone, Copy, Debug, Default)]
struct Told {
    decision: Option<(RunId, Decision)>,
    readers: usize,
}

impl Told {
    /// Whether somebody is to be told the policy behind a decision: once for each decision, and again if more
    /// listen by then, however often the command is sent.
    fn is_news(&mut self, run: RunId, decision: Decision, readers: usize) -> bool {
        let due = Some((run, decision));
        let news = readers > 0 && (self.decision != due || readers > self.readers);
        if news {
            self.decision = due;
        }
        self.readers = readers;
        news
    }
}

/// A word on patches or pages that were in form, but told of another map than their cells make. Those of
/// another run are counted without a word: between two missions they are to be expected.
fn tell_of_refusals(pilot: &Pilot, told: &mut u64) {
    let count = pilot.map().refusals().of("malformed");
    if count > *told {
        tracing::warn!("{count} messages about the map were malformed or did not add up");
        *told = count;
    }
}

/// A message about the map as the pilot hears it; a malformed one is told, and counted there.
fn heard<T>(message: Result<T, Refusal>, event: impl Fn(T) -> Event) -> Event {
    message.map_or_else(
        |refusal| {
            refuse(&refusal);
            Event::Refused(refusal)
        },
        event,
    )
}

/// Plans between two readings of the clock, beating as the work goes on; gives the plan's error bound beside
/// what is to be done. `None` if there is nothing to plan any more.
fn plan(pilot: &mut Pilot, planner: &mut dyn Planner, node: &mut Node) -> Option<(Vec<Effect>, f64)> {
    let (run, decision, status) = pilot.seen();
    let situation = pilot.situation().filter(|_| pilot.awaits_plan())?;
    let node = RefCell::new(node);
    let beat = || {
        if let Err(error) = node.borrow_mut().beat(run, decision, status) {
            tracing::debug!("beating while planning: {error}");
        }
    };
    let started = Node::now();
    let plan = planner.plan(&situation, &Budget { pulse: Pulse::new(&beat), ..Budget::default() });
    let ended = Node::now();
    crash_point("planner.planned");
    let error_bound = plan.error_bound;
    Some((pilot.on(Event::Planned(plan, started, ended), ended), error_bound))
}

/// The policy behind the command just sent, for the eye.
fn policy(pilot: &Pilot, planner: &mut dyn Planner, error_bound: f64) -> Option<Policy> {
    let situation = pilot.situation()?;
    Some(Policy {
        run: situation.state.run,
        robot: situation.state.robot,
        decision: situation.state.decision,
        planner: planner.name(),
        error_bound,
        cells: planner.policy()?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_policy_is_told_once_a_decision_and_again_to_who_comes_later() {
        let mut told = Told::default();
        let mut is_news = |decision, readers| told.is_news(RunId(1), Decision(decision), readers);
        assert!(!is_news(0, 0), "nobody listens");
        assert!(is_news(0, 1), "the command is sent again, and somebody listens");
        assert!(!is_news(0, 1), "the command is sent again");
        assert!(is_news(0, 2), "one more listens");
        assert!(!is_news(0, 1), "one has gone");
        assert!(is_news(0, 2), "another has come");
        assert!(is_news(1, 2), "the next decision");
        assert!(!is_news(1, 2));
    }
}
