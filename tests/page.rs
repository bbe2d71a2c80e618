//! The account behind the monitor's page: the same for whoever comes when, at whatever speed they read.

use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::{Arc, Mutex};

use contract::limits::{PAST_PAGE_RECORDS, TABLE_PAGE_ROWS};
use contract::{
    Action, Body, Brief, Decision, Detail, DetailPage, Goal, MapPatch, MonotonicNs, MotionModel, MotionRow,
    MotionTable, Name, Pacing, PastPage, Policy, PolicyCell, Record, RobotId, RunId, State, TableLanding,
    TablePage, TableRequest,
};
use hopper_sim::{Arbiter, Mission, Pace};
use lockstep::PlannerSchedule;
use monitor::history::{CELLS_A_FRAME, Chances, Cursor, Frame, POLICY_SIDE_MAX};
use monitor::web::{HISTORIES_MAX, POLICIES_MAX, Page};
use monitor::{History, Input, Watcher};
use perception::{Cartographer, Event};
use scenario::{ResolvedScenario, Scenario};
use serde_json::{Value, json};

const ROBOT: RobotId = RobotId(0);

/// A flown mission with all that was published of it.
struct Flown {
    brief: Brief,
    records: Vec<Record>,
    states: Vec<State>,
    patches: Vec<Vec<MapPatch>>,
    cartographer: Cartographer,
    details: Vec<(Decision, Detail)>,
}

fn flown(scenario: &str) -> Flown {
    flown_in(scenario::load(scenario).unwrap().resolve().unwrap())
}

fn flown_in(world: ResolvedScenario) -> Flown {
    let mut brief = Brief { run: RunId(77), ..world.brief.clone() };
    if let Goal::Visit(visit) = &mut brief.robots[0].goal {
        visit.hops_max = 60;
    }
    let mission = Mission { brief: brief.clone(), ..Mission::of(&world, 3) };
    let mut records = Vec::new();
    let schedule = PlannerSchedule::single("mdp".parse().unwrap());
    let mut ns = 0;
    let mut clock = || {
        ns += 1_000;
        MonotonicNs(ns)
    };
    let ended = lockstep::fly(mission.clone(), &schedule, &mut clock, &mut |record| records.push(*record));
    let details = ended.unwrap().details;
    let opening = *Arbiter::new(mission, None, Pace::Max, 0, MonotonicNs(1)).state();
    let later = records
        .iter()
        .map(|record| record.state_after(brief.run, record.timing.committed, record.timing.committed));
    let states: Vec<State> = std::iter::once(opening).chain(later).collect();
    let mut cartographer = Cartographer::new(ROBOT);
    cartographer.on(Event::Terrain(brief.run, world.terrain), MonotonicNs(0));
    cartographer.on(Event::Brief(brief.clone()), MonotonicNs(0));
    let patches = states.iter().map(|state| {
        cartographer.on(Event::State(*state), state.landed);
        cartographer.patches(state.landed, &mut || state.landed)
    });
    let patches = patches.collect();
    Flown { brief, records, states, patches, cartographer, details }
}

/// Everything that a reader gets until there is no more.
fn drain(account: &History, cursor: &mut Cursor) -> Vec<Frame> {
    let frames: Vec<Frame> = std::iter::from_fn(|| account.next(cursor, MonotonicNs(1))).collect();
    assert!(!account.has_news(cursor));
    for frame in &frames {
        assert!(
            !frame.data.contains('\n') && frame.data.len() < 200_000,
            "{}: {}",
            frame.event,
            frame.data.len()
        );
    }
    frames
}

/// What frames tell that does not depend on how they were cut: hops, and cells by index.
fn content(frames: &[Frame]) -> (Vec<Value>, BTreeMap<i64, (i64, i64)>) {
    let (mut hops, mut cells) = (Vec::new(), BTreeMap::new());
    for frame in frames {
        let value: Value = serde_json::from_str(&frame.data).unwrap();
        match frame.event {
            "hops" => hops.extend(value["rows"].as_array().unwrap().clone()),
            "cells" => {
                let list = |name: &str| -> Vec<i64> {
                    value[name].as_array().unwrap().iter().map(|number| number.as_i64().unwrap()).collect()
                };
                let (indices, heights, dates) = (list("i"), list("h"), list("at"));
                assert!(indices.len() == heights.len() && indices.len() == dates.len());
                assert!(indices.len() <= CELLS_A_FRAME);
                let (mut index, mut date) = (0, 0);
                for n in 0..indices.len() {
                    index += indices[n];
                    date += dates[n];
                    cells.insert(index, (heights[n], date));
                }
            }
            _ => {}
        }
    }
    (hops, cells)
}

/// P-WEB-ACCOUNT: A reader that watches from the start, reads slowly or starts late gets the same
/// history of hops and cells.
#[test]
fn an_account_begun_late_or_read_slowly_is_the_account_from_the_start() {
    the_account_is_the_same_for_all(&flown("treasures"));
    // Divided by 0.7 m, a hop of three such cells is a little less than three.
    let rounded = Scenario::parse(ROUNDED, "rounded").unwrap().resolve().unwrap();
    the_account_is_the_same_for_all(&flown_in(rounded));
}

