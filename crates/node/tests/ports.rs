//! Every port carries its messages, late comers are served, and rogue bytes are refused.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

mod samples;

use std::time::{Duration, Instant};

use bytemuck::Zeroable;
use contract::wire::{GroundV1, MapHeaderV2, StateV2};
use contract::{Decision, Incarnation, Name, PastPage, PastRequest, Role, RunId, Status, service};
use node::{Node, NodeError, Wake};
use samples::{Own, ROBOT, RUN, brief, command, map, name, policy, record, state, truth};

fn pair(own: &Own) -> (Node, Node) {
    let sim = Node::join(&own.0, Role::HopperSim, Name::NONE).unwrap();
    let planner = Node::join(&own.0, Role::Planner, name("mdp")).unwrap();
    (sim, planner)
}

#[test]
fn every_topic_carries_its_message() {
    let own = Own::new();
    {
        let (a, b) = pair(&own);
        let cells = samples::grid().cells();

        let (writer, mut reader) = (a.brief_writer().unwrap(), b.brief_reader().unwrap());
        writer.publish(&brief()).unwrap();
        assert_eq!(reader.newest(), Some(Ok(brief())));

        let (writer, mut reader) = (a.state_writer(ROBOT).unwrap(), b.state_reader(ROBOT).unwrap());
        writer.publish(&state(1)).unwrap();
        writer.publish(&state(2)).unwrap();
        let seen: Vec<_> = reader.drain().collect::<Result<_, _>>().unwrap();
        assert_eq!(seen, [state(1), state(2)]);
        assert_eq!(reader.newest(), None);

        let (writer, mut reader) = (b.command_writer(ROBOT).unwrap(), a.command_reader(ROBOT).unwrap());
        writer.publish(&command(0)).unwrap();
        assert_eq!(reader.receive(), Some(Ok(command(0))));

        let (writer, mut reader) = (a.terrain_writer(cells).unwrap(), b.terrain_reader().unwrap());
        writer.publish(&truth()).unwrap();
        assert_eq!(reader.newest(), Some(Ok(truth())));

        let (writer, mut reader) = (a.map_writer(ROBOT, cells).unwrap(), b.map_reader(ROBOT).unwrap());
        writer.publish(&map(1)).unwrap();
        writer.publish(&map(2)).unwrap();
        assert_eq!(reader.newest(), Some(Ok(map(2))), "the newest wins");

        let (writer, mut reader) = (b.policy_writer(ROBOT, cells).unwrap(), a.policy_reader(ROBOT).unwrap());
        assert!(writer.has_readers());
        writer.publish(&policy()).unwrap();
        assert_eq!(reader.newest(), Some(Ok(policy())));
        drop(reader);
        assert!(!writer.has_readers());
    }
    own.assert_gone();
}

#[test]
fn the_past_is_asked_for_and_answered() {
    let own = Own::new();
    {
        let (mut a, mut b) = pair(&own);
        let (mut server, mut client) = (a.past_server().unwrap(), b.past_client().unwrap());
        let page = |request: &PastRequest| PastPage {
            run: request.run,
            robot: request.robot,
            from: request.from,
            records: (request.from.0..request.from.0 + 64).map(record).collect(),
        };
        for from in [0, 64] {
            let request = PastRequest { run: RUN, robot: ROBOT, from: Decision(from) };
            assert_eq!(client.receive(), None);
            client.request(&request).unwrap();
            assert_eq!(a.wait(Duration::from_secs(5)), Wake::Event, "a request wakes the server");
            assert_eq!(server.serve(page).unwrap(), []);
            assert_eq!(b.wait(Duration::from_secs(5)), Wake::Event, "an answer wakes the client");
            assert_eq!(client.receive(), Some(Ok(page(&request))));
        }
        let request = PastRequest { run: RUN, robot: ROBOT, from: Decision(9) };
        for _ in 0..100 {
            client.request(&request).unwrap();
        }
        server.serve(page).unwrap();
        assert_eq!(client.receive(), Some(Ok(page(&request))), "only the last of many requests is answered");
        client.request(&request).unwrap();
        server.serve(|_| None).unwrap();
        assert_eq!(client.receive(), None, "a request may go unanswered");
        let long =
            |request: &PastRequest| PastPage { records: (0..65).map(record).collect(), ..page(request) };
        client.request(&request).unwrap();
        assert!(matches!(server.serve(long), Err(NodeError::Oversize { need: 64, got: 65, .. })));
    }
    own.assert_gone();
}

