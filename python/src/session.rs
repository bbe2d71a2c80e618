//! A mission in lockstep that waits for its actions: the caller decides where a planner would.
//!
//! The mission flies in a thread of its own, whose planner sends each question to the caller and waits for the answer.

use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

use contract::{Action, Brief, Name, Record, Task, Team};
use hopper_sim::Mission;
use lockstep::Flown;
use planner::{Budget, Plan, PlanStatus, Planner, PlannerError, Situation};
use pyo3::prelude::*;

use crate::arrays::{Arrays, Map, News, Watch};
use crate::mission::{Answer, RUN, schedule_of, told, world};
use crate::view;

/// A decision that is due.
struct Question {
    brief: Brief,
    news: News,
    state: contract::State,
    team: Option<Team>,
}

/// The planner that asks.
struct Asker {
    name: Name,
    questions: Sender<Question>,
    answers: Receiver<Action>,
    watch: Watch,
}

impl Planner for Asker {
    fn name(&self) -> Name {
        self.name
    }

    fn suits(&self, _: Task) -> bool {
        true
    }

    fn plan(&mut self, situation: &Situation<'_>, _: &Budget) -> Plan {
        let Situation { brief, map, state, team, .. } = *situation;
        let news = self.watch.news(map);
        let asked = self.questions.send(Question { brief: *brief, news, state: *state, team: team.cloned() });
        match asked.ok().and_then(|()| self.answers.recv().ok()) {
            Some(action) => Plan::at_once(action, PlanStatus::Solved),
            None => std::panic::resume_unwind(Box::new("the caller has dropped the mission")),
        }
    }
}

type Ended = Result<(Flown, Vec<Record>), PlannerError>;

/// A mission that waits for its actions.
#[pyclass(unsendable, module = "hopper")]
pub struct Session {
    brief: Brief,
    seed: u64,
    /// `None` once the mission is over or dropped.
    ports: Option<(Receiver<Question>, Sender<Action>)>,
    flight: Option<JoinHandle<Ended>>,
    arrays: Option<Arrays>,
    awaits: bool,
}

#[pymethods]
impl Session {
    /// Begins a mission.
    #[new]
    fn new(scenario: &str, profile: Option<&str>, seed: u64) -> PyResult<Self> {
        let world = world(scenario, profile)?;
        let brief = Brief { run: RUN, ..world.brief };
        if brief.mixed.is_some() {
            return Err(crate::mission::unfit());
        }
        let usual = planner::assigned(&brief, &world.vehicles(), None, &world.planners);
        let usual = usual.map_err(|error| crate::error(error.in_scenario(brief.scenario)))?;
        let mission = Mission { brief, terrain: world.terrain, seed, fleet: world.fleet };
        let (questions, inbox) = channel();
        let (outbox, answers) = channel();
        let name: Name = "session".parse().map_err(crate::error)?;
        let asker = Asker { name, questions, answers, watch: Watch::default() };
        let flight =
            std::thread::Builder::new().name("mission".into()).spawn(move || fly(mission, asker, &usual))?;
        Ok(Self {
            brief,
            seed,
            ports: Some((inbox, outbox)),
            flight: Some(flight),
            arrays: None,
            awaits: false,
        })
    }

    /// The decision that is due; None once the mission is over.
    fn next(&mut self, py: Python<'_>) -> PyResult<Option<(view::Brief, Map, view::State)>> {
        let Some((inbox, outbox)) = self.ports.take() else { return Ok(None) };
        let (inbox, question) = py.detach(move || {
            let question = inbox.recv();
            (inbox, question)
        });
        let Ok(Question { brief, news, state, team }) = question else { return Ok(None) };
        self.ports = Some((inbox, outbox));
        self.awaits = true;
        let map = Arrays::update(&mut self.arrays, py, &news)?;
        Ok(Some((view::Brief(brief), map, view::State { state, team })))
    }

    /// Takes the action for the decision that is due.
    fn act(&mut self, action: u32) -> PyResult<()> {
        let is_hopper = self.brief.is_of_hopper();
        let action = Action::from_code(action).filter(|action| match action {
            Action::Hold => true,
            Action::Hop(_) => is_hopper,
            _ => !is_hopper,
        });
        let Some(action) = action else {
            return Err(crate::error("an action needs to be one of this mission's robots"));
        };
        match self.ports.as_ref().filter(|_| self.awaits) {
            Some((_, outbox)) => outbox.send(action).map_err(crate::error)?,
            None => return Err(crate::error("a mission needs to await an action: call next() first")),
        }
        self.awaits = false;
        Ok(())
    }

    /// What `hopper.run` returns, once the mission is over.
    fn ended<'py>(&mut self, py: Python<'py>) -> PyResult<Answer<'py>> {
        let flight = self.flight.take().filter(|_| self.ports.is_none());
        let flight = flight.ok_or_else(|| crate::error("a mission needs to be over, and ends once"))?;
        let ended = py.detach(move || flight.join());
        let ended = ended.map_err(|_| crate::error("the mission was dropped"))?;
        let (flown, records) = ended.map_err(crate::error)?;
        told(py, &self.brief, self.seed, &flown, &records)
    }
}

fn fly(mission: Mission, asker: Asker, usual: &[Name]) -> Ended {
    let own = asker.name;
    let schedule = schedule_of(own, mission.brief.task(), usual);
    let mut asker = Some(asker);
    let mut make = |name: Name, _: &Mission| -> Result<Box<dyn Planner>, PlannerError> {
        if name != own {
            return planner::algorithm(name.as_str());
        }
        let asker = asker.take().ok_or(PlannerError::UnknownAlgorithm { got: name.to_string() })?;
        Ok(Box::new(asker))
    };
    let mut records = Vec::new();
    let flown = lockstep::fly_with(mission, &schedule, &mut make, &mut node::Node::now, &mut |record| {
        records.push(*record);
    })?;
    Ok((flown, records))
}
