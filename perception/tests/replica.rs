//! A reader's map is the cartographer's or none, whatever is lost on the way.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::cell::RefCell;
use std::sync::Arc;

use contract::limits::ASK_AGAIN_NS;
use contract::limits::{MAP_PAGE_CELLS, MAP_PATCH_CELLS, PATCHES_BUFFERED};
use contract::{
    Action, Branch, Brief, Cell, Collected, Decision, Digest, Flight, GradientSource, Grid, Ground, Leader,
    MapPage, MapPatch, MapRequest, MonotonicNs, ObservedMap, Outcome, PastPage, Pose, Record, RobotId, RunId,
    Sensor, SensorParameters, Soil, State, Status, Timing,
};
use follow::Replica;
use perception::{Cartographer, Effect, Event};
use terrain::Terrain;

const RUN: RunId = RunId(7);
const ROBOT: RobotId = RobotId(0);

fn at(ns: u64) -> MonotonicNs {
    MonotonicNs(ns)
}

/// What of a landing is in the digest chain; here the hopper goes where it is put.
fn held(cell: Cell) -> Outcome {
    Outcome { branch: Branch::Held, from: cell, to: cell, flight: Flight::default() }
}

/// Rough ground with a walk over it, and all that perception publishes about it.
struct Source {
    brief: Brief,
    terrain: Arc<Terrain>,
    cartographer: Cartographer,
    decision: u64,
    downwards: bool,
    /// When decision 0 is, nanoseconds.
    epoch: u64,
    /// The digest of each decision so far.
    digests: RefCell<Vec<Digest>>,
}

impl Source {
    fn new(side: u32, radius_m: f64) -> Self {
        let grid = Grid::new(side, side, 1.0, 1).unwrap();
        let rough = |index: usize| (index as f64 * 0.37).sin();
        let ground = |index: usize| Ground {
            height_m: rough(index),
            soil: if rough(3 * index) > 0.4 { Soil::Sand } else { Soil::Hard },
            ..Ground::FLAT
        };
        let treasures = vec![Cell::new(5, 3), Cell::new(8, 8), Cell::new(12, 15)];
        let cells = (0..grid.cells()).map(ground).collect();
        let terrain = Terrain { grid, cells, treasures, prior: Vec::new() };
        let brief = scenario::load("hard").unwrap().resolve().unwrap().brief;
        let sensor = SensorParameters {
            gain: 0.0,
            offset_m: 0.0,
            radius_min_m: radius_m,
            radius_max_m: radius_m,
            gradient: GradientSource::SeenDifferences,
        };
        let mut brief = Brief { run: RUN, grid, ..brief };
        (brief.robots[0].sensor, brief.robots[0].start.cell) = (Sensor::Disc(sensor), Cell::new(1, 1));
        let mut source = Self {
            brief,
            terrain: terrain.into(),
            cartographer: Cartographer::new(ROBOT),
            decision: 0,
            downwards: false,
            epoch: 0,
            digests: RefCell::default(),
        };
        source.begin();
        source
    }

    fn begin(&mut self) {
        self.digests.borrow_mut().clear();
        self.cartographer = Cartographer::new(ROBOT);
        self.cartographer.on(Event::Terrain(RUN, self.terrain.clone()), at(0));
        self.cartographer.on(Event::Brief(self.brief.clone()), at(0));
    }

