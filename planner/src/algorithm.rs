//! The algorithms by name.

use contract::Name;

use crate::greedy::Greedy;
use crate::hold::Hold;
use crate::mdp::Mdp;
use crate::{Planner, PlannerError};

/// Every algorithm there is.
pub const ALGORITHMS: &[&str] = &["mdp", "greedy", "hold"];

/// A fresh planner of the algorithm called `name`.
///
/// # Errors
/// [`PlannerError::UnknownAlgorithm`] names the known ones.
pub fn algorithm(name: &str) -> Result<Box<dyn Planner>, PlannerError> {
    match name {
        "mdp" => Ok(Box::<Mdp>::default()),
        "greedy" => Ok(Box::new(Greedy)),
        "hold" => Ok(Box::new(Hold)),
        _ => Err(PlannerError::UnknownAlgorithm { got: name.into() }),
    }
}

/// The name of a built-in algorithm as a [`Name`].
pub(crate) fn name(text: &'static str) -> Name {
    text.parse().expect("the names of algorithms are short and printable")
}
