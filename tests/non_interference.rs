//! What has not been seen changes no decision: two truths that agree on everything observed so far give
//! the same commands so far.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use contract::limits::TREASURES_MAX;
use contract::{Action, MonotonicNs, Name, Pose, Record, Soil, Vetoed};
use hopper::lockstep::{self, Crew};
use hopper::simulate::chance::Chance;
use hopper::simulate::setup;
use hopper_sim::{Mission, ROBOT};
use perception::Observation;

fn fly(mission: &Mission, planner: &str) -> Vec<Record> {
    let mut records = Vec::new();
    let planner: Name = planner.parse().unwrap();
    lockstep::fly(mission.clone(), &Crew::single(planner), &mut || MonotonicNs(0), &mut |record| {
        records.push(*record);
    })
    .unwrap();
    records
}

/// The same mission on ground that differs wherever nothing was seen through decision `through`.
fn elsewhere(mission: &Mission, records: &[Record], through: usize, chance: &mut Chance) -> Mission {
    let Mission { brief, terrain, .. } = mission;
    let mut seen = Observation::unseen(brief, ROBOT);
    let start = contract::Pose { cell: brief.start, height_m: terrain.ground(brief.start).unwrap().height_m };
    let poses = std::iter::once(start).chain(records.iter().map(|record| record.pose));
    for (decision, pose) in (0..).zip(poses.take(through + 1)) {
        seen.fold(brief, terrain, pose, contract::Decision(decision));
    }
    let mut other = mission.clone();
    for (ground, seen) in other.terrain.cells.iter_mut().zip(seen.map().cells()) {
        if seen.is_none() {
            ground.height_m = 20.0 * chance.unit() - 10.0;
            ground.gradient = [chance.unit() - 0.5, chance.unit() - 0.5];
            ground.soil = chance.pick(&[Soil::Hard, Soil::Sand]);
            ground.passable = chance.one_in(2);
        }
    }
    // Of the treasures, those seen stay, and others lie where nothing was seen.
    let hidden = |cell| seen.map().ground(cell).is_none();
    let treasures = &mut other.terrain.treasures;
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

/// Pairs of truths flown with `planner`: how many there were, in how many the missions differ at all, and
/// in how many they differ by what was decided before the difference could be seen.
fn pairs(planner: &str, worlds: u64) -> (u64, u64, u64) {
    let (mut flown, mut differ, mut leaked) = (0, 0, 0);
    for seed in 0..worlds {
        let mission = setup::mission(seed, 0);
        let records = fly(&mission, planner);
        let mut chance = Chance::new(seed, "elsewhere");
        for _ in 0..3 {
            let through = chance.below(records.len() as u64) as usize;
            let others = fly(&elsewhere(&mission, &records, through, &mut chance), planner);
            // The commands of decisions 0 to `through`, and all that became of those before it.
            let commands =
                |records: &[Record]| records.iter().map(decided).take(through + 1).collect::<Vec<_>>();
            let same = commands(&records) == commands(&others);
            // Not the digests: what is collected is numbered over all treasures, the unseen among them.
            let poses = |records: &[Record]| -> Vec<Pose> {
                records.iter().map(|record| record.pose).take(through).collect()
            };
            flown += 1;
            leaked += u64::from(!same || poses(&records) != poses(&others));
            differ += u64::from(records.last().unwrap().digest != others.last().unwrap().digest);
        }
    }
    (flown, differ, leaked)
}

/// P-UNSEEN-IDLE.
#[test]
fn what_has_not_been_seen_changes_no_decision_of_any_planner() {
    for planner in planner::ALGORITHMS {
        let (flown, differ, leaked) = pairs(planner, 120);
        assert_eq!(leaked, 0, "{planner}: {leaked} of {flown} pairs");
        assert!(differ > flown / 10 || *planner == "hold", "{planner}: {differ} of {flown} ever differ");
    }
}

#[test]
fn a_planner_that_sees_the_truth_is_found_out() {
    let (flown, _, leaked) = pairs(planner::CLAIRVOYANT, 40);
    assert!(leaked > 0, "none of {flown} pairs");
}
