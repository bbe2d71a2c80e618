//! Many missions side by side, for learners: the dynamics of hopper-sim without processes, maps or journals.
//!
//! A step looks everything up that a cell determines (what is seen from there, how hops scatter, what the guard vetoes),
//! and draws as hopper-sim does. The digest is computed on request, by hopper-sim's own dynamics over the actions taken, so
//! it also proves the tables.

use std::sync::{Arc, Mutex};

use contract::{Action, Brief, Cell, Direction, Leg, Status};
use hopper_sim::Mission;
use pyo3::buffer::{Element, PyBuffer};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use scenario::Dynamics;

use crate::boundary::{guarded, locked};
use crate::columns::Columns;
use crate::ground::{Ground, PLANES};
use crate::mission::{self, Need};
use crate::resolved::Resolved;
use crate::task::Task;
use crate::trial::Trial;

/// Numbers beside the planes: x, y, cells to the goal along x and y, share of the steps left.
const NUMBERS: usize = 5;

/// Most missions of a batch.
const MISSIONS_MAX: usize = 1 << 20;

/// Missions over one scenario, each at its own decision.
#[pyclass(frozen, module = "hopper._native")]
pub struct Batch {
    resolved: Py<Resolved>,
    ground: Arc<Ground>,
    /// Cells of a window's side; 0 for the whole map.
    window: usize,
    trials: Mutex<Vec<Trial>>,
}

/// Seed and actions of a mission, which make it again; `None` if it has not begun.
type Past = Option<(u64, Vec<u8>)>;

/// The scenario of a batch, and the past of each of its missions.
type Snapshot = (String, Vec<Past>);

#[pymethods]
impl Batch {
    /// `count` missions of a scenario, not begun.
    #[new]
    fn new(resolved: Bound<'_, Resolved>, count: usize, window: usize) -> PyResult<Self> {
        guarded(|| {
            let world = &resolved.get().0;
            if Task::of(&world.brief) != Task::Reach {
                return Err(mission::no_environment(world.brief.scenario, Need::Hopper));
            }
            if window != 0 && window.is_multiple_of(2) || window > 255 {
                return Err(crate::error(format!(
                    "an environment needs an odd window of 1 to 255 cells, or 0 for the whole map, got {window}"
                )));
            }
            let cells = world.brief.grid.cells();
            let most = (1 << 28) / cells.max(1);
            if count == 0 || count > MISSIONS_MAX.min(most) {
                return Err(crate::error(format!(
                    "an environment of {cells} cells needs 1 to {} missions, got {count}",
                    MISSIONS_MAX.min(most)
                )));
            }
            let (brief, terrain) = (world.brief.clone(), Arc::clone(&world.terrain));
            let dynamics = world.dynamics.clone();
            if matches!(dynamics, Dynamics::Contact(_)) {
                let message =
                    "an environment flies under law or collision, got contact: fly it with hopper.fly";
                return Err(crate::error(message.to_owned()));
            }
            let mission = Mission { brief, terrain, seed: 0, dynamics, table: None, faults: Vec::new() };
            let ground = Arc::new(Ground::new(mission));
            let trials = Mutex::new(vec![Trial::new(&ground); count]);
            Ok(Self { resolved: resolved.unbind(), ground, window, trials })
        })
    }

    /// Rows and columns of a plane.
    #[getter]
    fn shape(&self) -> (usize, usize) {
        self.ground.shape(self.window)
    }

    /// Columns, rows, steps until the mission is a deadlock.
    #[getter]
    fn limits(&self) -> (u32, u32, u64) {
        let Brief { grid, limits, .. } = self.ground.brief();
        (grid.width, grid.height, limits.steps_max)
    }

    /// How many actions there are: hold and four hops, and four vertical hops where the scenario has them.
    #[getter]
    fn actions(&self) -> i64 {
        self.ground.actions()
    }

    /// How many missions there are.
    fn __len__(&self) -> usize {
        locked(&self.trials).len()
    }

    /// Begins every mission that has a seed here; the others go on.
    fn reset(&self, seeds: Vec<Option<u64>>) -> PyResult<()> {
        guarded(|| {
            let mut trials = locked(&self.trials);
            if seeds.len() != trials.len() {
                let (need, got) = (trials.len(), seeds.len());
                return Err(crate::error(format!("{need} missions need a seed each, got {got} seeds")));
            }
            for (trial, seed) in trials.iter_mut().zip(seeds) {
                if let Some(seed) = seed {
                    trial.begin(&self.ground, seed);
                }
            }
            Ok(())
        })
    }

