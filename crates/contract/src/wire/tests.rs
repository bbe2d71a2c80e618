//! Tests over all declarations, and the tables of `docs/messages.md`.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::fmt::Write as _;

use bytemuck::Zeroable;

use super::*;
use crate::limits::{GOALS_MAX, TREASURES_MAX};
use crate::message::{Message, Request};
use crate::{Ground, Member, PolicyCell, PriorCell, Record, SeenCell, SoilMotion};

/// A wire type by what its declaration says.
struct Described {
    name: &'static str,
    bytes: usize,
    fields: Vec<Field>,
}

fn described<W: Wire>() -> Described {
    Described { name: W::NAME, bytes: size_of::<W>(), fields: W::fields() }
}

/// Every wire type of a message or a request, each once, and then those inside others.
fn all() -> Vec<Described> {
    struct Types(Vec<Described>);
    impl Types {
        fn payload<P: crate::Payload>(&mut self) {
            for described in [described::<P::Header>(), described::<P::Cell>()] {
                if described.bytes > 0 && self.0.iter().all(|known| known.name != described.name) {
                    self.0.push(described);
                }
            }
        }
    }
    impl Visitor for Types {
        fn message<M: Message>(&mut self) {
            self.payload::<M>();
        }

        fn request<Q: Request>(&mut self) {
            self.payload::<Q>();
            self.payload::<Q::Response>();
        }
    }
    let mut types = Types(Vec::new());
    visit(&mut types);
    types.0.extend([described::<LeaderV1>(), described::<PoseV1>(), described::<OutcomeV1>()]);
    types.0.extend([described::<SoilMotionV1>(), described::<DesignV1>()]);
    types.0
}

#[test]
fn every_field_says_why_it_is_there_and_every_byte_belongs_to_one() {
    for Described { name, bytes, fields } in all() {
        let mut ends = fields.iter().skip(1).map(|field| field.offset).chain([bytes]);
        assert_eq!(fields[0].offset, 0, "{name}");
        for field in &fields {
            assert!(field.name == "reserved" || field.reason.ends_with('.'), "{name}.{}", field.name);
            let length = ends.next().unwrap() - field.offset;
            for end in field.inside.iter().chain(&field.outside) {
                assert_eq!(end.len(), length, "{name}.{}", field.name);
            }
        }
    }
}

