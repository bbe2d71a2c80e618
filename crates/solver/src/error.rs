//! Why a world is refused.

use thiserror::Error;

/// An input out of its range.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Error {
    /// The grid holds no node, or more than can be numbered.
    #[error("a world needs 1 to {nodes_max} nodes, got {width} × {height}")]
    Size {
        /// Nodes per row that were asked for.
        width: usize,
        /// Rows that were asked for.
        height: usize,
        /// [`GridWorld::NODES_MAX`](crate::GridWorld::NODES_MAX).
        nodes_max: usize,
    },
    /// The discount is not in [0, 1).
    #[error("a discount lies in [0, 1), got {got}")]
    Discount {
        /// The discount that was given.
        got: f64,
    },
    /// The loss is not finite.
    #[error("a loss is finite, got {got}")]
    Loss {
        /// The loss that was given.
        got: f64,
    },
    /// A bound on the probability of being lost is none.
    #[error(
        "a bound on the probability of being lost needs to be above 0 and below 1, got {got}; 0.01 allows one loss in a hundred missions"
    )]
    RiskBound {
        /// The bound that was given.
        got: f64,
    },
    /// There is no soil, or there are too many.
    #[error("a world needs 1 to {soils_max} soils, got {got}")]
    Soils {
        /// Soils that were given.
        got: usize,
        /// [`GridWorld::SOILS_MAX`](crate::GridWorld::SOILS_MAX).
        soils_max: usize,
    },
    /// There is no row of a table of landings, or there are too many.
    #[error("a table of landings needs 1 to {rows_max} rows, got {got}")]
    Rows {
        /// Rows that were given.
        got: usize,
        /// [`LandingTable::ROWS_MAX`](crate::landings::LandingTable::ROWS_MAX).
        rows_max: usize,
    },
    /// A row has too many landings.
    #[error("row {row} of a table needs at most {landings_max} landings, got {got}")]
    Landings {
        /// Index of the row.
        row: usize,
        /// Landings that were given.
        got: usize,
        /// [`LandingTable::LANDINGS_MAX`](crate::landings::LandingTable::LANDINGS_MAX).
        landings_max: usize,
    },
    /// A landing is out of reach, or its probability is none.
    #[error(
        "row {row} of a table needs landings at most {reach} hops away along each axis, with probabilities in [0, 1]; got {forward} \
         forward, {left} left, {probability}"
    )]
    Landing {
        /// Index of the row.
        row: usize,
        /// Hops forward that were given.
        forward: i8,
        /// Hops to the left that were given.
        left: i8,
        /// Probability that was given.
        probability: f64,
        /// [`LandingTable::REACH`](crate::landings::LandingTable::REACH).
        reach: i8,
    },
    /// The probabilities of a row add up to more than 1.
    #[error("the probabilities of row {row} of a table need to add up to at most 1, got {got}")]
    Sum {
        /// Index of the row.
        row: usize,
        /// Their sum.
        got: f64,
    },
    /// The numbers of a soil are not probabilities, or do not sum to 1.
    #[error(
        "soil {soil} needs intended, stuck and sideways in [0, 1] with intended + stuck + 2 sideways = 1, \
         and a wait in [0, 1]; got {intended}, {stuck}, {sideways}, wait {wait}"
    )]
    Scatter {
        /// Index in [`Rules::soils`](crate::Rules::soils).
        soil: usize,
        /// Probability of the intended landing on the flat.
        intended: f64,
        /// Probability of getting stuck on the flat.
        stuck: f64,
        /// Probability of a slip to either side on the flat.
        sideways: f64,
        /// Share of the hops that take a second period.
        wait: f64,
    },
}
