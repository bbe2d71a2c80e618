//! Why a world or a mission cannot be.

use contract::Cell;
use coverage::Situation;

/// Why there is no such [`crate::World`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WorldError {
    /// The share of obstacles is none.
    #[error("obstacles need to be 0 % or more and below 100 % of the cells, got {got_percent} %")]
    ObstaclePercent {
        /// The share asked for.
        got_percent: f64,
    },
    /// Every further obstacle would cut off free cells.
    #[error(
        "{need} obstacles do not fit without cutting off free cells, only {got} did: ask for fewer, or another seed"
    )]
    TooManyObstacles {
        /// Number of obstacles asked for.
        need: usize,
        /// Number that could be placed.
        got: usize,
    },
    /// The list of obstacles has another length than the grid has cells.
    #[error("a grid of {need} cells needs as many entries that say whether there is an obstacle, got {got}")]
    Length {
        /// Cells of the grid.
        need: usize,
        /// Entries given.
        got: usize,
    },
}

/// Why a [`crate::Mission`] cannot begin.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SetupError {
    /// There is no rover, or there are too many.
    #[error("a team needs 1 to {} rovers, got {got}", Situation::ROVERS_MAX)]
    Rovers {
        /// Rovers asked for.
        got: usize,
    },
    /// A start is an obstacle or off the grid.
    #[error("rover {robot} needs a start on free ground, got {cell}")]
    StartNotFree {
        /// Number of the rover.
        robot: usize,
        /// Its start.
        cell: Cell,
    },
    /// Two rovers start on one cell.
    #[error("every rover needs a start of its own, rovers {robots:?} got {cell}")]
    StartShared {
        /// Numbers of the rovers.
        robots: [usize; 2],
        /// Their start.
        cell: Cell,
    },
    /// There are fewer free cells than rovers.
    #[error("{need} rovers need as many free cells, the world has {got}")]
    TooFewFreeCells {
        /// Rovers asked for.
        need: usize,
        /// Free cells of the world.
        got: usize,
    },
    /// The share to cover is none.
    #[error("the share to cover needs to be 1 to 100 %, got {got} %")]
    Percent {
        /// The share asked for.
        got: u32,
    },
    /// A fault names a rover that is not in the team, or the action 0.
    #[error(
        "a fault needs a rover from 0 to {robot_max} and an action from 1, got rover {robot}, action {action}"
    )]
    Fault {
        /// Highest number of a rover.
        robot_max: usize,
        /// Number of the rover named.
        robot: usize,
        /// Number of the action named.
        action: u64,
    },
}