    fn state(&self, decision: u64) -> State {
        // Diagonally there and back, without leaving the map.
        let side = self.brief.grid.width as u64 - 2;
        let along = (decision % (2 * side)).min(2 * side - decision % (2 * side)) as i32;
        let up = along.min(side as i32 - 1);
        let along = if self.downwards { side as i32 - 1 - up } else { up };
        let cell = Cell::new(1 + along, 1 + along);
        let mut state = State {
            run: RUN,
            robot: ROBOT,
            decision: Decision(decision),
            steps: 2 * decision,
            status: Status::Underway,
            leader: Leader::default(),
            collected: Collected::default(),
            pose: Pose { cell, height_m: self.terrain.ground(cell).unwrap().height_m },
            last: Some(held(cell)),
            previous: Digest::default(),
            digest: Digest::default(),
            landed: at(self.epoch + decision),
            published: at(self.epoch + decision),
            visits: 0,
            vetoed: contract::Vetoed::NONE,
            last_origin: contract::Origin::Planner,
            last_vetoed: contract::Vetoed::NONE,
            last_timing: Timing::default(),
        };
        let mut digests = self.digests.borrow_mut();
        for known in digests.len() as u64..=decision {
            let mut digest = Digest::default();
            digest.0[..8].copy_from_slice(&known.to_le_bytes());
            digest.0[8..12].copy_from_slice(&cell.x.to_le_bytes());
            digests.push(digest);
        }
        state.digest = digests[decision as usize];
        state.previous = decision.checked_sub(1).map_or(Digest::default(), |before| digests[before as usize]);
        state
    }

    /// The next landing's patches.
    fn land(&mut self) -> Vec<MapPatch> {
        let now = at(self.epoch + self.decision);
        let effects = self.cartographer.on(Event::State(self.state(self.decision)), now);
        assert!(effects.contains(&Effect::PublishMap), "{effects:?} at {}", self.decision);
        self.decision += 1;
        self.publish()
    }

    fn publish(&mut self) -> Vec<MapPatch> {
        let now = at(self.epoch + self.decision);
        self.cartographer.patches(now, &mut || now)
    }

    /// Perception dies and rebuilds its map from the past, in pages of `records`; what it publishes then.
    fn restart(&mut self, records: usize) -> Vec<MapPatch> {
        self.begin();
        let last = self.decision - 1;
        let mut effects = self.cartographer.on(Event::State(self.state(last)), at(0));
        let mut pages = 0;
        while let [Effect::RequestPast(request)] = effects[..] {
            let from = request.from.0;
            let until = last.min(from + records as u64);
            let records = (from..until).map(|decision| self.record(decision)).collect();
            let page = PastPage { run: RUN, robot: ROBOT, from: request.from, records };
            effects = self.cartographer.on(Event::Past(page), at(0));
            pages += 1;
        }
        assert_eq!(effects, [Effect::PublishMap], "rebuilt from {pages} pages through {last}");
        assert_eq!(
            pages,
            last.saturating_sub(1).div_ceil(records as u64),
            "the last pose comes with the state"
        );
        self.publish()
    }

    /// What the journal holds of a decision: it leads to the pose of the next.
    fn record(&self, decision: u64) -> Record {
        let (before, after) = (self.state(decision), self.state(decision + 1));
        let (from, to) = (before.pose.cell, after.pose);
        Record {
            robot: ROBOT,
            decision: Decision(decision),
            leader: Leader::default(),
            action: Action::Hold,
            origin: contract::Origin::Planner,
            vetoed: contract::Vetoed::NONE,
            visits: 0,
            observation: 0,
            work: 0,
            cut: false,
            outcome: Outcome { branch: Branch::Intended, from, to: to.cell, flight: Flight::default() },
            pose: to,
            detail: contract::DetailId::NONE,
            collected: Collected::default(),
            steps: 2 * (decision + 1),
            status: Status::Underway,
            timing: Timing::default(),
            previous: before.digest,
            digest: after.digest,
        }
    }

    fn map(&self) -> &ObservedMap {
        self.cartographer.map().unwrap()
    }
}

fn reader(source: &Source) -> Replica {
    let mut replica = Replica::new(ROBOT);
    replica.begin(&source.brief);
    replica
}

/// Lets the replica ask and the source answer until nothing is asked for; gives the pages.
fn catch_up(replica: &mut Replica, source: &Source, now: MonotonicNs) -> usize {
    let mut pages = 0;
    let mut request = replica.ask(now);
    while let Some(asked) = request {
        pages += 1;
        assert!(pages < 1000, "catching up has no end");
        request = replica.page(&source.cartographer.page(&asked).unwrap(), now);
    }
    pages
}

