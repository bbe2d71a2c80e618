//! The cartographer builds one map, whatever the order and whoever died.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::sync::Arc;

use contract::limits::{ASK_AGAIN_NS, MAP_PAGE_SPAN};
use contract::wire::{MapPageV2, MapPatchV2, map_page_from_wire, patch_from_wire};
use contract::{
    Action, Branch, Brief, Cell, Decision, Digest, Direction, Flight, Grid, Ground, Leader, MapRequest,
    MonotonicNs, ObservedMap, Outcome, PastPage, PastRequest, Pose, Record, RobotId, RunId, State, Status,
    Timing, TruthPage, TruthRequest,
};
use perception::cartographer::REPUBLISH_NS;
use perception::{Cartographer, Effect, Event};
use terrain::Terrain;

const NOW: MonotonicNs = MonotonicNs(1);
const RUN: RunId = RunId(7);

struct World {
    brief: Brief,
    terrain: Arc<Terrain>,
    /// The decision from which on the walk goes north; another one is another timeline.
    turns_at: u64,
}

impl World {
    fn new(profile: contract::Profile) -> Self {
        let world = scenario::load("hard")
            .unwrap()
            .with(&scenario::Overrides { profile: Some(profile), ..Default::default() })
            .resolve()
            .unwrap();
        Self { brief: Brief { run: RUN, ..world.brief }, terrain: world.terrain, turns_at: u64::MAX }
    }

    fn start(&self) -> Cell {
        self.brief.robots[0].start.cell
    }

    fn pose(&self, cell: Cell) -> Pose {
        Pose { cell, height_m: self.terrain.ground(cell).map_or(0.0, |ground| ground.height_m) }
    }

    fn cell(&self, decision: u64) -> Cell {
        let (start, east) = (self.start(), decision.min(self.turns_at));
        Cell::new(start.x + east as i32, start.y + (decision - east) as i32)
    }

    /// A walk east from the start, and north from `turns_at` on: record k leads to pose k + 1.
    fn record(&self, decision: u64) -> Record {
        let (from, to) = (self.cell(decision), self.cell(decision + 1));
        let direction = if decision < self.turns_at { Direction::East } else { Direction::North };
        let previous = decision.checked_sub(1).map_or(Digest::default(), |before| self.record(before).digest);
        let record = Record {
            robot: RobotId(0),
            decision: Decision(decision),
            leader: Leader::default(),
            action: Action::Hop(direction),
            origin: contract::Origin::Planner,
            visits: 0,
            vetoed: contract::Vetoed::NONE,
            observation: 0,
            work: 0,
            cut: false,
            outcome: Outcome { branch: Branch::Intended, from, to, flight: Flight::default() },
            pose: self.pose(to),
            detail: contract::DetailId::NONE,
            collected: contract::Collected::default(),
            steps: 2 * (decision + 1),
            status: Status::Underway,
            timing: Timing::default(),
            previous,
            digest: Digest::default(),
        };
        Record { digest: previous.chain(&record), ..record }
    }

    fn state(&self, decision: u64) -> State {
        if decision == 0 {
            return State {
                decision: Decision(0),
                steps: 0,
                pose: self.pose(self.start()),
                last: None,
                digest: Digest::default(),
                ..self.record(0).state_after(RUN, NOW, NOW)
            };
        }
        self.record(decision - 1).state_after(RUN, NOW, NOW)
    }

    fn page(&self, from: u64, count: u64) -> PastPage {
        PastPage {
            run: RUN,
            robot: RobotId(0),
            from: Decision(from),
            records: (from..from + count).map(|decision| self.record(decision)).collect(),
        }
    }

    fn ready(&self) -> Cartographer {
        let mut cartographer = Cartographer::new(RobotId(0));
        assert_eq!(cartographer.on(Event::Brief(self.brief.clone()), NOW), []);
        assert_eq!(cartographer.on(Event::Terrain(RUN, self.terrain.clone()), NOW), []);
        cartographer
    }

