//! A rogue process writes what it should not beside a real mission: refused, counted, it moves nothing.

use std::time::Duration;

use crate::harness::{Mission, Process, eventually, lockstep};
use bytemuck::Zeroable;
use contract::wire::{
    BriefV10, CommandV3, HeartbeatV2, MapPatchV2, MapRequestV1, PastRequestV1, PolicyCellV1, PolicyHeaderV1,
    RobotV1, SeenCellV4, StateV4, TruthRequestV1, brief_from_wire,
};
use contract::{
    Account, Action, Body, Brief, Command, Cover, Decision, Digest, Direction, Goal, Ground, Heartbeat,
    Incarnation, MapPage, MapPatch, MapRequest, MonotonicNs, Name, ObservedMap, PastRequest, Policy, Refusal,
    RobotId, RobotSet, Role, Rover, SeenCell, Sensor, Square, State, Status, TruthRequest,
};
use hostile::{extremes, fixtures};
use node::{Instance, Node, Reader, Writer};
use process::{Ports, Reader as _, Server as _, Writer as _};
use rustix::process::Signal;
use serde_json::Value;

const ROBOT: RobotId = RobotId(0);

/// One that joined the instance without a role.
struct Rogue {
    node: Node,
    states: Reader<State>,
    commands: Writer<Command>,
}

impl Rogue {
    fn new(mission: &Mission) -> Self {
        let mut node = Node::visit(&Instance::new(&mission.name).unwrap()).unwrap();
        let states = node.reader(ROBOT, false).unwrap();
        let commands = node.writer(ROBOT).unwrap();
        Self { node, states, commands }
    }

    /// The state in which the hopper has just landed: a whole flight is left before the next.
    fn landing(&mut self) -> State {
        let mut before = None::<Decision>;
        let mut landed = None;
        eventually("a landing", || {
            self.node.sleep(Duration::from_millis(5));
            for state in self.states.drain().into_iter().map(Result::unwrap) {
                landed = before.is_some_and(|before| before < state.decision).then_some(state);
                before = Some(state.decision);
            }
            landed.is_some()
        });
        landed.unwrap()
    }

    /// A command that would be obeyed at `state` if it came from the planner in command.
    fn command(state: &State) -> CommandV3 {
        CommandV3::from(&Command {
            run: state.run,
            robot: ROBOT,
            decision: state.decision,
            digest: state.digest,
            term: state.leader.term,
            action: Action::Hop(Direction::West),
            observation: 7,
            planner: "rogue".parse().unwrap(),
            incarnation: Incarnation(0xbad),
            pid: std::process::id(),
            work: 1,
            cut: false,
            sensed: MonotonicNs(1),
            map_published: MonotonicNs(2),
            planning_started: MonotonicNs(3),
            planning_ended: MonotonicNs(4),
        })
    }

    fn send(&mut self, commands: impl IntoIterator<Item = CommandV3>) {
        for command in commands {
            self.commands.publish_wire((), &[command]).unwrap();
        }
    }
}

/// Ends a slow hopper-sim in good order; its summary.
fn stop(sim: &mut Process) -> Value {
    sim.signal(Signal::TERM);
    assert_eq!(sim.code(), 130, "{}", sim.log());
    sim.json()
}

/// Lets another hopper-sim finish the journal; the digest is that of the undisturbed mission, and only
/// planners of the stack commanded.
fn assert_nothing_moved(mission: &Mission, seed: &str) {
    let mut sim = mission.start("sim", &["--seed", seed]);
    assert_eq!(sim.code(), 0, "{}", sim.log());
    let summary = sim.json();
    assert_eq!(summary["digest"], lockstep(&["--seed", seed])["digest"], "{summary}");
    let verified = mission.verified();
    assert_eq!((&verified["contiguous"], &verified["duplicates"]), (&true.into(), &0.into()));
    for planner in summary["planners"].as_array().unwrap() {
        assert_eq!(planner["name"], "mdp", "{summary}");
    }
}