    /// Takes one action in every mission, or none at all. One that is over begins anew instead, with the next seed, and pays
    /// nothing. `rewards` are 64-bit floats, `ends` bytes: 1 for terminated, 2 for truncated.
    fn step(
        &self,
        py: Python<'_>,
        actions: &Bound<'_, PyAny>,
        rewards: &Bound<'_, PyAny>,
        ends: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        guarded(|| {
            // Asking for a buffer may run Python, which may come here again: not with the lock.
            let actions = PyBuffer::<i64>::get(actions)?;
            let (rewards, ends) = (PyBuffer::<f64>::get(rewards)?, PyBuffer::<u8>::get(ends)?);
            let mut trials = locked(&self.trials);
            let count = trials.len();
            let (actions, rewards, ends) =
                (cells(&actions, count)?, writable(py, &rewards, count)?, writable(py, &ends, count)?);
            let actions = actions.as_slice(py).ok_or_else(not_contiguous)?;
            if let Some(trial) = trials.iter().position(|trial| !trial.begun) {
                return Err(crate::error(format!("mission {trial} has not begun: call reset() first")));
            }
            let actions: Vec<Action> =
                actions.iter().map(|number| self.ground.action(number.get())).collect::<PyResult<_>>()?;
            for (index, (trial, action)) in trials.iter_mut().zip(actions).enumerate() {
                if trial.status.is_over() {
                    trial.begin_next(&self.ground);
                    rewards[index].set(0.0);
                    ends[index].set(0);
                    continue;
                }
                rewards[index].set(trial.act(&self.ground, action));
                ends[index].set(match trial.status {
                    Status::Underway => 0,
                    Status::Deadlock => 2,
                    _ => 1,
                });
            }
            Ok(())
        })
    }

    /// Writes what every mission shows into arrays of 32-bit floats: planes, and numbers.
    fn observe(&self, py: Python<'_>, planes: &Bound<'_, PyAny>, numbers: &Bound<'_, PyAny>) -> PyResult<()> {
        guarded(|| {
            let (planes, numbers) = (PyBuffer::<f32>::get(planes)?, PyBuffer::<f32>::get(numbers)?);
            let trials = locked(&self.trials);
            let (rows, columns) = self.shape();
            let size = PLANES * rows * columns;
            let planes = writable(py, &planes, trials.len() * size)?;
            let numbers = writable(py, &numbers, trials.len() * NUMBERS)?;
            let mut window = vec![0.0; size];
            for ((trial, planes), numbers) in
                trials.iter().zip(planes.chunks_exact(size)).zip(numbers.chunks_exact(NUMBERS))
            {
                trial.window(&self.ground, self.window, &mut window);
                planes.iter().zip(&window).for_each(|(to, from)| to.set(*from));
                let values = trial.numbers(self.ground.leg());
                numbers.iter().zip(values).for_each(|(to, value)| to.set(value));
            }
            Ok(())
        })
    }

    /// Seed, steps, treasures collected and status of a mission.
    fn told(&self, index: usize) -> PyResult<(u64, u64, u32, String)> {
        let trials = locked(&self.trials);
        let trial = trials.get(index).ok_or_else(|| no_mission(index, trials.len()))?;
        Ok((trial.seed, trial.steps, trial.collected.count(), trial.status.to_string()))
    }

    /// The digest of a mission so far, that of the live mission with its seed and its actions.
    fn digest(&self, index: usize) -> PyResult<String> {
        guarded(|| {
            let trials = locked(&self.trials);
            let trial = trials.get(index).ok_or_else(|| no_mission(index, trials.len()))?;
            let digest = trial.digest(&self.ground);
            digest.map(|digest| digest.to_string()).ok_or_else(|| {
                crate::error("the digest's mission and the environment's differ: this is a defect of hopper")
            })
        })
    }

