//! The certified solver on worlds of arrays.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use solver::{Effort, GridWorld, Kind, Leaving, Rules, Site, Soil, SolveStatus, Solver, policy};

use crate::columns::Columns;

/// What a world of arrays is made of; see `hopper.World`. Arrays are in index order.
#[derive(FromPyObject)]
pub struct World {
    shape: (usize, usize),
    payoff: Vec<f64>,
    slope_east: Vec<f64>,
    slope_north: Vec<f64>,
    soil: Vec<u8>,
    goal: Vec<bool>,
    lost: Vec<bool>,
    /// (intended, stuck, sideways, wait) of each.
    soils: Vec<(f64, f64, f64, f64)>,
    discount: f64,
    loss: f64,
    leaving: String,
}

impl World {
    fn grid_world(&self) -> PyResult<GridWorld> {
        let leaving = match self.leaving.as_str() {
            "stays" => Leaving::Stays,
            "loses" => Leaving::Loses,
            got => {
                return Err(crate::error(format!("leaving needs to be \"stays\" or \"loses\", got {got:?}")));
            }
        };
        let soil = |&(intended, stuck, sideways, wait): &(f64, f64, f64, f64)| Soil {
            intended,
            stuck,
            sideways,
            wait,
        };
        let soils: Vec<Soil> = self.soils.iter().map(soil).collect();
        let (height, width) = self.shape;
        let count = soils.len();
        let rules = Rules { discount: self.discount, loss: self.loss, leaving, soils };
        let mut world = GridWorld::new(width, height, rules).map_err(crate::error)?;
        for node in 0..world.nodes() {
            let kind = match (self.lost[node], self.goal[node]) {
                (true, _) => Kind::Lost,
                (false, true) => Kind::Goal,
                (false, false) => Kind::Free,
            };
            let numbers = [self.payoff[node], self.slope_east[node], self.slope_north[node]];
            if usize::from(self.soil[node]) >= count || numbers.iter().any(|number| !number.is_finite()) {
                return Err(crate::error(format!(
                    "a cell needs a finite payoff, finite slopes, and one of {count} soils, got {numbers:?} and soil {} at \
                     [{}, {}]",
                    self.soil[node],
                    node / width,
                    node % width
                )));
            }
            let [payoff, slope_east, slope_north] = numbers;
            world.set(node, Site { kind, payoff, slope_east, slope_north, soil: self.soil[node] });
        }
        Ok(world)
    }
}

/// Solves a world; see `hopper.solve`. Returns columns of values and policy, the bound, and whether it was reached.
#[pyfunction]
pub fn solve<'py>(
    py: Python<'py>,
    world: World,
    error_max: f64,
    sweeps_max: Option<u64>,
) -> PyResult<(Bound<'py, PyDict>, f64, bool, u64)> {
    let world = world.grid_world()?;
    let effort = Effort { error_max, sweeps_max: sweeps_max.unwrap_or(u64::MAX) };
    let (values, solution) = py.detach(|| {
        let mut solver = Solver::new();
        let solution = solver.solve(&world, &effort);
        (solver.values().to_vec(), solution)
    });
    let hop = |node| policy::hop(&world, &values, node, 0.0).map_or(0, |hop| hop as u8 + 1);
    let columns = Columns::new(py);
    columns.add("policy", (0..world.nodes()).map(hop))?;
    columns.add("values", values.iter().copied())?;
    let is_solved = solution.status == SolveStatus::Solved;
    Ok((columns.into_dict(), solution.certificate.error_bound, is_solved, solution.sweeps))
}
