//! Latency of three processes that hand on state, map and command: bare, and through this crate's ports.
//!
//! `cargo bench -p hopper-node --bench relay [-- --rounds N --hertz HZ --cells N]`, N cells in each patch of the map, at
//! most 1,024, 9 unless told, as the median patch of the paper's missions has; without `--hertz` it runs at
//! full speed, at 1000 and at 100 rounds a second. Bare and ports take turns, three times each, and the
//! medians of their percentiles are reported. Through the ports means domain types, validation of every
//! cell and one wait for all reasons to wake; the difference to bare is what this crate costs.

use std::io::Write;
use std::process::{Child, Command, ExitCode};
use std::time::Duration;

use contract::{
    Action, Cell, Decision, Digest, Grid, Ground, Incarnation, Leader, MapPatch, MonotonicNs, Name, Pose,
    RobotId, Role, RunId, SeenCell, State, Status, Term, Timing,
};
use node::relay::{Relay, Stage};
use node::{Exit, Failure, Instance, Node};
use process::{Membership, Ports, Reader as _, TICK_NS, Terms, Writer as _};

const ROBOT: RobotId = RobotId(0);

/// Longest sleep of a work loop.
const TICK: Duration = Duration::from_nanos(TICK_NS);

/// What every heartbeat says.
const SEEN: (RunId, Decision, Status) = (RunId(1), Decision(0), Status::Underway);

/// Turns of each kind; odd, so that there is a median.
const TURNS: usize = 3;

/// What the three processes run on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Bare,
    Ports,
}

impl Kind {
    const ALL: [(Kind, &'static str); 2] = [(Kind::Bare, "bare"), (Kind::Ports, "ports")];

    fn as_str(self) -> &'static str {
        Self::ALL[self as usize].1
    }
}

struct Arguments {
    rounds: u64,
    cells: u32,
    hertz: Option<f64>,
    /// Of the processes that the bench starts itself: kind, instance and stage.
    stage: Option<(Kind, String, Stage)>,
}

fn main() -> ExitCode {
    node::main("relay", || {
        let arguments = parse()?;
        if let Some((kind, instance, stage)) = &arguments.stage {
            let instance = Instance::new(instance)?;
            match kind {
                Kind::Bare => Relay { instance, cells: arguments.cells as usize }.answer(*stage)?,
                Kind::Ports => answer(&instance, *stage, arguments.cells)?,
            }
            return Ok(Exit::Done);
        }
        writeln!(std::io::stdout(), "pace_hz,kind,rounds,p50_us,p90_us,p99_us")?;
        let paces = arguments.hertz.map_or_else(|| vec![0.0, 1000.0, 100.0], |hertz| vec![hertz]);
        for hertz in paces {
            compare(&arguments, hertz)?;
        }
        Ok(Exit::Done)
    })
}

fn parse() -> Result<Arguments, Failure> {
    let mut arguments = Arguments { rounds: 2000, cells: 9, hertz: None, stage: None };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or_else(|| Failure::usage(format!("{word} needs a value")));
        match word.as_str() {
            "--rounds" => arguments.rounds = value()?.parse().map_err(Failure::usage)?,
            "--cells" => arguments.cells = cells(&value()?)?,
            "--hertz" => arguments.hertz = Some(value()?.parse().map_err(Failure::usage)?),
            "--stage" => {
                let (name, instance) = (value()?, value()?);
                let kind = Kind::ALL.into_iter().find(|(_, known)| *known == name).map(|(kind, _)| kind);
                let kind =
                    kind.ok_or_else(|| Failure::usage(format!("a kind is bare or ports, got {name}")))?;
                arguments.stage = Some((kind, instance, value()?.parse().map_err(Failure::usage)?));
            }
            // What cargo passes on.
            _ => {}
        }
    }
    Ok(arguments)
}