/// P-WEB-DETAILS.
#[test]
fn details_are_asked_for_in_turn_and_told_once_and_nothing_is_asked_for_under_the_law() {
    let law = flown("hard");
    let mut account = History::new(ROBOT);
    account.on(Input::Brief(&law.brief), MonotonicNs(0));
    for state in &law.states {
        account.on(Input::State(state), state.landed);
        assert_eq!(account.wanted(state.landed).detail, None, "decision {}", state.decision);
    }
    assert!(!account.lacks_details());
    assert!(drain(&account, &mut Cursor::default()).iter().all(|frame| frame.event != "details"));

    let mut scenario = scenario::load("hard").unwrap();
    scenario.truth.dynamics = scenario::Dynamics::of(MotionModel::Contact);
    let flown = flown_in(scenario.resolve().unwrap());
    assert!(flown.details.iter().any(|(_, detail)| detail.path.len() > 2), "some hop bounces");
    let run = flown.brief.run;
    let page = |decision: Decision| {
        let (_, detail) = flown.details.iter().find(|(known, _)| *known == decision)?;
        Some(DetailPage { run, decision, detail: detail.clone() })
    };
    let mut account = History::new(ROBOT);
    account.on(Input::Brief(&flown.brief), MonotonicNs(0));
    flown.states.iter().for_each(|state| _ = account.on(Input::State(state), state.landed));
    let (mut now, mut answered, mut cursor) = (MonotonicNs(1), 0, Cursor::default());
    while account.lacks_details() {
        let Some(request) = account.wanted(now).detail else {
            now = now.plus_ns(contract::limits::ASK_AGAIN_NS);
            continue;
        };
        answered += 1;
        // Every third answer is lost, and every fifth is one of another decision.
        let decision = if answered % 5 == 0 { Decision(request.decision.0 + 1) } else { request.decision };
        let answer = if answered % 3 == 0 { None } else { page(decision) };
        if let Some(answer) = answer {
            account.on(Input::Detail(&answer), now);
            account.on(Input::Detail(&answer), now);
        }
    }
    assert_eq!(account.wanted(now.plus_ns(u64::MAX / 2)).detail, None);
    let frames = drain(&account, &mut cursor);
    let told = frames.iter().filter(|frame| frame.event == "details").flat_map(|frame| {
        let value: Value = serde_json::from_str(&frame.data).unwrap();
        value["rows"].as_array().unwrap().clone()
    });
    let told: BTreeMap<u64, Value> =
        told.map(|row| (row["decision"].as_u64().unwrap(), row["detail"].clone())).collect();
    let expected: BTreeMap<u64, Value> =
        flown.details.iter().map(|(decision, detail)| (decision.0, json!(detail))).collect();
    assert_eq!(told, expected);
    assert_eq!(account.details().unwrap().iter().count(), expected.len(), "each once");
}

/// Hops of three cells of 0.7 m over ground so flat that the sensor sees no further than one of them.
const ROUNDED: &str = r#"
[truth.terrain.random_hills]
width_cells = 31
height_cells = 31
cell_size_m = 0.7
seed = 7
hills = 5
sigma_m = [0.7, 2.0]
amplitude_m = [0.005, 0.02]
reach_sigma = 6.0
[brief]
start = [0, 0]
goal = [30, 30]
[robot]
hop_distance_m = 2.1
"#;

fn the_account_is_the_same_for_all(flown: &Flown) {
    let mut live = History::new(ROBOT);
    live.on(Input::Brief(&flown.brief), MonotonicNs(0));
    let (mut quick, mut frames) = (Cursor::default(), Vec::new());
    for (state, patches) in flown.states.iter().zip(&flown.patches) {
        live.on(Input::State(state), state.landed);
        for patch in patches {
            assert_eq!(live.on(Input::Patch(patch.clone()), state.landed), None, "nothing was missed");
        }
        live.on(Input::Tick, state.landed);
        frames.extend(drain(&live, &mut quick));
    }
    assert_eq!(
        (frames[0].event, frames.iter().filter(|frame| frame.event == "mission").count()),
        ("mission", 1)
    );
    let from_the_start = content(&frames);
    assert_eq!(from_the_start.0.len(), flown.records.len());
    let seen = flown.cartographer.map().unwrap().seen_cells();
    assert_eq!(from_the_start.1.len(), seen, "every seen cell was told");
    let slow = content(&drain(&live, &mut Cursor::default()));
    assert!(slow == from_the_start, "who read nothing until now has missed nothing");

    let mut late = History::new(ROBOT);
    let now = MonotonicNs(1 << 40);
    late.on(Input::Brief(&flown.brief), now);
    late.on(Input::State(flown.states.last().unwrap()), now);
    let mut request = late.on(Input::Tick, now);
    for (page, records) in flown.records.chunks(PAST_PAGE_RECORDS).enumerate() {
        let from = Decision((page * PAST_PAGE_RECORDS) as u64);
        let page = PastPage { run: flown.brief.run, robot: ROBOT, from, records: records.to_vec() };
        late.on(Input::Past(&page), now);
    }
    while let Some(asked) = request {
        request = late.on(Input::Page(&flown.cartographer.page(&asked).unwrap()), now);
    }
    late.on(Input::Tick, now);
    assert!(content(&drain(&late, &mut Cursor::default())) == from_the_start, "the past tells the same");
}

