//! The faults of one mission, drawn from its seed and its victim.

use contract::Role;
use hopper_sim::Pace;
use serde::Serialize;
use simulation::chance::Chance;

/// Most faults in a mission.
const FAULTS_MAX: u64 = 4;

/// Latest start-up fault, microseconds after the start: by then a process has joined, unless the machine is busy.
const START_UP_US: u64 = 40_000;

/// Decisions after which a fault is injected, the first and the last, on hard ground, where missions take at least 35.
pub const ON_HARD_GROUND: (u64, u64) = (1, 34);

/// Latest fault after its decision, microseconds.
const FLIGHT_US: u64 = 8_000;

/// Highest passage of a crash point at which a process is killed.
const PASSAGES: u64 = 12;

/// Shortest and longest pause, milliseconds: a short one, and one after which a process counts as gone.
const PAUSE_MS: [(u64, u64); 2] = [(1, 120), (1_050, 1_400)];

/// When a fault is injected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultTime {
    /// After the victim was started.
    StartUp {
        /// Microseconds between that and the fault.
        after_us: u64,
    },
    /// After the journal first held a number of decisions.
    Flight {
        /// Executed decisions, counted from the start of the mission.
        decisions: u64,
        /// Microseconds between that and the fault.
        after_us: u64,
    },
}

/// A fault of the victim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Fault {
    /// kill -9 at a passage of a named crash point; set when the process is started.
    Point {
        /// One of [`crash_points`], where the process kills itself.
        name: &'static str,
        /// How many times the process reaches the point, this time included.
        passage: u64,
    },
    /// SIGKILL: the process ends at once, and is started again.
    Kill(FaultTime),
    /// SIGSTOP, and SIGCONT after a while.
    Pause {
        /// When the process is stopped.
        at: FaultTime,
        /// Time until it is continued, milliseconds.
        for_ms: u64,
    },
    /// SIGTERM, then a new process.
    Restart(FaultTime),
}

impl Fault {
    /// Name under which it is counted.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Fault::Point { name, .. } => name,
            Fault::Kill(FaultTime::StartUp { .. }) => "kill in start-up",
            Fault::Kill(FaultTime::Flight { .. }) => "kill in flight",
            Fault::Pause { .. } => "pause",
            Fault::Restart(_) => "restart",
        }
    }

    /// When it is injected; `None` at a crash point.
    #[must_use]
    pub fn at(&self) -> Option<FaultTime> {
        match *self {
            Fault::Point { .. } => None,
            Fault::Kill(at) | Fault::Restart(at) | Fault::Pause { at, .. } => Some(at),
        }
    }
}

/// The faults of one mission.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Plan {
    /// Seed of the plan and of the mission.
    pub seed: u64,
    /// Role whose process the faults are injected into.
    pub victim: Role,
    /// Which of several planners is the victim.
    #[serde(skip_serializing_if = "is_first")]
    pub planner: usize,
    /// Order in which they are started, all planners one after the other.
    pub order: [Role; 4],
    /// Pace of the mission, landings a second.
    #[serde(skip)]
    pub pace: Pace,
    /// Faults in the order in which they are injected.
    pub faults: Vec<Fault>,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde wants a reference")]
fn is_first(planner: &usize) -> bool {
    *planner == 0
}

impl Plan {
    /// The plan of `seed` for `victim`, one of so many planners if it is one, with faults after these decisions. Where the first
    /// is not 1, none comes at start-up.
    #[must_use]
    pub fn of(seed: u64, victim: Role, planners: usize, decisions: (u64, u64)) -> Self {
        let mut chance = Chance::new(seed, victim.as_str());
        let mut order = Role::ALL;
        for last in (1..order.len()).rev() {
            order.swap(last, chance.below(last as u64 + 1) as usize);
        }
        // A mission does not wait for its monitor: at full pace it would be over before the monitor is back.
        let slow = victim == Role::Monitor || chance.one_in(2);
        let pace = if slow { Pace::Hertz(150.0) } else { Pace::Max };
        let mut faults = Vec::new();
        let mut fresh = true;
        for _ in 0..chance.between(1, FAULTS_MAX) {
            let fault = draw(&mut chance, victim, fresh, decisions);
            // A crash point is set when a process is started; after a pause it is still the same process.
            fresh = !matches!(fault, Fault::Pause { .. });
            faults.push(fault);
        }
        let planner = Chance::new(seed, "planner").below(planners.max(1) as u64) as usize;
        Self { seed, victim, planner, order, pace, faults }
    }
}

/// The crash points of a role.
#[must_use]
pub fn crash_points(role: Role) -> &'static [&'static str] {
    match role {
        Role::HopperSim => hopper_sim::CRASH_POINTS,
        Role::Perception => perception::process::CRASH_POINTS,
        Role::Planner => planner::process::CRASH_POINTS,
        Role::Monitor => monitor::process::CRASH_POINTS,
    }
}

fn draw(chance: &mut Chance, victim: Role, fresh: bool, decisions: (u64, u64)) -> Fault {
    match chance.below(8) {
        0..3 if fresh && decisions.0 <= 1 => {
            let name = chance.pick(crash_points(victim));
            let passage = if chance.one_in(2) { 1 } else { chance.between(2, PASSAGES) };
            Fault::Point { name, passage }
        }
        0..6 => Fault::Kill(fault_time(chance, decisions)),
        6 => {
            let (least, most) = PAUSE_MS[usize::from(chance.one_in(8))];
            Fault::Pause { at: fault_time(chance, decisions), for_ms: chance.between(least, most) }
        }
        _ => Fault::Restart(fault_time(chance, decisions)),
    }
}

fn fault_time(chance: &mut Chance, (first, last): (u64, u64)) -> FaultTime {
    if chance.one_in(2) && first <= 1 {
        FaultTime::StartUp { after_us: chance.below(START_UP_US) }
    } else {
        let decisions = chance.between(first, last.max(first));
        FaultTime::Flight { decisions, after_us: chance.below(FLIGHT_US) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_hundred_plans_of_a_role_name_every_crash_point_and_every_kind_of_fault() {
        for victim in Role::ALL {
            let plan = |seed| Plan::of(seed, victim, 1, ON_HARD_GROUND);
            let plans: Vec<Plan> = (0..200).map(plan).collect();
            assert_eq!(plans, (0..200).map(plan).collect::<Vec<_>>());
            let names: std::collections::BTreeSet<&str> =
                plans.iter().flat_map(|plan| &plan.faults).map(Fault::name).collect();
            let kinds = ["kill in start-up", "kill in flight", "pause", "restart"];
            for name in crash_points(victim).iter().chain(&kinds) {
                assert!(names.contains(name), "{victim}: {name}");
            }
        }
    }
    #[test]
    fn late_faults_come_after_their_first_decision_and_to_every_planner() {
        let plans: Vec<Plan> = (0..200).map(|seed| Plan::of(seed, Role::Planner, 3, (300, 800))).collect();
        for fault in plans.iter().flat_map(|plan| &plan.faults) {
            match fault.at() {
                Some(FaultTime::Flight { decisions, .. }) => assert!((300..=800).contains(&decisions)),
                other => panic!("{other:?}"),
            }
        }
        for planner in 0..3 {
            assert!(plans.iter().any(|plan| plan.planner == planner), "{planner}");
        }
    }
}
