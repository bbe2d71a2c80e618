//! A mission in lockstep that waits for its actions: the caller decides where a planner would.
//!
//! The mission flies in a thread of its own, whose planner sends each question to the caller and waits for the answer.

use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::thread::JoinHandle;

use contract::{Action, Brief, Goal, Name, Record, Robot, Team};
use hopper_sim::Mission;
use lockstep::{Flown, PlannerSchedule};
use planner::{Budget, Plan, PlanStatus, Planner, PlannerError, Situation};
use pyo3::prelude::*;
use scenario::ResolvedScenario;

use crate::arrays::{Arrays, Map, News, Watch};
use crate::boundary::guarded;
use crate::mission::{Answer, Need, RUN, no_environment, refused, told};
use crate::resolved::Resolved;
use crate::task::Task;
use crate::view;

/// A decision that is due.
struct Question {
    brief: view::Brief,
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

    fn suits(&self, robot: &Robot) -> bool {
        matches!(robot.goal, Goal::Cover(_))
    }

    fn plan(&mut self, situation: &Situation<'_>, _: &Budget) -> Plan {
        let Situation { map, state, team, .. } = *situation;
        let brief = view::Brief::of(situation);
        let news = self.watch.news(map);
        let asked = self.questions.send(Question { brief, news, state: *state, team: team.cloned() });
        match asked.ok().and_then(|()| self.answers.recv().ok()) {
            Some(action) => Plan::at_once(action, PlanStatus::Solved),
            None => std::panic::resume_unwind(Box::new("the caller has dropped the mission")),
        }
    }
}

type Ended = Result<(Flown, Vec<Record>), PlannerError>;

/// A mission of rovers that waits for their actions.
#[pyclass(frozen, module = "hopper._native")]
pub struct Session {
    world: ResolvedScenario,
    brief: Brief,
    seed: u64,
    /// The process that the mission's thread is in.
    pid: u32,
    turn: Mutex<Turn>,
}

/// Whose turn it is: the mission's, or the caller's.
struct Turn {
    /// `None` once the mission is over.
    ports: Option<(Receiver<Question>, Sender<Action>)>,
    flight: Option<JoinHandle<Ended>>,
    arrays: Option<Arrays>,
    awaits: bool,
}

#[pymethods]
impl Session {
    /// Begins a mission.
    #[new]
    fn new(resolved: &Bound<'_, Resolved>, seed: u64) -> PyResult<Self> {
        guarded(|| {
            let world = resolved.get().0.clone();
            let brief = Brief { run: RUN, ..world.brief.clone() };
            if Task::of(&brief) != Task::Cover {
                return Err(no_environment(brief.scenario, Need::Rovers));
            }
            let mission = Mission { brief: brief.clone(), ..Mission::of(&world, seed) };
            let (questions, inbox) = channel();
            let (outbox, answers) = channel();
            let name: Name = "session".parse().map_err(crate::error)?;
            let asker = Asker { name, questions, answers, watch: Watch::default() };
            let flight =
                std::thread::Builder::new().name("mission".into()).spawn(move || fly(mission, asker))?;
            let turn =
                Turn { ports: Some((inbox, outbox)), flight: Some(flight), arrays: None, awaits: false };
            Ok(Self { world, brief, seed, pid: std::process::id(), turn: Mutex::new(turn) })
        })
    }

    /// The decision that is due; None once the mission is over.
    fn next(&self, py: Python<'_>) -> PyResult<Option<(view::Brief, Map, view::State)>> {
        guarded(|| {
            let mut turn = self.turn()?;
            if turn.awaits {
                return Err(crate::error("a mission needs the action that is due first: call act()"));
            }
            let Some((inbox, outbox)) = turn.ports.take() else { return Ok(None) };
            let (inbox, question) = py.detach(move || {
                let question = inbox.recv();
                (inbox, question)
            });
            let Ok(Question { brief, news, state, team }) = question else { return Ok(None) };
            turn.ports = Some((inbox, outbox));
            turn.awaits = true;
            let map = Arrays::update(&mut turn.arrays, py, &news)?;
            Ok(Some((brief, map, view::State { state, team })))
        })
    }

    /// Takes the action for the decision that is due.
    fn act(&self, action: u32) -> PyResult<()> {
        guarded(|| {
            let mut turn = self.turn()?;
            let Some(action @ (Action::Hold | Action::Step(_))) = Action::from_code(action) else {
                return Err(crate::error(format!("an action needs to be a hold or a step, got {action}")));
            };
            if !turn.awaits {
                return Err(crate::error("a mission needs to await an action: call next() first"));
            }
            if let Some((_, outbox)) = &turn.ports {
                outbox.send(action).map_err(crate::error)?;
            }
            turn.awaits = false;
            Ok(())
        })
    }

    /// What `hopper.run` returns, once the mission is over.
    fn ended<'py>(&self, py: Python<'py>) -> PyResult<Answer<'py>> {
        guarded(|| {
            let mut turn = self.turn()?;
            if turn.ports.is_some() {
                return Err(crate::error("a mission needs to be over"));
            }
            let flight = turn.flight.take().ok_or_else(|| crate::error("a mission ends once"))?;
            let ended = py.detach(move || flight.join());
            let ended = ended.map_err(|_| crate::error("the mission was dropped"))?;
            let (flown, records) = ended.map_err(|error| refused(&self.brief, &error))?;
            told(py, &self.world, &self.brief, self.seed, flown, records)
        })
    }
}

impl Session {
    fn turn(&self) -> PyResult<MutexGuard<'_, Turn>> {
        if self.pid != std::process::id() {
            let pid = self.pid;
            return Err(crate::error(format!(
                "a mission needs the process that began it, {pid}, got a fork of it, which has no threads: call reset() first"
            )));
        }
        match self.turn.try_lock() {
            Ok(turn) => Ok(turn),
            Err(TryLockError::Poisoned(poisoned)) => Ok(PoisonError::into_inner(poisoned)),
            Err(TryLockError::WouldBlock) => {
                Err(crate::error("a mission needs one thread at a time, got another while it is in use"))
            }
        }
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        if self.pid != std::process::id() {
            // The thread is the parent's.
            let turn = self.turn.get_mut().unwrap_or_else(PoisonError::into_inner);
            std::mem::forget((turn.ports.take(), turn.flight.take()));
        }
    }
}

fn fly(mission: Mission, asker: Asker) -> Ended {
    let schedule = PlannerSchedule::single(asker.name);
    let mut asker = Some(asker);
    let mut make = |name: Name, _: &Mission| -> Result<Box<dyn Planner>, PlannerError> {
        let asker = asker
            .take()
            .ok_or(PlannerError::UnknownAlgorithm { got: name.to_string(), hint: String::new() })?;
        Ok(Box::new(asker))
    };
    let mut records = Vec::new();
    let flown = lockstep::fly_with(mission, &schedule, &mut make, &mut node::Node::now, &mut |record| {
        records.push(*record);
    })?;
    Ok((flown, records))
}
