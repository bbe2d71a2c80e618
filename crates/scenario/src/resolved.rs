//! The result of resolving a scenario: terrain, brief, canonical text and hash.

use std::sync::Arc;

use contract::{Brief, MotionRow, MotionTable, Name};
use sha2::{Digest as _, Sha256};
use terrain::Terrain;

use crate::{Dynamics, Fault, RobotRules, Scenario, TerrainSource, Warning};

/// A scenario with its terrain built, what depends on it filled in, and checked: with the seed of the hops it
/// determines a mission.
#[derive(Clone, Debug, PartialEq)]
pub struct ResolvedScenario {
    /// The true ground, known to hopper-sim only.
    pub terrain: Arc<Terrain>,
    /// The brief that hopper-sim publishes; `run` is zero until hopper-sim draws one.
    pub brief: Brief,
    /// The robots that will fail. Part of the truth: only hopper-sim knows them. At most one for each robot.
    pub faults: Vec<Fault>,
    /// Where a hop ends. Part of the truth: only hopper-sim knows it.
    pub dynamics: Dynamics,
    /// Where hops end as planners are to believe it; `None` for the four branches.
    pub table: Option<Arc<MotionTable>>,
    /// The planner that each robot names, if it names one.
    pub planners: Vec<Option<Name>>,
    /// Canonical TOML with file paths absolute, and with what depends on the ground filled in; it resolves to the same value. Of
    /// robots, goals, guard and readings a field at its default is left out.
    pub resolved: String,
    /// SHA-256 over what the mission depends on: the canonical text, the bits of every cell, and those of the motion table if there is one.
    ///
    /// Only the last part of a file path is hashed, since the cells stand for the contents: an elevation
    /// model moved to another folder is the same mission, a changed one is another. The decision budget is
    /// left out: it changes no hop. So are the planners that robots name.
    pub hash: [u8; 32],
    /// Warnings; empty for a sound scenario.
    pub warnings: Vec<Warning>,
}

/// The canonical text of a scenario that is resolved.
pub(crate) fn canonical(scenario: &Scenario) -> String {
    toml::to_string(scenario).expect("a scenario is tables, numbers and text")
}

/// What of a scenario its hash covers: all but what changes no outcome, and folders of files.
pub(crate) fn hashed(scenario: &Scenario) -> Scenario {
    let mut portable = scenario.clone();
    portable.limits.decision_budget_ms = 0.0;
    portable.robots.iter_mut().for_each(RobotRules::forget_planner);
    let name_only = |path: &mut std::path::PathBuf| {
        if let Some(name) = path.file_name() {
            *path = name.into();
        }
    };
    if let TerrainSource::ElevationFile(file) = &mut portable.truth.terrain {
        name_only(&mut file.file);
        // Which values are nodata shows in the cells.
        file.nodata = None;
    }
    portable.truth.sand.mask_file.iter_mut().for_each(name_only);
    portable.brief.motion.table.iter_mut().for_each(name_only);
    portable
}

/// See [`ResolvedScenario::hash`].
pub(crate) fn hash(scenario: &Scenario, terrain: &Terrain, table: Option<&MotionTable>) -> [u8; 32] {
    let mut hasher = Sha256::new();
    let text = canonical(&hashed(scenario));
    hasher.update(b"hopper scenario v1");
    hasher.update((text.len() as u64).to_le_bytes());
    hasher.update(text);
    hasher.update(terrain.grid.width.to_le_bytes());
    hasher.update(terrain.grid.height.to_le_bytes());
    for ground in &terrain.cells {
        for value in [ground.height_m, ground.gradient[0], ground.gradient[1]] {
            hasher.update(value.to_bits().to_le_bytes());
        }
        hasher.update([ground.soil as u8, u8::from(ground.passable)]);
        if let Some(speed) = ground.speed {
            hasher.update([speed as u8]);
        }
        if let Some(reading) = ground.reading {
            hasher.update([0x80 | reading as u8]);
        }
    }
    for probability in terrain.prior.iter().flat_map(|prior| prior.probabilities()) {
        hasher.update(probability.to_bits().to_le_bytes());
    }
    for landing in table.iter().flat_map(|table| table.rows()).flat_map(MotionRow::all) {
        hasher.update([landing.forward.cast_unsigned(), landing.left.cast_unsigned()]);
        hasher.update(landing.probability.to_bits().to_le_bytes());
    }
    hasher.finalize().into()
}
