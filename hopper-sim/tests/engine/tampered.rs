//! Journals whose header or records were changed and framed anew, with right checksums and, but for the digests themselves, a right
//! chain: verifying and resuming refuse them alike, by record and field.

use std::fs;
use std::path::Path;

use contract::{
    Account, Action, Announcement, Body, Branch, Brief, Cell, Collected, Command, Digest, Direction, Goal,
    Incarnation, Leader, MonotonicNs, Name, Origin, Pace, Profile, Record, RobotId, Robots, Route, RunId,
    Sensor, Status, Term, Timing, Vetoed, Waypoint,
};
use hopper_sim::journal::FILE_NAME;
use hopper_sim::{
    Arbiter, Effect, Event, Journal, JournalError, JournalHeader, JournalReader, Mission, verify,
};
use scenario::{Fault, ResolvedScenario, Scenario};
use tempfile::TempDir;

use crate::fixture::{command, frame, header_payloads, name};

/// Decisions of a journal that is tampered with.
const DECISIONS: usize = 60;

const SEED: u64 = 7;

/// A mission of one kind: its world, and what was flown of it.
struct Flown {
    what: &'static str,
    world: ResolvedScenario,
    records: Vec<Record>,
    routes: Vec<Route>,
    dir: TempDir,
}

impl Flown {
    /// Flown without sense: what nobody refuses, in turns. Every third decision is tried with what the guard may veto first.
    fn of(what: &'static str, world: ResolvedScenario) -> Self {
        let brief = Brief { run: RunId(5), ..world.brief.clone() };
        let mission = Mission { brief, ..Mission::of(&world, SEED) };
        let dir = tempfile::tempdir().unwrap();
        let mut flight = Flight {
            arbiter: Arbiter::new(mission, None, Pace::Max, 0, MonotonicNs(1)),
            records: Vec::new(),
            routes: Vec::new(),
        };
        flight.on(Event::Tick, 1);
        while flight.records.len() < DECISIONS && !flight.arbiter.state().status.is_over() {
            flight.decide();
        }
        let Flight { records, routes, .. } = flight;
        let flown = Self { what, world, records, routes, dir };
        drop(flown.create(flown.path()));
        flown.write(&flown.records);
        assert!(flown.records.len() > 12, "{what}: {} decisions", flown.records.len());
        flown
    }

    fn path(&self) -> &Path {
        self.dir.path()
    }

    fn header(&self) -> JournalHeader {
        JournalHeader::new(&self.world, SEED).with_run(RunId(5))
    }

    fn create(&self, dir: &Path) -> Journal {
        Journal::create(dir, &self.header(), false).unwrap()
    }

    /// The journal with this header and the records as they were.
    fn write_under(&self, header: &JournalHeader) {
        let dir = tempfile::tempdir().unwrap();
        drop(Journal::create(dir.path(), header, false).unwrap());
        self.write_behind(fs::read(dir.path().join(FILE_NAME)).unwrap());
    }

    /// The journal with the records behind what is written before them.
    fn write_behind(&self, mut head: Vec<u8>) {
        self.records.iter().for_each(|record| head.extend(self.frame(record)));
        fs::write(self.path().join(FILE_NAME), head).unwrap();
    }

    /// The journal with these records, framed anew.
    fn write(&self, records: &[Record]) {
        let path = self.path().join(FILE_NAME);
        let mut bytes = fs::read(&path).unwrap();
        let [_, text] = header_payloads(&bytes);
        bytes.truncate(text.end);
        for record in records {
            bytes.extend(self.frame(record));
        }
        fs::write(&path, bytes).unwrap();
    }

    fn frame(&self, record: &Record) -> Vec<u8> {
        let config = bincode::config::standard().with_little_endian().with_fixed_int_encoding();
        let announced = self.routes.iter().find(|route| record.action == Action::Announce(route.id()));
        let payload = match announced {
            Some(route) => bincode::serde::encode_to_vec((record, route.waypoints()), config),
            None => bincode::serde::encode_to_vec(record, config),
        };
        frame(&payload.unwrap())
    }

    /// Whether the leader of a record commands its robot for the first time.
    fn begins_to_lead(&self, index: usize) -> bool {
        let record = &self.records[index];
        let before = self.records[..index].iter().rev().find(|before| before.robot == record.robot);
        before.is_none_or(|before| before.leader != record.leader)
    }

