//! Scenarios: text to a world, or one error.

use scenario::{Scenario, ScenarioCheck, TerrainSource};

use crate::{fixtures, told};

/// Largest side that is built here, cells: a world of the largest takes a second, and no other path.
const SIDE_MAX: u32 = 48;

/// Most hills that are built here.
const HILLS_MAX: usize = 40;

/// Parses, builds the world, and builds it again from its own canonical text.
pub fn read(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let scenario = match Scenario::parse(text, "hostile.toml") {
        Ok(scenario) => scenario,
        Err(error) => return told(&error),
    };
    if !is_small(&scenario) {
        return;
    }
    match scenario.resolve() {
        Err(error) => told(&error),
        Ok(world) => {
            let again = Scenario::parse(&world.resolved, "canonical").expect("its own text is a scenario");
            let again = again.resolve().expect("its own text is a world");
            assert_eq!(
                (again.hash, &again.brief),
                (world.hash, &world.brief),
                "the canonical text is the world"
            );
            told(&ScenarioCheck::of(&world));
        }
    }
}

/// No files are read here, and nothing large is built.
fn is_small(scenario: &Scenario) -> bool {
    let small = |width, height, hills| width <= SIDE_MAX && height <= SIDE_MAX && hills <= HILLS_MAX;
    let built = match &scenario.truth.terrain {
        TerrainSource::Gaussians(hills) => {
            small(hills.width_cells, hills.height_cells, hills.raised_m.len() + hills.lowered_m.len())
        }
        TerrainSource::RandomHills(hills) => {
            small(hills.width_cells, hills.height_cells, hills.hills as usize)
        }
        TerrainSource::Obstacles(field) => small(field.width_cells, field.height_cells, 0),
        TerrainSource::Rocks(plain) => small(plain.width_cells, plain.height_cells, plain.rocks.len()),
        // Always 200 x 200 cells.
        TerrainSource::Passages(_) => true,
        TerrainSource::ElevationFile(_) => false,
    };
    built && scenario.truth.sand.mask_file.is_none()
}

/// One of each kind of generated ground.
#[must_use]
pub fn seeds() -> Vec<Vec<u8>> {
    let rocks = include_str!("../../../scenarios/rocks.toml");
    vec![fixtures::GAUSSIANS.into(), fixtures::RANDOM_HILLS.into(), fixtures::ROVERS.into(), rocks.into()]
}
