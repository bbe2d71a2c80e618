//! What has not been seen changes no decision: two truths that agree on everything observed so far give
//! the same commands so far.

use std::collections::BTreeSet;
use std::sync::Arc;

use contract::limits::{MAP_PATCH_CELLS, TREASURES_MAX};
use contract::{Action, Brief, MonotonicNs, Name, Pose, Profile, Record, RunId, Soil, Vetoed};
use hopper_sim::{Mission, ROBOT};
use lockstep::PlannerSchedule;
use perception::Observation;
use scenario::Scenario;
use simulation::chance::Chance;
use simulation::setup::Missions;

fn fly(mission: &Mission, planner: &str) -> Vec<Record> {
    let mut records = Vec::new();
    let planner: Name = planner.parse().unwrap();
    lockstep::fly(
        mission.clone(),
        &PlannerSchedule::single(planner),
        &mut || MonotonicNs(0),
        &mut |record| {
            records.push(*record);
        },
    )
    .unwrap();
    records
}

/// The same mission on ground that differs wherever nothing was seen through decision `through`.
fn elsewhere(mission: &Mission, records: &[Record], through: usize, chance: &mut Chance) -> Mission {
    let Mission { brief, terrain, .. } = mission;
    let mut seen = Observation::unseen(brief, ROBOT);
    let start = pose_at_start(brief, terrain);
    let poses = std::iter::once(start).chain(records.iter().map(|record| record.pose));
    for (decision, pose) in (0..).zip(poses.take(through + 1)) {
        seen.fold(brief, terrain, pose, contract::Decision(decision));
    }
    let mut other = mission.clone();
    for (ground, seen) in Arc::make_mut(&mut other.terrain).cells.iter_mut().zip(seen.map().cells()) {
        if seen.is_none() {
            ground.height_m = 20.0 * chance.unit() - 10.0;
            ground.gradient = [chance.unit() - 0.5, chance.unit() - 0.5];
            ground.soil = chance.pick(&[Soil::Hard, Soil::Sand]);
            ground.passable = chance.one_in(2);
        }
    }
    // Of the treasures, those seen stay, and others lie where nothing was seen.
    let hidden = |cell| seen.map().ground(cell).is_none();
    let treasures = &mut Arc::make_mut(&mut other.terrain).treasures;
    treasures.retain(|cell| !hidden(*cell));
    treasures.extend(terrain.grid.iter().filter(|cell| hidden(*cell) && chance.one_in(6)));
    treasures.truncate(TREASURES_MAX);
    treasures.sort_by_key(|cell| terrain.grid.index(*cell));
    other
}

/// What was decided, what the guard had vetoed, on what, with how much work.
fn decided(record: &Record) -> (Action, Vetoed, u64, u64) {
    (record.action, record.vetoed, record.observation, record.work)
}

/// Pairs of truths flown with a planner.
#[derive(Debug, Default)]
struct Pairs {
    flown: u64,
    /// In how many the missions differ at all.
    differ: u64,
    /// In how many they differ by what was decided before the difference could be seen.
    leaked: u64,
    /// In how many treasures lie elsewhere.
    treasures: u64,
    profiles: BTreeSet<Profile>,
}

impl Pairs {
    /// Flies `mission` with `planner`, and it thrice on ground that differs where nothing was seen.
    fn fly(&mut self, mission: &Mission, planner: &str, chance: &mut Chance) {
        let records = fly(mission, planner);
        for _ in 0..3 {
            let through = chance.below(records.len() as u64) as usize;
            let other = elsewhere(mission, &records, through, chance);
            let others = fly(&other, planner);
            // The commands of decisions 0 to `through`, and all that became of those before it.
            let commands =
                |records: &[Record]| records.iter().map(decided).take(through + 1).collect::<Vec<_>>();
            let same = commands(&records) == commands(&others);
            // Not the digests: what is collected is numbered over all treasures, the unseen among them.
            let poses = |records: &[Record]| -> Vec<Pose> {
                records.iter().map(|record| record.pose).take(through).collect()
            };
            self.flown += 1;
            self.leaked += u64::from(!same || poses(&records) != poses(&others));
            self.differ += u64::from(records.last().unwrap().digest != others.last().unwrap().digest);
            self.treasures += u64::from(mission.terrain.treasures != other.terrain.treasures);
            self.profiles.insert(mission.brief.profile);
        }
    }

