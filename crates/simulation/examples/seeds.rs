//! Simulates seeds on two threads and prints the first promise that does not hold: the whole of the fault simulation
//! without shared memory, quick to build from a changed tree.
//!
//! `cargo run --release -p simulation --example seeds -- 0..5000`, with `rovers`, `scouts`, `accompanied` or `mixed` behind it those of
//! several robots, and with `protocol` those of a hopper that nothing surprises
//!
//! The last line is for programs too: `seed N breaks: PROMISE: DETAIL` with exit code 1, or anything with exit code 0; with
//! exit code 3 no promise was broken, but a rare event never came up that should have.

use std::io::Write;
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use simulation::Sometimes;
use simulation::coverage::{Coverage, SOMETIMES};
use simulation::fault::Plan;
use simulation::setup::Missions;
use simulation::simulate;

const THREADS: usize = 2;

fn main() -> ExitCode {
    let range = std::env::args().nth(1).unwrap_or_else(|| "0..2000".into());
    let ends = range.split_once("..").and_then(|(from, to)| Some((from.parse().ok()?, to.parse().ok()?)));
    let Some((from, to)) = ends.filter(|(from, to)| from < to) else {
        return say(2, &format!("seeds are A..B with A below B, e.g. 0..2000; got {range:?}"));
    };
    let asked = |word: &str| std::env::args().skip(2).any(|given| given == word);
    let traced = asked("--trace");
    let several = [
        ("rovers", Missions::Rovers),
        ("scouts", Missions::Scouts),
        ("accompanied", Missions::Accompanied),
        ("mixed", Missions::Mixed),
        ("protocol", Missions::Protocol),
    ];
    let missions =
        several.into_iter().find(|(word, _)| asked(word)).map_or(Missions::Hopper, |(_, whose)| whose);
    let (next, failing) = (AtomicU64::new(from), AtomicU64::new(u64::MAX));
    let coverage = Mutex::new(Coverage::default());
    std::thread::scope(|scope| {
        for _ in 0..THREADS {
            scope.spawn(|| {
                loop {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed >= to.min(failing.load(Ordering::Relaxed)) {
                        return;
                    }
                    let report = simulate(&Plan::of(missions, seed), false);
                    coverage.lock().unwrap_or_else(PoisonError::into_inner).add(&report.coverage);
                    if report.violation.is_some() {
                        failing.fetch_min(seed, Ordering::Relaxed);
                    }
                }
            });
        }
    });
    let seed = failing.into_inner();
    if seed == u64::MAX {
        let coverage = coverage.into_inner().unwrap_or_else(PoisonError::into_inner);
        return conclude(&coverage, missions, to - from);
    }
    let report = simulate(&Plan::of(missions, seed), traced);
    for line in &report.trace {
        say(1, &format!("{:>12.3} ms  {}", line.ms, line.text));
    }
    let Some(violation) = report.violation else {
        return say(
            1,
            &format!("seed {seed} breaks a promise once, and not again: the simulation is not deterministic"),
        );
    };
    say(1, &format!("seed {seed} breaks: {}: {}", violation.rule, violation.detail))
}

/// Prints how often each rare event came up; exit code 3 if one did not that should have.
fn conclude(coverage: &Coverage, missions: Missions, seeds: u64) -> ExitCode {
    for Sometimes { group, name, .. } in SOMETIMES.iter().filter(|event| event.missions.contains(&missions)) {
        say(0, &format!("{:>9} times {group} {name}", coverage.of(group, name)));
    }
    let never: Vec<String> =
        coverage.never(missions, seeds).map(|event| format!("{} {}", event.group, event.name)).collect();
    if never.is_empty() {
        return say(0, &format!("{seeds} seeds, no promise was broken"));
    }
    say(3, &format!("{seeds} seeds, no promise was broken, but this never came up: {}", never.join(", ")))
}

fn say(exit: u8, text: &str) -> ExitCode {
    // Nobody is left to read if standard output is closed.
    let _ = writeln!(std::io::stdout(), "{text}");
    ExitCode::from(exit)
}
