//! The motion law of P23, section IV: one of four branches is drawn, whatever lies in between.

use contract::Outcome;
use motion::{Domain, Draw};
use scenario::LawRules;

use super::{Hop, Landing, MotionModel, height_m};
use crate::Mission;

/// The law with the parameters of the body.
#[derive(Debug)]
pub struct Law;

impl Law {
    /// Its parameters are those of the body.
    pub fn new(_: &Mission, _: &LawRules) -> Self {
        Self
    }
}

impl MotionModel for Law {
    /// The draw is keyed by (seed, domain, robot, decision) alone, so the same action at the same decision has the same outcome
    /// however often and in whichever process it is executed.
    ///
    /// # Panics
    /// If it departs outside of the terrain, as only in a mission that is over.
    fn hop(&self, hop: &Hop<'_>) -> Landing {
        let Hop { mission, robot, body, decision, from, direction, .. } = *hop;
        let (grid, terrain, law) = (&mission.brief.grid, &mission.terrain, &body.motion);
        let ground = terrain.ground(from).expect("a mission underway stands on its terrain");
        let uniform = Draw::new(mission.seed, Domain::Motion, robot, decision).uniform();
        let branch = motion::transition(law, ground, direction).branch(uniform);
        let rise_m = height_m(terrain, grid.hop(from, direction), from) - ground.height_m;
        Outcome {
            branch,
            from,
            to: motion::landing(grid, from, direction, branch),
            flight: motion::flight(law, grid, ground.soil, rise_m),
        }
        .into()
    }
}
