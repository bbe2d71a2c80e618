//! What happens to a pilot.

use contract::{
    Brief, Heartbeat, MapPage, MapPatch, MonotonicNs, PriorPage, Refusal, RoutePage, State, TablePage, Team,
};

use crate::Plan;

/// What a pilot hears.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant, reason = "an event is made, taken, and gone")]
pub enum Event {
    /// The brief; one of a new run drops all that was known.
    Brief(Brief),
    /// The state.
    State(State),
    /// All robots as of a state.
    Team(Team),
    /// What a landing changed in the observed map.
    Patch(MapPatch),
    /// A page of the observed map that was asked for; after all patches that were there when it came.
    Page(MapPage),
    /// A page of the prior that was asked for.
    Prior(PriorPage),
    /// A page of the motion table.
    Table(TablePage),
    /// A route that was asked for.
    Route(RoutePage),
    /// A message about the map was malformed.
    Refused(Refusal),
    /// A sign of life.
    Heartbeat(Heartbeat),
    /// The operating system knows of no process with this number.
    Gone(u32),
    /// This planner shall claim the next term of each robot that it serves and does not lead, once, as with `--takeover`.
    HandOver,
    /// The plan that was asked for, with the moments at which planning began and ended.
    Planned(Plan, MonotonicNs, MonotonicNs),
    /// Time passes.
    Tick,
}
