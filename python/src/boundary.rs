//! The boundary between Rust and Python: what goes wrong on this side of it is an exception there, never a panic.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use pyo3::prelude::*;

/// How often a long computation looks whether the user interrupts it.
const LOOK: Duration = Duration::from_millis(50);

/// Runs what Python calls. A panic is a defect, and raised as an error that `except Exception` catches.
pub fn guarded<T>(call: impl FnOnce() -> PyResult<T>) -> PyResult<T> {
    match catch_unwind(AssertUnwindSafe(call)) {
        Ok(result) => result,
        Err(panic) => Err(crate::error(format!("this is a defect of hopper: {}", message(panic.as_ref())))),
    }
}

/// What a panic says.
pub fn message(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("a panic without a message")
}

/// The contents of a lock. Whoever panicked with it has left nothing half done: what is changed is replaced whole.
pub fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What Python has raised, handed through code that knows nothing of it.
#[derive(Clone, Default)]
pub struct Raised(Arc<Mutex<Option<PyErr>>>);

impl Raised {
    /// Unwinds to [`Raised::catch`] with an exception.
    pub fn raise(&self, error: PyErr) -> ! {
        *locked(&self.0) = Some(error);
        resume_unwind(Box::new("Python has raised an exception"))
    }

    /// Runs `call`, and raises what was raised within it.
    pub fn catch<T>(&self, call: impl FnOnce() -> T) -> PyResult<T> {
        catch_unwind(AssertUnwindSafe(call)).map_err(|panic| {
            let raised = locked(&self.0).take();
            raised.unwrap_or_else(|| resume_unwind(panic))
        })
    }
}

/// Looks now and then whether a signal has come, in a computation that runs without the interpreter.
pub struct Lookout {
    raised: Raised,
    looked: Mutex<Instant>,
}

impl Lookout {
    /// One that raises by `raised`.
    pub fn new(raised: Raised) -> Self {
        Self { raised, looked: Mutex::new(Instant::now()) }
    }

    /// Raises what the handler of a signal raises, such as KeyboardInterrupt, if it is time to look.
    pub fn look(&self) {
        let mut looked = locked(&self.looked);
        if looked.elapsed() < LOOK {
            return;
        }
        *looked = Instant::now();
        drop(looked);
        if let Err(error) = Python::attach(|py| py.check_signals()) {
            self.raised.raise(error);
        }
    }
}
