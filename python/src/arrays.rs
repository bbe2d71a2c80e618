//! The observed map as NumPy arrays that are kept up to date.
//!
//! The arrays are made once a mission. Before each decision the cells that changed since the last one are written into them,
//! and nothing else is: what a decision costs depends on what the landing has revealed, not on the map.

use std::marker::PhantomData;

use contract::{Cell, Grid, Ground, ObservedMap, RunId, Soil};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::memory::{Memory, Number};

/// What changed in the map since it was last looked at.
pub struct News {
    run: RunId,
    grid: Grid,
    /// Whether the cells are all that is known, and not what changed.
    is_all: bool,
    cells: Vec<(usize, Ground, u16)>,
    treasures: Vec<Cell>,
    fingerprint: u64,
}

/// Which state of a map was last looked at.
#[derive(Default)]
pub struct Watch(Option<(RunId, Grid, u64)>);

impl Watch {
    /// The changes since the last call.
    pub fn news(&mut self, map: &ObservedMap) -> News {
        let known = self.0.filter(|(run, grid, _)| (*run, *grid) == (map.run, map.grid));
        let changed = known.and_then(|(_, _, fingerprint)| map.changed_since(fingerprint));
        let cell = |index: usize| Some((index, map.cells()[index]?, map.visits(index)));
        let cells = match changed {
            Some(changed) => changed.iter().filter_map(|&index| cell(index as usize)).collect(),
            None => (0..map.grid.cells()).filter_map(cell).collect(),
        };
        self.0 = Some((map.run, map.grid, map.observation()));
        News {
            run: map.run,
            grid: map.grid,
            is_all: changed.is_none(),
            cells,
            treasures: map.treasures().to_vec(),
            fingerprint: map.observation(),
        }
    }
}

/// What has been seen so far. All arrays are read-only, indexed [y, x], row 0 southernmost; those of a copy are its own.
#[pyclass(frozen, get_all, module = "hopper")]
pub struct Map {
    /// Height above the datum, metres; NaN where unseen.
    pub height_m: Py<PyAny>,
    /// Gradient (d/dx, d/dy), metres per metre, in the last axis; NaN where unseen.
    pub gradient: Py<PyAny>,
    /// Whether a seen cell is sand.
    pub sand: Py<PyAny>,
    /// Whether a seen cell is passable.
    pub passable: Py<PyAny>,
    /// Whether a cell has been seen.
    pub seen: Py<PyAny>,
    /// How often rovers have entered a cell.
    pub visits: Py<PyAny>,
    /// Cells (x, y) of treasures that have been seen and not yet collected.
    pub treasures: Vec<(i32, i32)>,
    /// Equal for equal maps.
    pub fingerprint: u64,
}

#[pymethods]
impl Map {
    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let (height, width): (usize, usize) = self.seen.getattr(py, "shape")?.extract(py)?;
        let seen: u64 = self.seen.call_method0(py, "sum")?.extract(py)?;
        Ok(format!(
            "<Map of {width} x {height} cells, {seen} seen, {} treasures in sight>",
            self.treasures.len()
        ))
    }

    /// The map of this moment: its arrays are its own.
    fn __copy__(&self, py: Python<'_>) -> PyResult<Self> {
        let copied = |array: &Py<PyAny>| array.call_method0(py, "copy");
        Ok(Self {
            height_m: copied(&self.height_m)?,
            gradient: copied(&self.gradient)?,
            sand: copied(&self.sand)?,
            passable: copied(&self.passable)?,
            seen: copied(&self.seen)?,
            visits: copied(&self.visits)?,
            treasures: self.treasures.clone(),
            fingerprint: self.fingerprint,
        })
    }

    fn __deepcopy__(&self, py: Python<'_>, _memo: &Bound<'_, PyAny>) -> PyResult<Self> {
        self.__copy__(py)
    }

    #[allow(clippy::type_complexity, reason = "what pickle asks for")]
    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, ([Py<PyAny>; 6], Vec<(i32, i32)>, u64))> {
        let Self { height_m, gradient, sand, passable, seen, visits, treasures, fingerprint } =
            self.__copy__(py)?;
        let arrays = [height_m, gradient, sand, passable, seen, visits];
        Ok((py.import("hopper._native")?.getattr("read_map")?, (arrays, treasures, fingerprint)))
    }
}