/// What the terminal shows of a moment gone by, and the page by the same rule.
#[test]
fn looking_back_shows_the_treasures_of_that_moment() {
    let flown = flown("treasures");
    let mut account = History::new(ROBOT);
    account.on(Input::Brief(&flown.brief), MonotonicNs(0));
    let mut lying = Vec::new();
    for (state, patches) in flown.states.iter().zip(&flown.patches) {
        account.on(Input::State(state), state.landed);
        patches.iter().for_each(|patch| _ = account.on(Input::Patch(patch.clone()), state.landed));
        account.on(Input::Tick, state.landed);
        lying.push(sorted(account.treasures(state.decision)));
    }
    let collected = flown.states.last().unwrap().collected.count();
    assert!(collected > 0, "the mission collects some, or nothing is told by this");
    for (state, then) in flown.states.iter().zip(&lying) {
        assert_eq!(&sorted(account.treasures(state.decision)), then, "at decision {}", state.decision);
    }
}

fn sorted(mut cells: Vec<contract::Cell>) -> Vec<contract::Cell> {
    cells.sort_unstable_by_key(|cell| (cell.y, cell.x));
    cells
}

/// A built-in world whose planners believe a table: hops that rise fall short, those that fall go too far or are lost.
fn by_table(scenario: &str) -> ResolvedScenario {
    let mut world = scenario::load(scenario).unwrap().resolve().unwrap();
    let rows = (0..MotionTable::ROWS).map(|class| {
        let steep = 0.05 * (class % 5) as f64;
        let landing = |forward, left, probability| TableLanding { forward, left, probability };
        let landings = [
            landing(1, 0, 0.7 - steep),
            landing(0, 0, 0.1),
            landing(0, -1, 0.02),
            landing(2, 0, 0.1 + steep / 2.0),
            landing(1, 1, 0.05 + steep / 4.0),
        ];
        MotionRow::new(&landings).unwrap()
    });
    let table = MotionTable::new(rows.collect()).unwrap();
    for robot in world.brief.robots.iter_mut() {
        if let Body::Hopper(hopper) = &mut robot.body {
            hopper.motion.table = table.fingerprint();
        }
    }
    world.table = Some(Arc::new(table));
    world
}

/// Tells the history the table that it asks for; without it there are no chances.
fn hear(history: &mut History, table: &MotionTable, start: &State) {
    assert!(history.lacks_table());
    while let Some(TableRequest { run, from }) = history.wanted(MonotonicNs(1)).table {
        assert_eq!(history.reason(start.pose.cell, start.decision), None);
        let rows = table.rows()[from as usize..].iter().take(TABLE_PAGE_ROWS).copied().collect();
        history.on(Input::Table(TablePage { run, from, rows }), MonotonicNs(1));
    }
    assert!(!history.lacks_table());
}

/// Holds that every cell's value in the policy is that of its best hop, whether the cell is seen or not, on the edge or not.
fn are_of_the_best_hops(history: &History, state: &State, cells: &[PolicyCell], tolerance: f64) {
    let (brief, cell) = (history.brief().unwrap(), state.pose.cell);
    for at in brief.grid.iter().filter(|at| at.x % 3 == 0 && at.y % 3 == 0 || *at == cell) {
        let policy = cells[brief.grid.index(at).unwrap()];
        let reason = history.reason(at, state.decision).unwrap();
        let values: Vec<f64> = reason.hops.iter().filter_map(|hop| hop.value).collect();
        let Action::Hop(_) = policy.action else { continue };
        let best = values.into_iter().fold(f64::MIN, f64::max);
        let is_best = (best - policy.value).abs() <= tolerance;
        assert!(is_best, "{} {at:?}: {best} or {}", brief.scenario, policy.value);
    }
}

