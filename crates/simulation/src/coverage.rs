//! How often each thing that is worth simulating has come up.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::setup::Missions;

/// Counters by group and name.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Coverage(pub BTreeMap<&'static str, BTreeMap<&'static str, u64>>);

impl Coverage {
    /// An event of `group` happened once more.
    pub fn count(&mut self, group: &'static str, name: &'static str) {
        *self.0.entry(group).or_default().entry(name).or_default() += 1;
    }

    /// How often it came up.
    #[must_use]
    pub fn of(&self, group: &str, name: &str) -> u64 {
        self.0.get(group).and_then(|names| names.get(name)).copied().unwrap_or(0)
    }

    /// Adds the counts of another simulation.
    pub fn add(&mut self, other: &Coverage) {
        for (group, names) in &other.0 {
            for (name, count) in names {
                *self.0.entry(group).or_default().entry(name).or_default() += count;
            }
        }
    }
}

/// A rare event that must come up: group, name, in whose missions, and within how many seeds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sometimes {
    /// Group of the counter.
    pub group: &'static str,
    /// Name of the counter.
    pub name: &'static str,
    /// Missions in which the event can happen.
    pub missions: &'static [Missions],
    /// Seeds within which it comes up at least once, with room to spare.
    pub seeds: u64,
}

const ALL: &[Missions] = &[
    Missions::Hopper,
    Missions::Rovers,
    Missions::Scouts,
    Missions::Accompanied,
    Missions::Mixed,
    Missions::Protocol,
];
const UNCERTAIN: &[Missions] =
    &[Missions::Hopper, Missions::Rovers, Missions::Scouts, Missions::Accompanied, Missions::Mixed];
const PROTOCOL: &[Missions] = &[Missions::Protocol];
const HOPPER: &[Missions] = &[Missions::Hopper];
const ALONE: &[Missions] = &[Missions::Hopper, Missions::Protocol];
const ROVERS: &[Missions] = &[Missions::Rovers];
const SCOUTS: &[Missions] = &[Missions::Scouts];
const ACCOMPANIED: &[Missions] = &[Missions::Accompanied];
const MIXED: &[Missions] = &[Missions::Mixed];
const MEETING: &[Missions] = &[Missions::Rovers, Missions::Mixed];
const FLYING: &[Missions] = &[Missions::Scouts, Missions::Accompanied, Missions::Mixed];
const TEAMS: &[Missions] = &[Missions::Rovers, Missions::Scouts, Missions::Accompanied, Missions::Mixed];

const fn sometimes(
    group: &'static str,
    name: &'static str,
    missions: &'static [Missions],
    seeds: u64,
) -> Sometimes {
    Sometimes { group, name, missions, seeds }
}

/// Rare events without which promises are kept by luck.
pub const SOMETIMES: &[Sometimes] = &[
    sometimes("map", "discs_differ", HOPPER, 100),
    sometimes("map", "patch_between_pages", ALL, 500),
    sometimes("map", "pass_undisturbed", ALL, 500),
    sometimes("map", "pass_disturbed", ALL, 500),
    sometimes("map", "pass_repeated", UNCERTAIN, 2_000),
    sometimes("map", "pass_repeated", PROTOCOL, 20_000),
    sometimes("run", "after_the_end", ALL, 500),
    sometimes("map", "asked_again", ALL, 2_000),
    sometimes("journal", "replaced_before", ALL, 500),
    sometimes("journal", "replaced_after", ALONE, 500),
    sometimes("journal", "resumed_beyond_a_page", ALL, 2_000),
    sometimes("past", "page_beyond_the_first", ALL, 500),
    sometimes("reservation", "two_robots_kept", MEETING, 2_000),
    sometimes("play", "executed", TEAMS, 500),
    sometimes("play", "blocked", MEETING, 500),
    sometimes("play", "drive_blocked", &[Missions::Scouts, Missions::Mixed], 500),
    sometimes("reservation", "kept", ALL, 500),
    sometimes("reservation", "slow_bidder", ALL, 20_000),
    sometimes("stayed", "planner", ALL, 500),
    sometimes("stayed", "perception", ALL, 500),
    sometimes("stayed", "monitor", ALL, 500),
    sometimes("fallback", "policy", ALONE, 2_000),
    sometimes("vertical", "climbed", HOPPER, 500),
    sometimes("vertical", "missed", HOPPER, 500),
    sometimes("rovers", "stranded", ROVERS, 500),
    sometimes("rovers", "another_leads", ROVERS, 500),
    sometimes("rovers", "two_led_by_one", ROVERS, 500),
    sometimes("refusal", "not_due", TEAMS, 500),
    sometimes("refusal", "occupied", MEETING, 2_000),
    sometimes("refusal", "unknown_route", FLYING, 500),
    sometimes("refusal", "beyond_budget", SCOUTS, 5_000),
    sometimes("refusal", "vetoed", FLYING, 500),
    sometimes("scouts", "announcement_lost", FLYING, 500),
    sometimes("scouts", "another_life_drives_off", SCOUTS, 500),
    sometimes("scouts", "another_life_takes_off", FLYING, 500),
    sometimes("scouts", "flight_taken_over", SCOUTS, 500),
    sometimes("scouts", "drive_taken_over", SCOUTS, 500),
    sometimes("scouts", "announced_anew", SCOUTS, 500),
    sometimes("scouts", "helicopter_out", FLYING, 500),
    sometimes("scouts", "rover_trapped", SCOUTS, 500),
    sometimes("scouts", "drives_misled", SCOUTS, 500),
    sometimes("scouts", "fallback_flies", FLYING, 500),
    sometimes("scouts", "fallback_drives", SCOUTS, 500),
    sometimes("scouts", "route_asked_again", FLYING, 500),
    sometimes("stages", "halted", SCOUTS, 500),
    sometimes("stages", "fallback_halted", SCOUTS, 2_000),
    sometimes("stages", "flies_again", SCOUTS, 500),
    sometimes("stages", "replanned_after_halt", SCOUTS, 500),
    sometimes("stages", "another_life_after_halt", SCOUTS, 2_000),
    sometimes("scouts", "treasure_spotted", ACCOMPANIED, 500),
    sometimes("scouts", "hopper_out", ACCOMPANIED, 500),
    sometimes("scouts", "prior_of_two_lives", SCOUTS, 2_000),
    sometimes("fallback", "greedy", MIXED, 500),
    sometimes("mixed", "hop_stops_before_another", MIXED, 500),
    sometimes("mixed", "hopper_waits", MIXED, 500),
    sometimes("mixed", "rover_waits", MIXED, 500),
    sometimes("mixed", "rover_enters_an_empty_find", MIXED, 2_000),
    sometimes("mixed", "hopper_arrives", MIXED, 500),
    sometimes("mixed", "rover_arrives", MIXED, 500),
    sometimes("mixed", "gives_up", MIXED, 500),
    sometimes("mixed", "hopper_is_lost", MIXED, 500),
    sometimes("mixed", "goes_on_without_one", MIXED, 500),
    sometimes("mixed", "closed_to_rovers", MIXED, 500),
    sometimes("mixed", "ends_while_others_act", MIXED, 500),
];

impl Coverage {
    /// The rare events that should have come up in so many seeds of these missions, and did not.
    pub fn never(&self, missions: Missions, seeds: u64) -> impl Iterator<Item = &'static Sometimes> + '_ {
        let due = move |event: &&Sometimes| event.missions.contains(&missions) && event.seeds <= seeds;
        SOMETIMES.iter().filter(due).filter(|event| self.of(event.group, event.name) == 0)
    }
}
