//! `hopper link` beside real missions, and what readers of other makers make of its packets.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "../../../tests/harness/mod.rs"]
mod harness;

use std::collections::BTreeMap;
use std::io::Read as _;
use std::net::{TcpStream, UdpSocket};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;
use std::thread::JoinHandle;

use contract::{Record, State};
use harness::{Mission, Process, lockstep, program, stderr};
use link::GroundMap;
use serde_json::Value;
use telemetry::{EventKind, Packet, Telemetry, packet_length};

/// What reads packets by their XTCE, and headers.
const REQUIREMENTS: &str = "space-packet-parser==6.2.0 spacepackets==0.32.0";

/// The interpreter of a virtual environment in the target folder.
fn python() -> &'static Path {
    static PYTHON: OnceLock<PathBuf> = OnceLock::new();
    PYTHON.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("packets-venv");
        let (interpreter, stamp) = (folder.join("bin/python"), folder.join("requirements.txt"));
        let does = |command: &mut Command, what: &str| {
            let output =
                command.output().unwrap_or_else(|error| panic!("{what} needs python3 with venv: {error}"));
            assert!(output.status.success(), "{what} failed; it needs PyPI once:\n{}", stderr(&output));
        };
        if std::fs::read_to_string(&stamp).ok().as_deref() != Some(REQUIREMENTS) {
            does(
                Command::new("python3").args(["-m", "venv", "--clear"]).arg(&folder),
                "making a virtual environment",
            );
            let mut install = Command::new(&interpreter);
            install.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]);
            does(install.args(REQUIREMENTS.split(' ')), "installing from PyPI");
            std::fs::write(&stamp, REQUIREMENTS).unwrap();
        }
        interpreter
    })
}

/// Starts the link of `mission` on a free TCP port, and reads all that it sends.
fn listen(mission: &Mission, words: &[&str]) -> (Process, JoinHandle<Vec<u8>>) {
    program("hopper-link");
    let link = mission.start("link", &[&["--tcp", "0"], words].concat());
    link.await_log("whoever connects to TCP ");
    let log = link.log();
    let address = log.split("whoever connects to TCP ").nth(1).unwrap().split(';').next().unwrap();
    let mut stream = TcpStream::connect(address).unwrap();
    let reader = std::thread::spawn(move || {
        let mut bytes = Vec::new();
        // A link that is killed resets the connection: what came before counts.
        let _ = stream.read_to_end(&mut bytes);
        bytes
    });
    (link, reader)
}

/// The packets of a stream; the last may be cut.
fn packets(mut stream: &[u8]) -> Vec<Packet> {
    let mut packets = Vec::new();
    while let Some(length) = packet_length(stream)
        && let Some((packet, rest)) = stream.split_at_checked(length)
    {
        packets.push(Packet::decode(packet).unwrap_or_else(|error| panic!("{error}")));
        stream = rest;
    }
    packets
}

/// What the ground knows after these packets.
#[derive(Default)]
struct Ground {
    map: GroundMap,
    records: BTreeMap<u64, Record>,
    state: Option<State>,
    events: Vec<EventKind>,
}

impl Ground {
    fn of(packets: &[Packet]) -> Self {
        let mut ground = Self::default();
        for packet in packets {
            match &packet.body {
                Telemetry::Brief(brief) => ground.map.begin(brief),
                Telemetry::Map(patch) => assert!(ground.map.patch(patch.clone())),
                Telemetry::Past(page) => {
                    ground.records.extend(page.records.iter().map(|record| (record.decision.0, *record)));
                }
                Telemetry::State(state) => ground.state = Some(*state),
                Telemetry::Event(event) => ground.events.push(event.kind),
                _ => {}
            }
        }
        ground
    }

    /// It has all of the mission in the journal.
    fn assert_whole(&self, verified: &Value) {
        let decisions = verified["decisions"].as_u64().unwrap();
        assert!(self.records.keys().copied().eq(0..decisions), "{:?} of {decisions}", self.records.keys());
        let last = &self.records[&(decisions - 1)];
        assert_eq!(last.digest.to_string(), verified["digest"], "the last record");
        let mut digest = self.records[&0].previous;
        for record in self.records.values() {
            assert_eq!(digest.chain(record), record.digest, "decision {}", record.decision);
            digest = record.digest;
        }
        assert_eq!(self.state.unwrap().digest, last.digest);
        assert!(self.map.is_whole() && self.map.map().unwrap().is_of(&self.state.unwrap()));
        assert!(self.events.contains(&EventKind::MissionEnded), "{:?}", self.events);
    }
}