fn assert_whole(replica: &Replica, source: &Source) {
    assert_eq!(replica.map().expect("the map is whole"), source.map());
}

/// P-PATCHES: A reader that gets every patch holds perception's map, and never asks for a page.
#[test]
fn patches_add_up_to_the_map() {
    for radius_m in [1.0, 6.5, 40.0] {
        let mut source = Source::new(60, radius_m);
        let mut replica = reader(&source);
        let mut sequence = 0;
        for decision in 0..80 {
            let patches = source.land();
            for patch in patches {
                sequence += 1;
                assert_eq!(patch.sequence, sequence);
                assert!(patch.cells.len() <= MAP_PATCH_CELLS);
                let last = patch.more == 0;
                assert_eq!(replica.patch(patch, at(decision)), None);
                let through = replica.map().unwrap().through;
                assert_eq!(through, last.then_some(Decision(decision)), "a part of a landing covers nothing");
            }
            assert_whole(&replica, &source);
        }
        assert_eq!(replica.refusals().0.len(), 0);
        assert_eq!(replica.map().unwrap().observation(), source.map().observation());
    }
}

#[test]
fn a_large_landing_is_split_into_bounded_patches() {
    let mut source = Source::new(60, 40.0);
    let patches = source.land();
    assert!(patches.len() > 1);
    let more: Vec<u32> = patches.iter().map(|patch| patch.more).collect();
    assert_eq!(more, (0..patches.len() as u32).rev().collect::<Vec<_>>());
    assert!(patches.windows(2).all(|pair| pair[0].after == pair[1].before));
    assert_eq!(patches.last().unwrap().seen_cells as usize, source.map().seen_cells());
}

#[test]
fn a_landing_that_reveals_nothing_is_an_empty_patch() {
    let mut source = Source::new(20, 30.0);
    source.land();
    let patches = source.land();
    assert_eq!((patches.len(), patches[0].cells.len()), (1, 0));
    assert_eq!((patches[0].before, patches[0].through), (patches[0].after, Decision(1)));
}

/// P-MISSED: A reader that misses any patch notices, catches up in place, and knows what changed.
#[test]
fn a_reader_that_misses_a_patch_catches_up() {
    for missed in 0..12 {
        let mut source = Source::new(80, 6.0);
        let mut replica = reader(&source);
        let mut before = None;
        for decision in 0..12_u64 {
            let patches = source.land();
            if decision == missed {
                before = replica.map().map(|map| (map.observation(), map.cells().to_vec()));
                continue;
            }
            for patch in patches {
                if let Some(request) = replica.patch(patch, at(decision * ASK_AGAIN_NS)) {
                    assert_eq!(decision, missed + 1, "the gap is noticed at the next patch");
                    assert!(replica.map().is_none(), "nobody decides on a map with a gap");
                    let page = source.cartographer.page(&request).unwrap();
                    assert_eq!(replica.page(&page, at(1)), None);
                }
            }
            if decision > missed {
                assert_whole(&replica, &source);
            }
        }
        if missed < 11
            && let Some((observation, cells)) = before
        {
            let map = replica.map().unwrap();
            let changed = map.changed_since(observation).expect("it was caught up with in place");
            let differ = (0..cells.len()).filter(|&index| cells[index] != map.cells()[index]);
            assert!(differ.clone().count() > 0);
            differ.for_each(|index| assert!(changed.contains(&(index as u32))));
        }
    }
}

/// P-LATE: A reader that starts late gets the map in bounded pages while it grows.
#[test]
fn a_late_comer_catches_up_while_the_map_grows() {
    let mut source = Source::new(300, 45.0);
    for _ in 0..150 {
        source.land();
    }
    let mut replica = reader(&source);
    let mut pages = 0;
    let mut request = replica.ask(at(0));
    while let Some(asked) = request {
        assert!(replica.map().is_none(), "part of a map is none");
        // The page is made, then the hopper lands before it is read; the patches are read first.
        let page = source.cartographer.page(&asked).unwrap();
        assert!(page.cells.len() <= MAP_PAGE_CELLS);
        for patch in source.land() {
            replica.patch(patch, at(0));
        }
        request = replica.page(&page, at(0));
        pages += 1;
        assert!(pages < 100);
    }
    assert!(pages > 5, "{pages} pages");
    assert_whole(&replica, &source);
    assert_eq!(replica.refusals().0.len(), 0);
    for patch in source.land() {
        assert_eq!(replica.patch(patch, at(0)), None, "the chain goes on");
    }
    assert_whole(&replica, &source);
}

