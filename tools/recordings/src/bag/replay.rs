//! `hopper bag replay`: shows what another planner would have done.
//!
//! Brief, states, patches and pages are folded as a planner process folds them; whenever map and state agree, the
//! planner decides, in this process. That its map is the very one on which was decided then is proven by the
//! fingerprint in the record.

use std::collections::BTreeMap;
use std::io::BufRead as _;
use std::time::{Duration, Instant};

use contract::{Action, Brief, Cell, Decision, MonotonicNs, Name, Vetoed};
use hopper::stdout::print;
use node::{Exit, Failure};
use planner::{Budget, Situation, algorithm};
use recording::{PendingDecision, Playback, RecordedMessage, RecordedRun, Recording, last_run};
use report::{Format, table};
use serde::Serialize;

use super::{Source, at_fault, load, open, warn_of_skipped};

/// Differences that the text shows; the JSON has all.
const SHOWN: usize = 40;

/// Arguments of `hopper bag replay`.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    #[command(flatten)]
    source: Source,
    #[arg(long, value_name = "NAME", help = format!(
        "Algorithm that decides: {} [default: the one that commanded first]", planner::ALGORITHMS.join(", ")
    ))]
    planner: Option<String>,
    /// Multiple of the recorded speed, e.g. 1 or 10 [default: as fast as the planner can].
    #[arg(long, value_parser = rate, value_name = "R")]
    rate: Option<f64>,
    /// Wait for a line on standard input before each decision.
    #[arg(long, conflicts_with = "rate")]
    step: bool,
    /// Format of the answer on standard output: text or json.
    #[arg(long, default_value_t)]
    format: Format,
}

impl Args {
    /// Whether it waits for its user, or keeps to a pace that its user chose.
    pub(super) fn is_by_hand(&self) -> bool {
        self.step || self.rate.is_some()
    }
}

/// Slowest and fastest multiple of the recorded pace. At the slowest, the longest span that 64 bits of nanoseconds
/// hold is a duration still.
const RATES: std::ops::RangeInclusive<f64> = 1e-3..=1e6;

fn rate(text: &str) -> Result<f64, String> {
    let rate = text.parse().ok().filter(|rate| RATES.contains(rate));
    rate.ok_or_else(|| format!("a rate needs to be 0.001 to 1000000, got {text:?}"))
}

/// What came of it. The names are those of the JSON.
#[derive(Debug, Serialize)]
struct Replay {
    /// The algorithm that decided anew.
    planner: Name,
    /// Decisions executed, as far as the recording tells.
    decisions: u64,
    /// Decisions that were decided anew on the map they were decided on.
    compared: u64,
    /// Decisions whose map or state the recording does not have.
    not_posed: u64,
    /// Decisions posed with another map than their record tells of; a fallback tells of none.
    other_map: u64,
    /// First landing to last, and how long deciding anew took, seconds.
    recorded_s: f64,
    replayed_s: f64,
    /// Where the two differ.
    different: Vec<Different>,
}

/// A decision on which the two differ.
#[derive(Debug, Serialize)]
struct Different {
    decision: Decision,
    cell: Cell,
    /// Who decided then: a planner, or the fallback.
    decided: String,
    recorded: Action,
    now: Action,
}

/// What was decided anew.
#[derive(Clone, Copy, Debug)]
struct Anew {
    cell: Cell,
    action: Action,
    observation: u64,
}

/// Replays the recording.
///
/// # Errors
/// If it cannot be read or has no brief, or if the algorithm is unknown.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let path = &args.source.file;
    let bytes = load(path)?;
    let recording = open(path, &bytes)?;
    let flown = last_run(&recording).map_err(|error| at_fault(path, &error))?;
    warn_of_skipped(path, &flown.skipped);
    if flown.brief.has_team() {
        return Err(Failure::usage(format!(
            "{}: to decide anew needs the mission of a hopper alone, got scenario {} with {} {}; hopper journal verify flies \
             all of its decisions anew",
            path.display(),
            flown.brief.scenario,
            flown.brief.robots.count(),
            if flown.brief.robots.count() == 1 { "robot that is no hopper" } else { "robots" }
        )));
    }
    let first = flown.records.values().next().map(|record| record.leader.planner.to_string());
    let name = args.planner.clone().or(first).unwrap_or_else(|| "mdp".into());
    check(&name, args.planner.is_some(), &flown.brief)
        .map_err(|failure| Failure::new(failure.exit, format!("{}: {}", path.display(), failure.message)))?;
    let replay = replay(&recording, &flown, &name, args)
        .map_err(|failure| Failure::new(failure.exit, format!("{}: {}", path.display(), failure.message)))?;
    match args.format {
        Format::Text => print(&replay.text())?,
        Format::Json => print(&format!("{}\n", serde_json::to_string(&replay).map_err(Failure::run)?))?,
    }
    Ok(Exit::Done)
}

