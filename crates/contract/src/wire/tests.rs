//! Tests over all declarations, and the tables of `docs/messages.md`.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::fmt::Write as _;

use bytemuck::Zeroable;

use super::*;
use crate::block::InBlock;
use crate::limits::TREASURES_MAX;
use crate::message::{Message, Request};
use crate::mission::kind::KindInBlock;
use crate::{
    Account, Body, Goal, Ground, Member, MotionRow, PathPoint, PolicyCell, PriorCell, Record, Robot,
    SeenCell, Sensor,
};

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
    for (family, kinds) in
        [("bodies", Body::described()), ("sensors", Sensor::described()), ("goals", Goal::described())]
    {
        write!(section, "\n### Blocks of {family}\n\n").unwrap();
        section.push_str(
            "| kind | number | parameter | accepted | what it is |\n| --- | --- | --- | --- | --- |\n",
        );
        for KindInBlock { code, name, what, parameters } in kinds {
            writeln!(section, "| {code} `{name}` | | | | {what} |").unwrap();
            for InBlock { name: parameter, at, reason, range } in parameters {
                writeln!(section, "| `{name}` | {at} | `{parameter}` | {range} | {reason} |").unwrap();
            }
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
    fixed::<_, SeenCell>(&[lowest::<SeenCellV4>()]);
    fixed::<_, PolicyCell>(&[lowest::<PolicyCellV1>()]);
    fixed::<_, MapRequest>(&[lowest::<MapRequestV1>()]);
    fixed::<_, PastRequest>(&[lowest::<PastRequestV1>()]);
    fixed::<_, PriorRequest>(&[lowest::<PriorRequestV1>()]);
    fixed::<_, RouteRequest>(&[lowest::<RouteRequestV1>()]);
    fixed::<_, DetailRequest>(&[lowest::<DetailRequestV1>()]);
    fixed::<_, TableRequest>(&[lowest::<TableRequestV1>()]);
    fixed::<_, MotionRow>(&[lowest::<MotionRowV1>()]);
    fixed::<_, PathPoint>(&[lowest::<PathPointV1>()]);
    fixed::<_, TruthRequest>(&[lowest::<TruthRequestV1>()]);
    fixed::<_, State>(&[StateV4 { last: lowest(), ..lowest() }]);
    fixed::<_, Record>(&[RecordV5 { outcome: lowest(), ..lowest() }]);
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
    header(lowest::<TablePageV1>(), |wire| table_page_from_wire(wire, &[]));
    header(lowest::<PastHeaderV1>(), |wire| page_from_wire(wire, &[]));
    header(lowest::<PolicyHeaderV1>(), |wire| policy_from_wire(wire, &[]));
    header(lowest::<AnnouncementV1>(), |wire| announcement_from_wire(wire, &[WaypointV1::zeroed()]));
    header(lowest::<RoutePageV1>(), |wire| route_page_from_wire(wire, &[WaypointV1::zeroed()]));
    header(lowest::<DetailPageV1>(), |wire| detail_page_from_wire(wire, &[]));
    header(lowest::<WaypointV1>(), |wire| route_page_from_wire(&lowest(), &[*wire]));
    let rests = MemberV6 { halts: 0, halted: 0, travels: 0, ..lowest() };
    let stages = MemberV6 { halts: 1, halted: 1, travels: 1, ..lowest() };
    fixed::<_, Member>(&[rests, MemberV6 { halts: 0, halted: 0, ..stages }, stages]);
    header(lowest::<TeamHeaderV1>(), |wire| team_from_wire(wire, &[rests]));
    the_brief_holds();
    let all: BTreeSet<&str> = all().iter().map(|described| described.name).collect();
    assert_eq!(TESTED.take(), all, "types that are tested, and all types");
}

/// The brief and its robots, whose fields depend on each other.
fn the_brief_holds() {
    let (body, sensor, goal) =
        (Body::Rover(Default::default()), Sensor::Track(Default::default()), Goal::Cover(Default::default()));
    let [body, sensor, goal] = [body.to_block().0, sensor.to_block().0, goal.to_block().0];
    let mut rover = RobotV1 { body, sensor, goal, required: 1, start: [0, 0], ..lowest() };
    (rover.body_values[0], rover.goal_values[0]) = (1.0, 100.0);
    fixed::<_, Robot>(&[rover]);
    let alone = BriefV10 {
        width: 20,
        height: 10,
        account: Account::Actions.code(),
        rover_samples: 0,
        helicopter_samples: 0,
        ..lowest()
    };
    let sampled = BriefV10 { rover_samples: 1, helicopter_samples: 1, ..alone };
    // In the first cell of any grid.
    let hopper =
        RobotV1::from(&Robot { goal: Goal::Reach(Default::default()), ..samples::brief().robots[0] });
    holds(&[alone, sampled], "field of its own", |wire| {
        let is_of_hopper = wire.account == Account::Hopper.code();
        brief_from_wire(wire, &[if is_of_hopper { hopper } else { rover }])
    });
}

/// P-BRIEF-ROBOTS: A brief whose robots cannot be those of one mission is refused by what is wrong with them.
#[test]
fn robots_that_do_not_go_together_are_refused() {
    let brief = samples::brief();
    let wire = (BriefV10::from(&brief), RobotV1::from(&brief.robots[0]));
    assert_eq!(brief_from_wire(&wire.0, &[wire.1]).unwrap(), brief);
    let helicopter = RobotV1 { required: 0, ..RobotV1::from(&samples::helicopter(&brief)) };
    let driver = RobotV1::from(&samples::driver(&brief));
    let off = RobotV1 { start: [99, 0], ..wire.1 };
    let idle = RobotV1 { required: 0, ..wire.1 };
    let actions = BriefV10 { account: Account::Actions.code(), ..wire.0 };
    let cases: [(&str, BriefV10, Vec<RobotV1>); 7] = [
        ("field brief.robots needs 1 to 16, got 0", wire.0, vec![]),
        ("field brief.robots needs 1 to 16, got 17", wire.0, vec![wire.1; 17]),
        ("field robot.start needs a cell on the grid", wire.0, vec![off]),
        ("field robot.required", wire.0, vec![idle, helicopter]),
        ("field brief.account", wire.0, vec![wire.1, wire.1]),
        ("field brief.account", wire.0, vec![helicopter, wire.1]),
        ("field brief.sampling.rover_samples", actions, vec![driver]),
    ];
    assert!(brief_from_wire(&wire.0, &[wire.1, helicopter]).is_ok());
    for (need, header, robots) in cases {
        let refusal = brief_from_wire(&header, &robots).unwrap_err().to_string();
        assert!(refusal.starts_with(need), "{need}: {refusal}");
    }
}

/// Robots, and the brief of a hopper alone.
mod samples {
    use super::*;
    use crate::{
        Camera, Driver, GradientSource, Helicopter, LookAhead, MotionParameters, Reach, SensorParameters,
        SoilMotion,
    };

    pub fn brief() -> Brief {
        let grid = Grid::new(20, 10, 1.0, 1).unwrap();
        let soil = SoilMotion { intended: 0.8, stuck: 0.1, sideways: 0.05, flights: 1 };
        let motion = MotionParameters {
            hard: soil,
            sand: soil,
            slope_limit_rad: 0.5,
            launch_angle_rad: 0.8,
            gravity_mps2: 3.72,
            vertical: false,
            table: 0,
        };
        let gradient = GradientSource::Measured;
        let sensor =
            SensorParameters { gain: 2.0, offset_m: 1.0, radius_min_m: 1.0, radius_max_m: 9.0, gradient };
        let hopper = Robot::hopper(&grid, motion, sensor, [Cell::new(0, 0), Cell::new(19, 9)]);
        let header = BriefV10 {
            width: 20,
            height: 10,
            cell_size_m: 1.0,
            account: 1,
            rover_samples: 0,
            helicopter_samples: 0,
            ..lowest()
        };
        brief_from_wire(&header, &[RobotV1::from(&hopper)]).unwrap()
    }

    pub fn helicopter(brief: &Brief) -> Robot {
        Robot {
            body: Body::Helicopter(Helicopter { speed_mps: 5.0, budget_m: 300.0 }),
            sensor: Sensor::Camera(Camera { radius_m: 25.0 }),
            goal: Goal::LookAhead(LookAhead {}),
            ..brief.robots[0]
        }
    }

    pub fn driver(brief: &Brief) -> Robot {
        Robot {
            body: Body::Driver(Driver {}),
            goal: Goal::Reach(Reach::of_cell(&brief.grid, Cell::new(9, 9))),
            ..brief.robots[0]
        }
    }
}
