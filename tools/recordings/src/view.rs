//! `hopper view` of a recording: its last run on the page of running missions.

use std::path::PathBuf;

use contract::message::Message;
use contract::{Announcement, DetailPage, DetailRequest, MonotonicNs, RobotId, Route, RoutePage, Team};
use hopper::commands::view::{ServeArgs, gather_pages, serve};
use monitor::{Event, History, Input, Watcher};
use node::{Exit, Failure};
use recording::{JsonMessage, RecordedMessage, Recording, RecordingError};

use crate::bag::{load, open, scenario_of, warn_of_skipped};

/// Arguments of `hopper view` where the path is a recording.
#[derive(clap::Args, Clone, Debug)]
pub struct Args {
    #[arg(value_name = "RECORDING")]
    file: PathBuf,
    #[command(flatten)]
    serve: ServeArgs,
}

/// Serves the page of the recording until Ctrl-C.
///
/// # Errors
/// If it cannot be read, or the address cannot be had.
pub fn run(args: &Args) -> Result<Exit, Failure> {
    let bytes = load(&args.file)?;
    let recording = open(&args.file, &bytes)?;
    warn_of_skipped(&args.file, &recording.undecodable());
    let history = history(&recording)?;
    if history.brief().is_none() {
        let messages = recording.entries().count() as u64;
        return Err(Failure::usage(format!(
            "{}: {}",
            args.file.display(),
            RecordingError::NoBrief { messages }
        )));
    }
    serve(history, &args.serve)
}

/// The history that the recorded messages tell; of several runs the last. Messages that cannot be decoded are left out.
///
/// # Errors
/// If the scenario is malformed.
pub fn history(recording: &Recording<'_>) -> Result<History, Failure> {
    let robot = RobotId(0);
    let (mut history, mut watcher) = (History::new(robot), Watcher::new(robot));
    let mut last = MonotonicNs(0);
    let (mut routes, mut details): (Vec<Route>, Vec<DetailPage>) = (Vec::new(), Vec::new());
    for entry in recording.entries().filter(|entry| entry.undecodable().is_none()) {
        let now = entry.logged;
        last = now;
        if entry.known.is_none() {
            if let Some(team) = json::<Team>(&entry.topic, entry.data)? {
                history.on(Input::Team(&team), now);
                watcher.on(Event::Team(team), now);
            } else if JsonMessage::is_topic_of_answers::<DetailRequest>(&entry.topic) {
                details.push(decoded::<DetailPage>(&entry.topic, entry.data)?);
            } else if let Some(Announcement { route, .. }) = json(&entry.topic, entry.data)? {
                routes.push(Route::new(route.waypoints().to_vec()).map_err(Failure::usage)?);
            }
            continue;
        }
        let Some(message) = entry.message().map_err(Failure::usage)? else { continue };
        match message {
            RecordedMessage::Brief(brief) => {
                history.on(Input::Brief(&brief), now);
                watcher.on(Event::Brief(brief), now);
            }
            RecordedMessage::State(state) => {
                history.on(Input::State(&state), now);
                watcher.on(Event::State(state), now);
            }
            RecordedMessage::Past(page) => {
                history.on(Input::Past(&page), now);
                watcher.on(Event::Past(page), now);
            }
            RecordedMessage::Patch(patch) => {
                watcher.on(Event::Map(patch.clone()), now);
                history.on(Input::Patch(patch), now);
                history.on(Input::Tick, now);
            }
            RecordedMessage::Page(page) => _ = history.on(Input::Page(&page), now),
            RecordedMessage::Heartbeat(beat) => {
                history.on(Input::Heartbeat(&beat), now);
                watcher.on(Event::Heartbeat(beat), now);
            }
            RecordedMessage::Policy(policy) => _ = history.on(Input::Policy(policy), now),
            RecordedMessage::Pacing(pacing) => _ = history.on(Input::Pacing(pacing), now),
            RecordedMessage::Command(_)
            | RecordedMessage::Control(_)
            | RecordedMessage::Host(_)
            | RecordedMessage::Gap(_) => {}
        }
    }
    history.on(Input::Tick, last);
    // Records may be recorded after their details, so they come first.
    details.iter().for_each(|page| _ = history.on(Input::Detail(page), last));
    answer(&mut history, recording, routes, last)?;
    if let Some(progress) = watcher.progress(last) {
        history.set_progress(progress);
    }
    Ok(history)
}

/// A message that is recorded as JSON, if it is one of type `M`.
fn json<M: Message + serde::de::DeserializeOwned>(topic: &str, data: &[u8]) -> Result<Option<M>, Failure> {
    if !JsonMessage::is_topic_of::<M>(topic) {
        return Ok(None);
    }
    decoded(topic, data).map(Some)
}

fn decoded<M: serde::de::DeserializeOwned>(topic: &str, data: &[u8]) -> Result<M, Failure> {
    serde_json::from_slice(data)
        .map_err(|error| Failure::usage(format!("a message of {topic} is malformed: {error}")))
}