/// P-ROGUE: Commands out of turn from a rogue process are refused, counted by reason, and move
/// nothing.
///
/// A stale or leaping term, a repeated or future decision, a wrong run or robot: refused, counted.
#[test]
fn commands_out_of_turn_are_refused_by_name_and_nothing_moves() {
    let mission = Mission::new("turn");
    let mut sim = mission.start_slow_sim("41");
    let _perception = mission.start("perception", &[]);
    let _monitor = mission.start("monitor", &[]);
    // A second term, so that the first is stale: the heir of a planner that was killed.
    let mut leader = mission.start("planner", &[]);
    leader.await_log("in command");
    mission.await_decisions(1);
    leader.kill();
    let heir = mission.start("planner", &[]);
    heir.await_log("in command, term 2");

    let mut rogue = Rogue::new(&mission);
    let state = rogue.landing();
    assert_eq!((state.leader.term.0, state.decision.0 > 0), (2, true));
    let valid = Rogue::command(&state);
    // Each reason another number of times, fewer than a queue holds.
    rogue.send([
        CommandV3 { term: 1, ..valid },
        CommandV3 { term: 4, ..valid },
        CommandV3 { term: 1 << 30, ..valid },
        CommandV3 { decision: valid.decision + 1, ..valid },
        CommandV3 { decision: valid.decision + 2, term: 3, ..valid },
        CommandV3 { decision: valid.decision + 1_000_000, ..valid },
        CommandV3 { run: [valid.run[0], !valid.run[1]], ..valid },
        CommandV3 { run: [0, 0], ..valid },
        CommandV3 { run: [valid.run[1], valid.run[0]], ..valid },
        CommandV3 { run: [u64::MAX; 2], term: 3, ..valid },
        CommandV3 { robot: 1, ..valid },
        CommandV3 { robot: 70_000, ..valid },
        CommandV3 { decision: valid.decision - 1, ..valid },
        // The very life and name of the planner in command, for a decision that is taken.
        CommandV3 {
            decision: 0,
            incarnation: state.leader.incarnation.0,
            planner: state.leader.planner.bytes(),
            ..valid
        },
        // The term in force, which the rogue does not hold.
        valid,
    ]);
    mission.await_decisions(state.decision.0 + 2);
    let refusals = stop(&mut sim)["refusals"].take();
    for (reason, count) in [
        ("stale_term", 1),
        ("future_term", 2),
        ("future_decision", 3),
        ("wrong_run", 4),
        ("wrong_robot", 2),
        ("not_leader", 1),
    ] {
        assert_eq!(refusals[reason], count, "{reason} in {refusals}");
    }
    // The leader repeats itself too when its command crosses the landing.
    assert!(refusals["repeated_decision"].as_u64().unwrap() >= 2, "{refusals}");
    assert_nothing_moved(&mission, "41");
}

/// P-ROGUE-FIELDS: Commands with impossible fields are refused as malformed, counted, and move
/// nothing.
///
/// Unknown tags, zeros and numbers out of range are refused as malformed.
#[test]
fn commands_with_impossible_fields_are_refused_as_malformed_and_nothing_moves() {
    let mission = Mission::new("fields");
    let mut sim = mission.start_slow_sim("42");
    let _peers = mission.start_peers();
    let mut rogue = Rogue::new(&mission);
    let state = rogue.landing();
    // Were it not for its field, each would take over.
    let valid = CommandV3 { term: state.leader.term.0 + 1, ..Rogue::command(&state) };
    let zero = CommandV3 {
        run: [0; 2],
        decision: 0,
        term: 0,
        incarnation: 0,
        observation: 0,
        work: 0,
        sensed_ns: 0,
        map_published_ns: 0,
        planning_started_ns: 0,
        planning_ended_ns: 0,
        robot: 0,
        action: 0,
        pid: 0,
        cut: 0,
        planner: [0; Name::BYTES],
        digest: [0; 32],
        route: 0,
    };
    let malformed = [
        zero,
        CommandV3 { action: 13, ..valid },
        CommandV3 { action: 1, route: 5, ..valid },
        CommandV3 { action: 99, ..valid },
        CommandV3 { action: u32::MAX, ..valid },
        CommandV3 { term: 0, ..valid },
        CommandV3 { term: u64::MAX, ..valid },
        CommandV3 { decision: u64::MAX, ..valid },
        CommandV3 { incarnation: 0, ..valid },
        CommandV3 { cut: 2, ..valid },
        CommandV3 { planning_ended_ns: valid.planning_started_ns - 1, ..valid },
        CommandV3 { planner: [0; Name::BYTES], ..valid },
        CommandV3 { planner: [0xff; Name::BYTES], ..valid },
    ];
    rogue.send(malformed);
    mission.await_decisions(state.decision.0 + 2);
    let summary = stop(&mut sim);
    assert_eq!(summary["refusals"]["malformed"], malformed.len() as u64, "{summary}");
    assert_eq!(summary["planners"].as_array().unwrap().len(), 1, "{summary}");
    assert_nothing_moved(&mission, "42");
}

