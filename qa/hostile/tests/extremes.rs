//! Every field of every message at every extreme: refused and counted, or borne.

use std::sync::Arc;

use contract::wire::{
    BriefV10, CommandV3, GroundV2, HeartbeatV2, MapPageV2, MapPatchV2, PastHeaderV1, RecordV5, RobotV1,
    SeenCellV4, StateV4, TruthPageV1, brief_from_wire, map_page_from_wire, page_from_wire, patch_from_wire,
    truth_page_from_wire,
};
use contract::{Brief, Command, Decision, Heartbeat, Incarnation, MonotonicNs, PastPage, Record, State};
use hopper_sim::{Arbiter, Effect, Event, Mission, Pace, ROBOT};
use hostile::{extremes, fixtures, wire};
use monitor::watcher::{self, Watcher};
use perception::Observation;
use perception::cartographer::{self, Cartographer};
use planner::pilot::{self, Pilot, PilotConfig};
use planner::{Budget, Situation, algorithm};

const NOW: MonotonicNs = MonotonicNs(5_000_000_000);

/// An arbiter whose planner in command has had its first command executed.
fn led() -> Arbiter {
    let mut arbiter = Arbiter::new(fixtures::mission(), None, Pace::Max, 1_000_000_000, NOW);
    arbiter.on(Event::Tick, NOW);
    let command = fixtures::command(arbiter.state());
    assert!(matches!(arbiter.on(Event::Command(Ok(command)), NOW)[..], [Effect::Append(_)]));
    arbiter.on(Event::Appended, NOW);
    assert_eq!(arbiter.state().decision, Decision(1));
    arbiter
}

/// P-EXTREMES: A stranger's command with any field at any extreme moves nothing, and is counted.
#[test]
fn a_strangers_command_with_any_field_at_any_extreme_is_refused_and_counted() {
    let mut arbiter = led();
    let before = *arbiter.state();
    let stranger = Command { incarnation: Incarnation(0xbad), ..fixtures::command(&before) };
    let commands = extremes::of(&CommandV3::from(&stranger));
    assert!(commands.len() > 400, "{}", commands.len());
    for wire in &commands {
        let effects = arbiter.on(Event::Command(Command::try_from(wire)), NOW);
        assert!(matches!(effects[0], Effect::Refused(_)), "{wire:?}: {effects:?}");
        assert!(effects.iter().all(|effect| !matches!(effect, Effect::Append(_))), "{wire:?}");
        assert_eq!(arbiter.state(), &before);
    }
    let counted: u64 = arbiter.refusals().0.values().sum();
    assert_eq!(counted, commands.len() as u64, "{:?}", arbiter.refusals());
    // And the planner in command is obeyed as before.
    let effects = arbiter.on(Event::Command(Ok(fixtures::command(&before))), NOW);
    assert!(matches!(effects[..], [Effect::Append(_)]), "{effects:?}");
}

/// Machines in the midst of a mission.
struct Processes {
    cartographer: Cartographer,
    pilot: Pilot,
    watcher: Watcher,
}

impl Processes {
    fn new() -> Self {
        let config = PilotConfig {
            robots: contract::RobotSet::default(),
            incarnation: Incarnation(77),
            pid: 1,
            planner: fixtures::heartbeat().planner,
            takeover: false,
            succeeds_pid: None,
        };
        Self {
            cartographer: Cartographer::new(ROBOT),
            pilot: Pilot::new(config),
            watcher: Watcher::new(ROBOT),
        }
    }

    fn brief(&mut self, brief: Brief) {
        self.cartographer.on(cartographer::Event::Brief(brief.clone()), NOW);
        self.pilot.on(pilot::Event::Brief(brief.clone()), NOW);
        self.watcher.on(watcher::Event::Brief(brief), NOW);
    }

    fn state(&mut self, state: State) {
        self.cartographer.on(cartographer::Event::State(state), NOW);
        self.pilot.on(pilot::Event::State(state), NOW);
        self.watcher.on(watcher::Event::State(state), NOW);
    }

    /// Time passes; whatever there is to be told is told.
    fn tick(&mut self) {
        let later = NOW.plus_ns(3_000_000_000);
        for now in [NOW, later] {
            for effect in self.cartographer.on(cartographer::Event::Tick, now) {
                if effect == cartographer::Effect::PublishMap {
                    self.cartographer.patches(now, &mut || now);
                }
            }
            self.pilot.on(pilot::Event::Tick, now);
            self.watcher.on(watcher::Event::Tick, now);
        }
        let _ = (
            self.watcher.progress(later),
            self.watcher.latency(),
            self.pilot.seen(),
            self.cartographer.seen(),
        );
    }

    /// With the brief, the truth and the opening state of the fixtures' mission.
    fn aboard() -> Self {
        let mut processes = Self::new();
        processes.brief(fixtures::brief());
        processes.cartographer.on(cartographer::Event::Truth(wire::truth()), NOW);
        processes.state(fixtures::flown().1[0]);
        processes
    }
}

