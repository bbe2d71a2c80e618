//! The stack beside what it is compared with, in one run: medians of interleaved rounds.
//!
//! `cargo bench --bench stack`. Every figure is a median over rounds; ratios are taken within a round,
//! so that the noise of a shared machine falls on both sides alike.

#![allow(clippy::print_stdout, reason = "a benchmark's output is its data")]

mod flown;

use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use contract::{Brief, MonotonicNs, Record, RunId, Timing};
use flown::{median, overhead_us, timings};
use hopper_sim::Mission;
use lockstep::PlannerSchedule;
use node::relay::{Relay, Stage};
use node::{Instance, Node};
use perception::{Cartographer, Effect, Event};
use rustix::time::{ClockId, clock_gettime};
use scenario::{ResolvedScenario, Scenario};

/// Interleaved rounds of each measurement.
const ROUNDS: u64 = 7;

/// Landings a second at which latency is measured, on both sides: with time to fall asleep, and without.
const PACES_HZ: [u64; 2] = [50, 1000];

/// Decisions of one relay round, about as many as a mission on hard ground takes.
const RELAY_ROUNDS: u64 = 40;

/// Lockstep missions a round.
const EPISODES: u64 = 200;

/// Lockstep missions of rovers a round.
const COVERINGS: u64 = 20;

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    if let [_, role, instance, cells, stage] = arguments.as_slice()
        && role == "relay-stage"
    {
        let relay = relay(instance, cells.parse().expect("a number of cells"));
        relay.answer(stage.parse().expect("a stage")).expect("the relay runs");
        return;
    }
    let cells = patch_cells();
    let mut rows = Rows::default();
    for round in 0..ROUNDS {
        for pace_hz in PACES_HZ {
            let bare_us = bare_relay_us(round, pace_hz, cells);
            let timings = fly(round, &pace_hz.to_string());
            let stack_us = median(timings.iter().map(overhead_us));
            rows.push(&format!("{pace_hz} Hz: bare relay of three processes [us]"), bare_us);
            rows.push(&format!("{pace_hz} Hz: landing to accepted, less planning [us]"), stack_us);
            rows.push(&format!("{pace_hz} Hz: ratio of the two"), stack_us / bare_us);
        }
        let hopper_hz = rate_hz(&fly(round, "max"));
        let rovers_hz = rate_hz(&fly_in("coverage-8", round, "max"));
        rows.push("hops a second through four processes at --pace max", hopper_hz);
        rows.push("8 rovers: decisions a second through eleven processes", rovers_hz);
        rows.push("8 rovers: ratio of the two", rovers_hz / hopper_hz);
        for rovers in [1, 8] {
            rows.push(
                &format!("{rovers} rovers: lockstep steps a second of processor time"),
                covering_hz(rovers, round),
            );
        }
        for algorithm in ["mdp", "greedy"] {
            let (planning_us, episodes_hz) = in_lockstep(algorithm, round);
            rows.push(&format!("{algorithm}: planning a decision on 20x20 [us]"), planning_us);
            rows.push(&format!("{algorithm}: lockstep episodes a second, one thread"), episodes_hz);
        }
    }
    println!("processor: {}", node::host::processor());
    println!("cores: {}, rounds: {ROUNDS}, cells of a patch in the relay: {cells}\n", cores());
    rows.print();
}

fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

fn relay(instance: &str, cells: usize) -> Relay {
    Relay { instance: Instance::new(instance).expect("an instance"), cells }
}

/// Cells of the median patch of these missions: what the relay has to carry, like the stack.
fn patch_cells() -> usize {
    let ResolvedScenario { brief, terrain, .. } = paper_world();
    let mut cells = Vec::new();
    for seed in 0..ROUNDS {
        let mission = Mission::under_law(brief.clone(), terrain.clone(), seed);
        let mut cartographer = Cartographer::new(hopper_sim::ROBOT);
        cartographer.on(Event::Brief(brief.clone()), MonotonicNs(0));
        cartographer.on(Event::Terrain(brief.run, terrain.clone()), MonotonicNs(0));
        let mut land = |record: &Record| {
            let state = record.state_after(brief.run, MonotonicNs(0), MonotonicNs(0));
            if cartographer.on(Event::State(state), MonotonicNs(0)).contains(&Effect::PublishMap) {
                let patches = cartographer.patches(MonotonicNs(0), &mut || MonotonicNs(0));
                cells.extend(patches.iter().map(|patch| patch.cells.len() as f64));
            }
        };
        lockstep::fly(
            mission,
            &PlannerSchedule::single("mdp".parse().expect("a name")),
            &mut Node::now,
            &mut land,
        )
        .expect("a known algorithm");
    }
    median(cells.into_iter()) as usize
}

fn paper_world() -> ResolvedScenario {
    let world = scenario::load("hard").and_then(|scenario| scenario.resolve()).expect("a built-in scenario");
    ResolvedScenario { brief: Brief { run: RunId(1), ..world.brief.clone() }, ..world }
}