#[test]
fn a_late_reader_gets_the_last_message_once_the_writer_idles() {
    let own = Own::new();
    {
        let (a, b) = pair(&own);
        let states = a.state_writer(ROBOT).unwrap();
        let maps = a.map_writer(ROBOT, samples::grid().cells()).unwrap();
        states.publish(&state(6)).unwrap();
        states.publish(&state(7)).unwrap();
        maps.publish(&map(7)).unwrap();
        let (mut late_states, mut late_maps) = (b.state_reader(ROBOT).unwrap(), b.map_reader(ROBOT).unwrap());
        assert_eq!(late_states.newest(), None);
        states.idle().unwrap();
        maps.idle().unwrap();
        assert_eq!(late_states.newest(), Some(Ok(state(7))));
        assert_eq!(late_maps.newest(), Some(Ok(map(7))));
    }
    own.assert_gone();
}

#[test]
fn a_reader_survives_its_writer() {
    let own = Own::new();
    {
        let (a, b) = pair(&own);
        let mut reader = b.state_reader(ROBOT).unwrap();
        let first = a.state_writer(ROBOT).unwrap();
        first.publish(&state(1)).unwrap();
        drop((first, a));
        let restarted = Node::join(&own.0, Role::HopperSim, Name::NONE).unwrap();
        let second = restarted.state_writer(ROBOT).unwrap();
        second.publish(&state(2)).unwrap();
        let seen: Vec<_> = reader.drain().collect::<Result<_, _>>().unwrap();
        assert_eq!(seen.last(), Some(&state(2)));
    }
    own.assert_gone();
}

#[test]
fn a_second_writer_of_a_single_writer_topic_is_refused_by_name() {
    let own = Own::new();
    {
        let (a, b) = pair(&own);
        let _first = a.state_writer(ROBOT).unwrap();
        let error = b.state_writer(ROBOT).unwrap_err();
        assert!(error.to_string().contains("hop/r0/state"), "{error}");
        assert!(matches!(error, NodeError::Open { what: "publishing", .. }), "{error}");
    }
    own.assert_gone();
}

#[test]
fn a_malformed_sample_is_refused_by_name() {
    let own = Own::new();
    {
        let (a, b) = pair(&own);
        let (writer, mut reader) = (a.state_writer(ROBOT).unwrap(), b.state_reader(ROBOT).unwrap());
        writer.publish_wire(StateV2 { status: 99, ..StateV2::from(&state(1)) }).unwrap();
        let refusal = reader.newest().unwrap().unwrap_err();
        assert_eq!(refusal.to_string(), "field state.status needs a known tag, got 99");
        let mut wire = StateV2::from(&state(1));
        wire.pose.height_m = f64::NAN;
        writer.publish_wire(wire).unwrap();
        assert!(reader.newest().unwrap().unwrap_err().to_string().contains("pose.height_m"));
        writer.publish(&state(2)).unwrap();
        assert_eq!(reader.newest(), Some(Ok(state(2))), "the next good one is read");

        let (writer, mut reader) = (a.map_writer(ROBOT, 20).unwrap(), b.map_reader(ROBOT).unwrap());
        writer.publish_wire(&MapHeaderV2::from(&map(1)), 3, |_| GroundV1::zeroed()).unwrap();
        let refusal = reader.newest().unwrap().unwrap_err();
        assert_eq!(refusal.to_string(), "field map.cells needs 20 cells, got 3");

        let (writer, mut reader) = (a.terrain_writer(20).unwrap(), b.terrain_reader().unwrap());
        let header = contract::wire::TerrainHeaderV2::new(RUN, &samples::grid(), &[]);
        writer.publish_wire(&header, 20, |_| GroundV1::UNSEEN).unwrap();
        let refusal = reader.newest().unwrap().unwrap_err();
        assert!(refusal.to_string().contains("terrain.soil"), "the truth has no unseen cell: {refusal}");
    }
    own.assert_gone();
}

#[test]
fn a_list_of_treasures_that_cannot_be_is_refused() {
    let mut seen = map(1);
    let all: Vec<contract::Cell> = seen.grid.iter().collect();
    let ground = seen.cells.iter().flatten().copied().next();
    seen.cells.fill(ground);
    seen.treasures = vec![all[1], all[3]];
    let ground: Vec<GroundV1> = seen.cells.iter().map(|ground| ground.as_ref().into()).collect();
    let read = |change: fn(&mut MapHeaderV2)| {
        let mut header = MapHeaderV2::from(&seen);
        change(&mut header);
        contract::wire::map_from_wire(&header, &ground)
    };
    assert_eq!(read(|_| {}).unwrap(), seen);
    let changes: [fn(&mut MapHeaderV2); 5] = [
        |header| header.treasure_count = 17,
        |header| header.treasure_count = u32::MAX,
        |header| header.treasures.swap(0, 1),
        |header| header.treasures[1] = header.treasures[0],
        |header| header.treasures[1] = [i32::MAX, 0],
    ];
    for (index, change) in changes.into_iter().enumerate() {
        let refusal = read(change).unwrap_err().to_string();
        assert!(refusal.contains("map.treasures"), "change {index}: {refusal}");
    }
    let unseen = vec![GroundV1::UNSEEN; ground.len()];
    let refusal = contract::wire::map_from_wire(&MapHeaderV2::from(&seen), &unseen).unwrap_err();
    assert!(refusal.to_string().contains("seen cells"), "{refusal}");
}

