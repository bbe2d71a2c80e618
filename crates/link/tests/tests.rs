//! Missions in lockstep with a downlink, and a ground that loses packets.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::cell::Cell;
use std::collections::BTreeMap;
use std::rc::Rc;

use contract::limits::PAST_PAGE_RECORDS;
use contract::{MonotonicNs, PastPage, PastRequest, Record, RobotId, SeenCell};
use link::{Downlink, DownlinkPorts, GroundMap, Settings};
use lockstep::{DirectPorts, Flight, Hooks, Mission, PlannerSchedule, Tempo};
use process::{Ports, Server};
use proptest::prelude::*;
use telemetry::{EventKind, Kind, MissionTime, Packet, Telemetry};

/// Nanoseconds of the host between two rounds of a mission.
const ROUND_NS: u64 = 1_000_000;

/// Everything that the ground knows.
#[derive(Default)]
struct Ground {
    map: GroundMap,
    records: BTreeMap<u64, Record>,
    state: Option<contract::State>,
    events: Vec<EventKind>,
    /// Next packet of each APID.
    sequences: BTreeMap<u16, u16>,
    lost: u64,
}

impl Ground {
    fn receive(&mut self, bytes: &[u8]) {
        let packet = Packet::decode(bytes).unwrap_or_else(|error| panic!("{error}"));
        let apid = packet.body.kind().apid();
        let due = self.sequences.insert(apid, (packet.sequence + 1) % (1 << 14)).unwrap_or(packet.sequence);
        self.lost += u64::from(packet.sequence.wrapping_sub(due) % (1 << 14));
        match packet.body {
            Telemetry::Brief(brief) => self.map.begin(&brief),
            Telemetry::Map(patch) => drop(self.map.patch(patch)),
            Telemetry::Past(page) => {
                self.records.extend(page.records.iter().map(|record| (record.decision.0, *record)));
            }
            Telemetry::State(state) => self.state = Some(state),
            Telemetry::Event(event) => self.events.push(event.kind),
            Telemetry::Team(_) | Telemetry::Route(_) | Telemetry::Detail(_) | Telemetry::Latency(_) => {}
        }
    }
}

/// A mission with its downlink.
struct Flown<'c> {
    flight: Flight<'c>,
    ports: DirectPorts<'c>,
    reads: DownlinkPorts<DirectPorts<'c>>,
    /// Lockstep keeps no records of a hopper alone.
    past: <DirectPorts<'c> as Ports>::Server<PastRequest>,
    downlink: Downlink,
    time: Rc<Cell<u64>>,
    records: Rc<std::cell::RefCell<Vec<Record>>>,
}

impl Flown<'_> {
    fn begin(scenario: &str, planners: &[&str], settings: &Settings) -> Flown<'static> {
        let world = scenario::load(scenario).unwrap().resolve().unwrap();
        let planners: Vec<contract::Name> = planners.iter().map(|name| name.parse().unwrap()).collect();
        let schedule = PlannerSchedule::of_robots(&planners);
        let time = Rc::new(Cell::new(0));
        let records = Rc::new(std::cell::RefCell::new(Vec::new()));
        let (clock, seen) = (Rc::clone(&time), Rc::clone(&records));
        let hooks = Hooks {
            make: Box::new(lockstep::algorithm),
            clock: Box::new(move || MonotonicNs(clock.get())),
            observe: Box::new(move |record| seen.borrow_mut().push(*record)),
        };
        let mut flight = Flight::begin(Mission::of(&world, 3), &schedule, Tempo::default(), hooks).unwrap();
        let mut ports = flight.ports();
        let reads =
            DownlinkPorts::open(&mut ports).unwrap_or_else(|_| unreachable!("direct ports always open"));
        let past = ports.server(RobotId(0)).unwrap_or_else(|_| unreachable!("direct ports always open"));
        Flown { flight, ports, reads, past, downlink: Downlink::new(settings), time, records }
    }

    /// One more round of the mission, and a look of the downlink; whether the mission goes on. After its end hopper-sim
    /// and perception still answer what the downlink asks for.
    fn round(&mut self) -> bool {
        self.time.set(self.time.get() + ROUND_NS);
        self.flight.round().unwrap();
        self.look();
        !self.flight.state().status.is_over()
    }

    fn look(&mut self) {
        let records = self.records.borrow();
        let answer = |request: &PastRequest| {
            let records =
                records.iter().skip(request.from.0 as usize).take(PAST_PAGE_RECORDS).copied().collect();
            Some(PastPage { run: request.run, robot: request.robot, from: request.from, records })
        };
        self.past.serve(answer).unwrap_or_else(|_| unreachable!("direct ports never fail"));
        drop(records);
        self.reads
            .turn(&mut self.ports, &mut self.downlink)
            .unwrap_or_else(|_| unreachable!("direct ports never fail"));
    }
}