    /// Why the journal is not resumed, if it is not.
    fn resume(&self) -> Result<(), JournalError> {
        Journal::resume(self.path(), &self.header(), &self.world.terrain, false).map(drop)
    }
}

struct Flight {
    arbiter: Arbiter,
    records: Vec<Record>,
    routes: Vec<Route>,
}

impl Flight {
    fn on(&mut self, event: Event, now: u64) {
        for effect in self.arbiter.on(event, MonotonicNs(now)) {
            if let Effect::Append(record) = effect {
                self.records.push(record);
                self.on(Event::Appended, now);
            }
        }
    }

    /// Has the robot that is due act, or lets the deadline pass.
    fn decide(&mut self) {
        let (number, state) = (self.records.len(), *self.arbiter.state());
        let deadline_ns = self.arbiter.mission().brief.guard.deadline_ns;
        if deadline_ns > 0 && number % 5 == 4 {
            return self.on(Event::Tick, state.published.0 + deadline_ns);
        }
        for action in self.candidates(number) {
            let due = self.arbiter.team().map_or(RobotId(0), |team| team.due);
            // Now and then another planner takes over.
            let term = 1 + number as u64 / 20;
            let life = Incarnation(1 + u64::from(due.0) + 100 * term);
            let leader = self.leader(due);
            let term = if leader.incarnation == life { leader.term } else { leader.term.next() };
            let order = Command { robot: due, incarnation: life, term, ..command(&state, action) };
            self.on(Event::Command(Ok(order)), state.published.0 + 50);
            if self.records.len() > number {
                return;
            }
        }
        panic!("a robot can always hold");
    }

    fn leader(&self, robot: RobotId) -> Leader {
        match self.arbiter.team() {
            Some(team) => team.members[usize::from(robot.0)].leader,
            None => self.arbiter.state().leader,
        }
    }

    fn candidates(&mut self, number: usize) -> Vec<Action> {
        let due = self.arbiter.team().map_or(RobotId(0), |team| team.due);
        let body = self.arbiter.mission().brief.robots[usize::from(due.0)].body;
        let turned = |from: usize| (0..4).map(move |turn| Direction::ALL[(from + turn) % 4]);
        let mut actions: Vec<Action> = match body.along_route() {
            Some(along) => vec![along, self.announce(number)],
            None if body.hops() => turned(number / 3).map(Action::Hop).collect(),
            None => turned(number / 4).map(Action::Step).collect(),
        };
        actions.push(Action::Hold);
        actions
    }

    /// The announcement of a route of three points around where the robot that is due is.
    fn announce(&mut self, number: usize) -> Action {
        let team = self.arbiter.team().unwrap();
        let (robot, at) = (team.due, team.members[usize::from(team.due.0)].travel.unwrap().at);
        let by = 0.5 + 0.1 * number as f64;
        let points = vec![at, Waypoint { x_m: at.x_m + by, ..at }, Waypoint { y_m: at.y_m + by, ..at }];
        let route = Route::new(points).unwrap();
        let announcement = Announcement { run: RunId(5), robot, route: route.clone() };
        self.on(Event::Announcement(Ok(announcement)), 1);
        let id = route.id();
        self.routes.push(route);
        Action::Announce(id)
    }
}

fn built_in(scenario: &str) -> ResolvedScenario {
    scenario::load(scenario).unwrap().resolve().unwrap()
}

/// The hard ground under a guard with a deadline, which the profile of the paper has not.
fn guarded() -> ResolvedScenario {
    let text = built_in("hard").resolved.replace("paper-2023", "hopper");
    let text = format!("{text}\n[guard]\ndeadline_s = 1.0\nhazard_max = 0.0\n");
    Scenario::parse(&text, "test").unwrap().resolve().unwrap()
}

/// A mission of each kind, from the hopper's that is alone to that of all kinds.
fn missions() -> Vec<Flown> {
    let mut missions: Vec<Flown> =
        ["hard", "treasures", "patrol", "coverage", "rover-helicopter", "hopper-scout", "expedition"]
            .map(|scenario| Flown::of(scenario, built_in(scenario)))
            .into();
    missions.push(Flown::of("a deadline", guarded()));
    missions
}