fn cells(text: &str) -> Result<u32, Failure> {
    let most = contract::limits::MAP_PATCH_CELLS as u32;
    let cells = text.parse().ok().filter(|cells| (1..=most).contains(cells));
    cells.ok_or_else(|| {
        Failure::usage(format!("--cells needs 1 to {most}, the most of a patch, got {text:?}"))
    })
}

/// Lets both kinds take turns at one pace, and prints the medians.
fn compare(arguments: &Arguments, hertz: f64) -> Result<(), Failure> {
    let period = if hertz > 0.0 { Duration::from_secs_f64(1.0 / hertz) } else { Duration::ZERO };
    let mut percentiles = [[[0; TURNS]; 3]; 2];
    for turn in 0..TURNS {
        for (kind, _) in Kind::ALL {
            let mut durations = measure(arguments, kind, period)?;
            durations.sort_unstable();
            for (row, share) in percentiles[kind as usize].iter_mut().zip([0.5, 0.9, 0.99]) {
                row[turn] = durations[((durations.len() - 1) as f64 * share) as usize];
            }
        }
    }
    for (kind, name) in Kind::ALL {
        let [p50, p90, p99] = percentiles[kind as usize].map(|mut turns| {
            turns.sort_unstable();
            turns[TURNS / 2] as f64 / 1000.0
        });
        writeln!(std::io::stdout(), "{hertz},{name},{},{p50:.1},{p90:.1},{p99:.1}", arguments.rounds)?;
    }
    Ok(())
}

/// One turn: starts the other two processes and times the rounds, nanoseconds.
fn measure(arguments: &Arguments, kind: Kind, period: Duration) -> Result<Vec<u64>, Failure> {
    let name = format!("relay-{}", std::process::id());
    let instance = Instance::new(&name)?;
    let start = |stage: Stage| {
        Command::new(std::env::current_exe()?)
            .args(["--cells", &arguments.cells.to_string(), "--stage", kind.as_str(), &name, stage.as_str()])
            .spawn()
    };
    let mut children: Vec<Child> =
        [Stage::Map, Stage::Command].map(start).into_iter().collect::<Result<_, _>>()?;
    let durations = match kind {
        Kind::Bare => Relay { instance: instance.clone(), cells: arguments.cells as usize }
            .source(arguments.rounds, period)
            .map_err(Failure::from),
        Kind::Ports => source(&instance, arguments.rounds, period),
    };
    for child in &mut children {
        if durations.is_err() {
            let _ = child.kill();
        }
        child.wait()?;
    }
    instance.clean()?;
    durations
}

fn state(decision: u64, status: Status) -> State {
    State {
        run: RunId(1),
        robot: ROBOT,
        decision: Decision(decision),
        steps: 0,
        status,
        leader: Leader::default(),
        pose: Pose { cell: Cell::new(0, 0), height_m: 0.0 },
        collected: contract::Collected::default(),
        last: None,
        previous: Digest::default(),
        digest: Digest::default(),
        landed: MonotonicNs(0),
        published: MonotonicNs(0),
        visits: 0,
        vetoed: contract::Vetoed::NONE,
        last_origin: contract::Origin::Planner,
        last_vetoed: contract::Vetoed::NONE,
        last_timing: Timing::default(),
    }
}

/// The source of [`Relay::source`], through the ports. Decision 0 has no outcome to carry, so all states do
/// without by never leaving it: the step count is the round.
fn source(instance: &Instance, rounds: u64, period: Duration) -> Result<Vec<u64>, Failure> {
    let mut node = Node::join(instance, Role::HopperSim)?;
    let mut membership = Membership::join(&mut node, Role::HopperSim, Name::NONE, Terms::default())?;
    let mut states = node.writer::<State>(ROBOT)?;
    let mut commands = node.reader::<contract::Command>(ROBOT, true)?;
    while states.readers() == 0 || commands.writers() == 0 {
        std::thread::sleep(Duration::from_millis(5));
    }
    let warm_up = rounds / 10;
    let mut durations = Vec::with_capacity(rounds as usize);
    for round in 0..warm_up + rounds {
        let started = Node::now();
        states.publish(State { steps: round, ..state(0, Status::Underway) })?;
        while commands.newest().is_none_or(|command| command.is_ok_and(|command| command.work != round)) {
            node.sleep(TICK);
            membership.beat(SEEN, Node::now())?;
        }
        let ended = Node::now();
        if round >= warm_up {
            durations.push(ended.since_ns(started));
        }
        let due = started.plus_ns(period.as_nanos() as u64);
        std::thread::sleep(Duration::from_nanos(due.since_ns(Node::now())));
    }
    states.publish(state(0, Status::Lost))?;
    while commands.newest().is_none_or(|command| command.is_ok_and(|command| !command.cut)) {
        node.sleep(TICK);
    }
    Ok(durations)
}