/// P-ROGUE-BEAT: Rogue heartbeats neither crash nor stall any process, and a forged one cannot
/// silence a live process.
#[test]
fn rogue_heartbeats_crash_and_stall_nobody() {
    let mission = Mission::new("beats");
    let mut sim = mission.start_slow_sim("43");
    let mut peers = mission.start_peers();
    let mut rogue = Rogue::new(&mission);
    let state = rogue.landing();
    let mut beats = rogue.node.writer::<Heartbeat>(ROBOT).unwrap();
    let valid = HeartbeatV2::from(&Heartbeat {
        role: Role::Monitor,
        incarnation: Incarnation(0xbad),
        pid: std::process::id(),
        version: node::version(),
        planner: Name::NONE,
        counter: 1,
        run: state.run,
        decision: state.decision,
        status: Status::Underway,
        robots: RobotSet::default(),
    });
    for beat in [
        HeartbeatV2 { incarnation: 0, ..valid },
        HeartbeatV2 { role: 0, ..valid },
        HeartbeatV2 { role: u32::MAX, ..valid },
        HeartbeatV2 { status: 77, ..valid },
        HeartbeatV2 { version: [0xff; Name::BYTES], ..valid },
        HeartbeatV2 { planner: [0x80; Name::BYTES], ..valid },
        // Nothing wrong with these but what they say.
        HeartbeatV2 { counter: u64::MAX, decision: u64::MAX, ..valid },
        HeartbeatV2 { incarnation: 1, run: [u64::MAX; 2], status: Status::Goal.code(), pid: 0, ..valid },
        HeartbeatV2 { incarnation: 2, role: Role::HopperSim.code(), decision: u64::MAX, ..valid },
        HeartbeatV2 { incarnation: 3, role: Role::Planner.code(), counter: u64::MAX, ..valid },
    ] {
        beats.publish_wire((), &[beat]).unwrap();
    }
    mission.await_decisions(state.decision.0 + 2);
    for process in peers.iter_mut().chain([&mut sim]) {
        assert!(process.has_ended().is_none(), "{} ended: {}", process.role, process.log());
    }
    drop((beats, rogue));
    stop(&mut sim);
    assert_nothing_moved(&mission, "43");
    for peer in &mut peers {
        assert_eq!(peer.code(), 0, "{}: {}", peer.role, peer.log());
    }
}