fn settings(rate: Option<u64>, passes: Option<&str>) -> Settings {
    let passes = passes.map(|passes| passes.parse().unwrap());
    Settings { rate, passes, step: MissionTime::from_seconds(60.0) }
}

/// What the mission knows of the ground, cell by cell.
fn cells(map: &contract::ObservedMap) -> Vec<SeenCell> {
    let seen = map.cells().iter().enumerate().filter_map(|(at, ground)| {
        Some(SeenCell { index: at as u32, ground: (*ground)?, visits: map.visits(at) })
    });
    seen.collect()
}

/// P-LINK-WHOLE: Whatever the rate, the ground has every record, the last state, and the map cell by cell once
/// everything has been sent, and no more bits were sent than the budget allows.
#[test]
fn the_ground_has_all_of_a_mission_within_the_budget() {
    for (rate, passes) in
        [(None, None), (Some(2_000), None), (Some(2_000), Some("10m/90m")), (Some(60), None)]
    {
        let mut flown = Flown::begin("hard", &["greedy"], &settings(rate, passes));
        let (mut ground, mut bits) = (Ground::default(), 0);
        let mut rounds = 0;
        loop {
            let goes_on = flown.round();
            while let Some(packet) = flown.downlink.take() {
                bits += 8 * packet.len() as u64;
                ground.receive(&packet);
            }
            if !goes_on && flown.downlink.is_idle() {
                break;
            }
            rounds += 1;
            assert!(rounds < 100_000, "{:?}", flown.downlink.tally());
        }
        let records = flown.records.borrow();
        assert_eq!(ground.records.values().copied().collect::<Vec<_>>(), *records, "{rate:?}");
        let state = ground.state.unwrap();
        assert_eq!((state.digest, state.status), (flown.flight.state().digest, flown.flight.state().status));
        assert!(ground.map.is_whole());
        assert_eq!(cells(ground.map.map().unwrap()), cells(flown.flight.map().unwrap()));
        assert_eq!(ground.lost, 0);
        assert!(ground.events.contains(&EventKind::MissionEnded), "{:?}", ground.events);
        if let Some(rate) = rate {
            let share = if passes.is_some() { 1.0 / 9.0 } else { 1.0 };
            let passed = flown.downlink.now().seconds();
            let allowed = rate as f64 * (passed * share + if passes.is_some() { 600.0 } else { 1.0 });
            assert!(bits as f64 <= allowed + 8.0 * 4_200.0, "{bits} bits in {passed} s at {rate}");
        }
    }
}

