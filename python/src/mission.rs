//! Whole missions in lockstep.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::{Arc, Mutex, PoisonError};

use contract::{Brief, MonotonicNs, Name, Profile, Record, RunId, Task};
use hopper_sim::Mission;
use lockstep::{Flown, PlannerSchedule};
use planner::{Budget, Plan, PlanStatus, Planner, PlannerError, Situation};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use report::SummaryBuilder;
use scenario::{Overrides, ResolvedScenario};

use crate::answer::{self, Decider};
use crate::arrays::Watch;
use crate::columns;
use crate::view::State;

/// The run of missions flown here; nothing depends on it.
pub const RUN: RunId = RunId(1);

/// The scenario of that name or file, resolved.
pub fn world(scenario: &str, profile: Option<&str>) -> PyResult<ResolvedScenario> {
    let profile: Option<Profile> = profile.map(str::parse).transpose().map_err(crate::error)?;
    let scenario = scenario::load(scenario).map_err(crate::error)?;
    let overrides = Overrides { profile, ..Overrides::default() };
    scenario.with(&overrides).resolve().map_err(crate::error)
}

/// A Python planner in the caller's thread. What it raises ends the mission.
struct Local {
    name: Name,
    decider: Decider,
    watch: Watch,
    raised: Raised,
}

impl Planner for Local {
    fn name(&self) -> Name {
        self.name
    }

    fn suits(&self, _: Task) -> bool {
        true
    }

    fn plan(&mut self, situation: &Situation<'_>, _: &Budget) -> Plan {
        let Situation { brief, map, state, team, .. } = *situation;
        let news = self.watch.news(map);
        let state = State { state: *state, team: team.cloned() };
        match Python::attach(|py| self.decider.decide(py, brief, &news, state)) {
            Ok(action) => Plan::at_once(action, PlanStatus::Solved),
            Err(error) => raise(&self.raised, error),
        }
    }
}

/// The planner that a mission is flown with: a name, or an object with a method `decide`.
#[derive(FromPyObject)]
pub enum Chosen<'py> {
    /// A built-in one.
    Named(String),
    /// One of the user's.
    Own(Bound<'py, PyAny>),
}

/// Summary as JSON, rows and columns of the grid, and columns of rows, route and map.
pub type Answer<'py> = (String, (u32, u32), Bound<'py, PyDict>, Bound<'py, PyDict>, Bound<'py, PyDict>);

/// Flies a mission to its end; see `hopper.run`.
#[pyfunction]
pub fn run<'py>(
    py: Python<'py>,
    scenario: &str,
    planner: Chosen<'py>,
    seed: u64,
    profile: Option<&str>,
) -> PyResult<Answer<'py>> {
    let world = world(scenario, profile)?;
    let brief = Brief { run: RUN, ..world.brief };
    let vehicles = world.vehicles();
    let own = world.planners;
    let usual = planner::assigned(&brief, &vehicles, None, &own)
        .map_err(|error| crate::error(error.in_scenario(brief.scenario)))?;
    let mission = Mission { brief, terrain: world.terrain, seed, fleet: world.fleet };
    let (flown, records) = match planner {
        Chosen::Named(name) => {
            let name: Name = name.parse().map_err(crate::error)?;
            let planners = planner::assigned(&brief, &vehicles, Some(name), &own);
            let planners = planners.map_err(|error| crate::error(error.in_scenario(brief.scenario)))?;
            py.detach(move || {
                let mut records = Vec::new();
                let schedule = PlannerSchedule::of_robots(&planners);
                let flown = lockstep::fly(mission, &schedule, &mut node::Node::now, &mut |record| {
                    records.push(*record)
                });
                flown.map(|flown| (flown, records)).map_err(crate::error)
            })?
        }
        Chosen::Own(_) if brief.mixed.is_some() => return Err(unfit()),
        Chosen::Own(planner) => fly_own(&planner, mission, &usual)?,
    };
    told(py, &brief, seed, &flown, &records)
}