/// P-WEB-WHY: The values of the four hops that the page shows are those of the planner's own model,
/// and its choice is the best of them.
#[test]
fn the_reason_for_a_hop_is_the_planners_own() {
    let worlds =
        ["hard", "sandy", "hills", "patrol"].map(|name| scenario::load(name).unwrap().resolve().unwrap());
    let by_table = ["hills", "sandy"].map(by_table);
    for world in worlds.into_iter().chain(by_table) {
        let table = world.table.clone();
        let flown = flown_in(world);
        let mut history = History::new(ROBOT);
        history.on(Input::Brief(&flown.brief), MonotonicNs(0));
        if let Some(table) = &table {
            hear(&mut history, table, &flown.states[0]);
        }
        let mut planner = planner::algorithm("mdp").unwrap();
        let mut map = contract::ObservedMap::unseen(flown.brief.run, ROBOT, flown.brief.grid);
        let mut hops = 0;
        for (state, patches) in flown.states.iter().zip(&flown.patches).take(40) {
            history.on(Input::State(state), state.landed);
            for patch in patches {
                patch.cells.iter().for_each(|seen| _ = map.learn(seen.index as usize, seen.ground));
                history.on(Input::Patch(patch.clone()), state.landed);
            }
            map.mark();
            history.on(Input::Tick, state.landed);
            let (brief, cell) = (&flown.brief, state.pose.cell);
            let before = history.reason(cell, state.decision).unwrap();
            assert!(hops > 0 || before.policy.is_none() && before.hops.iter().all(|hop| hop.value.is_none()));
            if state.status.is_over() {
                break;
            }
            let leg = brief.leg(state.visits);
            let alone = planner::Situation::alone(brief, &leg, &map, state);
            let situation = planner::Situation { table: table.as_deref(), ..alone };
            let plan = planner.plan(&situation, &planner::Budget::of(None));
            let cells = planner.policy().unwrap();
            let Action::Hop(chosen) = plan.action else { continue };
            let policy = Policy {
                run: flown.brief.run,
                robot: ROBOT,
                decision: state.decision,
                planner: planner.name(),
                error_bound: plan.error_bound,
                cells: cells.clone(),
            };
            history.on(Input::Policy(policy), state.landed);
            let tolerance = 2.0 * plan.error_bound + 1e-6;
            let reason = history.reason(cell, state.decision).unwrap();
            let best = reason.hops.iter().map(|hop| hop.value.unwrap()).fold(f64::MIN, f64::max);
            let value = reason.hops[chosen as usize].value.unwrap();
            assert!(value >= best - tolerance, "{} {cell:?}: {reason:?}", flown.brief.scenario);
            are_of_the_best_hops(&history, state, &cells, tolerance * 1e3);
            for hop in reason.hops {
                let Chances { aimed, stayed, left, right, elsewhere, lost } = hop.chances;
                assert!((aimed + stayed + left + right + elsewhere + lost - 1.0).abs() < 1e-9);
                assert_eq!(elsewhere > 0.0 && lost > 0.0, table.is_some(), "only a table has both");
            }
            hops += 1;
        }
        assert!(hops > 10, "{}: {hops}", flown.brief.scenario);
    }
}

/// P-WEB-WHY.
#[test]
fn the_reason_is_that_of_the_planner_in_command() {
    let flown = flown("hard");
    let mut history = History::new(ROBOT);
    history.on(Input::Brief(&flown.brief), MonotonicNs(0));
    for (state, patches) in flown.states.iter().zip(&flown.patches).take(4) {
        history.on(Input::State(state), state.landed);
        patches.iter().for_each(|patch| _ = history.on(Input::Patch(patch.clone()), state.landed));
    }
    let state = flown.states[3];
    history.on(Input::Tick, state.landed);
    let policy = Policy {
        run: flown.brief.run,
        robot: ROBOT,
        decision: state.decision,
        planner: "mdp".parse().unwrap(),
        error_bound: 0.0,
        cells: vec![PolicyCell { action: Action::Hold, value: 1.0 }; flown.brief.grid.cells()],
    };
    history.on(Input::Policy(policy), state.landed);
    let shown = |history: &History| history.reason(state.pose.cell, state.decision).unwrap().policy;
    assert_eq!(shown(&history).map(|(planner, ..)| planner.to_string()), Some("mdp".into()));
    let leader =
        contract::Leader { planner: "greedy".parse().unwrap(), term: contract::Term(9), ..state.leader };
    history.on(Input::State(&State { leader, ..state }), state.landed);
    assert_eq!(shown(&history), None);
}

/// A flown rover with a helicopter that errs: its robots at the start, its records, its routes, and what it saw last.
struct Scouted {
    mission: Mission,
    records: Vec<Record>,
    routes: Vec<contract::Route>,
    team: contract::Team,
    map: contract::ObservedMap,
}

fn scouted(accuracy: &str) -> Scouted {
    // The last table is that of the helicopter.
    let text = format!("{}{accuracy}\n", include_str!("../scenarios/rover-helicopter.toml"));
    let world = Scenario::parse(&text, "scouted").unwrap().resolve().unwrap();
    let brief = Brief { run: RunId(77), ..world.brief.clone() };
    let mission = Mission { brief, ..Mission::of(&world, 3) };
    let planners: Vec<Name> = ["rrt_star_ett", "rrt_star_it"].map(|name| name.parse().unwrap()).into();
    let schedule = PlannerSchedule::of_robots(&planners);
    let mut records = Vec::new();
    let hooks = lockstep::Hooks {
        make: Box::new(lockstep::algorithm),
        clock: Box::new(|| MonotonicNs(0)),
        observe: Box::new(|record| records.push(*record)),
    };
    let tempo = lockstep::Tempo { pace: Pace::Max, control: false };
    let mut flight = lockstep::Flight::begin(mission.clone(), &schedule, tempo, hooks).unwrap();
    while !flight.round().unwrap() {}
    let routes = flight.routes();
    let map = flight.into_map().unwrap();
    let team = Arbiter::new(mission.clone(), None, Pace::Max, 0, MonotonicNs(1)).team().unwrap().clone();
    Scouted { mission, records, routes, team, map }
}