    /// What a picture of a mission shows: columns of all cells, of the route, of start and goal, and of treasures in sight.
    fn scene<'py>(&self, py: Python<'py>, index: usize) -> PyResult<Bound<'py, PyDict>> {
        guarded(|| {
            let trials = locked(&self.trials);
            let trial = trials.get(index).ok_or_else(|| no_mission(index, trials.len()))?;
            let (rows, columns) = self.ground.shape(0);
            let mut planes = vec![0.0; PLANES * rows * columns];
            trial.window(&self.ground, 0, &mut planes);
            let Leg { start, goal, .. } = *self.ground.leg();
            let table = Columns::new(py);
            table.add("planes", planes.into_iter())?;
            pairs(&table, "route", trial.route.iter().copied())?;
            pairs(&table, "ends", [start, goal].into_iter())?;
            pairs(&table, "treasures", trial.treasures_in_sight(&self.ground))?;
            Ok(table.into_dict())
        })
    }

    /// What makes the missions again: see `restore`.
    fn snapshot(&self) -> Snapshot {
        let past = |trial: &Trial| {
            let numbers = || trial.actions.iter().map(|action| number(*action)).collect();
            trial.begun.then(|| (trial.seed, numbers()))
        };
        (self.identity(), locked(&self.trials).iter().map(past).collect())
    }

    /// Takes the missions of a snapshot, or none of them.
    fn restore(&self, snapshot: Snapshot) -> PyResult<()> {
        guarded(|| {
            let (identity, pasts) = snapshot;
            if identity != self.identity() {
                return Err(crate::error(format!(
                    "a snapshot needs to be of this scenario, {}, got one of {identity}",
                    self.identity()
                )));
            }
            let count = locked(&self.trials).len();
            if pasts.len() != count {
                let got = pasts.len();
                return Err(crate::error(format!(
                    "a snapshot of {count} missions is needed, got one of {got}"
                )));
            }
            let trials = pasts.iter().map(|past| self.again(past)).collect::<PyResult<Vec<_>>>()?;
            *locked(&self.trials) = trials;
            Ok(())
        })
    }

    fn __copy__(&self, py: Python<'_>) -> Self {
        Self {
            resolved: self.resolved.clone_ref(py),
            ground: Arc::clone(&self.ground),
            window: self.window,
            trials: Mutex::new(locked(&self.trials).clone()),
        }
    }

    fn __deepcopy__(&self, py: Python<'_>, _memo: &Bound<'_, PyAny>) -> Self {
        self.__copy__(py)
    }

    #[allow(clippy::type_complexity, reason = "what pickle asks for")]
    fn __reduce__<'py>(
        slf: &Bound<'py, Self>,
    ) -> (Bound<'py, PyAny>, (Py<Resolved>, usize, usize), Snapshot) {
        let batch = slf.get();
        let snapshot = batch.snapshot();
        let arguments = (batch.resolved.clone_ref(slf.py()), snapshot.1.len(), batch.window);
        (slf.get_type().into_any(), arguments, snapshot)
    }

    fn __setstate__(&self, snapshot: Snapshot) -> PyResult<()> {
        self.restore(snapshot)
    }
}

impl Batch {
    /// Of the scenario, with its profile: missions of one are of no use to another.
    fn identity(&self) -> String {
        self.resolved.get().identity()
    }

    /// The mission that went like this.
    fn again(&self, past: &Past) -> PyResult<Trial> {
        let mut trial = Trial::new(&self.ground);
        let Some((seed, codes)) = past else { return Ok(trial) };
        trial.begin(&self.ground, *seed);
        for &code in codes {
            let action = self.ground.action(i64::from(code))?;
            if trial.status.is_over() {
                return Err(crate::error("a snapshot needs actions until the mission's end, got more"));
            }
            trial.act(&self.ground, action);
        }
        Ok(trial)
    }
}

/// The number of an action in an environment: its code, and 5 to 8 for vertical hops north, east, south, west.
fn number(action: Action) -> u8 {
    match action {
        Action::Up(direction) => 5 + direction as u8,
        other => other.code() as u8,
    }
}

impl Ground {
    /// How many actions there are.
    fn actions(&self) -> i64 {
        if self.leg().motion.vertical { 9 } else { 5 }
    }

    /// The action of that number.
    fn action(&self, number: i64) -> PyResult<Action> {
        match number {
            0 => Ok(Action::Hold),
            1..=4 => Ok(Action::Hop(Direction::ALL[number as usize - 1])),
            5..=8 if self.actions() > 5 => Ok(Action::Up(Direction::ALL[number as usize - 5])),
            _ => {
                Err(crate::error(format!("an action needs to be 0 to {}, got {number}", self.actions() - 1)))
            }
        }
    }
}

fn no_mission(index: usize, count: usize) -> PyErr {
    crate::error(format!("a mission needs to be 0 to {}, got {index}", count - 1))
}

/// Adds a column of cells, x and y of each in turn.
fn pairs(table: &Columns<'_>, name: &str, cells: impl Iterator<Item = Cell>) -> PyResult<()> {
    table.add(name, cells.flat_map(|cell| [cell.x, cell.y]))
}

/// The memory of an array of `count` numbers.
fn cells<T: Element>(buffer: &PyBuffer<T>, count: usize) -> PyResult<&PyBuffer<T>> {
    if buffer.item_count() == count {
        return Ok(buffer);
    }
    Err(crate::error(format!("an array needs {count} numbers, got {}", buffer.item_count())))
}

/// The memory of an array of `count` numbers, to be written.
fn writable<'a, T: Element>(
    py: Python<'a>,
    buffer: &'a PyBuffer<T>,
    count: usize,
) -> PyResult<&'a [std::cell::Cell<T>]> {
    cells(buffer, count)?.as_mut_slice(py).ok_or_else(not_contiguous)
}

fn not_contiguous() -> PyErr {
    crate::error("arrays need to be contiguous, and writable where they are written")
}