/// The fixtures' brief with any field of it or of its robot at any extreme, as far as it passes the checks of the wire.
fn briefs() -> Vec<Brief> {
    let brief = fixtures::brief();
    let (header, robot) = (BriefV10::from(&brief), RobotV1::from(&brief.robots[0]));
    let headers = extremes::of(&header).into_iter().map(|header| brief_from_wire(&header, &[robot]));
    let robots = extremes::of(&robot).into_iter().map(|robot| brief_from_wire(&header, &[robot]));
    headers.chain(robots).filter_map(Result::ok).collect()
}

/// P-EXTREMES-PEERS: Perception, planner and monitor survive every extreme value that passes the
/// checks of the wire.
// Long: a list of the messages that peers read.
#[test]
fn no_extreme_of_what_peers_read_ends_one_of_them() {
    let (records, states) = fixtures::flown();
    let (patch, page, truth) = (wire::patch(), wire::page(), wire::truth());
    let cells: Vec<_> = patch.cells.iter().map(SeenCellV4::from).collect();
    let ground: Vec<_> = truth.cells.iter().map(GroundV2::from).collect();
    for brief in briefs() {
        for run in [fixtures::RUN, brief.run] {
            let mut processes = Processes::aboard();
            processes.brief(Brief { run, ..brief.clone() });
            processes.state(State { run, ..states[0] });
            processes.tick();
        }
    }
    for wire in extremes::of(&StateV4::from(&states[1])) {
        if let Ok(state) = State::try_from(&wire) {
            let mut processes = Processes::aboard();
            processes.state(state);
            processes.state(states[2]);
            processes.tick();
        }
    }
    for header in extremes::of(&MapPatchV2::from(&patch)) {
        if let Ok(patch) = patch_from_wire(&header, &cells) {
            let mut processes = Processes::aboard();
            processes.watcher.on(watcher::Event::Map(patch.clone()), NOW);
            processes.pilot.on(pilot::Event::Patch(patch), NOW);
            processes.tick();
        }
    }
    for header in extremes::of(&MapPageV2::from(&page)) {
        if let Ok(page) = map_page_from_wire(&header, &cells) {
            let mut processes = Processes::aboard();
            processes.pilot.on(pilot::Event::Page(page), NOW);
            processes.tick();
        }
    }
    for header in extremes::of(&TruthPageV1::from(&truth)) {
        if let Ok(truth) = truth_page_from_wire(&header, &ground) {
            let mut processes = Processes::new();
            processes.brief(fixtures::brief());
            processes.cartographer.on(cartographer::Event::Truth(truth), NOW);
            processes.state(states[0]);
            processes.tick();
        }
    }
    let page =
        PastPage { run: fixtures::RUN, robot: ROBOT, from: Decision(0), records: records[..1].to_vec() };
    for record in extremes::of(&RecordV5::from(&records[0])) {
        if let Ok(page) = page_from_wire(&PastHeaderV1::from(&page), &[record]) {
            let mut processes = Processes::aboard();
            processes.state(states[2]);
            processes.cartographer.on(cartographer::Event::Past(page.clone()), NOW);
            processes.watcher.on(watcher::Event::Past(page), NOW);
            processes.tick();
        }
    }
    for wire in extremes::of(&HeartbeatV2::from(&fixtures::heartbeat())) {
        if let Ok(beat) = Heartbeat::try_from(&wire) {
            let (mut processes, mut arbiter) = (Processes::aboard(), led());
            processes.pilot.on(pilot::Event::Heartbeat(beat), NOW);
            processes.watcher.on(watcher::Event::Heartbeat(beat), NOW);
            let before = *arbiter.state();
            arbiter.on(Event::Heartbeat(beat), NOW);
            assert_eq!(arbiter.state(), &before, "a beat moves nothing");
            processes.tick();
        }
    }
    assert!(Record::try_from(&RecordV5::from(&records[0])).is_ok());
}

/// What a plan may take: sweeps, expansions.
const WORK_MAX: u64 = 200_000;

/// P-EXTREMES-PLAN: Every planner decides within its budget under every extreme brief that passes
/// the checks of the wire.
#[test]
fn every_planner_decides_under_every_brief_that_passes() {
    let mut planned = 0;
    for brief in briefs() {
        let mut terrain = fixtures::mission().terrain;
        if brief.grid.cells() != terrain.cells.len() {
            continue;
        }
        Arc::make_mut(&mut terrain).grid = brief.grid;
        let mission = Mission::under_law(brief.clone(), terrain.clone(), 1);
        let state = *Arbiter::new(mission, None, Pace::Max, 0, NOW).state();
        let mut observation = Observation::unseen(&brief, ROBOT);
        observation.fold(&brief, &terrain, state.pose, Decision(0));
        let leg = brief.leg(state.visits);
        for name in planner::ALGORITHMS {
            let mut planner = algorithm(name).unwrap();
            let situation = Situation::alone(&brief, &leg, observation.map(), &state);
            let plan = planner.plan(&situation, &Budget::of(Some(WORK_MAX)));
            assert!(plan.error_bound >= 0.0, "{name}: {} under {brief:?}", plan.error_bound);
            assert!(plan.work <= WORK_MAX, "{name}: work {} under {brief:?}", plan.work);
            planned += 1;
        }
    }
    assert!(planned > 300, "{planned} plans");
}
