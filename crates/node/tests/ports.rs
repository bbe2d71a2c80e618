//! Every port carries its messages, late comers are served, and rogue bytes are refused.

use std::time::{Duration, Instant};

use crate::samples::{
    Own, ROBOT, RUN, brief, command, map_page, name, patch, policy, record, state, truth_page,
};
use bytemuck::Zeroable;
use contract::message::{Capacity, PublishSubscribe};
use contract::wire::{GroundV2, MapPageV2, MapPatchV2, SeenCellV4, StateV4, TruthPageV1};
use contract::{
    Brief, Command, Decision, Incarnation, MapPatch, MapRequest, Message, Name, PastPage, PastRequest,
    Payload, Policy, Refusal, Request, Role, RunId, State, Status, TruthRequest,
};
use node::{MemoryBudget, Node, NodeError, Wake};
use process::{Client as _, Membership, Ports, Reader as _, Server as _, Terms, Writer as _};

/// Two nodes that may use every port.
fn pair(own: &Own) -> (Node, Node) {
    (Node::visit(&own.0).unwrap(), Node::visit(&own.0).unwrap())
}

fn messages<M: Message>(reader: &mut node::Reader<M>) -> Vec<M> {
    reader.drain().into_iter().collect::<Result<_, _>>().unwrap()
}

#[test]
fn every_topic_carries_its_message() {
    let own = Own::new();
    {
        let (mut a, mut b) = pair(&own);
        let (mut writer, mut reader) =
            (a.writer::<Brief>(ROBOT).unwrap(), b.reader::<Brief>(ROBOT, false).unwrap());
        writer.publish(brief()).unwrap();
        assert_eq!(reader.newest(), Some(Ok(brief())));

        let (mut writer, mut reader) =
            (a.writer::<State>(ROBOT).unwrap(), b.reader::<State>(ROBOT, false).unwrap());
        writer.publish(state(1)).unwrap();
        writer.publish(state(2)).unwrap();
        let seen = messages(&mut reader);
        assert_eq!(seen, [state(1), state(2)]);
        assert_eq!(reader.newest(), None);

        let (mut writer, mut reader) =
            (b.writer::<Command>(ROBOT).unwrap(), a.reader::<Command>(ROBOT, false).unwrap());
        writer.publish(command(0)).unwrap();
        assert_eq!(reader.receive(), Some(Ok(command(0))));

        let (mut writer, mut reader) =
            (a.writer::<MapPatch>(ROBOT).unwrap(), b.reader::<MapPatch>(ROBOT, false).unwrap());
        writer.publish(patch(1)).unwrap();
        writer.publish(patch(2)).unwrap();
        let seen = messages(&mut reader);
        assert_eq!(seen, [patch(1), patch(2)], "no patch gives way to the next");

        let (mut writer, mut reader) =
            (b.writer::<Policy>(ROBOT).unwrap(), a.reader::<Policy>(ROBOT, false).unwrap());
        assert_eq!(writer.readers(), 1);
        writer.publish(policy()).unwrap();
        assert_eq!(reader.newest(), Some(Ok(policy())));
        drop(reader);
        assert_eq!(writer.readers(), 0);
    }
    own.assert_gone();
}

#[test]
fn the_past_is_asked_for_and_answered() {
    let own = Own::new();
    {
        let (mut a, mut b) = pair(&own);
        let (mut server, mut client) =
            (a.server::<PastRequest>(ROBOT).unwrap(), b.client::<PastRequest>(ROBOT).unwrap());
        let page = |request: &PastRequest| PastPage {
            run: request.run,
            robot: request.robot,
            from: request.from,
            records: (request.from.0..request.from.0 + 64).map(record).collect(),
        };
        for from in [0, 64] {
            let request = PastRequest { run: RUN, robot: ROBOT, from: Decision(from) };
            assert_eq!(client.receive(), None);
            client.request(request).unwrap();
            assert_eq!(a.sleep(Duration::from_secs(5)), Wake::Event, "a request wakes the server");
            assert_eq!(server.serve(|request| Some(page(request))).unwrap(), []);
            assert_eq!(b.sleep(Duration::from_secs(5)), Wake::Event, "an answer wakes the client");
            assert_eq!(client.receive(), Some(Ok(page(&request))));
        }
        let request = PastRequest { run: RUN, robot: ROBOT, from: Decision(9) };
        for _ in 0..100 {
            client.request(request).unwrap();
        }
        server.serve(|request| Some(page(request))).unwrap();
        assert_eq!(client.receive(), Some(Ok(page(&request))), "only the last of many requests is answered");
        client.request(request).unwrap();
        server.serve(|_| None).unwrap();
        assert_eq!(client.receive(), None, "a request may go unanswered");
        let long =
            |request: &PastRequest| PastPage { records: (0..65).map(record).collect(), ..page(request) };
        client.request(request).unwrap();
        assert!(matches!(
            server.serve(|request| Some(long(request))),
            Err(NodeError::Oversize { need: 64, got: 65, .. })
        ));
    }
    own.assert_gone();
}