/// Median round trip of a relay that does no work, microseconds.
fn bare_relay_us(round: u64, pace_hz: u64, cells: usize) -> f64 {
    let instance = format!("bench-relay-{}-{round}-{pace_hz}", std::process::id());
    let executable = std::env::current_exe().expect("this benchmark");
    let stage = |stage: Stage| -> Child {
        Command::new(&executable)
            .args(["relay-stage", &instance, &cells.to_string(), stage.as_str()])
            .stdin(Stdio::null())
            .spawn()
            .expect("a stage starts")
    };
    let mut stages = [stage(Stage::Map), stage(Stage::Command)];
    let period = Duration::from_nanos(1_000_000_000 / pace_hz);
    let times_ns = relay(&instance, cells).source(RELAY_ROUNDS, period).expect("the relay runs");
    for stage in &mut stages {
        stage.wait().expect("a stage ends");
    }
    median(times_ns.into_iter().map(|ns| ns as f64 / 1e3))
}

/// Timings of a mission flown by four processes.
fn fly(round: u64, pace: &str) -> Vec<Timing> {
    fly_in("hard", round, pace)
}

fn fly_in(scenario: &str, round: u64, pace: &str) -> Vec<Timing> {
    let dir = tempfile::tempdir().expect("a folder");
    let out = dir.path().join("out");
    let status = Command::new(env!("CARGO_BIN_EXE_hopper"))
        .args(["run", "--instance", &format!("bench-stack-{}-{round}", std::process::id())])
        .args([
            "--scenario",
            scenario,
            "--pace",
            pace,
            "--seed",
            &round.to_string(),
            "--format",
            "json",
            "--out",
        ])
        .arg(&out)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .expect("hopper runs");
    assert!(matches!(status.code(), Some(0 | 1)), "the mission ended with {status}");
    timings(&out.join("journal"))
}

fn rate_hz(timings: &[Timing]) -> f64 {
    let (first, last) = (timings.first().expect("hops"), timings.last().expect("hops"));
    timings.len() as f64 * 1e9 / last.committed.since_ns(first.landed) as f64
}

/// Processor time of this thread, seconds.
fn processor_s() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// Steps a second of processor time of rovers that cover 20 x 20 cells by spirals.
fn covering_hz(rovers: usize, round: u64) -> f64 {
    let mut text = String::from(
        "[brief]\nprofile = \"hopper\"\n[limits]\nsteps_max = 5000\n\
         [truth.terrain.obstacles]\nwidth_cells = 20\nheight_cells = 20\ncell_size_m = 1.0\npercent = 10.0\nseed = 0\n",
    );
    for [x, y] in [[0, 0], [19, 0], [0, 19], [19, 19], [9, 0], [0, 9], [19, 10], [10, 19]].iter().take(rovers)
    {
        text += &format!("[[robots]]\nbody = \"rover\"\nstart = [{x}, {y}]\ngoal = {{ cover = 95 }}\n");
    }
    let world =
        Scenario::parse(&text, "covering").and_then(|scenario| scenario.resolve()).expect("a sound scenario");
    let schedule = PlannerSchedule::single("spiral".parse().expect("a name"));
    let mut steps = 0;
    let started_s = processor_s();
    for episode in 0..COVERINGS {
        let brief = Brief { run: RunId(1), ..world.brief.clone() };
        let mission = Mission { brief, ..Mission::of(&world, round * COVERINGS + episode) };
        lockstep::fly(mission, &schedule, &mut Node::now, &mut |_| steps += 1).expect("a known algorithm");
    }
    f64::from(steps) / (processor_s() - started_s)
}

/// Median planning time in microseconds, and missions a second.
fn in_lockstep(algorithm: &str, round: u64) -> (f64, f64) {
    let world = paper_world();
    let schedule = PlannerSchedule::single(algorithm.parse().expect("a name"));
    let mut planning_us = Vec::new();
    let started = Instant::now();
    for episode in 0..EPISODES {
        let mission = Mission::of(&world, round * EPISODES + episode);
        let mut clock = || -> MonotonicNs { Node::now() };
        lockstep::fly(mission, &schedule, &mut clock, &mut |record| {
            let Timing { planning_started, planning_ended, .. } = record.timing;
            planning_us.push(planning_ended.since_ns(planning_started) as f64 / 1e3);
        })
        .expect("a known algorithm");
    }
    let episodes_hz = EPISODES as f64 / started.elapsed().as_secs_f64();
    (median(planning_us.into_iter()), episodes_hz)
}

/// Figures by name, in order of appearance.
#[derive(Default)]
struct Rows(Vec<(String, Vec<f64>)>);

impl Rows {
    fn push(&mut self, name: &str, value: f64) {
        match self.0.iter_mut().find(|(known, _)| known == name) {
            Some((_, values)) => values.push(value),
            None => self.0.push((name.into(), vec![value])),
        }
    }

    fn print(&self) {
        for (name, values) in &self.0 {
            let (low, high) = values
                .iter()
                .fold((f64::MAX, f64::MIN), |(low, high), value| (low.min(*value), high.max(*value)));
            println!("{name:<55} {:>10.2}   (rounds {low:.2} to {high:.2})", median(values.iter().copied()));
        }
    }
}
