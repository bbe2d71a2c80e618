//! The registry of algorithms.

use crate::error::PlannerError;
use crate::greedy::Greedy;
use crate::hold::Hold;
use crate::mdp::Mdp;
use crate::names::{ASTAR, CLAIRVOYANT, DSTAR_LITE, GREEDY, HOLD, MDP};
use crate::plan::Planner;
use crate::route::{AStar, DStarLite};

/// A fresh planner of the algorithm called `name`.
///
/// # Errors
/// [`PlannerError::UnknownAlgorithm`] names the known ones; [`PlannerError::LockstepOnly`] refuses
/// the clairvoyant.
pub fn algorithm(name: &str) -> Result<Box<dyn Planner>, PlannerError> {
    match name {
        MDP => Ok(Box::<Mdp>::default()),
        GREEDY => Ok(Box::new(Greedy)),
        ASTAR => Ok(Box::new(AStar)),
        DSTAR_LITE => Ok(Box::<DStarLite>::default()),
        HOLD => Ok(Box::new(Hold)),
        CLAIRVOYANT => Err(PlannerError::LockstepOnly),
        _ => Err(PlannerError::UnknownAlgorithm { got: name.into() }),
    }
}