#[test]
fn a_client_that_asks_without_end_keeps_the_server_from_nothing() {
    let own = Own::new();
    {
        let (mut a, mut b) = pair(&own);
        let (mut server, mut rogue) =
            (a.server::<TruthRequest>(ROBOT).unwrap(), b.client::<TruthRequest>(ROBOT).unwrap());
        let mut honest = a.client::<TruthRequest>(ROBOT).unwrap();
        let request = TruthRequest { run: RUN, from: 0 };
        rogue.request(request).unwrap();
        let mut answered = 0;
        let answer = |_: &TruthRequest| {
            answered += 1;
            assert!(answered < 1000, "a turn has an end");
            // It asks again before it has its answer.
            rogue.request(request).unwrap();
            Some(truth_page(&request))
        };
        server.serve(answer).unwrap();
        assert_eq!(
            answered,
            TruthRequest::SERVICE.max_clients,
            "one answer a client, then the rest of the turn"
        );
        honest.request(request).unwrap();
        assert_eq!(a.sleep(Duration::from_secs(5)), Wake::Event, "what is left ends the next wait");
        server.serve(|request| Some(truth_page(request))).unwrap();
        assert_eq!(honest.receive(), Some(Ok(truth_page(&request))), "whoever else asks is answered");
    }
    own.assert_gone();
}

#[test]
fn truth_and_snapshot_are_asked_for_and_answered() {
    let own = Own::new();
    {
        let (mut a, mut b) = pair(&own);
        let (mut server, mut client) =
            (a.server::<TruthRequest>(ROBOT).unwrap(), b.client::<TruthRequest>(ROBOT).unwrap());
        for from in [0, 12] {
            let request = TruthRequest { run: RUN, from };
            client.request(request).unwrap();
            assert_eq!(a.sleep(Duration::from_secs(5)), Wake::Event, "a request wakes the server");
            assert_eq!(server.serve(|request| Some(truth_page(request))).unwrap(), []);
            assert_eq!(b.sleep(Duration::from_secs(5)), Wake::Event, "an answer wakes the client");
            assert_eq!(client.receive(), Some(Ok(truth_page(&request))));
        }
        let (mut server, mut client) =
            (a.server::<MapRequest>(ROBOT).unwrap(), b.client::<MapRequest>(ROBOT).unwrap());
        for from in [0, 12] {
            let request = MapRequest { run: RUN, robot: ROBOT, from, observation: 77 };
            client.request(request).unwrap();
            assert_eq!(server.serve(|request| Some(map_page(request))).unwrap(), []);
            assert_eq!(client.receive(), Some(Ok(map_page(&request))));
        }
        let error = b.server::<MapRequest>(ROBOT).unwrap_err();
        assert!(error.to_string().contains("hop/snapshot"), "the map has one server: {error}");
    }
    own.assert_gone();
}

#[test]
fn a_late_reader_gets_the_last_state_once_the_writer_idles_and_asks_for_the_map() {
    let own = Own::new();
    {
        let (mut a, mut b) = pair(&own);
        let mut states = a.writer::<State>(ROBOT).unwrap();
        let mut maps = a.writer::<MapPatch>(ROBOT).unwrap();
        states.publish(state(6)).unwrap();
        states.publish(state(7)).unwrap();
        maps.publish(patch(7)).unwrap();
        let (mut late_states, mut late_maps) =
            (b.reader::<State>(ROBOT, false).unwrap(), b.reader::<MapPatch>(ROBOT, false).unwrap());
        assert_eq!(late_states.newest(), None);
        states.idle();
        maps.idle();
        assert_eq!(late_states.newest(), Some(Ok(state(7))));
        assert_eq!(late_maps.newest(), None, "an old patch is of no use without those before it");
    }
    own.assert_gone();
}

