//! Whole missions in lockstep.

use contract::{Brief, MonotonicNs, Name, Record, Robot, RunId};
use hopper_sim::Mission;
use lockstep::{Flown, PlannerSchedule};
use planner::{Budget, Plan, PlanStatus, Planner, PlannerError, Situation};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use report::SummaryBuilder;
use scenario::{ResolvedScenario, RobotRules, Scenario};

use crate::answer::{self, Decider};
use crate::arrays::Watch;
use crate::boundary::{Lookout, Raised, guarded};
use crate::columns;
use crate::drawing::Drawing;
use crate::resolved::Resolved;
use crate::task::Task;
use crate::view::{self, State};

/// The run of missions flown here; nothing depends on it.
pub const RUN: RunId = RunId(1);

/// What an environment is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// A hopper that is alone, with one goal.
    Hopper,
    /// Rovers that cover ground.
    Rovers,
}

impl Need {
    /// The names of the built-in scenarios that have it.
    fn built_in(self) -> String {
        let has = |(name, text): &(&str, &str)| {
            let Ok(scenario) = Scenario::parse(text, name) else { return false };
            match self {
                Need::Hopper => scenario.robots.is_empty() && scenario.brief.goals.is_empty(),
                Need::Rovers => {
                    let covers = |rules: &RobotRules| matches!(rules, RobotRules::Rover(_));
                    !scenario.robots.is_empty() && scenario.robots.iter().all(covers)
                }
            }
        };
        scenario::BUILT_IN.into_iter().filter(has).map(|(name, _)| name).collect::<Vec<_>>().join(", ")
    }
}

/// That there is no environment of this kind for a scenario, and which environments there are.
pub fn no_environment(scenario: Name, need: Need) -> PyErr {
    let need = match need {
        Need::Hopper => "a hopper alone with one goal",
        Need::Rovers => "rovers that cover ground",
    };
    crate::error(format!(
        "this environment needs a mission of {need}, got scenario {scenario}. hopper.gym has {}; hopper.pettingzoo has {}. \
         hopper.run flies every scenario with a planner of yours or its own",
        Need::Hopper.built_in(),
        Need::Rovers.built_in(),
    ))
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

    fn suits(&self, robot: &Robot) -> bool {
        answer::suits(robot)
    }

    fn plan(&mut self, situation: &Situation<'_>, _: &Budget) -> Plan {
        let Situation { map, state, team, .. } = *situation;
        let news = self.watch.news(map);
        let state = State { state: *state, team: team.cloned() };
        let brief = view::Brief::of(situation);
        match Python::attach(|py| self.decider.decide(py, brief, &news, state)) {
            Ok(action) => Plan::at_once(action, PlanStatus::Solved),
            Err(error) => self.raised.raise(error),
        }
    }
}

/// Summary as JSON, rows and columns of the grid, columns of rows, route and map, and what draws the mission.
pub type Answer<'py> =
    (String, (u32, u32), Bound<'py, PyDict>, Bound<'py, PyDict>, Bound<'py, PyDict>, Drawing);

/// Flies a mission to its end; see `hopper.run`. A `planner` is a built-in name, an object with a method `decide`, or None for the
/// scenario's own.
#[pyfunction]
pub fn run<'py>(
    py: Python<'py>,
    resolved: &Bound<'py, Resolved>,
    planner: Option<Bound<'py, PyAny>>,
    seed: u64,
) -> PyResult<Answer<'py>> {
    guarded(|| {
        let world = &resolved.get().0;
        let brief = Brief { run: RUN, ..world.brief.clone() };
        let raised = Raised::default();
        let (mut own, mut given) = (None, None);
        if let Some(planner) = &planner {
            match planner.extract::<String>() {
                Ok(name) => given = Some(name.parse::<Name>().map_err(crate::error)?),
                Err(_) => {
                    let (decider, name) = (Decider::new(planner)?, answer::name(planner)?);
                    let raised = raised.clone();
                    own = Some(Local { name, decider, watch: Watch::default(), raised });
                }
            }
        }
        let assigned = planner::assigned(&brief, given, &world.planners)
            .map_err(|error| crate::error(error.in_scenario(brief.scenario)))?;
        let schedule = match &own {
            Some(own) => schedule_of(own.name, &brief, &assigned)?,
            None => PlannerSchedule::of_robots(&assigned),
        };
        let mission = Mission { brief: brief.clone(), ..Mission::of(world, seed) };
        let lookout = Lookout::new(raised.clone());
        let (flown, records) = py.detach(|| {
            let mut make = |asked: Name, mission: &Mission| -> Result<Box<dyn Planner>, PlannerError> {
                match own.take_if(|own| own.name == asked) {
                    Some(own) => Ok(Box::new(own)),
                    None => lockstep::algorithm(asked, mission),
                }
            };
            let mut records = Vec::new();
            let mut clock = || -> MonotonicNs { node::Node::now() };
            let mut observe = |record: &Record| {
                records.push(*record);
                lookout.look();
            };
            let flown = raised
                .catch(|| lockstep::fly_with(mission, &schedule, &mut make, &mut clock, &mut observe))?
                .map_err(|error| refused(&brief, &error))?;
            Ok::<_, PyErr>((flown, records))
        })?;
        told(py, world, &brief, seed, flown, records)
    })
}