/// P-WIRE-RANGES: A field whose codec knows the ends of its range is accepted just inside and refused by name just outside, in
/// every wire type, and `docs/messages.md` lists all fields.
///
/// `HOPPER_BLESS=1` writes that section anew.
#[test]
fn the_reference_has_every_field_with_its_range_and_its_reason() {
    let mut section = String::new();
    for Described { name, bytes, fields } in all() {
        write!(section, "\n### `{name}` ({bytes} bytes)\n\n").unwrap();
        section.push_str("| field | type | accepted | what it is |\n| --- | --- | --- | --- |\n");
        for Field { name, layout, range, reason, .. } in fields {
            let reason = without_links(reason).replace('|', "\\|");
            writeln!(section, "| `{name}` | `{layout}` | {range} | {reason} |").unwrap();
        }
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/messages.md");
    let page = std::fs::read_to_string(path).unwrap();
    let start = page.find("\n## Fields\n").unwrap();
    let start = page[start..].find("\n### ").map_or(page.len(), |first| start + first);
    if std::env::var_os("HOPPER_BLESS").is_some() {
        std::fs::write(path, format!("{}{section}", &page[..start])).unwrap();
    } else {
        assert!(page[start..] == section, "{path} is out of date: HOPPER_BLESS=1 writes it");
    }
}

/// The links of doc comments as plain code.
fn without_links(text: &str) -> String {
    let mut plain = String::new();
    for (at, part) in text.split("[`").enumerate() {
        match part.split_once("`]") {
            Some((code, rest)) if at > 0 => {
                let target = if rest.starts_with('(') { rest.split_once(')') } else { None };
                write!(plain, "`{code}`{}", target.map_or(rest, |(_, rest)| rest)).unwrap();
            }
            _ => plain.push_str(part),
        }
    }
    plain
}

/// A wire value with every field at an end of its range, the first of both.
fn lowest<W: Wire>() -> W {
    let mut wire = W::zeroed();
    for field in W::fields() {
        if let Some(end) = field.inside.first() {
            wire = with(&wire, &field, end);
        }
    }
    wire
}

fn with<W: Wire>(wire: &W, field: &Field, value: &[u8]) -> W {
    let mut wire = *wire;
    bytemuck::bytes_of_mut(&mut wire)[field.offset..field.offset + value.len()].copy_from_slice(value);
    wire
}

/// Each field just inside of its range is accepted in one of the valid `samples`, and just outside is refused in one, by its
/// own name or that of `sum`.
fn holds<W: Wire, D>(samples: &[W], sum: &str, read: impl Fn(&W) -> Result<D, Refusal>) {
    TESTED.with_borrow_mut(|tested| tested.insert(W::NAME));
    for sample in samples {
        if let Err(refusal) = read(sample) {
            panic!("{}: {refusal}", W::NAME);
        }
    }
    for field in W::fields() {
        let told = format!("{}.{} as {}", W::NAME, field.name, field.refused_as);
        let refusals = |value: &[u8]| -> Vec<Option<String>> {
            let reads = samples.iter().map(|sample| read(&with(sample, &field, value)));
            reads.map(|read| read.err().map(|refusal| refusal.to_string())).collect()
        };
        for value in &field.inside {
            let refusals = refusals(value);
            assert!(refusals.contains(&None), "{told}: {value:?} is inside: {refusals:?}");
        }
        for value in &field.outside {
            let refusals = refusals(value);
            let is_named = |refusal: &&String| {
                let names = [&format!("field {}", field.refused_as), sum, "needs robot below"];
                names.iter().any(|name| refusal.starts_with(*name))
            };
            assert!(refusals.iter().flatten().any(|text| is_named(&text)), "{told}: {value:?}: {refusals:?}");
        }
    }
}

fn fixed<W: Wire, D: for<'a> TryFrom<&'a W, Error = Refusal>>(samples: &[W]) {
    holds(samples, "field of its own", |wire| D::try_from(wire));
}

fn header<W: Wire, D>(sample: W, read: impl Fn(&W) -> Result<D, Refusal>) {
    holds(&[sample], "field of its own", read);
}

fn treasures() -> [[i32; 2]; TREASURES_MAX] {
    std::array::from_fn(|x| [x as i32, 0])
}

thread_local! {
    /// The names of the wire types that [`holds`] has tested in this thread: each test has its own.
    static TESTED: RefCell<BTreeSet<&'static str>> = const { RefCell::new(BTreeSet::new()) };
}

/// P-WIRE-RANGES.
#[test]
fn every_field_is_accepted_just_inside_of_its_range_and_refused_just_outside() {
    fixed::<_, Leader>(&[lowest::<LeaderV1>()]);
    fixed::<_, Pose>(&[lowest::<PoseV1>()]);
    fixed::<_, Outcome>(&[lowest::<OutcomeV1>()]);
    fixed::<_, Heartbeat>(&[lowest::<HeartbeatV2>()]);
    fixed::<_, Command>(&[lowest::<CommandV3>()]);
    fixed::<_, Ground>(&[lowest::<GroundV2>()]);
    fixed::<_, SeenCell>(&[lowest::<SeenCellV3>()]);
    fixed::<_, PolicyCell>(&[lowest::<PolicyCellV1>()]);
    fixed::<_, MapRequest>(&[lowest::<MapRequestV1>()]);
    fixed::<_, PastRequest>(&[lowest::<PastRequestV1>()]);
    fixed::<_, PriorRequest>(&[lowest::<PriorRequestV1>()]);
    fixed::<_, RouteRequest>(&[lowest::<RouteRequestV1>()]);
    fixed::<_, TruthRequest>(&[lowest::<TruthRequestV1>()]);
    fixed::<_, State>(&[StateV4 { last: lowest(), ..lowest() }]);
    fixed::<_, Record>(&[RecordV4 { outcome: lowest(), ..lowest() }]);
    fixed::<_, PriorCell>(&[PriorCellV1 { probabilities: [1.0, 0.0, 0.0, 0.0], ..lowest() }]);
    let [handover, pace] = [5, 4].map(|order| ControlV1 { order, pace: 3, ..lowest() });
    fixed::<_, Control>(&[handover, pace]);
    fixed::<_, Pacing>(&[TempoV1 { pace: 3, ..lowest() }]);
    let on_grid = MapPatchV2 { width: 20, height: 10, treasures: treasures(), ..lowest() };
    header(on_grid, |wire| patch_from_wire(wire, &[]));
    let on_grid = MapPageV2 { width: 20, height: 10, treasures: treasures(), ..lowest() };
    header(on_grid, |wire| map_page_from_wire(wire, &[]));
    let on_grid = TruthPageV1 { width: 20, height: 10, treasures: treasures(), ..lowest() };
    header(on_grid, |wire| truth_page_from_wire(wire, &[]));
    header(lowest::<PriorPageV1>(), |wire| prior_page_from_wire(wire, &[]));
    header(lowest::<PastHeaderV1>(), |wire| page_from_wire(wire, &[]));
    header(lowest::<PolicyHeaderV1>(), |wire| policy_from_wire(wire, &[]));
    header(lowest::<AnnouncementV1>(), |wire| announcement_from_wire(wire, &[WaypointV1::zeroed()]));
    header(lowest::<RoutePageV1>(), |wire| route_page_from_wire(wire, &[WaypointV1::zeroed()]));
    header(lowest::<WaypointV1>(), |wire| route_page_from_wire(&lowest(), &[*wire]));
    let member = |vehicle, sensor| MemberV5 { vehicle, sensor, halts: 0, halted: 0, ..lowest() };
    let stages = MemberV5 { halts: 1, halted: 1, ..member(3, 5) };
    fixed::<_, Member>(&[member(1, 1), member(2, 2), member(3, 3), member(4, 4), member(5, 5), stages]);
    header(lowest::<TeamHeaderV1>(), |wire| team_from_wire(wire, &[member(1, 1)]));
    the_brief_holds();
    let all: BTreeSet<&str> = all().iter().map(|described| described.name).collect();
    assert_eq!(TESTED.take(), all, "types that are tested, and all types");
}

/// The scatter of a soil, a design and a brief, whose fields depend on each other.
fn the_brief_holds() {
    let soil = SoilMotionV1 { flights: 1, ..Zeroable::zeroed() };
    let hard = SoilMotionV1 { intended: 1.0, ..soil };
    let soils = [hard, SoilMotionV1 { stuck: 1.0, ..soil }, SoilMotionV1 { sideways: 0.5, ..soil }];
    holds(&soils, "field motion.sum", |wire| SoilMotion::try_from(wire));
    let patrol = BriefV9 {
        width: 20,
        height: 10,
        hard,
        sand: hard,
        goals: std::array::from_fn(|x| [x as i32, 0]),
        rover_samples: 0,
        helicopter_samples: 0,
        ..lowest()
    };
    let alone = BriefV9 { goals: [[0; 2]; GOALS_MAX], goal_count: 0, hops_max: 0, ..patrol };
    let scout = BriefV9 { rover_samples: 1, helicopter_samples: 1, ..alone };
    fixed::<_, Brief>(&[alone, patrol, scout]);
    let mixed = BriefV9 { required: 1, ..alone };
    holds(&[DesignV1 { robots: 1, hard, sand: hard, ..lowest() }], "field of its own", |wire| {
        let mut brief = mixed;
        brief.designs[0] = *wire;
        Brief::try_from(&brief)
    });
}
