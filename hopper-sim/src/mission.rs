//! What the arbiter executes: a brief, the true terrain under it, the seed of its draws.

use std::sync::Arc;

use contract::{
    Account, Brief, Digest, Ground, MotionTable, PriorCell, PriorPage, PriorRequest, RobotId, SpeedPrior,
    Status, TablePage, TableRequest, TruthPage, TruthRequest,
};
use scenario::{Dynamics, Fault, ResolvedScenario};
use terrain::Terrain;

/// The first robot, and the only one where a hopper is alone. Ports of services that belong to no robot are opened with it.
pub const ROBOT: RobotId = RobotId(0);

/// One mission in full, the truth included.
#[derive(Clone, Debug)]
pub struct Mission {
    /// What every process receives; `brief.run` is the run's nonce.
    pub brief: Brief,
    /// The true terrain, on the grid of the brief.
    pub terrain: Arc<Terrain>,
    /// Seed of the keyed draws; never leaves hopper-sim but for the journal's header.
    pub seed: u64,
    /// Where a hop ends; never leaves hopper-sim but for the journal's header.
    pub dynamics: Dynamics,
    /// Where hops end as planners are to believe it; `None` for the four branches.
    pub table: Option<Arc<MotionTable>>,
    /// How robots will fail; never leaves hopper-sim but for the journal's header.
    pub faults: Vec<Fault>,
}

impl Mission {
    /// The mission of a scenario, flown with `seed`.
    #[must_use]
    pub fn of(world: &ResolvedScenario, seed: u64) -> Self {
        let ResolvedScenario { brief, terrain, dynamics, table, faults, .. } = world;
        Self {
            brief: brief.clone(),
            terrain: Arc::clone(terrain),
            seed,
            dynamics: dynamics.clone(),
            table: table.clone(),
            faults: faults.clone(),
        }
    }

    /// A mission under the law, without faults, whose planners believe the four branches.
    #[must_use]
    pub fn under_law(brief: Brief, terrain: impl Into<Arc<Terrain>>, seed: u64) -> Self {
        let dynamics = Dynamics::default();
        Self { brief, terrain: terrain.into(), seed, dynamics, table: None, faults: Vec::new() }
    }

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
        (request.run == run).then(|| {
            let (from, cells) = page_of(&terrain.cells, request.from, cells_max);
            let cells = cells.to_vec();
            TruthPage { run, grid: terrain.grid, from, cells, treasures: terrain.treasures.clone() }
        })
    }

    /// The page of the prior that answers `request`, of at most `cells_max` cells; `None` if another run's is asked for.
    #[must_use]
    pub fn prior_page(&self, request: &PriorRequest, cells_max: usize) -> Option<PriorPage> {
        let (run, terrain) = (self.brief.run, &self.terrain);
        (request.run == run).then(|| {
            let (from, speeds) = page_of(&terrain.prior, request.from, cells_max);
            let ground = &terrain.cells[from as usize..];
            let cell =
                |(&speeds, ground): (&SpeedPrior, &Ground)| PriorCell { speeds, height_m: ground.height_m };
            let cells = speeds.iter().zip(ground).map(cell).collect();
            PriorPage { run, grid: terrain.grid, from, cells }
        })
    }

    /// The page of the motion table that answers `request`, of at most `rows_max` rows; `None` if another run's is asked for, or there is
    /// no table.
    #[must_use]
    pub fn table_page(&self, request: &TableRequest, rows_max: usize) -> Option<TablePage> {
        let (run, table) = (self.brief.run, self.table.as_ref()?);
        (request.run == run).then(|| {
            let (from, rows) = page_of(table.rows(), request.from, rows_max);
            TablePage { run, from, rows: rows.to_vec() }
        })
    }
}

/// A page of at most `cells_max` of `cells`.
fn page_of<T>(cells: &[T], from: u32, cells_max: usize) -> (u32, &[T]) {
    let from = (from as usize).min(cells.len());
    let until = (from + cells_max).min(cells.len());
    (from as u32, &cells[from..until])
}

/// Start of the digest chain of `brief` flown with `seed`.
#[must_use]
pub fn genesis(brief: &Brief, seed: u64) -> Digest {
    Digest::genesis(&brief.scenario_hash, seed, brief.profile, ROBOT)
}

/// How a mission stands before its first command: there already, if it starts at its goal.
#[must_use]
pub fn opening_status(brief: &Brief) -> Status {
    let robot = &brief.robots[0];
    let is_there =
        robot.goal.is_reached_at_start(&brief.grid, robot.start_at, robot.body.along_route().is_some());
    if is_there && brief.account == Account::Hopper { Status::Goal } else { Status::Underway }
}
