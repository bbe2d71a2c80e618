//! Tests over all kinds of packets, and the table of `docs/ground.md`.

use contract::message::Wire;
use contract::{
    Brief, Decision, Detail, DetailPage, Grid, Leader, MapPatch, MonotonicNs, MotionModel, Name, PastPage,
    PathPoint, Payload, Record, RoutePage, RunId, SeenCell, State, Status, Team, Timing,
};
use proptest::prelude::*;

use crate::{
    Event, EventKind, Headers, Kind, Latency, MissionTime, Packet, PacketError, Telemetry, packet_length,
    table, xtce,
};

/// A wire value with every field at an end of its range: the first or the last.
fn at_ends<W: Wire>(last: bool) -> W {
    let mut wire = W::zeroed();
    for field in W::fields() {
        let end = if last { field.inside.last() } else { field.inside.first() };
        if let Some(end) = end {
            bytemuck::bytes_of_mut(&mut wire)[field.offset..field.offset + end.len()].copy_from_slice(end);
        }
    }
    wire
}

fn read<P: Payload>(header: P::Header, cells: &[P::Cell]) -> P {
    P::from_wire(&header, cells).unwrap_or_else(|refusal| panic!("{refusal}"))
}

fn record(decision: u64) -> Record {
    let mut wire: contract::wire::RecordV5 = at_ends(true);
    wire.decision = decision;
    wire.action = 4;
    wire.route = 0;
    wire.leader = at_ends(true);
    wire.leader.planner = Name::NONE.bytes();
    wire.pose = at_ends(false);
    wire.outcome = at_ends(true);
    wire.timing_ns = [1, 2, 3, 4, 5, 6, 7, 8];
    wire.digest = std::array::from_fn(|at| at as u8);
    Record::try_from(&wire).unwrap()
}

/// A message of each kind, and of some kinds several.
pub fn samples() -> Vec<Telemetry> {
    let run = RunId(0x0123_4567_89ab_cdef_0f1e_2d3c_4b5a_6978);
    let grid = Grid::new(20, 10, 0.5, 1).unwrap();
    let past =
        PastPage { run, robot: contract::RobotId(0), from: Decision(4), records: vec![record(4), record(5)] };
    let mut state = past.records[1].state_after(run, MonotonicNs(77), MonotonicNs(78));
    let first = State { decision: Decision(0), last: None, ..state };
    state.leader = Leader::default();
    let cell: SeenCell = SeenCell::try_from(&contract::wire::SeenCellV4 {
        height_m: 0.1 + 0.2,
        gradient: [-0.0, 1e-300],
        index: 7,
        visits: 513,
        ..at_ends(true)
    })
    .unwrap();
    let patch = MapPatch {
        run,
        robot: contract::RobotId(0),
        through: Decision(6),
        digest: state.digest,
        more: 1,
        sequence: 9,
        before: u64::MAX,
        after: 0x0102_0304_0506_0708,
        sensed: MonotonicNs(5),
        published: MonotonicNs(6),
        grid,
        seen_cells: 3,
        treasures: vec![contract::Cell::new(2, 0)],
        cells: vec![cell, SeenCell { index: 199, ..cell }],
    };
    let point = PathPoint { seconds: 0.25, at_m: [1.0, -2.0, 0.1], leaves_mps: [0.0, -0.0, 3.5] };
    let detail = Detail {
        model: MotionModel::Contact,
        rest_m: [0.1, 0.2, 0.3],
        figures: [0.5; 6],
        path: vec![point; 3],
    };
    let mut latency = Latency::default();
    latency.add(Decision(4), &Timing::from_moments([1, 2, 4, 8, 16, 32, 64, 128].map(MonotonicNs)));
    latency.add(Decision(5), &Timing::from_moments([1, 2, 3, 4, 5, 6, 7, 8].map(MonotonicNs)));
    let mut member: contract::wire::MemberV6 = at_ends(false);
    member.travels = 0;
    member.standing = 1;
    let mut team: contract::wire::TeamHeaderV1 = at_ends(false);
    team.due = 1;
    let route = contract::Route::new(vec![contract::Waypoint { x_m: 0.1, y_m: 2.0 }]).unwrap();
    let name = Name::from_bytes(std::array::from_fn(|at| b"mdp"[..].get(at).copied().unwrap_or(0))).unwrap();
    vec![
        Telemetry::Event(Event::mission_ended(Decision(90), Status::Goal)),
        Telemetry::Event(Event {
            name,
            value: 3,
            ..Event::new(EventKind::LeaderChanged, contract::RobotId(2), Decision(8))
        }),
        Telemetry::Brief(brief(grid)),
        Telemetry::State(state),
        Telemetry::State(first),
        Telemetry::Team(read::<Team>(team, &[member, member])),
        Telemetry::Map(MapPatch { cells: Vec::new(), ..patch.clone() }),
        Telemetry::Map(patch),
        Telemetry::Past(past),
        Telemetry::Route(RoutePage { run, route }),
        Telemetry::Detail(DetailPage { run, decision: Decision(5), detail }),
        Telemetry::Latency(latency),
    ]
}

