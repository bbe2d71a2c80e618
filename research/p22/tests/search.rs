//! The search itself, on judgements that cost nothing.

use p22::search::{Judged, Search};
use p22::{P22, Reading};

/// Answers in common with the reading in use.
fn likeness(reading: &Reading) -> Judged {
    let questions = P22.questions();
    let same = |field: &str| {
        let value = |reading: &Reading| serde_json::to_value(reading).unwrap()[field].clone();
        value(reading) == value(&P22)
    };
    let holds = questions.iter().filter(|question| same(question.field)).count();
    Judged { holds, claims: questions.len(), reading: *reading }
}

/// P-KNOWN-SEARCH: The search for a reading is repeatable on any number of threads, and judges no
/// reading twice.
#[test]
fn a_search_is_repeatable_and_climbs_to_the_summit() {
    let search = Search { seed: 4, samples: 20, climbs: 3, high_climbs: 1 };
    let found = search.run(|readings| readings.iter().map(likeness).collect());
    assert_eq!(found.summits[0].reading, P22);
    assert_eq!(found.summits[0].holds, found.summits[0].claims);
    assert_eq!(found.chosen.reading, P22);
    assert_eq!(found, search.run(|readings| readings.iter().map(likeness).collect()));
}

/// P-KNOWN-SEARCH.
#[test]
fn no_reading_is_judged_twice() {
    let mut seen = Vec::new();
    let search = Search { seed: 1, samples: 30, climbs: 2, high_climbs: 0 };
    let found = search.run(|readings| {
        for reading in readings {
            assert!(!seen.contains(reading), "{reading:?} again");
            seen.push(*reading);
        }
        readings.iter().map(likeness).collect()
    });
    assert_eq!(found.judged, seen.len());
}

#[test]
fn samples_differ_with_the_seed_and_use_every_answer() {
    let sample = |seed| Search { seed, samples: 600, climbs: 0, high_climbs: 0 }.sample();
    assert_eq!(sample(1), sample(1));
    assert_ne!(sample(1), sample(2));
    let (sample, questions) = (sample(1), P22.questions());
    for question in questions.iter().filter(|question| question.field != "hollows") {
        let value = |reading: &Reading| serde_json::to_value(reading).unwrap()[question.field].clone();
        for answer in &question.answers {
            let count = sample.iter().filter(|reading| value(reading) == value(answer)).count();
            assert!(count * question.answers.len() * 3 > sample.len(), "{}: {count}", question.field);
        }
    }
}