#[test]
fn patches_that_were_read_before_the_snapshot_are_dropped_and_later_ones_kept() {
    let mut source = Source::new(80, 6.0);
    let mut replica = reader(&source);
    let mut buffered: Vec<MapPatch> = (0..6).flat_map(|_| source.land()).collect();
    let asked = replica.ask(at(0)).unwrap();
    let page = source.cartographer.page(&asked).unwrap();
    buffered.extend((0..3).flat_map(|_| source.land()));
    // The first is lost, so that the others wait in the buffer.
    for patch in buffered.drain(1..) {
        replica.patch(patch, at(1));
    }
    assert_eq!(replica.page(&page, at(2)), None);
    assert_whole(&replica, &source);
}

#[test]
fn a_patch_lost_between_two_pages_is_noticed_and_the_snapshot_begins_anew() {
    // It walks towards the lower rows, which come first in a snapshot.
    let mut source = Source::new(300, 45.0);
    source.downwards = true;
    source.brief.robots[0].start.cell = source.state(0).pose.cell;
    source.begin();
    for _ in 0..150 {
        source.land();
    }
    let mut replica = reader(&source);
    let mut request = replica.ask(at(0));
    let mut lost = false;
    while let Some(asked) = request {
        if !lost && asked.from > 0 {
            let patches = source.land();
            assert!(patches[0].cells[0].index < asked.from, "a row that is told of already");
            lost = true;
        }
        let page = source.cartographer.page(&asked).unwrap();
        request = replica.page(&page, at(0));
    }
    assert!(lost && replica.map().is_none());
    assert_eq!(replica.refusals().of("malformed"), 1, "{:?}", replica.refusals());
    assert!(catch_up(&mut replica, &source, at(ASK_AGAIN_NS)) > 3);
    assert_whole(&replica, &source);
}

/// P-SENSE-KILL: A perception that is killed at any moment continues with the same stream of
/// patches.
#[test]
fn a_restarted_perception_goes_on_with_the_same_stream() {
    for heard in 0..2 {
        let mut source = Source::new(60, 40.0);
        let mut replica = reader(&source);
        let patches = source.land();
        assert!(patches.len() > heard);
        for patch in patches.into_iter().take(heard) {
            assert_eq!(replica.patch(patch, at(0)), None);
        }
        assert_eq!(replica.map().and_then(|map| map.through), None);
        let again = source.restart(3);
        let mut now = 0;
        for patch in again {
            now += ASK_AGAIN_NS;
            if let Some(request) = replica.patch(patch, at(now)) {
                replica.page(&source.cartographer.page(&request).unwrap(), at(now));
            }
        }
        catch_up(&mut replica, &source, at(now + ASK_AGAIN_NS));
        assert_whole(&replica, &source);
        for patch in source.land() {
            assert_eq!(replica.patch(patch, at(now)), None);
        }
        assert_whole(&replica, &source);
    }
    // A reader that is up to date needs no cell again.
    let mut source = Source::new(60, 6.0);
    let mut replica = reader(&source);
    let mut old = None;
    for _ in 0..9 {
        for patch in source.land() {
            old.get_or_insert(patch.clone());
            replica.patch(patch, at(0));
        }
    }
    for records in [1, 3, 64] {
        for patch in source.restart(records) {
            assert_eq!(replica.patch(patch, at(1)), None, "the last landing once more is no news");
        }
        assert_whole(&replica, &source);
    }
    let request = replica.patch(old.unwrap(), at(1)).expect("an old patch is asked about");
    let page = source.cartographer.page(&request).unwrap();
    assert_eq!(page.cells, []);
    replica.page(&page, at(1));
    assert_whole(&replica, &source);
}

