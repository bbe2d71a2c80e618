//! What a cartographer wants done.

use contract::{PastRequest, Refusal, RouteRequest, Status, TruthRequest};

/// What perception wants done.
#[derive(Clone, Debug, PartialEq)]
pub enum Effect {
    /// Ask for the past.
    RequestPast(PastRequest),
    /// Ask for the terrain.
    RequestTruth(TruthRequest),
    /// Ask for the points of a route.
    RequestRoute(RouteRequest),
    /// Publish [`crate::Cartographer::patches`].
    PublishMap,
    /// A message was refused.
    Refused(Refusal),
    /// The mission is over and its last map is out.
    Finished(Status),
}