type Twist = fn(&mut Record);

/// How each field of a record is changed, and which fields a refusal may name then. A changed action comes to something else; a
/// record that names another robot may be that robot's first.
const TWISTS: &[(&str, Twist, &[&str])] = &[
    ("robot", |record| record.robot = RobotId(15), &["robot"]),
    ("robot", |record| record.robot.0 ^= 1, &["robot", "leader"]),
    ("decision", |record| record.decision = record.decision.next(), &["decision"]),
    ("leader.term", |record| record.leader.term = Term(record.leader.term.0 + 2), &["leader"]),
    ("leader.term", |record| record.leader.term = Term(0), &["leader"]),
    ("leader.incarnation", |record| record.leader.incarnation.0 += 1, &["leader"]),
    ("leader.pid", |record| record.leader.pid += 1, &["leader"]),
    ("leader.planner", |record| record.leader.planner = name("forged"), &["leader"]),
    ("leader without a name", |record| record.leader.planner = Name::NONE, &["leader"]),
    ("leader without a life", |record| record.leader.incarnation.0 = 0, &["leader"]),
    (
        "action",
        |record| record.action = another(record.action),
        &["action", "origin", "outcome.branch", "outcome.to", "outcome.flight"],
    ),
    ("origin", |record| record.origin = another_origin(record.origin), &["origin", "action", "leader"]),
    ("vetoed", |record| record.vetoed = record.vetoed.with(Action::Hold), &["vetoed", "action"]),
    (
        "outcome.branch",
        |record| record.outcome.branch = another_branch(record.outcome.branch),
        &["outcome.branch"],
    ),
    ("outcome.from", |record| record.outcome.from.x += 1, &["outcome.from"]),
    ("outcome.to", |record| record.outcome.to.y += 1, &["outcome.to"]),
    (
        "outcome.flight.launch_speed_mps",
        |record| record.outcome.flight.launch_speed_mps += 0.5,
        &["outcome.flight"],
    ),
    (
        "outcome.flight.launch_angle_rad",
        |record| record.outcome.flight.launch_angle_rad += 0.01,
        &["outcome.flight"],
    ),
    ("outcome.flight.range_m", |record| record.outcome.flight.range_m += 0.5, &["outcome.flight"]),
    ("outcome.flight.rise_m", |record| record.outcome.flight.rise_m += 0.5, &["outcome.flight"]),
    (
        "outcome.flight.apex_height_m",
        |record| record.outcome.flight.apex_height_m += 0.5,
        &["outcome.flight"],
    ),
    (
        "outcome.flight.flight_time_s",
        |record| record.outcome.flight.flight_time_s += 0.5,
        &["outcome.flight"],
    ),
    ("outcome.flight.flights", |record| record.outcome.flight.flights += 1, &["outcome.flight"]),
    (
        "pose.cell",
        |record| record.pose.cell = Cell::new(record.pose.cell.x + 1, record.pose.cell.y),
        &["pose.cell"],
    ),
    ("pose.height_m", |record| record.pose.height_m += 0.125, &["pose.height_m"]),
    ("collected", |record| record.collected = Collected(record.collected.0 ^ 1), &["collected"]),
    ("visits", |record| record.visits += 1, &["visits"]),
    ("steps", |record| record.steps += 1, &["steps"]),
    ("status", |record| record.status = Status::Goal, &["status"]),
    ("timing.landed", |record| record.timing.landed.0 = u64::MAX, &["timing.state_published"]),
    (
        "timing.state_published",
        |record| record.timing.state_published.0 = record.timing.accepted.0 + 1,
        &["timing.accepted"],
    ),
    ("timing.accepted", |record| record.timing.accepted.0 += 1, &["timing.committed"]),
    ("timing.committed", |record| record.timing.committed.0 = u64::MAX, &["timing.committed"]),
    ("timing.committed", |record| record.timing.committed.0 -= 1, &["timing.committed"]),
    ("previous", |record| record.previous = Digest([9; 32]), &["previous"]),
    ("digest", |record| record.digest = Digest([9; 32]), &["digest"]),
];