#[test]
fn a_reader_survives_its_writer() {
    let own = Own::new();
    {
        let (mut a, mut b) = pair(&own);
        let mut reader = b.reader::<State>(ROBOT, false).unwrap();
        let mut first = a.writer::<State>(ROBOT).unwrap();
        first.publish(state(1)).unwrap();
        drop((first, a));
        let mut restarted = Node::visit(&own.0).unwrap();
        let mut second = restarted.writer::<State>(ROBOT).unwrap();
        second.publish(state(2)).unwrap();
        let seen = messages(&mut reader);
        assert_eq!(seen.last(), Some(&state(2)));
    }
    own.assert_gone();
}

#[test]
fn a_second_writer_of_a_single_writer_topic_is_refused_by_name() {
    let own = Own::new();
    {
        let (mut a, mut b) = pair(&own);
        let _first = a.writer::<State>(ROBOT).unwrap();
        let error = b.writer::<State>(ROBOT).unwrap_err();
        assert!(error.to_string().contains("hop/state"), "{error}");
        assert!(matches!(error, NodeError::Full { what: "publishing", .. }), "{error}");
    }
    own.assert_gone();
}

#[test]
fn a_malformed_sample_is_refused_by_name() {
    let own = Own::new();
    {
        let (mut a, mut b) = pair(&own);
        let (mut writer, mut reader) =
            (a.writer::<State>(ROBOT).unwrap(), b.reader::<State>(ROBOT, false).unwrap());
        writer.publish_wire((), &[StateV4 { status: 99, ..StateV4::from(&state(1)) }]).unwrap();
        let refusal = reader.newest().unwrap().unwrap_err();
        assert_eq!(refusal.to_string(), "field state.status needs a known tag, got 99");
        let mut wire = StateV4::from(&state(1));
        wire.pose.height_m = f64::NAN;
        writer.publish_wire((), &[wire]).unwrap();
        assert!(reader.newest().unwrap().unwrap_err().to_string().contains("pose.height_m"));
        writer.publish_wire((), &[]).unwrap();
        let refusal = reader.newest().unwrap().unwrap_err();
        assert_eq!(refusal.to_string(), "field payload needs one element, got 0");
        writer.publish(state(2)).unwrap();
        assert_eq!(reader.newest(), Some(Ok(state(2))), "the next good one is read");
    }
    own.assert_gone();
}

/// What a reader says of a message that is `patch(1)` but for what `twist` does to it.
fn refusal(twist: impl Fn(&mut MapPatchV2, &mut [SeenCellV4])) -> Refusal {
    let mut header = MapPatchV2::from(&patch(1));
    let mut cells: Vec<SeenCellV4> = patch(1).cells.iter().map(SeenCellV4::from).collect();
    contract::wire::patch_from_wire(&header, &cells).unwrap();
    twist(&mut header, &mut cells);
    contract::wire::patch_from_wire(&header, &cells).unwrap_err()
}