    /// Over the small worlds of the simulation.
    fn small(planner: &str, worlds: u64) -> Self {
        let mut pairs = Self::default();
        for seed in 0..worlds {
            // By the law: physics depends on the ground around a body, seen or not.
            let mission = Mission { dynamics: Default::default(), ..Missions::Hopper.mission(seed, 0) };
            // The clairvoyant plans for one goal.
            if mission.brief.visits().is_none() || planner != planner::CLAIRVOYANT {
                pairs.fly(&mission, planner, &mut Chance::new(seed, "elsewhere"));
            }
        }
        pairs
    }
}

/// P-UNSEEN-IDLE: Two truths that agree on everything observed so far lead to the same commands so
/// far, whatever the planner.
///
/// In all profiles, with vertical hops and without, also with treasures in other places.
#[test]
fn what_has_not_been_seen_changes_no_decision_of_any_planner() {
    for planner in planner::ALGORITHMS {
        let pairs = Pairs::small(planner, 120);
        assert_eq!(pairs.leaked, 0, "{planner}: {pairs:?}");
        assert!(pairs.differ > pairs.flown / 10 || *planner == "hold", "{planner}: {pairs:?}");
        assert!(pairs.treasures > pairs.flown / 2, "{planner}: {pairs:?}");
        assert_eq!(pairs.profiles.len(), Profile::ALL.len(), "{planner}: {pairs:?}");
    }
}

fn pose_at_start(brief: &Brief, terrain: &terrain::Terrain) -> Pose {
    let cell = brief.robots[0].start.cell;
    Pose { cell, height_m: terrain.ground(cell).unwrap().height_m }
}

/// Ground so wide that a landing is told in several patches.
fn wide(profile: Profile, seed: u64) -> Mission {
    let text = format!(
        "[truth]\ntreasures = [[30, 21], [60, 60]]\n[truth.terrain.random_hills]\nwidth_cells = 80\nheight_cells = 80\n\
         cell_size_m = 1.0\nseed = {seed}\nhills = 60\nsigma_m = [2.0, 6.0]\namplitude_m = [0.05, 0.4]\n\
         [truth.sand]\nrectangles = [{{ x = [26, 30], y = [0, 40] }}]\n\
         [brief]\nname = \"wide\"\nprofile = \"{profile}\"\nstart = [20, 20]\ngoal = [70, 66]\n\
         [robot]\nhop_distance_m = 1.0\nsensor = {{ gain = 12.0, offset_m = 2.0 }}\n[limits]\nsteps_max = 110\n"
    );
    let world = Scenario::parse(&text, "wide").and_then(|scenario| scenario.resolve()).unwrap();
    Mission { brief: Brief { run: RunId(1), ..world.brief.clone() }, ..Mission::of(&world, seed) }
}

/// P-UNSEEN-WIDE: Unseen ground changes no decision on maps so wide that a landing takes several
/// patches, in both profiles, with treasures.
#[test]
fn what_has_not_been_seen_changes_no_decision_on_ground_told_in_many_patches() {
    for planner in planner::ALGORITHMS {
        let mut pairs = Pairs::default();
        let profiles = [Profile::Paper2023, Profile::Hopper];
        for (seed, profile) in (1..=2).flat_map(|seed| profiles.map(|profile| (seed, profile))) {
            let mission = wide(profile, seed);
            let mut first = Observation::unseen(&mission.brief, ROBOT);
            let start = pose_at_start(&mission.brief, &mission.terrain);
            first.fold(&mission.brief, &mission.terrain, start, contract::Decision(0));
            let mut chance = Chance::new(seed, "wide");
            pairs.fly(&mission, planner, &mut chance);
            let seen = first.map().seen_cells();
            assert!(seen > MAP_PATCH_CELLS && seen < mission.brief.grid.cells() / 2, "{seen} cells");
        }
        assert_eq!(pairs.leaked, 0, "{planner}: {pairs:?}");
        assert!(pairs.treasures > 0 && pairs.profiles.len() == 2, "{planner}: {pairs:?}");
        assert!(pairs.differ > 0 || *planner == "hold", "{planner}: {pairs:?}");
    }
}

#[test]
fn a_planner_that_sees_the_truth_is_found_out() {
    let pairs = Pairs::small(planner::CLAIRVOYANT, 40);
    assert!(pairs.leaked > 0, "{pairs:?}");
}