/// P-OLD-PLANNER: A planner of a release too old to check builds is reported with both versions,
/// and its commands are ignored.
#[test]
fn a_planner_of_an_older_release_is_told_with_both_versions_and_not_heard() {
    let mission = Mission::new("older");
    let mut sim = mission.start_slow_sim("44");
    let perception = mission.start("perception", &[]);
    let mut leader = mission.start("planner", &[]);
    let mut rogue = Rogue::new(&mission);
    let state = rogue.landing();
    // Nobody commands any more: whoever asks for the next term would have it.
    leader.kill();
    let mut due = state;
    eventually("the last hop to land", || {
        rogue.node.sleep(Duration::from_millis(5));
        due = rogue.states.drain().into_iter().fold(due, |_, state| state.unwrap());
        mission.decisions() == due.decision.0
    });
    let mut beats = rogue.node.writer::<Heartbeat>(ROBOT).unwrap();
    let beat = |counter| {
        HeartbeatV2::from(&Heartbeat {
            role: Role::Planner,
            incarnation: Incarnation(0xbad),
            pid: std::process::id(),
            version: "0.0.9".parse().unwrap(),
            planner: "rogue".parse().unwrap(),
            counter,
            run: due.run,
            decision: due.decision,
            status: Status::Underway,
            robots: RobotSet::default(),
        })
    };
    let told = format!(
        "planner (process {}) is version 0.0.9, this process is version {}",
        std::process::id(),
        node::version()
    );
    let mut counter = 0;
    for process in [&sim, &perception] {
        eventually("the older release to be told", || {
            counter += 1;
            beats.publish_wire((), &[beat(counter)]).unwrap();
            process.log().contains(&told)
        });
    }
    let command = Rogue::command(&due);
    rogue.send([CommandV3 { term: due.leader.term.0 + 1, ..command }]);
    // Three states later nothing has moved.
    for _ in 0..3 {
        let mut told = None;
        eventually("the state to be told again", || {
            rogue.node.sleep(Duration::from_millis(5));
            told = rogue.states.drain().into_iter().fold(None, |_, state| Some(state.unwrap()));
            told.is_some()
        });
        assert_eq!(told.unwrap().decision, due.decision);
    }
    drop(beats);
    let mut heir = mission.start("planner", &[]);
    heir.await_log("in command");
    let summary = stop(&mut sim);
    assert_eq!(summary["refusals"]["malformed"], 1, "{summary}");
    drop(rogue);
    assert_nothing_moved(&mission, "44");
    assert_eq!(heir.code(), 0, "{}", heir.log());
}

/// The first patch of a mission, as perception might write it: a planner would decide on it.
fn first_patch(brief: &Brief) -> MapPatch {
    let index = brief.grid.index(brief.robots[0].start.cell).unwrap();
    MapPatch {
        run: brief.run,
        robot: ROBOT,
        through: Decision(0),
        digest: Digest::genesis(&brief.scenario_hash, 44, brief.profile, ROBOT),
        more: 0,
        sequence: 1,
        before: 0,
        after: ObservedMap::unseen(brief.run, ROBOT, brief.grid).step(index, &Ground::FLAT, 0),
        sensed: MonotonicNs(1),
        published: MonotonicNs(2),
        grid: brief.grid,
        seen_cells: 1,
        treasures: Vec::new(),
        cells: vec![SeenCell { index: index as u32, visits: 0, ground: Ground::FLAT }],
    }
}

/// A page that tells of another map than it says.
fn forged_page(honest: &MapPatch, request: &MapRequest) -> MapPage {
    let MapPatch { run, robot, through, digest, sequence, sensed, published, grid, cells, treasures, .. } =
        honest.clone();
    let next = grid.cells() as u32;
    let observation = 0xbad;
    let (from, cells) = if request.from == 0 { (0, cells) } else { (request.from, Vec::new()) };
    MapPage {
        run,
        robot,
        through,
        digest,
        sequence,
        observation,
        sensed,
        published,
        grid,
        from,
        next,
        treasures,
        cells,
    }
}

