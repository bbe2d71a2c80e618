//! The registry of algorithms.

use crate::error::PlannerError;
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
        names::CLAIRVOYANT => Err(PlannerError::LockstepOnly),
        _ => Err(PlannerError::UnknownAlgorithm { got: name.into() }),
    }
}