    fn undisturbed(&self, through: u64) -> ObservedMap {
        let mut cartographer = self.ready();
        for decision in 0..=through {
            let effects = cartographer.on(Event::State(self.state(decision)), NOW);
            assert_eq!(effects, [Effect::PublishMap], "decision {decision}");
        }
        cartographer.map().unwrap().clone()
    }
}

fn request(from: u64) -> Effect {
    Effect::RequestPast(PastRequest { run: RUN, robot: RobotId(0), from: Decision(from) })
}

#[test]
fn the_first_map_holds_the_sensing_disc_and_nothing_else() {
    let world = World::new(contract::Profile::Paper2023);
    let map = world.undisturbed(0);
    assert_eq!(map.through, Some(Decision(0)));
    let (_, sensor) = world.brief.robots[0].as_hopper().unwrap();
    let radius_m = sensor.radius_m(world.pose(world.start()).height_m);
    for cell in world.brief.grid.iter() {
        let seen = map.ground(cell).is_some();
        assert_eq!(seen, cell.distance_cells(world.start()) <= radius_m, "{cell}");
        if seen {
            assert_eq!(map.ground(cell), world.terrain.ground(cell), "paper-2023 measures gradients");
        }
    }
}

#[test]
fn the_messages_of_a_run_may_come_in_any_order() {
    let world = World::new(contract::Profile::Paper2023);
    let events = [
        Event::Brief(world.brief.clone()),
        Event::Terrain(RUN, world.terrain.clone()),
        Event::State(world.state(0)),
    ];
    for order in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
        let mut cartographer = Cartographer::new(RobotId(0));
        let mut effects = Vec::new();
        for index in order {
            assert!(effects.is_empty() && cartographer.waits_for().is_some());
            effects = cartographer.on(events[index].clone(), NOW);
        }
        assert_eq!(effects, [Effect::PublishMap], "{order:?}");
        assert_eq!(cartographer.waits_for(), None);
    }
}

/// P-REBUILD: A restarted perception rebuilds the same map from the past.
#[test]
fn a_restarted_perception_rebuilds_the_same_map_from_the_past() {
    for profile in contract::Profile::ALL {
        let world = World::new(profile);
        let mut reborn = world.ready();
        assert_eq!(reborn.on(Event::State(world.state(9)), NOW), [request(0)]);
        let soon = NOW.plus_ns(ASK_AGAIN_NS - 1);
        assert_eq!(reborn.on(Event::Tick, soon), [], "an answer is given time to come");
        assert_eq!(
            reborn.on(Event::State(world.state(9)), soon),
            [],
            "the same state is no reason to ask anew"
        );
        assert_eq!(reborn.on(Event::Tick, NOW.plus_ns(ASK_AGAIN_NS)), [request(0)], "then it is asked again");
        assert_eq!(reborn.on(Event::Past(world.page(0, 4)), NOW), [request(4)]);
        let late = NOW.plus_ns(ASK_AGAIN_NS);
        assert_eq!(reborn.on(Event::Past(world.page(2, 2)), late), [], "an old page brings nothing");
        assert_eq!(reborn.on(Event::Past(world.page(4, 5)), NOW), [Effect::PublishMap]);
        assert_eq!(reborn.map().unwrap().cells(), world.undisturbed(9).cells());
        assert_eq!(reborn.map().unwrap().through, Some(Decision(9)));
        assert_eq!(reborn.map().unwrap().observation(), world.undisturbed(9).observation());
    }
}

#[test]
fn a_page_of_another_run_or_robot_is_not_folded() {
    let world = World::new(contract::Profile::Paper2023);
    let mut reborn = world.ready();
    assert_eq!(reborn.on(Event::State(world.state(9)), NOW), [request(0)]);
    for foreign in
        [PastPage { run: RunId(8), ..world.page(0, 4) }, PastPage { robot: RobotId(1), ..world.page(0, 4) }]
    {
        assert_eq!(reborn.on(Event::Past(foreign), NOW), []);
    }
    assert_eq!(reborn.on(Event::Tick, NOW.plus_ns(ASK_AGAIN_NS)), [request(0)]);
}