/// The answers of [`Relay::answer`], through the ports.
fn answer(instance: &Instance, stage: Stage, cells: u32) -> Result<(), Failure> {
    match stage {
        Stage::Map => answer_with_maps(instance, cells),
        Stage::Command => answer_with_commands(instance),
    }
}

fn answer_with_maps(instance: &Instance, cells: u32) -> Result<(), Failure> {
    let grid = Grid::new(cells, 1, 1.0, 1).map_err(Failure::usage)?;
    let mut node = Node::join(instance, Role::Perception)?;
    let mut membership = Membership::join(&mut node, Role::Perception, Name::NONE, Terms::default())?;
    let mut states = node.reader::<State>(ROBOT, true)?;
    let mut maps = node.writer::<MapPatch>(ROBOT)?;
    let ground = Ground { height_m: 1.0, gradient: [0.5; 2], ..Ground::FLAT };
    let mut map = MapPatch {
        run: RunId(1),
        robot: ROBOT,
        through: Decision(0),
        digest: Digest::default(),
        more: 0,
        sequence: 0,
        before: 0,
        after: 0,
        sensed: MonotonicNs(0),
        published: MonotonicNs(0),
        grid,
        seen_cells: cells,
        treasures: Vec::new(),
        cells: (0..cells).map(|index| SeenCell { index, visits: 0, ground }).collect(),
    };
    while !node.stop_requested() {
        node.sleep(TICK);
        membership.beat(SEEN, Node::now())?;
        let Some(Ok(state)) = states.newest() else { continue };
        map.sequence = state.steps;
        map.through = Decision(u64::from(state.status.is_over()));
        maps.publish(map.clone())?;
        if state.status.is_over() {
            // What is unread goes with its writer: the end must be heard before.
            while maps.readers() > 0 {
                maps.idle();
                std::thread::sleep(TICK);
            }
            break;
        }
    }
    Ok(())
}

fn answer_with_commands(instance: &Instance) -> Result<(), Failure> {
    let planner: Name = "relay".parse().map_err(Failure::usage)?;
    let mut node = Node::join(instance, Role::Planner)?;
    let mut membership = Membership::join(&mut node, Role::Planner, planner, Terms::default())?;
    let mut maps = node.reader::<MapPatch>(ROBOT, true)?;
    let mut commands = node.writer::<contract::Command>(ROBOT)?;
    while !node.stop_requested() {
        node.sleep(TICK);
        membership.beat(SEEN, Node::now())?;
        let Some(Ok(map)) = maps.newest() else { continue };
        let over = map.through == Decision(1);
        commands.publish(contract::Command {
            run: map.run,
            robot: ROBOT,
            decision: Decision(0),
            digest: map.digest,
            term: Term(1),
            action: Action::Hold,
            observation: 0,
            planner,
            incarnation: Incarnation(1),
            pid: node.pid(),
            work: map.sequence,
            cut: over,
            sensed: map.sensed,
            map_published: map.published,
            planning_started: MonotonicNs(0),
            planning_ended: MonotonicNs(0),
        })?;
        if over {
            while commands.readers() > 0 {
                std::thread::sleep(TICK);
            }
            break;
        }
    }
    Ok(())
}
