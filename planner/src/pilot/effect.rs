//! What a pilot wants done.

use contract::{Command, Leader, MapRequest, PriorRequest, RouteRequest, Status, TableRequest, Term};

/// What a pilot wants done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Ask for the observed map.
    RequestMap(MapRequest),
    /// Ask for the prior.
    RequestPrior(PriorRequest),
    /// Ask hopper-sim for a page of the motion table.
    RequestTable(TableRequest),
    /// Ask for the points of a route.
    RequestRoute(RouteRequest),
    /// Plan for [`crate::pilot::Pilot::situation`], then report [`crate::pilot::Event::Planned`]; unless the plan was reported
    /// meanwhile ([`crate::pilot::Pilot::awaits_plan`]).
    Plan,
    /// Send the command.
    Send(Command),
    /// This planner now commands, under the given term.
    Leads(Term),
    /// Another planner commands now; this one no longer does.
    StepsBack(Term),
    /// Another planner commands, and this one waits for its end.
    StandsBy(Leader),
    /// The mission is over.
    Finished(Status),
}
