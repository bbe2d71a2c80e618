//! The table of planners: what each is called, what it is for, and how it is made.
//!
//! The lists of names, which planners suit a robot, which is usual for it, and the help texts follow from it.

use contract::spelling::did_you_mean;
use contract::{Account, Body, Brief, Goal, Robot};
use coverage::Algorithm;

use crate::cover::Cover;
use crate::drive::{Drive, RouteSearch};
use crate::error::PlannerError;
use crate::fly::{FlightSearch, Fly, LookAhead};
use crate::greedy::Greedy;
use crate::hold::Hold;
use crate::mdp::Mdp;
use crate::names::{
    ASTAR, CLAIRVOYANT, DSTAR_LITE, ETT_EXACT, GREEDY, HOLD, MDP, RRT_STAR, RRT_STAR_ETT, RRT_STAR_IT,
    SCOUT_AHEAD, SCOUT_ROUTE, SCOUT_VALUE,
};
use crate::plan::Planner;
use crate::route::{AStar, DStarLite};

/// Every planner that a process can run. Where a robot may have planners of several purposes, the first usual one is its usual one.
const PLANNERS: &[BuiltIn] = &[
    BuiltIn::new(MDP, Purpose::Hop, || Box::<Mdp>::default()).usual(),
    BuiltIn::new(GREEDY, Purpose::Hop, || Box::new(Greedy)),
    BuiltIn::new(ASTAR, Purpose::Hop, || Box::new(AStar)),
    BuiltIn::new(DSTAR_LITE, Purpose::Hop, || Box::<DStarLite>::default()),
    BuiltIn::new(HOLD, Purpose::Hop, || Box::new(Hold)),
    BuiltIn::new(Algorithm::Spiral.name(), Purpose::Cover, || covers(Algorithm::Spiral)),
    BuiltIn::new(Algorithm::SpiralCircumnavigation.name(), Purpose::Cover, || {
        covers(Algorithm::SpiralCircumnavigation)
    }),
    BuiltIn::new(Algorithm::Boustrophedon.name(), Purpose::Cover, || covers(Algorithm::Boustrophedon)),
    BuiltIn::new(Algorithm::BoustrophedonCircumnavigation.name(), Purpose::Cover, || {
        covers(Algorithm::BoustrophedonCircumnavigation)
    }),
    BuiltIn::new(Algorithm::CoverFrontier.name(), Purpose::Cover, || covers(Algorithm::CoverFrontier))
        .usual(),
    BuiltIn::new(RRT_STAR, Purpose::Drive, || Box::new(Drive::new(RouteSearch::Shortest))),
    BuiltIn::new(RRT_STAR_ETT, Purpose::Drive, || Box::new(Drive::new(RouteSearch::ExpectedTime))).usual(),
    BuiltIn::new(ETT_EXACT, Purpose::Drive, || Box::new(Drive::new(RouteSearch::Exact))),
    BuiltIn::new(SCOUT_ROUTE, Purpose::LookAheadOfDriver, || Box::new(Fly::new(FlightSearch::Route))),
    BuiltIn::new(RRT_STAR_IT, Purpose::LookAheadOfDriver, || Box::new(Fly::new(FlightSearch::Spread)))
        .usual(),
    BuiltIn::new(SCOUT_VALUE, Purpose::LookAheadOfDriver, || Box::new(Fly::new(FlightSearch::Value))),
    BuiltIn::new(SCOUT_AHEAD, Purpose::LookAheadOfHopper, || Box::<LookAhead>::default()).usual(),
];

const _: () =
    assert!(count(Purpose::Cover) == Algorithm::ALL.len(), "all planners of coverage are in the table");

/// A planner that a process can run.
struct BuiltIn {
    /// The name that it is asked for by.
    name: &'static str,
    purpose: Purpose,
    /// Whether it commands a robot for which nobody names another.
    is_usual: bool,
    /// Makes one that has planned nothing.
    make: fn() -> Box<dyn Planner>,
}

impl BuiltIn {
    const fn new(name: &'static str, purpose: Purpose, make: fn() -> Box<dyn Planner>) -> Self {
        Self { name, purpose, is_usual: false, make }
    }