/// P-LINK-BOUNDED: With a link that is far too slow the mission is as fast as without, what waits is bounded, and an
/// event does not wait behind what can wait.
#[test]
fn a_link_that_is_too_slow_holds_nothing_up_and_sends_events_first() {
    let mut flown = Flown::begin("hard", &["greedy"], &settings(Some(8), None));
    let mut kinds = Vec::new();
    let mut goes_on = true;
    while goes_on {
        goes_on = flown.round();
        let tally = flown.downlink.tally();
        assert!(tally.cells_waiting <= flown.flight.map().map_or(0, |map| map.seen_cells()));
        while let Some(packet) = flown.downlink.take() {
            kinds.push(Packet::decode(&packet).unwrap().body.kind());
        }
    }
    let decisions = flown.flight.state().decision.0;
    let tally = flown.downlink.tally();
    assert!(tally.states_replaced + 10 > decisions / 2, "{tally:?} of {decisions}");
    assert_eq!(kinds.first(), Some(&Kind::Event));
    // The end of the mission is the next packet, once the budget is there for one.
    while !kinds.ends_with(&[Kind::Event]) {
        flown.time.set(flown.time.get() + ROUND_NS);
        flown.look();
        kinds.extend(flown.downlink.take().map(|packet| Packet::decode(&packet).unwrap().body.kind()));
        assert!(kinds.len() < 5_000, "no event among {} packets", kinds.len());
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 8, failure_persistence: None, max_shrink_iters: 0, ..ProptestConfig::default() })]

    /// P-LINK-CATCH-UP: Packets that are lost are asked for again by their numbers, and then the map is whole, cell by
    /// cell, and every record is there: after single losses, after an outage, and in whatever order packets come.
    #[test]
    fn what_is_lost_is_asked_for_until_the_ground_has_all(
        loss in 0.0..0.3_f64, outage in 0_u64..200, seed in any::<u64>(), rate in prop_oneof![Just(None), (300_u64..8_000).prop_map(Some)],
    ) {
        let mut flown = Flown::begin("hard", &["greedy"], &settings(rate, None));
        let mut ground = Ground::default();
        let mut random = seed | 1;
        let mut draw = move || {
            random ^= random << 13;
            random ^= random >> 7;
            random ^= random << 17;
            (random >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut held: Option<Vec<u8>> = None;
        let mut rounds = 0;
        loop {
            let goes_on = flown.round();
            let decision = flown.flight.state().decision.0;
            while let Some(packet) = flown.downlink.take() {
                let is_out = (20..20 + outage).contains(&decision) && goes_on;
                if is_out || draw() < loss {
                    continue;
                }
                // One packet in ten comes after the next one.
                if held.is_none() && draw() < 0.1 {
                    held = Some(packet);
                    continue;
                }
                ground.receive(&packet);
                if let Some(late) = held.take() {
                    ground.receive(&late);
                }
            }
            rounds += 1;
            prop_assert!(rounds < 100_000, "{:?} {:?}", flown.downlink.tally(), ground.map.gaps());
            if goes_on || !flown.downlink.is_idle() {
                continue;
            }
            let due = flown.flight.state().decision.0;
            let missing: Vec<u64> = (0..due).filter(|decision| !ground.records.contains_key(decision)).collect();
            let is_map_whole = ground.map.is_whole() && ground.map.map().map(cells) == flown.flight.map().map(cells);
            if missing.is_empty() && is_map_whole {
                break;
            }
            for decision in missing {
                flown.downlink.history_again(decision, decision);
            }
            for gap in ground.map.gaps() {
                flown.downlink.map_again(gap.first, gap.last);
            }
            if is_map_whole || ground.map.is_whole() {
                // If the newest patch was lost, the link tells again which it was.
                flown.time.set(flown.time.get() + 100 * ROUND_NS);
            }
        }
        let records = flown.records.borrow();
        prop_assert_eq!(ground.records.values().copied().collect::<Vec<_>>(), records.clone());
    }
}

/// P-LINK-TEAM: Of a mission of several robots with routes the ground has the team, and the points of each route.
#[test]
fn routes_and_teams_go_down_too() {
    let mut flown = Flown::begin("hopper-scout", &["mdp", "scout_ahead"], &settings(None, None));
    let (mut teams, mut routes) = (0, Vec::new());
    let mut announced = Vec::new();
    for _ in 0..4_000 {
        let goes_on = flown.round();
        while let Some(packet) = flown.downlink.take() {
            match Packet::decode(&packet).unwrap().body {
                Telemetry::Team(_) => teams += 1,
                Telemetry::Route(page) => routes.push(page.route.id()),
                Telemetry::Past(page) => {
                    let of_page = page.records.iter().filter_map(Record::announced);
                    announced.extend(of_page.map(|(_, route)| route));
                }
                _ => {}
            }
        }
        if !goes_on && flown.downlink.is_idle() {
            break;
        }
    }
    assert!(teams > 10 && !routes.is_empty(), "{teams} {}", routes.len());
    routes.sort();
    routes.dedup();
    announced.sort();
    announced.dedup();
    assert_eq!(routes, announced);
}
