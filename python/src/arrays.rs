//! The observed map as NumPy arrays that are kept up to date.
//!
//! The arrays are made once a mission. Before each decision the cells that changed since the last one are written into them,
//! and nothing else is: what a decision costs depends on what the landing has revealed, not on the map.

use contract::{Cell, Grid, Ground, ObservedMap, RunId, Soil};
use pyo3::buffer::{Element, PyBuffer};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

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

/// What has been seen so far. All arrays are read-only, indexed [y, x], row 0 southernmost.
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

/// The arrays' memory, which NumPy owns.
pub struct Arrays {
    run: RunId,
    grid: Grid,
    height_m: Shared<f64>,
    gradient: Shared<f64>,
    sand: Shared<u8>,
    passable: Shared<u8>,
    seen: Shared<u8>,
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
            arrays.height_m.set(py, *index, ground.height_m);
            arrays.gradient.set(py, 2 * index, ground.gradient[0]);
            arrays.gradient.set(py, 2 * index + 1, ground.gradient[1]);
            arrays.sand.set(py, *index, u8::from(ground.soil == Soil::Sand));
            arrays.passable.set(py, *index, u8::from(ground.passable));
            arrays.seen.set(py, *index, 1);
            arrays.visits.set(py, *index, *visits);
        }
        Ok(Map {
            height_m: arrays.height_m.view.clone_ref(py),
            gradient: arrays.gradient.view.clone_ref(py),
            sand: arrays.sand.view.clone_ref(py),
            passable: arrays.passable.view.clone_ref(py),
            seen: arrays.seen.view.clone_ref(py),
            visits: arrays.visits.view.clone_ref(py),
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
            height_m: Shared::new(py, &shape, f64::NAN, "f8", "f8")?,
            gradient: Shared::new(py, &[grid.height, grid.width, 2], f64::NAN, "f8", "f8")?,
            sand: Shared::new(py, &shape, 0.0, "u1", "?")?,
            passable: Shared::new(py, &shape, 0.0, "u1", "?")?,
            seen: Shared::new(py, &shape, 0.0, "u1", "?")?,
            visits: Shared::new(py, &shape, 0.0, "u2", "u2")?,
        })
    }
}

/// An array that we write, and others read.
struct Shared<T: Element> {
    /// Read-only, and the one that others get.
    view: Py<PyAny>,
    owner: Py<PyAny>,
    memory: PyBuffer<T>,
    /// References to view and owner that are ours.
    own: [isize; 2],
}

impl<T: Element> Shared<T> {
    /// An array full of `value`, of type `kind` for us and `seen_as` for others.
    fn new(py: Python<'_>, shape: &[u32], value: f64, kind: &str, seen_as: &str) -> PyResult<Self> {
        let shape = PyTuple::new(py, shape)?;
        let owner = py.import("numpy")?.call_method1("full", (shape, value, kind))?;
        let view = owner.call_method1("view", (seen_as,))?;
        let flags = PyDict::new(py);
        flags.set_item("write", false)?;
        view.call_method("setflags", (), Some(&flags))?;
        let memory = PyBuffer::get(&owner)?;
        let mut shared = Self { view: view.unbind(), owner: owner.unbind(), memory, own: [0; 2] };
        shared.own = shared.references(py);
        Ok(shared)
    }

    fn references(&self, py: Python<'_>) -> [isize; 2] {
        // SAFETY: both are alive as long as `self`, and `py` shows that this thread holds the interpreter.
        [&self.view, &self.owner].map(|array| unsafe { pyo3::ffi::Py_REFCNT(array.bind(py).as_ptr()) })
    }

    fn is_kept(&self, py: Python<'_>) -> bool {
        self.references(py).into_iter().zip(self.own).any(|(references, own)| references > own)
    }

    fn set(&self, py: Python<'_>, index: usize, value: T) {
        if let Some(cell) = self.memory.as_mut_slice(py).and_then(|cells| cells.get(index)) {
            cell.set(value);
        }
    }
}
