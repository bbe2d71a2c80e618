//! What the arbiter executes: a brief, the true terrain under it, the seed of its draws.

use contract::{Brief, Digest, RobotId, Status, TruthPage, TruthRequest};
use terrain::Terrain;

/// The only robot of a hopper mission.
pub const ROBOT: RobotId = RobotId(0);

/// One mission in full, the truth included.
#[derive(Clone, Debug)]
pub struct Mission {
    /// What everyone is told; `brief.run` is the run's nonce.
    pub brief: Brief,
    /// The true terrain, on the grid of the brief.
    pub terrain: Terrain,
    /// Seed of the keyed draws; never leaves hopper-sim but for the journal's header.
    pub seed: u64,
}

impl Mission {
    /// Start of the digest chain.
    #[must_use]
    pub fn genesis(&self) -> Digest {
        genesis(&self.brief, self.seed)
    }

    /// The page of the truth that answers `request`, of at most `cells_max` cells; `None` if another run's is
    /// asked for.
    #[must_use]
    pub fn truth_page(&self, request: &TruthRequest, cells_max: usize) -> Option<TruthPage> {
        let (run, terrain) = (self.brief.run, &self.terrain);
        let from = (request.from as usize).min(terrain.cells.len());
        let until = (from + cells_max).min(terrain.cells.len());
        (request.run == run).then(|| TruthPage {
            run,
            grid: terrain.grid,
            from: from as u32,
            cells: terrain.cells[from..until].to_vec(),
            treasures: terrain.treasures.clone(),
        })
    }
}

/// Start of the digest chain of `brief` flown with `seed`.
#[must_use]
pub fn genesis(brief: &Brief, seed: u64) -> Digest {
    Digest::genesis(&brief.scenario_hash, seed, brief.profile, ROBOT)
}

/// How a mission stands before its first command: there already, if it starts at its goal.
#[must_use]
pub fn opening_status(brief: &Brief) -> Status {
    if brief.start == brief.goal && brief.patrol.is_none() { Status::Goal } else { Status::Underway }
}