/// P-HOSTILE-MAP: A patch, a page or a piece of the truth with any field out of range is refused,
/// and the error names the field.
#[test]
fn a_patch_or_page_out_of_range_is_refused_by_name() {
    assert_eq!(
        refusal(|_, cells| cells[5].index = 20).to_string(),
        "field cell.index needs 8 to 19 in order, got 20"
    );
    for (field, refusal) in [
        ("cell.index", refusal(|_, cells| cells[0].index = u32::MAX)),
        ("cell.index", refusal(|_, cells| cells[1].index = 3)),
        ("cell.index", refusal(|_, cells| cells.swap(1, 2))),
        ("cell.height_m", refusal(|_, cells| cells[2].height_m = f64::NAN)),
        ("cell.height_m", refusal(|_, cells| cells[2].height_m = 1e300)),
        ("cell.gradient", refusal(|_, cells| cells[2].gradient[1] = f64::INFINITY)),
        ("cell.soil", refusal(|_, cells| cells[2].soil = 4)),
        ("cell.soil", refusal(|_, cells| cells[2].soil = u8::MAX)),
        ("map.sequence", refusal(|header, _| header.sequence = u64::MAX)),
        ("map.through", refusal(|header, _| header.through = u64::MAX)),
        ("map.seen_cells", refusal(|header, _| header.seen_cells = 21)),
        ("map.more", refusal(|header, _| header.more = u32::MAX)),
        ("map.treasures", refusal(|header, _| header.treasure_count = 17)),
        ("map.treasures", refusal(|header, _| header.treasure_count = u32::MAX)),
        ("map.treasures", refusal(|header, _| header.treasure_count = 2)),
        ("map.treasures", refusal(|header, _| header.treasures[0] = [i32::MAX, 0])),
        ("map.grid", refusal(|header, _| header.width = 0)),
        ("map.grid", refusal(|header, _| header.width = u32::MAX)),
        ("map.grid", refusal(|header, _| header.cell_size_m = f64::NAN)),
        ("cell.index", refusal(|header, cells| (header.height, cells[5].index) = (2, 10))),
    ] {
        assert!(refusal.to_string().contains(field), "{field}: {refusal}");
        assert_eq!(refusal.reason(), "malformed", "{field}");
    }
    let cell = SeenCellV4::from(&patch(1).cells[0]);
    let refusal = contract::wire::patch_from_wire(&MapPatchV2::from(&patch(1)), &[cell; 1025]).unwrap_err();
    assert_eq!(refusal.to_string(), "field map.cells needs at most 1024 cells, got 1025");

    let request = MapRequest { run: RUN, robot: ROBOT, from: 3, observation: 0 };
    let header = MapPageV2::from(&map_page(&request));
    for (from, next) in [(3, 21), (5, 4), (0, u32::MAX), (u32::MAX, u32::MAX)] {
        let refusal =
            contract::wire::map_page_from_wire(&MapPageV2 { from, next, ..header }, &[]).unwrap_err();
        assert!(refusal.to_string().contains("map.next"), "{from} to {next}: {refusal}");
    }
    let refusal = contract::wire::map_page_from_wire(&MapPageV2 { from: 4, ..header }, &[cell]).unwrap_err();
    assert!(refusal.to_string().contains("cell.index"), "outside of its stretch: {refusal}");

    let header = TruthPageV1::from(&truth_page(&TruthRequest { run: RUN, from: 0 }));
    let hard = GroundV2 { soil: 1, ..GroundV2::zeroed() };
    for (field, header, cells) in [
        ("ground.soil", header, vec![GroundV2::zeroed()]),
        ("truth.cells", header, vec![hard; 21]),
        ("truth.cells", TruthPageV1 { from: 20, ..header }, vec![hard]),
        ("truth.cells", TruthPageV1 { from: u32::MAX, ..header }, vec![hard]),
        ("truth.grid", TruthPageV1 { height: 0, ..header }, vec![hard]),
    ] {
        let refusal = contract::wire::truth_page_from_wire(&header, &cells).unwrap_err();
        assert!(refusal.to_string().contains(field), "{field}: {refusal}");
    }
}

#[test]
fn an_oversize_message_is_an_error() {
    let own = Own::new();
    {
        let (mut a, _b) = pair(&own);
        let mut writer = a.writer::<MapPatch>(ROBOT).unwrap();
        let patch = contract::MapPatch { cells: vec![patch(1).cells[0]; 1025], ..patch(1) };
        let error = writer.publish(patch).unwrap_err();
        assert_eq!(error.to_string(), "service hop/map needs at most 1024 cells in a message, got 1025");
    }
    own.assert_gone();
}

/// A message of more cells than any shared memory holds.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
struct Huge;

impl Payload for Huge {
    type Header = ();
    type Cell = SeenCellV4;

    fn header(&self) {}

    fn cells(&self) -> usize {
        1 << 40
    }

    fn cell(&self, _index: usize) -> SeenCellV4 {
        unreachable!("it is refused before it is written")
    }

    fn from_wire((): &(), _cells: &[SeenCellV4]) -> Result<Self, Refusal> {
        Ok(Self)
    }
}

