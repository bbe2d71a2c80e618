//! The robots of a past mission, as hopper-sim had them after each of its decisions.

use std::sync::Arc;

use contract::{Action, Brief, Record, Route, State, Team};
use hopper_sim::{JournalReader, Mission, RobotTeam};
use node::Failure;
use scenario::ResolvedScenario;
use terrain::Terrain;

/// All robots of a mission that is not a single hopper's, folded again from its records.
pub struct Robots {
    terrain: Arc<Terrain>,
    robots: RobotTeam,
    /// Whether a record came whose robot was not due: the journal is of a build with other turns. The robots stay as they were.
    is_lost: bool,
}

impl Robots {
    /// The robots before the first decision; `None` where there is a single hopper.
    #[must_use]
    pub fn at_start(world: &ResolvedScenario, brief: &Brief) -> Option<Self> {
        if !brief.has_team() {
            return None;
        }
        let robots = RobotTeam::new(&Mission { brief: brief.clone(), ..Mission::of(world, 0) });
        Some(Self { terrain: Arc::clone(&world.terrain), robots, is_lost: false })
    }

    /// The robots of the journal's mission before its first decision; `None` where there is a
    /// single hopper.
    ///
    /// # Errors
    /// If the ground of its scenario is not at hand.
    pub fn of_journal(journal: &JournalReader) -> Result<Option<Self>, Failure> {
        if !journal.header().brief.has_team() {
            return Ok(None);
        }
        let world = journal.world()?;
        Ok(Self::at_start(&world, &world.brief))
    }

    /// Folds in the next record. `routes` are at least those that were announced until then.
    pub fn record(&mut self, record: &Record, routes: &[Route]) {
        self.is_lost |= self.robots.due() != Some(record.robot);
        if self.is_lost {
            return;
        }
        if let Action::Announce(id) = record.action {
            let route = routes.iter().rev().find(|route| route.id() == id);
            route.into_iter().for_each(|route| self.robots.recall_route(route.clone()));
        }
        self.robots.recall(&self.terrain, record);
    }

    /// All of them, as published with `state`, to which the last record led.
    #[must_use]
    pub fn team(&self, state: &State) -> Team {
        self.robots.team(state)
    }
}