#[test]
fn the_ground_is_asked_for_page_by_page_unless_it_is_known() {
    let world = World::new(contract::Profile::Paper2023);
    let whole = world.terrain.cells.len();
    let page = |from: usize, until: usize| {
        let cells = world.terrain.cells[from..until].to_vec();
        let (grid, from, treasures) = (world.brief.grid, from as u32, Vec::new());
        Event::Truth(TruthPage { run: RUN, grid, from, cells, treasures })
    };
    let request = |from| Effect::RequestTruth(TruthRequest { run: RUN, from });
    let mut cartographer = Cartographer::new(RobotId(0));
    cartographer.on(Event::Brief(world.brief.clone()), NOW);
    assert_eq!(cartographer.on(Event::Tick, NOW), [request(0)]);
    assert!(matches!(cartographer.on(page(0, 0), NOW)[..], [Effect::Refused(_)]), "a page without a cell");
    assert_eq!(cartographer.on(page(0, 100), NOW), [request(100)]);
    assert_eq!(cartographer.on(Event::State(world.state(0)), NOW), []);
    assert_eq!(cartographer.on(page(100, whole), NOW), [Effect::PublishMap]);
    assert_eq!(cartographer.map().unwrap().cells(), world.undisturbed(0).cells());
    assert_eq!(world.ready().on(Event::Tick, NOW), [], "known before the brief is begun with");
    let mut told_first = Cartographer::new(RobotId(0));
    told_first.on(Event::Terrain(RUN, world.terrain.clone()), NOW);
    told_first.on(Event::Brief(world.brief), NOW);
    assert_eq!(told_first.on(Event::Tick, NOW), []);
}

#[test]
fn a_landing_is_cut_into_patches_of_as_many_cells_as_asked_for() {
    let world = World::new(contract::Profile::Paper2023);
    let mut cartographer = Cartographer::new(RobotId(0)).with_patches_of(3);
    for event in [
        Event::Brief(world.brief.clone()),
        Event::Terrain(RUN, world.terrain.clone()),
        Event::State(world.state(0)),
    ] {
        cartographer.on(event, NOW);
    }
    let patches = cartographer.patches(NOW, &mut || NOW);
    let (last, rest) = patches.split_last().unwrap();
    assert!(!rest.is_empty() && rest.iter().all(|patch| patch.cells.len() == 3));
    assert!((1..=3).contains(&last.cells.len()));
    let mut seen = 0;
    for patch in &patches {
        seen += patch.cells.len();
        assert_eq!(patch.seen_cells as usize, seen, "of the map after this patch");
    }
    assert_eq!(seen, world.undisturbed(0).seen_cells());
}

fn map_request(from: usize) -> MapRequest {
    MapRequest { run: RUN, robot: RobotId(0), from: from as u32, observation: 0 }
}

#[test]
fn a_page_of_the_map_is_served_once_the_landing_of_the_state_is_published() {
    let world = World::new(contract::Profile::Paper2023);
    let mut cartographer = world.ready();
    cartographer.on(Event::State(world.state(0)), NOW);
    assert_eq!(cartographer.page(&map_request(0)), None, "folded, but not published");
    cartographer.patches(NOW, &mut || NOW);
    assert!(cartographer.page(&map_request(0)).is_some());
    cartographer.on(Event::State(world.state(3)), NOW);
    assert_eq!(cartographer.page(&map_request(0)), None, "published, but behind the state");
}

#[test]
fn a_page_of_the_map_spans_so_many_cells_though_none_of_them_is_seen() {
    let mut world = World::new(contract::Profile::Paper2023);
    let grid = Grid::new(512, 256, 1.0, 1).unwrap();
    let cells = vec![Ground::FLAT; grid.cells()];
    world.terrain = Terrain { grid, cells, treasures: Vec::new(), prior: Vec::new() }.into();
    world.brief.grid = grid;
    let mut cartographer = world.ready();
    cartographer.on(Event::State(world.state(0)), NOW);
    cartographer.patches(NOW, &mut || NOW);
    let next = |from| cartographer.page(&map_request(from)).unwrap().next as usize;
    assert_eq!([next(0), next(MAP_PAGE_SPAN), next(9)], [MAP_PAGE_SPAN, grid.cells(), MAP_PAGE_SPAN + 9]);
}

