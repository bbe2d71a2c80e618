//! A scenario that is read once, for every mission over it.
//!
//! Missions that begin later, copies and pickles have the scenario as it was read: its file may change or vanish, and the
//! working folder may be another.

use std::path::{Path, PathBuf};

use contract::Profile;
use pyo3::prelude::*;
use scenario::{BUILT_IN, Overrides, ResolvedScenario, Scenario};

use crate::boundary::guarded;

/// A scenario with its ground.
#[pyclass(frozen, module = "hopper._native")]
pub struct Resolved(pub ResolvedScenario);

#[pymethods]
impl Resolved {
    /// The scenario that `hopper run` takes with the same options: `scenario` is a built-in name or a file, by default
    /// `hard`, or one that fits the elevation model `dem`.
    #[new]
    fn new(
        py: Python<'_>,
        scenario: Option<String>,
        profile: Option<String>,
        dem: Option<PathBuf>,
        nodata: Option<Vec<f64>>,
    ) -> PyResult<Self> {
        guarded(|| {
            let profile: Option<Profile> =
                profile.as_deref().map(str::parse).transpose().map_err(crate::error)?;
            let overrides = Overrides { profile, dem, nodata, ..Overrides::default() };
            let world = py.detach(|| read(scenario.as_deref(), &overrides)?.resolve().map_err(said));
            world.map(Self).map_err(|error| crate::error(in_python(&error)))
        })
    }

    /// What tells missions of this scenario from those of another: name, profile and hash.
    #[getter]
    pub fn identity(&self) -> String {
        let Self(ResolvedScenario { hash, brief, .. }) = self;
        let hash: String = hash.iter().take(8).map(|byte| format!("{byte:02x}")).collect();
        format!("{} ({}, {hash})", brief.scenario, brief.profile)
    }

    /// What is probably not as intended, a sentence each.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.0.warnings.iter().map(|warning| in_python(&warning.to_string())).collect()
    }

    fn __copy__(slf: Bound<'_, Self>) -> Bound<'_, Self> {
        slf
    }

    fn __deepcopy__<'py>(slf: Bound<'py, Self>, _memo: &Bound<'_, PyAny>) -> Bound<'py, Self> {
        slf
    }

    #[allow(clippy::type_complexity, reason = "what pickle asks for")]
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String, String))> {
        let read = py.import("hopper._native")?.getattr("read_resolved")?;
        Ok((read, (self.0.resolved.clone(), self.identity())))
    }
}

/// Reads a pickled scenario from its canonical text.
///
/// # Errors
/// If files that it names are missing or have changed.
#[pyfunction]
pub fn read_resolved(py: Python<'_>, text: &str, identity: String) -> PyResult<Resolved> {
    guarded(|| {
        let origin = format!("the scenario {identity}");
        let world = py.detach(|| Scenario::parse(text, &origin).and_then(|scenario| scenario.resolve()));
        let resolved = Resolved(world.map_err(|error| crate::error(in_python(&error.to_string())))?);
        let got = resolved.identity();
        if got == identity {
            return Ok(resolved);
        }
        Err(crate::error(format!(
            "the scenario needs to be {identity} as before, got {got}: a file that it names has changed"
        )))
    })
}

/// The scenario that is asked for, not yet resolved.
fn read(scenario: Option<&str>, overrides: &Overrides) -> Result<Scenario, String> {
    if let (None, Some(dem)) = (scenario, &overrides.dem) {
        let fitted = scenario::fitted_with(dem, overrides.nodata.as_deref()).map_err(said)?;
        return Ok(fitted.scenario.with(&Overrides { dem: None, ..overrides.clone() }));
    }
    let selector = scenario.unwrap_or("hard");
    if !BUILT_IN.iter().any(|(name, _)| *name == selector) {
        check_file(Path::new(selector))?;
    }
    Ok(scenario::load(selector).map_err(said)?.with(overrides))
}

/// Refuses pipes and devices, which would be waited for, or read for ever. What does not exist, and folders, are refused
/// by name later.
fn check_file(path: &Path) -> Result<(), String> {
    match std::fs::metadata(path) {
        Ok(data) if !data.is_file() && !data.is_dir() => {
            Err(format!("a scenario needs to be a file, got a pipe or a device, {}", path.display()))
        }
        _ => Ok(()),
    }
}

fn said(error: impl std::fmt::Display) -> String {
    error.to_string()
}

/// A message with the command's options as Python's arguments: `--dem FILE` as `dem=FILE`.
fn in_python(message: &str) -> String {
    let mut message = format!(" {message}");
    for (option, argument) in [
        (" --nodata none", " nodata=[]"),
        (" --nodata needs", " nodata= needs"),
        (" --nodata ", " nodata="),
        (" --dem FILE", " dem=FILE"),
        (" --dem: need ", " dem= needs "),
        (" --dem", " dem="),
    ] {
        message = message.replace(option, argument);
    }
    message.split_off(1)
}
