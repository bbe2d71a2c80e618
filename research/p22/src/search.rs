//! Searches for the reading under which most of the paper's claims hold.
//!
//! It begins with a seeded sample: every question of [`Reading::questions`] is answered at random, each answer
//! equally likely. From the best few, hill climbing moves to the best of all readings that differ in one answer,
//! until none is better. From the best few local optima it continues with all readings that differ in two answers
//! (except for the choice of hollows). Of equal readings the one found first comes first.
//!
//! A reading is judged over all maps and weights at once, by the number of claims that hold: nothing is tuned to
//! one weighting or map.

use std::collections::BTreeMap;

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use crate::{Findings, P22, Reading};

/// Parameters of a hill-climbing search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Search {
    /// Seed of the random sample.
    pub seed: u64,
    /// Number of readings in the sample.
    pub samples: usize,
    /// Number of the best samples that hill climbing starts from.
    pub climbs: usize,
    /// Number of the best local optima that climbing continues from, two answers at a time.
    pub high_climbs: usize,
}

/// A reading with its score.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Judged {
    /// Number of claims that hold.
    pub holds: usize,
    /// Number of claims that were checked.
    pub claims: usize,
    /// The reading that was judged.
    pub reading: Reading,
}

/// Result of a search.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Found {
    /// Parameters of the search.
    pub search: Search,
    /// Number of different readings judged.
    pub judged: usize,
    /// Local optima, best first, without repetition.
    pub summits: Vec<Judged>,
    /// The reading in use, [`P22`].
    pub chosen: Judged,
    /// The readings that differ from it in at most one answer: for each of [`Reading::questions`] its answers, in
    /// order.
    pub around: Vec<Vec<Judged>>,
}

/// Counts the claims that hold under one reading.
#[must_use]
pub fn judge(reading: &Reading) -> Judged {
    let (holds, claims) = Findings::new(reading).score();
    Judged { holds, claims, reading: *reading }
}

impl Search {
    /// Runs the search. `judge_all` judges readings in their order, on any number of threads.
    pub fn run(self, mut judge_all: impl FnMut(&[Reading]) -> Vec<Judged>) -> Found {
        let mut known = BTreeMap::new();
        let mut judged = |readings: &[Reading]| -> Vec<Judged> {
            let mut fresh: Vec<Reading> = Vec::new();
            let mut keys = std::collections::BTreeSet::new();
            for reading in readings {
                let key = key(reading);
                if !known.contains_key(&key) && keys.insert(key) {
                    fresh.push(*reading);
                }
            }
            known.extend(judge_all(&fresh).into_iter().map(|judged| (key(&judged.reading), judged)));
            readings.iter().map(|reading| known[&key(reading)]).collect()
        };
        let mut sample = judged(&self.sample());
        // The sort is stable: of equal readings the one drawn first comes first.
        sample.sort_by_key(|judged| std::cmp::Reverse(judged.holds));
        sample.dedup_by_key(|judged| key(&judged.reading));
        let summits = climb_all(&sample, self.climbs, &neighbours, &mut judged);
        let mut higher = climb_all(&summits, self.high_climbs, &second_neighbours, &mut judged);
        for summit in summits {
            if !higher.iter().any(|other| other.reading == summit.reading) {
                higher.push(summit);
            }
        }
        let mut summits = higher;
        summits.sort_by_key(|judged| std::cmp::Reverse(judged.holds));
        let chosen = judged(&[P22])[0];
        let around = P22.questions().iter().map(|question| judged(&question.answers)).collect();
        Found { search: self, judged: known.len(), summits, chosen, around }
    }

    /// The random sample: every question answered at random.
    #[must_use]
    pub fn sample(&self) -> Vec<Reading> {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        (0..self.samples)
            .map(|_| {
                (0..P22.questions().len()).fold(P22, |reading, question| {
                    let answers = &reading.questions()[question].answers;
                    answers[(random.next_u64() % answers.len() as u64) as usize]
                })
            })
            .collect()
    }
}

/// Climbs from the first `count` of `starts`; the local optima, best first, without repetition.
fn climb_all(
    starts: &[Judged],
    count: usize,
    around: &dyn Fn(&Reading) -> Vec<Reading>,
    judged: &mut impl FnMut(&[Reading]) -> Vec<Judged>,
) -> Vec<Judged> {
    let mut summits: Vec<Judged> = Vec::new();
    for &start in starts.iter().take(count) {
        let summit = climb(start, around, judged);
        if !summits.iter().any(|other| other.reading == summit.reading) {
            summits.push(summit);
        }
    }
    summits.sort_by_key(|judged| std::cmp::Reverse(judged.holds));
    summits
}

/// Moves to the best neighbouring reading, the first of equals, until none is better.
fn climb(
    start: Judged,
    around: &dyn Fn(&Reading) -> Vec<Reading>,
    judged: &mut impl FnMut(&[Reading]) -> Vec<Judged>,
) -> Judged {
    let mut here = start;
    loop {
        let better = |best: Judged, other: Judged| if other.holds > best.holds { other } else { best };
        let best = judged(&around(&here.reading)).into_iter().fold(here, better);
        if best.holds <= here.holds {
            return here;
        }
        here = best;
    }
}

/// The readings that differ in at most one answer.
fn neighbours(reading: &Reading) -> Vec<Reading> {
    reading.questions().into_iter().flat_map(|question| question.answers).collect()
}

/// The readings that differ in at most two answers, with the same hollows.
fn second_neighbours(reading: &Reading) -> Vec<Reading> {
    let few = |reading: &Reading| {
        let questions = reading.questions().into_iter().filter(|question| question.field != "hollows");
        questions.flat_map(|question| question.answers).collect::<Vec<_>>()
    };
    few(reading).iter().flat_map(few).collect()
}

/// A text that identifies the reading.
fn key(reading: &Reading) -> String {
    format!("{reading:?}")
}