impl Scouted {
    /// The history of whoever comes at the end, and asks for all that is missing.
    fn history(&self) -> History {
        let (brief, run) = (self.mission.brief.clone(), self.mission.brief.run);
        let mut history = History::new(ROBOT);
        let mut now = MonotonicNs(1);
        history.on(Input::Brief(&brief), now);
        let page = PastPage { run, robot: ROBOT, from: Decision(0), records: self.records.clone() };
        history.on(Input::Past(&page), now);
        history.on(Input::Team(&self.team), now);
        let patch = patch_of(&self.map);
        assert_eq!(history.on(Input::Patch(patch), now), None);
        history.on(Input::Tick, now);
        let mut pages = 0;
        while history.lacks_pages() {
            now = now.plus_ns(1);
            let wanted = history.wanted(now);
            assert!(wanted != monitor::history::Wanted::default(), "it asks for what it lacks");
            if let Some(request) = wanted.prior {
                pages += 1;
                let page = self.mission.prior_page(&request, contract::limits::PRIOR_PAGE_CELLS).unwrap();
                history.on(Input::Prior(page), now);
            }
            if let Some(request) = wanted.route {
                let route = self.routes.iter().find(|route| route.id() == request.id).unwrap().clone();
                history.on(Input::Route(&contract::RoutePage { run, route }), now);
            }
        }
        assert_eq!(pages, brief.grid.cells().div_ceil(contract::limits::PRIOR_PAGE_CELLS), "each page once");
        assert_eq!(
            history.wanted(MonotonicNs(u64::MAX)),
            monitor::history::Wanted::default(),
            "once, and no more"
        );
        history
    }
}

/// All that is in a map, as one patch.
fn patch_of(map: &contract::ObservedMap) -> MapPatch {
    let seen = map.cells().iter().enumerate();
    let cells = seen.filter_map(|(index, ground)| {
        Some(contract::SeenCell { index: index as u32, visits: map.visits(index), ground: (*ground)? })
    });
    MapPatch {
        run: map.run,
        robot: ROBOT,
        through: map.through.unwrap(),
        digest: map.digest,
        more: 0,
        sequence: 1,
        before: contract::ObservedMap::unseen(map.run, ROBOT, map.grid).observation(),
        after: map.observation(),
        sensed: MonotonicNs(1),
        published: MonotonicNs(1),
        grid: map.grid,
        seen_cells: map.seen_cells() as u32,
        treasures: Vec::new(),
        cells: cells.collect(),
    }
}

/// What frames tell of expected speeds and routes.
#[derive(Default)]
struct Told {
    /// The distinct distributions, and the number of each cell's.
    rows: Vec<Value>,
    codes: Vec<usize>,
    /// What was observed of each cell: 0 nothing, 1 to 4 a speed, 5 to 8 a reading.
    observed: Vec<usize>,
    routes: Vec<Value>,
}

impl Told {
    fn by(frames: &[Frame], cells: usize) -> Self {
        let mut told = Self { observed: vec![0; cells], ..Self::default() };
        for frame in frames {
            let data: Value = serde_json::from_str(&frame.data).unwrap();
            let list = |name: &str| data[name].as_array().unwrap().clone();
            let numbers =
                |name: &str| list(name).iter().map(|number| number.as_i64().unwrap()).collect::<Vec<_>>();
            match frame.event {
                "speeds" => {
                    assert_eq!(data["from"], told.codes.len());
                    told.rows.extend(list("rows"));
                    for run in numbers("runs").chunks(2) {
                        told.codes.resize(told.codes.len() + run[1] as usize, run[0] as usize);
                    }
                }
                "cells" => {
                    let mut index = 0;
                    for (step, code) in numbers("i").into_iter().zip(numbers("v")) {
                        index += step;
                        told.observed[index as usize] = code as usize;
                    }
                }
                "routes" => told.routes.push(data),
                _ => {}
            }
        }
        told
    }

    /// Expected speed and spread of a cell, m/Sol.
    fn speed(&self, index: usize) -> [f64; 2] {
        // What readings do not change is told once.
        let row = self.rows[self.codes[index]].as_array().unwrap();
        let number = |n: usize| row[n % row.len()].as_f64().unwrap();
        match self.observed[index] {
            0 => [number(0), number(1)],
            speed @ 1..=4 => [[0.0, 50.0, 150.0, 200.0][speed - 1], 0.0],
            reading => [number(2 * (reading - 4)), number(2 * (reading - 4) + 1)],
        }
    }
}

/// P-WEB-SPEEDS: The page receives the expected speed and the spread of every cell, and all
/// announced routes.
/// P-SPEED-LAYER.
#[test]
fn the_frames_tell_the_expected_speed_of_every_cell_as_planners_count_with_it() {
    for accuracy in ["", "accuracy = 0.9"] {
        let scouted = scouted(accuracy);
        let frames = drain(&scouted.history(), &mut Cursor::default());
        let told = Told::by(&frames, scouted.map.grid.cells());
        assert_eq!(told.codes.len(), scouted.map.grid.cells());
        let camera = helicopter::Sensor::with_accuracy(0.9).unwrap();
        let camera = if accuracy.is_empty() { None } else { Some(&camera) };
        let mut kinds = std::collections::BTreeSet::new();
        for (index, prior) in scouted.mission.terrain.prior.iter().enumerate() {
            let ground = scouted.map.cells()[index];
            let speed = |speed: contract::DriveSpeed| rover::Speed::ALL[speed as usize];
            let sighting = helicopter::Sighting {
                speed: ground.and_then(|ground| ground.speed).map(speed),
                reading: ground.and_then(|ground| ground.reading).map(speed),
            };
            kinds.insert((sighting.speed.is_some(), sighting.reading.is_some()));
            let prior = rover::SpeedDistribution::as_given(prior.probabilities()).unwrap();
            let belief = sighting.belief(prior, camera);
            // Told with one decimal.
            let need = [belief.mean_m_per_sol(), belief.sd_m_per_sol()];
            for (told, need) in told.speed(index).into_iter().zip(need) {
                assert!((told - need).abs() <= 0.0501, "cell {index}: told {told}, need {need}");
            }
        }
        assert!(kinds.contains(&(false, false)) && kinds.contains(&(true, false)), "{kinds:?}");
        assert_eq!(kinds.contains(&(false, true)), !accuracy.is_empty(), "{kinds:?}");
        let announces = |record: &&Record| matches!(record.action, Action::Announce(_));
        let announced: Vec<u64> =
            scouted.records.iter().filter(announces).map(|record| record.decision.0).collect();
        let decisions = told.routes.iter().map(|route| route["decision"].as_u64().unwrap());
        assert_eq!(decisions.collect::<Vec<_>>(), announced);
        let points: usize = told.routes.iter().map(|route| route["points"].as_array().unwrap().len()).sum();
        assert_eq!(points, scouted.routes.iter().map(|route| route.waypoints().len()).sum::<usize>());
    }
}

