//! Asks a Python planner, and makes an action of what it answers.

use contract::{Action, Name, Robot, RobotId};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyType};

use crate::arrays::{Arrays, News};
use crate::view::{Brief, State};

/// A planner written in Python, with the arrays that it sees.
pub struct Decider {
    decide: Py<PyAny>,
    arrays: Option<Arrays>,
    /// Whether the log has said that arrays were kept.
    warned: bool,
}

impl Decider {
    /// The method `decide` of `planner`.
    pub fn new(planner: &Bound<'_, PyAny>) -> PyResult<Self> {
        if let Ok(class) = planner.cast::<PyType>() {
            let name = class.name()?;
            return Err(crate::error(format!(
                "a planner needs to be an instance, got the class {name}: write {name}() in its place"
            )));
        }
        let decide = planner.getattr("decide").ok().filter(|decide| decide.is_callable());
        let decide = decide.ok_or_else(|| {
            crate::error(format!("a planner needs a method decide(brief, map, state), got {}", told(planner)))
        })?;
        Ok(Self { decide: decide.unbind(), arrays: None, warned: false })
    }

    /// Brings the arrays up to date.
    pub fn learn(&mut self, py: Python<'_>, news: &News) -> PyResult<()> {
        Arrays::update(&mut self.arrays, py, news).map(drop)
    }

    /// Asks for an action. What is raised is passed on; an answer that is no action for this mission is an error.
    pub fn decide(&mut self, py: Python<'_>, brief: Brief, news: &News, state: State) -> PyResult<Action> {
        let due = state.team.as_ref().map_or(RobotId(0), |team| team.due);
        let robot = brief.brief.robots.at(due);
        let hops = robot.is_some_and(|robot| robot.body.hops());
        let has_vertical =
            robot.and_then(|robot| robot.as_hopper()).is_some_and(|(motion, _)| motion.vertical);
        let map = Arrays::update(&mut self.arrays, py, news)?;
        let answer = self.decide.bind(py).call1((brief, map, state))?;
        if !self.warned && self.arrays.as_ref().is_some_and(|arrays| arrays.are_kept(py)) {
            self.warned = true;
            tracing::warn!(
                "decide keeps arrays of the map: they change with the next decision; keep array.copy() instead"
            );
        }
        // To Python True is 1 and would be a hop to the north.
        let number = if answer.is_instance_of::<PyBool>() { None } else { answer.extract::<u32>().ok() };
        let code = number.and_then(Action::from_code).filter(|action| match action {
            Action::Hold => true,
            Action::Hop(_) => hops,
            Action::Up(_) => has_vertical,
            Action::Step(_) => !hops,
            _ => false,
        });
        let need = if hops { "HOLD or a hop" } else { "HOLD or a step" };
        code.ok_or_else(|| {
            crate::error(format!(
                "decide needs to return a hopper.Action, here {need}, got {}",
                told(&answer)
            ))
        })
    }
}

/// Whether a planner written in Python can command that robot: it announces no routes, so it moves none that goes along them.
pub fn suits(robot: &Robot) -> bool {
    robot.body.along_route().is_none()
}

/// The name of a planner: its attribute `name`, or its class.
pub fn name(planner: &Bound<'_, PyAny>) -> PyResult<Name> {
    let name = match planner.getattr_opt(intern!(planner.py(), "name"))? {
        Some(name) => name
            .extract::<String>()
            .map_err(|_| crate::error(format!("a planner's name needs to be text, got {}", told(&name))))?,
        None => planner.get_type().name()?.extract::<String>()?,
    };
    name.parse().map_err(|error| crate::error(format!("a planner's name: {error}")))
}

/// A value with its type, in a few words.
fn told(value: &Bound<'_, PyAny>) -> String {
    let kind = value.get_type().name().map_or_else(|_| "?".into(), |name| name.to_string());
    let text = value.repr().map_or_else(|_| String::new(), |text| text.to_string());
    let text: String = text.chars().take(80).collect();
    format!("{text} of type {kind}")
}