/// Refuses a planner that cannot decide for a hopper that is alone, and one that this program does not have.
fn check(name: &str, is_given: bool, brief: &Brief) -> Result<(), Failure> {
    let hopper = &brief.robots[0];
    if brief.motion_table() != 0 {
        let need = "a recording of planners that believe the law, got one of a motion table, which no recording holds";
        return Err(Failure::usage(format!(
            "need {need}; `hopper journal verify --against-lockstep` decides anew"
        )));
    }
    match algorithm(name) {
        Err(_) if !is_given => Err(Failure::usage(format!(
            "its decisions are those of {name}, a planner of one's own: name one of {} with --planner",
            planner::suited(brief, hopper).join(", ")
        ))),
        Err(error) => Err(Failure::usage(error)),
        Ok(planner) if !planner.suits(hopper) => Err(Failure::usage(format!(
            "scenario {} needs one of the planners {}, got {name}",
            brief.scenario,
            planner::suited(brief, hopper).join(", ")
        ))),
        Ok(_) => Ok(()),
    }
}

fn replay(
    recording: &Recording<'_>,
    flown: &RecordedRun,
    name: &str,
    args: &Args,
) -> Result<Replay, Failure> {
    let mut planner = algorithm(name).map_err(Failure::usage)?;
    let mut playback = Playback::default();
    let mut anew = BTreeMap::<(Decision, Vetoed), Anew>::new();
    let began = Instant::now();
    let mut metronome = Metronome { rate: args.rate, began, first: None };
    let mut deciding = Duration::ZERO;
    for (logged, message) in recording.messages().filter_map(Result::ok) {
        let Some(PendingDecision { brief, leg, map, state }) = playback.on(&message, logged) else {
            if matches!(message, RecordedMessage::Brief(_))
                && playback.brief().map(|b| b.run) == Some(flown.brief.run)
            {
                // Only the last run is compared.
                planner = algorithm(name).map_err(Failure::usage)?;
            }
            continue;
        };
        if brief.run != flown.brief.run {
            continue;
        }
        metronome.wait(state.landed);
        if args.step && !enter() {
            break;
        }
        let started = Instant::now();
        let past_state = state.of_its_past();
        let situation = Situation {
            brief,
            leg: leg.as_ref(),
            map,
            state: &past_state,
            team: None,
            scouting: None,
            table: None,
        };
        let plan = planner.plan(&situation, &Budget::default());
        deciding += started.elapsed();
        let decided = Anew { cell: state.pose.cell, action: plan.action, observation: map.observation() };
        anew.insert((state.decision, state.vetoed), decided);
        if args.step {
            tracing::info!("decision {} at {}: {}", state.decision, state.pose.cell, plan.action);
        }
    }
    let took = if args.rate.is_some() || args.step { began.elapsed() } else { deciding };
    Ok(Replay::of(planner.name(), flown, &anew, took))
}

/// Keeps to the recorded pace, or a multiple of it.
struct Metronome {
    rate: Option<f64>,
    began: Instant,
    first: Option<MonotonicNs>,
}

impl Metronome {
    fn wait(&mut self, landed: MonotonicNs) {
        if let Some(due) = self.due(landed) {
            std::thread::sleep(due.saturating_sub(self.began.elapsed()));
        }
    }

    /// When the decision of a landing is due, from the begin on.
    fn due(&mut self, landed: MonotonicNs) -> Option<Duration> {
        let rate = self.rate?;
        let first = *self.first.get_or_insert(landed);
        Some(Duration::from_secs_f64(landed.since_ns(first) as f64 / 1e9 / rate))
    }
}

/// Waits for a line; whether there was one.
fn enter() -> bool {
    let mut line = String::new();
    std::io::stdin().lock().read_line(&mut line).is_ok_and(|bytes| bytes > 0)
}