/// What may be anything: no decision depends on it. The fingerprint of the map is compared where planners fly again.
const FREE: &[(&str, Twist)] = &[
    ("observation", |record| record.observation += 1),
    ("work", |record| record.work += 1),
    ("cut", |record| record.cut = !record.cut),
    // Another boot's clock.
    ("timing", |record| {
        let Timing { landed, state_published, accepted, committed, .. } = &mut record.timing;
        [landed, state_published, accepted, committed].into_iter().for_each(|stamp| stamp.0 += 1 << 40);
    }),
    ("timing.sensed", |record| record.timing.sensed.0 = 0),
    ("timing.map_published", |record| record.timing.map_published.0 = u64::MAX),
    ("timing.planning_started", |record| record.timing.planning_started.0 = 0),
    ("timing.planning_ended", |record| record.timing.planning_ended.0 = 0),
];

fn another(action: Action) -> Action {
    match action {
        Action::Hop(direction) => Action::Hop(direction.left()),
        Action::Step(direction) => Action::Step(direction.left()),
        Action::Hold => Action::Hop(Direction::East),
        _ => Action::Hold,
    }
}

fn another_origin(origin: Origin) -> Origin {
    if origin == Origin::Hold { Origin::Planner } else { Origin::Hold }
}

fn another_branch(branch: Branch) -> Branch {
    if branch == Branch::Left { Branch::Right } else { Branch::Left }
}

/// The records with `twist` done to the one at `index`. Unless it is a digest that is changed, the chain goes on from it.
fn twisted(records: &[Record], index: usize, field: &str, twist: Twist) -> Vec<Record> {
    let mut records = records.to_vec();
    twist(&mut records[index]);
    if !["previous", "digest"].contains(&field) {
        for number in index..records.len() {
            let previous =
                if number == index { records[number].previous } else { records[number - 1].digest };
            records[number].previous = previous;
            records[number].digest = previous.chain(&records[number]);
        }
    }
    records
}

/// P-NOT-SOUND: A journal whose header contradicts its scenario, or whose records cannot have been
/// flown, is not resumed, drawn, viewed, read by Python or flown again, and nothing panics.
/// Verifying and resuming share one check, which executes every record again and names the first
/// record and field that differ.
/// P-RECOMPUTED: Everything that the next decision can depend on is recomputed when a journal is
/// resumed or verified, including what no digest covers: brief and robots from the scenario in the
/// header; visits, leaders, clocks, routes and stages from the records. Each veto in a record is
/// checked against the guard; which commands were tried is not recorded.
/// P-STAMPS-JOURNAL: A journal is sound only if in each record landing, publication and acceptance
/// follow one another and the commit has the stamp of the acceptance. Stamps of other processes are
/// not checked, nor stamps of different records against each other, since a reboot starts a new
/// clock.
#[test]
fn a_journal_with_any_field_changed_is_refused_by_record_and_field_whoever_reads_it() {
    for flown in missions() {
        let what = flown.what;
        assert_eq!(verify(flown.path()).unwrap().faults(), [""; 0], "{what}");
        flown.resume().unwrap_or_else(|error| panic!("{what}: {error}"));
        for index in [3, flown.records.len() / 2, flown.records.len() - 2] {
            let is_new_leader = flown.begins_to_lead(index);
            for (field, twist, named) in TWISTS {
                if is_new_leader && ["leader.incarnation", "leader.pid", "leader.planner"].contains(field) {
                    // Anybody may have taken over.
                    continue;
                }
                let case = format!("{what}, {field} of record {index}");
                flown.write(&twisted(&flown.records, index, field, *twist));
                let before = fs::read(flown.path().join(FILE_NAME)).unwrap();
                let error = match (verify(flown.path()), flown.resume()) {
                    // What is no value of its field is no record.
                    (Err(JournalError::Undecodable { .. }), Err(JournalError::Undecodable { .. })) => {
                        continue;
                    }
                    (Ok(verification), Err(error)) => {
                        let fault = verification.fault.unwrap_or_else(|| panic!("{case} is taken for sound"));
                        assert!(named.contains(&&*fault.field), "{case}: {fault}");
                        assert_eq!(fault.record, Some(index as u64), "{case}: {fault}");
                        let text = error.to_string();
                        let is_named = text.contains(&fault.to_string())
                            || matches!(
                                error,
                                JournalError::OutOfOrder { .. } | JournalError::BrokenChain { .. }
                            );
                        assert!(is_named, "{case}: {text}");
                        error
                    }
                    (verified, resumed) => panic!("{case}: {verified:?}, {resumed:?}"),
                };
                assert_eq!(error.exit(), process::Exit::Usage, "{case}");
                assert!(
                    fs::read(flown.path().join(FILE_NAME)).unwrap() == before,
                    "{case}: the file is left alone"
                );
            }
            for (field, twist) in FREE {
                let mut records = flown.records.clone();
                if records[index].origin.is_fallback() {
                    continue;
                }
                twist(&mut records[index]);
                flown.write(&records);
                assert_eq!(verify(flown.path()).unwrap().faults(), [""; 0], "{what}, {field}");
                flown.resume().unwrap_or_else(|error| panic!("{what}, {field}: {error}"));
            }
        }
    }
}