/// P-ROGUE-MAP: Patches and pages with NaN, cells off the map or wrong sums are refused and
/// counted; patches out of sequence are resolved by pages; the mission continues.
#[test]
fn rogue_patches_and_pages_are_refused_and_the_mission_flies_on() {
    let mission = Mission::new("nan");
    let mut sim = mission.start("sim", &["--seed", "44"]);
    let mut peers = ["planner", "monitor"].map(|role| mission.start(role, &[]));
    peers.iter().for_each(|peer| peer.await_log("joined"));
    let mut node = Node::visit(&Instance::new(&mission.name).unwrap()).unwrap();
    let mut briefs = node.reader::<Brief>(ROBOT, false).unwrap();
    let mut brief = None;
    eventually("the brief", || {
        node.sleep(Duration::from_millis(5));
        brief = briefs.newest().map(Result::unwrap);
        brief.is_some()
    });
    let mut maps = node.writer::<MapPatch>(ROBOT).unwrap();
    let mut snapshots = node.server::<MapRequest>(ROBOT).unwrap();
    let honest = first_patch(&brief.unwrap());
    let (header, cell) = (MapPatchV2::from(&honest), SeenCellV4::from(&honest.cells[0]));
    let patches = [
        (header, SeenCellV4 { height_m: f64::NAN, ..cell }),
        (header, SeenCellV4 { gradient: [f64::INFINITY; 2], ..cell }),
        (header, SeenCellV4 { index: 400, ..cell }),
        (header, SeenCellV4 { index: u32::MAX, ..cell }),
        (header, SeenCellV4 { soil: 9, ..cell }),
        (MapPatchV2 { cell_size_m: f64::NAN, ..header }, cell),
        (MapPatchV2 { width: u32::MAX, ..header }, cell),
        (MapPatchV2 { sequence: u64::MAX, ..header }, cell),
        (MapPatchV2 { through: u64::MAX, ..header }, cell),
        (MapPatchV2 { treasure_count: 99, ..header }, cell),
        // In form, but they do not add up.
        (MapPatchV2 { sequence: 2, ..header }, cell),
        (MapPatchV2 { sequence: 0, ..header }, cell),
        (MapPatchV2 { before: 5, ..header }, cell),
        (MapPatchV2 { after: header.after ^ 1, ..header }, cell),
        (header, SeenCellV4 { height_m: 1.0, ..cell }),
        (MapPatchV2 { treasure_count: 1, treasures: [[0; 2]; 16], ..header }, cell),
    ];
    let mut pages = 0;
    eventually("the planner to refuse patches and pages", || {
        for (header, cell) in patches {
            maps.publish_wire(header, &[cell]).unwrap();
            node.sleep(Duration::from_millis(1));
        }
        snapshots
            .serve(|request| {
                pages += 1;
                Some(forged_page(&honest, request))
            })
            .unwrap();
        let log = peers[0].log();
        let named = ["cell.height_m", "cell.index", "cell.soil", "map.grid", "map.sequence", "map.through"];
        pages > 3 && named.iter().all(|field| log.contains(field)) && log.contains("messages about the map")
    });
    assert!(!peers[0].log().contains("in command"), "{}", peers[0].log());
    drop((maps, snapshots, briefs, node));
    let mut perception = mission.start("perception", &[]);
    assert_eq!(sim.code(), 0, "{}", sim.log());
    assert_eq!(sim.json()["digest"], lockstep(&["--seed", "44"])["digest"]);
    for peer in peers.iter_mut().chain([&mut perception]) {
        assert_eq!(peer.code(), 0, "{}: {}", peer.role, peer.log());
    }
}

/// P-ONE-MAP: Brief, state and map have one writer each, and past, truth and snapshot one server; a
/// second is refused by name.
#[test]
fn a_second_writer_of_what_has_one_is_refused_by_name() {
    let mission = Mission::new("maps");
    let _sim = mission.start_slow_sim("45");
    let _peers = mission.start_peers();
    mission.await_decisions(1);
    let mut node = Node::visit(&Instance::new(&mission.name).unwrap()).unwrap();
    let refusals = [
        ("hop/brief", node.writer::<Brief>(ROBOT).err()),
        ("hop/state", node.writer::<State>(ROBOT).err()),
        ("hop/map", node.writer::<MapPatch>(ROBOT).err()),
        ("hop/past", node.server::<PastRequest>(ROBOT).err()),
        ("truth/terrain", node.server::<TruthRequest>(ROBOT).err()),
        ("hop/snapshot", node.server::<MapRequest>(ROBOT).err()),
    ];
    for (service, error) in refusals {
        let error = error.unwrap_or_else(|| panic!("{service} takes a second writer")).to_string();
        assert!(error.contains(service), "{error}");
    }
    let decisions = mission.decisions();
    mission.await_decisions(decisions + 1);
}