/// The brief of a rover that covers ground.
fn brief(grid: Grid) -> Brief {
    let robot = contract::Robot {
        body: contract::Body::Rover(contract::Rover { speed_mps: 0.5 }),
        sensor: contract::Sensor::Square(contract::Square { range_cells: 2 }),
        start: contract::Placement { cell: contract::Cell::new(1, 2), heading: contract::Direction::East },
        start_at: contract::Waypoint { x_m: 0.75, y_m: 1.25 },
        goal: contract::Goal::Cover(contract::Cover { percent: 60, mode: contract::CoverMode::Voronoi }),
        required: true,
    };
    let header = contract::wire::BriefV10 {
        width: grid.width,
        height: grid.height,
        cell_size_m: grid.cell_size_m,
        account: contract::Account::Actions.code(),
        rover_samples: 0,
        helicopter_samples: 0,
        ..at_ends(false)
    };
    read(header, &[(&robot).into()])
}

fn packet(body: Telemetry) -> Packet {
    Packet { time: MissionTime::from_seconds(5400.5), sequence: 16_383, body }
}

/// P-LINK-PACKETS: A message survives its packet bit for bit, whatever its kind, and its headers say what it is and when.
#[test]
fn every_message_survives_its_packet_bit_for_bit() {
    let mut kinds = std::collections::BTreeSet::new();
    for body in samples() {
        kinds.insert(body.kind());
        let packet = packet(body);
        let bytes = packet.encode();
        let headers = Headers::read(&bytes).unwrap();
        assert_eq!((headers.apid, headers.sequence), (packet.body.kind().apid(), 16_383));
        assert_eq!((headers.service.1, headers.time), (packet.body.subtype(), packet.time));
        assert_eq!(packet_length(&bytes), Some(bytes.len()));
        let got = Packet::decode(&bytes).unwrap_or_else(|error| panic!("{error}: {packet:?}"));
        // Not only equal: −0 and 0 are, and have other bits.
        assert_eq!((got.encode(), &got), (bytes, &packet));
    }
    assert_eq!(kinds.into_iter().collect::<Vec<_>>(), Kind::ALL);
}

#[test]
fn apids_are_each_ones_own() {
    for kind in Kind::ALL {
        assert_eq!(Kind::from_apid(kind.apid()), Some(*kind));
        // 2047 is that of idle packets, and the last hundred are reserved.
        assert!(kind.apid() < 1900, "{kind}");
    }
}

/// P-LINK-REFUSES: A packet that is cut, too long, changed in any bit, of another APID, service or structure, or with a
/// field out of range is refused by name.
#[test]
fn packets_that_cannot_be_are_refused_by_name() {
    let state = samples().into_iter().find(|body| body.kind() == Kind::State).unwrap();
    let bytes = packet(state).encode();
    let resealed = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = bytes.clone();
        bytes.truncate(bytes.len() - 2);
        change(&mut bytes);
        let length = (bytes.len() + 2 - 7) as u16;
        bytes[4..6].copy_from_slice(&length.to_be_bytes());
        let checksum = spacepackets::crc::CRC_CCITT_FALSE.checksum(&bytes);
        bytes.extend(checksum.to_be_bytes());
        Packet::decode(&bytes).unwrap_err().to_string()
    };
    type Change<'a> = &'a dyn Fn(&mut Vec<u8>);
    let cases: [(&str, Change); 10] = [
        ("APID 2000 is not one of 256 to 264", &|bytes| {
            bytes[..2].copy_from_slice(&(0x0800_u16 | 2000).to_be_bytes())
        }),
        ("needs telemetry with a secondary header", &|bytes| bytes[0] |= 0x10),
        ("needs telemetry with a secondary header", &|bytes| bytes[0] &= !0x08),
        ("needs packet version 0", &|bytes| bytes[0] |= 0x20),
        ("needs an unsegmented packet", &|bytes| bytes[2] &= 0x3f),
        ("needs PUS version 2, got 1", &|bytes| bytes[6] = 0x10),
        ("State needs service (3, [25]), got (4, 25)", &|bytes| bytes[7] = 4),
        ("State needs structure 1, got 9", &|bytes| bytes[19] = 9),
        ("the body of State needs 348 bytes, got 349", &|bytes| bytes.push(0)),
        ("State: field state.decision needs at most", &|bytes| bytes[36..44].fill(0xff)),
    ];
    for (need, change) in cases {
        let refusal = resealed(change);
        assert!(refusal.contains(need), "{need}: {refusal}");
    }
    for end in 0..bytes.len() {
        assert!(Packet::decode(&bytes[..end]).is_err(), "{end} bytes");
    }
    for bit in 0..8 * bytes.len() {
        let mut flipped = bytes.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        assert!(Packet::decode(&flipped).is_err(), "bit {bit}");
    }
    assert!(matches!(Packet::decode(&[0; 70_000]), Err(PacketError::TooLong { got: 70_000, .. })));
}