/// P-PRIOR-ALONE: For a hopper alone, and for rovers that cover ground, no prior and no route is
/// requested.
#[test]
fn nothing_is_asked_of_a_mission_without_routes() {
    for name in ["hard", "coverage"] {
        let world = scenario::load(name).unwrap().resolve().unwrap();
        let mut history = History::new(ROBOT);
        history.on(Input::Brief(&world.brief), MonotonicNs(0));
        assert_eq!(history.wanted(MonotonicNs(1)), monitor::history::Wanted::default(), "{name}");
        assert!(!history.lacks_pages(), "{name}");
        let frames = drain(&history, &mut Cursor::default());
        assert!(frames.iter().all(|frame| frame.event != "speeds"), "{name}");
    }
}

/// P-WEB-PALETTE: The page draws the map in the colours of the pictures.
/// P-CONTRAST. The page draws its symbols with the same rims.
#[test]
fn the_page_draws_in_the_colours_of_the_pictures() {
    use report::colour;
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let read = |file: &str| std::fs::read_to_string(root.join("monitor/src/web/page").join(file)).unwrap();
    let palette = read("palette.js");
    for (name, colour) in [
        ("ROUTE", colour::ROUTE),
        ("STRAY", colour::STRAY),
        ("SAND", colour::SAND),
        ("BLOCKED", colour::BLOCKED),
        ("START", colour::START),
        ("HOPPER", colour::HOPPER),
        ("GOAL", colour::GOAL),
        ("TREASURE", colour::TREASURE),
        ("COLLECTED", colour::COLLECTED),
        ("DARK", colour::DARK),
        ("LIGHT", colour::LIGHT),
    ] {
        assert!(palette.contains(&format!("export const {name} = \"{colour}\";")), "{name} {colour}");
    }
    // The colours of layers with a scale are told with the mission.
    let world = scenario::load("rover-helicopter").unwrap().resolve().unwrap();
    let mut history = History::new(ROBOT);
    history.on(Input::Brief(&world.brief), MonotonicNs(0));
    let frames = drain(&history, &mut Cursor::default());
    let mission: Value = serde_json::from_str(&frames[0].data).unwrap();
    for (name, colours) in [("speed", json!(colour::SPEEDS)), ("spread", json!(colour::SPREADS))] {
        let layers = mission["layers"].as_array().unwrap();
        let layer = layers.iter().find(|layer| layer["name"] == name).unwrap();
        assert_eq!(layer["ramp"], colours, "{name}");
    }
    let robots: Vec<String> = (0..8).map(|number| format!("\"{}\"", colour::robot(number))).collect();
    assert!(palette.contains(&format!("ROBOTS = [{}]", robots.join(", "))), "{robots:?}");
    let map = read("map.js");
    // The rims by which hopper and goal stand out on every ground: see P-CONTRAST.
    for line in ["rim === DARK ? LIGHT : DARK", "HOPPER, DARK)", "GOAL, LIGHT)"] {
        assert!(map.contains(line), "{line}");
    }
}

#[test]
fn a_patrol_is_told_with_its_goals_and_the_visits_of_each_hop() {
    let flown = flown("patrol");
    let mut account = History::new(ROBOT);
    account.on(Input::Brief(&flown.brief), MonotonicNs(0));
    flown.states.iter().for_each(|state| _ = account.on(Input::State(state), state.landed));
    let frames = drain(&account, &mut Cursor::default());
    let mission: Value = serde_json::from_str(&frames[0].data).unwrap();
    assert_eq!(mission["goals"].as_array().unwrap().len(), 4);
    assert_eq!(mission["hops_max"], 60);
    let (hops, _) = content(&frames);
    let visits: Vec<u64> = hops.iter().map(|row| row[11].as_u64().unwrap()).collect();
    assert_eq!(visits, flown.records.iter().map(|record| record.visits).collect::<Vec<_>>());
    assert!(visits.last() > Some(&0), "it came somewhere: {visits:?}");
    assert!(hops.iter().all(|row| row[12] == "planner" && row[13] == ""), "nothing was vetoed, nobody late");
}

