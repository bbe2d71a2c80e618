//! Where a hop ends, and by which way: one file a motion model.
//!
//! A model answers one question: from a rest position on the true ground, with an aim and keyed random numbers, where does the body come
//! to rest? What planners believe of that is in the brief, and may be wrong.

use std::fmt::Debug;
use std::sync::Arc;

use contract::{Cell, Decision, Detail, Direction, Hopper, Outcome, RobotId, Waypoint};
use scenario::Dynamics;
use terrain::Terrain;

use crate::Mission;

/// Declares the models, one line each: the module, and the struct in it that is made of a mission and the fields of `[truth.dynamics]`.
macro_rules! models {
    ($($module:ident => $model:ident;)+) => {
        $(mod $module;)+

        /// The model of a mission.
        #[must_use]
        pub(crate) fn of(mission: &Mission) -> Arc<dyn MotionModel> {
            match &mission.dynamics {
                $(Dynamics::$model(rules) => Arc::new($module::$model::new(mission, rules)),)+
            }
        }
    };
}

models! {
    law => Law;
    collision => Collision;
    contact => Contact;
}

/// A hop to be made.
#[derive(Clone, Copy, Debug)]
pub struct Hop<'a> {
    /// The mission, with its true ground and the seed of its draws.
    pub mission: &'a Mission,
    /// Who hops.
    pub robot: RobotId,
    /// Its body.
    pub body: &'a Hopper,
    /// The decision, by which random numbers are keyed.
    pub decision: Decision,
    /// Cell of departure.
    pub from: Cell,
    /// Where in it the body rests, (east, north, up), metres; `None` for the middle of the cell.
    pub rest_m: Option<[f64; 3]>,
    /// Where it aims.
    pub direction: Direction,
    /// Whether it is the vertical hop.
    pub is_up: bool,
}

/// Where a hop ends.
#[derive(Clone, Debug, PartialEq)]
pub struct Landing {
    /// What became of it.
    pub outcome: Outcome,
    /// What the model tells beyond that.
    pub detail: Option<Detail>,
}

impl From<Outcome> for Landing {
    fn from(outcome: Outcome) -> Self {
        Self { outcome, detail: None }
    }
}

/// A motion model.
pub trait MotionModel: Debug + Send + Sync {
    /// What becomes of a hop.
    fn hop(&self, hop: &Hop<'_>) -> Landing;

    /// As `hop`, which would have ended on a cell that another robot takes up.
    fn displaced(&self, hop: &Hop<'_>, landing: Landing, is_taken: &dyn Fn(Cell) -> bool) -> Landing {
        let _ = is_taken;
        let rest_m = middle_m(hop.mission, hop.from, hop.from);
        let detail = landing.detail.map(|detail| Detail { rest_m, ..detail });
        Landing { outcome: Outcome { to: hop.from, ..landing.outcome }, detail }
    }
}

/// Height of the ground at `cell`, metres; that of `other` outside of the map.
fn height_m(terrain: &Terrain, cell: Cell, other: Cell) -> f64 {
    terrain.ground(cell).or_else(|| terrain.ground(other)).map_or(0.0, |ground| ground.height_m)
}

/// The middle of `cell` on the ground, (east, north, up), metres; outside of the map at the height of `other`.
fn middle_m(mission: &Mission, cell: Cell, other: Cell) -> [f64; 3] {
    let Waypoint { x_m, y_m } = Waypoint::middle_of(&mission.brief.grid, cell);
    [x_m, y_m, height_m(&mission.terrain, cell, other)]
}