/// P-UNSEEN: No observation contains anything of unseen cells.
#[test]
fn gradients_of_profile_hopper_come_from_seen_cells_only() {
    let world = World::new(contract::Profile::Hopper);
    let mut altered = World::new(contract::Profile::Hopper);
    let map = world.undisturbed(3);
    for (index, ground) in Arc::make_mut(&mut altered.terrain).cells.iter_mut().enumerate() {
        if map.cells()[index].is_none() {
            ground.height_m += 1.0;
        }
        ground.gradient = [9.0, 9.0];
    }
    assert_eq!(altered.undisturbed(3).cells(), map.cells(), "what is unseen leaks into no gradient");
}

#[test]
fn a_map_is_published_again_for_those_who_missed_it() {
    let world = World::new(contract::Profile::Paper2023);
    let mut cartographer = world.ready();
    cartographer.on(Event::State(world.state(0)), NOW);
    assert_eq!(cartographer.on(Event::Tick, NOW.plus_ns(REPUBLISH_NS - 1)), []);
    assert_eq!(cartographer.on(Event::Tick, NOW.plus_ns(REPUBLISH_NS)), [Effect::PublishMap]);
}

#[test]
fn an_older_state_or_another_run_changes_nothing() {
    let world = World::new(contract::Profile::Paper2023);
    let mut cartographer = world.ready();
    for decision in 0..3 {
        cartographer.on(Event::State(world.state(decision)), NOW);
    }
    let before = cartographer.map().unwrap().clone();
    assert_eq!(cartographer.on(Event::State(world.state(1)), NOW), []);
    let foreign = State { run: RunId(8), ..world.state(1) };
    assert_eq!(cartographer.on(Event::State(foreign), NOW), []);
    assert_eq!(cartographer.map().unwrap(), &before);
}

#[test]
fn a_new_run_drops_all_that_was_known() {
    let world = World::new(contract::Profile::Paper2023);
    let mut cartographer = world.ready();
    for decision in 0..5 {
        cartographer.on(Event::State(world.state(decision)), NOW);
    }
    cartographer.on(Event::Brief(Brief { run: RunId(8), ..world.brief.clone() }), NOW);
    assert_eq!(cartographer.map().unwrap().seen_cells(), 0);
    cartographer.on(Event::Terrain(RunId(8), world.terrain.clone()), NOW);
    let first = State { run: RunId(8), ..world.state(0) };
    assert_eq!(cartographer.on(Event::State(first), NOW), [Effect::PublishMap]);
    assert_eq!(cartographer.map().unwrap().cells(), world.undisturbed(0).cells());
}

#[test]
fn the_end_of_the_mission_is_reported_once() {
    let world = World::new(contract::Profile::Paper2023);
    let mut cartographer = world.ready();
    let end = State { status: Status::LeftMap, ..world.state(0) };
    let effects = cartographer.on(Event::State(end), NOW);
    assert_eq!(effects, [Effect::PublishMap, Effect::Finished(Status::LeftMap)]);
    assert_eq!(cartographer.on(Event::State(end), NOW), []);
    assert_eq!(cartographer.seen(), (RUN, Decision(0), Status::LeftMap));
}

#[test]
fn a_run_is_known_once_its_ground_is() {
    let world = World::new(contract::Profile::Paper2023);
    let mut cartographer = Cartographer::new(RobotId(0));
    cartographer.on(Event::Brief(world.brief), NOW);
    assert_eq!(cartographer.seen().0, RunId::default(), "it cannot sense yet");
    cartographer.on(Event::Terrain(RunId(8), world.terrain.clone()), NOW);
    assert_eq!(cartographer.seen().0, RunId::default(), "on another run's ground");
    cartographer.on(Event::Terrain(RUN, world.terrain.clone()), NOW);
    assert_eq!(cartographer.seen(), (RUN, Decision(0), Status::Underway));
}

