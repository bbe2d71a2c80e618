//! What happens to a cartographer.

use std::sync::Arc;

use contract::{Brief, PastPage, RoutePage, RunId, State, TruthPage};
use terrain::Terrain;

/// A message that came in, or the passing of time.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant, reason = "an event is made, taken, and gone")]
pub enum Event {
    /// The brief; another than before drops all that was known.
    Brief(Brief),
    /// The terrain of a run, whole.
    Terrain(RunId, Arc<Terrain>),
    /// A page of the terrain that was asked for.
    Truth(TruthPage),
    /// The state.
    State(State),
    /// Records that were asked for.
    Past(PastPage),
    /// A route that was asked for.
    Route(RoutePage),
    /// Time passes.
    Tick,
}
