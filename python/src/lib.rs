//! Hopper's Python module: the native half of the package `hopper`.
//!
//! Arrays cross as buffers: NumPy owns the memory, and this module reads and writes it through the buffer protocol. The
//! package in `hopper/` makes arrays and dictionaries of what is returned here.

mod answer;
mod arrays;
mod batch;
mod boundary;
mod columns;
mod drawing;
mod fly;
mod ground;
mod memory;
mod mission;
mod recorded;
mod resolved;
mod session;
mod solve;
mod task;
mod trial;
mod view;

use pyo3::prelude::*;

pyo3::create_exception!(
    hopper,
    HopperError,
    pyo3::exceptions::PyException,
    "Hopper cannot do what was asked for."
);
pyo3::create_exception!(
    hopper,
    DecideTimeout,
    pyo3::exceptions::PyBaseException,
    "Raised inside decide() when its time is up; the robot holds."
);

/// An error with its message, in the words of the operating system without its numbers.
fn error(error: impl std::fmt::Display) -> PyErr {
    HopperError::new_err(process::Failure::run(error).message)
}

/// The native half of the package `hopper`.
#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("HopperError", module.py().get_type::<HopperError>())?;
    module.add("DecideTimeout", module.py().get_type::<DecideTimeout>())?;
    module.add_class::<view::Brief>()?;
    module.add_class::<view::State>()?;
    module.add_class::<arrays::Map>()?;
    module.add_class::<resolved::Resolved>()?;
    module.add_class::<batch::Batch>()?;
    module.add_class::<session::Session>()?;
    module.add_class::<drawing::Drawing>()?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_function(wrap_pyfunction!(fly::fly, module)?)?;
    module.add_function(wrap_pyfunction!(resolved::read_resolved, module)?)?;
    module.add_function(wrap_pyfunction!(view::read_brief, module)?)?;
    module.add_function(wrap_pyfunction!(view::read_state, module)?)?;
    module.add_function(wrap_pyfunction!(arrays::read_map, module)?)?;
    module.add_function(wrap_pyfunction!(mission::run, module)?)?;
    module.add_function(wrap_pyfunction!(mission::check, module)?)?;
    module.add_function(wrap_pyfunction!(recorded::read_journal, module)?)?;
    module.add_function(wrap_pyfunction!(recorded::read_recording, module)?)?;
    module.add_function(wrap_pyfunction!(solve::solve, module)?)?;
    Ok(())
}
