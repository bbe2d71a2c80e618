//! The algorithms by name.

use contract::Name;

use crate::greedy::Greedy;
use crate::hold::Hold;
use crate::mdp::Mdp;
use crate::route::{AStar, DStarLite};
use crate::{Planner, PlannerError};

/// Every algorithm there is.
pub const ALGORITHMS: &[&str] = &["mdp", "greedy", "astar", "dstar_lite", "hold"];

/// The planner that sees the whole ground: no process can run it, so it is none of [`ALGORITHMS`].
pub const CLAIRVOYANT: &str = "clairvoyant";

/// A fresh planner of the algorithm called `name`.
///
/// # Errors
/// [`PlannerError::UnknownAlgorithm`] names the known ones; [`PlannerError::LockstepOnly`] refuses
/// the clairvoyant.
pub fn algorithm(name: &str) -> Result<Box<dyn Planner>, PlannerError> {
    match name {
        "mdp" => Ok(Box::<Mdp>::default()),
        "greedy" => Ok(Box::new(Greedy)),
        "astar" => Ok(Box::new(AStar)),
        "dstar_lite" => Ok(Box::<DStarLite>::default()),
        "hold" => Ok(Box::new(Hold)),
        CLAIRVOYANT => Err(PlannerError::LockstepOnly),
        _ => Err(PlannerError::UnknownAlgorithm { got: name.into() }),
    }
}

/// The name of a built-in algorithm as a [`Name`].
pub(crate) fn name(text: &'static str) -> Name {
    text.parse().expect("the names of algorithms are short and printable")
}