    const fn usual(self) -> Self {
        Self { is_usual: true, ..self }
    }
}

fn covers(algorithm: Algorithm) -> Box<dyn Planner> {
    Box::new(Cover::new(algorithm))
}

/// What a planner is for: robots of one body with one kind of goal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Purpose {
    /// Hoppers that go to a cell, or to one after another.
    Hop,
    /// Helicopters that look ahead for hoppers.
    LookAheadOfHopper,
    /// Rovers that cover ground.
    Cover,
    /// Rovers that drive to a goal over uncertain ground.
    Drive,
    /// Helicopters that look ahead for such rovers.
    LookAheadOfDriver,
}

impl Purpose {
    /// In the order of help texts, with the words that come before the planners of each.
    const LISTED: &[(Purpose, &'static str)] = &[
        (Purpose::Hop, ""),
        (Purpose::LookAheadOfHopper, "; for a hopper's helicopter "),
        (Purpose::Cover, "; for rovers that cover ground "),
        (Purpose::Drive, "; for a rover that is scouted for "),
        (Purpose::LookAheadOfDriver, ", and its helicopter "),
    ];

    /// Whether planners of this purpose can plan for a robot of that mission.
    fn is_of(self, brief: &Brief, robot: &Robot) -> bool {
        let looks_ahead = matches!((robot.body, robot.goal), (Body::Helicopter(_), Goal::LookAhead(_)));
        match self {
            Purpose::Hop => robot.body.hops() && robot.goal.is_place(),
            Purpose::Cover => matches!((robot.body, robot.goal), (Body::Rover(_), Goal::Cover(_))),
            Purpose::Drive => matches!((robot.body, robot.goal), (Body::Driver(_), Goal::Reach(_))),
            Purpose::LookAheadOfDriver => looks_ahead && brief.robots.iter().any(|other| other.body.drives()),
            // A mission of which all actions count is that of a rover and its helicopters alone.
            Purpose::LookAheadOfHopper => looks_ahead && brief.account != Account::Actions,
        }
    }
}

const fn count(purpose: Purpose) -> usize {
    let (mut count, mut row) = (0, 0);
    while row < PLANNERS.len() {
        count += (PLANNERS[row].purpose as u8 == purpose as u8) as usize;
        row += 1;
    }
    count
}

/// The names of all planners of a purpose, of which there are `N`.
const fn names<const N: usize>(purpose: Purpose) -> [&'static str; N] {
    let mut names = [""; N];
    let (mut found, mut row) = (0, 0);
    while row < PLANNERS.len() {
        if PLANNERS[row].purpose as u8 == purpose as u8 {
            names[found] = PLANNERS[row].name;
            found += 1;
        }
        row += 1;
    }
    names
}

/// Every algorithm that a planner process can run for a hopper.
pub const ALGORITHMS: &[&str] = &names::<{ count(Purpose::Hop) }>(Purpose::Hop);

/// Every algorithm that a planner process can run for rovers that cover ground.
pub const COVER_ALGORITHMS: &[&str] = &names::<{ count(Purpose::Cover) }>(Purpose::Cover);

/// Every algorithm that a planner process can run for a rover that drives to a goal over uncertain ground.
pub const DRIVE_ALGORITHMS: &[&str] = &names::<{ count(Purpose::Drive) }>(Purpose::Drive);

/// Every algorithm that a planner process can run for a helicopter that looks ahead for a rover.
pub const FLY_ALGORITHMS: &[&str] =
    &names::<{ count(Purpose::LookAheadOfDriver) }>(Purpose::LookAheadOfDriver);

/// Every algorithm that a planner process can run for a helicopter that looks ahead for a hopper.
pub const AHEAD_ALGORITHMS: &[&str] =
    &names::<{ count(Purpose::LookAheadOfHopper) }>(Purpose::LookAheadOfHopper);

/// A fresh planner of the algorithm called `name`.
///
/// # Errors
/// [`PlannerError::UnknownAlgorithm`] names the known ones; [`PlannerError::LockstepOnly`] refuses
/// the clairvoyant.
pub fn algorithm(name: &str) -> Result<Box<dyn Planner>, PlannerError> {
    match PLANNERS.iter().find(|planner| planner.name == name) {
        Some(planner) => Ok((planner.make)()),
        None if name == CLAIRVOYANT => Err(PlannerError::LockstepOnly),
        None => Err(PlannerError::UnknownAlgorithm { got: name.to_owned(), hint: hint(name) }),
    }
}

/// The planners that `got` resembles, or all that there are.
fn hint(got: &str) -> String {
    match did_you_mean(got, all()).as_str() {
        "" => format!("; need one of {}", listed()),
        meant => meant.to_owned(),
    }
}

/// The planners for a robot of that mission. Of those for hoppers, only some plan by a motion table.
fn suiting<'a>(brief: &'a Brief, robot: &'a Robot) -> impl Iterator<Item = &'static BuiltIn> + 'a {
    let has_branches = robot.as_hopper().is_none_or(|(motion, _)| motion.table == 0);
    let suits = move |planner: &&BuiltIn| {
        let plans_by_table = planner.purpose != Purpose::Hop || [MDP, HOLD].contains(&planner.name);
        planner.purpose.is_of(brief, robot) && (has_branches || plans_by_table)
    };
    PLANNERS.iter().filter(suits)
}

