//! A mission flown at once, and what it came to.

use std::sync::Arc;

use contract::MonotonicNs;
use serde::{Deserialize, Serialize};

use crate::Request;

/// How a mission ended. Equal on every machine.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Outcome {
    /// Decisions executed.
    pub decisions: u64,
    /// Steps, in the paper's count.
    pub steps: u64,
    /// How it stands, such as `goal`.
    pub status: String,
    /// The digest chain after the last decision.
    pub digest: String,
    /// SHA-256 of the resolved scenario.
    pub scenario_hash: String,
    /// Fingerprint of the map at the end.
    pub map: String,
}

/// Flies the mission to its end, over the ground of `dem` if the request names a file of it.
///
/// # Errors
/// What was needed and what was got, in a sentence.
pub fn fly(request: &Request, dem: &Arc<[u8]>) -> Result<Outcome, String> {
    let wanted = request.mission(dem)?;
    let hash = wanted.mission.brief.scenario_hash;
    // No time passes: no result depends on it.
    let mut clock = || MonotonicNs(0);
    let flown = lockstep::fly(wanted.mission, &wanted.schedule, &mut clock, &mut |_| ())
        .map_err(|error| error.to_string())?;
    Ok(Outcome {
        decisions: flown.state.decision.0,
        steps: flown.state.steps,
        status: flown.state.status.to_string(),
        digest: flown.state.digest.to_string(),
        scenario_hash: hash.iter().map(|byte| format!("{byte:02x}")).collect(),
        map: format!("{:016x}", flown.map.observation()),
    })
}
