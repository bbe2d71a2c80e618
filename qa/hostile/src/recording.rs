//! Recordings: bytes to the messages before the first record that is not whole, or one error.

use contract::{Control, MonotonicNs, Order, Pace, Pacing, PastPage, Policy, PolicyCell};
use hopper_sim::ROBOT;
use perception::Cartographer;
use recording::{
    Context, MachineLoad, Playback, RecordedMessage, Recorder, Recording, SequenceGap, last_run, recover,
};

use crate::{fixtures, told};

/// Reads, decodes, folds, recovers: what is recovered is whole and has the same messages.
pub fn read(bytes: &[u8]) {
    let recording = match Recording::read(bytes) {
        Ok(recording) => recording,
        Err(error) => return told(&error),
    };
    assert!(recording.valid_bytes <= bytes.len() as u64);
    assert_eq!(recording.is_whole(), recording.fault.is_none());
    let mut playback = Playback::default();
    for message in recording.messages() {
        match message {
            Ok((logged, message)) => drop(playback.on(&message, logged).map(|posed| posed.state)),
            Err(error) => told(&error),
        }
    }
    if let Err(error) = last_run(&recording) {
        told(&error);
    }
    match recover(&recording) {
        Ok(whole) => {
            let again = Recording::read(&whole).expect("what is recovered is a recording");
            assert!(again.is_whole(), "{:?}", again.fault);
            assert!(again.entries().count() <= recording.entries().count());
        }
        Err(error) => told(&error),
    }
}

/// Every kind of message, out of the fixtures' mission.
#[must_use]
pub fn messages() -> Vec<RecordedMessage> {
    let (records, states) = fixtures::flown();
    let mission = fixtures::mission();
    let mut now = MonotonicNs(1_000);
    let mut cartographer = Cartographer::new(ROBOT);
    cartographer.on(perception::Event::Terrain(fixtures::RUN, mission.terrain.clone()), now);
    cartographer.on(perception::Event::Brief(fixtures::brief()), now);
    let mut messages =
        vec![RecordedMessage::Heartbeat(fixtures::heartbeat()), RecordedMessage::Brief(fixtures::brief())];
    for state in states {
        messages.push(RecordedMessage::State(state));
        for effect in cartographer.on(perception::Event::State(state), now) {
            if effect == perception::Effect::PublishMap {
                now = now.plus_ns(7);
                messages
                    .extend(cartographer.patches(now, &mut || now).into_iter().map(RecordedMessage::Patch));
            }
        }
        if !state.status.is_over() {
            messages.push(RecordedMessage::Command(fixtures::command(&state)));
        }
    }
    let request = contract::MapRequest { run: fixtures::RUN, robot: ROBOT, from: 0, observation: 0 };
    messages.extend(cartographer.page(&request).map(RecordedMessage::Page));
    let (run, robot, from) = (fixtures::RUN, ROBOT, contract::Decision(0));
    messages.push(RecordedMessage::Past(PastPage { run, robot, from, records }));
    let cell = PolicyCell { action: contract::Action::Hold, value: -1.5 };
    messages.push(RecordedMessage::Policy(Policy {
        run,
        robot,
        decision: contract::Decision(3),
        planner: "mdp".parse().expect("a name"),
        error_bound: 0.25,
        cells: vec![cell; 42],
    }));
    for order in [Order::Pause, Order::Pace(Pace::Hertz(2.5)), Order::HandOver(contract::Incarnation(7))] {
        messages.push(RecordedMessage::Control(Control { run, robot, order }));
    }
    let (pace, paused, obeys) = (Pace::Real, true, true);
    messages.push(RecordedMessage::Pacing(Pacing { run, robot, pace, paused, obeys }));
    let host =
        MachineLoad { since: MonotonicNs(5), until: MonotonicNs(9), busy: 0.5, load_1min: 1.25, cores: 2 };
    messages.push(RecordedMessage::Host(host));
    let topic = "hop/state".into();
    messages.push(RecordedMessage::Gap(SequenceGap {
        topic,
        from: 3,
        through: 4,
        counted: "decisions".into(),
    }));
    messages
}

/// A recording of [`messages`], a chunk closed after every tenth.
#[must_use]
pub fn seeds() -> Vec<Vec<u8>> {
    let told = [("seed", "42"), ("format", "1")].map(|(key, value)| (key.to_owned(), value.to_owned()));
    let context = Context::from([("hopper".to_owned(), told.into())]);
    let mut now = MonotonicNs(1_000_000);
    let mut recorder = Recorder::new(&context, now).expect("memory takes it");
    for message in messages() {
        now = now.plus_ns(recording::recorder::CHUNK_NS / 10);
        recorder.on(message, now).expect("memory takes it");
        recorder.tick(now).expect("memory takes it");
    }
    recorder.finish(now).expect("memory takes it");
    vec![recorder.bytes()]
}