/// That one planner cannot command robots with tasks of their own.
pub fn unfit() -> PyErr {
    crate::error(
        "a mission whose robots have tasks of their own needs named planners; hopper.fly commands one of its robots",
    )
}

/// What Python gets of a mission that was flown.
pub fn told<'py>(
    py: Python<'py>,
    brief: &Brief,
    seed: u64,
    flown: &Flown,
    records: &[Record],
) -> PyResult<Answer<'py>> {
    let mut summary = SummaryBuilder::new(brief, seed);
    records.iter().for_each(|record| summary.record(record));
    let mut summary = summary.build(&flown.state, flown.team.as_ref(), &flown.refusals);
    summary.coverage = Some(flown.map.coverage());
    let json = serde_json::to_string(&summary).map_err(crate::error)?;
    let (rows, route) = (columns::records(py, records)?, columns::route(py, brief, records)?);
    Ok((json, (brief.grid.height, brief.grid.width), rows, route, columns::map(py, &flown.map)?))
}

/// Holds a planner to the law; see `hopper.check`.
#[pyfunction]
pub fn check(make: &Bound<'_, PyAny>) -> PyResult<()> {
    let raised = Arc::new(Mutex::new(None));
    let local = || {
        let made = make.call0().and_then(|planner| {
            let (name, decider) = (answer::name(&planner)?, Decider::new(&planner)?);
            Ok(Local { name, decider, watch: Watch::default(), raised: Arc::clone(&raised) })
        });
        made.unwrap_or_else(|error| raise(&raised, error))
    };
    match catch_unwind(AssertUnwindSafe(|| planner::conformance::check(local))) {
        Ok(checked) => checked.map_err(crate::error),
        Err(panic) => Err(taken(&raised).unwrap_or_else(|| resume_unwind(panic))),
    }
}

/// What Python has raised, handed through code that knows nothing of it.
type Raised = Arc<Mutex<Option<PyErr>>>;

fn raise(raised: &Raised, error: PyErr) -> ! {
    *raised.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
    resume_unwind(Box::new("Python has raised an exception"))
}

fn taken(raised: &Raised) -> Option<PyErr> {
    raised.lock().unwrap_or_else(PoisonError::into_inner).take()
}

/// Who commands if the planner `own` is of the user's: all robots, but not a hopper's helicopters, which keep their `usual` ones.
pub fn schedule_of(own: Name, task: Task, usual: &[Name]) -> PlannerSchedule {
    if task != Task::Accompany {
        return PlannerSchedule::single(own);
    }
    let names: Vec<Name> = std::iter::once(own).chain(usual.iter().skip(1).copied()).collect();
    PlannerSchedule::of_robots(&names)
}

fn fly_own(planner: &Bound<'_, PyAny>, mission: Mission, usual: &[Name]) -> PyResult<(Flown, Vec<Record>)> {
    let name = answer::name(planner)?;
    let raised = Arc::new(Mutex::new(None));
    let mut local = Some(Local {
        name,
        decider: Decider::new(planner)?,
        watch: Watch::default(),
        raised: Arc::clone(&raised),
    });
    let mut make = |asked: Name, _: &Mission| -> Result<Box<dyn Planner>, PlannerError> {
        if asked != name {
            return planner::algorithm(asked.as_str());
        }
        let local = local.take().ok_or(PlannerError::UnknownAlgorithm { got: name.to_string() })?;
        Ok(Box::new(local))
    };
    let mut records = Vec::new();
    let mut clock = || -> MonotonicNs { node::Node::now() };
    let flown = catch_unwind(AssertUnwindSafe(|| {
        let schedule = schedule_of(name, mission.brief.task(), usual);
        lockstep::fly_with(mission, &schedule, &mut make, &mut clock, &mut |record| records.push(*record))
    }));
    match flown {
        Ok(flown) => Ok((flown.map_err(crate::error)?, records)),
        Err(panic) => Err(taken(&raised).unwrap_or_else(|| resume_unwind(panic))),
    }
}