/// Reads a pickled map.
#[pyfunction]
pub fn read_map(arrays: [Py<PyAny>; 6], treasures: Vec<(i32, i32)>, fingerprint: u64) -> Map {
    let [height_m, gradient, sand, passable, seen, visits] = arrays;
    Map { height_m, gradient, sand, passable, seen, visits, treasures, fingerprint }
}

/// The arrays' memory.
pub struct Arrays {
    run: RunId,
    grid: Grid,
    height_m: Shared<f64>,
    gradient: Shared<f64>,
    sand: Shared<bool>,
    passable: Shared<bool>,
    seen: Shared<bool>,
    visits: Shared<u16>,
}

impl Arrays {
    /// Writes `news` into `arrays`, which are made anew for another mission, and returns the map for a planner.
    pub fn update(arrays: &mut Option<Self>, py: Python<'_>, news: &News) -> PyResult<Map> {
        let fresh = arrays.take().filter(|arrays| {
            // One that has seen less is another map: cells are never forgotten.
            (arrays.run, arrays.grid) == (news.run, news.grid) && !news.is_all
        });
        let arrays = match fresh {
            Some(known) => arrays.insert(known),
            None => arrays.insert(Self::new(py, news.run, news.grid)?),
        };
        for (index, ground, visits) in &news.cells {
            arrays.height_m.set(*index, ground.height_m);
            arrays.gradient.set(2 * index, ground.gradient[0]);
            arrays.gradient.set(2 * index + 1, ground.gradient[1]);
            arrays.sand.set(*index, ground.soil == Soil::Sand);
            arrays.passable.set(*index, ground.passable);
            arrays.seen.set(*index, true);
            arrays.visits.set(*index, *visits);
        }
        Ok(Map {
            height_m: arrays.height_m.view(py)?,
            gradient: arrays.gradient.view(py)?,
            sand: arrays.sand.view(py)?,
            passable: arrays.passable.view(py)?,
            seen: arrays.seen.view(py)?,
            visits: arrays.visits.view(py)?,
            treasures: news.treasures.iter().map(|cell| (cell.x, cell.y)).collect(),
            fingerprint: news.fingerprint,
        })
    }

    /// Whether anybody holds an array, or a part of one, after the map that had them is gone.
    pub fn are_kept(&self, py: Python<'_>) -> bool {
        self.height_m.is_kept(py)
            || self.gradient.is_kept(py)
            || self.sand.is_kept(py)
            || self.passable.is_kept(py)
            || self.seen.is_kept(py)
            || self.visits.is_kept(py)
    }

    fn new(py: Python<'_>, run: RunId, grid: Grid) -> PyResult<Self> {
        let shape = [grid.height, grid.width];
        Ok(Self {
            run,
            grid,
            height_m: Shared::new(py, &shape, f64::NAN)?,
            gradient: Shared::new(py, &[grid.height, grid.width, 2], f64::NAN)?,
            sand: Shared::new(py, &shape, false)?,
            passable: Shared::new(py, &shape, false)?,
            seen: Shared::new(py, &shape, false)?,
            visits: Shared::new(py, &shape, 0)?,
        })
    }
}

/// Cells that we write, and others read.
struct Shared<T> {
    memory: Py<Memory>,
    shape: Vec<u32>,
    number: PhantomData<T>,
}

impl<T: Number> Shared<T> {
    /// Cells full of `value`.
    fn new(py: Python<'_>, shape: &[u32], value: T) -> PyResult<Self> {
        let cells = shape.iter().map(|side| *side as usize).product();
        let memory = Py::new(py, value.memory(cells))?;
        Ok(Self { memory, shape: shape.to_vec(), number: PhantomData })
    }

    /// A read-only array over the cells. Each decision gets its own, so that nobody changes the shape of another's.
    fn view(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let flat = py.import("numpy")?.call_method1("frombuffer", (&self.memory, T::KIND))?;
        Ok(flat.call_method1("reshape", (PyTuple::new(py, &self.shape)?,))?.unbind())
    }

    /// Whether an array over the cells is left.
    fn is_kept(&self, py: Python<'_>) -> bool {
        // SAFETY: the memory is alive as long as `self`, and `py` shows that this thread holds the interpreter.
        unsafe { pyo3::ffi::Py_REFCNT(self.memory.bind(py).as_ptr()) > 1 }
    }

    fn set(&self, index: usize, value: T) {
        value.write(self.memory.get(), index);
    }
}