/// The algorithms that suit a robot of that mission.
#[must_use]
pub fn suited(brief: &Brief, robot: &Robot) -> Vec<&'static str> {
    suiting(brief, robot).map(|planner| planner.name).collect()
}

/// The algorithm that commands a robot of that mission for which nobody names another; `None` if no algorithm suits it.
#[must_use]
pub fn usual(brief: &Brief, robot: &Robot) -> Option<&'static str> {
    suiting(brief, robot).find(|planner| planner.is_usual).map(|planner| planner.name)
}

/// All algorithms that a planner process can run, with what each is for: for help texts.
#[must_use]
pub fn listed() -> String {
    let listed = |(purpose, words): &(Purpose, &str)| {
        format!("{words}{}", of(*purpose).collect::<Vec<_>>().join(", "))
    };
    Purpose::LISTED.iter().map(listed).collect()
}

/// The names of all planners in the order of help texts, and the one that no process can run.
fn all() -> impl Iterator<Item = &'static str> {
    Purpose::LISTED.iter().flat_map(|(purpose, _)| of(*purpose)).chain([CLAIRVOYANT])
}

/// The names of the planners of a purpose.
fn of(purpose: Purpose) -> impl Iterator<Item = &'static str> {
    PLANNERS.iter().filter(move |planner| planner.purpose == purpose).map(|planner| planner.name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_helicopter_may_have_the_planners_for_those_whom_it_looks_ahead_for() {
        for (scenario, usually, names) in [
            ("hopper-scout", SCOUT_AHEAD, AHEAD_ALGORITHMS.to_vec()),
            ("rover-helicopter", RRT_STAR_IT, FLY_ALGORITHMS.to_vec()),
            ("expedition", RRT_STAR_IT, [FLY_ALGORITHMS, AHEAD_ALGORITHMS].concat()),
        ] {
            let brief = scenario::load(scenario).unwrap().resolve().unwrap().brief;
            let flies = |robot: &&Robot| matches!(robot.body, Body::Helicopter(_));
            let helicopter = brief.robots.iter().find(flies).unwrap();
            assert_eq!(suited(&brief, helicopter), names, "{scenario}");
            assert_eq!(usual(&brief, helicopter), Some(usually), "{scenario}");
        }
    }

    #[test]
    fn each_robot_has_one_usual_planner_among_those_that_suit_it() {
        for (scenario, usually) in [("hard", MDP), ("patrol", MDP), ("coverage", "cover_frontier")] {
            let brief = scenario::load(scenario).unwrap().resolve().unwrap().brief;
            let robot = &brief.robots[0];
            assert_eq!(suiting(&brief, robot).filter(|planner| planner.is_usual).count(), 1, "{scenario}");
            assert_eq!(usual(&brief, robot), Some(usually), "{scenario}");
        }
    }
}