impl Message for Huge {
    const SERVICE: PublishSubscribe = PublishSubscribe {
        capacity: Capacity::Grid,
        ..PublishSubscribe::new("hop/rN/huge", &[Role::Planner])
    };
}

#[test]
fn a_writer_that_shared_memory_cannot_hold_is_refused_with_both_numbers() {
    let own = Own::new();
    {
        let (mut a, _b) = pair(&own);
        let error = a.writer::<Huge>(ROBOT).unwrap().publish(Huge).unwrap_err();
        assert!(matches!(error, NodeError::NoRoom { need_bytes, free_bytes, .. } if need_bytes > free_bytes));
    }
    own.assert_gone();
}

#[test]
#[should_panic(expected = "planner must not write hop/state")]
fn a_role_must_not_write_what_another_writes() {
    let own = Own::new();
    let _ = Node::join(&own.0, Role::Planner).unwrap().writer::<State>(ROBOT);
}

#[test]
#[should_panic(expected = "monitor must not serve truth/terrain")]
fn a_role_must_not_serve_what_another_serves() {
    let own = Own::new();
    let _ = Node::join(&own.0, Role::Monitor).unwrap().server::<TruthRequest>(ROBOT);
}

/// P-ROOM-ON-DEMAND: A policy takes memory once it is published, and never more than the last one
/// needs.
#[test]
fn a_policy_takes_room_once_it_is_published_and_no_more_than_the_last_one_needs() {
    let own = Own::new();
    {
        let (mut a, mut b) = pair(&own);
        let mut writer = a.writer::<Policy>(ROBOT).unwrap();
        assert_eq!(writer.readers(), 0);
        let mut reader = b.reader::<Policy>(ROBOT, false).unwrap();
        assert_eq!(writer.readers(), 1);
        let before = used(&own);
        let of = |side: usize| contract::Policy { cells: vec![policy().cells[0]; side * side], ..policy() };
        let mut bytes_a_cell = [300, 300, 200, 300].map(|side| {
            for _ in 0..3 {
                writer.publish(of(side)).unwrap();
                assert_eq!(reader.newest(), Some(Ok(of(side))), "{side}");
            }
            (used(&own) - before) / (side * side) as u64
        });
        // Seven slots of 16 bytes a cell, and not twice that.
        bytes_a_cell.sort_unstable();
        assert!(bytes_a_cell[0] >= 112 && bytes_a_cell[3] < 128, "{bytes_a_cell:?} bytes a cell");
    }
    own.assert_gone();
}

#[test]
fn news_wakes_who_listens_and_silence_times_out() {
    let own = Own::new();
    {
        let (mut a, mut b) = pair(&own);
        let _readers = [b.reader::<State>(ROBOT, true).unwrap(), b.reader::<State>(ROBOT, true).unwrap()];
        let mut writer = a.writer::<State>(ROBOT).unwrap();
        assert_eq!(b.sleep(Duration::from_millis(5)), Wake::Timeout);
        for decision in 0..3 {
            writer.publish(state(decision)).unwrap();
            assert_eq!(b.sleep(Duration::from_secs(5)), Wake::Event);
            assert_eq!(b.sleep(Duration::from_millis(5)), Wake::Timeout, "one wake for one message");
        }
        let started = Instant::now();
        assert_eq!(a.sleep(Duration::from_millis(20)), Wake::Timeout);
        assert!(started.elapsed() >= Duration::from_millis(20));
    }
    own.assert_gone();
}