#[test]
fn a_reminder_tells_whoever_missed_the_last_patch_and_nobody_else() {
    let mut source = Source::new(60, 6.0);
    let (mut keeps_up, mut misses) = (reader(&source), reader(&source));
    for decision in 0..5 {
        for patch in source.land() {
            keeps_up.patch(patch.clone(), at(0));
            if decision < 4 {
                misses.patch(patch, at(0));
            }
        }
    }
    let reminder = source.publish();
    assert_eq!((reminder.len(), reminder[0].cells.len()), (1, 0));
    assert_eq!(keeps_up.patch(reminder[0].clone(), at(0)), None);
    assert_whole(&keeps_up, &source);
    let request = misses.patch(reminder[0].clone(), at(0)).unwrap();
    misses.page(&source.cartographer.page(&request).unwrap(), at(0));
    assert_whole(&misses, &source);
}

#[test]
fn a_journal_that_lost_its_tail_takes_the_map_back() {
    let mut source = Source::new(60, 6.0);
    let mut replica = reader(&source);
    for _ in 0..9 {
        for patch in source.land() {
            replica.patch(patch, at(0));
        }
    }
    source.begin();
    source.decision = 0;
    let patches: Vec<MapPatch> = (0..4).flat_map(|_| source.land()).collect();
    let mut now = 0;
    for patch in patches {
        now += ASK_AGAIN_NS;
        replica.patch(patch, at(now));
    }
    // Its cells cannot be unlearnt in place: the second attempt begins from an empty map.
    for _ in 0..2 {
        now += ASK_AGAIN_NS;
        catch_up(&mut replica, &source, at(now));
    }
    assert_whole(&replica, &source);
}

#[test]
fn patches_in_the_wrong_order_are_set_right_without_a_page_unless_one_is_missing() {
    let mut source = Source::new(60, 6.0);
    let mut replica = reader(&source);
    let patches: Vec<MapPatch> = (0..9).flat_map(|_| source.land()).collect();
    let mut hear = |numbers: &[u64]| {
        for &number in numbers {
            replica.patch(patches[number as usize - 1].clone(), at(0));
        }
        replica.map().map(|map| map.sequence)
    };
    assert_eq!(hear(&[1, 2, 3]), Some(3));
    assert_eq!(hear(&[5]), None);
    assert_eq!(hear(&[4]), Some(5), "the fifth is not lost");
    assert_eq!(hear(&[9, 7, 6]), None, "the ninth shows that the eighth is missing");
    assert_eq!(hear(&[8]), Some(9));
    assert_eq!(replica.refusals().0.len(), 0);
    assert_whole(&replica, &source);
}

#[test]
fn patches_of_a_tail_that_the_journal_has_lost_stand_in_no_ones_way() {
    let mut source = Source::new(300, 45.0);
    for _ in 0..60 {
        source.land();
    }
    let mut replica = reader(&source);
    // It has just come, asks, and hears of hops that are then lost, before it is answered.
    let mut request = replica.ask(at(0));
    let lost: Vec<MapPatch> = (0..20).flat_map(|_| source.land()).collect();
    for patch in &lost {
        replica.patch(patch.clone(), at(0));
    }
    source.downwards = true;
    source.brief.robots[0].start.cell = source.state(0).pose.cell;
    (source.epoch, source.decision) = (1000, 0);
    source.begin();
    while source.cartographer.map().is_none_or(|map| map.sequence < lost[0].sequence) {
        source.land();
    }
    assert!(source.map().cells()[lost[1].cells[0].index as usize].is_none(), "they led elsewhere");
    // While it catches up, the numbers of what was lost come round again.
    let mut pages = 0;
    while let Some(asked) = request {
        let page = source.cartographer.page(&asked).unwrap();
        for patch in source.land() {
            replica.patch(patch, at(0));
        }
        request = replica.page(&page, at(0));
        pages += 1;
    }
    assert!(pages > 2, "{pages} pages");
    assert_eq!(replica.refusals().0.len(), 0, "the first attempt succeeds");
    assert_whole(&replica, &source);
}

