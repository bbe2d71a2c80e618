//! Rows as columns: bytes that NumPy reads as an array.

use contract::{Account, Brief, Cell, ObservedMap, Record, Soil};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

/// Columns of one table, by name: NumPy's name of the type, and the bytes.
pub struct Columns<'py>(Bound<'py, PyDict>);

/// A number that a column may hold.
pub trait Number: Copy {
    const KIND: &'static str;
    fn write(self, bytes: &mut Vec<u8>);
}

macro_rules! number {
    ($($kind:literal $type:ty),*) => {$(
        impl Number for $type {
            const KIND: &'static str = $kind;
            fn write(self, bytes: &mut Vec<u8>) {
                bytes.extend(self.to_ne_bytes());
            }
        }
    )*};
}
number!("u1" u8, "u2" u16, "u4" u32, "u8" u64, "i4" i32, "f4" f32, "f8" f64);

impl Number for bool {
    const KIND: &'static str = "?";
    fn write(self, bytes: &mut Vec<u8>) {
        bytes.push(self.into());
    }
}

impl<'py> Columns<'py> {
    /// No columns yet.
    pub fn new(py: Python<'py>) -> Self {
        Self(PyDict::new(py))
    }

    /// Adds a column.
    pub fn add<T: Number>(&self, name: &str, numbers: impl Iterator<Item = T>) -> PyResult<()> {
        let mut bytes = Vec::new();
        numbers.for_each(|number| number.write(&mut bytes));
        self.0.set_item(name, (T::KIND, PyBytes::new(self.0.py(), &bytes)))
    }

    /// What Python gets.
    pub fn into_dict(self) -> Bound<'py, PyDict> {
        self.0
    }
}

/// One row for each decision.
pub fn records<'py>(py: Python<'py>, records: &[Record]) -> PyResult<Bound<'py, PyDict>> {
    let columns = Columns::new(py);
    let each = || records.iter();
    columns.add("decision", each().map(|record| record.decision.0))?;
    columns.add("robot", each().map(|record| record.robot.0))?;
    columns.add("action", each().map(|record| record.action.code() as u8))?;
    columns.add("branch", each().map(|record| record.outcome.branch.code() as u8))?;
    columns.add("from_x", each().map(|record| record.outcome.from.x))?;
    columns.add("from_y", each().map(|record| record.outcome.from.y))?;
    columns.add("x", each().map(|record| record.pose.cell.x))?;
    columns.add("y", each().map(|record| record.pose.cell.y))?;
    columns.add("height_m", each().map(|record| record.pose.height_m))?;
    columns.add("steps", each().map(|record| record.steps))?;
    columns.add("visits", each().map(|record| record.visits))?;
    columns.add("treasures", each().map(|record| record.collected.0.count_ones()))?;
    columns.add("status", each().map(|record| record.status.code() as u8))?;
    columns.add("term", each().map(|record| record.leader.term.0))?;
    columns.add("work", each().map(|record| record.work))?;
    columns.add("cut", each().map(|record| record.cut))?;
    columns.add("is_fallback", each().map(|record| record.origin.is_fallback()))?;
    columns.add("vetoed", each().map(|record| record.vetoed.count() as u8))?;
    columns.add("flights", each().map(|record| record.outcome.flight.flights))?;
    columns.add("range_m", each().map(|record| record.outcome.flight.range_m))?;
    columns.add("apex_height_m", each().map(|record| record.outcome.flight.apex_height_m))?;
    columns.add("flight_time_s", each().map(|record| record.outcome.flight.flight_time_s))?;
    let planning = |record: &Record| record.timing.planning_ended.since_ns(record.timing.planning_started);
    columns.add("planning_ns", each().map(planning))?;
    columns.add("committed_ns", each().map(|record| record.timing.committed.0))?;
    Ok(columns.into_dict())
}

/// The cells of each robot from its start on, in the order of decisions.
pub fn route<'py>(py: Python<'py>, brief: &Brief, records: &[Record]) -> PyResult<Bound<'py, PyDict>> {
    let columns = Columns::new(py);
    let start = (brief.account == Account::Hopper).then_some(brief.robots[0].start.cell);
    let cells = || start.into_iter().chain(records.iter().map(|record| record.pose.cell));
    columns.add("x", cells().map(|Cell { x, .. }| x))?;
    columns.add("y", cells().map(|Cell { y, .. }| y))?;
    let robots = start.map(|_| 0).into_iter().chain(records.iter().map(|record| record.robot.0));
    columns.add("robot", robots)?;
    Ok(columns.into_dict())
}

/// The cells of a map in index order.
pub fn map<'py>(py: Python<'py>, map: &ObservedMap) -> PyResult<Bound<'py, PyDict>> {
    let columns = Columns::new(py);
    let each = || map.cells().iter();
    columns.add("height_m", each().map(|cell| cell.map_or(f64::NAN, |ground| ground.height_m)))?;
    columns.add("seen", each().map(Option::is_some))?;
    columns.add("sand", each().map(|cell| cell.is_some_and(|ground| ground.soil == Soil::Sand)))?;
    columns.add("passable", each().map(|cell| cell.is_some_and(|ground| ground.passable)))?;
    columns.add("visits", (0..map.cells().len()).map(|index| map.visits(index)))?;
    Ok(columns.into_dict())
}