/// P-RECOMPUTED. Which actions a planner tried cannot be recomputed; that the guard vetoes them
/// can.
#[test]
fn vetoes_are_checked_for_what_the_guard_vetoes_and_nothing_else() {
    let mut removed = 0;
    for flown in missions() {
        for index in (0..flown.records.len()).filter(|index| flown.records[*index].vetoed != Vetoed::NONE) {
            let mut records = flown.records.clone();
            records[index].vetoed = Vetoed::NONE;
            flown.write(&records);
            assert_eq!(verify(flown.path()).unwrap().faults(), [""; 0], "{}, record {index}", flown.what);
            flown.resume().unwrap();
            records[index].vetoed = flown.records[index].vetoed.with(Action::Hold);
            flown.write(&records);
            let fault = verify(flown.path()).unwrap().fault.unwrap();
            assert_eq!((&*fault.field, fault.record), ("vetoed", Some(index as u64)), "{}", flown.what);
            removed += 1;
        }
    }
    assert!(removed > 0);
}

/// P-NOT-SOUND. The missions that the other tests tamper with have all kinds of records.
#[test]
fn the_missions_that_are_tampered_with_have_vetoes_fallbacks_and_takeovers() {
    let missions = missions();
    let all = || missions.iter().flat_map(|flown| &flown.records);
    assert!(all().any(|record| record.vetoed != Vetoed::NONE));
    assert!(all().any(|record| record.origin.is_fallback()));
    assert!(all().any(|record| record.leader.term > Term(1)));
    assert!(all().any(|record| matches!(record.action, Action::Drive | Action::Fly)));
}

type HeaderTwist = fn(&mut JournalHeader);