/// Gives the history what it would ask hopper-sim for: all routes that were recorded, though others may be
/// missing; and of uncertain ground the prior of the scenario, if the recording has it.
fn answer(
    history: &mut History,
    recording: &Recording<'_>,
    routes: Vec<Route>,
    now: MonotonicNs,
) -> Result<(), Failure> {
    let Some(brief) = history.brief().cloned() else { return Ok(()) };
    for route in routes {
        history.on(Input::Route(&RoutePage { run: brief.run, route }), now);
    }
    if brief.sampling.is_none() {
        return Ok(());
    }
    if let Some((_, world)) = scenario_of(recording, &brief)? {
        let later = now.plus_ns(contract::limits::ASK_AGAIN_NS);
        gather_pages(history, &brief, &world, later);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use contract::{
        Action, Brief, Decision, Detail, Goal, LookAhead, MotionModel, PastPage, PathPoint, Record, Robot,
        Robots, RouteRequest, RunId, Waypoint,
    };
    use hostile::fixtures;
    use recording::{Context, Recorder};

    use super::*;

    /// A recorder that has the records by which robots 0 and 1 announced a route each, and the two routes.
    fn recorder_of_two() -> (Recorder, Brief, [Route; 2]) {
        let route = |x_m| {
            let points = [0.5, x_m].map(|x_m| Waypoint { x_m, y_m: 0.5 });
            Route::new(points.to_vec()).unwrap()
        };
        let routes = [route(1.5), route(2.5)];
        let (flown, _) = fixtures::flown();
        let announced = (0..).zip(&routes).zip(flown).map(|((robot, route), record)| Record {
            robot: RobotId(robot),
            action: Action::Announce(route.id()),
            ..record
        });
        let brief = fixtures::brief();
        let first = brief.robots[0];
        let goal = Goal::LookAhead(LookAhead {});
        let robots = Robots::new(&[first, Robot { goal, required: false, ..first }]).unwrap();
        let brief = Brief { robots, ..brief };
        let (run, robot, from) = (brief.run, RobotId(0), Decision(0));
        let past = PastPage { run, robot, from, records: announced.collect() };
        let mut recorder = Recorder::new(&Context::default(), MonotonicNs(1)).unwrap();
        for message in [RecordedMessage::Brief(brief.clone()), RecordedMessage::Past(past)] {
            recorder.on(message, MonotonicNs(1)).unwrap();
        }
        (recorder, brief, routes)
    }

    #[test]
    fn a_route_that_was_not_recorded_hides_no_other() {
        let (mut recorder, Brief { run, .. }, [_, route]) = recorder_of_two();
        let announcement = Announcement { run, robot: RobotId(1), route: route.clone() };
        recorder.on_json(&JsonMessage::of(&announcement).unwrap(), MonotonicNs(2)).unwrap();
        recorder.finish(MonotonicNs(3)).unwrap();
        let bytes = recorder.bytes();
        let history = history(&Recording::read(&bytes).unwrap()).unwrap();
        let announced = |robot| history.announcements().unwrap().of(RobotId(robot), Decision(9));
        assert_eq!(announced(0), None);
        assert_eq!(announced(1).map(|announced| &announced.route), Some(&route));
    }

    /// P-BAG-ROBOTS: A recording keeps commands and announced routes under the name of their robot.
    /// It has every announced route: one whose announcement was missed is requested and recorded
    /// once.
    #[test]
    fn routes_that_were_missed_are_asked_for_recorded_once_and_shown() {
        let (mut recorder, Brief { run, .. }, routes) = recorder_of_two();
        let mut now = MonotonicNs(2);
        let announced = Announcement { run, robot: RobotId(0), route: routes[0].clone() };
        recorder.with(|transcript| transcript.on_announcement(&announced, now)).unwrap();
        assert!(recorder.lacks_routes(), "that of robot 1 was not heard");
        let missed = &routes[1];
        for _ in 0..2 {
            let wanted = recorder.tick(now).unwrap().route;
            assert_eq!(wanted, Some(RouteRequest { run, id: missed.id() }), "until it comes");
            assert_eq!(recorder.tick(now).unwrap().route, None, "one request at a time");
            now = now.plus_ns(contract::limits::ASK_AGAIN_NS);
        }
        for run in [RunId(run.0 + 1), run, run] {
            let page = RoutePage { run, route: missed.clone() };
            recorder.with(|transcript| transcript.on_route(&page, now)).unwrap();
        }
        assert!(!recorder.lacks_routes());
        assert_eq!(recorder.tick(now.plus_ns(contract::limits::ASK_AGAIN_NS)).unwrap().route, None);
        recorder.finish(now).unwrap();
        let bytes = recorder.bytes();
        let recording = Recording::read(&bytes).unwrap();
        let topics: Vec<_> =
            recording.entries().map(|entry| entry.topic).filter(|topic| topic.ends_with("/route")).collect();
        let expected = ["hop/r0/route", "hop/r1/route"];
        assert_eq!(topics.iter().filter(|topic| topic.starts_with("hop/")).collect::<Vec<_>>(), expected);
        let history = history(&recording).unwrap();
        for (robot, route) in (0..).map(RobotId).zip(&routes) {
            let shown = history.announcements().unwrap().of(robot, Decision(9));
            assert_eq!(shown.map(|announced| &announced.route), Some(route), "robot {robot}");
        }
    }

    /// P-BAG-DETAILS: A recording has what the motion model told of each decision: asked for until it comes, recorded once, kept by a
    /// recovery, and shown again to the bit.
    #[test]
    fn details_are_asked_for_recorded_once_and_shown_to_the_bit() {
        let detail = |decision: u64| {
            let leaves_mps = [0.1 + 0.2, -1e-17, 1.0 / 3.0];
            let point = |seconds| PathPoint { seconds, at_m: [0.7, 0.1 * seconds, -0.3], leaves_mps };
            let figures = [1.0, 1.0, 0.1 + 0.7, 1.9, 2.0 / 3.0, 0.0];
            let path = vec![point(0.0), point(0.1 + decision as f64)];
            Detail { model: MotionModel::Contact, rest_m: [0.3, 0.2 + 0.1, -0.0], figures, path }
        };
        let (flown, _) = fixtures::flown();
        let brief = fixtures::brief();
        let (run, robot, from) = (brief.run, RobotId(0), Decision(0));
        let told = |record: Record| Record { detail: detail(record.decision.0).id(), ..record };
        let mut previous = flown[0].previous;
        let records: Vec<Record> = flown.into_iter().take(3).map(told).collect();
        let records: Vec<Record> = records
            .into_iter()
            .map(|record| {
                let record = Record { previous, ..record };
                previous = previous.chain(&record);
                Record { digest: previous, ..record }
            })
            .collect();
        let count = records.len() as u64;
        let mut recorder = Recorder::new(&Context::default(), MonotonicNs(1)).unwrap();
        let past = PastPage { run, robot, from, records };
        for message in [RecordedMessage::Brief(brief), RecordedMessage::Past(past)] {
            recorder.on(message, MonotonicNs(1)).unwrap();
        }
        let mut now = MonotonicNs(2);
        for decision in (0..count).map(Decision) {
            assert!(recorder.lacks_details());
            let wanted = Some(DetailRequest { run, decision });
            assert_eq!(recorder.tick(now).unwrap().detail, wanted);
            assert_eq!(recorder.tick(now).unwrap().detail, None, "one request at a time");
            now = now.plus_ns(contract::limits::ASK_AGAIN_NS);
            assert_eq!(recorder.tick(now).unwrap().detail, wanted, "until it comes");
            for (run, of) in [(RunId(run.0 + 1), decision.0), (run, 77), (run, decision.0), (run, decision.0)]
            {
                let page = DetailPage { run, decision, detail: detail(of) };
                recorder.with(|transcript| transcript.on_detail(page, now)).unwrap();
            }
        }
        assert!(!recorder.lacks_details());
        recorder.finish(now).unwrap();
        let bytes = recorder.bytes();
        for bytes in [&bytes, &recording::recover(&Recording::read(&bytes).unwrap()).unwrap()] {
            let recording = Recording::read(bytes).unwrap();
            assert!(recording.entries().all(|entry| entry.undecodable().is_none()));
            let count_of = recording.entries().filter(|entry| entry.topic == "hop/details").count();
            assert_eq!(count_of as u64, count, "each once");
            let history = history(&recording).unwrap();
            for decision in (0..count).map(Decision) {
                let shown = history.details().unwrap().of(decision);
                assert_eq!(shown.map(Detail::id), Some(detail(decision.0).id()), "{decision}");
            }
        }
    }

    /// P-BAG-ROBOTS.
    #[test]
    fn commands_are_recorded_under_the_name_of_their_robots_service() {
        let (mut recorder, ..) = recorder_of_two();
        let (_, states) = fixtures::flown();
        let command = |robot| contract::Command { robot: RobotId(robot), ..fixtures::command(&states[0]) };
        for robot in [1, 0, 1] {
            recorder.on(RecordedMessage::Command(command(robot)), MonotonicNs(2)).unwrap();
        }
        recorder.finish(MonotonicNs(3)).unwrap();
        let bytes = recorder.bytes();
        for bytes in [&bytes, &recording::recover(&Recording::read(&bytes).unwrap()).unwrap()] {
            let recording = Recording::read(bytes).unwrap();
            assert!(recording.is_whole(), "{:?}", recording.fault);
            let commands = recording.entries().filter(|entry| entry.topic.ends_with("/command"));
            let read: Vec<_> = commands
                .map(|entry| (entry.topic.clone(), entry.sequence, entry.message().unwrap()))
                .collect();
            let expected = [(1, 0), (0, 0), (1, 1)].map(|(robot, sequence)| {
                let message = RecordedMessage::Command(command(robot));
                (format!("hop/r{robot}/command"), sequence, Some(message))
            });
            assert_eq!(read, expected);
        }
    }
}