/// P-WEB-PATCHES: On a map of 821 × 821 cells a landing costs the page's stream only what it
/// reveals.
#[test]
fn a_landing_on_the_largest_map_makes_small_frames() {
    let world = scenario::load("vast").unwrap().resolve().unwrap();
    let brief = Brief { run: RunId(5), ..world.brief.clone() };
    let mission = Mission { brief: brief.clone(), ..Mission::of(&world, 1) };
    let mut state = *Arbiter::new(mission, None, Pace::Max, 0, MonotonicNs(1)).state();
    let mut cartographer = Cartographer::new(ROBOT);
    cartographer.on(Event::Terrain(brief.run, world.terrain), MonotonicNs(0));
    cartographer.on(Event::Brief(brief.clone()), MonotonicNs(0));
    let mut account = History::new(ROBOT);
    account.on(Input::Brief(&brief), MonotonicNs(0));
    let mut cursor = Cursor::default();
    for step in 0..40_u64 {
        cartographer.on(Event::State(state), MonotonicNs(step));
        let patches = cartographer.patches(MonotonicNs(step), &mut || MonotonicNs(step));
        let revealed: usize = patches.iter().map(|patch| patch.cells.len()).sum();
        account.on(Input::State(&state), MonotonicNs(step));
        for patch in patches {
            account.on(Input::Patch(patch), MonotonicNs(step));
        }
        account.on(Input::Tick, MonotonicNs(step));
        let bytes: usize = drain(&account, &mut cursor).iter().map(|frame| frame.data.len()).sum();
        assert!(bytes <= 1024 + 24 * revealed, "{bytes} bytes for {revealed} cells");
        let before = state.pose.cell;
        let to = contract::Cell::new(before.x + 1, before.y);
        state = State {
            decision: state.decision.next(),
            pose: contract::Pose { cell: to, ..state.pose },
            last: Some(contract::Outcome {
                branch: contract::Branch::Intended,
                from: before,
                to,
                flight: contract::Flight::default(),
            }),
            ..state
        };
    }
    assert!(account.seen_cells().unwrap().seen() > 100);
    // Of a policy there is the window around the hopper.
    let cells = vec![PolicyCell { action: Action::Hold, value: 0.5 }; brief.grid.cells()];
    let (planner, decision): (Name, Decision) = ("mdp".parse().unwrap(), Decision(1));
    account.on(
        Input::Policy(Policy { run: brief.run, robot: ROBOT, decision, planner, error_bound: 0.25, cells }),
        MonotonicNs(1),
    );
    let mut policies = Cursor::of_policies();
    let frames = drain(&account, &mut policies);
    let policy: Value = serde_json::from_str(&frames[0].data).unwrap();
    assert_eq!((frames.len(), &policy["width"]), (1, &POLICY_SIDE_MAX.into()));
    assert_eq!(policy["error_bound"], 0.25, "the certificate comes with it");
    assert_eq!(policy["actions"].as_str().unwrap().len() as u32, POLICY_SIDE_MAX * POLICY_SIDE_MAX);
    let x = policy["x"].as_i64().unwrap();
    assert!((x..x + i64::from(POLICY_SIDE_MAX)).contains(&i64::from(state.pose.cell.x)), "{x}");
}

/// P-WEB-SLOW: A client that reads nothing blocks neither the monitor nor another client.
#[test]
fn a_client_that_reads_nothing_holds_up_nobody() {
    let flown = flown("hard");
    let mut watcher = Watcher::new(ROBOT);
    watcher.on(monitor::Event::Brief(flown.brief.clone()), MonotonicNs(0));
    let mut account = History::new(ROBOT);
    account.on(Input::Brief(&flown.brief), MonotonicNs(0));
    let account = Arc::new(Mutex::new(account));
    let page = Page::open("127.0.0.1:0".parse().unwrap(), &[], false, account).unwrap();
    let open = || {
        let mut stream = TcpStream::connect(page.address()).unwrap();
        write!(stream, "GET /events HTTP/1.1\r\nHost: {}\r\n\r\n", page.address()).unwrap();
        stream
    };
    let deaf = open();
    // Far more than any socket's buffer takes.
    let turns = 20_000_u64;
    for turn in 0..turns {
        let mut progress = watcher.progress(MonotonicNs(turn)).unwrap();
        progress.decision = Decision(turn);
        let pacing =
            Pacing { run: flown.brief.run, robot: ROBOT, pace: Pace::Max, paused: false, obeys: false };
        let mut account = page.history();
        account.on(Input::Pacing(pacing), MonotonicNs(turn));
        account.set_progress(progress);
        drop(account);
        page.notify();
    }
    let mut reader = open();
    let (mut text, mut piece) = (Vec::new(), [0; 4096]);
    let newest = format!("\"decision\":{}", turns - 1);
    while !String::from_utf8_lossy(&text).contains(&newest) {
        let count = reader.read(&mut piece).unwrap();
        assert!(count > 0, "the stream ended");
        text.extend_from_slice(&piece[..count]);
    }
    drop((deaf, reader));
}