/// How each field of a header is changed, and what a refusal may name: of a brief the field, of the text what follows from it. A
/// twist that leaves a header as it was is of other missions.
const HEADER_TWISTS: &[(&str, HeaderTwist, &[&str])] = &[
    ("scenario", |header| header.brief.scenario = name("forged"), &["brief.scenario"]),
    ("hash", |header| header.brief.scenario_hash[31] ^= 1, &["brief.scenario_hash"]),
    ("profile", |header| header.brief.profile = other_profile(header.brief.profile), &["brief.profile"]),
    (
        "robots",
        |header| header.brief.robots = Robots::new(&header.brief.robots[..1]).unwrap(),
        &["brief.robots.1"],
    ),
    (
        "robots.heading",
        |header| header.brief.robots[0].start.heading = Direction::West,
        &["brief.robots.0.start.heading"],
    ),
    ("account", |header| header.brief.account = Account::Actions, &["brief.account"]),
    ("grid.width", |header| header.brief.grid.width += 1, &["brief.grid.width"]),
    ("grid.height", |header| header.brief.grid.height += 1, &["brief.grid.height"]),
    ("grid.cell_size_m", |header| header.brief.grid.cell_size_m *= 2.0, &["brief.grid.cell_size_m"]),
    ("grid.hop_cells", |header| header.brief.grid.hop_cells += 1, &["brief.grid.hop_cells"]),
    ("datum_m", |header| header.brief.datum_m += 1.0, &["brief.datum_m"]),
    ("start", |header| header.brief.robots[0].start.cell.x += 1, &["brief.robots.0.start.cell.x"]),
    (
        "goal",
        |header| {
            let grid = header.brief.grid;
            if let Goal::Reach(reach) = &mut header.brief.robots[0].goal {
                reach.at.y_m -= grid.cell_size_m;
            }
        },
        &["brief.robots.0.goal.at.y_m"],
    ),
    (
        "goals",
        |header| {
            if let Goal::Visit(visit) = &mut header.brief.robots[0].goal {
                visit.hops_max += 1;
            }
        },
        &["brief.robots.0.goal.hops_max"],
    ),
    ("weights", |header| header.brief.weights.distance += 1.0, &["brief.weights.distance"]),
    ("payoff", |header| header.brief.payoff.goal += 1.0, &["brief.payoff.goal"]),
    ("priors.safety", |header| header.brief.priors.safety.max += 1.0, &["brief.priors.safety.max"]),
    ("priors.height_m", |header| header.brief.priors.height_m.min -= 1.0, &["brief.priors.height_m.min"]),
    ("priors.treasures", |header| header.brief.priors.treasures += 1, &["brief.priors.treasures"]),
    (
        "motion.gravity",
        |header| {
            if let Body::Hopper(hopper) = &mut header.brief.robots[0].body {
                hopper.motion.gravity_mps2 = 9.81;
            }
        },
        &["brief.robots.0.body.motion.gravity_mps2"],
    ),
    (
        "motion.hard",
        |header| {
            if let Body::Hopper(hopper) = &mut header.brief.robots[0].body {
                hopper.motion.hard.flights += 1;
            }
        },
        &["brief.robots.0.body.motion.hard.flights"],
    ),
    (
        "sensor",
        |header| {
            if let Sensor::Disc(disc) = &mut header.brief.robots[0].sensor {
                disc.gain += 0.5;
            }
        },
        &["brief.robots.0.sensor.gain"],
    ),
    ("limits.steps_max", |header| header.brief.limits.steps_max += 1, &["brief.limits.steps_max"]),
    (
        "limits.decision_budget_ns",
        |header| header.brief.limits.decision_budget_ns += 1,
        &["brief.limits.decision_budget_ns"],
    ),
    ("guard.hazard_max", |header| header.brief.guard.hazard_max *= 0.5, &["brief.guard.hazard_max"]),
    ("guard.deadline_ns", |header| header.brief.guard.deadline_ns += 1_000_000, &["brief.guard.deadline_ns"]),
    ("reading", |header| header.brief.reading.opening_steps += 1, &["brief.reading.opening_steps"]),
    (
        "cover",
        |header| {
            if let Goal::Cover(cover) = &mut header.brief.robots[0].goal {
                cover.percent -= 1;
            }
        },
        &["brief.robots.0.goal.percent"],
    ),
    (
        "sampling",
        |header| header.brief.sampling.iter_mut().for_each(|sampling| sampling.seed ^= 1),
        &["brief.sampling.seed"],
    ),
    (
        "required",
        |header| header.brief.robots.iter_mut().for_each(|robot| robot.required ^= true),
        &["brief.robots.0.required"],
    ),
    ("faults", |header| header.faults.push(Fault { robot: RobotId(0), action: 9 }), &["faults"]),
    ("text", |header| header.resolved = "nonsense = (".into(), &["resolved"]),
    ("text", |header| header.resolved.clear(), &["resolved"]),
    (
        "text",
        |header| header.resolved = header.resolved.replace("[robot.sensor]", "[robot.censor]"),
        &["resolved"],
    ),
    (
        "text.name",
        |header| {
            let needed = format!("name = \"{}\"", header.brief.scenario);
            header.resolved = header.resolved.replace(&needed, "name = \"forged\"");
        },
        &["brief.scenario"],
    ),
    (
        "text.gravity",
        |header| header.resolved = header.resolved.replace("gravity_mps2 = 3.72", "gravity_mps2 = 9.81"),
        // The first hopper's; where no robot hops, only the hash tells.
        &[
            "brief.robots.0.body.motion.gravity_mps2",
            "brief.robots.2.body.motion.gravity_mps2",
            "brief.scenario_hash",
        ],
    ),
    // What the mission is flown on.
    (
        "text.truth",
        |header| header.resolved = header.resolved.replace("amplitude_m = 0.159", "amplitude_m = 0.959"),
        &["brief.scenario_hash"],
    ),
    (
        "text.budget",
        |header| {
            header.resolved =
                header.resolved.replace("decision_budget_ms = 600.0", "decision_budget_ms = 9.0");
        },
        &["brief.limits.decision_budget_ns"],
    ),
];