/// Found by fuzzing.
#[test]
fn another_brief_of_the_same_run_begins_the_map_anew() {
    let world = World::new(contract::Profile::Paper2023);
    let mut cartographer = Cartographer::new(RobotId(0));
    let wider = contract::Grid { width: world.brief.grid.width + 1, ..world.brief.grid };
    let cells = vec![contract::Ground::FLAT; wider.cells()];
    let terrain = Terrain { grid: wider, cells, ..Terrain::clone(&world.terrain) };
    cartographer.on(Event::Terrain(RUN, terrain.into()), NOW);
    for grid in [world.brief.grid, wider] {
        cartographer.on(Event::Brief(contract::Brief { grid, ..world.brief.clone() }), NOW);
        cartographer.on(Event::State(world.state(0)), NOW);
    }
    assert_eq!(cartographer.map().unwrap().grid, wider);
}

#[test]
fn a_treasure_is_on_the_map_from_sight_to_landing() {
    let mut world = World::new(contract::Profile::Paper2023);
    let start = world.start();
    // The walk goes east along the start's row; its disc reaches two or three cells.
    let [ahead, behind, far] = [(4, 0), (3, 1), (9, 9)].map(|(x, y)| Cell::new(start.x + x, start.y + y));
    Arc::make_mut(&mut world.terrain).treasures = vec![ahead, behind, far];
    let known = |through: u64| {
        let mut cartographer = Cartographer::new(RobotId(0));
        for event in [
            Event::Terrain(RUN, world.terrain.clone()),
            Event::Brief(world.brief.clone()),
            Event::State(world.state(through)),
            Event::Past(world.page(0, through)),
        ] {
            cartographer.on(event, NOW);
        }
        let map = cartographer.map().unwrap().clone();
        assert_eq!(map.through, Some(Decision(through)));
        map.treasures().to_vec()
    };
    assert_eq!(known(0), []);
    assert_eq!(known(3), [ahead, behind], "both are in sight, in index order; the far one is not");
    assert_eq!(known(4), [behind], "landing has collected one");
    assert_eq!(known(6), [behind], "what is out of sight again stays known, what is collected stays away");
}

/// A cartographer that has followed the walk up to `through`.
fn following(world: &World, through: u64) -> Cartographer {
    let mut cartographer = world.ready();
    for decision in 0..=through {
        cartographer.on(Event::State(world.state(decision)), NOW);
    }
    cartographer
}

/// Carries out what a cartographer asks for until its map is up to `state`.
fn catch_up(cartographer: &mut Cartographer, world: &World, state: State) {
    let mut now = state.published;
    let mut effects = cartographer.on(Event::State(state), now);
    for _ in 0..100 {
        if effects.contains(&Effect::PublishMap) {
            return;
        }
        now = now.plus_ns(ASK_AGAIN_NS);
        let asked = effects.iter().find_map(|effect| match effect {
            Effect::RequestPast(request) => Some(request.from.0),
            _ => None,
        });
        effects = match asked {
            Some(from) => {
                let page = world.page(from, (state.decision.0 - from).min(3));
                cartographer.on(Event::Past(page), now)
            }
            None => cartographer.on(Event::Tick, now),
        };
    }
    panic!("never caught up");
}

/// P-TIMELINE. A journal is restored to decision 10 and continued elsewhere, to before, at and
/// after the decision that perception knows.
#[test]
fn a_map_of_a_past_that_is_no_longer_the_journals_is_built_anew() {
    let walked = World::new(contract::Profile::Paper2023);
    let elsewhere = World { turns_at: 10, ..World::new(contract::Profile::Paper2023) };
    for through in [8, 12, 19, 20, 21, 26] {
        let mut cartographer = following(&walked, 20);
        let later = NOW.plus_ns(1);
        catch_up(&mut cartographer, &elsewhere, State { published: later, ..elsewhere.state(through) });
        assert_eq!(cartographer.map().unwrap().through, Some(Decision(through)));
        assert_eq!(cartographer.map().unwrap().cells(), elsewhere.undisturbed(through).cells(), "{through}");
        // What was published before the journal changed comes late.
        assert_eq!(cartographer.on(Event::State(walked.state(20.min(through))), later), []);
        assert_eq!(cartographer.map().unwrap().cells(), elsewhere.undisturbed(through).cells(), "{through}");
    }
}