#[test]
fn a_request_is_repeated_until_it_is_answered_and_no_earlier() {
    let source = Source::new(20, 3.0);
    let mut replica = reader(&source);
    let request = MapRequest { run: RUN, robot: ROBOT, from: 0, observation: 0 };
    assert_eq!(replica.ask(at(5)), Some(request));
    assert_eq!(replica.ask(at(4 + ASK_AGAIN_NS)), None);
    assert_eq!(replica.ask(at(5 + ASK_AGAIN_NS)), Some(request));
    assert_eq!(source.cartographer.page(&request), None, "before the first landing there is no answer");
}

/// P-FORGED: Patches of another map than they claim, or of another run, robot or lattice, are
/// refused and counted, and change nothing. Pages that do not add up are counted, and their map is
/// shown to no reader.
// Long: a list of cases, each with what it must be refused as.
#[test]
fn what_does_not_add_up_is_refused_counted_and_changes_nothing() {
    let mut source = Source::new(60, 6.0);
    let mut replica = reader(&source);
    for _ in 0..5 {
        for patch in source.land() {
            replica.patch(patch, at(0));
        }
    }
    let whole = replica.map().unwrap().clone();
    let honest = source.land().remove(0);
    let twist = |twist: &dyn Fn(&mut MapPatch)| {
        let mut patch = honest.clone();
        twist(&mut patch);
        patch
    };
    let mut now = 0;
    for (what, patch, counted) in [
        ("another run", twist(&|patch| patch.run = RunId(8)), [1, 0]),
        ("another robot", twist(&|patch| patch.robot = RobotId(3)), [1, 1]),
        ("another lattice", twist(&|patch| patch.grid.width = 61), [1, 2]),
    ] {
        assert_eq!(replica.patch(patch, at(now)), None, "{what} is none of ours");
        assert_eq!(replica.map(), Some(&whole), "{what}");
        assert_eq!(["wrong_run", "malformed"].map(|reason| replica.refusals().of(reason)), counted, "{what}");
    }
    for (what, patch) in [
        ("a cell too many", twist(&|patch| patch.cells.push(patch.cells[0]))),
        ("a cell too few", twist(&|patch| patch.cells.truncate(patch.cells.len() - 1))),
        ("another height", twist(&|patch| patch.cells[3].ground.height_m = 1e6)),
        (
            "a treasure in the dark",
            twist(&|patch| {
                let (before, dark) = (patch.treasures.clone(), Cell::new(59, 0));
                patch.treasures = vec![dark];
                patch.after = patch.after.wrapping_add(ObservedMap::treasures_step(&before, &[dark]));
            }),
        ),
        ("another end", twist(&|patch| patch.after ^= 1)),
        ("another beginning", twist(&|patch| patch.before ^= 1)),
        ("a sequence of old", twist(&|patch| patch.sequence = 0)),
        ("a sequence to come", twist(&|patch| patch.sequence = 1 << 40)),
        ("a moment at the end of time", twist(&|patch| (patch.published, patch.before) = (at(u64::MAX), 0))),
        (
            "a reminder of another map",
            twist(&|patch| {
                patch.cells.clear();
                (patch.before, patch.after) = (3, 3);
            }),
        ),
    ] {
        now += ASK_AGAIN_NS;
        let refused = replica.refusals().of("malformed");
        let request = replica.patch(patch, at(now)).unwrap_or_else(|| panic!("{what} is asked about"));
        assert!(replica.map().is_none(), "{what}: nobody decides before that is cleared up");
        assert_eq!(request.observation, whole.observation(), "{what} changed nothing");
        assert_eq!(
            replica.refusals().of("malformed"),
            refused
                + u64::from(
                    what.starts_with("a cell")
                        || what.ends_with("dark")
                        || what.ends_with("height")
                        || what == "another end"
                ),
            "{what}"
        );
        // Perception, whose landing the replica still misses, sets it right.
        let page = source.cartographer.page(&request).unwrap();
        assert_eq!(replica.page(&page, at(now)), None, "{what}");
        assert_whole(&replica, &source);
        // Back to before the landing, for the next one.
        replica = reader(&source);
        let page = MapPage {
            run: RUN,
            robot: ROBOT,
            through: whole.through.unwrap(),
            digest: whole.digest,
            sequence: whole.sequence,
            observation: whole.observation(),
            sensed: whole.sensed,
            published: whole.published,
            grid: whole.grid,
            from: 0,
            next: whole.grid.cells() as u32,
            treasures: whole.treasures().to_vec(),
            cells: source_cells(&whole),
        };
        replica.ask(at(now));
        assert_eq!(replica.page(&page, at(now)), None);
        assert_eq!(replica.map(), Some(&whole));
    }
    for (what, page, reason) in forged_pages(&source) {
        let mut replica = reader(&source);
        replica.ask(at(0)).unwrap();
        replica.page(&page, at(0));
        assert!(replica.map().is_none(), "{what}");
        let counted = replica.refusals().0.values().sum::<u64>();
        assert_eq!(counted, u64::from(reason.is_some()), "{what}");
        assert!(reason.is_none_or(|reason| replica.refusals().of(reason) == 1), "{what}");
        for round in 1..4 {
            catch_up(&mut replica, &source, at(round * ASK_AGAIN_NS));
        }
        assert_whole(&replica, &source);
    }
    // A flood that never fits stays within its bounds, and the honest stream goes on.
    for sequence in 0..10 * PATCHES_BUFFERED as u64 {
        replica.patch(twist(&|patch| (patch.before, patch.sequence) = (sequence, 100 + sequence)), at(now));
    }
    now += ASK_AGAIN_NS;
    catch_up(&mut replica, &source, at(now));
    assert_whole(&replica, &source);
}