impl Replay {
    fn of(
        planner: Name,
        flown: &RecordedRun,
        anew: &BTreeMap<(Decision, Vetoed), Anew>,
        took: Duration,
    ) -> Self {
        let (mut compared, mut not_posed, mut other_map) = (0, 0, 0);
        let mut different = Vec::new();
        for record in flown.records.values() {
            let Some(now) = anew.get(&(record.decision, record.vetoed)) else {
                not_posed += 1;
                continue;
            };
            if !record.origin.is_fallback() && now.observation != record.observation {
                other_map += 1;
                continue;
            }
            compared += 1;
            if now.action != record.action {
                let decided = match record.origin.is_fallback() {
                    true => format!("fallback ({})", record.origin),
                    false => record.leader.planner.to_string(),
                };
                different.push(Different {
                    decision: record.decision,
                    cell: now.cell,
                    decided,
                    recorded: record.action,
                    now: now.action,
                });
            }
        }
        let landed = |step: Option<&report::DecisionTiming>| step.map(|step| step.timing.landed);
        let span = landed(flown.decisions.first()).zip(landed(flown.decisions.last()));
        Self {
            planner,
            decisions: flown.decisions.len() as u64,
            compared,
            not_posed: not_posed + flown.decisions.len().saturating_sub(flown.records.len()) as u64,
            other_map,
            recorded_s: span.map_or(0.0, |(first, last)| last.since_ns(first) as f64 / 1e9),
            replayed_s: took.as_secs_f64(),
            different,
        }
    }

    fn text(&self) -> String {
        let Self { planner, decisions, compared, not_posed, other_map, recorded_s, replayed_s, different } =
            self;
        let mut text = format!(
            "{planner} decided {compared} of {decisions} decisions anew, and {} of them otherwise.\n",
            different.len()
        );
        if not_posed + other_map > 0 {
            text += &format!(
                "Not compared: {not_posed} of which the recording lacks map or record, {other_map} on another map.\n"
            );
        }
        text += &format!("Recorded in {recorded_s:.3} s, decided anew in {replayed_s:.3} s.\n");
        if different.is_empty() {
            return text;
        }
        let row = |d: &Different| {
            [
                d.decision.to_string(),
                d.cell.to_string(),
                d.decided.clone(),
                d.recorded.to_string(),
                d.now.to_string(),
            ]
        };
        let rows: Vec<_> = different.iter().take(SHOWN).map(row).collect();
        text += "\n";
        text += &table(["decision", "cell", "decided by", "recorded", planner.as_str()], &rows);
        if different.len() > SHOWN {
            text += &format!("… and {} more: --format json has all\n", different.len() - SHOWN);
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// P-OWN-UNSUITED. A planner that cannot decide for the recorded mission is refused by name,
    /// also an external one that flew it.
    #[test]
    fn a_planner_that_does_not_suit_the_recording_is_refused_by_name() {
        let bytes = include_bytes!("../../../../tests/golden/hard.mcap");
        let recording = Recording::read(bytes).expect("a recording of an earlier build");
        let brief = last_run(&recording).expect("it has a mission").brief;
        for suited in planner::suited(&brief, &brief.robots[0]) {
            assert!(check(suited, true, &brief).is_ok(), "{suited}");
        }
        let unsuited =
            [planner::COVER_ALGORITHMS, planner::DRIVE_ALGORITHMS, planner::FLY_ALGORITHMS].concat();
        for name in unsuited.into_iter().chain(planner::AHEAD_ALGORITHMS.iter().copied()) {
            let failure = check(name, true, &brief).expect_err(name);
            let need = format!(
                "scenario hard needs one of the planners mdp, greedy, astar, dstar_lite, hold, got {name}"
            );
            assert_eq!((failure.exit, failure.message), (Exit::Usage, need));
        }
        for (name, is_given, need) in [
            (
                "my_planner",
                false,
                "its decisions are those of my_planner, a planner of one's own: name one of mdp",
            ),
            ("my_planner", true, "\"my_planner\""),
            ("MDP", true, "\"MDP\""),
            ("", true, "\"\""),
            ("clairvoyant", true, "needs the whole ground"),
        ] {
            let failure = check(name, is_given, &brief).expect_err(name);
            assert!(failure.exit == Exit::Usage && failure.message.contains(need), "{}", failure.message);
        }
    }

    #[test]
    fn no_rate_and_no_span_make_a_duration_that_is_none() {
        for refused in ["1e-300", "0", "-1", "nan", "inf", "1e7", "0.0009", "fast"] {
            assert!(rate(refused).unwrap_err().contains("0.001 to 1000000"), "{refused}");
        }
        for (text, least_s) in [("0.001", 1e13), ("1e6", 1e4)] {
            let mut metronome =
                Metronome { rate: Some(rate(text).unwrap()), began: Instant::now(), first: None };
            assert_eq!(metronome.due(MonotonicNs(0)), Some(Duration::ZERO));
            let due = metronome.due(MonotonicNs(u64::MAX)).unwrap();
            assert!(due.as_secs_f64() > least_s, "{due:?}");
            assert!(
                metronome.due(MonotonicNs(1)).unwrap() < due,
                "a landing out of order is due in the past"
            );
        }
    }
}