/// P-LINK-LIVE: A link sends every decision of the journal, the last state and the whole map; it ends once all is sent,
/// the mission has the digest of lockstep, and nothing is left behind. XTCE and headers are read by the libraries of
/// others: every packet is of the kind, and every value the one that was sent.
#[test]
fn the_stream_is_the_journal_and_libraries_of_others_read_it() {
    let mut mission = Mission::new("link");
    let (mut link, reader) = listen(&mission, &["--rate", "20000"]);
    let mut processes = vec![mission.start("sim", &["--seed", "1"])];
    processes.extend(mission.start_peers());
    for process in &mut processes {
        assert_eq!(process.code(), 0, "{}", process.log());
    }
    assert_eq!(link.code(), 0, "{}", link.log());
    let stream = reader.join().unwrap();
    let packets = packets(&stream);
    let verified = mission.verified();
    assert_eq!(verified["digest"], lockstep(&["--seed", "1"])["digest"]);
    Ground::of(&packets).assert_whole(&verified);
    mission.assert_nothing_left();

    if suites::is_left_out("packets in Python") {
        return;
    }
    std::fs::write(mission.path("stream.bin"), &stream).unwrap();
    let xtce = mission.hopper(&["link", "xtce"]).output().unwrap();
    assert_eq!(xtce.status.code(), Some(0), "{}", stderr(&xtce));
    std::fs::write(mission.path("hopper.xml"), &xtce.stdout).unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/read_packets.py");
    let mut read = Command::new(python());
    read.arg(script).arg(mission.path("hopper.xml")).arg(mission.path("stream.bin"));
    let told: Output = read.output().unwrap();
    assert!(told.status.success(), "{}", stderr(&told));
    let told: Vec<Value> = serde_json::from_slice(&told.stdout).unwrap();
    assert_eq!(told.len(), packets.len());
    for (told, packet) in told.iter().zip(&packets) {
        assert_as_told(told, packet);
    }
}

/// The values that others read are those that were sent, bit for bit.
fn assert_as_told(told: &Value, packet: &Packet) {
    let kind = packet.body.kind();
    assert_eq!(told["container"], kind.as_str());
    assert_eq!(told["apid"], kind.apid());
    assert_eq!(told["sequence"], packet.sequence);
    assert_eq!(told["service"], serde_json::json!([kind.service().0, packet.body.subtype()]));
    assert_eq!(told["time"], packet.time.units());
    let values = &told["values"];
    let bits = |value: f64| Value::from(format!("{:016x}", value.to_bits()));
    match &packet.body {
        Telemetry::State(state) => {
            assert_eq!(values["state_decision"], state.decision.0);
            assert_eq!(values["state_steps"], state.steps);
            assert_eq!(values["state_status"], state.status.code());
            assert_eq!(values["state_run_0"], (state.run.0 >> 64) as u64);
            assert_eq!(values["state_digest"], state.digest.to_string());
            assert_eq!(values["state_leader_planner"], state.leader.planner.as_str());
            assert_eq!(values["state_pose_cell_0"], state.pose.cell.x);
            assert_eq!(values["state_pose_height_m"], bits(state.pose.height_m));
            assert_eq!(values["state_published_ns"], state.published.0);
            for (place, moment) in state.last_timing.moments().iter().enumerate() {
                assert_eq!(values[format!("state_last_timing_ns_{place}")], moment.0);
            }
            if let Some(outcome) = state.last {
                assert_eq!(values["state_last_flight_time_s"], bits(outcome.flight.flight_time_s));
                assert_eq!(values["state_last_to_1"], outcome.to.y);
            }
        }
        Telemetry::Map(patch) => {
            assert_eq!(values["map_before"], patch.before);
            assert_eq!(values["map_after"], patch.after);
            assert_eq!(values["map_count"], patch.cells.len());
            let cells = values["map_cells"].as_str().unwrap();
            assert_eq!(cells.len(), 64 * patch.cells.len());
            for (place, cell) in patch.cells.iter().enumerate() {
                let told = &cells[64 * place..64 * (place + 1)];
                assert_eq!(told[..16], format!("{:016x}", cell.ground.height_m.to_bits()));
                assert_eq!(told[48..56], format!("{:08x}", cell.index));
            }
        }
        Telemetry::Past(page) => {
            assert_eq!(values["past_from"], page.from.0);
            assert_eq!(values["past_count"], page.records.len());
            let cells = values["past_cells"].as_str().unwrap();
            for (record, told) in page.records.iter().zip(cells.as_bytes().chunks(2 * 376)) {
                let told = std::str::from_utf8(told).unwrap();
                assert_eq!(told[..16], format!("{:016x}", record.decision.0));
                assert!(told.contains(&record.digest.to_string()));
            }
        }
        Telemetry::Event(event) => {
            assert_eq!(values["event_event"], event.kind.code());
            assert_eq!(values["event_value"], event.value);
        }
        Telemetry::Latency(latency) => {
            assert_eq!(values["latency_count"], latency.count);
            assert_eq!(values["latency_max_ns_7"], latency.max_ns[7]);
        }
        Telemetry::Brief(brief) => {
            assert_eq!(values["brief_scenario"], brief.scenario.as_str());
            assert_eq!(values["brief_discount"], bits(brief.payoff.discount));
        }
        Telemetry::Team(_) | Telemetry::Route(_) | Telemetry::Detail(_) => {}
    }
}

