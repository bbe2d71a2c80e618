//! The registry of algorithms.

use coverage::UnknownAlgorithm;

use crate::cover::Cover;
use crate::drive::{Drive, RouteSearch};
use crate::error::PlannerError;
use crate::fly::{FlightSearch, Fly, LookAhead};
use crate::greedy::Greedy;
use crate::hold::Hold;
use crate::mdp::Mdp;
use crate::names;
use crate::plan::Planner;
use crate::route::{AStar, DStarLite};

/// A fresh planner of the algorithm called `name`.
///
/// # Errors
/// [`PlannerError::UnknownAlgorithm`] names the known ones; [`PlannerError::LockstepOnly`] refuses
/// the clairvoyant.
pub fn algorithm(name: &str) -> Result<Box<dyn Planner>, PlannerError> {
    // Paths, since a bare name that is not imported would match everything.
    match name {
        names::MDP => Ok(Box::<Mdp>::default()),
        names::GREEDY => Ok(Box::new(Greedy)),
        names::ASTAR => Ok(Box::new(AStar)),
        names::DSTAR_LITE => Ok(Box::<DStarLite>::default()),
        names::HOLD => Ok(Box::new(Hold)),
        names::RRT_STAR => Ok(Box::new(Drive::new(RouteSearch::Shortest))),
        names::RRT_STAR_ETT => Ok(Box::new(Drive::new(RouteSearch::ExpectedTime))),
        names::ETT_EXACT => Ok(Box::new(Drive::new(RouteSearch::Exact))),
        names::SCOUT_ROUTE => Ok(Box::new(Fly::new(FlightSearch::Route))),
        names::RRT_STAR_IT => Ok(Box::new(Fly::new(FlightSearch::Spread))),
        names::SCOUT_VALUE => Ok(Box::new(Fly::new(FlightSearch::Value))),
        names::SCOUT_AHEAD => Ok(Box::<LookAhead>::default()),
        names::CLAIRVOYANT => Err(PlannerError::LockstepOnly),
        _ => match name.parse() {
            Ok(algorithm) => Ok(Box::new(Cover::new(algorithm))),
            Err(UnknownAlgorithm { got }) => Err(PlannerError::UnknownAlgorithm { got }),
        },
    }
}