/// P-WEB-ROOM: Idle readers of policies and of the history take slots neither from the page's files
/// nor from the operator's orders. Streams with the key have slots of their own, and may use those
/// of streams without it.
#[test]
fn idle_readers_leave_room_for_the_page_and_for_orders() {
    let flown = flown("hard");
    let mut account = History::new(ROBOT);
    account.on(Input::Brief(&flown.brief), MonotonicNs(0));
    let page = Page::open("127.0.0.1:0".parse().unwrap(), &[], true, Arc::new(Mutex::new(account))).unwrap();
    let address = page.address();
    let key = page.url().split_once("#key=").unwrap().1.to_owned();
    let ask = |request: &str| answer_to(address, request);
    let get = |path: &str| ask(&format!("GET {path} HTTP/1.1\r\nHost: {address}\r\n\r\n"));
    let mut idle = Vec::new();
    for (path, most) in [("/policy", POLICIES_MAX), ("/events", HISTORIES_MAX)] {
        for number in 0..40 {
            let (stream, answer) = get(path);
            let need = if number < most { "200 OK" } else { "503 Service Unavailable" };
            assert_eq!(answer, format!("HTTP/1.1 {need}"), "{path} {number}");
            // A refused one is closed by its answer; the others stay open and read nothing more.
            idle.extend((number < most).then_some(stream));
        }
    }
    for path in ["/", "/main.js", "/page.css"] {
        assert_eq!(get(path).1, "HTTP/1.1 200 OK", "{path}");
    }
    for path in ["/events", "/policy"] {
        assert_eq!(
            get(&format!("{path}?key=0")).1,
            "HTTP/1.1 503 Service Unavailable",
            "{path} with a guess"
        );
        assert_eq!(get(&format!("{path}?key={key}")).1, "HTTP/1.1 200 OK", "{path} with the key");
    }
    let order = r#"{"order":"pause"}"#;
    let (_, answer) = ask(&format!(
        "POST /control HTTP/1.1\r\nHost: {address}\r\nOrigin: http://{address}\r\n\
         Content-Type: application/json\r\nX-Hopper-Key: {key}\r\nContent-Length: {}\r\n\r\n{order}",
        order.len()
    ));
    assert_eq!(answer, "HTTP/1.1 409 Conflict", "it is heard: no hopper-sim has told whether it obeys");
    drop(idle);
}

/// The first line of the answer to a request, with its connection.
fn answer_to(address: std::net::SocketAddr, request: &str) -> (TcpStream, String) {
    let mut stream = TcpStream::connect(address).unwrap();
    write!(stream, "{request}").unwrap();
    let mut line = Vec::new();
    let mut byte = [0];
    while line.last() != Some(&b'\n') && stream.read(&mut byte).unwrap() == 1 {
        line.push(byte[0]);
    }
    (stream, String::from_utf8(line).unwrap().trim_end().to_owned())
}

/// P-WEB-SLOW-REQUESTS: However many clients send a request slowly or not at all, or accept no
/// answer, whole requests are answered at once, with and without the key.
#[test]
fn slow_clients_keep_nobody_out() {
    let flown = flown("hard");
    let mut account = History::new(ROBOT);
    account.on(Input::Brief(&flown.brief), MonotonicNs(0));
    let page = Page::open("127.0.0.1:0".parse().unwrap(), &[], true, Arc::new(Mutex::new(account))).unwrap();
    let address = page.address();
    let key = page.url().split_once("#key=").unwrap().1.to_owned();
    let order = r#"{"order":"pause"}"#;
    let head = |key: &str| {
        format!(
            "POST /control HTTP/1.1\r\nHost: {address}\r\nOrigin: http://{address}\r\n\
             Content-Type: application/json\r\nX-Hopper-Key: {key}\r\nContent-Length: {}\r\n\r\n",
            order.len()
        )
    };
    let whole = format!("GET /main.js HTTP/1.1\r\nHost: {address}\r\n\r\n");
    let (guess, stream) = (head(&"0".repeat(key.len())), whole.replace("main.js", "events"));
    let slow = [
        "",
        "G",
        &whole[..whole.len() - 2],
        &whole.replace("\r\n\r\n", "\r\nConnection: keep-alive\r\nX:"),
        &whole,
        &guess[..guess.len() - 1],
        &stream,
    ];
    let mut held = Vec::new();
    for _ in 0..40 {
        for request in slow {
            let mut client = TcpStream::connect(address).unwrap();
            // Who makes room for others may find the door closed.
            let _ = write!(client, "{request}");
            held.push(client);
        }
        for path in ["/", "/main.js", "/page.css"] {
            let answer = answer_to(address, &whole.replace("/main.js", path)).1;
            assert_eq!(answer, "HTTP/1.1 200 OK", "{path} after {} slow clients", held.len());
        }
        let answer = answer_to(address, &format!("{}{order}", head(&key))).1;
        assert_eq!(answer, "HTTP/1.1 409 Conflict", "it is heard, after {} slow clients", held.len());
        for path in ["events", "policy"] {
            let request = whole.replace("main.js", &format!("{path}?key={key}"));
            // The places of streams with the key are few: each is left before the next is taken.
            let answered = answer_to(address, &request).1;
            assert!(["HTTP/1.1 200 OK", "HTTP/1.1 503 Service Unavailable"].contains(&answered.as_str()));
        }
    }
    drop(held);
}