/// Why a mission was not flown.
pub fn refused(brief: &Brief, error: &PlannerError) -> PyErr {
    let text = error.to_string();
    let scenario = format!("scenario {}", brief.scenario);
    if text.contains(&scenario) { crate::error(text) } else { crate::error(format!("{scenario}: {text}")) }
}

/// What Python gets of a mission that was flown.
pub fn told<'py>(
    py: Python<'py>,
    world: &ResolvedScenario,
    brief: &Brief,
    seed: u64,
    flown: Flown,
    records: Vec<Record>,
) -> PyResult<Answer<'py>> {
    let mut summary = SummaryBuilder::new(brief, seed);
    records.iter().for_each(|record| summary.record(record));
    let mut summary = summary.build(&flown.state, flown.team.as_ref(), &flown.refusals);
    summary.coverage = Some(flown.map.coverage());
    let json = serde_json::to_string(&summary).map_err(crate::error)?;
    let (rows, route) = (columns::records(py, &records)?, columns::route(py, brief, &records)?);
    let cells = columns::map(py, &flown.map)?;
    let shape = (brief.grid.height, brief.grid.width);
    let drawing = Drawing::new(brief.clone(), world.clone(), flown, records);
    Ok((json, shape, rows, route, cells, drawing))
}

/// Holds a planner to the law; see `hopper.check`.
#[pyfunction]
pub fn check(make: &Bound<'_, PyAny>) -> PyResult<()> {
    guarded(|| {
        let raised = Raised::default();
        let local = || {
            let made = make.call0().and_then(|planner| {
                let (decider, name) = (Decider::new(&planner)?, answer::name(&planner)?);
                Ok(Local { name, decider, watch: Watch::default(), raised: raised.clone() })
            });
            made.unwrap_or_else(|error| raised.raise(error))
        };
        raised.catch(|| planner::conformance::check(local))?.map_err(crate::error)
    })
}

/// Who commands if the planner `own` is of the user's: all robots, but not a hopper's helicopters, which keep their `usual` ones.
///
/// # Errors
/// If one planner cannot command all robots.
pub fn schedule_of(own: Name, brief: &Brief, usual: &[Name]) -> PyResult<PlannerSchedule> {
    let unsuited = |need: &str| {
        let scenario = brief.scenario;
        Err(crate::error(format!("scenario {scenario} needs {need}, got {own}, a planner of your own")))
    };
    match Task::of(brief) {
        Task::Mixed => unsuited(
            "the names of built-in planners for robots with tasks of their own; hopper.fly commands its hoppers and the rovers \
             that cover ground, one at a time",
        ),
        Task::Scout => unsuited("the names of built-in planners for robots that go along announced routes"),
        Task::Accompany if usual.iter().skip(1).any(|name| *name == own) => {
            unsuited("planners of different names for hopper and helicopters")
        }
        Task::Accompany => {
            let names: Vec<Name> = std::iter::once(own).chain(usual.iter().skip(1).copied()).collect();
            Ok(PlannerSchedule::of_robots(&names))
        }
        Task::Reach | Task::Patrol | Task::Cover => Ok(PlannerSchedule::single(own)),
    }
}