#[test]
fn an_oversize_message_is_an_error() {
    let own = Own::new();
    {
        let (a, _b) = pair(&own);
        let writer = a.map_writer(ROBOT, 19).unwrap();
        let error = writer.publish(&map(1)).unwrap_err();
        assert_eq!(error.to_string(), "service hop/r0/map needs at most 19 cells in a message, got 20");
    }
    own.assert_gone();
}

#[test]
fn a_writer_that_shared_memory_cannot_hold_is_refused_with_both_numbers() {
    let own = Own::new();
    {
        let (a, _b) = pair(&own);
        let error = a.map_writer(ROBOT, 1 << 40).unwrap_err();
        assert!(matches!(error, NodeError::NoRoom { need_bytes, free_bytes, .. } if need_bytes > free_bytes));
    }
    own.assert_gone();
}

#[test]
fn news_wakes_who_listens_and_silence_times_out() {
    let own = Own::new();
    {
        let (mut a, mut b) = pair(&own);
        b.listen(&service::state(ROBOT)).unwrap();
        b.listen(&service::state(ROBOT)).unwrap();
        let writer = a.state_writer(ROBOT).unwrap();
        assert_eq!(b.wait(Duration::from_millis(5)), Wake::Timeout);
        for decision in 0..3 {
            writer.publish(&state(decision)).unwrap();
            assert_eq!(b.wait(Duration::from_secs(5)), Wake::Event);
            assert_eq!(b.wait(Duration::from_millis(5)), Wake::Timeout, "one wake for one message");
        }
        let started = Instant::now();
        assert_eq!(a.wait(Duration::from_millis(20)), Wake::Timeout);
        assert!(started.elapsed() >= Duration::from_millis(20));
    }
    own.assert_gone();
}

#[test]
fn heartbeats_advance_at_their_pace_and_at_once_when_the_mission_ends() {
    let own = Own::new();
    {
        let (mut a, mut b) = pair(&own);
        assert_eq!(a.heartbeats(), []);
        let started = Instant::now();
        let mut beats = Vec::new();
        while started.elapsed() < Duration::from_millis(320) {
            b.beat(RUN, Decision(4), Status::Underway).unwrap();
            beats.extend(a.heartbeats().into_iter().map(Result::unwrap));
            std::thread::sleep(Duration::from_millis(1));
        }
        assert!((4..=8).contains(&beats.len()), "{} beats in 320 ms", beats.len());
        assert!(beats.is_sorted_by(|a, b| a.counter < b.counter), "the counter advances");
        let beat = beats.last().unwrap();
        assert_eq!((beat.role, beat.incarnation, beat.pid), (Role::Planner, b.incarnation(), b.pid()));
        assert_eq!((beat.planner, beat.run, beat.decision), (name("mdp"), RUN, Decision(4)));
        assert_ne!(beat.incarnation, Incarnation(0));
        assert_ne!(a.incarnation(), b.incarnation());
        b.beat(RUN, Decision(5), Status::Goal).unwrap();
        let end = a.heartbeats().pop().unwrap().unwrap();
        assert_eq!((end.status, end.counter), (Status::Goal, beat.counter + 1));
        a.beat(RunId(0), Decision(0), Status::Underway).unwrap();
        assert_eq!(a.heartbeats(), [], "our own beats are left out");
    }
    own.assert_gone();
}

#[test]
fn what_a_port_needs_is_what_it_takes() {
    let own = Own::new();
    {
        let (a, _b) = pair(&own);
        let cells = 400;
        let before = used(&own);
        let _map = a.map_writer(ROBOT, cells).unwrap();
        let taken = used(&own) - before;
        let room = node::Room::of(cells, 1).unwrap();
        let reckoned = room.services.iter().find(|service| service.service == "hop/r0/map").unwrap().bytes;
        assert!(reckoned <= taken && taken <= reckoned + 200_000, "reckoned {reckoned} bytes, took {taken}");
        assert!(room.need_bytes < 64 << 20, "the default mission runs in 64 MB");
        room.check().unwrap();
    }
    own.assert_gone();
}

fn used(own: &Own) -> u64 {
    let size = |name: &String| {
        std::fs::metadata(format!("{}/{name}", node::SHARED_MEMORY)).map_or(0, |data| data.len())
    };
    own.files().iter().map(size).sum()
}