#[test]
fn heartbeats_advance_at_their_pace_and_at_once_when_the_mission_ends() {
    let own = Own::new();
    {
        let mut sim = Node::join(&own.0, Role::HopperSim).unwrap();
        let mut planner = Node::join(&own.0, Role::Planner).unwrap();
        let terms = Terms::default();
        let mut listening = Membership::join(&mut sim, Role::HopperSim, Name::NONE, terms).unwrap();
        let mut beating = Membership::join(&mut planner, Role::Planner, name("mdp"), terms).unwrap();
        assert_eq!(listening.hear(Node::now()), None);
        let started = Instant::now();
        let mut beats = Vec::new();
        while beats.len() < 5 {
            assert!(started.elapsed() < Duration::from_secs(60), "{} beats in a minute", beats.len());
            beating.beat((RUN, Decision(4), Status::Underway), Node::now()).unwrap();
            while let Some(beat) = listening.hear(Node::now()) {
                beats.push(beat.unwrap());
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        let least = Duration::from_nanos(4 * contract::protocol::peer_table::BEAT_PERIOD_NS);
        assert!(started.elapsed() >= least, "five beats in {:?}", started.elapsed());
        assert!(beats.is_sorted_by(|a, b| a.counter < b.counter), "the counter advances");
        let beat = beats.last().unwrap();
        let incarnation = planner.incarnation();
        assert_eq!((beat.role, beat.incarnation, beat.pid), (Role::Planner, incarnation, planner.pid()));
        assert_eq!((beat.planner, beat.run, beat.decision), (name("mdp"), RUN, Decision(4)));
        assert_ne!(beat.incarnation, Incarnation(0));
        assert_ne!(sim.incarnation(), planner.incarnation());
        beating.beat((RUN, Decision(5), Status::Goal), Node::now()).unwrap();
        let end = listening.hear(Node::now()).unwrap().unwrap();
        assert_eq!((end.status, end.counter), (Status::Goal, beat.counter + 1));
        listening.beat((RunId(0), Decision(0), Status::Underway), Node::now()).unwrap();
        assert_eq!(listening.hear(Node::now()), None, "our own beats are left out");
    }
    own.assert_gone();
}

/// P-ROOM: The memory budget that `doctor` computes is what the ports take.
#[test]
fn what_a_port_needs_is_what_it_takes() {
    let own = Own::new();
    {
        let (mut a, mut b) = pair(&own);
        let cells = 821 * 821;
        let budget = MemoryBudget::of(cells, 1).unwrap();
        let mut before = used(&own);
        let mut taken = || {
            let taken = used(&own) - before;
            before += taken;
            taken
        };
        let _map = a.writer::<MapPatch>(ROBOT).unwrap();
        let map = taken();
        let _truth = a.server::<TruthRequest>(ROBOT).unwrap();
        let truth = taken();
        let _snapshot = a.server::<MapRequest>(ROBOT).unwrap();
        let snapshot = taken();
        let _past = a.server::<PastRequest>(ROBOT).unwrap();
        let past = taken();
        let mut policies = [a.writer::<Policy>(ROBOT).unwrap(), b.writer::<Policy>(ROBOT).unwrap()];
        for writer in &mut policies {
            writer.publish(Policy { cells: vec![policy().cells[0]; cells], ..policy() }).unwrap();
        }
        let policies_taken = taken();
        for (name, taken) in [
            ("hop/map", map),
            ("truth/terrain", truth),
            ("hop/snapshot", snapshot),
            ("hop/past", past),
            ("hop/r0/policy", policies_taken),
        ] {
            let reckoned = budget.services.iter().find(|service| service.service == name).unwrap().bytes;
            assert!(reckoned + 400_000 > taken, "{name}: reckoned {reckoned} bytes, took {taken}");
            assert!(
                reckoned < taken + taken / 10 + 400_000,
                "{name}: reckoned {reckoned} bytes, took {taken}"
            );
        }
        assert!(budget.need_bytes < 256_000_000, "{} bytes at 821 x 821", budget.need_bytes);
        assert!(MemoryBudget::of(400, 1).unwrap().need_bytes < 64 << 20, "the default mission runs in 64 MB");
        budget.check(&own.0).unwrap();
    }
    own.assert_gone();
}

/// P-ROOM-GRID: On a larger grid only the policy takes more shared memory.
#[test]
fn on_a_larger_grid_the_policy_alone_takes_more_room() {
    let [small, large] = [400, 821 * 821].map(|cells| MemoryBudget::of(cells, 1).unwrap().services);
    let differ = small.iter().zip(&large).filter(|(small, large)| small != large);
    let differ: Vec<&str> = differ.map(|(small, _)| small.service.as_str()).collect();
    assert_eq!((small.len(), &differ[..]), (large.len(), &["hop/r0/policy"][..]));
}

fn used(own: &Own) -> u64 {
    let size = |name: &String| {
        std::fs::metadata(format!("{}/{name}", node::SHARED_MEMORY)).map_or(0, |data| data.len())
    };
    own.files().iter().map(size).sum()
}