/// Waits until hopper-sim has read everything that was sent until now; how many `markers` that took. A marker
/// repeats a decision that is taken, so that the state is published again; between two publications hopper-sim
/// reads its commands at least once.
fn settle(rogue: &mut Rogue, marker: CommandV3) -> u64 {
    rogue.states.drain();
    let (mut markers, mut heard) = (0, 0);
    while heard < 2 {
        rogue.send([marker]);
        markers += 1;
        eventually("hopper-sim to go round", || {
            rogue.node.sleep(Duration::from_millis(2));
            let states = rogue.states.drain().len();
            heard += states;
            states > 0
        });
    }
    markers
}

/// P-ROGUE-EXTREMES: A rogue that sends every message it can (commands, heartbeats, policies,
/// requests) with every field at every extreme moves nothing, and is counted.
// Long: one mission serves every message in turn.
#[test]
fn every_field_at_every_extreme_moves_nothing_and_is_counted() {
    let mission = Mission::new("extremes");
    let mut sim = mission.start_slow_sim("46");
    let mut peers = mission.start_peers();
    let mut rogue = Rogue::new(&mission);
    let state = rogue.landing();

    // Under the term in force, which the rogue does not hold; fewer at a time than a queue holds.
    let commands = extremes::of(&Rogue::command(&state));
    let marker = CommandV3 { decision: 0, ..Rogue::command(&state) };
    let mut markers = 0;
    for some in commands.chunks(6) {
        rogue.send(some.iter().copied());
        markers += settle(&mut rogue, marker);
    }
    let malformed =
        |refusal: Option<Refusal>| usize::from(refusal.is_some_and(|why| why.reason() == "malformed"));
    let malformed_commands =
        commands.iter().map(|wire| malformed(Command::try_from(wire).err())).sum::<usize>();
    let mut need = malformed_commands;

    let honest = Heartbeat {
        role: Role::Monitor,
        incarnation: Incarnation(0xbad),
        pid: std::process::id(),
        version: "0.1.0".parse().unwrap(),
        planner: Name::NONE,
        counter: 1,
        run: state.run,
        decision: state.decision,
        status: Status::Underway,
        robots: RobotSet::default(),
    };
    let beats = extremes::of(&HeartbeatV2::from(&honest));
    let mut writer = rogue.node.writer::<Heartbeat>(ROBOT).unwrap();
    for some in beats.chunks(8) {
        some.iter().for_each(|beat| writer.publish_wire((), &[*beat]).unwrap());
        markers += settle(&mut rogue, marker);
    }
    need += beats.iter().map(|beat| malformed(Heartbeat::try_from(beat).err())).sum::<usize>();

    let (run, robot) = (state.run, ROBOT);
    let mut past = rogue.node.client::<PastRequest>(ROBOT).unwrap();
    for wire in extremes::of(&PastRequestV1::from(&PastRequest { run, robot, from: Decision(0) })) {
        past.request_wire(wire).unwrap();
        let wrong = malformed(PastRequest::try_from(&wire).err());
        markers += if wrong > 0 { settle(&mut rogue, marker) } else { 0 };
        need += wrong;
    }
    let mut truth = rogue.node.client::<TruthRequest>(ROBOT).unwrap();
    for wire in extremes::of(&TruthRequestV1::from(&TruthRequest { run, from: 0 })) {
        truth.request_wire(wire).unwrap();
    }
    // Perception answers these.
    let mut snapshot = rogue.node.client::<MapRequest>(robot).unwrap();
    for wire in extremes::of(&MapRequestV1::from(&MapRequest { run, robot, from: 0, observation: 1 })) {
        snapshot.request_wire(wire).unwrap();
    }
    // Nobody acts upon a policy.
    let mut policies = rogue.node.writer::<Policy>(robot).unwrap();
    let (header, cell) = (PolicyHeaderV1::zeroed(), PolicyCellV1 { value: 1.0, action: 1, reserved: 0 });
    extremes::of(&header).iter().for_each(|header| policies.publish_wire(*header, &[cell]).unwrap());
    extremes::of(&cell).iter().for_each(|cell| policies.publish_wire(header, &[*cell; 4]).unwrap());

    for process in peers.iter_mut().chain([&mut sim]) {
        assert!(process.has_ended().is_none(), "{} ended: {}", process.role, process.log());
    }
    drop((writer, past, truth, snapshot, policies, rogue));
    let decisions = mission.decisions();
    mission.await_decisions(decisions + 1);
    let summary = stop(&mut sim);
    let refusals = &summary["refusals"];
    assert_eq!(refusals["malformed"], need, "{refusals}");
    let counted: u64 = refusals.as_object().unwrap().values().filter_map(Value::as_u64).sum();
    // The planner in command repeats itself when its command crosses the landing.
    assert!(
        counted >= (commands.len() + need - malformed_commands) as u64 + markers,
        "{markers} markers: {refusals}"
    );
    assert_nothing_moved(&mission, "46");
    for peer in &mut peers {
        assert_eq!(peer.code(), 0, "{}: {}", peer.role, peer.log());
    }
}