proptest! {
    /// P-LINK-REFUSES.
    #[test]
    fn no_bytes_make_the_decoder_panic(bytes in proptest::collection::vec(any::<u8>(), 0..600), apid in 250_u16..270) {
        let _ = Packet::decode(&bytes);
        // With headers and a checksum that are right, so that the body is read.
        if let Some(kind) = Kind::from_apid(apid) {
            let time = MissionTime::from_units(apid.into()).to_bytes();
            let (service, subtypes) = kind.service();
            let mut packet = (0x0800 | apid).to_be_bytes().to_vec();
            packet.extend([0xc0, 0, 0, 0, 0x20, service, subtypes[0], 0, 0, 0, 0]);
            packet.extend(time);
            packet.extend(kind.structure());
            packet.extend(&bytes);
            let length = (packet.len() + 2 - 7) as u16;
            packet[4..6].copy_from_slice(&length.to_be_bytes());
            let checksum = spacepackets::crc::CRC_CCITT_FALSE.checksum(&packet);
            packet.extend(checksum.to_be_bytes());
            let headers = Headers::read(&packet).unwrap();
            prop_assert_eq!(headers.apid, apid);
            if let Ok(decoded) = Packet::decode(&packet) {
                prop_assert_eq!(decoded.body.kind(), kind);
            }
        }
    }
}

/// P-LINK-XTCE: The XTCE describes every packet to the last bit: what precedes the cells takes as many bits as in the
/// packet, and each parameter has a type.
#[test]
fn the_xtce_describes_every_packet_to_the_last_bit() {
    let text = xtce::document("test & <build>");
    let document = roxmltree::Document::parse(&text).unwrap();
    let named = |tag: &str, name: &str| {
        document
            .descendants()
            .find(|node| node.tag_name().name() == tag && node.attribute("name") == Some(name))
            .unwrap_or_else(|| panic!("no {tag} {name}"))
    };
    let bits_of = |parameter: &str| -> Option<u64> {
        let type_name = named("Parameter", parameter).attribute("parameterTypeRef").unwrap().to_owned();
        let of_type = document
            .descendants()
            .find(|node| {
                node.tag_name().name().ends_with("ParameterType")
                    && node.attribute("name") == Some(&type_name)
            })
            .unwrap_or_else(|| panic!("no type {type_name}"));
        let encoding =
            of_type.descendants().find(|node| node.tag_name().name().ends_with("Encoding")).unwrap();
        let fixed = encoding.descendants().find(|node| node.tag_name().name() == "FixedValue");
        let text = encoding.attribute("sizeInBits").or_else(|| fixed?.text());
        text.map(|bits| bits.parse().unwrap())
    };
    let entries = |container: &str| -> Vec<String> {
        let container = named("SequenceContainer", container);
        let entries = container.descendants().filter(|node| node.tag_name().name() == "ParameterRefEntry");
        entries.map(|node| node.attribute("parameterRef").unwrap().to_owned()).collect()
    };
    let head: u64 = entries("CCSDSPacket").iter().map(|name| bits_of(name).unwrap()).sum();
    assert_eq!(head, 8 * 19);
    for kind in Kind::ALL {
        let names = entries(kind.as_str());
        let distinct: std::collections::BTreeSet<&String> = names.iter().collect();
        assert_eq!(distinct.len(), names.len(), "{kind}");
        let sum: u64 = names.iter().filter_map(|name| bits_of(name)).sum();
        let body = kind.body();
        let fixed = body.head_bytes() + if body.is_counted { 0 } else { body.cell_bytes() };
        let structure = usize::from(kind.structure().is_some());
        assert_eq!(sum, 8 * (fixed + structure + 2) as u64, "{kind}");
    }
}

/// P-LINK-TABLE: `docs/ground.md` has the table of packets with every field.
///
/// `HOPPER_BLESS=1` writes that section anew.
#[test]
fn the_page_has_every_packet_with_its_fields() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/ground.md");
    let page = std::fs::read_to_string(path).unwrap();
    const START: &str = "\n## Packets\n\n";
    let start = page.find(START).unwrap() + START.len();
    let table = table::markdown();
    if std::env::var_os("HOPPER_BLESS").is_some() {
        std::fs::write(path, format!("{}{table}", &page[..start])).unwrap();
    } else {
        assert!(
            page[start..] == table,
            "{path} is out of date: HOPPER_BLESS=1 cargo test -p telemetry writes it"
        );
    }
}

#[test]
fn a_summary_has_least_sum_and_most() {
    let Some(Telemetry::Latency(latency)) = samples().pop() else { panic!("the last sample") };
    assert_eq!((latency.first, latency.last, latency.count), (Decision(4), Decision(5), 2));
    assert_eq!((latency.min_ns[0], latency.sum_ns[0], latency.max_ns[0]), (7, 134, 127));
    assert_eq!((latency.min_ns[7], latency.sum_ns[7], latency.max_ns[7]), (1, 65, 64));
}