fn other_profile(profile: Profile) -> Profile {
    if profile == Profile::Hopper { Profile::Paper2023 } else { Profile::Hopper }
}

/// P-NOT-SOUND.
/// P-RECOMPUTED. Nothing is taken from the header unchecked.
#[test]
fn a_header_with_any_field_changed_is_refused_by_field_whoever_reads_it() {
    let mut twisted = std::collections::BTreeSet::new();
    for flown in missions() {
        for (field, twist, named) in HEADER_TWISTS {
            let mut header = flown.header();
            twist(&mut header);
            if header == flown.header() {
                continue;
            }
            twisted.insert(*field);
            flown.write_under(&header);
            let before = fs::read(flown.path().join(FILE_NAME)).unwrap();
            let case = format!("{}, {field}", flown.what);
            let error = match (verify(flown.path()), flown.resume()) {
                // What is beyond the bounds of a brief is no header.
                (Err(JournalError::BadHeader { .. }), Err(error @ JournalError::BadHeader { .. })) => error,
                (Ok(verification), Err(error)) => {
                    let fault = verification.fault.unwrap_or_else(|| panic!("{case} is taken for sound"));
                    assert_eq!(fault.record, None, "{case}: {fault}");
                    assert!(named.contains(&&*fault.field), "{case}: {fault}");
                    assert!(fault.need != fault.got && fault.to_string().len() < 400, "{case}: {fault}");
                    assert!(matches!(error, JournalError::Mismatch { .. }), "{case}: {error}");
                    let reader = JournalReader::open(flown.path()).unwrap();
                    let world = reader.world().unwrap_err();
                    assert!(world.to_string().contains(&fault.to_string()), "{case}: {world}");
                    assert!(matches!(reader.require_sound(), Err(JournalError::NotSound { .. })), "{case}");
                    error
                }
                (verified, resumed) => panic!("{case}: {verified:?}, {resumed:?}"),
            };
            assert_eq!(error.exit(), process::Exit::Usage, "{case}");
            assert!(error.to_string().len() < 600, "{case}: {error}");
            assert!(
                fs::read(flown.path().join(FILE_NAME)).unwrap() == before,
                "{case}: the file is left alone"
            );
        }
    }
    let all: std::collections::BTreeSet<&str> = HEADER_TWISTS.iter().map(|(field, ..)| *field).collect();
    assert_eq!(twisted, all, "each field is one of some mission");
}

/// P-NOT-SOUND. With any header whose checksum holds nothing panics, and a journal that passes is
/// the same mission.
#[test]
fn a_header_with_any_byte_changed_is_refused_or_of_the_same_mission() {
    let missions = missions();
    std::thread::scope(|scope| {
        for flown in &missions {
            scope.spawn(|| change_each_byte(flown));
        }
    });
}

fn change_each_byte(flown: &Flown) {
    let (what, header) = (flown.what, flown.header());
    let bytes = fs::read(flown.path().join(FILE_NAME)).unwrap();
    let [version, text] = header_payloads(&bytes);
    let changed = (8..12).chain(version.clone()).chain(text.clone());
    let mut sound = 0;
    for at in changed {
        let mut head = bytes.clone();
        head[at] ^= 1 << (at % 8);
        flown.write_behind(
            [&head[..12], &frame(&head[version.clone()]), &frame(&head[text.clone()])].concat(),
        );
        let (verified, resumed) = (verify(flown.path()), flown.resume());
        let is_sound = matches!(&verified, Ok(verification) if verification.is_sound());
        assert_eq!(is_sound, resumed.is_ok(), "{what}, byte {at}: {verified:?}, {resumed:?}");
        if is_sound {
            sound += 1;
            let reader = JournalReader::open(flown.path()).unwrap();
            let world = reader.world().unwrap();
            let need = JournalHeader::new(&world, reader.header().seed).with_run(header.run());
            assert_eq!(
                (need.brief, need.faults),
                (header.brief.clone(), header.faults.clone()),
                "{what}, byte {at}"
            );
            assert_eq!(world.terrain, flown.world.terrain, "{what}, byte {at}");
        }
    }
    assert!(sound > version.len(), "{what}: version and run may be any");
}