/// P-LINK-KILL: A link may be killed and started again at any moment: the next one sends all of the mission, whose
/// digest is that of lockstep.
#[test]
fn a_link_that_is_killed_changes_nothing_and_the_next_one_sends_all() {
    let mission = Mission::new("link-killed");
    let sim = mission.start_slow_sim("2");
    let mut peers = mission.start_peers();
    let (mut first, before) = listen(&mission, &[]);
    mission.await_decisions(3);
    first.kill();
    let (mut second, after) = listen(&mission, &["--stay"]);
    mission.await_decisions(4);
    mission.hurry(sim, "2");
    for process in &mut peers {
        assert_eq!(process.code(), 0, "{}", process.log());
    }
    second.await_log("all of the mission has been sent");
    second.kill();
    let verified = mission.verified();
    assert_eq!(verified["digest"], lockstep(&["--seed", "2"])["digest"]);
    let before = Ground::of(&packets(&before.join().unwrap()));
    assert!(before.state.is_some(), "the first link has sent a state");
    Ground::of(&packets(&after.join().unwrap())).assert_whole(&verified);
}

/// Datagrams to a port where nobody listens disturb nobody; where somebody does, each is a packet.
#[test]
fn a_datagram_is_a_packet_and_nobody_has_to_listen() {
    program("hopper-link");
    let mission = Mission::new("link-udp");
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.set_read_timeout(Some(harness::PATIENCE)).unwrap();
    let heard = socket.local_addr().unwrap().to_string();
    let unheard = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
    let mut links = [&heard, &unheard].map(|address| mission.start("link", &["--udp", address]));
    let mut processes = vec![mission.start("sim", &["--seed", "1"])];
    processes.extend(mission.start_peers());
    let mut bytes = [0; 65_536];
    let mut kinds = Vec::new();
    while !kinds.contains(&telemetry::Kind::State) {
        let (length, _) = socket.recv_from(&mut bytes).unwrap();
        kinds.push(Packet::decode(&bytes[..length]).unwrap().body.kind());
    }
    assert_eq!(kinds[0], telemetry::Kind::Event);
    for process in processes.iter_mut().chain(&mut links) {
        assert_eq!(process.code(), 0, "{}", process.log());
    }
}

#[test]
fn what_cannot_be_sent_is_a_usage_error_with_what_was_needed() {
    program("hopper-link");
    let mission = Mission::new("link-usage");
    for (words, need) in [
        (&["--rate", "0"][..], "1..=1000000000000"),
        (&["--passes", "90m/10m"], "LENGTH/PERIOD"),
        (&["--step", "soon"], "1ms to 100d"),
        (&["--udp", "nowhere"], "an address is e.g."),
        (&["--udp", "1", "--tcp", "2"], "cannot be used with"),
        (&["--tcp", "192.0.2.1:1"], "--tcp cannot listen on 192.0.2.1:1"),
    ] {
        let output =
            mission.hopper(&[&["link", "--instance", &mission.name], words].concat()).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{words:?}: {}", stderr(&output));
        assert!(stderr(&output).contains(need), "{words:?}: {}", stderr(&output));
    }
}