/// P-TIMELINE. The past was missing, so only the start is folded; then the journal turns out to be
/// empty.
#[test]
fn a_start_folded_for_a_later_state_gets_the_digest_of_its_own() {
    let world = World::new(contract::Profile::Paper2023);
    let mut cartographer = world.ready();
    assert_eq!(cartographer.on(Event::State(world.state(2)), NOW), [request(0)]);
    let start = State { digest: Digest([7; 32]), published: NOW.plus_ns(1), ..world.state(0) };
    assert_eq!(cartographer.on(Event::State(start), NOW.plus_ns(2)), [Effect::PublishMap]);
    let patches = cartographer.patches(NOW, &mut || NOW);
    assert_eq!(patches.iter().map(|patch| patch.digest).collect::<Vec<_>>(), [Digest([7; 32])]);
}

/// P-TIMELINE.
#[test]
fn a_late_page_of_a_past_that_is_gone_is_not_kept() {
    let walked = World::new(contract::Profile::Paper2023);
    let elsewhere = World { turns_at: 3, ..World::new(contract::Profile::Paper2023) };
    let mut cartographer = elsewhere.ready();
    let state = elsewhere.state(9);
    assert_eq!(cartographer.on(Event::State(state), NOW), [request(0)]);
    assert_eq!(cartographer.on(Event::Past(walked.page(0, 6)), NOW), [request(6)]);
    assert_eq!(cartographer.on(Event::Past(elsewhere.page(6, 3)), NOW), [], "it does not continue");
    let again = NOW.plus_ns(ASK_AGAIN_NS);
    assert_eq!(cartographer.on(Event::Tick, again), [request(5)], "the record before decides");
    assert_eq!(cartographer.on(Event::Past(elsewhere.page(5, 3)), again), [], "the map is of another past");
    assert_eq!(cartographer.on(Event::Tick, again), [request(0)]);
    catch_up(&mut cartographer, &elsewhere, state);
    assert_eq!(cartographer.map().unwrap().cells(), elsewhere.undisturbed(9).cells());
}

/// P-STAMPS-WIRE. Patch, reminder and page have the moments of the landing, each in a field of its
/// own on the wire.
#[test]
fn patches_reminders_and_pages_keep_the_moments_of_the_landing() {
    let world = World::new(contract::Profile::Hopper);
    let mut cartographer = world.ready();
    cartographer.on(Event::State(world.state(0)), NOW);
    let mut clock_ns = 500;
    let mut clock = || {
        clock_ns += 1;
        MonotonicNs(clock_ns)
    };
    let fresh = cartographer.patches(MonotonicNs(40), &mut clock);
    let again = cartographer.patches(MonotonicNs(90), &mut clock);
    assert!(again[0].cells.is_empty());
    for patch in fresh.iter().chain(&again) {
        assert_eq!((patch.sensed, patch.published), (MonotonicNs(40), MonotonicNs(501)));
        let wire = MapPatchV2::from(patch);
        assert_eq!((wire.sensed_ns, wire.published_ns), (40, 501));
        let read = patch_from_wire(&MapPatchV2 { ..wire }, &[]).unwrap();
        assert_eq!((read.sensed, read.published), (MonotonicNs(40), MonotonicNs(501)));
    }
    let request = MapRequest { run: RUN, robot: RobotId(0), from: 0, observation: 0 };
    let page = cartographer.page(&request).unwrap();
    assert_eq!((page.sensed, page.published), (MonotonicNs(40), MonotonicNs(501)));
    let wire = MapPageV2::from(&page);
    assert_eq!((wire.sensed_ns, wire.published_ns), (40, 501));
    let read = map_page_from_wire(&wire, &[]).unwrap();
    assert_eq!((read.sensed, read.published), (MonotonicNs(40), MonotonicNs(501)));
}