fn source_cells(map: &ObservedMap) -> Vec<contract::SeenCell> {
    let seen = |(index, ground): (usize, &Option<Ground>)| {
        ground.map(|ground| contract::SeenCell { index: index as u32, visits: 0, ground })
    };
    map.cells().iter().enumerate().filter_map(seen).collect()
}

/// Pages that tell another map than they say, or no end, with the reason under which each is counted. An
/// answer to another request is none: it was given up.
fn forged_pages(source: &Source) -> Vec<(&'static str, MapPage, Option<&'static str>)> {
    let request = MapRequest { run: RUN, robot: ROBOT, from: 0, observation: 0 };
    let honest = source.cartographer.page(&request).unwrap();
    let mut other_height = honest.clone();
    other_height.cells[0].ground.height_m += 1.0;
    let mut no_progress = MapPage { next: 0, ..honest.clone() };
    no_progress.cells.clear();
    vec![
        ("another height", other_height, Some("malformed")),
        ("no progress", no_progress, Some("malformed")),
        (
            "another fingerprint",
            MapPage { observation: honest.observation ^ 1, ..honest.clone() },
            Some("malformed"),
        ),
        ("a foreign run", MapPage { run: RunId(8), ..honest.clone() }, Some("wrong_run")),
        ("a foreign robot", MapPage { robot: RobotId(1), ..honest.clone() }, Some("malformed")),
        ("another stretch", MapPage { from: 7, ..honest }, None),
    ]
}

#[test]
fn the_brief_told_again_changes_nothing_and_another_one_begins_an_empty_map() {
    let mut source = Source::new(12, 3.0);
    let mut replica = reader(&source);
    source.land().into_iter().for_each(|patch| assert_eq!(replica.patch(patch, at(0)), None));
    replica.begin(&source.brief);
    assert_whole(&replica, &source);
    let others = [
        Brief { run: RunId(8), ..source.brief.clone() },
        Brief { grid: Grid::new(11, 12, 1.0, 1).unwrap(), ..source.brief },
    ];
    for other in others {
        let mut replica = replica.clone();
        replica.begin(&other);
        assert!(replica.map().is_none());
        let asked = replica.ask(at(0)).unwrap();
        assert_eq!((asked.run, asked.from, asked.observation), (other.run, 0, 0));
    }
}

