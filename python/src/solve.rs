//! The certified solver on worlds of arrays.

use pyo3::buffer::{Element, PyBuffer};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use solver::{Effort, GridWorld, Kind, Leaving, Rules, Site, Soil, SolveStatus, Solver, policy};

use crate::boundary::{Lookout, Raised, guarded};
use crate::columns::Columns;

/// What a world of arrays is made of; see `hopper.World`. Arrays are in index order, of 64-bit floats but for goal, lost and soil,
/// of bytes.
#[derive(FromPyObject)]
pub struct World<'py> {
    shape: (usize, usize),
    payoff: Bound<'py, PyAny>,
    slope_east: Bound<'py, PyAny>,
    slope_north: Bound<'py, PyAny>,
    soil: Bound<'py, PyAny>,
    goal: Bound<'py, PyAny>,
    lost: Bound<'py, PyAny>,
    /// (intended, stuck, sideways, wait) of each.
    soils: Vec<(f64, f64, f64, f64)>,
    discount: f64,
    loss: f64,
    leaving: String,
}

impl World<'_> {
    fn grid_world(&self, py: Python<'_>) -> PyResult<GridWorld> {
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
        let nodes = world.nodes();
        let (payoff, slope_east, slope_north): (Vec<f64>, Vec<f64>, Vec<f64>) = (
            numbers(py, "payoff", &self.payoff, nodes)?,
            numbers(py, "slope_east", &self.slope_east, nodes)?,
            numbers(py, "slope_north", &self.slope_north, nodes)?,
        );
        let (soil, goal, lost): (Vec<u8>, Vec<u8>, Vec<u8>) = (
            numbers(py, "soil", &self.soil, nodes)?,
            numbers(py, "goal", &self.goal, nodes)?,
            numbers(py, "lost", &self.lost, nodes)?,
        );
        for node in 0..nodes {
            let kind = match (lost[node] != 0, goal[node] != 0) {
                (true, _) => Kind::Lost,
                (false, true) => Kind::Goal,
                (false, false) => Kind::Free,
            };
            let numbers = [payoff[node], slope_east[node], slope_north[node]];
            if usize::from(soil[node]) >= count || numbers.iter().any(|number| !number.is_finite()) {
                return Err(crate::error(format!(
                    "a cell needs a finite payoff, finite slopes, and one of {count} soils, got {numbers:?} and soil {} at \
                     [{}, {}]",
                    soil[node],
                    node / width,
                    node % width
                )));
            }
            let [payoff, slope_east, slope_north] = numbers;
            world.set(node, Site { kind, payoff, slope_east, slope_north, soil: soil[node] });
        }
        if !world.afterstate_max().is_finite() {
            return Err(crate::error(format!(
                "payoffs need to be so small that their sum for ever, payoff / (1 - discount), is a number, got payoffs up to {:e} \
                 and discount {}",
                payoff.iter().fold(0.0, |most: f64, payoff| most.max(payoff.abs())),
                self.discount
            )));
        }
        Ok(world)
    }
}

/// The numbers of an array.
fn numbers<T: Element + Copy>(
    py: Python<'_>,
    name: &str,
    array: &Bound<'_, PyAny>,
    count: usize,
) -> PyResult<Vec<T>> {
    let numbers = PyBuffer::<T>::get(array)?.to_vec(py)?;
    if numbers.len() == count {
        return Ok(numbers);
    }
    Err(crate::error(format!("{name} needs {count} numbers, got {}", numbers.len())))
}

/// Solves a world; see `hopper.solve`. Returns columns of values and policy, the bound, whether it is the one asked for, and the
/// sweeps.
#[pyfunction]
pub fn solve<'py>(
    py: Python<'py>,
    world: World<'py>,
    error_max: f64,
    sweeps_max: Option<u64>,
) -> PyResult<(Bound<'py, PyDict>, f64, bool, u64)> {
    guarded(|| {
        let world = world.grid_world(py)?;
        let effort = Effort { error_max, sweeps_max: sweeps_max.unwrap_or(u64::MAX) };
        let raised = Raised::default();
        let lookout = Lookout::new(raised.clone());
        let (values, solution) = py.detach(|| {
            raised.catch(|| {
                let mut solver = Solver::new();
                let solution = solver.solve_with(&world, &effort, &|| lookout.look());
                (solver.values().to_vec(), solution)
            })
        })?;
        let hop = |node| policy::hop(&world, &values, node, 0.0).map_or(0, |hop| hop as u8 + 1);
        let columns = Columns::new(py);
        columns.add("policy", (0..world.nodes()).map(hop))?;
        columns.add("values", values.iter().copied())?;
        let is_solved = solution.status == SolveStatus::Solved;
        Ok((columns.into_dict(), solution.certificate.error_bound, is_solved, solution.sweeps))
    })
}