/// P-ROGUE-SIM: A rogue in place of hopper-sim ends no process, whatever brief and state it sends.
#[test]
fn a_rogue_in_the_place_of_hopper_sim_ends_nobody() {
    let mission = Mission::new("impostor");
    let mut peers = mission.start_peers();
    peers.iter().for_each(|peer| peer.await_log("joined"));
    let mut node = Node::visit(&Instance::new(&mission.name).unwrap()).unwrap();
    let (mut briefs, mut states) =
        (node.writer::<Brief>(ROBOT).unwrap(), node.writer::<State>(ROBOT).unwrap());
    let (brief, flown) = (fixtures::brief(), fixtures::flown().1);
    let pause = || std::thread::sleep(Duration::from_millis(1));
    let robot = RobotV1::from(&brief.robots[0]);
    for wire in extremes::of(&BriefV10::from(&brief)) {
        // A grid that is another's takes room in shared memory, which is not what this is about.
        if brief_from_wire(&wire, &[robot]).is_ok_and(|got| got.grid.cells() > 4096) {
            continue;
        }
        briefs.publish_wire(wire, &[robot]).unwrap();
        pause();
    }
    for robot in extremes::of(&robot) {
        briefs.publish_wire(BriefV10::from(&brief), &[robot]).unwrap();
        pause();
    }
    // A mission for other planners than this one: it is not flown, and this one waits for another.
    let mut covering = Brief { account: Account::ActionsWithoutWaits, ..brief.clone() };
    let rover = &mut covering.robots[0];
    rover.body = Body::Rover(Rover { speed_mps: 1.0 });
    (rover.sensor, rover.goal) = (Sensor::Square(Square { range_cells: 1 }), Goal::Cover(Cover::default()));
    briefs.publish(covering).unwrap();
    peers[1].await_log("needs one of the planners");
    briefs.publish(brief).unwrap();
    for state in [&flown[0], &flown[1]] {
        for wire in extremes::of(&StateV4::from(state)) {
            states.publish_wire((), &[wire]).unwrap();
            pause();
        }
    }
    for peer in &mut peers {
        assert!(peer.has_ended().is_none(), "{} ended: {}", peer.role, peer.log());
    }
    for peer in &peers[..2] {
        peer.await_log("refused a message");
    }
    drop((briefs, states, node));
    let mut sim = mission.start("sim", &["--seed", "47"]);
    assert_eq!(sim.code(), 0, "{}", sim.log());
    assert_eq!(sim.json()["digest"], lockstep(&["--seed", "47"])["digest"]);
    for peer in &mut peers {
        assert_eq!(peer.code(), 0, "{}: {}", peer.role, peer.log());
    }
}
