//! The names that algorithms are asked for by.

use contract::{Brief, Name, Task, Vehicle};
use coverage::Algorithm;

/// Every algorithm that a planner process can run for a hopper.
pub const ALGORITHMS: &[&str] = &[MDP, GREEDY, ASTAR, DSTAR_LITE, HOLD];

/// Every algorithm that a planner process can run for rovers that cover ground.
pub const COVER_ALGORITHMS: &[&str] = &{
    let mut names = [""; Algorithm::ALL.len()];
    let mut index = 0;
    while index < names.len() {
        names[index] = Algorithm::ALL[index].name();
        index += 1;
    }
    names
};

/// Every algorithm that a planner process can run for a rover that drives to a goal over uncertain ground.
pub const DRIVE_ALGORITHMS: &[&str] = &[RRT_STAR, RRT_STAR_ETT, ETT_EXACT];

/// Every algorithm that a planner process can run for a helicopter that looks ahead for a rover.
pub const FLY_ALGORITHMS: &[&str] = &[SCOUT_ROUTE, RRT_STAR_IT, SCOUT_VALUE];

/// Every algorithm that a planner process can run for a helicopter that looks ahead for a hopper.
pub const AHEAD_ALGORITHMS: &[&str] = &[SCOUT_AHEAD];

pub(crate) const RRT_STAR: &str = "rrt_star";
pub(crate) const RRT_STAR_ETT: &str = "rrt_star_ett";
pub(crate) const ETT_EXACT: &str = "ett_exact";
pub(crate) const SCOUT_ROUTE: &str = "scout_route";
pub(crate) const RRT_STAR_IT: &str = "rrt_star_it";
pub(crate) const SCOUT_VALUE: &str = "scout_value";
pub(crate) const SCOUT_AHEAD: &str = "scout_ahead";
pub(crate) const MDP: &str = "mdp";
pub(crate) const GREEDY: &str = "greedy";
pub(crate) const ASTAR: &str = "astar";
pub(crate) const DSTAR_LITE: &str = "dstar_lite";
pub(crate) const HOLD: &str = "hold";

/// The planner that sees the whole ground. No process can run it, so it is not one of [`ALGORITHMS`].
pub const CLAIRVOYANT: &str = "clairvoyant";

/// The algorithms that suit a vehicle in that mission; without a vehicle, a hopper that is alone.
#[must_use]
pub fn suited(brief: &Brief, vehicle: Option<Vehicle>) -> Vec<&'static str> {
    let tasks = brief.tasks_of(vehicle).into_iter();
    tasks.flat_map(|task| of_vehicle(task, vehicle)).copied().collect()
}

/// All algorithms for that task, whatever the vehicle.
pub(crate) fn of_task(task: Task) -> Vec<&'static str> {
    match task {
        Task::Reach | Task::Patrol => ALGORITHMS.to_vec(),
        Task::Accompany => [ALGORITHMS, AHEAD_ALGORITHMS].concat(),
        Task::Cover(_) => COVER_ALGORITHMS.to_vec(),
        Task::Scout(_) => [DRIVE_ALGORITHMS, FLY_ALGORITHMS].concat(),
        // Robots of a mixed mission have tasks of their own.
        Task::Mixed(_) => Vec::new(),
    }
}

fn of_vehicle(task: Task, vehicle: Option<Vehicle>) -> &'static [&'static str] {
    match vehicle {
        None | Some(Vehicle::Hopper | Vehicle::HopperTo { .. }) => ALGORITHMS,
        Some(Vehicle::Rover { .. }) => COVER_ALGORITHMS,
        Some(Vehicle::Driver { .. }) => DRIVE_ALGORITHMS,
        Some(Vehicle::Helicopter { .. }) if task == Task::Accompany => AHEAD_ALGORITHMS,
        Some(Vehicle::Helicopter { .. }) => FLY_ALGORITHMS,
    }
}

/// The algorithm that commands a vehicle in that mission for which nobody names another.
#[must_use]
pub fn usual(brief: &Brief, vehicle: Option<Vehicle>) -> &'static str {
    match vehicle {
        None | Some(Vehicle::Hopper | Vehicle::HopperTo { .. }) => MDP,
        Some(Vehicle::Rover { .. }) => "cover_frontier",
        Some(Vehicle::Driver { .. }) => RRT_STAR_ETT,
        Some(Vehicle::Helicopter { .. }) if brief.scout.is_none() => SCOUT_AHEAD,
        Some(Vehicle::Helicopter { .. }) => RRT_STAR_IT,
    }
}

/// All algorithms that a planner process can run, with what each is for: for help texts.
#[must_use]
pub fn listed() -> String {
    format!(
        "{}; for a hopper's helicopter {}; for rovers that cover ground {}; for a rover that is scouted for {}, and its helicopter {}",
        ALGORITHMS.join(", "),
        AHEAD_ALGORITHMS.join(", "),
        COVER_ALGORITHMS.join(", "),
        DRIVE_ALGORITHMS.join(", "),
        FLY_ALGORITHMS.join(", ")
    )
}

/// One of the names above as a [`Name`].
pub(crate) fn name(text: &'static str) -> Name {
    text.parse().expect("the names of algorithms are short and printable")
}
