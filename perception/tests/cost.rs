//! What a landing costs, from the sensor to the planner's door.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell as Counter;

use contract::{
    Branch, Brief, Cell, Collected, Decision, Digest, Flight, GradientSource, Grid, Ground, Leader,
    MonotonicNs, Outcome, Pose, RobotId, RunId, Sensor, SensorParameters, State, Status, Timing,
};
use follow::Replica;
use perception::{Cartographer, Effect, Event};
use terrain::Terrain;

const RUN: RunId = RunId(7);
const ROBOT: RobotId = RobotId(0);
const NOW: MonotonicNs = MonotonicNs(1);

/// The system's allocator, counting bytes for each thread: the test harness allocates on one of its own.
struct Counting;

thread_local! {
    static BYTES: Counter<u64> = const { Counter::new(0) };
}

// SAFETY: every call is handed on to the system's allocator as it came.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // A thread that is ending has no count any more.
        let _ = BYTES.try_with(|bytes| bytes.set(bytes.get() + layout.size() as u64));
        // SAFETY: as above.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// What of a landing is in the digest chain; here the hopper goes where it is put.
fn held(cell: Cell) -> Outcome {
    Outcome { branch: Branch::Held, from: cell, to: cell, flight: Flight::default() }
}

/// Bytes allocated and cells changed by each of some landings along the same hops, on a map of `side` x `side`.
fn landings(side: u32) -> Vec<[u64; 2]> {
    let grid = Grid::new(side, side, 1.0, 1).unwrap();
    let ground = |cell: Cell| Ground { height_m: (f64::from(cell.x * 7 + cell.y)).sin(), ..Ground::FLAT };
    let cells = grid.iter().map(ground).collect();
    let terrain = Terrain { grid, cells, treasures: Vec::new(), prior: Vec::new() };
    let brief = scenario::load("hard").unwrap().resolve().unwrap().brief;
    let gradient = GradientSource::SeenDifferences;
    let sensor =
        SensorParameters { gain: 0.0, offset_m: 0.0, radius_min_m: 12.0, radius_max_m: 12.0, gradient };
    let mut brief = Brief { run: RUN, grid, ..brief };
    (brief.robots[0].sensor, brief.robots[0].start.cell) = (Sensor::Disc(sensor), Cell::new(20, 20));
    let mut cartographer = Cartographer::new(ROBOT);
    cartographer.on(Event::Brief(brief.clone()), NOW);
    cartographer.on(Event::Terrain(RUN, terrain.clone().into()), NOW);
    let mut replica = Replica::new(ROBOT);
    replica.begin(&brief);
    let mut costs = Vec::new();
    let mut previous = Digest::default();
    for decision in 0..24 {
        let cell = Cell::new(20 + decision as i32, 20);
        let state = State {
            run: RUN,
            robot: ROBOT,
            decision: Decision(decision),
            steps: 2 * decision,
            status: Status::Underway,
            leader: Leader::default(),
            pose: Pose { cell, height_m: terrain.ground(cell).unwrap().height_m },
            collected: Collected::default(),
            last: Some(held(cell)),
            previous,
            digest: Digest([decision as u8; 32]),
            landed: NOW,
            published: NOW,
            visits: 0,
            vetoed: contract::Vetoed::NONE,
            last_origin: contract::Origin::Planner,
            last_vetoed: contract::Vetoed::NONE,
            last_timing: Timing::default(),
        };
        previous = state.digest;
        let before = BYTES.get();
        let known = replica.map().map(|map| map.observation());
        assert_eq!(cartographer.on(Event::State(state), NOW), [Effect::PublishMap]);
        for patch in cartographer.patches(NOW, &mut || NOW) {
            assert_eq!(replica.patch(patch, NOW), None);
        }
        let map = replica.map().unwrap();
        let changed = known.map_or(0, |known| map.changed_since(known).unwrap().len());
        costs.push([BYTES.get() - before, changed as u64]);
    }
    assert_eq!(replica.map().unwrap(), cartographer.map().unwrap());
    costs
}

/// P-LANDING-COST: A landing allocates and changes only what it reveals, whatever the size of the
/// map: in sensing, patching and folding.
#[test]
fn a_landing_costs_what_it_reveals_whatever_the_size_of_the_map() {
    let [small, large] = [60, 821].map(landings);
    assert_eq!(small, large, "bytes and cells of each landing");
    let map_bytes = 821 * 821 * size_of::<Option<Ground>>() as u64;
    assert!(large.iter().all(|[bytes, _]| (1..map_bytes / 50).contains(bytes)), "{large:?}");
    assert!(large[1..].iter().all(|[_, cells]| (1..200).contains(cells)), "{large:?}");
}
