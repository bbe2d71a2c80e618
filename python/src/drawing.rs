//! The picture of a mission that was flown.

use contract::{Brief, Record};
use lockstep::Flown;
use pyo3::prelude::*;
use report::{Picture, PictureStyle};
use scenario::ResolvedScenario;

use crate::boundary::guarded;

/// Decisions of a picture, the last ones of the mission, as in `mission.svg`.
const ROUTE_SHOWN: usize = 2_000;

/// What a picture is drawn from.
#[pyclass(frozen, module = "hopper._native")]
pub struct Drawing {
    brief: Brief,
    world: ResolvedScenario,
    flown: Flown,
    records: Vec<Record>,
}

impl Drawing {
    /// The picture of `flown` over the ground of `world`.
    pub fn new(brief: Brief, world: ResolvedScenario, flown: Flown, mut records: Vec<Record>) -> Self {
        // A patrol may be longer than fits into a picture.
        records.drain(..records.len().saturating_sub(ROUTE_SHOWN));
        Self { brief, world, flown, records }
    }
}

#[pymethods]
impl Drawing {
    /// The picture as SVG.
    fn svg(&self, py: Python<'_>) -> PyResult<String> {
        guarded(|| {
            let Self { brief, world, flown, records } = self;
            let picture = Picture {
                brief,
                terrain: &world.terrain.cells,
                treasures: &world.terrain.treasures,
                map: &flown.map,
                policy: flown.policy.as_deref(),
                route: records,
                outcome: flown.state.status.into(),
                sensing_radius_m: None,
                speeds: &[],
                announced: &flown.routes,
                details: &flown.details,
            };
            py.detach(|| picture.svg_in(PictureStyle::default())).map_err(crate::error)
        })
    }
}