#[test]
fn a_map_begun_anew_is_asked_for_from_the_first_cell() {
    let mut source = Source::new(12, 3.0);
    let mut replica = reader(&source);
    source.land().into_iter().for_each(|patch| assert_eq!(replica.patch(patch, at(0)), None));
    replica.begin_anew();
    assert!(replica.map().is_none());
    let asked = replica.ask(at(0)).unwrap();
    assert_eq!((asked.from, asked.observation), (0, 0));
    replica.page(&source.cartographer.page(&asked).unwrap(), at(0));
    assert_whole(&replica, &source);
}

#[test]
fn what_a_reader_refuses_is_counted() {
    let mut replica = reader(&Source::new(12, 3.0));
    replica.refuse(&contract::Refusal::malformed("map.grid", "another", "none"));
    assert_eq!(replica.refusals().of("malformed"), 1);
}

#[test]
fn as_many_patches_are_kept_for_a_missing_one_as_the_limit_says() {
    let mut source = Source::new(60, 2.0);
    let patches: Vec<MapPatch> = (0..PATCHES_BUFFERED + 3).flat_map(|_| source.land()).collect();
    for (kept, is_whole) in [(PATCHES_BUFFERED, true), (PATCHES_BUFFERED + 1, false)] {
        let mut replica = reader(&source);
        replica.patch(patches[0].clone(), at(0));
        patches[2..2 + kept].iter().for_each(|patch| _ = replica.patch(patch.clone(), at(0)));
        replica.patch(patches[1].clone(), at(0));
        assert_eq!(replica.map().is_some(), is_whole, "{kept} were kept");
    }
}

/// The patch that says nothing but that the map is still that of `patch`.
fn reminder(patch: &MapPatch, published: u64) -> MapPatch {
    let (after, cells) = (patch.after, Vec::new());
    MapPatch { before: after, after, cells, published: at(published), ..patch.clone() }
}

#[test]
fn a_reminder_does_not_drop_the_patch_that_it_reminds_of() {
    let mut source = Source::new(12, 3.0);
    let patches: Vec<MapPatch> = (0..3).flat_map(|_| source.land()).collect();
    let mut replica = reader(&source);
    replica.patch(patches[0].clone(), at(0));
    replica.patch(patches[2].clone(), at(0));
    replica.patch(reminder(&patches[2], 1_000), at(0));
    replica.patch(patches[1].clone(), at(0));
    assert_eq!(replica.map().map(ObservedMap::observation), Some(source.map().observation()));
}

#[test]
fn patches_of_lost_hops_are_dropped_by_a_later_one_with_a_lower_number() {
    let mut source = Source::new(12, 3.0);
    let patches: Vec<MapPatch> = (0..4).flat_map(|_| source.land()).collect();
    let mut replica = reader(&source);
    replica.patch(patches[0].clone(), at(0));
    replica.patch(patches[2].clone(), at(0));
    replica.patch(patches[3].clone(), at(0));
    // The journal has lost its tail, and the hop after that reveals nothing.
    let anew = MapPatch { sequence: patches[1].sequence, ..reminder(&patches[0], 1_000) };
    replica.patch(anew, at(0));
    assert!(replica.map().is_some(), "what was kept stands in nobody's way");
}

#[test]
fn a_patch_with_the_number_of_the_last_one_that_changes_treasures_alone_is_not_taken_for_a_reminder() {
    let mut source = Source::new(12, 8.0);
    let last = source.land().pop().unwrap();
    let mut replica = reader(&source);
    replica.patch(last.clone(), at(0));
    assert_whole(&replica, &source);
    let step = ObservedMap::treasures_step(&last.treasures, &[]);
    let other =
        MapPatch { treasures: Vec::new(), after: last.after.wrapping_add(step), ..reminder(&last, 1) };
    assert_ne!(other.after, other.before, "there is a treasure in view");
    replica.patch(other, at(0));
    assert!(replica.map().is_none());
}
