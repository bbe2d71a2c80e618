//! The world of a journal's mission, made again from its header.

use contract::Brief;
use scenario::ResolvedScenario;

use super::disagreement::{Disagreement, agree};
use super::{Fault, JournalError, JournalHeader, JournalReader, Storage};

/// Why a mission has no world here.
#[derive(Clone, Debug)]
pub(super) enum NoWorld {
    /// The files that its ground comes from are missing, or have other contents.
    NotAtHand(String),
    /// The header contradicts itself: its scenario has another brief, other robots, or another hash.
    Contradicts(Disagreement),
}

impl From<Disagreement> for NoWorld {
    fn from(disagreement: Disagreement) -> Self {
        Self::Contradicts(disagreement)
    }
}

impl JournalHeader {
    /// Resolves the scenario again and compares what follows from it with the header: all of the brief but the run, and how robots fail.
    pub(super) fn world(&self) -> Result<ResolvedScenario, NoWorld> {
        let scenario = self.scenario()?;
        let names_files = scenario.names_files();
        let world = match scenario.resolve() {
            Ok(world) => world,
            Err(error) if names_files => return Err(NoWorld::NotAtHand(error.to_string())),
            Err(error) => {
                let (field, need) = ("resolved".into(), "a scenario that can be flown".into());
                return Err(Disagreement { field, need, got: error.to_string() }.into());
            }
        };
        let need = JournalHeader::new(&world, self.seed);
        let has_other_hash = need.brief.scenario_hash != self.brief.scenario_hash;
        let other_contents = || NoWorld::NotAtHand("its files have other contents than they had".into());
        let differs =
            need.brief.grid != self.brief.grid || need.brief.motion_table() != self.brief.motion_table();
        if has_other_hash && names_files && differs {
            return Err(other_contents());
        }
        let Brief { run, scenario_hash, .. } = self.brief;
        agree("brief", &Brief { run, scenario_hash, ..need.brief.clone() }, &self.brief)?;
        agree("dynamics", &need.dynamics, &self.dynamics)?;
        agree("faults", &need.faults, &self.faults)?;
        match has_other_hash {
            false => Ok(world),
            true if names_files => Err(other_contents()),
            true => {
                let field = "brief.scenario_hash".into();
                Err(Disagreement { field, need: need.hash(), got: self.hash() }.into())
            }
        }
    }
}

impl<S: Storage> JournalReader<S> {
    /// The world that the mission was flown in, resolved again from its scenario.
    ///
    /// # Errors
    /// [`JournalError::NoGround`] if a file that its ground comes from is missing or has other contents,
    /// [`JournalError::NotSound`] if the header contradicts its scenario.
    pub fn world(&self) -> Result<ResolvedScenario, JournalError> {
        let path = || self.path().into();
        self.header().world().map_err(|error| match error {
            NoWorld::NotAtHand(reason) => JournalError::NoGround { path: path(), reason },
            NoWorld::Contradicts(disagreement) => {
                let fault = Fault::of_header(disagreement);
                JournalError::NotSound { path: path(), faults: vec![fault.to_string()] }
            }
        })
    }
}
